//! Composite methods compared over the same seeds.
//!
//! Stages before the composite one are functions of seed and budgets, so methods begin with the same placements, grasps,
//! transition configurations and roadmaps; they keep them unless a method fails on these. Plans with equal lower bounds
//! (which depend on all of these) are counted as made from the same.

use std::fmt::Write as _;

use crate::bench_command::Row;
use crate::plan_command::Composite;

/// Makespans whose ratio is at most this much greater than 1 count as equal.
const EQUAL: f64 = 1e-9;

/// Figures of all methods, and ratios of the first's makespans to those of the others, seed by seed.
pub(crate) fn comparison(first: Composite, others: &[Composite], rows: &[Row]) -> String {
    let mut text = format!(
        "{:<12} {:>7} {:>18} {:>18} {:>14}  (mean, 95 % interval; median)\n",
        "method", "solved", "task s", "total s", "planning s"
    );
    for method in [first].iter().chain(others) {
        let of_method: Vec<&Row> = rows.iter().filter(|row| row.method == *method).collect();
        let solved = of_method.iter().filter(|row| row.solved).count();
        let figures = |key: &str| of_method.iter().filter_map(|row| row.figure(key)).collect::<Vec<f64>>();
        // A string always takes what is written.
        let _ = writeln!(
            text,
            "{:<12} {:>7} {:>18} {:>18} {:>14.2}",
            method.name(),
            format!("{solved}/{}", of_method.len()),
            interval(&figures("task_s"), 2),
            interval(&figures("total_s"), 2),
            median(of_method.iter().map(|row| row.elapsed_s).collect()),
        );
    }
    for other in others {
        text += &ratios(first, *other, rows);
    }
    text
}

fn ratios(first: Composite, other: Composite, rows: &[Row]) -> String {
    let mut text = format!("\n{} / {}\n", first.name(), other.name());
    let of = |method: Composite| rows.iter().filter(move |row| row.method == method && row.solved);
    let pairs: Vec<(&Row, &Row)> =
        of(first).filter_map(|row| Some((row, of(other).find(|other| other.seed == row.seed)?))).collect();
    let is_same = |(a, b): &&(&Row, &Row)| a.figure("lower_bound_s") == b.figure("lower_bound_s");
    let same = pairs.iter().filter(is_same).count();
    // A string always takes what is written.
    let _ = writeln!(text, "  seeds        {} solved by both, {same} from the same choices", pairs.len());
    for (name, key) in [("task", "task_s"), ("total", "total_s")] {
        let ratio = |(a, b): &(&Row, &Row)| Some((a.seed, a.figure(key)? / b.figure(key)?));
        let ratios: Vec<(u64, f64)> = pairs.iter().filter_map(ratio).collect();
        let values: Vec<f64> = ratios.iter().map(|(_, ratio)| *ratio).collect();
        let longer: Vec<String> = ratios
            .iter()
            .filter(|(_, ratio)| *ratio > 1.0 + EQUAL)
            .map(|(seed, ratio)| format!("{seed} ({ratio:.4})"))
            .collect();
        let longer = if longer.is_empty() { "no seed".to_owned() } else { format!("seeds {}", longer.join(", ")) };
        let _ = writeln!(text, "  {name:<12} {}, longer with {longer}", interval(&values, 4));
    }
    text
}

/// Mean and half the width of its 95 % interval (Student's t).
fn mean_and_half_width(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, student_t(values.len().saturating_sub(1)) * (variance / n).sqrt())
}

/// The 97.5 % quantile of Student's t (a standard table); beyond it, the least tabled number of degrees below.
fn student_t(degrees: usize) -> f64 {
    const TABLE: [f64; 30] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
        2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
    ];
    TABLE.get(degrees.clamp(1, TABLE.len()) - 1).copied().unwrap_or(f64::NAN)
}

fn interval(values: &[f64], digits: usize) -> String {
    match values {
        [] => "-".to_owned(),
        [only] => format!("{only:.digits$}"),
        _ => {
            let (mean, half) = mean_and_half_width(values);
            format!("{mean:.digits$} ± {half:.digits$}")
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_have_students_interval() {
        // n = 5, mean 3, standard deviation √2.5: 2.776 √(2.5 / 5).
        assert_eq!(interval(&[1.0, 2.0, 3.0, 4.0, 5.0], 3), "3.000 ± 1.963");
        assert_eq!((interval(&[], 1), interval(&[2.0], 1)), ("-".to_owned(), "2.0".to_owned()));
        assert_eq!((student_t(24), student_t(1), student_t(500)), (2.064, 12.706, 2.042));
    }

    #[test]
    fn ratios_are_taken_seed_by_seed_and_exceptions_are_named() {
        let row = |method, seed, task_s: f64| {
            Row::for_test(
                method,
                seed,
                serde_json::json!({"plan": {"task_s": task_s, "total_s": 10.0, "lower_bound_s": 1.0}}),
            )
        };
        let (a, b) = (Composite::Prioritised, Composite::SyncOpt);
        let rows = [row(a, 0, 1.0), row(b, 0, 2.0), row(a, 1, 6.0), row(b, 1, 4.0), row(a, 2, 5.0)];
        let text = comparison(a, &[b], &rows);
        assert!(text.contains("2 solved by both, 2 from the same choices"), "{text}");
        assert!(text.contains("task         1.0000 ± 6.3530, longer with seeds 1 (1.5000)"), "{text}");
        assert!(text.contains("total        1.0000 ± 0.0000, longer with no seed"), "{text}");
        assert!(text.contains("prioritised      3/3") && text.contains("sync-opt         2/2"), "{text}");
    }
}
