//! The report in words.

use std::collections::BTreeMap;

use super::{PairReport, Reason, RobotReport};

/// The report as it is printed.
#[must_use]
pub fn text(report: &RobotReport) -> String {
    let mut text =
        format!("{}: {} links, {} planned coordinates\n", report.name, report.links.len(), report.coordinates.len());
    text += "\nlinks, each with the joint that moves it\n";
    text += &links(report);
    text += "\ncoordinates (rad or m)            least   greatest      speed       home\n";
    text += &coordinates(report);
    text += &end_effector(report);
    text += &reach(report);
    text += &pairs(report);
    text
}

fn links(report: &RobotReport) -> String {
    let line = |link: &super::LinkReport| {
        let indent = "  ".repeat(link.depth + 1);
        let by = link.joint.as_ref().map_or(String::new(), |joint| format!("  ({joint}: {})", link.motion));
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        link.bodies.iter().for_each(|kind| *kinds.entry(kind).or_default() += 1);
        let bodies: Vec<String> = kinds
            .iter()
            .map(|(kind, count)| if *count == 1 { (*kind).to_owned() } else { format!("{count} × {kind}") })
            .collect();
        let bodies = if bodies.is_empty() { String::new() } else { format!("  [{}]", bodies.join(", ")) };
        format!("{indent}{}{by}{bodies}\n", link.name)
    };
    report.links.iter().map(line).collect()
}

fn coordinates(report: &RobotReport) -> String {
    let home: BTreeMap<&str, f64> = report.home.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    let line = |c: &super::CoordinateReport| {
        let limit = |x: f64| if x.is_finite() { format!("{x:.3}") } else { "none".to_owned() };
        let home = home.get(c.name.as_str()).map_or(String::new(), |x| format!("{x:.3}"));
        format!("  {:<26} {:>10} {:>10} {:>10.3} {home:>10}\n", c.name, limit(c.lower), limit(c.upper), c.velocity)
    };
    report.coordinates.iter().map(line).collect()
}

fn end_effector(report: &RobotReport) -> String {
    let hand = &report.end_effector;
    let opening = if hand.max_opening > 0.0 {
        format!("sliding fingers open {:.4} m", hand.max_opening)
    } else {
        "no sliding fingers: a problem must give `max_opening`, the greatest width of an object that it takes"
            .to_owned()
    };
    let tool = match &hand.tool {
        Some(tool) => {
            format!("`tool: {tool}` in a problem, if its z axis is the approach and its y axis the closing direction")
        }
        None => "no link looks like one: the parent link's frame is taken".to_owned(),
    };
    format!(
        "\nend effector `{}`\n  grasps in    {}\n  may touch    {}\n  opening      {opening}\n  tool frame   {tool}\n",
        hand.name,
        hand.parent_link,
        hand.touch_links.join(", ")
    )
}

fn reach(report: &RobotReport) -> String {
    let [x, y, z] = report.reach.shoulder;
    let range = |[least, greatest]: [f64; 2]| format!("{least:.3} to {greatest:.3} m");
    format!(
        "\nreach of {} from the shoulder at ({x:.3}, {y:.3}, {z:.3})\n  bounds       {}, from lengths and limits\n  \
         sampled      {}, at heights from {}\n",
        report.end_effector.parent_link,
        range(report.reach.bounds),
        range(report.reach.sampled),
        range(report.reach.height)
    )
}

fn pairs(report: &RobotReport) -> String {
    let mut text = format!("\npairs of links in {} random configurations\n", report.samples);
    for (reason, meaning) in [
        (Reason::Adjacent, "joined, never tested"),
        (Reason::Always, "touch in at least 95 %: should be disabled, or nothing can be planned"),
        (Reason::Default, "touch at `home`: should be disabled, or `home` changed"),
        (Reason::Never, "proven to touch in no configuration: need not be tested"),
    ] {
        let of_reason: Vec<&PairReport> = report.not_tested.iter().filter(|pair| pair.reason == Some(reason)).collect();
        if !of_reason.is_empty() {
            text += &format!("  {reason:?} ({}): {meaning}\n{}", of_reason.len(), listed(&of_reason));
        }
    }
    if !report.tested.is_empty() {
        let tested: Vec<&PairReport> = report.tested.iter().collect();
        text += &format!("  Tested ({}): touch in this share\n{}", tested.len(), listed(&tested));
    }
    if !report.doubtful.is_empty() {
        let doubtful: Vec<&PairReport> = report.doubtful.iter().collect();
        text += &format!(
            "  Doubtful ({}): the SRDF says not to test them, though they touch in some\n{}",
            doubtful.len(),
            listed(&doubtful)
        );
    }
    text
}

fn listed(pairs: &[&PairReport]) -> String {
    let line = |pair: &&PairReport| {
        let share = if pair.reason.is_some() { String::new() } else { format!("{:>9.2} %", 100.0 * pair.touching) };
        format!("    {:<24} {:<24}{share}\n", pair.link1, pair.link2).trim_end().to_owned() + "\n"
    };
    pairs.iter().map(line).collect()
}
