//! Paths: an equilibrium followed while one number of the scene moves, around folds, with all that happens on the way.
//!
//! Every branch is a curve in positions and parameter. Between two of its points
//!
//! - the parameter turns back: a **fold**, where the tangent's parameter part passes zero;
//! - the number of negative directions changes without that: a **bifurcation**, where the stiffness of one direction
//!   passes zero; other branches leave along that direction, and are followed too;
//! - the motion loses its stability without either: **flutter**, which only loads without a potential can do.
//!
//! Each is located on the curve itself to round-off, by a root of what passes zero there. If a hinge comes to a stop or
//! lifts off one the branch ends, and goes on as another one, on which the stop bears or no longer does.

mod stops;
mod trace;

use super::certify::bearing::{Set, borne};
use super::certify::equilibrium::Equilibrium;
use super::certify::stability::StabilityVerdict;
use super::family::Moving;
use super::problem::assembled::Assembled;
use super::search::{Observers, equilibrium_observed};
use crate::model::description::Description;
use crate::model::problem::{in_one_line, number};
use crate::model::{Model, Parameter};
use crate::spatial::{Pose, Wrench};
use std::cell::RefCell;
use std::collections::VecDeque;
use stops::Beginning;
use trace::{OffStops, Seed, StopChange, Tracer, seeds};

/// Branches that are followed, the first one included.
const MOST_BRANCHES: usize = 24;

/// The `(statics.path)` table.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSettings {
    /// The number that moves, as it is written.
    pub parameter: String,
    /// What it stands for: all are given the same value.
    pub numbers: Vec<Parameter>,
    /// Where the path starts, in units of the parameter.
    pub from: f64,
    /// The other end of its range.
    pub to: f64,
    /// Values at which points are wanted, within the range.
    pub at: Vec<f64>,
    /// Largest step: 1 is the whole range, or a radian or a length of every coordinate.
    pub step: f64,
    /// Most points of a branch.
    pub points: usize,
    /// Whether branches are followed from bifurcations.
    pub branches: bool,
    /// The coordinate that is drawn against the parameter; `None` for the one that moves most.
    pub coordinate: Option<Parameter>,
}

/// What a path found.
#[derive(Debug, Clone)]
pub struct Path {
    /// Branches in the order they were found; the first one starts at the equilibrium at `from`. None where there is no
    /// such equilibrium.
    pub branches: Vec<PathBranch>,
    /// The equilibrium at `from`, or the best that was found.
    pub start: Equilibrium,
    /// Whether every branch was followed to an end of the range, or into itself.
    pub complete: bool,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// One curve of equilibria.
#[derive(Debug, Clone)]
pub struct PathBranch {
    /// Branch and point of the bifurcation that it leaves from.
    pub parent: Option<(usize, usize)>,
    /// Its points, neighbours in order.
    pub points: Vec<PathPoint>,
    /// How it ends.
    pub end: BranchEnd,
}

/// How a branch ends.
#[derive(Debug, Clone, PartialEq)]
pub enum BranchEnd {
    /// At an end of the range.
    Range,
    /// In its own first point.
    Closed,
    /// At a stop of a hinge, which bears from there on or no longer does.
    Stop {
        /// The hinge, as in [`Model::label`].
        hinge: String,
        /// The limit (m or rad).
        limit: f64,
        /// Whether the hinge lifts off it.
        lifts: bool,
    },
    /// After as many points as were asked for.
    Points,
    /// Where it cannot be followed further, and why.
    Lost(String),
}

/// One equilibrium of a path.
#[derive(Debug, Clone)]
pub struct PathPoint {
    /// Value of the parameter.
    pub parameter: f64,
    /// Arclength since the first point of the branch, no unit.
    pub arclength: f64,
    /// Hinge coordinates.
    pub position: Vec<f64>,
    /// Root markers of the named bodies: `world_from_body`.
    pub poses: Vec<Pose>,
    /// What the hinge passes to each named body at its root marker, inertial axes.
    pub reactions: Vec<Wrench>,
    /// Potential energy (J).
    pub potential: f64,
    /// Outputs, in the order of the model.
    pub outputs: Vec<f64>,
    /// Largest unbalanced force relative to the forces that cancel there.
    pub relative_residual: f64,
    /// What kind of equilibrium it is.
    pub verdict: StabilityVerdict,
    /// Directions that run away.
    pub unstable_directions: usize,
    /// Whether it is one of the values that were asked for.
    pub wanted: bool,
    /// What happens here.
    pub event: Option<PathEvent>,
}

/// What happens at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct PathEvent {
    /// Its kind.
    pub kind: EventKind,
    /// Directions that change sides.
    pub directions: usize,
    /// Bodies whose hinges carry it, most of it first.
    pub carriers: Vec<String>,
}

