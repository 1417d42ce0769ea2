//! The scenes of a plan that are looked at before its cases: those whose columns a study can have.

use super::axis;
use super::case::{Cases, Refusal, VARY};
use super::plan::{Value, texts};
use crate::model::Parameter;
use crate::scenario::{Diagnostics, Override, Scenario, parse};

/// Cases, or values of a path, that are tried where the middle of a plan makes no scene.
const TRIED: u64 = 16;

impl Cases {
    /// The scenes whose columns a study can have: one, and one more for every value of an axis that is no plain number of
    /// the scene, such as the copies of a body.
    pub(super) fn scenes(&self) -> Result<Vec<(Scenario, Vec<Override>)>, Refusal> {
        let (base, first) = self.base()?;
        let mut scenes = vec![(first, self.changes(&base))];
        for (index, axis) in self.plan.axes.iter().enumerate() {
            if Parameter::find(&self.scenario.description, &axis.path).is_ok() {
                continue;
            }
            for value in &axis.values {
                let mut values = base.clone();
                values[index] = Some(value.clone());
                let scene = self.read_some(&values).ok();
                scenes.extend(scene.map(|scene| (scene, self.changes(&values))));
            }
        }
        Ok(scenes)
    }

    /// Values of the plan that make a scene, and the scene: the middle of the plan, else one of its cases, else the file as it is,
    /// without any value. What must be there at the start are the addresses, and values that fit each by itself: cases that make
    /// no scene are rows with their reason.
    fn base(&self) -> Result<(Vec<Option<String>>, Scenario), Refusal> {
        let problems = match self.read(&self.median()) {
            Ok(scene) => return Ok((self.median().into_iter().map(Some).collect(), scene)),
            Err(problems) => problems,
        };
        for case in spread(self.plan.cases()) {
            let values = self.in_units(&self.plan.values(case));
            if let Ok(scene) = self.read(&values) {
                return Ok((values.into_iter().map(Some).collect(), scene));
            }
        }
        let paths = self.plan.axes.len() + self.plan.varied.len();
        let none = vec![None; paths];
        for index in 0..paths {
            let alone = |value: String| {
                let mut values = none.clone();
                values[index] = Some(value);
                self.read_some(&values)
            };
            let mut values = self.values_of(index);
            // Refused whatever it is: the address, or its kind.
            if !values.any(|value| alone(value).is_ok()) {
                return Err(problems.into());
            }
        }
        Ok((none, self.scenario.clone()))
    }

    /// Values that a path has in the plan: some of an axis, some of a distribution.
    fn values_of(&self, index: usize) -> Box<dyn Iterator<Item = String> + '_> {
        match index.checked_sub(self.plan.axes.len()) {
            None => {
                let values = &self.plan.axes[index].values;
                Box::new(spread(values.len() as u64).map(|place| values[place as usize].clone()))
            }
            Some(varied) => {
                let varied = &self.plan.varied[varied];
                let parts = (1..=TRIED).map(|part| part as f64 / (TRIED + 1) as f64);
                Box::new(parts.map(|u| varied.written(varied.distribution.quantile(u))))
            }
        }
    }

    /// Values as they are written after `--set`, with the units of the distributions: that these fit is seen so.
    fn in_units(&self, values: &[Value<'_>]) -> Vec<String> {
        let varied = self.plan.axes.iter().map(|_| None).chain(self.plan.varied.iter().map(Some));
        let each = values.iter().zip(varied).map(|(value, varied)| match (value, varied) {
            (Value::Drawn(number), Some(varied)) => varied.written(*number),
            (value, _) => texts(std::slice::from_ref(value)).concat(),
        });
        each.collect()
    }

    /// The first value of every axis, and the median of every distribution, as written.
    fn median(&self) -> Vec<String> {
        let axes = self.plan.axes.iter().map(|axis| axis.values[0].clone());
        axes.chain(self.plan.varied.iter().map(|one| one.median.clone())).collect()
    }

    pub(super) fn read(&self, values: &[String]) -> Result<Scenario, Diagnostics> {
        self.read_some(&values.iter().cloned().map(Some).collect::<Vec<_>>())
    }

    /// The scene in which some paths have these values, and the others what the file says.
    fn read_some(&self, values: &[Option<String>]) -> Result<Scenario, Diagnostics> {
        parse(&self.scenario.name, &self.scenario.text, &self.changes(values))
    }

    /// The changes that all cases have, and these values of some paths.
    fn changes(&self, values: &[Option<String>]) -> Vec<Override> {
        let axes = self.plan.axes.len();
        let option = |index: usize| if index < axes { axis::OPTION } else { VARY };
        let named = self.plan.paths().zip(values).enumerate();
        // Neither path nor value is empty: both have been read before.
        let changes = named.filter_map(|(i, (path, value))| {
            Override::of_option(option(i), &format!("{path}={}", value.as_ref()?)).ok()
        });
        self.set.iter().cloned().chain(changes).collect()
    }
}

/// Some places of so many, over all of them.
fn spread(count: u64) -> impl Iterator<Item = u64> {
    let tried = count.min(TRIED);
    (0..tried).map(move |place| place * (count - 1) / (tried - 1).max(1))
}
