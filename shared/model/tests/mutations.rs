//! Whatever is done to the files, loading ends with a problem or with findings; it never panics.

mod support;

use model::{Problem, load_problem};
use proptest::prelude::*;
use support::mutants::{Random, mutant};
use support::{PROBLEM, SRDF, URDF, good, meshes, render};

/// A change to the text of one file.
#[derive(Clone, Debug)]
enum Change {
    /// Replaces a range of bytes.
    Bytes { at: usize, len: usize, by: Vec<u8> },
    /// Copies a line elsewhere.
    Line { from: usize, to: usize },
    /// Removes some lines.
    Remove { from: usize, count: usize },
    /// Replaces a number.
    Number { index: usize, by: &'static str },
    /// Replaces a word by another word of the file.
    Word { index: usize, by: usize },
}

fn change() -> impl Strategy<Value = Change> {
    let numbers =
        ["0", "-1", "1e308", "-1e308", "1e-320", ".nan", ".inf", "nan", "inf", "99999999999999999999", "''", "~"];
    prop_oneof![
        (any::<usize>(), 0..6usize, prop::collection::vec(any::<u8>(), 0..6)).prop_map(|(at, len, by)| Change::Bytes {
            at,
            len,
            by
        }),
        (any::<usize>(), any::<usize>()).prop_map(|(from, to)| Change::Line { from, to }),
        (any::<usize>(), 1..4usize).prop_map(|(from, count)| Change::Remove { from, count }),
        (any::<usize>(), prop::sample::select(numbers.to_vec())).prop_map(|(index, by)| Change::Number { index, by }),
        (any::<usize>(), any::<usize>()).prop_map(|(index, by)| Change::Word { index, by }),
    ]
}

fn apply(text: Vec<u8>, change: &Change) -> Vec<u8> {
    if let Change::Bytes { at, len, by } = change {
        let mut text = text;
        let at = at % (text.len() + 1);
        let end = (at + len).min(text.len());
        text.splice(at..end, by.iter().copied());
        return text;
    }
    let text = String::from_utf8_lossy(&text).into_owned();
    let mut lines: Vec<&str> = text.split('\n').collect();
    match change {
        Change::Line { from, to } => lines.insert(to % lines.len(), lines[from % lines.len()]),
        Change::Remove { from, count } => {
            let from = from % lines.len();
            lines.drain(from..(from + count).min(lines.len()));
        }
        Change::Number { index, by } => return replace_token(&text, *index, |c| c.is_ascii_digit() || c == '.', by),
        Change::Word { index, by } => {
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            let words: Vec<&str> = text.split(|c| !is_word(c)).filter(|word| !word.is_empty()).collect();
            let by = words.get(by % words.len().max(1)).copied().unwrap_or("x").to_owned();
            return replace_token(&text, *index, is_word, &by);
        }
        Change::Bytes { .. } => {}
    }
    lines.join("\n").into_bytes()
}

/// Replaces one of the maximal runs of characters that fit.
fn replace_token(text: &str, index: usize, fits: impl Fn(char) -> bool, by: &str) -> Vec<u8> {
    let mut tokens = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), '\n')]) {
        match (fits(c), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                tokens.push(from..at);
                start = None;
            }
            _ => {}
        }
    }
    if tokens.is_empty() {
        return text.as_bytes().to_vec();
    }
    let token = tokens[index % tokens.len()].clone();
    let mut text = text.to_owned();
    text.replace_range(token, by);
    text.into_bytes()
}

