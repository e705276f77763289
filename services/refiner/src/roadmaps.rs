//! Roadmaps for the present alternatives.

use contract::{
    Alternative, Answer, Job, ModeJob, Obstruction, PieceJob, PieceSpec, ProductRef, Reach, Request, StageKind,
};
use model::{Configuration, EndPolicy, Holding, PairId, RobotId};
use plan::{BodyRef, Cause};
use skeleton::{Mode, ModeKind, Occupancy, Presence};

use crate::asking::misfit;
use crate::candidate::{Candidate, Modes};
use crate::conflict::{Choice, Conflict, Stuck};
use crate::search::Search;

/// Roadmap of a mode.
#[derive(Clone, Debug)]
pub(crate) struct ModeAnswer {
    pub(crate) roadmap: ProductRef,
    pub(crate) shortest_s: f64,
    /// Possible poses that are in every way.
    pub(crate) in_the_way: Vec<Occupancy>,
}

/// An end of a mode: its configuration, and the arm piece that leads there unless the arm is folded.
struct ModeEnd {
    q: Configuration,
    arm: Option<Job>,
}

/// Jobs for the pieces of a mode.
struct ModePieces {
    holding: Option<Holding>,
    base: Option<Job>,
    start: ModeEnd,
    goal: ModeEnd,
}

impl ModePieces {
    /// Base, start and goal, in this order.
    fn slots(&self) -> [&Option<Job>; 3] {
        [&self.base, &self.start.arm, &self.goal.arm]
    }

    fn jobs(&self) -> impl Iterator<Item = &Job> {
        self.slots().into_iter().flatten()
    }
}

