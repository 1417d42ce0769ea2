//! A multibody simulator that starts at rest: it finds the static equilibrium of a scene of rigid bodies, hinges and
//! springs, proves what kind of equilibrium it is, and simulates from there. Statics and dynamics come from one
//! method, the reduced transfer matrix method, whose sweeps take a time proportional to the number of bodies.
//!
//! ```text
//!  scenarios/*.toml
//!       │  scenario::load            text → checked description; every problem with line and caret
//!       ▼
//!    Description ── Model::build ──► Model (immutable)          settings of simulate, statics, record
//!       │
//!       │            ┌───────────── statics::equilibrium ──► start, with its certificate
//!       ▼            │
//!    dynamics::System = forces (wrenches) ─► transfer (accelerations, reactions, tangent)
//!       │
//!       ▼
//!    simulate::run (the time loop) ◄─ integrate::Method         ─► record::Recorder ─► MCAP │ Rerun │ memory
//!       ▼
//!    cli                             reports, JSON, exit codes
//! ```
//!
//! # A pendulum in code
//!
//! ```
//! use stillpoint::model::Model;
//! use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
//! use stillpoint::record::{Memory, Opening};
//! use stillpoint::{simulate, statics};
//!
//! // A thin rod of 1 m and 1 kg, hinged at its upper end; the guess is a radian away from where it hangs.
//! let hinge = HingeDescription::revolute([0.0, 1.0, 0.0]).position([1.0]);
//! let rod = BodyDescription::new("rod", hinge).mass(1.0).center([0.0, 0.0, -0.5]).inertia([1.0 / 12.0, 1.0 / 12.0, 0.0]);
//! let scene = Description::new("Pendulum").body(rod);
//! let model = Model::build(&scene).map_err(|problems| format!("{problems:?}"))?;
//!
//! // Where it rests, what kind of rest that is, and how it swings: ω² = 3 g / (2 l).
//! let rest = statics::equilibrium(&model, &statics::Settings::default(), &model.start_position)?;
//! let stability = rest.stability.as_ref().ok_or("no equilibrium")?;
//! let omega = (1.5 * 9.80665_f64).sqrt();
//! assert!(rest.converged && rest.position[0].abs() < 1e-12);
//! assert_eq!(stability.verdict, statics::StabilityVerdict::Stable);
//! assert!((stability.modes[0].frequency_hz - omega / std::f64::consts::TAU).abs() < 1e-9);
//!
//! // What the hinge bears there: the weight.
//! assert!((rest.reactions[0].force.z - 9.80665).abs() < 1e-12);
//!
//! // Pushed a little aside and let go: after half a period it is on the other side.
//! let start = simulate::State { position: vec![1e-3], velocity: vec![0.0] };
//! let settings = simulate::Settings { duration: std::f64::consts::PI / omega, ..Default::default() };
//! let picture = simulate::scene(&model);
//! let mut samples = Memory::new(&Opening { scene: &picture, scenario: "", statics: None });
//! let end = simulate::run(&model, &settings, 100.0, &start, &mut samples, &mut |_, _| true)?;
//! assert!((end.state.position[0] + 1e-3).abs() < 1e-8);
//! assert_eq!(samples.samples.len(), end.samples);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | to | see |
//! |---|---|
//! | describe a scene | [`model::description`] |
//! | read a scenario file | [`scenario::load`] |
//! | find and judge an equilibrium | [`statics::equilibrium()`] |
//! | evaluate accelerations and reactions | [`dynamics::System::at`] |
//! | step an integrator by hand | [`simulate::problem::Equations`] |
//! | run and record | [`simulate::run`], [`record::RecordingFile`] |
//! | read a recording | [`record::Recording`], [`record::Table`] |
//!
//! A scene from a file is one call away: [`scenario::load`] gives the same [`Description`](model::Description) and the
//! settings beside it.
//!
//! # Features
//!
//! | feature | adds |
//! |---|---|
//! | none | the core: models, accelerations, statics, integrators, runs with samples in memory |
//! | `scenario` | scenario files: [`scenario`] |
//! | `import` | models of other programs and triangle meshes: [`import`], [`mesh`]; needs `scenario` |
//! | `record` | recordings: [`record::file`] |
//! | `view` | streaming to the Rerun viewer and `.rrd` files: [`record::view`]; needs `record` |
//! | `study` | many cases of a scenario: [`study`]; needs `scenario` |
//! | `fmu` | co-simulation by FMI 3.0: [`fmu`]; needs `scenario` |
//! | `cli` | the program: [`cli`]; needs `fmu`, `import`, `record` and `study` |
//! | `parquet` | datasets of studies, `export --parquet`; needs `study` |
//! | `friction` | [`statics::standing`]: whether scenes with contact or dry friction stand |
//! | `count-allocations` | what `bench` says of the allocator; needs `cli` |
//!
//! # Modules, in reading order
//!
//! | module | its one job |
//! |---|---|
//! | [`spatial`] | mechanics of one rigid body: wrenches, symmetric tensors, rotation vectors |
//! | [`model`] | what is simulated: a plain description, checked and compiled into a tree of links |
//! | [`hinge`] | the kinds of hinge: coordinates, elementary joints, conditions that close a loop |
//! | [`motion`] | where every link is and how fast it moves |
//! | [`force`] | the kinds of force between points of bodies: springs, bushings, ropes, curves, sliders, loads |
//! | [`transfer`] | the core: accelerations, reactions and tangents in O(n) |
//! | [`constraint`] | closed loops, drives and gears: rows solved with the core's factorization |
//! | [`contact`] | solids that touch, and whether supports within cones hold a load |
//! | [`dynamics`] | `System`, a model with the forces [`applied`](dynamics::applied) to it: the one place where these meet `transfer` |
//! | [`output`] | what a user asks of a scene, as numbers |
//! | [`linear`] | the equations about a place, linear: states, inputs, outputs |
//! | [`statics`] | the equilibrium and its certificate: residual, stability, modes |
//! | [`integrate`] | time stepping; knows nothing of mechanics |
//! | [`record`] | the samples of a run: memory, MCAP files, the Rerun picture |
//! | [`simulate`] | the time loop, the energy ledger, the rest proof |
//! | [`simulator`] | a scene that is stepped from outside |
//! | [`mesh`] | triangle meshes from files: STL, OBJ, glTF |
//! | [`import`] | models of other programs (URDF, MJCF), turned into scenario text |
//! | [`scenario`] | scenario files: the only place that knows TOML |
//! | [`study`] | many cases of one scenario: plans, distributions, rows, datasets |
//! | [`fmu`] | co-simulation by FMI 3.0 |
//! | [`cli`] | the program: the only place that prints |
//! | [`formula`] | formulas in named variables with exact derivatives |
//! | [`quantity`] | numbers with units |
//! | [`pages`] | lists in large pages of memory |
//! | [`round_off`] | when a number is only noise |
//! | [`sparse`] | sparse matrices, factorized in an order that keeps them so |
//! | [`suggest`] | “did you mean …?” |
//! | [`text_file`] | reading text, with a limit |
//! | [`whole_file`] | writing files that appear whole or not at all |
//! | [`foreign`] | foreign parsers, whose panics become errors |
//! | [`budget`] | how much an input may ask for before it is refused |
//!
//! SI units and radians everywhere; `world_from_body` is a pose that takes body axes to inertial ones; quaternions are
//! w, x, y, z. Errors name the element, the value and what is allowed.

#![forbid(unsafe_code)]

pub mod budget;
#[cfg(feature = "cli")]
pub mod cli;
pub mod constraint;
pub mod contact;
pub mod dynamics;
pub mod element;
pub mod extrapolate;
pub mod fem;
#[cfg(feature = "fmu")]
pub mod fmu;
pub mod force;
pub mod foreign;
pub mod formula;
pub mod hinge;
#[cfg(feature = "scenario")]
pub mod import;
pub mod integrate;
pub mod linear;
#[cfg(any(feature = "fmu", feature = "record"))]
mod markup;
#[cfg(any(feature = "record", feature = "scenario"))]
pub mod mesh;
pub mod model;
pub mod motion;
pub mod output;
pub mod pages;
pub mod quantity;
pub mod record;
pub mod round_off;
#[cfg(feature = "scenario")]
pub mod scenario;
pub mod simulate;
pub mod simulator;
pub mod sparse;
pub mod spatial;
pub mod statics;
#[cfg(feature = "study")]
pub mod study;
pub mod suggest;
#[cfg(feature = "scenario")]
pub mod text_file;
pub mod transfer;
pub mod whole_file;
