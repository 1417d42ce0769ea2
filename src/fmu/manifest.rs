//! `resources/manifest.json`: which scenario an FMU is of.

use super::FmuError;
use crate::text_file;
use serde_json::{Value, json};
use std::path::Path;

/// The name of its file in the folder of resources.
pub const MANIFEST: &str = "manifest.json";

/// What an instance starts from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Manifest {
    /// The instantiation token of the model description.
    pub token: String,
    /// The scenario file, from the folder of resources; with `/` between folders.
    pub scenario: String,
    /// What is set in it, as `path=value`.
    pub set: Vec<String>,
    /// Addresses of numbers that are parameters beside those of `[parameters]`.
    pub parameters: Vec<String>,
}

impl Manifest {
    /// As JSON.
    pub fn to_json(&self) -> String {
        let Self { token, scenario, set, parameters } = self;
        let value = json!({ "token": token, "scenario": scenario, "set": set, "parameters": parameters });
        format!("{value:#}\n")
    }

    /// Reads it from a folder of resources.
    ///
    /// # Errors
    /// If it is not there or was not written by this program.
    pub fn read(resources: &Path) -> Result<Self, FmuError> {
        let path = resources.join(MANIFEST);
        let text = text_file::read(&path, "manifest").map_err(|error| FmuError::Resources(error.to_string()))?;
        let wrong = || FmuError::Resources(format!("{}: this is no manifest of an FMU of stillpoint", path.display()));
        let value: Value = serde_json::from_str(&text).map_err(|_| wrong())?;
        let string = |value: &Value| value.as_str().map(str::to_owned);
        let list = |key: &str| value[key].as_array()?.iter().map(string).collect::<Option<Vec<_>>>();
        let read = || {
            Some(Self {
                token: string(&value["token"])?,
                scenario: string(&value["scenario"])?,
                set: list("set")?,
                parameters: list("parameters")?,
            })
        };
        read().ok_or_else(wrong)
    }
}
