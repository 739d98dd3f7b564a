//! Finite elements of organs that hang: the product's elements ([`palpate_fit::reference`]) under
//! their weight, with several organs that are tied to each other and with some nodes held or
//! displaced. Paper 000 lifts such organs.

pub mod hang;
pub mod locate;
pub mod organs;
pub mod suspension;
pub mod tie;
