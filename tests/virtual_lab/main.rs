//! The virtual laboratory: its measurements can be read, have the specified noise, and are reproduced by the true
//! model; its hidden effects stay hidden.

mod front_ends;
mod made;
mod measured;
mod outside;
mod sealed;
