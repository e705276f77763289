//! `mrtamp bench`: plans one problem with several seeds, each in a fresh program, and prints the figures; with several
//! composite methods, also a comparison of these over the same seeds.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Args;
use miette::{Context, IntoDiagnostic};
use serde_json::Value;

use crate::packages::PackageArgs;
use crate::plan_command::{Composite, MergedSteps};
use crate::search_args::SearchArgs;
use crate::{bench_comparison, bench_merged, exit, problem_source};

/// Time limit of a run (s) where neither the command line nor the problem has one.
const TIME_LIMIT_S: f64 = 120.0;

/// Arguments of `mrtamp bench`.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// Problem file, or the name of a built-in scene (default: figure1).
    pub problem: Option<PathBuf>,
    /// Number of seeds, counted from `--first-seed`.
    #[arg(long, default_value_t = 25)]
    pub seeds: u64,
    /// First seed.
    #[arg(long, default_value_t = 0)]
    pub first_seed: u64,
    /// Plan in one process, by direct calls.
    #[arg(long)]
    pub in_process: bool,
    /// How composite motion is searched for. Given several times, the methods are compared, all others with the first.
    #[arg(long, value_enum, default_values_t = [Composite::default()])]
    pub composite: Vec<Composite>,
    /// Which of the paper's steps are done as one. Given once or more, all those are compared, with and without causes.
    #[arg(long, value_enum)]
    pub merge: Vec<MergedSteps>,
    /// Seconds after which a search is ended (default: the problem's, else 120).
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
    /// Folder for the plans, one subfolder for each method and seed.
    #[arg(long, value_name = "DIR", default_value = "mrtamp-out/bench")]
    pub out: PathBuf,
    /// What the search does when a stage fails, and how much it may work.
    #[command(flatten)]
    pub search: SearchArgs,
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
}

/// One run.
pub(crate) struct Row {
    pub(crate) method: Composite,
    pub(crate) seed: u64,
    pub(crate) solved: bool,
    pub(crate) refused: bool,
    pub(crate) elapsed_s: f64,
    pub(crate) cpu_s: f64,
    /// Complete placements tried.
    pub(crate) placements: usize,
    /// Places of single hops tried, where steps are merged.
    pub(crate) hops: usize,
    pub(crate) report: Value,
}

impl Row {
    #[cfg(test)]
    pub(crate) fn for_test(method: Composite, seed: u64, report: Value) -> Self {
        Self { method, seed, solved: true, refused: false, elapsed_s: 1.0, cpu_s: 1.0, placements: 1, hops: 0, report }
    }

    /// A figure of the plan, if there is one.
    pub(crate) fn figure(&self, key: &str) -> Option<f64> {
        self.report["plan"][key].as_f64()
    }
}

/// Plans with every seed and prints a table, medians and worst cases.
///
/// # Errors
/// Bad input; when the program cannot start itself.
pub fn run(args: &BenchArgs) -> miette::Result<ExitCode> {
    let problem = problem_source::load_with(args.problem.as_deref(), &args.packages)?;
    let without = problem.search.time_limit.is_none().then_some(TIME_LIMIT_S);
    let args = &BenchArgs { time_limit: args.time_limit.or(without), ..args.clone() };
    if !args.merge.is_empty() {
        return bench_merged::run(args);
    }
    let mut rows = Vec::new();
    println!(
        "{:>6} {:>11} {:>9} {:>9} {:>10} {:>10} {:>10} {:>6}  end",
        "seed", "method", "time s", "cpu s", "task s", "total s", "bound s", "arcs"
    );
    for seed in args.first_seed..args.first_seed + args.seeds {
        for method in &args.composite {
            let row = plan_once(args, *method, seed, &args.out.join(method.name()).join(format!("seed{seed}")), &[])?;
            print_row(&row);
            rows.push(row);
        }
    }
    for method in &args.composite {
        println!("\n{}", method.name());
        print_totals(&rows.iter().filter(|row| row.method == *method).collect::<Vec<_>>());
    }
    if let [first, others @ ..] = args.composite.as_slice()
        && !others.is_empty()
    {
        print!("\n{}", bench_comparison::comparison(*first, others, &rows));
    }
    let all = rows.iter().all(|row| row.solved);
    Ok(ExitCode::from(if all { exit::SOLVED } else { exit::EXHAUSTED }))
}

