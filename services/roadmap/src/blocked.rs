//! Which motions a standing object blocks, remembered by content: a new pose is tested alone, and only against motions
//! whose swept boxes it meets. (Conditional reachability, Garrett et al., FFRob, doi:10.1177/0278364917739114.)

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use collision::{Geometry, Motion};
use contract::Digest;
use model::Standing;
use nalgebra::Point3;

/// Corners of a box in the world (m).
type Bounds = (Point3<f64>, Point3<f64>);

/// Answers beyond which the memo is dropped.
const MANY_ANSWERS: usize = 100_000;

/// A memo keyed by the digest of a list of motions and by where an object stands. Losing it changes no answer.
#[derive(Default)]
pub(crate) struct BlockedMotions(Mutex<Memo>);

#[derive(Default)]
struct Memo {
    /// Box around everything that each motion sweeps.
    bounds: BTreeMap<Digest, Arc<[Bounds]>>,
    blocked: BTreeMap<(Digest, Vec<u8>), Arc<[usize]>>,
}

impl BlockedMotions {
    /// Which of the motions (all of them together have this digest) a standing object blocks; ascending.
    pub(crate) fn by(
        &self,
        geometry: &Geometry,
        digest: Digest,
        motions: &dyn Fn() -> Vec<Motion>,
        standing: &Standing,
    ) -> Arc<[usize]> {
        let key = (digest, contract::encode_canonical(standing));
        if let Some(known) = self.0.lock().ok().and_then(|memo| memo.blocked.get(&key).cloned()) {
            return known;
        }
        let motions = motions();
        let bounds = self.bounds(geometry, digest, &motions);
        let at = geometry.standing_bounds(standing);
        // An answer may name a contact up to a quarter of the clearance early; so may a box.
        let spare = geometry.problem().settings.clearance;
        let near =
            |(least, greatest): &Bounds| (0..3).all(|i| least[i] - spare <= at.1[i] && at.0[i] <= greatest[i] + spare);
        let blocked: Arc<[usize]> = (0..motions.len())
            .filter(|i| near(&bounds[*i]) && geometry.motion_hits(&motions[*i], standing).is_some())
            .collect();
        if let Ok(mut memo) = self.0.lock() {
            if memo.blocked.len() >= MANY_ANSWERS {
                *memo = Memo::default();
            }
            memo.blocked.insert(key, blocked.clone());
        }
        blocked
    }

    fn bounds(&self, geometry: &Geometry, digest: Digest, motions: &[Motion]) -> Arc<[Bounds]> {
        let known = self.0.lock().ok().and_then(|memo| memo.bounds.get(&digest).cloned());
        known.filter(|known| known.len() == motions.len()).unwrap_or_else(|| {
            let bounds: Arc<[Bounds]> = motions.iter().map(|motion| geometry.sweep(motion, 0, 1).bounds()).collect();
            if let Ok(mut memo) = self.0.lock() {
                memo.bounds.insert(digest, bounds.clone());
            }
            bounds
        })
    }
}