impl Candidate<'_> {
    /// Roadmaps of all modes; alternatives whose roadmaps do not connect are given up on the way.
    pub(crate) fn roadmaps(&mut self, search: &mut Search<'_>) -> Result<Modes, Stuck> {
        let modes: Vec<Mode> = self.skeleton.modes.iter().flatten().copied().collect();
        loop {
            match self.try_roadmaps(search, &modes)? {
                Ok(answers) => return Ok(self.by_robot(&modes, answers)),
                Err(conflict) => self.fall_back(search, StageKind::Roadmap, conflict)?,
            }
        }
    }

    fn by_robot(&self, modes: &[Mode], answers: Vec<ModeAnswer>) -> Modes {
        let mut by_robot: Modes = vec![Vec::new(); self.problem.robots.len()];
        modes.iter().zip(answers).for_each(|(mode, answer)| by_robot[mode.id.robot.index()].push(answer));
        by_robot
    }

    /// Asks for all pieces at once, then for all mode roadmaps at once. Of several conflicts that of the first mode counts.
    pub(crate) fn try_roadmaps(
        &self,
        search: &mut Search<'_>,
        modes: &[Mode],
    ) -> Result<Result<Vec<ModeAnswer>, Conflict>, Stuck> {
        let pieces = modes.iter().map(|mode| self.pieces(mode)).collect::<Result<Vec<_>, _>>()?;
        let wanted: Vec<Job> = pieces.iter().flat_map(ModePieces::jobs).cloned().collect();
        let mut outcomes = search.ask(&wanted)?.into_iter();
        let mut jobs = Vec::new();
        for (mode, pieces) in modes.iter().zip(&pieces) {
            let mut products = [None; 3];
            for (slot, piece) in products.iter_mut().zip(pieces.slots()) {
                let Some((piece, outcome)) = piece.as_ref().and_then(|piece| Some((piece, outcomes.next()?))) else {
                    continue;
                };
                match outcome.result {
                    Ok(Answer::Piece(product)) => *slot = Some(product),
                    Ok(_) => return Err(misfit(StageKind::Roadmap).into()),
                    Err(report) => {
                        let pair = Choice::Alternative(self.pair_of_piece(mode, piece));
                        return Ok(Err(Conflict::of([pair], &report.causes, Some(search.id(piece)))));
                    }
                }
            }
            jobs.push(self.mode_job(mode, pieces, products));
        }
        let mut answers = Vec::new();
        for ((mode, job), outcome) in modes.iter().zip(&jobs).zip(search.ask(&jobs)?) {
            match outcome.result {
                Ok(Answer::Mode { roadmap, shortest_s, in_the_way }) => {
                    let in_the_way = self.possible_poses(mode, &in_the_way);
                    answers.push(ModeAnswer { roadmap, shortest_s, in_the_way });
                }
                Ok(_) => return Err(misfit(StageKind::Roadmap).into()),
                Err(report) => {
                    let choices = self.without_way(mode, &report.causes);
                    return Ok(Err(Conflict::of(choices, &report.causes, Some(search.id(job)))));
                }
            }
        }
        Ok(Ok(answers))
    }

    fn mode_job(&self, mode: &Mode, pieces: &ModePieces, products: [Option<ProductRef>; 3]) -> Job {
        let [base, start_arm, goal_arm] = products;
        self.budgets.job(Request::Mode(ModeJob {
            mode: mode.id,
            holding: pieces.holding,
            start: pieces.start.q.clone(),
            goal: pieces.goal.q.clone(),
            base,
            start_arm,
            goal_arm,
            certain: self.obstructions(mode, Presence::Certain),
            possible: self.obstructions(mode, Presence::Possible),
            level: self.level,
        }))
    }

    pub(crate) fn obstructions(&self, mode: &Mode, wanted: Presence) -> Vec<Obstruction> {
        self.skeleton
            .occupancies()
            .filter(|occupancy| {
                let interval = self.skeleton.interval_of(*occupancy);
                self.is_placed(*occupancy) && self.skeleton.graph.presence(interval, mode.interval()) == wanted
            })
            .map(|occupancy| Obstruction { occupancy, standing: self.standing(occupancy) })
            .collect()
    }

    fn possible_poses(&self, mode: &Mode, indices: &[u32]) -> Vec<Occupancy> {
        let possible = self.obstructions(mode, Presence::Possible);
        indices.iter().filter_map(|i| possible.get(*i as usize)).map(|obstruction| obstruction.occupancy).collect()
    }

    /// What a mode without a way depends on: the alternatives at its ends, or at the one that is named, and the certain poses
    /// that are in the way.
    fn without_way(&self, mode: &Mode, causes: &[(Cause, u64)]) -> Vec<Choice> {
        let named = |occupancy: &Occupancy| {
            let name = &self.problem.movable[occupancy.object.index()].name;
            causes.iter().any(|(cause, _)| {
                let Cause::NoPath { blocking, .. } = cause else { return false };
                blocking.iter().any(|body| matches!(body, BodyRef::Object(object) if object == name))
            })
        };
        let certain = self.obstructions(mode, Presence::Certain).into_iter().map(|obstruction| obstruction.occupancy);
        let mut pairs: Vec<PairId> =
            mode.begins.map(|event| event.pair).into_iter().chain([self.own_pair(mode)]).collect();
        let is_named = |id: &PairId| {
            let name = Some(&self.problem.pair(*id).name);
            causes.iter().any(|(cause, _)| matches!(cause, Cause::NoPath { pair, .. } if pair.as_ref() == name))
        };
        if pairs.iter().any(is_named) {
            pairs.retain(is_named);
        }
        certain.filter(named).map(Choice::Pose).chain(pairs.into_iter().map(Choice::Alternative)).collect()
    }

    /// The pair that a mode belongs to; a closing return to the last one.
    fn own_pair(&self, mode: &Mode) -> PairId {
        let last = self.problem.pairs_of_robot(mode.id.robot).last();
        mode.pair.or(last).unwrap_or(PairId(0))
    }

    /// The pair whose reach a piece belongs to: the previous one's, where a transit begins at a placed object.
    fn pair_of_piece(&self, mode: &Mode, piece: &Job) -> PairId {
        let own = self.own_pair(mode);
        let previous = mode.begins.map(|event| event.pair);
        let at_previous = previous
            .is_some_and(|pair| self.releasing_end(pair).is_ok_and(|released| released.arm.as_ref() == Some(piece)));
        if at_previous { previous.unwrap_or(own) } else { own }
    }

    fn pieces(&self, mode: &Mode) -> Result<ModePieces, Stuck> {
        let robot = self.problem.robot(mode.id.robot);
        let holding = match mode.pair {
            Some(pair) if mode.is_holding() => Some(self.holding(pair)?),
            _ => None,
        };
        let base = robot.base.as_ref().map(|_| self.piece(mode.id.robot, holding, PieceSpec::Base));
        let (start, goal) = match (mode.kind, mode.pair) {
            (ModeKind::Transit, Some(pair)) => (self.empty_start(mode)?, self.picking_end(pair)?),
            (ModeKind::Transfer, Some(pair)) => {
                let chosen = self.chosen(pair)?;
                (self.holding_end(pair, chosen, &chosen.pick), self.holding_end(pair, chosen, &chosen.place))
            }
            _ => (self.empty_start(mode)?, self.closing_end(mode)?),
        };
        Ok(ModePieces { holding, base, start, goal })
    }

    /// Where an empty-handed mode begins: at the object just placed, or at the robot's start.
    fn empty_start(&self, mode: &Mode) -> Result<ModeEnd, Stuck> {
        match mode.begins {
            Some(event) => self.releasing_end(event.pair),
            None => Ok(self.start_end(mode.id.robot)),
        }
    }

    fn start_end(&self, robot: RobotId) -> ModeEnd {
        let model = self.problem.robot(robot);
        let base = model.base_len();
        let folded = model.start[base..] == model.home[..];
        let spec = || PieceSpec::Arm {
            stand: model.start[..base].to_vec(),
            near: vec![model.start.clone()],
            lift_up: 0,
            support: None,
            touch: None,
        };
        ModeEnd { q: model.start.clone(), arm: (!folded).then(|| self.piece(robot, None, spec())) }
    }

    /// Where a closing return ends: at the start configuration, or with the arm home at the last stand.
    fn closing_end(&self, mode: &Mode) -> Result<ModeEnd, Stuck> {
        let robot = mode.id.robot;
        match (self.problem.end_policies[robot.index()], mode.begins) {
            (EndPolicy::Stay, Some(event)) => {
                let stand = &self.chosen(event.pair)?.place.stand;
                Ok(ModeEnd { q: [stand.as_slice(), &self.problem.robot(robot).home].concat(), arm: None })
            }
            _ => Ok(self.start_end(robot)),
        }
    }

    /// Empty-handed at the object that a pair is about to grasp.
    fn picking_end(&self, pair: PairId) -> Result<ModeEnd, Stuck> {
        Ok(self.empty_end(pair, &self.chosen(pair)?.pick, self.skeleton.picked(self.problem, pair)))
    }

    /// Empty-handed at the object that a pair has just released.
    fn releasing_end(&self, pair: PairId) -> Result<ModeEnd, Stuck> {
        Ok(self.empty_end(pair, &self.chosen(pair)?.place, self.skeleton.placed(self.problem, pair)))
    }

    fn empty_end(&self, pair: PairId, reach: &Reach, object: Occupancy) -> ModeEnd {
        let spec = PieceSpec::Arm {
            stand: reach.stand.clone(),
            near: reach.approach.clone(),
            lift_up: 0,
            support: None,
            touch: Some(self.standing(object)),
        };
        ModeEnd { q: reach.at_object.clone(), arm: Some(self.piece(self.problem.pair(pair).robot, None, spec)) }
    }

    fn holding_end(&self, pair: PairId, chosen: &Alternative, reach: &Reach) -> ModeEnd {
        let pair = self.problem.pair(pair);
        let spec = PieceSpec::Arm {
            stand: reach.stand.clone(),
            near: reach.lift.clone(),
            lift_up: reach.lift_up,
            support: Some(reach.support),
            touch: None,
        };
        let holding = Holding { object: pair.object, grasp: chosen.grasp };
        ModeEnd { q: reach.at_object.clone(), arm: Some(self.piece(pair.robot, Some(holding), spec)) }
    }

    fn holding(&self, pair: PairId) -> Result<Holding, Stuck> {
        Ok(Holding { object: self.problem.pair(pair).object, grasp: self.chosen(pair)?.grasp })
    }

    fn piece(&self, robot: RobotId, holding: Option<Holding>, spec: PieceSpec) -> Job {
        self.budgets.job(Request::Piece(PieceJob { robot, holding, level: self.level, spec }))
    }
}
