//! Messages in parts: cutting large bodies, and putting them together again.

use std::collections::BTreeMap;

use contract::MAX_MESSAGE_BYTES;

use crate::envelope::checksum;
use crate::{CONTRACT_VERSION, Envelope, Garbage, Kind, Parcel, RunKey, Topic};

/// Unfinished messages kept at a time; the oldest gives way.
const MAX_UNFINISHED: usize = 64;

/// Cuts a body into parts, each with its header. `header` is that of the whole message.
pub(crate) fn cut<'a>(
    header: &'a Envelope,
    body: &'a [u8],
    part_bytes: usize,
) -> impl Iterator<Item = (Envelope, &'a [u8])> {
    let part_bytes = part_bytes.max(1);
    let parts = body.len().div_ceil(part_bytes).max(1);
    (0..parts).map(move |index| {
        let part = &body[index * part_bytes..body.len().min((index + 1) * part_bytes)];
        let numbered = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        let header = Envelope { parts: numbered(parts), part: numbered(index), checksum: checksum(part), ..*header };
        (header, part)
    })
}

/// A whole message, its body not yet decoded.
pub(crate) struct Assembled {
    pub(crate) topic: Topic,
    pub(crate) header: Envelope,
    pub(crate) kind: Kind,
    pub(crate) body: Vec<u8>,
}

/// Puts messages together. Each sender's parts on a topic arrive in order.
#[derive(Default)]
pub(crate) struct Assembler {
    unfinished: BTreeMap<(Topic, u32), Unfinished>,
    age: u64,
}

struct Unfinished {
    header: Envelope,
    body: Vec<u8>,
    next: u32,
    age: u64,
}

impl Assembler {
    /// Takes a part. `Ok(None)`: the message goes on.
    pub(crate) fn take(&mut self, parcel: Parcel, run: RunKey) -> Result<Option<Assembled>, Garbage> {
        let header = Envelope::from_bytes(&parcel.header);
        let kind = check(&header, &parcel, run)?;
        let topic = parcel.topic;
        if header.parts == 1 {
            return Ok(Some(Assembled { topic, header, kind, body: parcel.part }));
        }
        let body = self.go_on(topic, header, &parcel.part)?;
        Ok(body.map(|body| Assembled { topic, header, kind, body }))
    }

    fn go_on(&mut self, topic: Topic, header: Envelope, part: &[u8]) -> Result<Option<Vec<u8>>, Garbage> {
        let key = (topic, header.sender);
        if header.part == 0 {
            self.make_room();
            self.age += 1;
            let begun = Unfinished { header, body: part.to_vec(), next: 1, age: self.age };
            let torn = self.unfinished.insert(key, begun).is_some();
            return if torn { Err(Garbage::Torn) } else { Ok(None) };
        }
        let Some(unfinished) = self.unfinished.get_mut(&key) else { return Err(Garbage::Torn) };
        if !unfinished.continues(&header) {
            self.unfinished.remove(&key);
            return Err(Garbage::Torn);
        }
        unfinished.body.extend_from_slice(part);
        unfinished.next += 1;
        let length = unfinished.body.len() as u64;
        if length < header.length && header.part + 1 < header.parts {
            return Ok(None);
        }
        let whole = self.unfinished.remove(&key).map(|unfinished| unfinished.body);
        if length == header.length && header.part + 1 == header.parts { Ok(whole) } else { Err(Garbage::Damaged) }
    }

    fn make_room(&mut self) {
        if self.unfinished.len() >= MAX_UNFINISHED {
            let oldest = self.unfinished.iter().min_by_key(|(_, unfinished)| unfinished.age).map(|(key, _)| *key);
            if let Some(key) = oldest {
                self.unfinished.remove(&key);
            }
        }
    }
}

impl Unfinished {
    fn continues(&self, header: &Envelope) -> bool {
        let first = &self.header;
        header.part == self.next
            && (header.sequence, header.kind, header.parts) == (first.sequence, first.kind, first.parts)
            && (header.length, header.job) == (first.length, first.job)
    }
}

fn check(header: &Envelope, parcel: &Parcel, run: RunKey) -> Result<Kind, Garbage> {
    if header.contract_version != CONTRACT_VERSION {
        return Err(Garbage::Version);
    }
    if header.run != run.0 {
        return Err(Garbage::Run);
    }
    let kind = Kind::of_number(header.kind).ok_or(Garbage::Kind)?;
    if !kind.belongs_on(parcel.topic) {
        return Err(Garbage::Topic);
    }
    if header.length > MAX_MESSAGE_BYTES as u64 {
        return Err(Garbage::TooLarge);
    }
    let length = parcel.part.len() as u64;
    let possible = header.part < header.parts
        && if header.parts == 1 { length == header.length } else { length > 0 && length <= header.length };
    if !possible || header.reserved != 0 || header.checksum != checksum(&parcel.part) {
        return Err(Garbage::Damaged);
    }
    Ok(kind)
}
