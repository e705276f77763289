//! A placement stage of somebody else's takes the place of ours: named by `command:` in a launch file, nothing recompiled.

use clap::Parser;
use collision::Geometry;
use contract::{
    Answer, Interrupted, Job, JobContext, Outcome, Placed, PlacementCandidate, ProblemStatement, Request, Stage,
    StageKind,
};
use launch::set::member::MemberArgs;
use launch::set::stage_process;
use model::{PairId, Problem, Standing};
use nalgebra::Translation3;

use crate::{scene, scene_path};

/// Puts every object into the middle of its region; it knows nothing better.
struct MiddleStage(Geometry);

fn middle(problem: &Problem, pair: PairId) -> Standing {
    let pair = problem.pair(pair);
    let height = problem.movable[pair.object.index()].origin_height();
    let region = &problem.regions[pair.to.index()];
    let world_from_object = region.world_from_region * Translation3::new(0.0, 0.0, height);
    Standing { object: pair.object, world_from_object }
}

impl Stage for MiddleStage {
    fn refine(&self, job: &Job, _: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let Request::Placement(request) = &job.request else { return Err(Interrupted::Unfit("not placement".into())) };
        let problem = self.0.problem();
        let placed = |i: usize| {
            let pair = PairId::at(i);
            Placed { pair, sample: 0, world_from_object: middle(problem, pair).world_from_object }
        };
        let placements = (0..problem.pairs.len()).map(placed).collect();
        let only = PlacementCandidate { index: 0, placements, orders: Vec::new() };
        let candidates = if request.first == 0 && request.nogoods.is_empty() { vec![only] } else { Vec::new() };
        Ok(Outcome::answer(Answer::Placements(candidates), 1))
    }
}

#[derive(Parser)]
struct Words {
    #[command(flatten)]
    member: MemberArgs,
}

/// Not only a test: it is how the foreign stage is started.
#[test]
fn this_program_is_the_foreign_stage_when_it_is_called_as_one() {
    let words: Vec<String> = std::env::args().collect();
    let Some(at) = words.iter().position(|word| word == "--") else {
        assert!(Words::try_parse_from(["--", "--nothing"]).is_err());
        return;
    };
    let member = Words::parse_from(&words[at..]).member;
    let make = |statement: &ProblemStatement| {
        let geometry = Geometry::new(&statement.problem).map_err(|error| error.to_string())?;
        Ok(Box::new(MiddleStage(geometry)) as Box<dyn Stage>)
    };
    let served = stage_process::run(&member, StageKind::Placement, "middle-of-region/1", &make);
    std::process::exit(i32::from(served.is_err()));
}

#[test]
fn t00_is_planned_with_a_placement_process_of_the_tests_own() {
    let folder = tempfile::tempdir().unwrap();
    let program = std::env::current_exe().unwrap();
    let test = "foreign_placement::this_program_is_the_foreign_stage_when_it_is_called_as_one";
    let command = format!("[{:?}, --exact, {test}, --nocapture, \"--\"]", program.to_string_lossy());
    let set = folder.path().join("set.yaml");
    std::fs::write(&set, format!("stages: {{placement: {{command: {command}}}}}\n")).unwrap();
    let ended = assert_cmd::Command::cargo_bin("mrtamp")
        .unwrap()
        .arg("plan")
        .arg(scene_path("t00_one_arm"))
        .args(["--out", "out", "--set"])
        .arg(&set)
        .current_dir(folder.path())
        .timeout(std::time::Duration::from_secs(120))
        .output()
        .unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let plan = plan::read_plan(&std::fs::read(folder.path().join("out/plan.json")).unwrap()).unwrap();
    assert!(plan.provenance.implementations.iter().any(|name| name.contains("middle-of-region/1")));
    let problem = scene("t00_one_arm");
    let detach = plan.events.iter().find(|event| event.kind == plan::EventKind::Detach).unwrap();
    let expected = middle(&problem, PairId(0)).world_from_object.translation.vector;
    let found = nalgebra::Vector3::from(detach.world_from_object.xyz);
    assert!((expected - found).norm() < 1e-9, "the object stands where the foreign stage put it");
}
