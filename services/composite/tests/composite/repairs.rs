//! Repairs on discs, through the stage: free of contact in every sampled instant, and commitment goes on behind them.

use contract::{Answer, Composition, Interrupted, Product, ProductRef};
use model::RobotId;
use skeleton::ModeId;

use crate::oracle::assert_free;
use crate::toys::{Errand, Toy, World, mode};

fn roadmaps(toy: &Toy) -> Vec<Vec<ProductRef>> {
    let put = |mode: &skeleton::Mode| toy.put(&Product::Mode(toy.roadmap(mode.id)));
    toy.skeleton().modes.iter().map(|modes| modes.iter().map(put).collect()).collect()
}

fn repair(toy: &Toy, prefix: Option<ProductRef>, mode: ModeId, robots: &[usize]) -> Composition {
    let robots = robots.iter().copied().map(RobotId::at).collect();
    Composition::Repair { prefix, mode, robots, roadmaps: roadmaps(toy) }
}

/// Robot 2 stands in a corridor between robot 1 and its work; there is a bay beside it, with its own work at the end.
fn in_the_way() -> Toy {
    let mut world = World::grid(5, 1, 0.7);
    world.points.extend([[1.4, 0.8], [1.4, 1.6]]);
    world.ways.extend([(2, 5), (5, 6)]);
    world.starts = vec![0, 2];
    world.objects = vec![4, 6];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 4, to: 4 }, Errand { robot: 1, object: 1, from: 6, to: 6 }];
    world.build()
}

#[test]
fn a_robot_that_has_not_begun_makes_room_and_commitment_goes_on_behind_it() {
    let toy = in_the_way();
    let outcome = toy.ask(&toy.job(repair(&toy, None, mode(0, 0), &[0, 1]))).unwrap();
    let Ok(Answer::Repaired { prefix, modes }) = outcome.result else { panic!("{outcome:?}") };
    let Product::Prefix(made) = toy.get(prefix) else { panic!("no prefix") };
    assert!(made.tails.iter().any(|tail| tail.robot == RobotId::at(1)), "robot 2 did not move: {made:?}");
    assert_eq!(modes, [(mode(0, 0), made.commitments[0].event_s)]);
    let commit =
        |prefix, next| toy.commit(Some(prefix), next).unwrap_or_else(|report| panic!("{next:?}: {report:?}")).0;
    let mut last = commit(prefix, mode(0, 1));
    // It stands in the way back again.
    assert!(toy.commit(Some(last), mode(0, 2)).is_err());
    let outcome = toy.ask(&toy.job(repair(&toy, Some(last), mode(0, 2), &[0, 1]))).unwrap();
    let Ok(Answer::Repaired { prefix, .. }) = outcome.result else { panic!("{outcome:?}") };
    last = prefix;
    // Robot 2 is committed from the beginning anew, among motion that counts on its making room.
    for next in [mode(1, 0), mode(1, 1), mode(1, 2)] {
        last = commit(last, next);
    }
    assert!(toy.is_complete(Some(last)));
    assert_free(&toy, &toy.commitments(last), "in the way");
    toy.assemble(last);
}

#[test]
fn who_may_not_move_stays_in_the_way() {
    let toy = in_the_way();
    let outcome = toy.ask(&toy.job(repair(&toy, None, mode(0, 0), &[0]))).unwrap();
    let report = outcome.result.unwrap_err();
    let names = ["r1".to_owned(), "r2".to_owned()];
    let told = |cause: &plan::Cause| matches!(cause, plan::Cause::Deadlock { robots } if *robots == names);
    assert!(report.causes.iter().any(|(cause, _)| told(cause)), "{report:?}");
}

#[test]
fn repairs_that_cannot_be_are_refused() {
    let toy = in_the_way();
    for (mode, robots) in [(mode(0, 1), &[0, 1][..]), (mode(0, 0), &[1]), (mode(7, 0), &[0]), (mode(0, 0), &[])] {
        let refused = toy.ask(&toy.job(repair(&toy, None, mode, robots)));
        assert!(matches!(refused, Err(Interrupted::Unfit(_))), "{mode:?} by {robots:?}: {refused:?}");
    }
    let complete =
        Composition::Repair { prefix: None, mode: mode(0, 0), robots: vec![RobotId::at(0)], roadmaps: vec![] };
    assert!(matches!(toy.ask(&toy.job(complete)), Err(Interrupted::Unfit(_))));
}
