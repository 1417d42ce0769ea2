//! Models of other programs, turned into scenario text.
//!
//! ```text
//! robot.urdf ─ xml ─► elements with places ─ urdf │ mjcf ─► Draft ─► scenario text + where each part came from
//!                          │
//!                          └ log: notes (what was taken how), problems (why it cannot be taken)
//! ```
//!
//! An importer reads every element and attribute that it understands; `xml` keeps count, and what nobody has read
//! becomes a note by itself. Nothing is dropped in silence, nothing is guessed: what cannot be meant is a problem, and
//! all problems of a file are said at once.

#[cfg(feature = "import")]
mod bounds;
#[cfg(feature = "import")]
mod draft;
#[cfg(feature = "import")]
mod files;
// Without importers nobody has anything to say.
#[cfg_attr(not(feature = "import"), allow(dead_code))]
mod log;
#[cfg(feature = "import")]
mod mend;
#[cfg(feature = "import")]
mod mjcf;
#[cfg(feature = "import")]
mod urdf;
#[cfg(feature = "import")]
mod xml;

pub use log::{Note, Place, Problem, Refused, Source, Taken, counted, ignored_kinds};

use crate::text_file;
#[cfg(feature = "import")]
use draft::Draft;
use log::Log;
use std::path::{Path, PathBuf};

/// How a model is taken.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Put before the name of every body, so that a model can be taken twice.
    pub prefix: String,
    /// The root moves freely; otherwise it is fixed to the ground.
    pub floating: bool,
    /// Limits of joints are left out.
    pub without_limits: bool,
    /// Dry friction of joints is left out.
    pub without_friction: bool,
    /// What collides in the model touches: its shapes, and if the model says which pairs, these.
    pub contact: bool,
    /// Joints of a URDF that follow others are let go.
    pub without_mimics: bool,
    /// Joints on which nothing with mass or inertia hangs are fixed: their motion would be undetermined.
    pub weld_massless: bool,
    /// Where the root stands (m).
    pub at: [f64; 3],
    /// How the root is turned: roll, pitch, yaw (rad).
    pub rpy: [f64; 3],
    /// The folder from which the scenario text finds its meshes; if it is not given, the folder of the model.
    pub folder: Option<PathBuf>,
    /// The keyframe of an MJCF model that is the start, by name or number from 0; the first one where it is not given.
    pub key: Option<String>,
    /// Folders of packages by name, for `package://name/…`.
    pub packages: Vec<(String, PathBuf)>,
    /// Folders that hold packages, as `ROS_PACKAGE_PATH` lists them.
    pub package_path: Vec<PathBuf>,
}

impl Options {
    /// Nothing but the package folders that the environment names (`ROS_PACKAGE_PATH`).
    pub fn from_environment() -> Self {
        let listed = std::env::var_os("ROS_PACKAGE_PATH");
        let package_path = listed.iter().flat_map(std::env::split_paths).filter(|path| path.is_absolute()).collect();
        Self { package_path, ..Self::default() }
    }
}

/// Whether a text is meant as a model: it starts as XML does.
pub fn is_model(text: &str) -> bool {
    text.trim_start_matches('\u{feff}').trim_start().starts_with('<')
}

/// The scenario that takes a model and says nothing else, for the model's folder.
pub fn alone(path: &Path) -> String {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    format!("model = {}\n", toml_edit::Value::from(file.as_ref()))
}

/// A model, as a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// In the project's own format, with comments that say where things came from.
    pub scenario: String,
    /// The files that were read, the first one that was asked for.
    pub sources: Vec<Source>,
    /// Parts of the scenario by address (`body[3].hinge.axis`), and where they are written in the sources.
    pub origins: Vec<(String, Place)>,
    /// What was not taken as it stands, in the order of the file.
    pub notes: Vec<Note>,
    /// Names of joints, and of the bodies by which the scenario names their hinges.
    pub joints: Vec<(String, String)>,
    /// The most that a motor may do in a hinge (N or N m, as a scenario writes it), by the name of the body.
    pub efforts: Vec<(String, String)>,
}

/// Turns a regular file into a scenario, by its root element.
///
/// # Errors
/// If the file cannot be read or is not a model that is known, and if something in it makes no sense: then with
/// all problems at once.
pub fn import(path: &Path, options: &Options) -> Result<Imported, Refused> {
    let text = text_file::read_regular(path, "model")?;
    import_text(path, text, options)
}

/// As [`import`], of a text that has been read. `path` is what it is called in messages; meshes are found from its folder.
///
/// # Errors
/// As [`import`].
#[cfg(feature = "import")]
pub fn import_text(path: &Path, text: String, options: &Options) -> Result<Imported, Refused> {
    let mut log = Log::new(path, text);
    let read = read(&log, path, options);
    match read {
        Some(draft) if log.is_fine() => {
            let (scenario, notes) = (draft.text(), log.notes());
            let Draft { origins, joints, efforts, .. } = draft;
            Ok(Imported { scenario, sources: log.into_sources(), origins, notes, joints, efforts })
        }
        _ => Err(Refused::Problems { problems: log.take_problems(), sources: log.into_sources() }),
    }
}

/// Always an error in this build.
///
/// # Errors
/// Always.
#[cfg(not(feature = "import"))]
pub fn import_text(path: &Path, text: String, _options: &Options) -> Result<Imported, Refused> {
    let mut log = Log::new(path, text);
    log.refuse(Problem {
        place: None,
        message: format!("`{}` is a model: this program was built without the `import` feature", path.display()),
        label: String::new(),
        help: Some("build it with `--features import` (it is on by default)".to_owned()),
    });
    Err(Refused::Problems { problems: log.take_problems(), sources: log.into_sources() })
}

#[cfg(feature = "import")]
fn read(log: &Log, path: &Path, options: &Options) -> Option<Draft> {
    let text = mend::readable(log.text(0), 0, log);
    let document = xml::parse(&text, 0, log)?;
    let root = xml::root(&document, 0, log);
    match root.name() {
        "robot" => urdf::read(&root, path, options),
        "mujoco" => mjcf::read(&root, path, options),
        other => {
            let message = format!("<{other}> is not a model that can be read");
            log.refuse(
                Problem::at(root.place(), message)
                    .help("a model is a URDF file, with <robot> around everything, or MJCF, with <mujoco>"),
            );
            None
        }
    }
}
