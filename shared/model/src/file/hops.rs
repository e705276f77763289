//! The hops of an object: in which order its pairs carry it on from region to region.

use super::task::{Nouns, Pairs};
use crate::problem_error::{FindingKind, Found, Source};
use crate::{GivenOrdering, ObjectId, RegionId};

/// Most steps of the search for the order of one object's pairs.
const MAX_STEPS: u32 = 100_000;

/// Numbers an object's hops from 1.
///
/// An order must begin where the first pair says (checked against the start pose elsewhere), connect region to region,
/// keep each robot's order, and keep the given orderings between these pairs. It must be the only one.
pub(crate) fn number_hops(
    source: &Source,
    pairs: &mut Pairs,
    nouns: &Nouns<'_>,
    object: ObjectId,
    orderings: &[GivenOrdering],
) -> Found<()> {
    let own: Vec<usize> = (0..pairs.pairs.len()).filter(|i| pairs.pairs[*i].object == object).collect();
    if own.is_empty() {
        return Ok(());
    }
    let start = start_region(nouns, object);
    let mut search =
        Search { pairs, own: &own, orderings, chain: Vec::new(), longest: Vec::new(), found: Vec::new(), steps: 0 };
    search.extend(start);
    let (found, longest, steps) = (search.found, search.longest, search.steps);
    if let [only] = found.as_slice() {
        for (hop, pair) in only.iter().enumerate() {
            pairs.pairs[*pair].hop = u32::try_from(hop + 1).unwrap_or(u32::MAX);
        }
        return Ok(());
    }
    let name = &nouns.movable[object.index()].name;
    if let [one, other, ..] = found.as_slice() {
        let at = one.iter().zip(other).position(|(a, b)| a != b).unwrap_or(0);
        let (a, b) = (&pairs.pairs[one[at]].name, &pairs.pairs[other[at]].name);
        return Err(source
            .finding(
                pairs.spans[one[at]],
                FindingKind::BadTask,
                format!("`{name}` may move by `{a}` or by `{b}` first"),
            )
            .note(source, pairs.spans[other[at]], "the other")
            .help(format!("say which: `orderings: [{{before: {a} release, after: {b} grasp}}]` or the reverse")));
    }
    Err(broken_chain(source, pairs, nouns, object, &own, &longest, steps))
}

/// The region that the object stands in at the start, where it is in one.
fn start_region(nouns: &Nouns<'_>, object: ObjectId) -> Option<Vec<RegionId>> {
    let object = &nouns.movable[object.index()];
    let regions = (0..nouns.regions.len()).filter(|i| super::placing::stands_in(object, &nouns.regions[*i], f64::MAX));
    let regions: Vec<RegionId> = regions.map(RegionId::at).collect();
    (!regions.is_empty()).then_some(regions)
}

struct Search<'a> {
    pairs: &'a Pairs,
    own: &'a [usize],
    orderings: &'a [GivenOrdering],
    chain: Vec<usize>,
    longest: Vec<usize>,
    /// Complete orders; two are enough to know that it is not the only one.
    found: Vec<Vec<usize>>,
    steps: u32,
}

impl Search<'_> {
    /// Tries every pair that may come next where the object now is (`None`: anywhere).
    fn extend(&mut self, at: Option<Vec<RegionId>>) {
        self.steps += 1;
        if self.chain.len() > self.longest.len() {
            self.longest.clone_from(&self.chain);
        }
        if self.chain.len() == self.own.len() {
            self.found.push(self.chain.clone());
            return;
        }
        for next in self.own {
            if self.found.len() > 1 || self.steps > MAX_STEPS {
                return;
            }
            let pair = &self.pairs.pairs[*next];
            let here = at.as_ref().is_none_or(|regions| regions.contains(&pair.from));
            if here && !self.chain.contains(next) && self.may_be_next(*next) {
                self.chain.push(*next);
                self.extend(Some(vec![pair.to]));
                self.chain.pop();
            }
        }
    }

    /// Whether every pair that must come before `next` is in the chain.
    fn may_be_next(&self, next: usize) -> bool {
        self.own.iter().filter(|other| **other != next && !self.chain.contains(other)).all(|other| {
            let same_robot = self.pairs.pairs[*other].robot == self.pairs.pairs[next].robot && *other < next;
            let given =
                |ordering: &GivenOrdering| ordering.before.0.index() == *other && ordering.after.0.index() == next;
            !same_robot && !self.orderings.iter().any(given)
        })
    }
}

fn broken_chain(
    source: &Source,
    pairs: &Pairs,
    nouns: &Nouns<'_>,
    object: ObjectId,
    own: &[usize],
    longest: &[usize],
    steps: u32,
) -> Box<crate::Finding> {
    let object = &nouns.movable[object.index()];
    let region = |region: RegionId| &nouns.regions[region.index()].name;
    let stuck = own.iter().find(|pair| !longest.contains(pair)).or(own.first()).copied().unwrap_or(0);
    let (name, from) = (&pairs.pairs[stuck].name, region(pairs.pairs[stuck].from));
    if steps > MAX_STEPS {
        return source
            .finding(
                pairs.spans[stuck],
                FindingKind::BadTask,
                format!("too many ways to order the {} pairs of `{}`", own.len(), object.name),
            )
            .help("add orderings between them until their order is plain");
    }
    let finding = |whereabouts: String| {
        source.finding(
            pairs.spans[stuck],
            FindingKind::BadTask,
            format!("`{name}` picks `{}` in `{from}`, {whereabouts}", object.name),
        )
    };
    match longest.last() {
        None => finding("where it does not stand at the start".to_owned())
            .help("let its first pair pick it where it stands, or correct its pose"),
        Some(last) => {
            finding(format!("but `{}` leaves it in `{}`", pairs.pairs[*last].name, region(pairs.pairs[*last].to)))
                .note(source, pairs.spans[*last], "leaves it elsewhere")
                .help("each pair of an object must pick it where the one before it placed it")
        }
    }
}
