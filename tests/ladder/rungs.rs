//! The table: scene, planted answer, seeds.

use crate::facts::{self, Fact};

/// How a run must end.
pub enum Expected {
    /// With a plan.
    Solved {
        /// Discovered orderings.
        orders: Orders,
        /// The makespan is at most so many times the plan's lower bound.
        within: f64,
        /// What else must be so.
        fact: Option<Fact>,
    },
    /// Samples exhausted, for this reason: no certificate can prove it.
    Exhausted(Reason),
    /// Proven infeasible by a certificate of this kind, which the checker verifies.
    Proven(Proof),
}

/// Which orderings are discovered.
pub enum Orders {
    Exactly(&'static [&'static str]),
    AtMost(usize),
}

/// A cause that must be among those told.
pub enum Reason {
    /// This object stands in the way of a pair.
    BlockedBy(&'static str),
    /// These robots block one another.
    Deadlock(&'static [&'static str]),
}

/// What a certificate must say.
pub enum Proof {
    /// Orderings contradict one another in this region.
    Cycle(&'static str),
    /// These objects are together larger than their region.
    Area(&'static [&'static str]),
    /// No grasp serves both ends of this pair.
    NoCommonGrasp(&'static str),
    /// This region is out of reach.
    Reach(&'static str),
    /// The base cannot drive to where this region is within reach.
    BaseDisconnected(&'static str),
}

/// The last stage that may be asked for anything: who fails early starts nothing later.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Last {
    Placement,
    Transition,
    Roadmap,
    Composite,
}

/// One rung.
pub struct Rung {
    pub scene: &'static str,
    pub expected: Expected,
    pub last: Last,
    /// Seeds 0 to this one.
    pub seeds: u64,
    /// Whether dRRT* alone must do it, too.
    pub drrt: bool,
}

const fn solved(scene: &'static str, orders: Orders, within: f64, fact: Option<Fact>) -> Rung {
    Rung { scene, expected: Expected::Solved { orders, within, fact }, last: Last::Composite, seeds: 2, drrt: true }
}

const fn failed(scene: &'static str, expected: Expected, last: Last) -> Rung {
    Rung { scene, expected, last, seeds: 1, drrt: false }
}

use Expected::{Exhausted, Proven};
use Orders::{AtMost, Exactly};

const NONE: Orders = Exactly(&[]);

/// All rungs, with bounds on makespans that have room over what was measured with five seeds.
pub static RUNGS: &[Rung] = &[
    solved("t00_one_arm", NONE, 1.01, None),
    solved("t01_one_robot", NONE, 1.15, None),
    solved("t02_far_apart", NONE, 1.05, None),
    solved("t03_relay", NONE, 1.4, None),
    Rung { seeds: 1, drrt: false, ..solved("t04_spacious_region", NONE, 1.5, None) },
    solved("t05_tiny_region", Exactly(&["grasp r2.1 < release r1.1"]), 1.4, None),
    failed("t06_contradiction", Proven(Proof::Cycle("tiny")), Last::Placement),
    failed("t07_three_in_two", Proven(Proof::Area(&["a", "b", "c"])), Last::Placement),
    solved("t08_off_diagonal", NONE, 1.2, Some(facts::one_off_and_one_in_the_middle)),
    solved("t09_swap", Exactly(&["grasp r1.1 < release r2.1", "grasp r2.1 < release r1.1"]), 1.5, None),
    solved("t10_swap_with_buffer", NONE, 1.05, None),
    failed("t11_swap_without_buffer", Proven(Proof::Cycle("b")), Last::Placement),
    solved("t12_deep_cabinet", Exactly(&["done r1.1 < release r2.1"]), 1.5, None),
    solved("t13_occluded", Exactly(&["grasp r2.1 < at_pick r1.1"]), 1.6, None),
    failed("t14_blocked_for_ever", Exhausted(Reason::BlockedBy("m2")), Last::Transition),
    failed("t15_no_common_grasp", Proven(Proof::NoCommonGrasp("r1.1")), Last::Transition),
    solved("t15b_regrasp", NONE, 1.05, Some(facts::regrasped)),
    failed("t16_out_of_reach", Proven(Proof::Reach("far_back")), Last::Transition),
    failed("t17_walled_in", Proven(Proof::BaseDisconnected("inside")), Last::Roadmap),
    solved("t18_parked_in_the_door", Exactly(&["grasp r2.2 < at_pick r1.2"]), 1.3, Some(facts::waits_for_the_crate)),
    solved("t19_passing_bay", NONE, 1.6, Some(facts::the_bay_is_used)),
    failed("t19b_no_bay", Exhausted(Reason::Deadlock(&["r1", "r2"])), Last::Composite),
    solved("t20_dead_end", NONE, 1.8, Some(facts::comes_out_before_the_other_goes_in)),
    solved("t21_third_region", NONE, 1.2, Some(facts::the_near_door_is_passed_only_without_the_crate)),
    solved("t22_both_jambs", AtMost(1), 1.6, None),
    solved("t23_mixed_team", NONE, 1.6, None),
    Rung { seeds: 1, drrt: false, ..solved("t24_four_arms", AtMost(12), 2.0, None) },
    solved("t25_stays_after_its_last", NONE, 1.4, Some(facts::stays_for_good)),
    solved("t26_home_in_the_door", NONE, 1.4, Some(facts::makes_room_and_comes_home)),
    Rung { seeds: 1, drrt: false, ..solved("figure1_wide", NONE, 1.3, None) },
];
