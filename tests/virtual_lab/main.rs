//! The virtual laboratory: what it measures can be read, has the noise that was put in, and comes out again under the true
//! model; what it hides stays hidden.

mod front_ends;
mod made;
mod measured;
mod outside;
mod sealed;
