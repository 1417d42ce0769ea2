//! The numbers of a glTF file: one buffer, a view of it for each purpose, accessors.

use serde_json::{Map, Value, json};

/// What numbers are for: each purpose has a view of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Vectors of three.
    Vertices,
    Corners,
    Keys,
    /// Vectors of four, of vertices that move with several nodes.
    Weights,
    /// The nodes of these.
    Bones,
    /// Where those nodes are without motion.
    Bindings,
}

/// How many purposes there are.
const PURPOSES: usize = 6;

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const UNSIGNED_SHORT: u32 = 5123;

#[derive(Debug, Default)]
pub(super) struct Bytes {
    views: [Vec<u8>; PURPOSES],
    accessors: Vec<Value>,
}

impl Bytes {
    /// Numbers in groups of 1, 3 or 4, with their range if `ranged`; returns the accessor's number.
    pub(super) fn floats(&mut self, purpose: Purpose, values: &[f32], width: usize, ranged: bool) -> usize {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        let mut accessor = self.accessor(purpose, FLOAT, kind, values.len() / width);
        if ranged {
            let end = |pick: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
                (0..width).map(|k| values.iter().skip(k).step_by(width).copied().fold(start, pick)).collect()
            };
            accessor["min"] = json!(end(f32::min, f32::INFINITY));
            accessor["max"] = json!(end(f32::max, f32::NEG_INFINITY));
        }
        self.views[purpose as usize].extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self.push(accessor)
    }

    /// Numbers of corners.
    pub(super) fn corners(&mut self, corners: &[u32]) -> usize {
        let accessor = self.accessor(Purpose::Corners, UNSIGNED_INT, "SCALAR", corners.len());
        self.views[Purpose::Corners as usize].extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
        self.push(accessor)
    }

    /// Matrices of four rows and columns, column by column.
    pub(super) fn matrices(&mut self, values: &[f32]) -> usize {
        let accessor = self.accessor(Purpose::Bindings, FLOAT, "MAT4", values.len() / 16);
        self.views[Purpose::Bindings as usize].extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self.push(accessor)
    }

    /// Numbers of joints, four a vertex.
    pub(super) fn bones(&mut self, joints: &[u16]) -> usize {
        let accessor = self.accessor(Purpose::Bones, UNSIGNED_SHORT, "VEC4", joints.len() / 4);
        self.views[Purpose::Bones as usize].extend(joints.iter().flat_map(|joint| joint.to_le_bytes()));
        self.push(accessor)
    }

    fn accessor(&self, purpose: Purpose, component: u32, kind: &str, count: usize) -> Value {
        let offset = self.views[purpose as usize].len();
        json!({ "bufferView": purpose as usize, "byteOffset": offset, "componentType": component, "type": kind, "count": count })
    }

    fn push(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// The file: header, JSON, binary.
    pub(super) fn finish(mut self, mut root: Map<String, Value>) -> Vec<u8> {
        let mut views = Vec::new();
        let mut numbers = [0; PURPOSES];
        let mut buffer = Vec::new();
        for (purpose, view) in self.views.iter().enumerate().filter(|(_, view)| !view.is_empty()) {
            let mut entry = json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": view.len() });
            // Drawing programs are told what vertices and corners are; keys are neither.
            match purpose {
                0 => (entry["target"], entry["byteStride"]) = (json!(34962), json!(12)),
                1 => entry["target"] = json!(34963),
                3 => (entry["target"], entry["byteStride"]) = (json!(34962), json!(16)),
                4 => (entry["target"], entry["byteStride"]) = (json!(34962), json!(8)),
                _ => {}
            }
            numbers[purpose] = views.len();
            views.push(entry);
            buffer.extend(view);
        }
        for accessor in &mut self.accessors {
            let purpose = accessor["bufferView"].as_u64().unwrap_or_default() as usize;
            accessor["bufferView"] = json!(numbers[purpose]);
        }
        if !buffer.is_empty() {
            root.insert("buffers".into(), json!([{ "byteLength": buffer.len() }]));
            root.insert("bufferViews".into(), json!(views));
            root.insert("accessors".into(), json!(self.accessors));
        }
        let mut text = Value::Object(root).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunk =
            |kind: &[u8; 4], content: &[u8]| [&(content.len() as u32).to_le_bytes()[..], kind, content].concat();
        let mut body = chunk(b"JSON", &text);
        if !buffer.is_empty() {
            body.extend(chunk(b"BIN\0", &buffer));
        }
        let length = (12 + body.len()) as u32;
        [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes(), &body].concat()
    }
}
