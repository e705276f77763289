//! Roadmaps for the present alternatives.

use std::collections::BTreeSet;

use contract::{
    Alternative, Answer, CauseTally, FailureReport, Job, JobId, ModeJob, Obstruction, PieceJob, PieceSpec, ProductRef,
    Reach, Request, StageKind,
};
use model::{Configuration, EndPolicy, Holding, PairId, RobotId};
use skeleton::{Mode, ModeKind, Occupancy};

use crate::around::Around;
use crate::asking::misfit;
use crate::candidate::Candidate;
use crate::conflict::{Choice, Conflict, Stuck};
use crate::known::{ModeAnswer, NoWay};
use crate::search::Search;
use crate::ways::Scene;

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
    /// Looks at modes as the alternatives at their ends are chosen: asks for all pieces at once, then for all roadmaps at
    /// once, and notes what is found.
    pub(crate) fn look(&mut self, search: &mut Search<'_>, scene: &Scene, modes: &[Mode]) -> Result<(), Stuck> {
        let pieces = modes.iter().map(|mode| self.pieces(mode)).collect::<Result<Vec<_>, _>>()?;
        let wanted: Vec<Job> = pieces.iter().flat_map(ModePieces::jobs).cloned().collect();
        let mut outcomes = search.ask(&wanted)?.into_iter();
        let (mut jobs, mut failures) = (Vec::new(), Vec::new());
        for (mode, pieces) in modes.iter().zip(&pieces) {
            let (mut products, mut is_whole) = ([None; 3], true);
            for (slot, piece) in products.iter_mut().zip(pieces.slots()) {
                let Some((piece, outcome)) = piece.as_ref().and_then(|piece| Some((piece, outcomes.next()?))) else {
                    continue;
                };
                match outcome.result {
                    Ok(Answer::Piece(product)) => *slot = Some(product),
                    Ok(_) => return Err(misfit(StageKind::Roadmap).into()),
                    Err(mut report) => {
                        is_whole = false;
                        report.rests_on = Some(vec![Choice::Alternative(self.pair_of_piece(mode, piece))]);
                        failures.push((*mode, search.id(piece), report));
                    }
                }
            }
            if is_whole {
                jobs.push((*mode, self.mode_job(scene.about(mode), mode, pieces, products)));
            }
        }
        let asked: Vec<Job> = jobs.iter().map(|(_, job)| job.clone()).collect();
        for ((mode, job), outcome) in jobs.into_iter().zip(search.ask(&asked)?) {
            match outcome.result {
                Ok(Answer::Mode { roadmap, shortest_s, in_the_way }) => {
                    let around = scene.about(&mode).clone();
                    let in_the_way = in_the_way.iter().filter_map(|i| around.possible.iter().nth(*i as usize)).copied();
                    let answer = ModeAnswer { roadmap, shortest_s, in_the_way: in_the_way.collect() };
                    let ends = self.present_ends(&mode);
                    self.known_mut(&mode).add_way(ends, around, answer);
                }
                Ok(_) => return Err(misfit(StageKind::Roadmap).into()),
                Err(report) => failures.push((mode, search.id(&job), report)),
            }
        }
        self.note_failures(search, scene, failures)
    }

    /// Notes modes without a way; where causes are told to nobody, the first of them fails all that is chosen.
    fn note_failures(
        &mut self,
        search: &mut Search<'_>,
        scene: &Scene,
        failures: Vec<(Mode, JobId, FailureReport)>,
    ) -> Result<(), Stuck> {
        let tells_causes = search.policy(StageKind::Roadmap).tells_causes();
        for (mode, proof, report) in failures {
            if !tells_causes {
                let conflict = Conflict::of([], &report.causes, Some(proof));
                return self.fall_back(search, StageKind::Roadmap, conflict);
            }
            let no_way = self.no_way(&mode, scene.about(&mode), proof, &report);
            for pair in self
                .pairs_at_ends(&mode)
                .into_iter()
                .zip(no_way.ends)
                .filter_map(|(pair, end)| pair.filter(|_| end.is_some()))
            {
                self.because[pair.index()] = report.causes.first().map(|(cause, _)| cause.clone());
            }
            self.known_mut(&mode).no_ways.push(no_way);
        }
        Ok(())
    }

    fn no_way(&self, mode: &Mode, around: &Around, proof: JobId, report: &FailureReport) -> NoWay {
        let mut ends = self.present_ends(mode);
        let mut certain = around.certain.clone();
        if let Some(rests_on) = &report.rests_on {
            for (end, pair) in ends.iter_mut().zip(self.pairs_at_ends(mode)) {
                end.take_if(|_| pair.is_none_or(|pair| !rests_on.contains(&Choice::Alternative(pair))));
            }
            certain.retain(|pose| rests_on.contains(&Choice::Pose(*pose)));
        }
        let mut causes = CauseTally::default();
        causes.count_all(&report.causes);
        NoWay { ends, certain, choices: BTreeSet::new(), orders: BTreeSet::new(), causes, proof: Some(proof) }
    }

    fn mode_job(&self, around: &Around, mode: &Mode, pieces: &ModePieces, products: [Option<ProductRef>; 3]) -> Job {
        let [base, start_arm, goal_arm] = products;
        self.budgets.job(Request::Mode(ModeJob {
            mode: mode.id,
            holding: pieces.holding,
            start: pieces.start.q.clone(),
            goal: pieces.goal.q.clone(),
            base,
            start_arm,
            goal_arm,
            certain: self.obstructions(&around.certain),
            possible: self.obstructions(&around.possible),
            level: self.level,
        }))
    }

    fn obstructions(&self, poses: &BTreeSet<Occupancy>) -> Vec<Obstruction> {
        poses.iter().map(|pose| Obstruction { occupancy: *pose, standing: self.standing(*pose) }).collect()
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
