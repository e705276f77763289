//! What is to be done with each pair of a robot's links.

use collision::{Geometry, GeometryError};
use model::{LinkId, Robot, RobotId, Settings};

use super::srdf_text::Reason;
use super::survey::{Survey, lone};

/// The pairs, sorted by what is to be done with them.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    /// Not worth testing, and why.
    pub not_tested: Vec<((LinkId, LinkId), Reason)>,
    /// To be tested: they touch in some configurations, or it is not proven that they cannot.
    pub tested: Vec<(LinkId, LinkId)>,
    /// Disabled in the SRDF though they touch in some.
    pub doubtful: Vec<(LinkId, LinkId)>,
}

impl Pairs {
    /// Sorts the pairs of a survey. `at_home` are those that touch in the configuration `home`, `disabled` those that the
    /// SRDF says not to test.
    #[must_use]
    pub fn of(survey: &Survey, at_home: &[(LinkId, LinkId)], disabled: &[(LinkId, LinkId)]) -> Self {
        let mut pairs = Self::default();
        pairs.not_tested.extend(survey.adjacent.iter().map(|links| (*links, Reason::Adjacent)));
        for count in &survey.pairs {
            let reason = match count {
                _ if count.is_always() => Some(Reason::Always),
                _ if at_home.contains(&count.links) => Some(Reason::Default),
                _ if count.never => Some(Reason::Never),
                _ => None,
            };
            match reason {
                Some(reason) => pairs.not_tested.push((count.links, reason)),
                None => pairs.tested.push(count.links),
            }
            if reason.is_none() && count.touching > 0.0 && disabled.contains(&count.links) {
                pairs.doubtful.push(count.links);
            }
        }
        pairs.not_tested.sort_by_key(|(links, reason)| (*reason, *links));
        pairs
    }
}

/// Pairs of links that touch at `home`, but for those of the survey that always do.
///
/// # Errors
/// When a shape is degenerate.
pub fn touching_at_home(robot: &Robot, survey: &Survey) -> Result<Vec<(LinkId, LinkId)>, GeometryError> {
    let geometry = Geometry::new(&lone(robot, survey.hopeless(), Settings::default().clearance))?;
    let q = [vec![0.0; robot.base_len()], robot.home.clone()].concat();
    Ok(geometry.own_contacts(RobotId(0), &q))
}
