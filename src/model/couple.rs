//! Loops, drives and gears: what they must satisfy, and what they are compiled to.

use super::build::{Place, Places};
use super::couplings::{Closure, CoordinateName, GearKind, LoopDescription, MotionDescription};
use super::description::Description;
use super::prescribed::Prescribed;
use super::problem::{Element, Problem, number};
use super::{End, Link, Model};
use super::{controller, motor};
use crate::round_off::{PIVOT, RATIO};
use crate::suggest;
use nalgebra::{Matrix3, UnitQuaternion};
use std::collections::HashMap;

/// What closes a loop, compiled.
#[derive(Debug, Clone)]
pub struct Loop {
    /// Name.
    pub name: String,
    /// What joins the ends.
    pub closure: Closure,
    /// Both ends.
    pub ends: [End; 2],
    /// The loop's frame on the first link: `link_from_loop`.
    pub frame: Matrix3<f64>,
    /// The loop's frame on the second link; `None` if it follows from the positions as they are given.
    pub second_frame: Option<Matrix3<f64>>,
}

/// A hinge coordinate that is a plain number: of a turn or of a slide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scalar {
    /// The link whose elementary hinge it is.
    pub link: usize,
    /// Index into the positions.
    pub position: usize,
    /// Index into the velocities.
    pub velocity: usize,
    /// Whether it is a distance.
    pub slides: bool,
}

/// A driven coordinate, compiled.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Name.
    pub name: String,
    /// What is driven.
    pub coordinate: Scalar,
    /// How it moves.
    pub motion: Prescribed,
    /// What has been added to the armature of its coordinate (kg, kg m²): a motion that is given needs no inertia, but the
    /// articulated inertia of its hinge is divided by. With the row `q̈ = s̈` of the drive nothing else feels it:
    /// `(M + a e eᵀ) q̈ = f + e λ'` is `M q̈ = f + e λ` with `λ = λ' − a q̈`. 0 where the body of the hinge itself resists.
    pub armature: f64,
}

/// A gear, compiled: `q₁ − ratio q₂ = offset`.
#[derive(Debug, Clone)]
pub struct Gear {
    /// Name.
    pub name: String,
    /// Both coordinates.
    pub coordinates: [Scalar; 2],
    /// `dq₁/dq₂` (1, m/rad).
    pub ratio: f64,
    /// As given, or from the positions as they are given.
    pub offset: f64,
}

/// What is wrong with a loop between two bodies that move as one.
const WELDED: &str = "bodies welded together cannot close a loop";

/// Whether a problem is that of a loop whose ends are on one rigid part, which they may be no longer once a hinge has opened; that loop.
pub(super) fn on_one_part(problem: &Problem) -> Option<usize> {
    match problem.element {
        Element::Loop(index) if problem.help.as_deref() == Some(WELDED) => Some(index),
        _ => None,
    }
}

/// Resolves the ends of the loops.
pub(super) fn loop_places(description: &Description, places: &mut Places<'_>) -> Vec<[Place; 2]> {
    let ends = |(index, closed): (usize, &LoopDescription)| {
        let element = Element::Loop(index);
        [
            places.resolve(&closed.between[0], element, "between[0]"),
            places.resolve(&closed.between[1], element, "between[1]"),
        ]
    };
    description.loops.iter().enumerate().map(ends).collect()
}

