//! Mode commitment and assembly on toy worlds with analytic oracles.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod assembly;
mod commitment;
mod delays;
mod drrt;
mod oracle;
mod orders;
mod passages;
mod relation;
mod repairs;
mod requests;
mod rounds;
mod tails;
mod toys;
