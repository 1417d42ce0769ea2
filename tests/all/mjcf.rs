//! Models of MuJoCo: they move as MuJoCo moves them, and nothing of them is lost in silence.

mod actuator_defaults;
mod aligned;
mod attached;
mod compare;
mod contacts;
mod features;
mod losses;
mod refused;
mod taken;
mod torture;

use std::path::Path;
use stillpoint::import::{Imported, Options, Refused, import_text};
use stillpoint::scenario::{Scenario, parse};

/// Imports a text as if it were a file beside the tests' models.
fn import(text: &str) -> Result<Imported, Refused> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models/mjcf/model.xml");
    import_text(&path, text.to_owned(), &Options::default())
}

/// The scenario of a model that is fine.
fn scenario(text: &str) -> Scenario {
    let imported = import(text).unwrap_or_else(|refused| panic!("{refused}"));
    parse("model.toml", &imported.scenario, &[]).unwrap_or_else(|problems| panic!("{problems}\n{}", imported.scenario))
}

/// A model with this in its world.
fn world(inner: &str) -> String {
    format!("<mujoco><worldbody>{inner}</worldbody></mujoco>")
}