/// Kinds of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The parameter turns back: a limit load.
    Fold,
    /// Branches meet.
    Bifurcation,
    /// The motion about it begins to grow while the balance stays regular.
    Flutter,
    /// A hinge comes to a stop.
    Stop,
    /// A hinge lifts off its stop.
    Lift,
}

impl EventKind {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::Bifurcation => "bifurcation",
            Self::Flutter => "flutter",
            Self::Stop => "stop",
            Self::Lift => "lift",
        }
    }
}

/// Where a branch begins on which other stops bear.
enum Change {
    /// At the end of another one.
    Stop(StopChange),
    /// At a bifurcation.
    Off(OffStops),
}

impl Change {
    /// The stops that bear on it.
    fn set(&self) -> &Set {
        match self {
            Self::Stop(change) => &change.set,
            Self::Off(off) => &off.set,
        }
    }

    /// Its first point, beside this one of its parent.
    fn seed(&self, tracer: &mut Tracer<'_>, point: &PathPoint, parent: (usize, usize)) -> Beginning {
        match self {
            Self::Stop(change) => {
                tracer.onward(change, parent).map_or(Beginning::Nowhere, |seed| Beginning::At(Box::new(seed)))
            }
            Self::Off(off) => tracer.leaving(off, point, parent),
        }
    }

    /// Where its branch begins, with a tracer for the stops that bear on it; each that closes there is taken into the set.
    fn begin<'t>(
        &mut self,
        point: &PathPoint,
        parent: (usize, usize),
        tracer: &mut dyn FnMut(&Set) -> Result<Tracer<'t>, String>,
    ) -> Result<(Tracer<'t>, Option<Seed>), String> {
        loop {
            let mut tracer = tracer(self.set())?;
            match self.seed(&mut tracer, point, parent) {
                Beginning::At(seed) => return Ok((tracer, Some(*seed))),
                Beginning::Nowhere => return Ok((tracer, None)),
                Beginning::Closes(index, side) => match self {
                    Self::Stop(change) => change.set[index] = Some(side),
                    Self::Off(off) => off.set[index] = Some(side),
                },
            }
        }
    }

    /// What is said if it has none.
    fn missing(&self, model: &Model, settings: &PathSettings, at: f64, branch: usize) -> String {
        let (at, parameter) = (number(at), &settings.parameter);
        match self {
            Self::Stop(change) => {
                let stop = model.label(model.stops[change.index].velocity);
                format!(
                    "branch {branch} ends on the stop of {stop} at `{parameter}` = {at}: none was found that goes on from there"
                )
            }
            Self::Off(_) => format!("bifurcation at {at}: no branch was found within a step of it off its stops"),
        }
    }
}

