//! Structures of a scene with stages: what is closed, open and locked, and the scene that follows from it.
//!
//! Every structure is a scene of its own: the same bodies in the same order, with other hinges and other rows. A hinge that has
//! opened is a free hinge against the ground; what acted in its coordinates goes with it. A locked hinge has a drive that
//! stands still for each of its coordinates.

mod order;

use super::Model;
use super::beam::lay_once;
use super::couple::on_one_part;
use super::couplings::{CoordinateName, DriveDescription, MotionDescription};
use super::description::{Description, HingeDescription, HingeKind, WatchedDescription};
use super::output::{Output, QuantityDescription};
use super::problem::{Element, Problem};
use super::stage::{StageDescription, Verb, When};
use crate::hinge::DECLARED;
use crate::spatial::Pose;
use crate::suggest;
use nalgebra::UnitQuaternion;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// What stages change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The hinge of this body.
    Hinge(usize),
    /// Index into `Description::loops`, to which those follow that close cables, cable by cable.
    Loop(usize),
    /// Index into `Description::contacts`.
    Contact(usize),
    /// Index into `Description::drives`.
    Drive(usize),
    /// Index into `Description::gears`.
    Gear(usize),
    /// Index into `Description::motors`.
    Motor(usize),
}

/// Everything that has a name which stages may use.
fn parts(description: &Description) -> impl Iterator<Item = (Part, &str)> {
    fn list<T>(all: &[T], part: fn(usize) -> Part, name: fn(&T) -> &str) -> impl Iterator<Item = (Part, &str)> {
        all.iter().enumerate().map(move |(index, one)| (part(index), name(one)))
    }
    list(&description.bodies, Part::Hinge, |one| &one.name)
        .chain(list(&description.loops, Part::Loop, |one| &one.name))
        .chain(cables(description))
        .chain(list(&description.contacts, Part::Contact, |one| &one.name))
        .chain(list(&description.drives, Part::Drive, |one| &one.name))
        .chain(list(&description.gears, Part::Gear, |one| &one.name))
        .chain(list(&description.motors, Part::Motor, |one| &one.name))
}

/// The loops of cables, which have their names.
fn cables(description: &Description) -> impl Iterator<Item = (Part, &str)> {
    let cables = description.beams.iter().filter(|beam| beam.far.is_some());
    cables.enumerate().map(|(index, cable)| (Part::Loop(description.loops.len() + index), cable.name.as_str()))
}

/// What a verb and a name mean. A loop (or anything else that is no hinge) is locked by closing it, released by opening it.
fn meant(description: &Description, verb: Verb, name: &str) -> Option<(Verb, Part)> {
    let (part, _) = parts(description).find(|(_, known)| *known == name)?;
    Some(match (part, verb) {
        (Part::Hinge(_), verb) => (verb, part),
        (_, Verb::Lock) => (Verb::Close, part),
        (_, Verb::Release) => (Verb::Open, part),
        (_, verb) => (verb, part),
    })
}

/// What is open, locked and free at a time of a run.
#[derive(Debug, Clone, Default)]
pub struct Structure {
    /// Loops, contacts, drives, gears and motors that are open.
    absent: BTreeSet<Part>,
    /// Bodies whose hinges have opened, with the poses of their root markers then.
    pub freed: BTreeMap<usize, Pose>,
    /// Bodies whose hinges are locked, with the coordinates that they are held at; `None`: as given.
    pub locked: BTreeMap<usize, Option<Vec<f64>>>,
    /// Turns of the loops' frames in their second bodies.
    pub frames: BTreeMap<usize, UnitQuaternion<f64>>,
    /// Stages that have come.
    done: BTreeSet<usize>,
}

/// A change that contradicts what is.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// The list that names it.
    pub verb: Verb,
    /// The place in the list.
    pub index: usize,
    /// What is wrong.
    pub why: String,
}

/// What is wrong with a change of a hinge that is there no more.
const HAS_OPENED: &str = "has opened before";

impl Structure {
    /// Before the first stage: what is opened or released first is closed, what is closed or locked first is open.
    pub fn first(description: &Description) -> Self {
        let mut structure = Self::default();
        let mut seen = BTreeSet::new();
        for (verb, _, name) in description.stages.iter().flat_map(StageDescription::named) {
            match meant(description, verb, name) {
                Some((_, part)) if !seen.insert(part) => {}
                Some((Verb::Release, Part::Hinge(body))) => drop(structure.locked.insert(body, None)),
                Some((Verb::Close, part)) => drop(structure.absent.insert(part)),
                _ => {}
            }
        }
        structure
    }

