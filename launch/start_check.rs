//! Nothing may be planned from a start in collision: it is told at its place in the problem file.

use collision::{BodyName, Geometry, StartContact};
use miette::Report;
use model::{Misplaced, Part, Places, Problem};

use crate::exit::BadInput;

/// Depths below this (m) are shown as none.
const SHOWN: f64 = 5e-5;

/// Refuses a problem of which bodies overlap at the start, or links are nearer to something than the clearance.
///
/// # Errors
/// Bad input: both bodies' names, the depth in mm, the place in the file and what to do.
pub fn refuse_collisions(problem: &Problem, places: &Places) -> miette::Result<()> {
    let geometry = Geometry::new(problem).map_err(|error| Report::new(BadInput::new(error.to_string())))?;
    let contacts = geometry.start_contacts();
    let told: Vec<Misplaced> = contacts
        .iter()
        .filter(|contact| is_deepest(contact, &contacts))
        .map(|contact| misplaced(problem, contact))
        .collect();
    places.refuse(&told).map_err(Report::new)
}

/// Whether no other contact of the same two parts is deeper. Each pair of a robot's own links counts: each has its remedy.
fn is_deepest(contact: &StartContact, all: &[StartContact]) -> bool {
    let parts = |contact: &StartContact| (part(contact.contact.first), part(contact.contact.second));
    let (first, second) = parts(contact);
    first == second || all.iter().all(|other| parts(other) != (first, second) || other.depth <= contact.depth)
}

fn misplaced(problem: &Problem, StartContact { contact, depth }: &StartContact) -> Misplaced {
    let (names, clearance_mm) = (contact.describe(problem), problem.settings.clearance * 1e3);
    let message = if depth.abs() < SHOWN {
        format!("at the start {names} touch")
    } else if *depth > 0.0 {
        format!("at the start {names} overlap by {:.1} mm", depth * 1e3)
    } else {
        format!(
            "at the start {names} are only {:.1} mm apart, less than the clearance of {clearance_mm} mm",
            -depth * 1e3
        )
    };
    let help = match (contact.first, contact.second) {
        (BodyName::Link { robot, link: first }, BodyName::Link { robot: other, link: second }) if robot == other => {
            let name = |link: model::LinkId| &problem.robot(robot).links[link.index()].name;
            format!(
                "give other joint values in `start`, or the group state `home`; if these links may touch, add \
                 `<disable_collisions link1=\"{}\" link2=\"{}\"/>` to the SRDF",
                name(first),
                name(second)
            )
        }
        (BodyName::Link { .. }, BodyName::Object(_)) => {
            "give the robot another `start`, or put the object elsewhere".to_owned()
        }
        (BodyName::Link { .. }, _) => format!(
            "give the robot another `start` or `pose`, or move the other: {clearance_mm} mm must be free (`clearance` in \
             `settings`)"
        ),
        _ => format!("move one of them by at least {:.1} mm", (depth * 1e3).max(0.1)),
    };
    Misplaced { part: part(contact.first), other: part(contact.second), message, help }
}

fn part(body: BodyName) -> Part {
    match body {
        BodyName::Link { robot, .. } | BodyName::Held { robot, .. } => Part::Robot(robot),
        BodyName::Fixed(fixed) => Part::Fixed(fixed),
        BodyName::Object(object) => Part::Movable(object),
    }
}
