//! What every job of this stage works with.

use std::sync::Arc;

use collision::{Geometry, GeometryError};
use contract::{Assignment, Interrupted, JobContext, ProblemStatement, ProductRef};
use model::{Holding, Pose, Problem, Standing};
use skeleton::{ArcOrigin, EventGraph, Mode, Occupancy, Skeleton};

use crate::Conflicts;
use crate::prefix::is_holding_of;
use crate::sipp::ModeGraph;

/// Why the stage cannot work on a problem.
#[derive(Debug, thiserror::Error)]
pub enum CompositeError {
    /// A shape that the geometry cannot use.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The given orderings contradict one another.
    #[error("the given orderings form a cycle of {0} arcs")]
    Cycle(usize),
}

/// Problem, task plan and geometry.
pub struct Scene {
    /// Statement.
    pub statement: ProblemStatement,
    /// Modes, occupancies and the given order.
    pub skeleton: Skeleton,
    /// The conflict relation.
    pub conflicts: Conflicts,
}

impl Scene {
    /// Prepares a problem.
    ///
    /// # Errors
    /// [`CompositeError`].
    pub fn new(statement: &ProblemStatement) -> Result<Self, CompositeError> {
        let skeleton =
            Skeleton::of_problem(&statement.problem).map_err(|cycle| CompositeError::Cycle(cycle.0.len()))?;
        let geometry = Arc::new(Geometry::new(&statement.problem)?);
        Ok(Self { statement: statement.clone(), skeleton, conflicts: Conflicts::new(geometry) })
    }

    /// The problem.
    #[must_use]
    pub fn problem(&self) -> &Problem {
        &self.statement.problem
    }

    /// The given order and the assignment's.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`] if they contradict one another or name a pair that is none.
    pub fn graph(&self, assignment: &Assignment) -> Result<EventGraph, Interrupted> {
        let mut graph = self.skeleton.graph.clone();
        for order in &assignment.orders {
            let pairs = self.problem().pairs.len();
            if order.before.pair.index() >= pairs || order.after.pair.index() >= pairs {
                return Err(Interrupted::Unfit("an order names a pair that is none".into()));
            }
            graph
                .add(order.before, order.after, ArcOrigin::Discovered)
                .map_err(|cycle| Interrupted::Unfit(format!("the orders form a cycle of {} arcs", cycle.0.len())))?;
        }
        Ok(graph)
    }

    /// Where an object stands in one of its poses.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`] if the assignment has no such pose.
    pub fn standing(&self, assignment: &Assignment, occupancy: Occupancy) -> Result<Standing, Interrupted> {
        let Occupancy { object, hop } = occupancy;
        let pose: Option<&Pose> = assignment.poses.get(object.index()).and_then(|hops| hops.get(hop as usize));
        let lacking = || Interrupted::Unfit(format!("the assignment lacks pose {hop} of object {}", object.0));
        Ok(Standing { object, world_from_object: *pose.ok_or_else(lacking)? })
    }

    /// What the robot holds in a mode.
    fn holding(&self, assignment: &Assignment, mode: &Mode) -> Result<Option<Holding>, Interrupted> {
        let Some(pair) = mode.pair.filter(|_| mode.is_holding()) else { return Ok(None) };
        let grasp = assignment.grasps.get(pair.index());
        let grasp = *grasp.ok_or_else(|| Interrupted::Unfit("the assignment lacks a grasp".into()))?;
        Ok(Some(Holding { object: self.problem().pair(pair).object, grasp }))
    }

    /// The object that a mode's event puts down, where it then stands.
    pub(crate) fn placed(&self, assignment: &Assignment, mode: &Mode) -> Result<Option<Standing>, Interrupted> {
        let Some(pair) = mode.pair.filter(|_| mode.is_holding()) else { return Ok(None) };
        self.standing(assignment, self.skeleton.placed(self.problem(), pair)).map(Some)
    }

    /// The roadmap of a mode, holding what the mode holds.
    pub(crate) fn mode_graph(
        &self,
        assignment: &Assignment,
        mode: &Mode,
        product: &ProductRef,
        context: &JobContext<'_>,
    ) -> Result<ModeGraph<'_>, Interrupted> {
        let graph = ModeGraph::load(self.problem(), mode.id, product, context)?;
        let holding = graph.roadmap.holding;
        if holding != self.holding(assignment, mode)? || !is_holding_of(self.problem(), mode.id.robot, holding) {
            return Err(Interrupted::Unfit("a roadmap holds something else than its mode".into()));
        }
        Ok(graph)
    }
}
