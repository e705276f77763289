//! Connection to the next events: per-robot shortest paths, prioritised, with waits and evasion.
//!
//! One robot leads: it goes the shortest way to its event, perhaps after a delay. The others follow in order of priority:
//! each searches vertices and steps for a way towards its own goal that keeps clear of those before it, which makes a
//! robot that stands in the way leave in time (cooperative A*, Silver, AIIDE 2005). The tree gets every step, up to the
//! first event.

use contract::{Interrupted, SampleValues};

use super::cooperative::Attempt;
use super::meter::Meter;
use super::rules::Act;
use super::search::{Search, shuffle};
use super::tree::NodeId;
use super::validity::CompositeValidity;

/// Steps that the leader waits, in turn; also its waits by chance.
const DELAYS: [usize; 4] = [0, 4, 12, 32];
/// Most robots that lead in turn.
const LEADERS: usize = 3;
/// What an edge costs a leader on which it would meet a robot that stands now (s): so far it goes round.
const STANDING_S: f64 = 4.0;
impl<V: CompositeValidity> Search<'_, V> {
    /// Tries connections from a node in a fixed order until one leads to an event or to the end.
    pub fn connect_in_turn(&mut self, node: NodeId, meter: &mut Meter<'_, '_>) -> Result<(), Interrupted> {
        let state = self.tree.get(node).state.clone();
        let priorities = self.rules.priorities(&state);
        let ready = |robot: &usize| self.rules.urgency(&state, *robot).class == 0;
        let leaders: Vec<usize> = priorities.iter().copied().filter(ready).take(LEADERS).collect();
        for delay in DELAYS {
            for leader in &leaders {
                let attempt = Attempt { order: led_by(*leader, &priorities), delay, standing_s: STANDING_S };
                if self.connect(node, &attempt, meter)? || !meter.spend(0)? {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Tries one connection with leader, order, delay and detour by chance.
    pub fn connect_at_random(
        &mut self,
        node: NodeId,
        values: &mut SampleValues,
        meter: &mut Meter<'_, '_>,
    ) -> Result<(), Interrupted> {
        let state = self.tree.get(node).state.clone();
        let mut order = self.rules.priorities(&state);
        let ready: Vec<usize> =
            order.iter().copied().filter(|robot| self.rules.urgency(&state, *robot).class == 0).collect();
        if ready.is_empty() {
            return Ok(());
        }
        let leader = ready[values.next_index(ready.len())];
        if values.next_unit() < 0.5 {
            shuffle(&mut order, values);
        }
        let delay = DELAYS[values.next_index(DELAYS.len())] / 2 + values.next_index(4);
        let standing_s = [0.0, STANDING_S, 16.0 * STANDING_S][values.next_index(3)];
        self.connect(node, &Attempt { order: led_by(leader, &order), delay, standing_s }, meter)?;
        Ok(())
    }

    /// Whether an attempt led to an event or to the end of the plan.
    fn connect(&mut self, node: NodeId, attempt: &Attempt, meter: &mut Meter<'_, '_>) -> Result<bool, Interrupted> {
        let state = self.tree.get(node).state.clone();
        if !meter.spend(1)? {
            return Ok(false);
        }
        let planned = self.rules.plan_together(&state, attempt, meter)?;
        if !meter.spend(planned.as_ref().map_or(0, |steps| steps.len() as u64))? {
            return Ok(false);
        }
        Ok(planned.is_some_and(|steps| self.walk(node, &steps)))
    }

    /// Takes planned steps until an event happens; whether one did, or all is done.
    fn walk(&mut self, node: NodeId, steps: &[Vec<Act>]) -> bool {
        let mut at = node;
        for acts in steps {
            if self.happen(at, acts) {
                return true;
            }
            let state = self.tree.get(at).state.clone();
            if acts.iter().all(|act| *act == Act::Stay) {
                continue;
            }
            let Ok(step) = self.rules.checked_step(&state, acts) else { return false };
            at = self.reach(at, acts.clone(), step).0;
        }
        let still = vec![Act::Stay; self.tree.get(at).state.vertices.len()];
        self.happen(at, &still) || self.solution == Some(at)
    }

    /// Lets events happen at a node: all that can while the other robots go on, or else a single one.
    fn happen(&mut self, node: NodeId, acts: &[Act]) -> bool {
        let state = self.tree.get(node).state.clone();
        let ready: Vec<usize> = (0..acts.len()).filter(|robot| self.rules.has_event(&state, *robot)).collect();
        if ready.is_empty() {
            return false;
        }
        let with = |acts: &[Act], events: &[usize]| -> Vec<Act> {
            (0..acts.len()).map(|r| if events.contains(&r) { Act::Event } else { acts[r] }).collect()
        };
        let still = vec![Act::Stay; acts.len()];
        let mut choices = vec![with(acts, &ready), with(&still, &ready)];
        choices.extend(ready.iter().map(|robot| with(&still, &[*robot])));
        for acts in choices {
            if let Ok(step) = self.rules.checked_step(&state, &acts) {
                self.reach(node, acts, step);
                return true;
            }
        }
        false
    }
}

fn led_by(leader: usize, order: &[usize]) -> Vec<usize> {
    std::iter::once(leader).chain(order.iter().copied().filter(|robot| *robot != leader)).collect()
}
