//! Random values by key and index, never by state: equal keys give equal values in every process and order.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::{Digest, StageKind};

/// Values of one purpose of one stage for some named entities. Index `i` does not depend on how many are drawn.
#[derive(Clone, Debug)]
pub struct RandomStream {
    key: [u8; 32],
}

impl RandomStream {
    /// The stream of (seed, stage, entity names, purpose). Keys hold no job, level or budget.
    #[must_use]
    pub fn new(seed: u64, stage: StageKind, entities: &[&str], purpose: &str) -> Self {
        let mut parts: Vec<&[u8]> = vec![stage.name().as_bytes(), purpose.as_bytes()];
        let seed = seed.to_le_bytes();
        parts.push(&seed);
        parts.extend(entities.iter().map(|name| name.as_bytes()));
        Self { key: Digest::of("mrtamp random stream", &parts).0 }
    }

    /// `N` values in [0, 1) for sample `index`.
    #[must_use]
    pub fn unit<const N: usize>(&self, index: u64) -> [f64; N] {
        let mut values = self.values(index);
        std::array::from_fn(|_| values.next_unit())
    }

    /// As many values as wanted for sample `index`.
    #[must_use]
    pub fn values(&self, index: u64) -> SampleValues {
        let mut rng = ChaCha8Rng::from_seed(self.key);
        rng.set_stream(index);
        rng.set_word_pos(0);
        SampleValues(rng)
    }
}

/// Values of one sample.
#[derive(Clone, Debug)]
pub struct SampleValues(ChaCha8Rng);

impl SampleValues {
    /// Next value in [0, 1), 53 bits.
    pub fn next_unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Next index below `len` (0 if `len` is 0).
    pub fn next_index(&mut self, len: usize) -> usize {
        ((self.next_unit() * len as f64) as usize).min(len.saturating_sub(1))
    }
}

/// Element `index` (from 0) of the Halton sequence in `base`, in (0, 1). Halton, Numer. Math. 2 (1960) 84, doi:10.1007/BF01386213.
#[must_use]
pub fn halton(index: u64, base: u64) -> f64 {
    let (mut value, mut weight, mut rest) = (0.0, 1.0, index + 1);
    while rest > 0 {
        weight /= base as f64;
        value += weight * (rest % base) as f64;
        rest /= base;
    }
    value
}
