//! Sets of real processes with toy stages: what they commit, and what happens when they are killed, stopped, fed with
//! garbage, or left alone.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../shared/bus/tests/toy/mod.rs"]
mod toy;

mod deaths;
mod endings;
mod fixtures;
mod leftovers;
mod set;
mod watchdog;