/// Problems of loops, drives and gears that need no tree.
pub(super) fn check(description: &Description, problems: &mut Vec<Problem>) {
    let mut add = |element: Element, field: &str, message: String, help: &str| {
        let help = (!help.is_empty()).then(|| help.to_owned());
        problems.push(Problem { element, field: field.to_owned(), message, help });
    };
    let names = [
        ("loops", description.loops.iter().map(|x| &x.name).collect::<Vec<_>>()),
        ("drives", description.drives.iter().map(|x| &x.name).collect()),
        ("gears", description.gears.iter().map(|x| &x.name).collect()),
    ];
    for (what, names) in names {
        let mut seen = HashMap::new();
        for (index, name) in names.into_iter().enumerate() {
            if seen.insert(name, index).is_some() {
                let element = match what {
                    "loops" => Element::Loop(index),
                    "drives" => Element::Drive(index),
                    _ => Element::Gear(index),
                };
                add(element, "name", format!("two {what} are called `{name}`"), "names must be unique");
            }
        }
    }
    for (index, closed) in description.loops.iter().enumerate() {
        let is_flexible = description.modals.iter().any(|modal| modal.body == closed.between[0].body);
        check_loop(index, closed, is_flexible, &mut add);
    }
    for (index, drive) in description.drives.iter().enumerate() {
        let (element, name) = (Element::Drive(index), &drive.name);
        for (field, value, least) in numbers(&drive.motion) {
            if !value.is_finite() || value < least {
                let allowed = if least > 0.0 { "allowed: a finite number > 0" } else { "allowed: a finite number" };
                add(element, field, format!("`{field}` of `{name}` is {value}"), allowed);
            }
        }
    }
    for (index, gear) in description.gears.iter().enumerate() {
        let (field, value) = match gear.kind {
            GearKind::Ratio { ratio } => ("ratio", ratio),
            GearKind::Rack { radius } => ("radius", radius),
            GearKind::Screw { lead } => ("lead", lead),
        };
        if !value.is_finite() || value == 0.0 {
            let message = format!("`{field}` of `{}` is {value}", gear.name);
            add(Element::Gear(index), field, message, "allowed: a finite number that is not zero");
        }
        if let Some(offset) = gear.offset.filter(|offset| !offset.is_finite()) {
            let message = format!("`offset` of `{}` is {offset}", gear.name);
            add(Element::Gear(index), "offset", message, "allowed: a finite number");
        }
    }
}

/// The numbers of a motion with the least that each may be.
fn numbers(motion: &MotionDescription) -> Vec<(&'static str, f64, f64)> {
    let any = f64::NEG_INFINITY;
    match motion {
        MotionDescription::Hold | MotionDescription::Table { .. } | MotionDescription::Expression { .. } => vec![],
        MotionDescription::Rate { rate } => vec![("rate", *rate, any)],
        MotionDescription::Ramp { to, begin, duration } => {
            vec![("to", *to, any), ("begin", *begin, any), ("duration", *duration, f64::MIN_POSITIVE)]
        }
        MotionDescription::Sine { offset, amplitude, frequency, phase } => vec![
            ("offset", offset.unwrap_or(0.0), any),
            ("amplitude", *amplitude, any),
            ("frequency", *frequency, any),
            ("phase", *phase, any),
        ],
    }
}

fn check_loop(
    index: usize,
    closed: &LoopDescription,
    is_flexible: bool,
    add: &mut impl FnMut(Element, &str, String, &str),
) {
    let (element, name) = (Element::Loop(index), &closed.name);
    if closed.between[0].body == closed.between[1].body && !is_flexible {
        let message = format!("both ends of `{name}` are on `{}`", closed.between[0].body);
        add(element, "between", message, "a loop is closed between two different bodies");
    }
    match &closed.closure {
        Closure::Rod { length } if !(length.is_finite() && *length > 0.0) => {
            let message = format!("`length` of `{name}` is {length}");
            add(
                element,
                "length",
                message,
                "allowed: a finite number > 0 m; a rod without length is a spherical hinge",
            );
        }
        Closure::Rod { .. } => {}
        Closure::Hinge(kind) if kind.conditions().is_empty() => {
            add(element, "type", format!("`{name}` is {}", kind.name()), "a free hinge closes nothing");
        }
        Closure::Hinge(kind) => {
            kind.check(&format!("loop `{name}`"), &mut |key, message, help| add(element, key, message, help))
        }
    }
}

