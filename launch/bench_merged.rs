//! `mrtamp bench --merge`: the paper's ablations in one table: each pipeline over the same seeds, with and without causes.

use std::collections::BTreeMap;
use std::process::ExitCode;

use contract::StageKind;

use crate::bench_command::{BenchArgs, Row, plan_once};
use crate::exit;
use crate::plan_command::MergedSteps;

/// Policies of a search that is told no causes.
const NO_CAUSES: [&str; 6] = [
    "--policy",
    "transition=backtrack:no_causes",
    "--policy",
    "roadmap=backtrack:no_causes",
    "--policy",
    "composite=backtrack:no_causes",
];

/// Plans with every pipeline and seed, and prints the table. All figures but counts of ends are medians over the seeds.
///
/// # Errors
/// When the program cannot start itself.
pub(crate) fn run(args: &BenchArgs) -> miette::Result<ExitCode> {
    println!(
        "{:<6} {:<6} {:>7} {:>9} {:>7} {:>7} {:>38} {:>23}",
        "merge",
        "causes",
        "solved",
        "time s",
        "hops",
        "placed",
        "work of placement … composite",
        "jobs of trans., roadmap"
    );
    let mut all_solved = true;
    for merge in &args.merge {
        for causes in [true, false] {
            let rows = plan_all(args, *merge, causes)?;
            all_solved &= rows.iter().all(|row| row.solved);
            println!("{}", line(*merge, causes, &rows));
        }
    }
    Ok(ExitCode::from(if all_solved { exit::SOLVED } else { exit::EXHAUSTED }))
}

fn plan_all(args: &BenchArgs, merge: MergedSteps, causes: bool) -> miette::Result<Vec<Row>> {
    let mut more = vec!["--merge", merge.name()];
    if !causes {
        more.extend(NO_CAUSES);
    }
    let folder = args.out.join(format!("merge_{}", merge.name())).join(if causes { "causes" } else { "no_causes" });
    let seeds = args.first_seed..args.first_seed + args.seeds;
    let method = args.composite.first().copied().unwrap_or_default();
    seeds.map(|seed| plan_once(args, method, seed, &folder.join(format!("seed{seed}")), &more)).collect()
}

/// One line of the table.
fn line(merge: MergedSteps, causes: bool, rows: &[Row]) -> String {
    let median = |figure: &dyn Fn(&Row) -> f64| {
        let mut values: Vec<f64> = rows.iter().map(figure).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let of_stage = |stage: StageKind, key: &'static str| {
        median(&move |row: &Row| {
            let stages = row.report["stages"].as_array();
            let count = stages.and_then(|stages| stages.iter().find(|count| count["stage"] == stage.name()));
            count.and_then(|count| count[key].as_f64()).unwrap_or(0.0)
        })
    };
    let solved = rows.iter().filter(|row| row.solved).count();
    let work: Vec<String> = StageKind::ALL.iter().map(|stage| format!("{:>8.0}", of_stage(*stage, "work"))).collect();
    format!(
        "{:<6} {:<6} {:>7} {:>9.2} {:>7.0} {:>7.0}    {} {:>11.0} {:>11.0}  {}",
        merge.name(),
        if causes { "yes" } else { "no" },
        format!("{solved}/{}", rows.len()),
        median(&|row: &Row| row.elapsed_s),
        median(&|row: &Row| row.hops as f64),
        median(&|row: &Row| row.placements as f64),
        work.join(" "),
        of_stage(StageKind::Transition, "jobs"),
        of_stage(StageKind::Roadmap, "jobs"),
        ends(rows)
    )
}

/// How runs ended that are not solved.
fn ends(rows: &[Row]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows.iter().filter(|row| !row.solved) {
        *counts.entry(row.report["result"].as_str().unwrap_or("fault")).or_insert(0) += 1;
    }
    counts.iter().map(|(end, count)| format!("{end} {count}")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_line_has_medians_of_work_jobs_and_tries_and_tells_how_runs_ended() {
        let row = |seed: u64, solved: bool, work: u64| {
            let result = if solved { "solved" } else { "limit_reached" };
            let stages = json!([{"stage": "roadmap", "jobs": work / 10, "work": work}]);
            let (report, elapsed_s, hops) = (json!({"result": result, "stages": stages}), seed as f64, seed as usize);
            Row {
                method: crate::plan_command::Composite::Prioritised,
                seed,
                solved,
                refused: false,
                elapsed_s,
                cpu_s: 0.0,
                placements: 1,
                hops,
                report,
            }
        };
        let line = line(MergedSteps::OneToThree, false, &[row(1, true, 70), row(3, false, 90), row(2, true, 80)]);
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[..6], ["1-3", "no", "2/3", "2.00", "2", "1"]);
        assert_eq!(words[6..], ["0", "0", "80", "0", "0", "8", "limit_reached", "1"]);
    }
}
