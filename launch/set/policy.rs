//! Restart policies.

use std::collections::VecDeque;
use std::time::Duration;

use serde::Deserialize;

/// When a process that has ended is started again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Restart {
    /// Never.
    Never,
    /// If it did not end with exit code 0.
    #[default]
    OnFailure,
    /// Always.
    Always,
}

/// What is done when a process ends before the run is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Policy {
    /// Whether it is started again.
    pub restart: Restart,
    /// How often within `restart_window`.
    pub max_restarts: u32,
    /// Seconds.
    pub restart_window: u32,
    /// Whether the run ends when it is given up.
    pub required: bool,
}

impl Default for Policy {
    fn default() -> Self {
        Self { restart: Restart::OnFailure, max_restarts: 10, restart_window: 60, required: true }
    }
}

/// Restarts of one process.
#[derive(Clone, Debug, Default)]
pub struct Restarts {
    at: VecDeque<Duration>,
    total: u32,
}

impl Restarts {
    /// Whether a process that has ended at `now` is started again; if so, it is counted.
    pub fn allow(&mut self, policy: Policy, succeeded: bool, now: Duration) -> bool {
        let wanted = match policy.restart {
            Restart::Never => false,
            Restart::OnFailure => !succeeded,
            Restart::Always => true,
        };
        let window = Duration::from_secs(policy.restart_window.into());
        while self.at.front().is_some_and(|at| *at + window < now) {
            self.at.pop_front();
        }
        let allowed = wanted && self.at.len() < policy.max_restarts as usize;
        if allowed {
            self.at.push_back(now);
            self.total += 1;
        }
        allowed
    }

    /// How often it was started again.
    #[must_use]
    pub fn total(&self) -> u32 {
        self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn policy(restart: Restart) -> Policy {
        Policy { restart, max_restarts: 2, restart_window: 10, required: true }
    }

    #[test]
    fn the_word_decides_who_comes_back() {
        for (restart, after_failure, after_success) in
            [(Restart::Never, false, false), (Restart::OnFailure, true, false), (Restart::Always, true, true)]
        {
            assert_eq!(Restarts::default().allow(policy(restart), false, Duration::ZERO), after_failure);
            assert_eq!(Restarts::default().allow(policy(restart), true, Duration::ZERO), after_success);
        }
    }

    #[test]
    fn restarts_are_counted_within_a_window_that_moves() {
        let mut restarts = Restarts::default();
        let mut at = |second| restarts.allow(policy(Restart::OnFailure), false, Duration::from_secs(second));
        assert!(at(0) && at(5));
        assert!(!at(9));
        assert!(at(11), "the first is forgotten");
        assert!(!at(12));
        assert_eq!(restarts.total(), 3);
    }
}
