//! `Drrt` jobs.

use contract::{
    Answer, Assignment, Commitment, Interrupted, JobContext, ModeRoadmap, Outcome, Prefix, Product, ProductRef,
};
use skeleton::Skeleton;

use crate::{Scene, load_prefix};

/// Answers a `Drrt` job: commitments for all that is left after `prefix`.
///
/// # Errors
/// [`Interrupted`].
pub fn refine(
    scene: &Scene,
    assignment: &Assignment,
    prefix: Option<ProductRef>,
    roadmaps: &[Vec<ProductRef>],
    context: &mut JobContext<'_>,
) -> Result<Outcome, Interrupted> {
    let done = load_prefix(context, prefix)?;
    done.check(scene)?;
    let skeleton = Skeleton { graph: scene.graph(assignment)?, ..scene.skeleton.clone() };
    let load = |of_robot: &Vec<ProductRef>| of_robot.iter().map(|wanted| load_roadmap(wanted, context)).collect();
    let roadmaps: Vec<Vec<ModeRoadmap>> = roadmaps.iter().map(load).collect::<Result<_, _>>()?;
    check_holdings(scene, assignment, &roadmaps)?;
    let found = super::drrt(&scene.statement, &skeleton, assignment, &done, &roadmaps, &scene.conflicts, context)?;
    let commitments = match found {
        Ok(commitments) => commitments,
        Err(report) => return Ok(Outcome { result: Err(report), work: context.spent() }),
    };
    let ends_s = |c: &Commitment| c.tail.last().map_or(c.event_s, |last| last.ends_s);
    let all = || done.commitments.iter().chain(&commitments);
    let event_s = all().map(|c| c.event_s).fold(0.0, f64::max);
    let tail_s = all().map(ends_s).fold(0.0, f64::max);
    let prefix = context.publish(&Product::Prefix(Prefix { parent: prefix, commitments, tails: Vec::new() }))?;
    Ok(Outcome::answer(Answer::Committed { prefix, event_s, tail_s }, context.spent()))
}

/// The roadmap of a mode.
pub(crate) fn load_roadmap(wanted: &ProductRef, context: &JobContext<'_>) -> Result<ModeRoadmap, Interrupted> {
    match context.product(wanted)? {
        Product::Mode(roadmap) => Ok(roadmap),
        _ => Err(Interrupted::Unfit(format!("product {:?} is no roadmap of a mode", wanted.digest))),
    }
}

/// Whether every roadmap holds what its mode holds.
pub(crate) fn check_holdings(
    scene: &Scene,
    assignment: &Assignment,
    roadmaps: &[Vec<ModeRoadmap>],
) -> Result<(), Interrupted> {
    for (modes, roadmaps) in scene.skeleton.modes.iter().zip(roadmaps) {
        for (mode, roadmap) in modes.iter().zip(roadmaps) {
            let pair = mode.pair.filter(|_| mode.is_holding());
            let fits = match (pair, roadmap.holding) {
                (None, holding) => holding.is_none(),
                (Some(pair), holding) => holding.is_some_and(|holding| {
                    holding.object == scene.problem().pair(pair).object
                        && assignment.grasps.get(pair.index()) == Some(&holding.grasp)
                }),
            };
            if !fits {
                return Err(Interrupted::Unfit(format!("the roadmap of {:?} holds something else", mode.id)));
            }
        }
    }
    Ok(())
}