    /// Changes what a stage says. Poses, coordinates and frames of what changes are the caller's.
    ///
    /// # Errors
    /// If it opens what is open, closes what is closed, and so on; nothing is changed then.
    pub fn apply(&mut self, description: &Description, stage: usize) -> Result<(), Contradiction> {
        let mut next = self.clone();
        for (verb, index, name) in description.stages[stage].named() {
            let Some((meant, part)) = meant(description, verb, name) else { continue };
            if let Some(why) = next.change(meant, part) {
                return Err(Contradiction { verb, index, why: format!("`{name}` {why}") });
            }
        }
        next.done.insert(stage);
        *self = next;
        Ok(())
    }

    /// Changes one part; what contradicts that, if anything does.
    fn change(&mut self, meant: Verb, part: Part) -> Option<&'static str> {
        match (meant, part) {
            (Verb::Open | Verb::Lock | Verb::Release, Part::Hinge(body)) if self.freed.contains_key(&body) => {
                Some(HAS_OPENED)
            }
            (Verb::Open, Part::Hinge(body)) => {
                self.locked.remove(&body);
                self.freed.insert(body, Pose::identity());
                None
            }
            (Verb::Close, Part::Hinge(_)) => Some("cannot close"),
            (Verb::Lock, Part::Hinge(body)) => self.locked.insert(body, None).map(|_| "is locked already"),
            (Verb::Release, Part::Hinge(body)) => self.locked.remove(&body).is_none().then_some("is not locked"),
            (Verb::Open | Verb::Release, part) => (!self.absent.insert(part)).then_some("is open already"),
            (Verb::Close | Verb::Lock, part) => (!self.absent.remove(&part)).then_some("is closed already"),
        }
    }

    /// Whether a stage has come.
    pub fn has_come(&self, stage: usize) -> bool {
        self.done.contains(&stage)
    }

    /// Whether a loop is closed.
    pub fn is_closed(&self, index: usize) -> bool {
        !self.absent.contains(&Part::Loop(index))
    }

    /// Everything that is ever there, closed: what a recording has columns for.
    pub fn everything(description: &Description) -> Self {
        let locks = description.stages.iter().flat_map(|stage| stage.lock.iter().chain(&stage.release));
        let locked = locks.filter_map(|name| match meant(description, Verb::Lock, name)? {
            (_, Part::Hinge(body)) => Some((body, None)),
            _ => None,
        });
        Self { locked: locked.collect(), ..Self::default() }
    }

    /// That with those welds open that open at one time or other: a loop that closes again what was welded is there beside none of them.
    pub fn everything_but_welds(description: &Description) -> Self {
        let is_weld = |body: &usize| description.bodies[*body].hinge.kind == HingeKind::Fixed;
        let open = Self::ever_freed(description).into_iter().filter(is_weld);
        Self { freed: open.map(|body| (body, Pose::identity())).collect(), ..Self::everything(description) }
    }

    /// The bodies whose hinges open at one time or other.
    pub fn ever_freed(description: &Description) -> BTreeSet<usize> {
        let opened = description.stages.iter().flat_map(|stage| &stage.open);
        let hinge = |name: &String| match meant(description, Verb::Open, name)? {
            (_, Part::Hinge(body)) => Some(body),
            _ => None,
        };
        opened.filter_map(hinge).collect()
    }

    /// The scene of this structure: without stages, and with runs that end at the events of those that have not come.
    pub fn describe(&self, whole: &Description) -> Description {
        fn keep<T>(list: &mut Vec<T>, keeps: impl Fn(usize, &T) -> bool) {
            let mut index = 0;
            list.retain(|one| {
                index += 1;
                keeps(index - 1, one)
            });
        }
        // Cables lie as in the positions of the file, wherever the bodies at their ends are by now and whether they are closed.
        let opens = |part: &Part| cables(whole).any(|(cable, _)| cable == *part);
        let is_as_given = self.freed.is_empty() && !self.absent.iter().any(opens);
        let whole = &if is_as_given { Cow::Borrowed(whole) } else { Cow::Owned(lay_once(whole)) };
        let mut scene = Description { stages: Vec::new(), ..Description::clone(whole) };
        let is_freed = |name: &str| self.freed.keys().any(|body| whole.bodies[*body].name == name);
        for (body, pose) in &self.freed {
            let turn = pose.rotation;
            let at = pose.translation.vector;
            scene.bodies[*body].hinge = HingeDescription {
                position: vec![at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k],
                ..HingeDescription::new(HingeKind::Free)
            };
        }
        for (index, frame) in &self.frames {
            scene.loops[*index].second_frame = Some(*frame);
        }
        let stays = |part: Part| !self.absent.contains(&part);
        keep(&mut scene.loops, |index, _| stays(Part::Loop(index)));
        keep(&mut scene.contacts, |index, _| stays(Part::Contact(index)));
        keep(&mut scene.drives, |index, one| stays(Part::Drive(index)) && !is_freed(&one.coordinate.body));
        keep(&mut scene.gears, |index, one| {
            stays(Part::Gear(index)) && !one.between.iter().any(|one| is_freed(&one.body))
        });
        keep(&mut scene.motors, |index, one| stays(Part::Motor(index)) && !is_freed(&one.coordinate.body));
        scene.events.retain(|event| !matches!(&event.of, WatchedDescription::Hinge { body, .. } if is_freed(body)));
        for (body, held) in &self.locked {
            scene.drives.extend(locks(whole, *body, held.as_deref()));
        }
        for (index, stage) in whole.stages.iter().enumerate() {
            let When::Event(name) = &stage.when else { continue };
            let awaited = scene.events.iter_mut().filter(|event| event.name == *name && !self.has_come(index));
            awaited.for_each(|event| event.stops = true);
        }
        scene
    }
}