/// A coordinate by name; `None` if there is none, with the problem added.
pub(super) fn scalar(
    description: &Description,
    model: &Model,
    wanted: &CoordinateName,
    element: Element,
    field: &str,
    owner: &str,
    problems: &mut Vec<Problem>,
) -> Option<Scalar> {
    let before = problems.len();
    let mut add = |message: String, help: Option<String>| {
        problems.push(Problem { element, field: field.to_owned(), message, help });
    };
    let Some(body) = model.bodies.iter().find(|body| body.name == wanted.body) else {
        let known = description.bodies.iter().map(|body| body.name.as_str());
        let help = suggest::closest_of_many(before, &wanted.body, known).map(|near| format!("did you mean `{near}`?"));
        add(format!("there is no body `{}`", wanted.body), help);
        return None;
    };
    let kind = body.hinge.kind;
    let scalars: Vec<(usize, &Link)> = model
        .links
        .iter()
        .enumerate()
        .skip(1)
        .filter(|(_, link)| model.bodies[link.body].name == wanted.body && link.joint.is_scalar())
        .collect();
    let Some((index, link)) = scalars.get(wanted.index) else {
        let message = format!(
            "`{owner}`: the {} hinge of `{}` has no coordinate {} that is an angle or a distance",
            kind.name(),
            wanted.body,
            wanted.index
        );
        let help = match scalars.len() {
            0 => "a quaternion cannot be driven; build the turn from revolute hinges".to_owned(),
            count => format!("it has {count}, counted from 0"),
        };
        add(message, Some(help));
        return None;
    };
    let slides = link.joint.is_distance();
    Some(Scalar { link: *index, position: link.position, velocity: link.velocity, slides })
}

/// Compiles loops, drives and gears into a model whose tree is complete.
pub(super) fn couple(
    description: &Description,
    places: &[[Place; 2]],
    carrier: &dyn Fn(&Place) -> (End, UnitQuaternion<f64>),
    model: &mut Model,
) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (index, (closed, places)) in description.loops.iter().zip(places).enumerate() {
        let [(first, first_turn), (second, second_turn)] = [carrier(&places[0]), carrier(&places[1])];
        if first.link == second.link {
            let message = format!("both ends of `{}` are on the same rigid part", closed.name);
            let help = Some(WELDED.to_owned());
            problems.push(Problem { element: Element::Loop(index), field: "between".to_owned(), message, help });
        }
        let matrix = |turn: UnitQuaternion<f64>| *turn.to_rotation_matrix().matrix();
        model.loops.push(Loop {
            name: closed.name.clone(),
            closure: closed.closure,
            ends: [first, second],
            frame: matrix(first_turn * closed.frame),
            second_frame: closed.second_frame.map(|frame| matrix(second_turn * frame)),
        });
    }
    drives(description, model, &mut problems);
    gears(description, model, &mut problems);
    motor::motors(description, model, &mut problems);
    model.inputs = controller::inputs(&model.motors);
    problems
}

fn drives(description: &Description, model: &mut Model, problems: &mut Vec<Problem>) {
    let mut driven: HashMap<usize, &str> = HashMap::new();
    for (index, drive) in description.drives.iter().enumerate() {
        let element = Element::Drive(index);
        let coordinate = scalar(description, model, &drive.coordinate, element, "hinge", &drive.name, problems);
        let Some(coordinate) = coordinate else { continue };
        let mut add = |field: &str, message: String, help: &str| {
            problems.push(Problem { element, field: field.to_owned(), message, help: Some(help.to_owned()) });
        };
        let label = model.label(coordinate.velocity);
        if model.coordinates[coordinate.velocity].lock {
            add("hinge", format!("`{}` drives {label}, which is locked", drive.name), "take off the lock or the drive");
        }
        if let Some(other) = driven.insert(coordinate.velocity, &drive.name) {
            let message = format!("`{other}` and `{}` both drive {label}", drive.name);
            add("hinge", message, "one coordinate follows one motion");
        }
        match Prescribed::compile(&drive.motion, model.start_position[coordinate.position]) {
            Ok(motion) => {
                let armature = armature(model, &coordinate);
                model.coordinates[coordinate.velocity].armature += armature;
                model.drives.push(Drive { name: drive.name.clone(), coordinate, motion, armature });
            }
            Err(message) => {
                let field = match drive.motion {
                    MotionDescription::Table { .. } => "times",
                    MotionDescription::Expression { .. } => "expression",
                    _ => "type",
                };
                add(field, format!("`{}`: {message}", drive.name), "for example `expression = \"0.1*sin(2*pi*t)\"`");
            }
        }
    }
}

