//! The laboratory: data that are whitened, evaluation that stays unseen, hidden effects that come out, and the verbs that take
//! it step by step.

mod attempts;
mod blurred;
mod campaigns;
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
mod two_passes;
mod unknown;
mod unseen;
mod valleys;
mod whitening;
