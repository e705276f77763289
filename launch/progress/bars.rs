//! Live progress on a terminal: a line for the search and one for each stage, notable events above them.

use std::time::Duration;

use contract::StageKind;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::tally::{StageTally, Tally};
use crate::words;

/// The spinner turns this often.
const TURN: Duration = Duration::from_millis(120);

/// Lines that are drawn again and again at the end of a terminal.
#[derive(Debug)]
pub struct Bars {
    all: MultiProgress,
    search: ProgressBar,
    stages: [ProgressBar; 4],
    modes: usize,
}

impl Bars {
    /// Lines on `target` for a task plan of `modes` modes; `elapsed_s` tells the time that is shown.
    #[must_use]
    pub fn new(
        target: ProgressDrawTarget,
        modes: usize,
        elapsed_s: impl Fn() -> f64 + Clone + Send + Sync + 'static,
    ) -> Self {
        let all = MultiProgress::with_draw_target(target);
        let line = |name: &'static str, template: &str| {
            let clock = elapsed_s.clone();
            let since = move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
                // Writing to the text of a line cannot fail.
                let _ = write!(out, "{:.1} s", clock());
            };
            // The templates are this file's own.
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner());
            all.add(ProgressBar::new_spinner().with_style(style.with_key("since", since)).with_prefix(name))
        };
        let search = line("search", "{spinner:.cyan} {prefix:<10.bold} {since:>8}  {wide_msg}");
        let stages = StageKind::ALL.map(|stage| line(stage.name(), "  {prefix:<10} {wide_msg}"));
        Self { all, search, stages, modes }
    }

    /// Lets the spinner turn by itself.
    #[must_use]
    pub fn turning(self) -> Self {
        self.search.enable_steady_tick(TURN);
        self
    }

    /// Shows what has happened so far; `busy_s` is the time that each stage has worked.
    pub fn show(&self, tally: &Tally, busy_s: impl Fn(StageKind) -> f64) {
        self.search.set_message(search_text(tally, self.modes));
        for (stage, bar) in StageKind::ALL.into_iter().zip(&self.stages) {
            bar.set_message(stage_text(stage, tally.stage(stage), busy_s(stage)));
        }
    }

    /// Prints a line above the bars.
    pub fn print(&self, line: &str) {
        // A terminal that is gone has nobody before it.
        let _ = self.all.println(line);
    }

    /// Removes the lines from the terminal.
    pub fn clear(&self) {
        for bar in self.stages.iter().chain([&self.search]) {
            bar.finish_and_clear();
        }
        // As above.
        let _ = self.all.clear();
    }
}

/// Where the search is.
#[must_use]
pub fn search_text(tally: &Tally, modes: usize) -> String {
    match tally.reached() {
        None => "begins".to_owned(),
        Some(reached) => format!(
            "sample level {}, placement candidate {}, {} of {modes} modes committed",
            reached.level, reached.candidates, reached.committed
        ),
    }
}

/// What a stage has done.
#[must_use]
pub fn stage_text(stage: StageKind, tally: &StageTally, busy_s: f64) -> String {
    let what = match stage {
        StageKind::Placement => "candidates",
        StageKind::Transition => "alternatives",
        StageKind::Roadmap => "roadmaps",
        StageKind::Composite => "motions",
    };
    let cause = tally.commonest().map_or(String::new(), |cause| format!("  mostly: {}", words::cause(&cause)));
    let StageTally { jobs, failures, answers, .. } = tally;
    format!("{busy_s:>6.1} s {jobs:>6} jobs {answers:>6} {what:<12} {failures:>5} failed{cause}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{Answer, CauseTally, Decision, LedgerEntry, Outcome};
    use indicatif::InMemoryTerm;
    use model::RobotId;
    use plan::{BodyRef, Cause};
    use skeleton::ModeId;

    fn some_progress() -> Tally {
        let mut tally = Tally::default();
        for decision in
            [Decision::Level(1), Decision::Placement(0), Decision::Commit(ModeId { robot: RobotId(0), step: 0 })]
        {
            tally.committed(&LedgerEntry::Decided(decision));
        }
        tally.answered(StageKind::Placement, &Outcome::answer(Answer::Placements(Vec::new()), 1));
        let mut causes = CauseTally::default();
        causes.count(Cause::NoPath {
            pair: Some("r1.1".to_owned()),
            robot: "r1".to_owned(),
            blocking: vec![BodyRef::Object("m2".to_owned())],
        });
        tally.answered(StageKind::Roadmap, &Outcome::soft_failure(causes, 0, 1));
        tally
    }

    #[test]
    fn bars_show_where_the_search_is_and_what_each_stage_has_done_below_what_is_of_note() {
        let terminal = InMemoryTerm::new(12, 96);
        let bars = Bars::new(ProgressDrawTarget::term_like(Box::new(terminal.clone())), 9, || 12.34);
        bars.print("    0.50 s  [refiner] placement candidate 0");
        bars.show(&some_progress(), |stage| if stage == StageKind::Roadmap { 2.5 } else { 0.0 });
        let shown = terminal.contents();
        let lines: Vec<&str> = shown.lines().map(str::trim_end).collect();
        assert_eq!(lines[0], "    0.50 s  [refiner] placement candidate 0");
        assert!(
            lines[1].ends_with("search       12.3 s  sample level 1, placement candidate 1, 1 of 9 modes committed")
        );
        assert_eq!(
            lines[2..],
            [
                "  placement     0.0 s      1 jobs      0 candidates       0 failed",
                "  transition    0.0 s      0 jobs      0 alternatives     0 failed",
                "  roadmap       2.5 s      1 jobs      0 roadmaps         1 failed  mostly: no way for r1 in r1.",
                "  composite     0.0 s      0 jobs      0 motions          0 failed",
            ]
        );
        bars.clear();
        assert_eq!(terminal.contents().trim_end(), "    0.50 s  [refiner] placement candidate 0");
    }
}
