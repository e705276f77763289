//! Why a plan is as it is: orderings and their causes, what was given up on the way, who waits for whom, how far the
//! makespan is from its bound.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use contract::{Decision, Ledger, LedgerEntry};
use model::Problem;
use plan::{ModeKind, Origin, Plan, RobotTrajectory, Segment, SegmentKind};

use crate::words;

/// Waits that are listed.
const LISTED: usize = 6;
/// Shorter waits are not worth a line (s).
const SHORT_S: f64 = 0.05;

/// Why a plan is as it is; `ledger` is that of its search, if it is known.
#[must_use]
pub fn plan_text(problem: &Problem, plan: &Plan, ledger: Option<&Ledger>) -> String {
    let mut text = section("Orderings that the geometry forces", discovered(plan));
    if let Some(ledger) = ledger {
        text += &section("Given up on the way", given_up(problem, ledger));
    }
    text += &section("Longest waits for others", waits(plan));
    text + &section("Makespan", vec![gap(plan)])
}

fn section(heading: &str, lines: Vec<String>) -> String {
    let mut text = format!("{heading}\n");
    if lines.is_empty() {
        text += "  none\n";
    }
    for line in lines {
        // Writing to text cannot fail.
        let _ = writeln!(text, "  {line}");
    }
    text
}

fn discovered(plan: &Plan) -> Vec<String> {
    let discovered = plan.orderings.iter().filter(|ordering| ordering.origin == Origin::Discovered);
    discovered.map(words::ordering).collect()
}

/// What was given up, one line for each kind of decision and cause, most often first.
fn given_up(problem: &Problem, ledger: &Ledger) -> Vec<String> {
    let mut counts: BTreeMap<(String, String), u64> = BTreeMap::new();
    for entry in &ledger.entries {
        let LedgerEntry::Backtrack { decision, because, .. } = entry else { continue };
        let what = match decision {
            Decision::Placement(_) => "placement candidate".to_owned(),
            Decision::Alternative { pair, .. } => format!("way to do {}", problem.pair(*pair).name),
            Decision::Hop { pair, .. } => format!("place for {}", problem.pair(*pair).name),
            Decision::Order(order) => format!("ordering {}", words::order(problem, order)),
            Decision::Drrt => "composite search".to_owned(),
            Decision::Synchronous(_) => "synchronous schedule".to_owned(),
            Decision::Level(_)
            | Decision::Commit(_)
            | Decision::Repair(_)
            | Decision::Round(_)
            | Decision::More { .. } => words::decision(problem, decision),
        };
        let why = because.as_ref().map_or("no cause was named".to_owned(), words::cause);
        *counts.entry((what, why)).or_insert(0) += 1;
    }
    let mut counts: Vec<((String, String), u64)> = counts.into_iter().collect();
    counts.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    counts.into_iter().map(|((what, why), times)| format!("{times} × {what}: {why}")).collect()
}

/// A stretch in which a robot stands until another one has gone on.
struct Wait {
    seconds: f64,
    words: String,
}

fn waits(plan: &Plan) -> Vec<String> {
    let mut waits: Vec<Wait> = plan.robots.iter().flat_map(|robot| waits_of(plan, robot)).collect();
    waits.sort_by(|a, b| b.seconds.total_cmp(&a.seconds).then_with(|| a.words.cmp(&b.words)));
    let more = waits.len().saturating_sub(LISTED);
    let mut lines: Vec<String> = waits.into_iter().take(LISTED).map(|wait| wait.words).collect();
    if more > 0 {
        lines.push(format!("and {more} more"));
    }
    lines
}

/// Waits that end with a dependency arc; a robot also stands while its gripper closes or opens.
fn waits_of(plan: &Plan, robot: &RobotTrajectory) -> Vec<Wait> {
    let standing = robot.segments.iter().filter(|segment| segment.kind == SegmentKind::Wait);
    let waits = standing.filter_map(|segment| {
        let arcs = plan
            .dependencies
            .iter()
            .filter(|arc| arc.after.robot == robot.name && (segment.from + 1..=segment.to).contains(&arc.after.knot));
        // The arc that is fulfilled last is what the robot stands for.
        let reached = |arc: &plan::Dependency| {
            let other = plan.robots.iter().find(|other| other.name == arc.before.robot)?;
            Some((other.knots.get(arc.before.knot)?.t, other, arc.before.knot))
        };
        let (_, other, knot) = arcs.filter_map(reached).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (begins, ends) = (robot.knots.get(segment.from)?.t, robot.knots.get(segment.to)?.t);
        let own = part(segment);
        let words = format!(
            "{} waits {:.2} s at {begins:.2} s in {own} for {}, then in {}",
            robot.name,
            ends - begins,
            other.name,
            doing(other, knot)
        );
        Some(Wait { seconds: ends - begins, words })
    });
    waits.filter(|wait| wait.seconds >= SHORT_S).collect()
}

/// The mode that a segment is part of, such as `r1.2 transfer`.
fn part(segment: &Segment) -> String {
    let mode = match segment.mode {
        ModeKind::Transit => "transit",
        ModeKind::Transfer => "transfer",
        ModeKind::Return => "return",
    };
    segment.pair.as_ref().map_or_else(|| mode.to_owned(), |pair| format!("{pair} {mode}"))
}

/// What a robot is doing as it comes to a knot.
fn doing(robot: &RobotTrajectory, knot: usize) -> String {
    let segment = robot.segments.iter().find(|segment| segment.from < knot && knot <= segment.to);
    let Some(segment) = segment.or(robot.segments.first()) else { return "nothing".to_owned() };
    let kind = match segment.kind {
        SegmentKind::Base => "drive",
        SegmentKind::Reach => "reach",
        SegmentKind::Retract => "retract",
        SegmentKind::Wait => "stop",
    };
    format!("{} ({kind})", part(segment))
}

fn gap(plan: &Plan) -> String {
    let (task_s, bound_s) = (plan.makespan.task_s, plan.lower_bound.seconds);
    let above =
        if bound_s > 0.0 { format!("{:.1} % above", 100.0 * (task_s - bound_s) / bound_s) } else { "over".to_owned() };
    format!("{task_s:.2} s, {above} the lower bound of {bound_s:.2} s ({})", plan.lower_bound.kind)
}
