//! Nogoods of a job, as statements about sites and events.

use contract::Literal;
use skeleton::{Event, EventGraph};

use crate::layout::Layout;
use crate::network::Banned;

/// Combinations that must not be offered. One excludes a candidate if all its literals hold of it: an object has that
/// sample, an order holds (added or implied). A start pose always holds; what a candidate cannot say never does.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nogoods(Vec<Nogood>);

#[derive(Clone, Debug, Default)]
struct Nogood {
    poses: Banned,
    orders: Vec<(Event, Event)>,
}

impl Nogoods {
    /// The nogoods that can exclude a candidate of a level with `samples` samples for each hop.
    pub fn new(nogoods: &[Vec<Literal>], layout: &Layout, samples: usize) -> Self {
        Self(nogoods.iter().filter_map(|literals| Nogood::new(literals, layout, samples)).collect())
    }

    /// The combinations of poses that are banned under an order on events. An empty one: every combination is.
    pub fn under<'a>(&'a self, graph: &'a EventGraph) -> impl Iterator<Item = Banned> + 'a {
        let hold = |nogood: &&Nogood| nogood.orders.iter().all(|(before, after)| graph.precedes(*before, *after));
        self.0.iter().filter(hold).map(|nogood| nogood.poses.clone())
    }
}

impl Nogood {
    /// `None` if its literals cannot all hold.
    fn new(literals: &[Literal], layout: &Layout, samples: usize) -> Option<Self> {
        let mut nogood = Self::default();
        for literal in literals {
            match literal {
                Literal::Pose { occupancy, sample } => {
                    let site = layout.sites.iter().position(|site| site.occupancy == *occupancy)?;
                    if layout.sites[site].placed_by.is_some() {
                        nogood.poses.push((site, (*sample as usize).min(samples)));
                    }
                }
                Literal::Order { before, after } => nogood.orders.push((*before, *after)),
                Literal::Alternative { .. } => return None,
            }
        }
        nogood.poses.sort_unstable();
        nogood.poses.dedup();
        let twice = nogood.poses.windows(2).any(|two| two[0].0 == two[1].0);
        let unknown_sample = nogood.poses.iter().any(|(_, value)| *value >= samples);
        let unknown_event = nogood.orders.iter().any(|(a, b)| !layout.has_event(*a) || !layout.has_event(*b));
        (!twice && !unknown_sample && !unknown_event).then_some(nogood)
    }
}
