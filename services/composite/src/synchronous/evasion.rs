//! Making room within a round: where robots planned one after the other do not get past one another, one first goes where it is
//! in nobody's way, as into a bay; the others do their units; then it goes on.

use contract::{JobContext, VertexId};

use super::rounds::spend;
use super::sequence::Stop;
use super::team::Team;
use super::unit::{Around, timed_moves};
use crate::commit::Mover;
use crate::sipp::{Gates, Search, Step, Traffic};
use crate::{TimedMove, Travel};

/// The first part of a unit: to where the robot waits. Times count from the round's beginning.
pub(super) struct Leg {
    pub path: Vec<Step>,
    /// Where it leads to.
    pub vertex: VertexId,
    /// When it is over (s).
    pub ends_s: f64,
    /// Motion, and standing for ever behind it.
    pub moves: Vec<TimedMove>,
}

/// The way of a robot's next unit to the vertex that is reached first of those where the robot is in the way of no motion in
/// `ways`. `around` are all others, those that move in the round where they stand at its beginning. `None`: there is no such vertex.
pub(super) fn leg(
    team: &Team<'_>,
    robot: usize,
    done: &[u32],
    around: &Around,
    ways: &[Travel],
    context: &mut JobContext<'_>,
) -> Result<Option<Leg>, Stop> {
    let Some(next) = team.next(robot, done) else { return Ok(None) };
    let (graph, conflicts) = (&next.graph, &team.scene.conflicts);
    let others = around.robots.iter().enumerate().filter(|(other, _)| *other != robot);
    let others = others.map(|(_, moves)| moves.as_slice()).collect();
    let traffic = Traffic::among(conflicts, others, around.standings.clone(), 0.0);
    // In order of time alone, but never to where the unit cannot be ended.
    let bound_s = next.to_goal_s.iter().map(|time_s| if time_s.is_finite() { 0.0 } else { f64::INFINITY }).collect();
    let mut search = Search::new(graph, &traffic, conflicts, Gates::OPEN, bound_s, (graph.roadmap.start, 0.0, 0.0));
    while let Some(index) = search.next() {
        spend(context)?;
        let state = search.state(index);
        let stand = graph.stand(state.vertex, conflicts);
        let is_in_the_way = |way: &Travel| (0..way.cells).any(|cell| conflicts.cells_conflict(way, cell, &stand, 0));
        if search.interval(&state).until_s < f64::INFINITY || ways.iter().any(is_in_the_way) {
            continue;
        }
        let path = search.path(index);
        let mut mover = Mover::new(graph.vertex(graph.roadmap.start).clone(), 0.0);
        mover.follow(graph, &path);
        let mut moves = timed_moves(team.scene, next, &mover.moves);
        moves.push(TimedMove { travel: stand, begins_s: state.time_s, ends_s: f64::INFINITY });
        return Ok(Some(Leg { path, vertex: state.vertex, ends_s: state.time_s, moves }));
    }
    Ok(None)
}