fn print_row(row: &Row) {
    let number = |key: &str| row.figure(key).map_or("-".to_owned(), |x| format!("{x:.2}"));
    let end = row.report["result"].as_str().unwrap_or(if row.refused { "refused" } else { "fault" });
    println!(
        "{:>6} {:>11} {:>9.2} {:>9.2} {:>10} {:>10} {:>10} {:>6}  {end}",
        row.seed,
        row.method.name(),
        row.elapsed_s,
        row.cpu_s,
        number("task_s"),
        number("total_s"),
        number("lower_bound_s"),
        row.report["plan"]["arcs"].as_u64().map_or("-".to_owned(), |n| n.to_string()),
    );
}

/// Plans once, in a fresh program, with `more` arguments.
///
/// # Errors
/// When the program cannot start itself.
pub(crate) fn plan_once(
    args: &BenchArgs,
    method: Composite,
    seed: u64,
    out: &Path,
    more: &[&str],
) -> miette::Result<Row> {
    let program = std::env::current_exe().into_diagnostic()?;
    let mut command = Command::new(program);
    command.arg("plan").args(&args.problem).args(["--json", "--seed", &seed.to_string()]).arg("--out").arg(out);
    // Without one the problem's holds.
    command.args(args.time_limit.iter().flat_map(|limit| ["--time-limit".to_owned(), limit.to_string()]));
    command.args(["--composite", method.name()]);
    command.args(args.search.to_arguments()).args(more);
    command.args(args.packages.to_arguments());
    if args.in_process {
        command.arg("--in-process");
    }
    let (started, cpu_before) = (std::time::Instant::now(), children_cpu_s());
    let ended = command.output().into_diagnostic().wrap_err("the program cannot start itself")?;
    let report = result_of(&ended.stdout);
    let refused = String::from_utf8_lossy(&ended.stderr).contains("the checker refuses the plan");
    if report.is_null() {
        eprintln!("seed {seed}: {}", String::from_utf8_lossy(&ended.stderr).trim_end());
    }
    Ok(Row {
        method,
        seed,
        solved: ended.status.success(),
        refused,
        elapsed_s: started.elapsed().as_secs_f64(),
        cpu_s: children_cpu_s() - cpu_before,
        placements: count_events(&ended.stdout, "placement"),
        hops: count_events(&ended.stdout, "hop"),
        report,
    })
}

/// The object of a run's last line: its result. Null if it ended with none.
fn result_of(stdout: &[u8]) -> Value {
    let last = stdout.trim_ascii_end().rsplit(|byte| *byte == b'\n').next().unwrap_or_default();
    let line: Value = serde_json::from_slice(last).unwrap_or(Value::Null);
    if line["event"] == "result" { line } else { Value::Null }
}

/// How many lines of a run tell of such an event.
fn count_events(stdout: &[u8], event: &str) -> usize {
    let lines = stdout.split(|byte| *byte == b'\n').filter_map(|line| serde_json::from_slice::<Value>(line).ok());
    lines.filter(|line| line["event"] == event).count()
}

/// CPU time of all ended children and theirs (s).
fn children_cpu_s() -> f64 {
    use nix::sys::resource::{UsageWho, getrusage};
    let seconds = |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 / 1e6;
    getrusage(UsageWho::RUSAGE_CHILDREN)
        .map_or(f64::NAN, |usage| seconds(usage.user_time()) + seconds(usage.system_time()))
}

fn print_totals(rows: &[&Row]) {
    let solved = rows.iter().filter(|row| row.solved).count();
    let refused = rows.iter().filter(|row| row.refused).count();
    println!("solved {solved} of {}, refused by the checker {refused}", rows.len());
    print_spread("time s", rows.iter().map(|row| row.elapsed_s).collect());
    print_spread("cpu s", rows.iter().map(|row| row.cpu_s).collect());
    print_spread("task makespan s", rows.iter().filter_map(|row| row.figure("task_s")).collect());
    for stage in contract::StageKind::ALL {
        let of_stage = |key: &str| -> Vec<f64> {
            let stages = rows.iter().filter_map(|row| row.report["stages"].as_array()).flatten();
            stages.filter(|s| s["stage"] == stage.name()).filter_map(|s| s[key].as_f64()).collect()
        };
        print_spread(&format!("{stage} busy s"), of_stage("busy_s"));
        print_spread(&format!("{stage} work"), of_stage("work"));
    }
}

fn print_spread(name: &str, mut values: Vec<f64>) {
    values.sort_by(f64::total_cmp);
    if let (Some(least), Some(greatest)) = (values.first(), values.last()) {
        let median = values[values.len() / 2];
        println!("{name:<20} min {least:>12.2}  median {median:>12.2}  max {greatest:>12.2}");
    }
}
