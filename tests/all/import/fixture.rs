//! Robots written in a few lines.

use std::path::Path;
use stillpoint::import::{Imported, Options};
use stillpoint::scenario::{self, LoadError};

/// A link of 2 kg whose centre is half a metre below its origin.
pub(super) fn link(name: &str) -> String {
    format!(
        "<link name=\"{name}\"><inertial><origin xyz=\"0 0 -0.5\"/><mass value=\"2\"/>\
         <inertia ixx=\"0.2\" iyy=\"0.2\" izz=\"0.05\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n"
    )
}

/// A joint with everything but its ends in `inner`.
pub(super) fn joint(name: &str, kind: &str, ends: [&str; 2], inner: &str) -> String {
    let [parent, child] = ends;
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{inner}</joint>\n"
    )
}

/// A robot with a root `base` that weighs nothing.
pub(super) fn robot(inner: &str) -> String {
    format!("<robot name=\"test\">\n<link name=\"base\"/>\n{inner}</robot>\n")
}

pub(super) fn import(text: &str, options: &Options) -> Imported {
    scenario::convert_text(Path::new("robot.urdf"), text.to_owned(), options).unwrap_or_else(|error| panic!("{error}"))
}

/// What is said of a robot that must be refused.
pub(super) fn refused(text: &str) -> String {
    match scenario::convert_text(Path::new("robot.urdf"), text.to_owned(), &Options::default()) {
        Ok(imported) => panic!("it was taken:\n{}", imported.scenario),
        Err(LoadError::Problems(problems)) => problems.to_string(),
        Err(other) => other.to_string(),
    }
}

/// The notes, a line each.
pub(super) fn notes(imported: &Imported) -> String {
    let line = |note: &stillpoint::import::Note| {
        format!("{}: {}: {}: {}\n", note.line, note.verdict.word(), note.element, note.what)
    };
    imported.notes.iter().map(line).collect()
}
