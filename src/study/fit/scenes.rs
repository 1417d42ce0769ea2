//! The scene of an experiment: the scenario with the numbers of its row and the parameters that are fitted.

use super::Trouble;
use crate::model::description::OutputDescription;
use crate::model::parameter::Field;
use crate::model::{Model, Parameter};
use crate::scenario::{Diagnostics, Override, Scenario, parse};

/// Where a number comes from, as messages have it: from the data, or from the search.
const OPTION: &str = "fit:";
/// Scenes that are read and scenes whose numbers are set are compared at this part beside the start.
const BESIDE: f64 = 1.0 + 1.0 / 64.0;

/// Makes scenes of some numbers.
pub(super) struct Scenes<'s> {
    scenario: &'s Scenario,
    set: &'s [Override],
    /// What the numbers set: addresses of the rows, followed by those of the parameters.
    paths: Vec<String>,
    /// What each path sets, if that needs no reading.
    direct: Option<Vec<Vec<Parameter>>>,
    /// Coordinates that are measured and are no outputs of the scene.
    more: Vec<OutputDescription>,
}

impl<'s> Scenes<'s> {
    /// Scenes of these paths; `start` are numbers that make one.
    ///
    /// # Errors
    /// If they make none.
    pub(super) fn new(
        (scenario, set): (&'s Scenario, &'s [Override]),
        paths: Vec<String>,
        start: &[f64],
        more: Vec<OutputDescription>,
    ) -> Result<Self, Trouble> {
        let mut scenes = Self { scenario, set, paths, direct: None, more };
        scenes.read(start).map_err(Trouble::Problems)?;
        scenes.direct = scenes.directly(start);
        Ok(scenes)
    }

    /// What the paths set, if all of them are plain numbers and setting them gives the scenes that are read.
    fn directly(&self, start: &[f64]) -> Option<Vec<Vec<Parameter>>> {
        let find = |path: &String| Parameter::find(&self.scenario.description, path).ok();
        let numbers = self.paths.iter().map(find).collect::<Option<Vec<_>>>()?;
        if numbers.iter().flatten().any(|one| one.field == Field::Named) {
            return None;
        }
        let beside: Vec<f64> = start.iter().map(|x| x * BESIDE).collect();
        for values in [start, &beside] {
            let read = self.read(values).ok()?;
            let set = self.set_directly(&numbers, values).ok()?;
            let settings = |one: &Scenario| {
                (one.simulate.clone(), one.statics, one.unknown.clone(), one.aim.clone(), one.margin.clone())
            };
            if read.description != set.description || settings(&read) != settings(&set) {
                return None;
            }
        }
        Some(numbers)
    }

    fn set_directly(&self, numbers: &[Vec<Parameter>], values: &[f64]) -> Result<Scenario, String> {
        let mut scenario = self.scenario.clone();
        for (numbers, value) in numbers.iter().zip(values) {
            numbers.iter().try_for_each(|one| one.set(&mut scenario.description, *value))?;
        }
        scenario.description.outputs.extend(self.more.iter().cloned());
        Ok(scenario)
    }

    fn read(&self, values: &[f64]) -> Result<Scenario, Diagnostics> {
        let changes = self.paths.iter().zip(values).filter_map(|(path, value)| change(path, *value));
        let changes: Vec<Override> = self.set.iter().cloned().chain(changes).collect();
        let mut scenario = parse(&self.scenario.name, &self.scenario.text, &changes)?;
        scenario.description.outputs.extend(self.more.iter().cloned());
        Ok(scenario)
    }

    /// The scenario with these numbers.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(super) fn at(&self, values: &[f64]) -> Result<Scenario, String> {
        match &self.direct {
            // What is wrong with numbers that make no scene is said by who reads them.
            Some(numbers) => match self.set_directly(numbers, values) {
                Ok(scenario) if Model::build(&scenario.description).is_ok() => Ok(scenario),
                _ => self.read(values).map_err(|problems| first(&problems)),
            },
            None => self.read(values).map_err(|problems| first(&problems)),
        }
    }
}

/// The first problem, in one line.
fn first(problems: &Diagnostics) -> String {
    problems.iter().next().map_or_else(String::new, |first| first.message.clone())
}

/// As written after `--set`.
fn change(path: &str, value: f64) -> Option<Override> {
    Override::of_option(OPTION, &format!("{path}={value:?}")).ok()
}

/// Whether a path can be set to a number.
///
/// # Errors
/// What is wrong with it.
pub(super) fn accepts(scenario: &Scenario, set: &[Override], path: &str, value: f64) -> Result<(), Diagnostics> {
    let changes: Vec<Override> = set.iter().cloned().chain(change(path, value)).collect();
    parse(&scenario.name, &scenario.text, &changes).map(|_| ())
}
