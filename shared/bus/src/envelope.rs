//! The header of every message part.

use contract::{Digest, JobId};

use crate::member::first_u64;
use crate::{MemberId, RunKey};

/// Version of messages, encoding and meaning. Members of another version are refused.
pub const CONTRACT_VERSION: u32 = 2;

/// Header of one part of a message: fixed layout, little-endian, no padding.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Envelope {
    /// [`CONTRACT_VERSION`] of the sender.
    pub contract_version: u32,
    /// What the body is: [`crate::Kind`].
    pub kind: u32,
    /// Run.
    pub run: u64,
    /// The job that the message is about, or zeros.
    pub job: [u8; 32],
    /// Sender.
    pub sender: u32,
    /// Number of parts of the message.
    pub parts: u32,
    /// Which of them this is, from 0.
    pub part: u32,
    /// Zero.
    pub reserved: u32,
    /// Number of the message among its sender's.
    pub sequence: u64,
    /// Length of the whole body, all parts together (bytes).
    pub length: u64,
    /// Checksum of this part.
    pub checksum: u64,
}

const _: () = assert!(size_of::<Envelope>() == Envelope::BYTES);
const _: () = assert!(align_of::<Envelope>() == 8);

impl Envelope {
    /// Size on the wire.
    pub const BYTES: usize = 88;

    /// Header of a message in one part.
    #[must_use]
    pub fn whole(kind: u32, run: RunKey, job: Option<JobId>, sender: MemberId, sequence: u64, body: &[u8]) -> Self {
        Self {
            contract_version: CONTRACT_VERSION,
            kind,
            run: run.0,
            job: job.map_or([0; 32], |job| job.0.0),
            sender: sender.0,
            parts: 1,
            part: 0,
            reserved: 0,
            sequence,
            length: body.len() as u64,
            checksum: checksum(body),
        }
    }

    /// The job that the message is about.
    #[must_use]
    pub fn job(&self) -> Option<JobId> {
        (self.job != [0; 32]).then_some(JobId(Digest(self.job)))
    }

    /// Bytes on the wire.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        let mut at = 0;
        let mut put = |field: &[u8]| {
            bytes[at..at + field.len()].copy_from_slice(field);
            at += field.len();
        };
        put(&self.contract_version.to_le_bytes());
        put(&self.kind.to_le_bytes());
        put(&self.run.to_le_bytes());
        put(&self.job);
        for word in [self.sender, self.parts, self.part, self.reserved] {
            put(&word.to_le_bytes());
        }
        for word in [self.sequence, self.length, self.checksum] {
            put(&word.to_le_bytes());
        }
        bytes
    }

    /// The header of these bytes; nothing is checked.
    #[must_use]
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let mut job = [0; 32];
        job.copy_from_slice(&bytes[16..48]);
        Self {
            contract_version: u32_at(bytes, 0),
            kind: u32_at(bytes, 4),
            run: u64_at(bytes, 8),
            job,
            sender: u32_at(bytes, 48),
            parts: u32_at(bytes, 52),
            part: u32_at(bytes, 56),
            reserved: u32_at(bytes, 60),
            sequence: u64_at(bytes, 64),
            length: u64_at(bytes, 72),
            checksum: u64_at(bytes, 80),
        }
    }
}

/// Checksum of a part: the first eight bytes of its BLAKE3 digest.
#[must_use]
pub fn checksum(part: &[u8]) -> u64 {
    first_u64(&Digest::of("mrtamp part", &[part]).0)
}

fn u32_at(bytes: &[u8; Envelope::BYTES], at: usize) -> u32 {
    bytes[at..at + 4].iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

fn u64_at(bytes: &[u8; Envelope::BYTES], at: usize) -> u64 {
    bytes[at..at + 8].iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))
}
