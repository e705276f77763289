//! What a failure of composite motion, or one whose causes nobody is told, is laid to.

use std::collections::BTreeSet;

use contract::{Decision, StageKind};
use model::PairId;
use plan::Cause;

use crate::candidate::Candidate;
use crate::conflict::{Choice, Conflict, Order, Stuck};
use crate::known::NoWay;
use crate::search::Search;

/// How often choices that have failed together may be met again before a candidate is given up.
const MEETINGS: u32 = 256;

impl Candidate<'_> {
    /// A later stage has failed: alternatives are chosen anew, told what the failure rests on or not.
    pub(crate) fn fall_back(
        &mut self,
        search: &mut Search<'_>,
        stage: StageKind,
        mut conflict: Conflict,
    ) -> Result<(), Stuck> {
        if !search.policy(stage).tells_causes() {
            conflict.choices = self.all_choices();
            // Composite motion has counted its failure.
            if stage != StageKind::Composite {
                conflict = self.less_patient(stage, conflict)?;
            }
        }
        conflict.orders = self.present_orders();
        let pairs: Vec<PairId> = conflict.pairs().collect();
        if self.exclude(&pairs, &conflict) {
            return Ok(());
        }
        self.failed_together.insert(self.chosen.clone(), conflict.clone());
        let because = conflict.first_cause();
        let pair = self.penalise(&pairs, conflict)?;
        let index = self.chosen(pair).map_or(0, |chosen| chosen.index);
        search.backtrack(StageKind::Transition, Decision::Alternative { pair, index }, because);
        Ok(())
    }

    /// Choices that have failed together are met again: they would fail again.
    pub(crate) fn meet_again(&mut self, conflict: Conflict) -> Result<(), Stuck> {
        self.meetings += 1;
        let pairs: Vec<PairId> = conflict.pairs().collect();
        if self.meetings > MEETINGS {
            return Err(self.given_up(StageKind::Transition, conflict));
        }
        self.penalise(&pairs, conflict).map(drop)
    }

    /// What rests on how one robot does one pair, or two in a row, is excluded like a mode without a way. Whether it does.
    fn exclude(&mut self, pairs: &[PairId], conflict: &Conflict) -> bool {
        let modes = self.skeleton.modes.iter().flatten();
        let of_pairs = modes.copied().find(|mode| {
            let ends: BTreeSet<PairId> = self.pairs_at_ends(mode).into_iter().flatten().collect();
            mode.pair.is_some() && ends == pairs.iter().copied().collect()
        });
        let Some(mode) = of_pairs else { return false };
        for pair in pairs {
            self.because[pair.index()] = conflict.first_cause();
        }
        let ends = self.present_ends(&mode);
        let choices = conflict.choices.iter().filter(|choice| matches!(choice, Choice::Pose(_))).copied().collect();
        let Conflict { orders, causes, proof, .. } = conflict.clone();
        self.known_mut(&mode).no_ways.push(NoWay { ends, certain: BTreeSet::new(), choices, orders, causes, proof });
        true
    }

    /// Makes the present alternative of one of some pairs dearer, or of all if there are none: of the pair least often
    /// chosen for it, of several the last. So pairs that exclude one another take turns. Where none has another one, the
    /// conflict is one of the poses.
    fn penalise(&mut self, pairs: &[PairId], mut conflict: Conflict) -> Result<PairId, Stuck> {
        let every = self.every_pair();
        let pairs = if pairs.is_empty() { &every } else { pairs };
        let has_choice = |pair: &&PairId| self.open[pair.index()].len() > 1;
        let turn = |pair: &&PairId| (self.turns[pair.index()], std::cmp::Reverse(**pair));
        let next = pairs.iter().filter(has_choice).min_by_key(turn).copied();
        let Some(pair) = next.filter(|_| !self.all_have_failed()) else {
            conflict.choices = self.skeleton.occupancies().map(Choice::Pose).collect();
            return Err(Stuck::Failed(conflict));
        };
        self.turns[pair.index()] += 1;
        *self.penalties.entry((pair, self.chosen[pair.index()])).or_insert(0) += 1;
        Ok(pair)
    }

    /// Whether all combinations of alternatives that are open have failed.
    fn all_have_failed(&self) -> bool {
        let is_open = |(pair, number): (usize, &usize)| self.open[pair].contains(number);
        let counts = |(chosen, failed): &(&Vec<usize>, &Conflict)| {
            self.hold(&failed.orders) && chosen.iter().enumerate().all(is_open)
        };
        let combinations = self.open.iter().fold(1, |product: usize, open| product.saturating_mul(open.len()));
        self.failed_together.iter().filter(counts).count() >= combinations
    }

    /// Counts a failure whose causes are not known; when there were too many, the whole placement is given up.
    pub(crate) fn less_patient(&mut self, stage: StageKind, conflict: Conflict) -> Result<Conflict, Stuck> {
        self.patience = self.patience.saturating_sub(1);
        if self.patience > 0 { Ok(conflict) } else { Err(self.given_up(stage, conflict)) }
    }

    /// The placement is given up, although not everything was tried. This proves nothing about fewer choices than all.
    pub(crate) fn given_up(&mut self, stage: StageKind, mut conflict: Conflict) -> Stuck {
        self.patience = 0;
        conflict.choices = self.skeleton.occupancies().map(Choice::Pose).collect();
        conflict.orders = self.present_orders();
        conflict.causes.count(Cause::Budget { stage: stage.name().to_owned() });
        Stuck::Failed(conflict)
    }

    fn all_choices(&self) -> BTreeSet<Choice> {
        let alternatives = self.every_pair().into_iter().map(Choice::Alternative);
        alternatives.chain(self.skeleton.occupancies().map(Choice::Pose)).collect()
    }

    fn present_orders(&self) -> BTreeSet<Order> {
        self.orders.iter().map(|order| (order.before, order.after)).collect()
    }
}
