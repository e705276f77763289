//! The binary container of glTF 2.0: accessors over one buffer, and the two chunks.

use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// What an accessor is used for: vertex data names a buffer target, animation data none.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Positions and normals.
    Vertices,
    /// Keys of an animation.
    Animation,
}

/// A buffer with its views and accessors.
#[derive(Default)]
pub struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds values of `N` floats each (`SCALAR`, `VEC3` or `VEC4`), with their bounds; the accessor's index.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]], purpose: Use) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        let target = (purpose == Use::Vertices).then_some(ARRAY_BUFFER);
        let bound = |pick: fn(f32, f32) -> f32| {
            let first = values.first().copied().unwrap_or([0.0; N]);
            values.iter().fold(first, |bound, value| std::array::from_fn(|i| pick(bound[i], value[i]))).to_vec()
        };
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.accessor(&bytes, target, FLOAT, kind, values.len(), bound(f32::min).into(), bound(f32::max).into())
    }

    /// Adds indices of triangles; the accessor's index.
    pub fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let (least, greatest) = (indices.iter().min(), indices.iter().max());
        let target = Some(ELEMENT_ARRAY_BUFFER);
        self.accessor(&bytes, target, UNSIGNED_INT, "SCALAR", indices.len(), json!([least]), json!([greatest]))
    }

    fn accessor(
        &mut self,
        bytes: &[u8],
        target: Option<u32>,
        component: u32,
        kind: &str,
        count: usize,
        min: Value,
        max: Value,
    ) -> usize {
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend(bytes);
        self.accessors.push(json!({
            "bufferView": self.views.len(), "componentType": component, "type": kind, "count": count, "min": min, "max": max,
        }));
        self.views.push(view);
        self.accessors.len() - 1
    }

    /// The file: header, the document with this buffer's parts as JSON chunk, the bytes as binary chunk.
    ///
    /// # Errors
    /// A number that JSON cannot hold.
    pub fn into_glb(self, mut document: Value) -> Result<Vec<u8>, serde_json::Error> {
        document["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        document["bufferViews"] = self.views.into();
        document["accessors"] = self.accessors.into();
        let mut text = serde_json::to_vec(&document)?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = self.bytes;
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + 8 + bytes.len();
        let mut file = Vec::with_capacity(length);
        file.extend(*b"glTF");
        for word in [2, length as u32, text.len() as u32] {
            file.extend(word.to_le_bytes());
        }
        file.extend(*b"JSON");
        file.extend(text);
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(*b"BIN\0");
        file.extend(bytes);
        Ok(file)
    }
}
