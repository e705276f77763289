//! Shortening a found way without leaving the roadmaps: wandering that leads nowhere becomes standing, and steps that one
//! composite edge can replace are replaced.

use contract::{Interrupted, JobContext};

use super::rules::{Act, Rules, State};
use super::validity::CompositeValidity;

/// How often all robots and steps are gone through, at most.
const ROUNDS: usize = 4;
/// Most steps that one composite edge replaces.
const WINDOW: usize = 8;

/// A way: states, and what is done between them.
#[derive(Clone, Debug)]
pub(super) struct Way {
    pub states: Vec<State>,
    pub steps: Vec<Vec<Act>>,
}

impl Way {
    /// The way from `root` by `steps`.
    pub fn new<V: CompositeValidity>(rules: &mut Rules<'_, V>, root: State, steps: Vec<Vec<Act>>) -> Self {
        let mut states = vec![root];
        for acts in &steps {
            let next = rules.step(&states[states.len() - 1], acts).to;
            states.push(next);
        }
        Self { states, steps }
    }

    /// Shortens it until nothing changes.
    pub fn polish<V: CompositeValidity>(
        mut self,
        rules: &mut Rules<'_, V>,
        context: &mut JobContext<'_>,
    ) -> Result<Self, Interrupted> {
        for _ in 0..ROUNDS {
            let before = self.steps.clone();
            for robot in 0..self.states[0].vertices.len() {
                context.spend(1)?;
                self.stop_wandering(rules, robot);
            }
            self.drop_idle_steps();
            self.take_short_cuts(rules);
            if self.steps == before {
                break;
            }
        }
        Ok(self)
    }

    /// Where a robot comes back to a vertex within a phase, it may as well have stayed, if the others still keep clear.
    fn stop_wandering<V: CompositeValidity>(&mut self, rules: &mut Rules<'_, V>, robot: usize) {
        let phase = |rules: &Rules<'_, V>, state: &State| rules.vector(state).phases[robot];
        let mut from = 0;
        while from < self.steps.len() {
            let here = (phase(rules, &self.states[from]), self.states[from].vertices[robot]);
            let same_phase = (from + 1..self.states.len()).take_while(|i| phase(rules, &self.states[*i]) == here.0);
            let mut returns: Vec<usize> = same_phase.filter(|i| self.states[*i].vertices[robot] == here.1).collect();
            let moves = |to: &usize| self.steps[from..*to].iter().any(|acts| acts[robot] != Act::Stay);
            returns.retain(moves);
            from = returns.into_iter().rev().find(|to| self.stay_between(rules, robot, from, *to)).unwrap_or(from + 1);
        }
    }

    fn stay_between<V: CompositeValidity>(
        &mut self,
        rules: &mut Rules<'_, V>,
        robot: usize,
        from: usize,
        to: usize,
    ) -> bool {
        let vertex = self.states[from].vertices[robot];
        let mut changed = Vec::with_capacity(to - from);
        for i in from..to {
            let mut state = self.states[i].clone();
            state.vertices[robot] = vertex;
            let mut acts = self.steps[i].clone();
            acts[robot] = Act::Stay;
            if acts.iter().any(|act| *act != Act::Stay) && rules.checked_step(&state, &acts).is_err() {
                return false;
            }
            changed.push((state, acts));
        }
        for (i, (state, acts)) in (from..to).zip(changed) {
            self.states[i] = state;
            self.steps[i] = acts;
        }
        true
    }

    fn drop_idle_steps(&mut self) {
        let idle: Vec<bool> = self.steps.iter().map(|acts| acts.iter().all(|act| *act == Act::Stay)).collect();
        let mut step = idle.iter();
        self.steps.retain(|_| !step.next().copied().unwrap_or(false));
        // The state after an idle step is the one before it.
        let mut state = std::iter::once(&false).chain(&idle);
        self.states.retain(|_| !state.next().copied().unwrap_or(false));
    }

    fn take_short_cuts<V: CompositeValidity>(&mut self, rules: &mut Rules<'_, V>) {
        let mut from = 0;
        while from < self.steps.len() {
            let last = (from + WINDOW).min(self.steps.len());
            for to in (from + 2..=last).rev() {
                let (a, b) = (self.states[from].clone(), self.states[to].clone());
                if a.vector != b.vector {
                    continue;
                }
                let now: f64 = (from..to).map(|i| rules.step(&self.states[i], &self.steps[i]).duration_s).sum();
                let Some((acts, duration_s)) = rules.acts_between(&a, &b) else { continue };
                if duration_s < now && rules.checked_step(&a, &acts).is_ok() {
                    self.steps.splice(from..to, [acts]);
                    self.states.drain(from + 1..to);
                    break;
                }
            }
            from += 1;
        }
    }
}
