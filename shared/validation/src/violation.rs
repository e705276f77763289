//! What the checker finds: rules, violations, and the verdict on an accepted plan.

/// The rules that plans and failures must keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// Form of the trajectories: names, sizes, finite numbers, strictly increasing times, segments without gaps.
    V1,
    /// Robots and objects start where the problem says (1e-9).
    V2,
    /// Joint limits and base workspace (1e-9).
    V3,
    /// Speed limits (relative 1e-9).
    V4,
    /// Attach and detach alternate, in the order of each robot's pairs and of each object's hops.
    V5,
    /// At an attach the hand holds the object by a listed grasp (1 mm, 0.2°) and rests for the grip time.
    V6,
    /// After a detach the object stands: upright, inside its region, at its height, unmoved until the next attach.
    V7,
    /// An object is in one hand at a time.
    V8,
    /// Orderings between points, strict by at least 1 ns.
    V9,
    /// What orderings mean where the problem's settings ask for more: with `gate: action` an action is completed before the
    /// later robot comes to its stand, strictly by at least 1 ns; with `removal: completed` nothing is placed where an object
    /// stood that is still being carried away.
    V10,
    /// No two bodies meet at any instant, between knots included.
    V11,
    /// Contact only where it is allowed: hand and object about a grasp or release, object and support about a pick or place.
    V12,
    /// Every pair is executed once and every robot ends as its end policy says.
    V13,
    /// Reported makespans are those of the trajectories (1e-9), and no bound exceeds them.
    V14,
    /// No discovered ordering is redundant: none follows from the others, and what it names as its cause is so.
    V15,
    /// A failure that is called proven carries a certificate that holds.
    V16,
    /// Dependency arcs: valid, kept by the plan's own times, free of cycles.
    V17,
}

impl Rule {
    /// All rules in order.
    pub const ALL: [Rule; 17] = [
        Rule::V1,
        Rule::V2,
        Rule::V3,
        Rule::V4,
        Rule::V5,
        Rule::V6,
        Rule::V7,
        Rule::V8,
        Rule::V9,
        Rule::V10,
        Rule::V11,
        Rule::V12,
        Rule::V13,
        Rule::V14,
        Rule::V15,
        Rule::V16,
        Rule::V17,
    ];

    /// Number and subject, for messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        [
            "V1 form of the trajectories",
            "V2 start state",
            "V3 joint limits and workspace",
            "V4 speed limits",
            "V5 sequence of events",
            "V6 grasp",
            "V7 placement",
            "V8 exclusive holding",
            "V9 orderings",
            "V10 gates and removals",
            "V11 continuous collision",
            "V12 allowed contacts",
            "V13 goal and end policy",
            "V14 makespan",
            "V15 orderings without need",
            "V16 certificate of infeasibility",
            "V17 dependency arcs",
        ][self as usize]
    }
}

/// One broken rule, naming who broke it. Names are those of the problem.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{}: {message}", .rule.name(), .t.map(|t| format!(" at {t:.4} s")).unwrap_or_default())]
pub struct Violation {
    /// The rule.
    pub rule: Rule,
    /// Robots concerned.
    pub robots: Vec<String>,
    /// Movable and fixed objects concerned.
    pub objects: Vec<String>,
    /// When (s), if at a time.
    pub t: Option<f64>,
    /// What is wrong, in words and numbers.
    pub message: String,
}

impl Violation {
    pub(crate) fn new(rule: Rule, message: impl Into<String>) -> Self {
        Self { rule, robots: Vec::new(), objects: Vec::new(), t: None, message: message.into() }
    }

    pub(crate) fn robot(mut self, name: &str) -> Self {
        if !self.robots.iter().any(|known| known == name) {
            self.robots.push(name.to_owned());
        }
        self
    }

    pub(crate) fn object(mut self, name: &str) -> Self {
        if !self.objects.iter().any(|known| known == name) {
            self.objects.push(name.to_owned());
        }
        self
    }

    pub(crate) fn at(mut self, t: f64) -> Self {
        self.t = Some(t);
        self
    }
}

/// What was done to accept a plan.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Verdict {
    /// Stretches of time looked at, over all pairs of robots, each robot and itself, each robot and what stands.
    pub intervals: u64,
    /// Body pairs tested on a stretch of time.
    pub pairs_tested: u64,
    /// Exact distances computed.
    pub distances: u64,
    /// Body pairs that came closer than the resolution floor; an accepted plan has none.
    pub floor_hits: u64,
    /// Least distances met.
    pub least_clearance: LeastClearance,
}

/// Least exact distance (m) among those that had to be computed, per kind of pair: never below the true least clearance.
/// `None`: no pair of the kind came close enough to need one.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct LeastClearance {
    /// Between robots, held objects included.
    pub robot_robot: Option<f64>,
    /// Between a robot and fixed objects.
    pub robot_fixed: Option<f64>,
    /// Between a robot and standing objects, outside allowed contacts.
    pub robot_object: Option<f64>,
    /// Between bodies of one robot.
    pub own: Option<f64>,
}
