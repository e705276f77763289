//! First step of the paper (Sec. III-B): where objects stand after each hop, and the orders that this needs.
//!
//! No robot takes part: objects are moved as if by teleportation. Every pose that an object takes is a *site*, its samples
//! are the values, and two sites that may be taken at the same time must not collide, unless an order is added by which
//! one object leaves before the other comes.
//!
//! # Canonical order
//!
//! Candidates come by number of orders added: the problem in which all objects are present is tried first. Sets of orders
//! of one size are numbered as they are found and take turns, so that each gives ever more candidates. Under one set of
//! orders, candidates come by effort, then lexicographically by object and hop; the effort of sample `i` is the bit length
//! of `i`, that of a candidate the sum over its hops, so hops and regions are treated alike. Every combination of samples
//! with every irredundant way to order its collisions comes exactly once. Searches in this order are limited (`Patience`);
//! only where a limit is met may something come out of turn: a larger set of orders first, or any solution at hand.

mod bits;
mod contradiction;
mod crowds;
mod enumeration;
mod footprint;
mod guests;
mod hop;
mod layout;
mod network;
mod nogoods;
#[cfg(test)]
mod oracle_tests;
mod order_sets;
mod ordered;
mod outline;
mod proof;
mod report;
mod samples;
mod sampling;
mod sequence;
mod slots;
mod solutions;
mod solve;
mod stage;
mod verdict;
mod world;

pub use stage::PlacementStage;