/// Follows the equilibrium that is found at `from`.
///
/// # Errors
/// If the scene cannot be evaluated at the start, and if nothing feels the parameter.
pub fn follow(
    description: &Description,
    statics: &super::Settings,
    settings: &PathSettings,
    go_on: &mut dyn FnMut(f64) -> bool,
) -> Result<Path, String> {
    let mut first = description.clone();
    settings.numbers.iter().try_for_each(|one| one.set(&mut first, settings.from))?;
    let model = Model::build(&first).map_err(|problems| in_one_line(&problems))?;
    let (model, assembled) = Assembled::of(model)?;
    let asked = RefCell::new(&mut *go_on);
    let goes_on = || (asked.borrow_mut())(settings.from);
    let observers = Observers { go_on: Some(&goes_on), ..Observers::default() };
    let start = equilibrium_observed(&model, statics, &model.start_position, observers);
    let start = start.map_err(|fault| fault.to_string())?;
    let mut path = Path { branches: Vec::new(), complete: start.converged, start, notes: Vec::new() };
    if !path.start.converged {
        let from = number(settings.from);
        path.notes.push(format!("no path: there is no equilibrium at `{}` = {from} to start from", settings.parameter));
        return Ok(path);
    }
    let set = borne(&model, &path.start);
    let range = (settings.to - settings.from).abs();
    let q = path.start.position.clone();
    let numbers = &settings.numbers;
    let family = |at: f64, q: &[f64], set: Set| Moving::new(&first, assembled.clone(), numbers, at, range, (q, set));
    let mut moving = family(settings.from, &q, set.clone())?;
    // What only a stop feels is felt.
    if set.iter().all(Option::is_none) && !moving.is_felt(&q, settings.from)? {
        return Err(format!("nothing in this equilibrium feels `{}`: there is no path to follow", settings.parameter));
    }
    if path.start.stability.as_ref().is_some_and(|s| s.neutral_directions > 0) {
        moving.set_neutral();
    }
    let mut tracer = Tracer::new(moving, settings);
    let mut queue = VecDeque::from([tracer.first(&q)?]);
    let mut changes: VecDeque<(Change, (usize, usize))> = VecDeque::new();
    // The stops that bear along each branch.
    let mut sets: Vec<Set> = Vec::new();
    loop {
        let Some(seed) = queue.pop_front() else {
            let Some((mut change, parent)) = changes.pop_front() else { break };
            let point = path.branches[parent.0].points[parent.1].clone();
            let mut with = |set: &Set| {
                family(point.parameter, &point.position, set.clone()).map(|moving| Tracer::new(moving, settings))
            };
            let (next, seed) = change.begin(&point, parent, &mut with)?;
            tracer = next;
            if seed.is_none() {
                path.complete &= matches!(change, Change::Off(_));
                path.notes.push(change.missing(&model, settings, point.parameter, parent.0));
            }
            queue.extend(seed);
            continue;
        };
        if path.branches.len() == MOST_BRANCHES {
            path.complete = false;
            path.notes.push(format!("stopped after {MOST_BRANCHES} branches: there are more"));
            break;
        }
        let set = tracer.moving.set().clone();
        if path.branches.iter().zip(&sets).any(|(branch, of)| *of == set && tracer.is_on(&seed, branch)) {
            continue;
        }
        let index = path.branches.len();
        let (branch, change) = tracer.trace(seed, go_on)?;
        if let BranchEnd::Lost(reason) = &branch.end {
            let at = branch.points.last().map_or(settings.from, |point| point.parameter);
            let at = number(at);
            path.notes.push(format!("branch {index} is lost at `{}` = {at}: {reason}", settings.parameter));
            path.complete = false;
        }
        path.complete &= branch.end != BranchEnd::Points;
        if settings.branches {
            queue.extend(seeds(&mut tracer, &branch, index, &mut path.notes));
        }
        let off = std::mem::take(&mut tracer.off_stops);
        if settings.branches {
            changes.extend(off.into_iter().map(|(at, off)| (Change::Off(off), (index, at))));
        }
        changes.extend(change.map(|change| (Change::Stop(change), (index, branch.points.len() - 1))));
        path.branches.push(branch);
        sets.push(set);
    }
    Ok(path)
}

impl Path {
    /// Points with an event, with the index of their branch.
    pub fn events(&self) -> impl Iterator<Item = (usize, &PathPoint)> {
        self.branches.iter().enumerate().flat_map(|(index, branch)| {
            branch.points.iter().filter(|point| point.event.is_some()).map(move |point| (index, point))
        })
    }
}
