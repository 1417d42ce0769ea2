//! Columns of a table of cases that would have one name.

use super::answer::{Question, columns, output_columns, told};
use super::column::Column;
use crate::force::Act;
use crate::model::{Element, Model, Problem};
use crate::scenario::Scenario;
use std::collections::HashSet;

/// What is wrong with the names of outputs: they are those of other columns, in a table that has these `beside` the answers.
pub(super) fn clashes(scenario: &Scenario, model: &Model, question: &Question, beside: &[Column]) -> Vec<Problem> {
    let own = output_columns(model, question).count();
    let answers = columns(scenario, model, question);
    let others = &answers[..answers.len() - own];
    let taken: HashSet<&str> = beside.iter().chain(others).map(|column| column.name.as_str()).collect();
    let mut problems: Vec<Problem> = Vec::new();
    for one in output_columns(model, question).filter(|one| taken.contains(one.name.as_str())) {
        let (element, name) = (Element::Output(one.output), &model.outputs[one.output].name);
        if problems.last().is_some_and(|last| last.element == element) {
            continue;
        }
        problems.push(Problem {
            element,
            field: "name".to_owned(),
            message: format!(
                "an output cannot be called `{name}` in a sweep, whose table has a column `{}` of something else",
                one.name
            ),
            help: Some(
                "give it another name: that is one of a coordinate, a force, what is varied, or of every case"
                    .to_owned(),
            ),
        });
    }
    problems
}

/// What is wrong with the names of elements: two columns would be called like this one. None if no element is named so.
pub(super) fn twice(model: &Model, name: &str) -> Vec<Problem> {
    let found = owners(model, name);
    // Bodies are named by much else: another element is renamed more easily.
    let Some((element, own)) = found.iter().find(|(element, _)| !matches!(element, Element::Body(_))).or(found.first())
    else {
        return Vec::new();
    };
    let others: Vec<&str> =
        found.iter().filter(|(other, _)| other != element).map(|(_, words)| words.as_str()).collect();
    let message = match others[..] {
        [] => format!(
            "two columns of a sweep would be called `{name}`: that of {own}, and one of what is varied or answered"
        ),
        _ => format!(
            "two columns of a sweep would be called `{name}`: that of {own}, and that of {}",
            others.join(" and of ")
        ),
    };
    vec![Problem {
        element: *element,
        field: "name".to_owned(),
        message,
        help: Some("give one of them another name".to_owned()),
    }]
}

/// The elements that have a column of this name, in words.
fn owners(model: &Model, name: &str) -> Vec<(Element, String)> {
    let mut all = Vec::new();
    let mut add = |column: String, element: Element, words: &dyn Fn() -> String| {
        if column == name {
            all.push((element, words()));
        }
    };
    for (index, drive) in model.drives.iter().enumerate() {
        add(format!("drives.{}", drive.name), Element::Drive(index), &|| {
            format!("the force of the drive `{}`", drive.name)
        });
    }
    for (index, motor) in model.motors.iter().enumerate() {
        add(format!("motors.{}", motor.name), Element::Motor(index), &|| {
            format!("the force of the motor `{}`", motor.name)
        });
    }
    for (index, force) in model.forces.iter().enumerate().filter(|(_, force)| force.law.pull_name().is_some()) {
        add(format!("pulls.{}", force.name), Element::Force(index), &|| format!("the pull of `{}`", force.name));
    }
    for (index, body) in model.bodies.iter().enumerate() {
        for (coordinate, _) in body.hinge.kind.positions() {
            let words = || format!("the coordinate `{coordinate}` of the body `{}`", body.name);
            add(format!("{}.{coordinate}", body.name), Element::Body(index), &words);
            add(format!("final {}.{coordinate}", body.name), Element::Body(index), &words);
        }
    }
    let stages = model.stages.iter().flat_map(|whole| &whole.stages);
    for (index, stage) in stages.enumerate() {
        for (_, output) in told(model).filter(|(of, _)| of.name == stage.name) {
            for label in output.labels() {
                let words = || format!("`{label}` at the stage `{}`", stage.name);
                add(format!("{}.{label}", stage.name), Element::Stage(index), &words);
            }
        }
    }
    all
}