/// What a driven coordinate needs in addition to its own link's inertia: nothing where that resists in every position. Else the
/// inertia of what it carries, or of the scene: any number is exact, and one of that size keeps all digits.
fn armature(model: &Model, coordinate: &Scalar) -> f64 {
    let link = &model.links[coordinate.link];
    let (own, whole) = if coordinate.slides { (link.mass, 0.0) } else { (link.axial_inertia(), link.inertia.trace()) };
    if own + model.coordinates[coordinate.velocity].armature > PIVOT.of(whole) {
        return 0.0;
    }
    let subtree = &model.links[coordinate.link..link.subtree_end];
    let masses = [subtree, &model.links].map(|links| links.iter().map(|link| link.mass).sum::<f64>());
    let mass = masses.into_iter().find(|mass| *mass > 0.0).unwrap_or(1.0);
    let extent = subtree.iter().map(|link| model.bodies[link.body].extent()).fold(0.0, f64::max);
    let extent = if extent > 0.0 { extent } else { model.length_scale() };
    if coordinate.slides { mass } else { mass * extent * extent }
}

fn gears(description: &Description, model: &mut Model, problems: &mut Vec<Problem>) {
    // Gears whose first coordinate starts where they have it.
    let mut followers: Vec<usize> = Vec::new();
    for (index, gear) in description.gears.iter().enumerate() {
        let element = Element::Gear(index);
        let mut found = Vec::new();
        for (end, wanted) in gear.between.iter().enumerate() {
            let field = format!("between[{end}]");
            found.extend(scalar(description, model, wanted, element, &field, &gear.name, problems));
        }
        let [first, second] = found[..] else { continue };
        let mut add = |message: String, help: &str| {
            let (field, help) = ("between".to_owned(), Some(help.to_owned()));
            problems.push(Problem { element, field, message, help });
        };
        if first == second {
            add(format!("`{}` couples {} with itself", gear.name, model.label(first.velocity)), "name two coordinates");
            continue;
        }
        let fits = match gear.kind {
            GearKind::Ratio { .. } => first.slides == second.slides,
            GearKind::Rack { .. } | GearKind::Screw { .. } => first.slides && !second.slides,
        };
        if !fits {
            let what = |scalar: &Scalar| if scalar.slides { "a distance" } else { "an angle" };
            let message =
                format!("`{}` of type {} couples {} with {}", gear.name, gear.kind.name(), what(&first), what(&second));
            add(message, "a ratio couples two of a kind; a rack or a screw a distance (first) with an angle (second)");
        }
        let ratio = gear.kind.factor();
        let at = |scalar: &Scalar| model.start_position[scalar.position];
        let offset = gear.offset.unwrap_or_else(|| at(&first) - ratio * at(&second));
        let differs = |other: &&Gear| same_pair(&other.coordinates, &[first, second]) && !agrees(other, first, ratio);
        if let Some(other) = model.gears.iter().find(differs) {
            let message = format!(
                "`{}` gives {} and {} the ratio {}, the gear `{}` gives them a different one",
                gear.name,
                model.label(first.velocity),
                model.label(second.velocity),
                number(ratio),
                other.name
            );
            add(message, "two coordinates have one ratio");
        }
        model.gears.push(Gear { name: gear.name.clone(), coordinates: [first, second], ratio, offset });
        let own = description.bodies.iter().find(|body| body.name == gear.between[0].body);
        if gear.offset.is_some() && own.is_some_and(|body| body.hinge.position.is_empty()) {
            followers.push(model.gears.len() - 1);
        }
    }
    // One may follow another that follows: as many rounds as there are of them.
    for _ in 0..followers.len() {
        for index in &followers {
            let Gear { coordinates: [first, second], ratio, offset, .. } = model.gears[*index];
            model.start_position[first.position] = ratio * model.start_position[second.position] + offset;
        }
    }
}

fn same_pair(one: &[Scalar; 2], other: &[Scalar; 2]) -> bool {
    one == other || (one[0] == other[1] && one[1] == other[0])
}

fn agrees(other: &Gear, first: Scalar, ratio: f64) -> bool {
    let same = if other.coordinates[0] == first { other.ratio } else { 1.0 / other.ratio };
    RATIO.hides(same - ratio, ratio.abs())
}
