//! The recording file: MCAP, written while a run goes on and read back.
//!
//! # What is in it, in this order
//!
//! | record | content |
//! |---|---|
//! | attachment `scenario.toml` | the scenario file |
//! | metadata `stillpoint` | `version` of the program, `format` of what is described here |
//! | metadata `scene` | `json`: the [`Scene`](super::Scene) |
//! | metadata `statics` | `json`: the equilibrium the run started from, where there was one |
//! | `/scene` | one `foxglove.SceneUpdate`: every body's solids in the body's own frame |
//! | `/hinges` | `stillpoint.Hinges`, each sample |
//! | `/energy` | `stillpoint.Energy`, each sample |
//! | `/reactions` | `stillpoint.Reactions`, each sample |
//! | `/couplings` | `stillpoint.Couplings`, each sample; in scenes with drives, motors, gears or loops |
//! | `/outputs` | `stillpoint.Outputs`, each sample; in scenes with outputs |
//! | `/contacts` | `stillpoint.Contacts`, JSON, before each sample at which it changes: bodies, point, normal, force on the second body, `stick` or `slip`; in scenes with contact |
//! | `/tf` | `foxglove.FrameTransforms`, each sample: one transform from the frame `world` to each body's root marker |
//! | `/robot_description` | one `std_msgs/msg/String`: the solids as a URDF, for programs that draw those; where `ros` is asked for, up to 1000 bodies |
//! | `/joint_states` | `sensor_msgs/msg/JointState`, each sample: the same; hinges with one coordinate, if there are up to 64 |
//! | `/events` | `foxglove.Log`, each event: stops that are hit, crossings, changes of the integrator. The topic is there from the first event on |
//! | metadata `run` | `json`: the run's summary; only a finished recording has it |
//! | metadata `recovered` | `json`: what [`Recording::recover`] saved and lost; only in what it wrote |
//!
//! Log times are simulated nanoseconds from 0; the messages of one sample share time and sequence number, and a chunk
//! holds whole samples. Chunks are compressed with zstd and flushed about twice per second of wall time, so that a
//! killed run loses no more than that. The file is called `<name>.partial` until it is finished.
//!
//! # Numbers
//!
//! The numeric channels are protobuf with a schema made for the scene: one `double` field per number, named
//! `hinge_coordinate`, so that every reader finds the names and no number loses a bit:
//!
//! ```text
//! Hinges    { double time; Positions positions; Velocities velocities; Velocities accelerations; }
//! Positions { double upper_angle; double link_0_angle; … }
//! Energy    { double time, kinetic, potential, work, dissipated, error; }
//! Couplings { double time; double crank_motor_torque; double coupler_pin_force_x; … }
//! Outputs   { double time; double camber; double tip_0; … }
//! Reactions { Wrench upper; Wrench link_0; … }      Wrench { Vector force, moment; }
//! ```
//!
//! A field costs 9 to 11 bytes before compression, and a message of thousands of them is still one message. The
//! channel's metadata gives each field's name in the scenario and its unit. Poses are doubles too, but Foxglove's
//! messages leave zeros out and the sign of a zero with them.

mod chunks;
mod contacts;
mod events;
#[cfg(test)]
mod faults;
mod frames;
mod layout;
mod names;
mod numbers;
mod partial;
mod pictures;
mod reader;
mod recover;
mod ros;
mod samples;
mod schema;
mod survey;
mod writer;

pub use partial::{RecordingFile, keep_complete};
pub use reader::{Ending, Recording};
pub use recover::{Lost, Recovered};
pub use samples::Samples;
pub use survey::{ChannelSurvey, Survey};
pub use writer::FileWriter;

/// Version of the layout described above. Readers refuse newer ones.
const FORMAT: u32 = 1;

const SCENARIO: &str = "scenario.toml";
const PROGRAM: &str = "stillpoint";
const SCENE: &str = "scene";
const STATICS: &str = "statics";
const RUN: &str = "run";
const RECOVERED: &str = "recovered";
const JSON: &str = "json";

const SCENE_TOPIC: &str = "/scene";
const HINGES_TOPIC: &str = "/hinges";
const ENERGY_TOPIC: &str = "/energy";
const REACTIONS_TOPIC: &str = "/reactions";
const COUPLINGS_TOPIC: &str = "/couplings";
const OUTPUTS_TOPIC: &str = "/outputs";
const FRAMES_TOPIC: &str = "/tf";
const ROBOT_TOPIC: &str = "/robot_description";
const JOINTS_TOPIC: &str = "/joint_states";
const CONTACTS_TOPIC: &str = "/contacts";
const EVENTS_TOPIC: &str = "/events";
