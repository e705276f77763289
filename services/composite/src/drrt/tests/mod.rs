//! Tests on toy problems, against an exhaustive oracle and an independent replay.

mod brute;
mod large;
mod points;
mod prefixes;
mod random;
mod repairs;
mod scenes;
mod stepper;
mod toy;
