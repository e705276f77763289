//! Safe tails: whoever has done something goes where it may stand for ever, so that nobody is ever stuck behind it.

use contract::{EdgeKind, JobContext, Move, VertexId};
use model::Configuration;

use crate::Travel;
use crate::sipp::{Gates, ModeGraph, Search, Traffic};

use super::moves::Mover;
use super::{CommitJob, Start, Unreached, begin_at};

impl CommitJob<'_> {
    /// From the event to a place to stand for ever: the best parking vertex that can be reached, else any vertex; rather
    /// one that is in the way of none of the motions to be left free.
    pub(super) fn tail(
        &self,
        graph: &ModeGraph<'_>,
        traffic: &Traffic<'_>,
        leave_free: &[Travel],
        at: &Configuration,
        event_s: f64,
        context: &mut JobContext<'_>,
    ) -> Result<Option<Vec<Move>>, Unreached> {
        let start = graph.roadmap.start;
        let Start { mut mover, .. } = begin_at(graph, start, event_s, Mover::new(at.clone(), event_s))?;
        mover.stand(event_s + self.scene.problem().settings.grip_time, EdgeKind::Arm, graph.allowed_at(start));
        let best = graph.roadmap.parking.first().copied().unwrap_or(start);
        let bound_s = graph.times_to(best).into_iter().map(|time| if time.is_finite() { time } else { 0.0 }).collect();
        let conflicts = &self.scene.conflicts;
        let mut search = Search::new(graph, traffic, conflicts, Gates::OPEN, bound_s, (start, event_s, mover.time_s));
        let rank = |vertex: VertexId| graph.roadmap.parking.iter().position(|parking| *parking == vertex);
        let obstructs = |vertex: VertexId| {
            let stand = graph.stand(vertex, conflicts);
            leave_free.iter().any(|travel| (0..travel.cells).any(|i| conflicts.cells_conflict(travel, i, &stand, 0)))
        };
        let mut found: Option<(bool, usize, u64, usize)> = None;
        while let Some(index) = search.next() {
            self.spend(context)?;
            let state = search.state(index);
            if search.interval(&state).until_s < f64::INFINITY {
                continue;
            }
            let rank = rank(state.vertex).unwrap_or(usize::MAX);
            let here = (obstructs(state.vertex), rank, state.time_s.to_bits(), index);
            found = Some(found.map_or(here, |so_far| so_far.min(here)));
            if (here.0, here.1) == (false, 0) {
                break;
            }
        }
        let Some((_, _, _, index)) = found else { return Ok(None) };
        mover.follow(graph, &search.path(index));
        let vertex = search.state(index).vertex;
        mover.rest(EdgeKind::Arm, graph.allowed_at(vertex));
        Ok(Some(mover.moves))
    }
}
