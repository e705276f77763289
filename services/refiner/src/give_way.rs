//! What robots learn in dead ends: whom to give way to.

use std::collections::{BTreeMap, BTreeSet};

use model::RobotId;
use skeleton::{Mode, ModeId, ModeKind};

/// Which robots give way to a mode until it is committed: they park clear of it, and return home after it only. If that
/// is not enough, they wait for it with everything. An object that stands in a mode's way is put there after it only.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GiveWay {
    robots: BTreeMap<ModeId, BTreeMap<RobotId, Extent>>,
    /// Modes that wait with their releases, each for another mode.
    releases: BTreeSet<(ModeId, ModeId)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Extent {
    Parks,
    Waits,
}

impl GiveWay {
    /// Those in the way of a mode shall give way to it, or more than so far. Whether that is new.
    pub(crate) fn learn(&mut self, mode: ModeId, by: &[RobotId]) -> bool {
        let known = self.robots.entry(mode).or_default();
        let before = known.clone();
        for robot in by {
            known.entry(*robot).and_modify(|extent| *extent = Extent::Waits).or_insert(Extent::Parks);
        }
        *known != before
    }

    /// What has put objects in the way of a mode shall come after it. Whether that is new.
    pub(crate) fn learn_releases(&mut self, mode: ModeId, releases: &[ModeId]) -> bool {
        let before = self.releases.len();
        self.releases.extend(releases.iter().map(|release| (*release, mode)));
        self.releases.len() > before
    }

    /// Whether others give way to a mode.
    pub(crate) fn is_given(&self, mode: ModeId) -> bool {
        self.robots.contains_key(&mode)
    }

    /// Modes that a robot still has to give way to.
    pub(crate) fn ways_before<'a>(&'a self, robot: RobotId, next: &'a [usize]) -> impl Iterator<Item = ModeId> + 'a {
        let by_robot = self.robots.iter().filter(move |(mode, by)| is_open(mode, next) && by.contains_key(&robot));
        by_robot.map(|(mode, _)| *mode)
    }

    /// A mode that has to be committed before another, or has its robot give way.
    pub(crate) fn before(&self, mode: ModeId, next: &[usize]) -> Option<ModeId> {
        self.releases_before(mode, next).chain(self.ways_before(mode.robot, next)).next()
    }

    /// Whether a mode has to wait for another that its robot gives way to.
    pub(crate) fn holds_back(&self, mode: &Mode, next: &[usize]) -> bool {
        let for_robot = |before: ModeId| {
            let waits = self.robots[&before].get(&mode.id.robot) == Some(&Extent::Waits);
            mode.kind == ModeKind::Return || waits && mode.id.step > 0
        };
        self.releases_before(mode.id, next).next().is_some() || self.ways_before(mode.id.robot, next).any(for_robot)
    }

    fn releases_before<'a>(&'a self, mode: ModeId, next: &'a [usize]) -> impl Iterator<Item = ModeId> + 'a {
        let of_mode = self.releases.iter().filter(move |(release, before)| *release == mode && is_open(before, next));
        of_mode.map(|(_, before)| *before)
    }
}

fn is_open(mode: &ModeId, next: &[usize]) -> bool {
    next[mode.robot.index()] <= mode.step as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use skeleton::ModeKind::{Return, Transfer};

    fn id(robot: usize, step: u32) -> ModeId {
        ModeId { robot: RobotId::at(robot), step }
    }

    fn mode(robot: usize, step: u32, kind: ModeKind) -> Mode {
        Mode { id: id(robot, step), kind, pair: None, begins: None, ends: None }
    }

    #[test]
    fn a_robot_first_returns_later_and_then_waits_with_everything_but_its_first_mode() {
        let mut give_way = GiveWay::default();
        assert!(give_way.learn(id(0, 1), &[RobotId::at(1)]));
        assert!(
            give_way.holds_back(&mode(1, 2, Return), &[1, 2]) && !give_way.holds_back(&mode(1, 1, Transfer), &[1, 1])
        );
        assert!(give_way.learn(id(0, 1), &[RobotId::at(1)]) && !give_way.learn(id(0, 1), &[RobotId::at(1)]));
        assert!(
            give_way.holds_back(&mode(1, 1, Transfer), &[1, 1]) && !give_way.holds_back(&mode(1, 0, Transfer), &[1, 0])
        );
        assert!(!give_way.holds_back(&mode(1, 2, Return), &[2, 2]), "the mode is committed");
    }

    #[test]
    fn a_release_waits_for_the_mode_that_its_object_is_in_the_way_of_and_nothing_else_does() {
        let mut give_way = GiveWay::default();
        assert!(give_way.learn_releases(id(0, 2), &[id(1, 1)]) && !give_way.learn_releases(id(0, 2), &[id(1, 1)]));
        assert!(
            give_way.holds_back(&mode(1, 1, Transfer), &[2, 1]) && !give_way.holds_back(&mode(1, 3, Transfer), &[2, 3])
        );
        assert_eq!(give_way.before(id(1, 1), &[2, 1]), Some(id(0, 2)));
        assert!(!give_way.holds_back(&mode(1, 1, Transfer), &[3, 1]), "the mode is committed");
    }
}
