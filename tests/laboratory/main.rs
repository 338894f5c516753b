//! The laboratory: data that are whitened, evaluation that stays unseen, hidden effects that come out.

mod campaigns;
mod compared;
mod hostile;
mod structure;
mod two_passes;
mod unseen;
mod whitening;
