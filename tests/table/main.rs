//! Tables from users: read, damaged, predicted and fitted.

mod causes;
mod columns;
mod evaluation;
mod hidden;
mod hostile;
mod reach;
mod reading;
mod synthetic;
mod unrelated;
