//! The laboratory: data that are whitened, evaluation that stays unseen, hidden effects that come out, and the verbs that take
//! it step by step.

mod campaigns;
mod orders;
mod steps;
mod unknown;
mod compared;
mod hostile;
mod structure;
mod two_passes;
mod unseen;
mod whitening;
