//! The laboratory: data that are whitened, evaluation that stays unseen, hidden effects that come out.

mod campaigns;
mod unknown;
mod unseen;
mod whitening;