/// Drives that hold the coordinates of a hinge. They do not touch the given positions, from which ramps and gears begin.
fn locks(whole: &Description, body: usize, held: Option<&[f64]>) -> Vec<DriveDescription> {
    let (name, hinge) = (&whole.bodies[body].name, &whole.bodies[body].hinge);
    let count = hinge.kind.plain_coordinates();
    let drive = |index: usize| {
        let motion = match held.and_then(|held| held.get(index)) {
            None => MotionDescription::Hold,
            // It has ended before every run begins.
            Some(to) => MotionDescription::Ramp { to: *to, begin: -2.0, duration: 1.0 },
        };
        let label = if count == 1 { format!("{name}.lock") } else { format!("{name}.lock[{index}]") };
        DriveDescription { name: label, coordinate: CoordinateName { body: name.clone(), index }, motion }
    };
    (0..count).map(drive).collect()
}

/// The model before the first stage, which knows the whole scene.
pub(super) fn build(
    whole: &Description,
    build: impl Fn(&Description) -> Result<Model, Vec<Problem>>,
) -> Result<Model, Vec<Problem>> {
    // What is wrong without regard to stages is said at its own place; whether the ends of a loop that closes later are on one part then, in the
    // structure in which it closes.
    let first = Structure::first(whole);
    let is_later = |problem: &Problem| on_one_part(problem).is_some_and(|index| !first.is_closed(index));
    if let Err(mut problems) = build(&Description { stages: Vec::new(), ..whole.clone() }) {
        problems.retain(|problem| !is_later(problem));
        if !problems.is_empty() {
            return Err(problems);
        }
    }
    let mut problems = check(whole);
    if problems.is_empty() {
        problems = order::check(whole);
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut first: Option<Model> = None;
    let problems = each(whole, |scene| {
        let model = build(scene)?;
        let Some(first) = &first else {
            first = Some(model);
            return Ok(Vec::new());
        };
        let is_other = |(one, other): &(&Output, &Output)| one.units != other.units;
        let other = first.outputs.iter().zip(&model.outputs).find(is_other);
        Ok(other.map(|(output, _)| changed(&output.name)).into_iter().collect())
    })?;
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut model = first.expect("the structure before the first stage");
    model.stages = Some(std::sync::Arc::new(whole.clone()));
    Ok(model)
}

/// An output whose numbers are others in another structure.
fn changed(name: &str) -> Problem {
    Problem {
        element: Element::Scene,
        field: String::new(),
        message: format!("the output `{name}` is of other numbers than before"),
        help: Some(
            "of a body whose hinge opens ask for `position`, `velocity`, `orientation` in place of its coordinates"
                .to_owned(),
        ),
    }
}

/// What is wrong with the scenes of all structures: that before the first stage, and those that the stages leave in the order of the
/// file.
///
/// # Errors
/// The first scene that cannot be asked, or stages that contradict each other.
pub(super) fn each(
    whole: &Description,
    mut ask: impl FnMut(&Description) -> Result<Vec<Problem>, Vec<Problem>>,
) -> Result<Vec<Problem>, Vec<Problem>> {
    let mut structure = Structure::first(whole);
    let mut of = |structure: &Structure, stage: Option<usize>| match ask(&structure.describe(whole)) {
        Ok(found) => Ok(said(whole, stage, found)),
        Err(problems) => Err(said(whole, stage, problems)),
    };
    let mut found = of(&structure, None)?;
    for stage in 0..whole.stages.len() {
        let told = |wrong: Contradiction| {
            let Contradiction { verb, index, why } = wrong;
            let message = format!("stage `{}`: {why}", whole.stages[stage].name);
            let help = "stages are gone through in the order of the file here; each may come once".to_owned();
            vec![Problem {
                element: Element::Stage(stage),
                field: format!("{}[{index}]", verb.key()),
                message,
                help: Some(help),
            }]
        };
        structure.apply(whole, stage).map_err(told)?;
        found.extend(of(&structure, Some(stage))?);
    }
    Ok(found)
}

/// Problems of the scene that a stage leaves, at the stage: the elements of that scene have no places in a file.
fn said(whole: &Description, stage: Option<usize>, problems: Vec<Problem>) -> Vec<Problem> {
    let (element, when) = match stage {
        Some(stage) => (Element::Stage(stage), format!("after stage `{}`", whole.stages[stage].name)),
        None => (Element::Stage(0), "before the first stage".to_owned()),
    };
    let at_stage = |problem: Problem| {
        let Problem { message, help, .. } = absent(whole, stage, &problem).unwrap_or(problem);
        Problem { element, field: String::new(), message: format!("{when}: {message}"), help }
    };
    problems.into_iter().map(at_stage).collect()
}

/// The problem of an output that asks for the force of what a stage has opened, or closes later: it has none in between.
fn absent(whole: &Description, stage: Option<usize>, problem: &Problem) -> Option<Problem> {
    let come = stage.map_or(0, |stage| stage + 1);
    whole.outputs.iter().find_map(|output| {
        let QuantityDescription::Force { of, .. } = &output.of else { return None };
        if !(problem.message.contains(&format!("`{}`", output.name)) && problem.message.contains(&format!("`{of}`"))) {
            return None;
        }
        let opens = |one: &&StageDescription| one.open.contains(of);
        let closes = |one: &&StageDescription| one.close.contains(of);
        let (name, does) = match whole.stages[..come].iter().rfind(opens) {
            Some(stage) => (&stage.name, "opens"),
            None => (&whole.stages[come..].iter().find(closes)?.name, "closes"),
        };
        let message = format!("output `{}` asks for the force of `{of}`, which stage `{name}` {does}", output.name);
        let help =
            "what is open has no force: leave the output out, or take one of what is always there, as a `reaction`";
        Some(Problem { message, help: Some(help.to_owned()), ..problem.clone() })
    })
}

/// What is wrong with stages by themselves.
fn check(description: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (index, stage) in description.stages.iter().enumerate() {
        let name = &stage.name;
        let mut add = |field: String, message: String, help: Option<String>| {
            problems.push(Problem { element: Element::Stage(index), field, message, help });
        };
        if description.stages[..index].iter().any(|other| other.name == *name) {
            add("name".to_owned(), format!("two stages are called `{name}`"), Some("names must be unique".to_owned()));
        }
        check_when(description, stage, &mut add);
        let mut seen: BTreeMap<&str, Verb> = BTreeMap::new();
        for (verb, place, of) in stage.named() {
            let field = format!("{}[{place}]", verb.key());
            if let Some(first) = seen.insert(of, verb) {
                let message = format!("stage `{name}` names `{of}` in `{}` and in `{}`", first.key(), verb.key());
                add(field, message, Some("it does one of them at one instant; make two stages".to_owned()));
                continue;
            }
            if let Some((message, help)) = wrong_name(description, verb, of) {
                add(field, format!("stage `{name}`: {message}"), help);
            }
        }
        for (place, output) in stage.outputs.iter().enumerate() {
            if !description.outputs.iter().any(|one| one.name == *output) {
                let near = suggest::closest(output, description.outputs.iter().map(|one| one.name.as_str()));
                let help = near.map(|near| format!("did you mean `{near}`?"));
                add(format!("outputs[{place}]"), format!("stage `{name}`: there is no output `{output}`"), help);
            }
        }
        if stage.named().next().is_none() {
            let help = "give `open`, `close`, `lock` or `release`";
            add(String::new(), format!("stage `{name}` changes nothing"), Some(help.to_owned()));
        }
    }
    if let Some(one) = description.controllers.first().filter(|_| !description.stages.is_empty()) {
        let message = format!("a scene with the controller `{}` has no stages", one.name);
        let help = Some("motors follow their laws through all stages".to_owned());
        problems.push(Problem { element: Element::Stage(0), field: String::new(), message, help });
    }
    problems
}

fn check_when(
    description: &Description,
    stage: &StageDescription,
    add: &mut dyn FnMut(String, String, Option<String>),
) {
    let name = &stage.name;
    match &stage.when {
        When::Time(time) if !(*time >= 0.0 && time.is_finite()) => {
            add("when.time".to_owned(), format!("stage `{name}` comes at {time} s"), Some("allowed: ≥ 0 s".to_owned()));
        }
        When::Time(_) => {}
        When::Event(event) => match description.events.iter().find(|one| one.name == *event) {
            None => {
                let near = suggest::closest(event, description.events.iter().map(|one| one.name.as_str()));
                let help = near.map(|near| format!("did you mean `{near}`?"));
                add("when.event".to_owned(), format!("stage `{name}`: there is no event `{event}`"), help);
            }
            Some(one) if one.stops => {
                let message = format!("stage `{name}` never comes: the run ends at its event `{event}`");
                add("when.event".to_owned(), message, Some("take `action = \"stop\"` off the event".to_owned()));
            }
            Some(_) => {}
        },
    }
}

/// What is wrong with a name in a list.
fn wrong_name(description: &Description, verb: Verb, name: &str) -> Option<(String, Option<String>)> {
    let known = || parts(description).filter(|(_, known)| *known == name);
    let Some((_, part)) = meant(description, verb, name) else {
        let near = suggest::closest(name, parts(description).map(|(_, name)| name));
        let message = format!("there is no hinge, loop, cable, contact, drive, gear or motor `{name}`");
        return Some((message, near.map(|near| format!("did you mean `{near}`?"))));
    };
    if known().count() > 1 {
        let help = "give one of them another name".to_owned();
        return Some((format!("`{name}` is the name of a body and of something else"), Some(help)));
    }
    let Part::Hinge(body) = part else { return None };
    let kind = &description.bodies[body].hinge.kind;
    let (all, plain) = (kind.counts().0, kind.plain_coordinates());
    match verb {
        Verb::Close => {
            let closes = DECLARED.iter().any(|one| one.name == kind.name() && one.closes.is_some());
            let help = match closes {
                true => "let the body be free at first, and close a `[[loop]]` of this type".to_owned(),
                false => format!(
                    "no `[[loop]]` is of the type `{}`: let the hinge be closed from the beginning, and `lock` what it leaves free, or close a \
                     `[[loop]]` of another type",
                    kind.name()
                ),
            };
            Some((format!("the hinge of `{name}` cannot close"), Some(help)))
        }
        Verb::Lock | Verb::Release if description.bodies[body].hinge.lock => {
            let help = match verb {
                Verb::Release => "take off `lock = true`: a hinge that a stage releases is locked until then",
                _ => "take off `lock = true`: a hinge that a stage locks is free until then",
            };
            Some((format!("the hinge of `{name}` has `lock = true`, which holds in all stages"), Some(help.to_owned())))
        }
        Verb::Lock | Verb::Release if all == 0 || plain < all => {
            let help = "a `[[loop]]` of `type = \"fixed\"` holds two bodies as they stand when it closes".to_owned();
            Some((format!("the {} hinge of `{name}` has no coordinates that a lock holds", kind.name()), Some(help)))
        }
        _ => None,
    }
}
