//! First step of the paper (Sec. III-B): where objects stand after each hop, and the orders that this needs.
//!
//! No robot takes part: objects are moved as if by teleportation. Every pose that an object takes is a *site*, its samples
//! are the values, and two sites that may be taken at the same time must not collide, unless an order is added by which
//! one object leaves before the other comes.
//!
//! # Canonical order
//!
//! Candidates come by (number of orders added, effort, samples, orders). The effort of sample `i` is the bit length of `i`,
//! that of a candidate the sum over its hops; equal ones come lexicographically, samples by object and hop, then orders by
//! their events. Every combination of samples with every irredundant way to order its collisions comes exactly once. So
//! the problem in which all objects are present is tried first, hops and regions are treated alike, and a nogood only
//! takes candidates out of the sequence.

mod bits;
mod enumeration;
mod footprint;
mod layer;
mod layout;
mod network;
mod nogoods;
#[cfg(test)]
mod oracle_tests;
mod ordered;
mod outline;
mod proof;
mod refute;
mod report;
mod samples;
mod sampling;
mod slots;
mod stage;
mod world;

pub use stage::PlacementStage;
