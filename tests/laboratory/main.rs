//! The laboratory: whitening of data, held-out passes that stay unseen, hidden effects that are found, and the verbs
//! that run it step by step.

mod attempts;
mod blurred;
mod campaigns;
mod coated;
mod compared;
mod frames;
mod hostile;
mod look;
mod orders;
mod pair;
#[path = "../common/shared_folder.rs"]
mod shared_folder;
mod steps;
mod structure;
mod taken_back;
mod two_passes;
mod unknown;
mod unseen;
mod valleys;
mod whitening;
