//! Mode commitment and assembly on toy worlds with analytic oracles.

mod assembly;
mod commitment;
mod delays;
mod drrt;
mod oracle;
mod orders;
mod relation;
mod requests;
mod tails;
mod toys;
