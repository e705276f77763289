//! The hops of an object: in which order its pairs carry it on from region to region.

use super::placing::is_over;
use super::task::{Nouns, Pairs};
use crate::problem_error::{FindingKind, Found, Source};
use crate::{GivenOrdering, ObjectId, RegionId};

/// Most pairs of one object.
const MAX_HOPS: usize = 500;
/// Most steps of the search for the order of one object's pairs.
const MAX_STEPS: u32 = 100_000;

/// Numbers the hops of an object from 1; `own` are its pairs.
///
/// An order must begin where the object stands, connect region to region and keep each robot's order. Where there are
/// several such orders, the given orderings between these pairs must leave one.
pub(crate) fn number_hops(
    source: &Source,
    pairs: &mut Pairs,
    nouns: &Nouns<'_>,
    object: ObjectId,
    own: &[usize],
    orderings: &[GivenOrdering],
) -> Found<()> {
    if own.len() > MAX_HOPS {
        let message = format!("{} pairs move `{}`", own.len(), nouns.movable[object.index()].name);
        return Err(source
            .finding(pairs.spans[own[0]], FindingKind::TooLarge, message)
            .help(format!("give at most {MAX_HOPS} to one object")));
    }
    let start = start_regions(nouns, object);
    let free = search(pairs, own, &[], &start);
    let given = if free.found.len() > 1 { search(pairs, own, orderings, &start).found } else { Vec::new() };
    let orders = match (given.len(), free.found.len()) {
        // The given orderings contradict one another, which is told later as the cycle that it is.
        (0, 2..) => &free.found[..1],
        (0, _) => &free.found[..],
        _ => &given[..],
    };
    match orders {
        [only] => {
            for (hop, pair) in only.iter().enumerate() {
                pairs.pairs[*pair].hop = u32::try_from(hop + 1).unwrap_or(u32::MAX);
            }
            Ok(())
        }
        [one, other, ..] => Err(ambiguous(source, pairs, &nouns.movable[object.index()].name, one, other)),
        [] if free.steps > MAX_STEPS => Err(source
            .finding(pairs.spans[own[0]], FindingKind::BadTask, "too many ways to order the pairs of this object")
            .help("add orderings between them until their order is plain")),
        [] => Err(broken_chain(source, pairs, nouns, object, own, &free.longest)),
    }
}

/// The regions that the object stands in at the start; `None` where it stands in none, which is told elsewhere.
fn start_regions(nouns: &Nouns<'_>, object: ObjectId) -> Option<Vec<RegionId>> {
    let object = &nouns.movable[object.index()];
    let over: Vec<RegionId> =
        (0..nouns.regions.len()).filter(|i| is_over(object, &nouns.regions[*i])).map(RegionId::at).collect();
    (!over.is_empty()).then_some(over)
}

struct SearchEnd {
    /// Complete orders; two are enough to know that there is not only one.
    found: Vec<Vec<usize>>,
    longest: Vec<usize>,
    steps: u32,
}

struct Search<'a> {
    pairs: &'a Pairs,
    own: &'a [usize],
    /// For each of `own`, the positions in `own` that must come before it.
    before: Vec<Vec<usize>>,
    used: Vec<bool>,
    chain: Vec<usize>,
    end: SearchEnd,
}

fn search(pairs: &Pairs, own: &[usize], orderings: &[GivenOrdering], start: &Option<Vec<RegionId>>) -> SearchEnd {
    let robot = |position: usize| pairs.pairs[own[position]].robot;
    let mut before: Vec<Vec<usize>> = (0..own.len())
        .map(|later| (0..later).rev().find(|earlier| robot(*earlier) == robot(later)).into_iter().collect())
        .collect();
    let position = |pair: crate::PairId| own.iter().position(|own| *own == pair.index());
    for ordering in orderings {
        if let (Some(first), Some(later)) = (position(ordering.before.0), position(ordering.after.0))
            && first != later
        {
            before[later].push(first);
        }
    }
    let end = SearchEnd { found: Vec::new(), longest: Vec::new(), steps: 0 };
    let mut search = Search { pairs, own, before, used: vec![false; own.len()], chain: Vec::new(), end };
    search.extend(start.as_deref());
    search.end
}

impl Search<'_> {
    /// Tries every pair that may come next where the object now is (`None`: anywhere).
    fn extend(&mut self, at: Option<&[RegionId]>) {
        self.end.steps += 1;
        if self.chain.len() > self.end.longest.len() {
            self.end.longest.clone_from(&self.chain);
        }
        if self.chain.len() == self.own.len() {
            self.end.found.push(self.chain.clone());
            return;
        }
        for next in 0..self.own.len() {
            if self.end.found.len() > 1 || self.end.steps > MAX_STEPS {
                return;
            }
            let pair = &self.pairs.pairs[self.own[next]];
            let here = at.is_none_or(|regions| regions.contains(&pair.from));
            if here && !self.used[next] && self.before[next].iter().all(|first| self.used[*first]) {
                self.used[next] = true;
                self.chain.push(self.own[next]);
                self.extend(Some(&[pair.to]));
                self.chain.pop();
                self.used[next] = false;
            }
        }
    }
}

fn ambiguous(source: &Source, pairs: &Pairs, object: &str, one: &[usize], other: &[usize]) -> Box<crate::Finding> {
    let at = one.iter().zip(other).position(|(a, b)| a != b).unwrap_or(0);
    let (a, b) = (&pairs.pairs[one[at]].name, &pairs.pairs[other[at]].name);
    source
        .finding(
            pairs.spans[one[at]],
            FindingKind::BadTask,
            format!("`{object}` may be moved by `{a}` or by `{b}` first"),
        )
        .note(source, pairs.spans[other[at]], "the other")
        .help(format!("say which: `orderings: [{{before: {a} release, after: {b} grasp}}]`, or the reverse"))
}

fn broken_chain(
    source: &Source,
    pairs: &Pairs,
    nouns: &Nouns<'_>,
    object: ObjectId,
    own: &[usize],
    longest: &[usize],
) -> Box<crate::Finding> {
    let object = &nouns.movable[object.index()];
    let region = |region: RegionId| &nouns.regions[region.index()].name;
    let stuck = own.iter().find(|pair| !longest.contains(pair)).copied().unwrap_or(own[0]);
    let (name, from) = (&pairs.pairs[stuck].name, region(pairs.pairs[stuck].from));
    let finding = |whereabouts: String| {
        let message = format!("`{name}` picks `{}` in `{from}`, {whereabouts}", object.name);
        source.finding(pairs.spans[stuck], FindingKind::BadTask, message)
    };
    match longest.last() {
        None => finding("where it does not stand at the start".to_owned())
            .help("let its first pair pick it where it stands, or correct its pose"),
        Some(last) => {
            let (before, to) = (&pairs.pairs[*last].name, region(pairs.pairs[*last].to));
            finding(format!("but `{before}` leaves it in `{to}`"))
                .note(source, pairs.spans[*last], "leaves it elsewhere")
                .help("each pair of an object must pick it where the one before it placed it")
        }
    }
}
