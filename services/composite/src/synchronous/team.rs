//! Where all robots and objects are, given how many units each robot has done.

use collision::Motion;
use contract::{Assignment, Interrupted, JobContext, ProductRef};
use model::{AllowedContacts, ObjectId, RobotId};
use skeleton::{Event, Mode, Occupancy};

use super::needs::Needs;
use crate::sipp::ModeGraph;
use crate::{Scene, TimedStanding, Travel};

/// A mode as a unit of rounds.
pub(super) struct TeamMode<'a> {
    pub mode: Mode,
    pub graph: ModeGraph<'a>,
    /// Least time from every vertex to the goal (s).
    pub to_goal_s: Vec<f64>,
    /// Pause of the hand after its event (s).
    pub pause_s: f64,
}

impl TeamMode<'_> {
    /// Least time of the unit (s).
    pub fn least_s(&self) -> f64 {
        self.to_goal_s[self.graph.roadmap.start.index()] + self.pause_s
    }
}

/// All modes of all robots.
pub(super) struct Team<'a> {
    pub scene: &'a Scene,
    pub assignment: &'a Assignment,
    /// `modes[robot][step]`.
    pub modes: Vec<Vec<TeamMode<'a>>>,
    pub needs: Needs,
}

impl<'a> Team<'a> {
    /// Reads the roadmaps of all modes.
    ///
    /// # Errors
    /// [`Interrupted::Lacking`]; [`Interrupted::Unfit`] if they are not those of the problem's modes.
    pub fn load(
        scene: &'a Scene,
        assignment: &'a Assignment,
        roadmaps: &[Vec<ProductRef>],
        context: &JobContext<'_>,
    ) -> Result<Self, Interrupted> {
        let of_all = &scene.skeleton.modes;
        let fits = roadmaps.len() == of_all.len() && roadmaps.iter().zip(of_all).all(|(a, b)| a.len() == b.len());
        if !fits {
            return Err(Interrupted::Unfit("not one roadmap for each mode".into()));
        }
        let load = |(mode, product): (&Mode, &ProductRef)| load_mode(scene, assignment, mode, product, context);
        let of_robot = |(modes, products): (&Vec<Mode>, &Vec<ProductRef>)| {
            modes.iter().zip(products).map(load).collect::<Result<Vec<_>, _>>()
        };
        let modes: Vec<Vec<TeamMode<'_>>> = of_all.iter().zip(roadmaps).map(of_robot).collect::<Result<_, _>>()?;
        let needs = Needs::new(scene, assignment, &modes)?;
        Ok(Self { scene, assignment, modes, needs })
    }

    /// A robot's next unit, if it has one left.
    pub fn next(&self, robot: usize, done: &[u32]) -> Option<&TeamMode<'a>> {
        self.modes[robot].get(done[robot] as usize)
    }

    /// A robot where its units so far have brought it.
    pub fn stand(&self, robot: usize, done: u32) -> Travel {
        let (modes, conflicts) = (&self.modes[robot], &self.scene.conflicts);
        if let Some(next) = modes.get(done as usize) {
            return next.graph.stand(next.graph.roadmap.start, conflicts);
        }
        if let Some(last) = modes.last() {
            return last.graph.stand(last.graph.roadmap.goal, conflicts);
        }
        let q = self.scene.problem().robots[robot].start.clone();
        let (robot, allowed) = (RobotId::at(robot), AllowedContacts::default());
        conflicts.travel(&Motion { robot, holding: None, from: q.clone(), to: q, allowed })
    }

    /// The objects that stand, each for ever.
    pub fn standings(&self, done: &[u32]) -> Result<Vec<TimedStanding>, Interrupted> {
        let mut standings = Vec::new();
        for (object, hops) in self.scene.skeleton.hops.iter().enumerate() {
            let hop = hops.iter().take_while(|pair| self.is_done(Event::release(**pair), done)).count();
            if hops.get(hop).is_some_and(|pair| self.is_done(Event::grasp(*pair), done)) {
                continue;
            }
            let occupancy = Occupancy { object: ObjectId::at(object), hop: hop as u32 };
            let standing = self.scene.standing(self.assignment, occupancy)?;
            standings.push(TimedStanding { standing, from_s: f64::NEG_INFINITY, until_s: f64::INFINITY });
        }
        Ok(standings)
    }

    fn is_done(&self, event: Event, done: &[u32]) -> bool {
        let robot = self.scene.problem().pair(event.pair).robot.index();
        let so_far = &self.modes[robot][..done[robot] as usize];
        so_far.iter().any(|unit| unit.mode.ends == Some(event))
    }
}

fn load_mode<'a>(
    scene: &'a Scene,
    assignment: &Assignment,
    mode: &Mode,
    product: &ProductRef,
    context: &JobContext<'_>,
) -> Result<TeamMode<'a>, Interrupted> {
    let graph = scene.mode_graph(assignment, mode, product, context)?;
    let to_goal_s = graph.times_to(graph.roadmap.goal);
    let pause_s = if mode.ends.is_some() { scene.problem().settings.grip_time } else { 0.0 };
    Ok(TeamMode { mode: *mode, graph, to_goal_s, pause_s })
}
