//! Content-addressed products: what one stage makes and a later one reads.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};

use crate::{JobId, ModeRoadmap, Prefix, RoadmapPiece};

/// BLAKE3 digest.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Digest(pub [u8; 32]);

impl Digest {
    /// Digest of parts under a context; the parts' lengths count.
    #[must_use]
    pub fn of(context: &str, parts: &[&[u8]]) -> Self {
        let mut hasher = blake3::Hasher::new_derive_key(context);
        for part in parts {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
        Self(*hasher.finalize().as_bytes())
    }

    /// Digest of a product's bytes.
    #[must_use]
    pub fn of_product(bytes: &[u8]) -> Self {
        Self::of("mrtamp product", &[bytes])
    }

    /// All 64 hexadecimal digits.
    #[must_use]
    pub fn hex(&self) -> String {
        self.0.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl std::fmt::Debug for Digest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.hex()[..12])
    }
}

/// A product by its content, and the job that makes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ProductRef {
    /// Digest of the product's bytes.
    pub digest: Digest,
    /// Who makes it, should it be lost.
    pub made_by: JobId,
}

/// What stages hand to one another. Encoded as one message.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Product {
    /// A roadmap against fixed objects only.
    Piece(RoadmapPiece),
    /// A glued roadmap of a mode.
    Mode(ModeRoadmap),
    /// Committed motion.
    Prefix(Prefix),
    /// Bytes of `plan.json`.
    Plan(Vec<u8>),
}

/// Where products are kept.
pub trait Products: Send + Sync {
    /// Bytes of a product, if they can be had.
    fn get(&self, digest: &Digest) -> Option<Arc<[u8]>>;
    /// Keeps bytes and publishes them; returns their digest.
    fn put(&self, bytes: Vec<u8>) -> Digest;
}

/// Products in this process's memory.
#[derive(Debug, Default)]
pub struct MemoryProducts(Mutex<BTreeMap<Digest, Arc<[u8]>>>);

impl Products for MemoryProducts {
    fn get(&self, digest: &Digest) -> Option<Arc<[u8]>> {
        self.0.lock().ok()?.get(digest).cloned()
    }

    fn put(&self, bytes: Vec<u8>) -> Digest {
        let digest = Digest::of_product(&bytes);
        if let Ok(mut kept) = self.0.lock() {
            kept.entry(digest).or_insert_with(|| bytes.into());
        }
        digest
    }
}
