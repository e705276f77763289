//! Where a problem's parts stand in its file, for what turns out to be wrong with them once it is loaded.

use crate::problem_error::{FindingKind, Findings, Source, Span};
use crate::{FixedId, ObjectId, ProblemError, RobotId};

/// A part of a problem that stands somewhere at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A robot; its place in the file is its start, else its pose, else its name.
    Robot(RobotId),
    /// A fixed object; its place in the file is its pose, else its name.
    Fixed(FixedId),
    /// A movable object; its place in the file is its pose.
    Movable(ObjectId),
}

/// Two parts that cannot both stand where the file puts them.
#[derive(Clone, Debug)]
pub struct Misplaced {
    /// The part at whose place it is told.
    pub part: Part,
    /// The other part; may be the same one.
    pub other: Part,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

/// Places of a problem's parts in its file.
#[derive(Clone, Debug)]
pub struct Places {
    pub(crate) source: Source,
    pub(crate) robots: Vec<Span>,
    pub(crate) fixed: Vec<Span>,
    pub(crate) movable: Vec<Span>,
}

impl Places {
    fn of(&self, part: Part) -> Span {
        let span = match part {
            Part::Robot(robot) => self.robots.get(robot.index()),
            Part::Fixed(fixed) => self.fixed.get(fixed.index()),
            Part::Movable(object) => self.movable.get(object.index()),
        };
        span.copied().unwrap_or(Span { offset: 0, len: 0 })
    }

    /// Refuses a problem because of where its parts stand.
    ///
    /// # Errors
    /// A finding for each of `misplaced`, with its line; none if there are none.
    pub fn refuse(&self, misplaced: &[Misplaced]) -> Result<(), ProblemError> {
        let mut findings = Findings::default();
        for Misplaced { part, other, message, help } in misplaced {
            let finding = self.source.finding(self.of(*part), FindingKind::StartCollision, message).help(help);
            let (here, there) = (self.of(*part), self.of(*other));
            let finding = if here == there { finding } else { finding.note(&self.source, there, "the other") };
            findings.keep::<()>(Err(finding));
        }
        findings.end()
    }
}
