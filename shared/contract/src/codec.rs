//! The one encoding of messages, products and canonical bytes: fixed-width little-endian integers, bounded, no trailing bytes.

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use serde::{Serialize, de::DeserializeOwned};

/// Greatest size of an encoded message or product (bytes).
pub const MAX_MESSAGE_BYTES: usize = 64 << 20;

type Wire = Configuration<LittleEndian, Fixint, Limit<MAX_MESSAGE_BYTES>>;

const fn wire() -> Wire {
    bincode::config::standard().with_fixed_int_encoding().with_little_endian().with_limit::<MAX_MESSAGE_BYTES>()
}

/// Why bytes could not be made or read.
#[derive(Debug, thiserror::Error)]
pub enum CodecError {
    /// A value that the encoding cannot hold.
    #[error("cannot be encoded: {0}")]
    Encode(#[from] bincode::error::EncodeError),
    /// More bytes than a message may have.
    #[error("{0} bytes, more than the {MAX_MESSAGE_BYTES} a message may have")]
    TooLarge(usize),
    /// Bytes that are no such value.
    #[error("cannot be decoded: {0}")]
    Decode(#[from] bincode::error::DecodeError),
    /// A value followed by something else.
    #[error("{0} trailing bytes")]
    Trailing(usize),
}

/// Bytes of a value.
///
/// # Errors
/// [`CodecError::Encode`], [`CodecError::TooLarge`].
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, CodecError> {
    let bytes = bincode::serde::encode_to_vec(value, wire())?;
    if bytes.len() > MAX_MESSAGE_BYTES { Err(CodecError::TooLarge(bytes.len())) } else { Ok(bytes) }
}

/// The value of these bytes.
///
/// # Errors
/// [`CodecError::Decode`], [`CodecError::Trailing`]; never panics, whatever the bytes.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    let (value, used) = bincode::serde::decode_from_slice(bytes, wire())?;
    if used == bytes.len() { Ok(value) } else { Err(CodecError::Trailing(bytes.len() - used)) }
}

/// Bytes that stand for a value in digests. Types of this crate always encode; a failure is folded into the bytes.
#[must_use]
pub fn encode_canonical<T: Serialize>(value: &T) -> Vec<u8> {
    encode(value).unwrap_or_else(|error| format!("unencodable: {error}").into_bytes())
}
