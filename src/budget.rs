//! Budgets: how much of what a file may ask for before it is refused. Every limit on input is here, and in the table of
//! `docs/guide/limits.md`; a message that refuses something names the number.
//!
//! They are chosen so that a refusal takes less than a second and 500 MB, and so that no model, mesh or recording that
//! was met in practice comes near. What is within its budget may well take longer.

/// Bytes of a scenario, a start file or a model: some 100 000 bodies one by one.
pub const TEXT_BYTES: usize = 32 << 20;

/// Elements, texts and comments of one XML file.
pub const XML_NODES: u32 = 2_000_000;

/// Attributes of one XML element; a parser compares each with all others.
pub const XML_ATTRIBUTES: usize = 1_000;

/// Bytes that the entities of one XML file may expand to, all uses together.
pub const XML_ENTITY_BYTES: usize = 1 << 20;

/// The largest number of a scene, in SI units: the squares of larger ones overflow.
pub const LARGEST: f64 = 1e154;

/// Coordinates of a body in a recording, at most: those of a modal body.
pub const COORDINATES: usize = 96;

/// Bodies of a scenario with all copies, and of a recording.
pub const BODIES: usize = 1_000_000;

/// Contacts that the importer of MJCF writes for pairs of bodies.
pub const CONTACTS: usize = 10_000;

/// Problems of one kind for which a similar name is looked for, in the files of one command: each costs a comparison
/// with every known name.
pub const SUGGESTIONS: usize = 50;

/// Known names that one misspelt name is compared with.
pub const SUGGESTED_NAMES: usize = 20_000;

/// Characters of the longest name for which a similar one is looked for.
pub const SUGGESTED_LENGTH: usize = 100;

/// Bytes of a file of finite elements, and of its arrays together.
pub const FEM_BYTES: u64 = 512 << 20;

/// Rows of the matrices of finite elements.
pub const FEM_FREEDOMS: usize = 200_000;

/// Entries of one matrix of finite elements in a list.
pub const FEM_ENTRIES: usize = 20_000_000;

/// Estimated bytes of the matrices that statics or an implicit step takes for a scene.
pub const MATRIX_BYTES: usize = 8_000_000_000;

/// Bytes of a mesh file, and of each buffer beside it.
pub const MESH_BYTES: u64 = 256 << 20;

/// Bytes of all material files of a mesh together.
pub const MATERIAL_BYTES: u64 = 16 << 20;

/// Corners of a mesh, once its parts are put together.
pub const MESH_CORNERS: usize = 6_000_000;

/// Triangles of a mesh, once its parts are put together.
pub const MESH_TRIANGLES: usize = 6_000_000;

/// Visits of nodes and primitives of a glTF file: a node that stands in several places is visited in each.
pub const MESH_NODES: usize = 100_000;

/// Nodes within nodes of a glTF file.
pub const MESH_DEPTH: usize = 100;

/// Bytes of one record of a recording as it stands in the file; descriptions of the largest scenes have some tens of
/// millions.
pub const RECORD_BYTES: usize = 256 << 20;

/// Bytes of one chunk of a recording once it is unpacked. Those that are written have little over a mebibyte, or one
/// sample of the scene if that has more.
pub const CHUNK_BYTES: u64 = 256 << 20;

/// What one chunk, and all chunks together, may unpack to at any rate, in bytes: so many, …
pub const UNPACKED_BYTES: u64 = 32 << 20;

/// … and so many more for every byte that they take in the file. Motions are packed to a fifth; a scene at rest to less.
pub const UNPACKED_RATIO: u64 = 200;
