//! Two final placements that block one another whichever comes first: learnt of all samples at once, and a pose that
//! nothing keeps away is reckoned with.

use contract::{Answer, Choice, Digest, JobId, LedgerEntry, Literal, ModeJob, Outcome, ProductRef, Request};
use model::{ObjectId, PairId};
use plan::PairEnd;
use refiner::End;
use skeleton::Occupancy;

use crate::scripted::{Rule, Scripted};
use crate::worlds::{Rates, SAMPLES, World, decode, fails_for, told_by};

/// Nothing fails.
const NEVER: Rates = Rates { roadmap: 0, reach: 0, grasp: 0, transition: 0, overlap: 0, alternatives: 3 };

/// Where the second object of the swap ends, and the first.
const FINAL: [Occupancy; 2] = [Occupancy { object: ObjectId(1), hop: 1 }, Occupancy { object: ObjectId(0), hop: 1 }];

fn obstructed(job: &ModeJob, index: u32) -> Outcome {
    let digest = Digest::of("test", &[&contract::encode_canonical(job)]);
    let roadmap = ProductRef { digest, made_by: JobId(digest) };
    Outcome::answer(Answer::Mode { roadmap, shortest_s: 1.0, in_the_way: vec![index] }, 1)
}

/// Where both objects end at samples of the same number, neither can be released beside the other.
fn equal_samples_exclude_one_another(request: &Request) -> Option<Outcome> {
    match request {
        Request::GraspBlockers(job) if job.end == PairEnd::Place => {
            let own = told_by(&job.world_from_object).1;
            let blocks = |other: &model::Standing| told_by(&other.world_from_object) == (1, own);
            Some(Outcome::answer(Answer::Blocked(job.standing.iter().map(blocks).collect()), 1))
        }
        Request::Blockers(job) => {
            let (way, end) = decode(job.reach.at_object[0])?;
            let blocks = |other: &model::Standing| end == 1 && told_by(&other.world_from_object) == (1, way.samples[1]);
            Some(Outcome::answer(Answer::Blocked(job.standing.iter().map(blocks).collect()), 1))
        }
        Request::Mode(job) if job.mode.step == 1 => {
            let (own, _) = decode(job.goal[0])?;
            let other = FINAL[job.mode.robot.index()];
            let blocks = |o: &contract::Obstruction| {
                o.occupancy == other && told_by(&o.standing.world_from_object).1 == own.samples[1]
            };
            if job.certain.iter().any(blocks) {
                return Some(fails_for(vec![Choice::Pose(other), Choice::Alternative(PairId::at(own.pair))]));
            }
            let index = job.possible.iter().position(blocks)?;
            Some(obstructed(job, index as u32))
        }
        _ => None,
    }
}

#[test]
fn placements_that_block_one_another_whichever_comes_first_are_excluded_for_all_samples_at_once() {
    let world = World::new("t09_swap", 0, NEVER);
    let rules: Vec<Rule> =
        std::iter::once(Box::new(equal_samples_exclude_one_another) as Rule).chain(world.rules()).collect();
    let mut stages = Scripted::new(&world.statement, rules);
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }), "{:?}", run.end);
    let nogoods: Vec<Vec<Vec<Literal>>> = stages
        .asked
        .iter()
        .filter_map(|job| match &job.request {
            Request::Placement(job) => Some(job.nogoods.clone()),
            _ => None,
        })
        .collect();
    assert_eq!(nogoods.len(), 2, "the first candidate has equal samples, the second has not");
    let learnt: Vec<Vec<Literal>> = run
        .ledger
        .entries
        .iter()
        .filter_map(|entry| match entry {
            LedgerEntry::Learnt(nogood) => Some(nogood.literals.clone()),
            _ => None,
        })
        .collect();
    for sample in 0..SAMPLES {
        let mut both = FINAL.map(|occupancy| Literal::Pose { occupancy, sample }).to_vec();
        both.sort_by_key(|literal| format!("{literal:?}"));
        let says_so = |nogood: &Vec<Literal>| {
            let mut nogood = nogood.clone();
            nogood.sort_by_key(|literal| format!("{literal:?}"));
            nogood == both
        };
        assert!(nogoods[1].iter().any(says_so), "sample {sample}: {:?}", nogoods[1]);
        assert!(learnt.iter().any(says_so), "sample {sample}: {learnt:?}");
    }
    let of_equal = |nogood: &Vec<Literal>| {
        let says = |sample| FINAL.iter().all(|pose| nogood.contains(&Literal::Pose { occupancy: *pose, sample }));
        (0..SAMPLES).any(says)
    };
    assert!(nogoods[1].iter().all(of_equal), "more than equal samples is excluded: {:?}", nogoods[1]);
}

#[test]
fn a_pose_that_no_ordering_keeps_away_is_reckoned_with_and_another_alternative_is_found() {
    let has_others = |world: &std::rc::Rc<World>| world.alternatives(0, [0, 0]) > 1;
    let world = (0..).map(|seed| World::new("t09_swap", seed, NEVER)).find(has_others).unwrap();
    let [last_of_other, own_last] = FINAL;
    let rule: Rule = Box::new(move |request| match request {
        // The second robot cannot release where the first one's object stands already.
        Request::Blockers(job) => {
            let (way, end) = decode(job.reach.at_object[0])?;
            let blocks = |other: &model::Standing| {
                (way.pair, end) == (1, 1) && other.object == own_last.object && told_by(&other.world_from_object).0 == 1
            };
            Some(Outcome::answer(Answer::Blocked(job.standing.iter().map(blocks).collect()), 1))
        }
        Request::Mode(job) if (job.mode.robot.0, job.mode.step) == (0, 1) => {
            let (way, _) = decode(job.goal[0])?;
            let is_other = |o: &contract::Obstruction| o.occupancy == last_of_other;
            if job.certain.iter().any(is_other) {
                let rests_on = vec![Choice::Pose(last_of_other), Choice::Alternative(PairId(0))];
                return (way.index < 1).then(|| fails_for(rests_on));
            }
            let index = job.possible.iter().position(is_other)?;
            Some(obstructed(job, index as u32))
        }
        _ => None,
    });
    let rules: Vec<Rule> = std::iter::once(rule).chain(world.rules()).collect();
    let mut stages = Scripted::new(&world.statement, rules);
    let run = stages.run();
    let of_mode = |job: &contract::Job| match &job.request {
        Request::Mode(job) if (job.mode.robot.0, job.mode.step) == (0, 1) => {
            Some((decode(job.goal[0]).unwrap().0.index, job.certain.iter().any(|o| o.occupancy == last_of_other)))
        }
        _ => None,
    };
    let asked: Vec<(u32, bool)> = stages.asked.iter().filter_map(of_mode).collect();
    assert!(matches!(run.end, End::Solved { .. }), "{:?}", run.end);
    let reckoned = asked.iter().position(|(_, certain)| *certain).unwrap();
    assert!(asked[..reckoned].iter().all(|(_, certain)| !certain) && reckoned > 0, "{asked:?}");
    assert!(asked[reckoned..].iter().all(|(_, certain)| *certain), "{asked:?}");
    assert_eq!(asked.last(), Some(&(1, true)), "{asked:?}");
    assert_eq!(stages.count(|request| matches!(request, Request::Placement(_))), 1);
}
