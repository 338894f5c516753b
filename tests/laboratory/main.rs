//! The laboratory: data that are whitened, evaluation that stays unseen, hidden effects that come out.

mod campaigns;
mod unseen;
mod whitening;
