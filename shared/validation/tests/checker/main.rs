//! The checker accepts hand-made valid plans, rejects corrupted ones for the right reason, and agrees with dense sampling.

#![allow(clippy::panic, reason = "a test fails by panicking")]

mod certificates;
mod delays;
mod fixture;
mod mutations;
#[path = "../../src/random.rs"]
mod numbers;
mod random;
mod redundancy;
mod robots;
mod sampling;
mod scenarios;
mod shipped;
mod valid;
