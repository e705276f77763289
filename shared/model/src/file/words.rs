//! Parts of the problem file that may be a word, a list or a map.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::at::At;
use super::syntax::{GraspFile, PairFile};
use crate::Point;

/// `home`, or values by coordinate name.
#[derive(Debug)]
pub(crate) enum StartFile {
    Home,
    Values(Entries<At<f64>>),
}

/// Pairs by robot name, in file order.
#[derive(Debug)]
pub(crate) struct TaskFile(pub Entries<At<PairList>>);

/// Pairs of one robot.
pub(crate) type PairList = Vec<At<PairFile>>;
/// Keys and values of a map, in file order, with the places of the keys.
pub(crate) type Entries<T> = Vec<(At<String>, T)>;

/// One family or a list.
#[derive(Debug)]
pub(crate) struct GraspsFile(pub Vec<At<GraspEntry>>);

/// A family or one grasp.
#[derive(Debug)]
pub(crate) enum GraspEntry {
    Side,
    Top,
    One(Box<GraspFile>),
}

/// A time point of a pair: `"r1.2 release"` or `{pair: r1.2, point: release}`.
#[derive(Debug)]
pub(crate) struct PointFile {
    pub pair: String,
    pub point: Point,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "PairAndPoint")]
struct PointMap {
    /// Name of the pair.
    pair: String,
    /// Which of its time points.
    point: Point,
}

/// Reads any of a word, a list and a map, as far as `T` knows them.
trait Words: Sized {
    const EXPECTED: &'static str;

    fn word<E: Error>(word: &str) -> Result<Self, E> {
        Err(E::invalid_value(serde::de::Unexpected::Str(word), &Self::EXPECTED))
    }

    fn list<'de, A: SeqAccess<'de>>(_list: A) -> Result<Self, A::Error> {
        Err(A::Error::invalid_type(serde::de::Unexpected::Seq, &Self::EXPECTED))
    }

    fn map<'de, A: MapAccess<'de>>(_map: A) -> Result<Self, A::Error> {
        Err(A::Error::invalid_type(serde::de::Unexpected::Map, &Self::EXPECTED))
    }
}

struct WordsVisitor<T>(std::marker::PhantomData<T>);

impl<'de, T: Words> Visitor<'de> for WordsVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(T::EXPECTED)
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<T, E> {
        T::word(word)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<T, A::Error> {
        T::list(list)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::map(map)
    }
}

macro_rules! deserialize_words {
    ($($name:ident),*) => {$(
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any(WordsVisitor(std::marker::PhantomData))
            }
        }
    )*};
}

deserialize_words!(StartFile, TaskFile, GraspsFile, GraspEntry, PointFile);

/// All entries of a map.
fn entries<'de, A: MapAccess<'de>, T: Deserialize<'de>>(mut map: A) -> Result<Entries<T>, A::Error> {
    let mut entries = Vec::new();
    while let Some(entry) = map.next_entry()? {
        entries.push(entry);
    }
    Ok(entries)
}

impl Words for StartFile {
    const EXPECTED: &'static str = "`home` or values by coordinate name";

    fn word<E: Error>(word: &str) -> Result<Self, E> {
        match word {
            "home" => Ok(Self::Home),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(word), &Self::EXPECTED)),
        }
    }

    fn map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        entries(map).map(Self::Values)
    }
}

impl Words for TaskFile {
    const EXPECTED: &'static str = "lists of pairs by robot name";

    fn map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        entries(map).map(Self)
    }
}

impl Words for GraspsFile {
    const EXPECTED: &'static str = "`side`, `top`, or a list of these and of grasps";

    fn word<E: Error>(word: &str) -> Result<Self, E> {
        let entry = GraspEntry::word::<E>(word)?;
        let span = crate::problem_error::Span { offset: 0, len: 0 };
        Ok(Self(vec![At { value: entry, span }]))
    }

    fn list<'de, A: SeqAccess<'de>>(list: A) -> Result<Self, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(Self)
    }
}

impl Words for GraspEntry {
    const EXPECTED: &'static str = "`side`, `top` or a grasp";

    fn word<E: Error>(word: &str) -> Result<Self, E> {
        match word {
            "side" => Ok(Self::Side),
            "top" => Ok(Self::Top),
            _ => Err(E::unknown_variant(word, &["side", "top"])),
        }
    }

    fn map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        GraspFile::deserialize(MapAccessDeserializer::new(map)).map(Box::new).map(Self::One)
    }
}

impl Words for PointFile {
    const EXPECTED: &'static str = "`<pair> <point>` such as `r1.2 release`";

    fn word<E: Error>(word: &str) -> Result<Self, E> {
        let (pair, point) = word
            .trim()
            .rsplit_once(' ')
            .ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(word), &Self::EXPECTED))?;
        let point = Point::deserialize(StrDeserializer::new(point))?;
        Ok(Self { pair: pair.trim().to_owned(), point })
    }

    fn map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        let PointMap { pair, point } = PointMap::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Self { pair, point })
    }
}

macro_rules! word_schema {
    ($name:ident, $title:literal, |$generator:ident| $schema:expr) => {
        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                $title.into()
            }

            fn json_schema($generator: &mut SchemaGenerator) -> Schema {
                $schema
            }
        }
    };
}

word_schema!(StartFile, "Start", |_generator| json_schema!({
    "description": "`home`, or values by coordinate: x, y, yaw of a planar base (m, rad) and joint names. What is left out is as in `home`.",
    "oneOf": [{"const": "home"}, {"type": "object", "additionalProperties": {"type": "number"}}],
}));
word_schema!(TaskFile, "Task", |generator| json_schema!({
    "description": "For each robot its pairs in order.",
    "type": "object",
    "additionalProperties": {"type": "array", "items": generator.subschema_for::<PairFile>()},
}));
word_schema!(GraspsFile, "Grasps", |generator| json_schema!({
    "description": "A family, or a list of families and grasps.",
    "oneOf": [{"enum": ["side", "top"]}, {"type": "array", "items": generator.subschema_for::<GraspEntry>()}],
}));
word_schema!(GraspEntry, "GraspEntry", |generator| json_schema!({
    "description": "A family (`side`: 4 yaws, 2 flips, 3 heights; `top`: 4 yaws) or one grasp.",
    "oneOf": [{"enum": ["side", "top"]}, generator.subschema_for::<GraspFile>()],
}));
word_schema!(PointFile, "PointOfPair", |generator| json_schema!({
    "description": "A time point of a pair: `<pair> <point>`, or a map. Points: start, at_pick, grasp, carry, at_place, release, done.",
    "oneOf": [{"type": "string", "pattern": "^\\S+ +(start|at_pick|grasp|carry|at_place|release|done)$"},
        generator.subschema_for::<PointMap>()],
}));
