//! Tests of the bus: one conformance suite for all transports, runs of a toy set over them, garbage, golden bytes.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../toy/mod.rs"]
mod toy;

mod conformance;
mod dispatching;
mod golden;
mod runs;
mod set;
mod watchdog;
