//! Whether stages agree with each other at their instants: in the order of their times, whatever their order in the file.

use super::{HAS_OPENED, Part, Structure, meant};
use crate::model::description::Description;
use crate::model::problem::{Element, Problem, number};
use crate::model::stage::{Verb, When};
use std::collections::{BTreeMap, BTreeSet};

/// What a stage does to a part.
#[derive(Debug, Clone, Copy)]
struct Change {
    stage: usize,
    /// The list that names it, and the place in it.
    written: Verb,
    index: usize,
    meant: Verb,
}

/// What is wrong with the times of stages that are sound by themselves.
pub(super) fn check(whole: &Description) -> Vec<Problem> {
    let mut changes: BTreeMap<Part, Vec<Change>> = BTreeMap::new();
    for (stage, described) in whole.stages.iter().enumerate() {
        for (written, index, name) in described.named() {
            if let Some((meant, part)) = meant(whole, written, name) {
                changes.entry(part).or_default().push(Change { stage, written, index, meant });
            }
        }
    }
    changes.retain(|_, of| of.len() > 1);
    let twice: Vec<Problem> = changes.values().filter_map(|of| at_once(whole, of)).collect();
    if twice.is_empty() { by_time(whole, &changes) } else { twice }
}

/// Two stages of one instant that undo each other: whichever comes first, nothing has moved between them.
fn at_once(whole: &Description, changes: &[Change]) -> Option<Problem> {
    let binds = |verb: Verb| matches!(verb, Verb::Lock | Verb::Close);
    let undo = |a: Verb, b: Verb| binds(a) != binds(b);
    let when = |change: &Change| &whole.stages[change.stage].when;
    let pairs = changes.iter().enumerate().flat_map(|(k, later)| changes[..k].iter().map(move |first| (first, later)));
    let (first, later) = pairs.into_iter().find(|(first, later)| {
        first.stage != later.stage && when(first) == when(later) && undo(first.meant, later.meant)
    })?;
    let name = |change: &Change| &whole.stages[change.stage].name;
    let part =
        whole.stages[later.stage].named().find(|(verb, index, _)| (*verb, *index) == (later.written, later.index));
    let message = format!(
        "stage `{}` names `{}` in `{}`, and stage `{}` in `{}` at the same instant, {}",
        name(later),
        part.map_or("", |(_, _, part)| part),
        later.written.key(),
        name(first),
        first.written.key(),
        when(later)
    );
    let help = "nothing moves between the two: keep one of them, or let one come later".to_owned();
    Some(problem(later, message, help))
}

/// What contradicts itself in the order of the times; parts that stages at events change, too, are known in a run alone.
fn by_time(whole: &Description, changes: &BTreeMap<Part, Vec<Change>>) -> Vec<Problem> {
    let time = |stage: usize| match whole.stages[stage].when {
        When::Time(time) => Some(time),
        When::Event(_) => None,
    };
    let mut structure = Structure::first(whole);
    let mut told = BTreeSet::new();
    let mut problems = Vec::new();
    for (part, of) in changes {
        let Some(mut timed) = of.iter().map(|change| Some((time(change.stage)?, change))).collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        timed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let opened = timed.iter().find(|(_, change)| change.meant == Verb::Open).map(|(time, _)| *time);
        for (time, change) in timed {
            let Some(why) = structure.change(change.meant, *part) else { continue };
            if !told.insert(*part) {
                continue;
            }
            let stage = &whole.stages[change.stage];
            let name = stage.named().find(|(verb, index, _)| (*verb, *index) == (change.written, change.index));
            let name = name.map_or("", |(_, _, name)| name);
            let at = number(time);
            let message = match opened.filter(|_| why == HAS_OPENED) {
                Some(before) => {
                    let before = number(before);
                    format!("stage `{}` comes at t = {at} s: `{name}` has opened at t = {before} s already", stage.name)
                }
                None => format!("stage `{}`: `{name}` {why} at t = {at} s", stage.name),
            };
            let help = "stages come at their times, whatever their order in the file; what `lock` or `close` names first in \
                        the file is open until then, what `release` or `open` names first is not";
            problems.push(problem(change, message, help.to_owned()));
        }
    }
    problems
}

fn problem(change: &Change, message: String, help: String) -> Problem {
    let field = format!("{}[{}]", change.written.key(), change.index);
    Problem { element: Element::Stage(change.stage), field, message, help: Some(help) }
}