/// What every accepted problem keeps, whatever its file said.
fn is_sound(problem: &Problem) -> bool {
    let configurations = problem.robots.iter().all(|robot| {
        let within = robot.start.iter().zip(&robot.coordinates).all(|(q, c)| (c.lower..=c.upper).contains(q));
        let tree = robot.joints.len() + 1 == robot.links.len();
        within && tree && robot.coordinates.iter().all(|c| c.velocity > 0.0 && c.lower < c.upper)
    });
    let grasps = problem.movable.iter().flat_map(|object| object.grasps.iter().flatten());
    let finite = |pose: &model::Pose| pose.to_homogeneous().iter().all(|x| x.is_finite());
    configurations
        && grasps.into_iter().all(|grasp| finite(&grasp.link_from_object))
        && problem.fixed.iter().all(|object| finite(&object.world_from_object))
        && problem.movable.iter().all(|object| object.start_support.is_some() && finite(&object.world_from_start))
        && problem.pairs.iter().all(|pair| pair.hop > 0)
        && !problem.pairs.is_empty()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn changed_files_are_read_or_refused_with_findings(
        path in prop::sample::select(vec![PROBLEM, PROBLEM, URDF, SRDF]),
        changes in prop::collection::vec(change(), 1..4),
    ) {
        let mut files = good();
        for change in &changes {
            let text = files.0.remove(path).unwrap_or_default();
            files.0.insert(path.to_owned(), apply(text, change));
        }
        match load_problem(&files, PROBLEM) {
            Ok(problem) => prop_assert!(is_sound(&problem), "{changes:?}"),
            Err(error) => prop_assert!(render(&error).contains("help:"), "{}", render(&error)),
        }
    }

    #[test]
    fn changed_meshes_are_read_or_refused_with_findings(
        name in prop::sample::select(vec!["m.obj", "m.stl", "m.dae"]),
        changes in prop::collection::vec(change(), 1..4),
    ) {
        let original = match name {
            "m.obj" => meshes::cube_obj(),
            "m.stl" => meshes::stl(&meshes::TETRAHEDRON),
            _ => meshes::DAE.to_owned(),
        };
        let mesh = changes.iter().fold(original.into_bytes(), apply);
        if let Err(error) = meshes::load_as_blob((&format!("scenes/{name}"), &mesh), &format!("{{file: {name}}}")) {
            prop_assert!(render(&error).contains("help:"), "{}", render(&error));
        }
    }

    #[test]
    fn random_bytes_are_no_mesh(bytes in prop::collection::vec(any::<u8>(), 0..300), triangles in any::<u32>()) {
        // Binary STL: 80 bytes of header, the number of triangles, the triangles.
        let mut mesh = vec![0_u8; 80];
        mesh.extend(triangles.to_le_bytes());
        mesh.extend(bytes);
        if let Err(error) = meshes::load_as_blob(("scenes/m.stl", &mesh), "{file: m.stl}") {
            prop_assert!(render(&error).contains("help:"), "{}", render(&error));
        }
    }
}

/// Mutants here; `cargo run --release --example mutants` tries as many as one likes.
const MUTANTS: u64 = 3_000;

#[test]
fn mutants_behind_the_parsers_are_read_or_refused_with_findings() {
    let mut behind = 0;
    for seed in 0..MUTANTS {
        let mut random = Random(seed);
        let path = [PROBLEM, PROBLEM, URDF, SRDF][random.below(4)];
        let mut files = good();
        let text = String::from_utf8(files.0[path].clone()).unwrap();
        files.0.insert(path.to_owned(), mutant(&mut random, &text));
        match load_problem(&files, PROBLEM) {
            Ok(problem) => assert!(is_sound(&problem), "mutant {seed} of {path}"),
            Err(error) => {
                let told = |finding: &model::Finding| miette::Diagnostic::help(finding).is_some();
                assert!(error.findings().iter().all(told), "mutant {seed} of {path}: {error}");
                let malformed = |finding: &model::Finding| finding.kind() == model::FindingKind::Malformed;
                behind += u64::from(!error.findings().iter().any(malformed));
            }
        }
    }
    assert!(behind > MUTANTS / 5, "only {behind} mutants get past the parsers and are refused behind them");
}

#[test]
fn deep_nesting_is_refused_before_anything_recurses() {
    for (path, text) in [
        (PROBLEM, "[".repeat(200_000)),
        (PROBLEM, "a: ".repeat(100_000)),
        (URDF, "<robot>".repeat(200_000)),
        (SRDF, "<robot><group>".repeat(100_000)),
    ] {
        let mut files = good();
        files.0.insert(path.to_owned(), text.into_bytes());
        assert!(load_problem(&files, PROBLEM).is_err());
    }
    let nested = meshes::DAE.replace("<asset>", &format!("<asset>{}", "<extra>".repeat(100_000)));
    assert!(meshes::load_as_blob(("scenes/m.dae", nested.as_bytes()), "{file: m.dae}").is_err());
    let closed = format!("<asset>{}{}", "<extra>".repeat(100_000), "</extra>".repeat(100_000));
    for nested in [meshes::DAE.replace("<asset>", &closed), "<a>".repeat(100_000)] {
        assert!(meshes::load_as_blob(("scenes/m.dae", nested.as_bytes()), "{file: m.dae}").is_err());
    }
}

#[test]
fn aliases_that_multiply_are_refused() {
    let mut text = String::from("name: &a0 [x, x]\n");
    for level in 1..40 {
        text += &format!("k{level}: &a{level} [*a{0}, *a{0}]\n", level - 1);
    }
    let mut files = good();
    files.0.insert(PROBLEM.to_owned(), text.into_bytes());
    assert!(load_problem(&files, PROBLEM).is_err());
}
