//! The checker accepts hand-made valid plans, rejects corrupted ones for the right reason, and agrees with dense sampling.

mod delays;
mod fixture;
mod mutations;
#[path = "../../src/random.rs"]
mod numbers;
mod random;
mod robots;
mod sampling;
mod scenarios;
mod shipped;
mod valid;
