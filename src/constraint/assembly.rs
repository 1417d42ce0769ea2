//! Assembly: given positions and velocities are a guess; here they are brought onto the loops, drives and gears.

use super::close::{Closing, Metric, OpenGap};
use super::component::{between_ends, members, sharing};
use super::rank::decide;
use super::rows::{Owner, second_frame};
use super::{Constraints, RowGroup, RowSelection};
use crate::model::Model;
use crate::model::couplings::Closure;
use crate::model::problem::{Element, Problem, counted, rounded};
use crate::motion::Motion;
use crate::round_off;
use nalgebra::{DMatrix, DVector, Vector3};
use std::sync::Arc;

/// A gap below this part of its component's reach is closed; exact data close to round-off, numbers with six digits to
/// less.
const CLOSED: f64 = 1e-6;
/// Positions that moved by less than this part of the scene's length (or rad) are said to be where they were given.
const MOVED: f64 = 1e-6;

/// What assembly found.
#[derive(Debug, Clone, Default)]
pub struct Assembly {
    /// Degrees of freedom left by loops, gears and drives.
    pub degrees_of_freedom: usize,
    /// Loops and gears with rows that others already stand for: name, how many, of how many.
    pub redundant: Vec<(String, usize, usize)>,
    /// Widest gap at the positions as given (m; rad times the reach of the mechanism).
    pub given_gap: f64,
    /// Widest gap that is left.
    pub gap: f64,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Closes the loops of a model. The assembled model starts at positions and with velocities that all loops, drives and
/// gears agree with, the nearest to the given ones in the metric of the inertia, positions of many loops on one tree in
/// that of the coordinates; locked coordinates and given velocities stay as they are. A model without loops, drives and gears comes back as it is.
///
/// # Errors
/// If a gap cannot be closed, if gears leave nothing to move, or if a drive has nothing left to prescribe; each
/// names the element.
pub fn assemble(model: Arc<Model>) -> Result<(Arc<Model>, Assembly), Vec<Problem>> {
    assemble_at(model, 0.0)
}

/// [`assemble`] where drives are at a time (s).
///
/// # Errors
/// As [`assemble`].
pub fn assemble_at(model: Arc<Model>, time: f64) -> Result<(Arc<Model>, Assembly), Vec<Problem>> {
    if !model.is_constrained() {
        let assembly = Assembly { degrees_of_freedom: model.velocity_count(), ..Assembly::default() };
        return Ok((model, assembly));
    }
    let mut model = Arc::unwrap_or_clone(model);
    let assembly = close(&mut model, time)?;
    Ok((Arc::new(model), assembly))
}

/// The gap of a loop, drive or gear that is widest beside the scene's length (1 rad), where a model starts and drives are at a time (s);
/// `None` without any.
pub fn open_at(model: &Model, time: f64) -> Option<OpenGap> {
    if !model.is_constrained() {
        return None;
    }
    let mut closing = Closing::new(model, &RowSelection::default(), time);
    closing.gap(model, &model.start_position);
    Some(closing.widest_beside(model.length_scale()))
}

/// A state at time 0 that loops, drives and gears of an assembled model agree with, nearest to the one given, as [`assemble`] takes that
/// of a file: what is driven gives way first.
///
/// # Errors
/// As [`assemble`].
///
/// # Panics
/// If the numbers are not as many as the model has.
pub fn closed(model: &Arc<Model>, position: &[f64], velocity: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Vec<Problem>> {
    if !model.is_constrained() {
        return Ok((position.to_vec(), velocity.to_vec()));
    }
    let (model, _) = assemble(Arc::clone(model).starting_in(position, velocity))?;
    Ok((model.start_position.clone(), model.start_velocity.clone()))
}

/// Closes the loops of a model that nobody shares yet.
fn close(model: &mut Model, time: f64) -> Result<Assembly, Vec<Problem>> {
    freeze_frames(model);
    let mut notes = Vec::new();
    let (given_gap, gap) = close_positions(model, time, &mut notes)?;
    let ranking = decide(model, &RowSelection::default(), &model.start_position, time);
    let rows = Constraints::unplanned(model, &RowSelection::default());
    let mut problems = locked(model, &rows, &ranking.independent, &mut notes);
    problems.extend(overdriven(model, &rows, &ranking.independent, time));
    if !problems.is_empty() {
        return Err(problems);
    }
    if ranking.singular {
        notes.push(
            "the start is a singular position: around it the mechanism has fewer ways to move than there".to_owned(),
        );
    }
    let left_out = |element: &RowGroup| element.rows.clone().filter(|row| !ranking.independent[*row]).count();
    let redundant = rows.elements.iter().map(|element| (element.name.clone(), left_out(element), element.rows.len()));
    let redundant: Vec<_> = redundant.filter(|(_, left_out, _)| *left_out > 0).collect();
    let rank = ranking.independent.iter().filter(|row| **row).count();
    model.independent_rows = Some(ranking.independent);
    close_velocities(model, time, &mut notes)?;
    Ok(Assembly { degrees_of_freedom: model.velocity_count() - rank, redundant, given_gap, gap, notes })
}

/// Loops whose second frame follows from the given positions keep it from now on.
fn freeze_frames(model: &mut Model) {
    let mut given = Motion::new(model);
    given.update(model, &model.start_position, &vec![0.0; model.velocity_count()]);
    for closed in &mut model.loops {
        closed.second_frame = Some(second_frame(closed, &given));
    }
}

fn close_positions(model: &mut Model, time: f64, notes: &mut Vec<String>) -> Result<(f64, f64), Vec<Problem>> {
    let given = model.start_position.clone();
    let mut q = given.clone();
    let mut near = "the nearest assembly";
    let (given_widest, gap, widest) = {
        let mut closing = Closing::new(model, &RowSelection::locks(model), time);
        let relative = closing.gap(model, &q);
        let given_widest = closing.widest();
        let given_gap = given_widest.gap;
        let first = closing.of_guess();
        let mut gap =
            closing.close(model, &mut q, first).map_err(|singular| vec![undetermined(model, singular.link)])?;
        // From a stretched or symmetric guess no direction closes: look from a little beside it.
        let ways = (0..=4).flat_map(|attempt| [Metric::Coordinates, Metric::Inertia].map(|metric| (attempt, metric)));
        for (attempt, metric) in ways.filter(|way| *way != (0, first)) {
            if gap <= CLOSED {
                break;
            }
            let mut beside = given.clone();
            nudge(model, &mut beside, attempt);
            if let Ok(other) = closing.close(model, &mut beside, metric)
                && other < gap
            {
                (gap, q) = (other, beside);
                near = "one near them";
            }
        }
        closing.gap(model, &q);
        let mut widest = closing.widest();
        if gap < 1e-13 && relative <= gap {
            (widest.gap, widest.angle) = (given_gap, given_widest.angle);
        }
        (given_widest, gap, widest)
    };
    if !(gap <= CLOSED) {
        return Err(vec![cannot_close(model, &widest)]);
    }
    if let Some(turned) = turned_over(model, &q) {
        return Err(vec![turned]);
    }
    let (moved, furthest) = largest_move(model, &given, &q);
    if moved > MOVED {
        // Of many loops the one that is open most says little.
        let what = if given_widest.element.starts_with("loop") { "the loops" } else { given_widest.element.as_str() };
        notes.push(format!(
            "the given positions are a guess that leaves {what} open by {}: closed to {near}, up to {furthest} away",
            given_widest.words()
        ));
    }
    model.start_position = q;
    Ok((given_widest.gap, widest.gap))
}

/// Given velocities that are not zero, and those of hinges that no loop or drive concerns, weigh so much more than the
/// others that these give way.
const GIVEN: f64 = 1e-6;

/// The velocities nearest to the given ones that agree with loops, gears and drives.
fn close_velocities(model: &mut Model, time: f64, notes: &mut Vec<String>) -> Result<(), Vec<Problem>> {
    let q = model.start_position.clone();
    let given = model.start_velocity.clone();
    let mut closing = Closing::new(model, &RowSelection::default(), time);
    if let Some(independent) = &model.independent_rows {
        closing.rows.keep(|row| independent[row]);
    }
    let mut v = given.clone();
    let (before, open) = closing.speeds(model, &q, &v);
    // Turns and parts of reaches per second.
    let size = v.iter().fold(1.0 / model.time_scale(), |m, v| m.max(v.abs()));
    if open > round_off::CLOSED.of(size) {
        let yielding = yielding(model, &closing.rows, &given);
        let weights: Vec<f64> = yielding.iter().map(|yields| if *yields { 1.0 } else { GIVEN }).collect();
        for Local { columns, rows, rates } in locals(model, &mut closing, &before) {
            let weighted = DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] * weights[columns[j]]);
            // Rows may be linearly dependent in a singular position: the shortest step that meets them.
            let step = weighted.svd(true, true).solve(&-rates, 1e-11);
            let step = step.unwrap_or_else(|_| DVector::zeros(columns.len()));
            columns.iter().zip(step.iter()).for_each(|(j, step)| v[*j] += step * weights[*j]);
        }
    }
    let mut left =
        closing.close_rates(model, &q, &mut v).map_err(|singular| vec![undetermined(model, singular.link)])?;
    let changed = |i: usize| given[i] != 0.0 && (v[i] - given[i]).abs() > 1e-6 * given[i].abs();
    let driven = |i: usize| model.drives.iter().any(|drive| drive.coordinate.velocity == i);
    if (0..v.len()).any(|i| changed(i) && !driven(i)) {
        notes.push("the given velocities contradict the loops; taken are the nearest that do not".to_owned());
    }
    if left.is_nan() {
        left = f64::INFINITY;
    }
    if left > 1e-6 * size {
        let driven = model.drives.iter().map(|drive| format!("`{}`", drive.name)).collect::<Vec<_>>().join(", ");
        let message = format!("no velocities agree with the drives {driven} and the loops at the start");
        let help = "at this position the driven hinge cannot move the way it is asked to (a dead centre?)".to_owned();
        let field = "type".to_owned();
        return Err(vec![Problem { element: Element::Drive(0), field, message, help: Some(help) }]);
    }
    model.start_velocity = v;
    Ok(())
}

/// Rows that share hinges with each other and with no others, and those hinges' velocities.
struct Local {
    columns: Vec<usize>,
    rows: DMatrix<f64>,
    rates: DVector<f64>,
}

/// The rows as placed last, each with those that it shares hinges with: loops that stand by themselves are solved by
/// themselves. What agrees already is left out.
fn locals(model: &Model, closing: &mut Closing, rates: &DVector<f64>) -> Vec<Local> {
    let inner: Vec<Vec<usize>> = closing.rows.elements.iter().map(|element| between_ends(model, element)).collect();
    let of_element = sharing(&inner, model.links.len());
    let unknowns = closing.rows.plan.groups.iter();
    let unknowns = unknowns.flat_map(|group| group.rows.iter().map(|_| of_element[group.element]));
    let of_unknown: Vec<usize> = unknowns.collect();
    // The place of every row and velocity among those of its own.
    let (mut members, mut place_of_row) = (vec![Vec::new(); inner.len()], vec![0; of_unknown.len()]);
    for (unknown, local) in of_unknown.iter().enumerate() {
        place_of_row[unknown] = members[*local].len();
        members[*local].push(unknown);
    }
    let mut columns = vec![Vec::new(); inner.len()];
    let mut place_of_column = vec![usize::MAX; model.velocity_count()];
    for (element, links) in inner.iter().enumerate() {
        for link in links.iter().map(|link| &model.links[*link]) {
            for velocity in link.velocity..link.velocity + link.joint.counts().1 {
                if place_of_column[velocity] == usize::MAX {
                    place_of_column[velocity] = columns[of_element[element]].len();
                    columns[of_element[element]].push(velocity);
                }
            }
        }
    }
    let make = |(members, columns): (&Vec<usize>, Vec<usize>)| Local {
        rows: DMatrix::zeros(members.len(), columns.len()),
        rates: DVector::from_iterator(members.len(), members.iter().map(|unknown| rates[*unknown])),
        columns,
    };
    let mut locals: Vec<Local> = members.iter().zip(columns).map(make).collect();
    closing.gradient(model, |unknown, velocity, entry| {
        let local = &mut locals[of_unknown[unknown]];
        let column = place_of_column[velocity];
        // Hinges that both ends of a loop stand on carry nothing of it.
        if local.columns.get(column) == Some(&velocity) {
            local.rows[(place_of_row[unknown], column)] += entry;
        }
    });
    locals.retain(|local| local.rates.amax() > 0.0);
    locals
}

/// The dependent velocities: of driven hinges, and of hinges in loops and gears whose own is not given.
fn yielding(model: &Model, rows: &Constraints, given: &[f64]) -> Vec<bool> {
    let mut yielding = vec![false; given.len()];
    for element in &rows.elements {
        for link in between_ends(model, element) {
            let link = &model.links[link];
            for i in link.velocity..link.velocity + link.joint.counts().1 {
                yielding[i] |= given[i] == 0.0;
            }
        }
    }
    model.drives.iter().for_each(|drive| yielding[drive.coordinate.velocity] = true);
    yielding
}

fn undetermined(model: &Model, link: usize) -> Problem {
    let body = model.links[link].body;
    let name = &model.bodies[body].name;
    Problem {
        element: Element::Body(body),
        field: "inertia".to_owned(),
        message: format!("the hinge of `{name}` has no inertia to accelerate while the loops are closed"),
        help: Some("a point mass on its own axis needs `inertia`, or the hinge an `armature`".to_owned()),
    }
}

fn place_of(owner: Owner) -> Element {
    match owner {
        Owner::Loop(index) => Element::Loop(index),
        Owner::Drive(index) => Element::Drive(index),
        Owner::Gear(index) => Element::Gear(index),
        Owner::Held(_) => Element::Scene,
    }
}

fn cannot_close(model: &Model, widest: &OpenGap) -> Problem {
    let rows = Constraints::unplanned(model, &RowSelection::default());
    let owner = rows.elements.iter().find(|e| e.name == widest.element).map_or(Owner::Held(0), |e| e.owner);
    let locked: Vec<&str> = model.bodies.iter().filter(|body| body.hinge.lock).map(|body| body.name.as_str()).collect();
    let driven: Vec<&str> = model.drives.iter().map(|drive| drive.name.as_str()).collect();
    let mut suspects = vec!["a length, a place or an axis".to_owned()];
    suspects.extend((!locked.is_empty()).then(|| format!("the lock of {}", listed(&locked, "`"))));
    suspects.extend((!driven.is_empty()).then(|| format!("the drive {}", listed(&driven, "`"))));
    let help = format!("{} does not fit, or the given positions are too far away", suspects.join(", or "));
    Problem {
        element: place_of(owner),
        field: "between".to_owned(),
        message: format!("{} cannot be closed: a gap of {} remains", widest.element, widest.words()),
        help: Some(help),
    }
}

/// The first names of a list.
fn listed(list: &[&str], quote: &str) -> String {
    let all: Vec<String> = list.iter().take(6).map(|n| format!("{quote}{n}{quote}")).collect();
    format!("{}{}", all.join(", "), if list.len() > 6 { ", …" } else { "" })
}

/// Rows on axes are also met when the axes point against each other: that is no closed hinge.
fn turned_over(model: &Model, q: &[f64]) -> Option<Problem> {
    let mut motion = Motion::new(model);
    motion.update(model, q, &vec![0.0; model.velocity_count()]);
    let rows = Constraints::unplanned(model, &RowSelection::default());
    rows.elements.iter().find(|element| is_turned_over(element, model, &motion)).map(|element| Problem {
        element: place_of(element.owner),
        field: "between".to_owned(),
        message: format!(
            "{} can only be closed with its axes against each other from the given positions",
            element.name
        ),
        help: Some("give positions nearer to the assembled ones".to_owned()),
    })
}

/// Components in which nothing can move without their drives. Loops that hold all coordinates between their ends (a truss)
/// are said in a note: what their rows carry is statics. Gears that do contradict each other or the loops.
fn locked(model: &Model, rows: &Constraints, independent: &[bool], notes: &mut Vec<String>) -> Vec<Problem> {
    let elements = &rows.elements;
    let is = |e: usize, of: fn(&Owner) -> bool| of(&elements[e].owner);
    let is_drive = |e: usize| is(e, |owner| matches!(owner, Owner::Drive(_)));
    let inner: Vec<Vec<usize>> =
        (0..elements.len()).map(|e| if is_drive(e) { Vec::new() } else { between_ends(model, &elements[e]) }).collect();
    let mut problems = Vec::new();
    for members in members(&sharing(&inner, model.links.len())) {
        let members: Vec<usize> = members.into_iter().filter(|e| !is_drive(*e)).collect();
        let mut links: Vec<usize> = members.iter().flat_map(|e| inner[*e].iter().copied()).collect();
        links.sort_unstable();
        links.dedup();
        let freedoms: usize = links.iter().map(|link| model.links[*link].joint.counts().1).sum();
        let taken = members.iter().flat_map(|e| elements[*e].rows.clone()).filter(|row| independent[*row]).count();
        if taken < freedoms || taken == 0 {
            continue;
        }
        let names: Vec<&str> = members.iter().map(|e| elements[*e].name.as_str()).collect();
        let mut bodies: Vec<&str> = links.iter().map(|l| model.bodies[model.links[*l].body].name.as_str()).collect();
        bodies.dedup();
        let (names, bodies) = (listed(&names, ""), listed(&bodies, "`"));
        let conditions = counted(taken, "condition", "conditions");
        let coordinates = counted(freedoms, "coordinate", "coordinates");
        if members.iter().any(|e| is(*e, |owner| matches!(owner, Owner::Gear(_)))) {
            problems.push(Problem {
                element: place_of(elements[members[0]].owner),
                field: "type".to_owned(),
                message: format!(
                    "{names} lock the mechanism: {conditions} on {coordinates} leave {bodies} nothing to move"
                ),
                help: Some("take one off, free a hinge, or weld the bodies with fixed hinges".to_owned()),
            });
        } else {
            notes.push(format!("{bodies} cannot move: {conditions} of {names} on {coordinates}"));
        }
    }
    problems
}

/// Whether the axes of a loop stand against each other instead of together.
fn is_turned_over(element: &RowGroup, model: &Model, motion: &Motion) -> bool {
    let Owner::Loop(index) = element.owner else { return false };
    let closed = &model.loops[index];
    let [first, second] = [&motion.links[closed.ends[0].link], &motion.links[closed.ends[1].link]];
    let Some(second_frame) = closed.second_frame else { return false };
    let against =
        |axis: &Vector3<f64>| (first.turn * (closed.frame * axis)).dot(&(second.turn * (second_frame * axis))) < 0.0;
    match &closed.closure {
        Closure::Hinge(kind) => kind.shared().iter().any(against),
        Closure::Rod { .. } => false,
    }
}

/// Drives of a motion that others already prescribe. What holds still beside what holds still contradicts nothing, and shares its load.
fn overdriven(model: &Model, rows: &Constraints, independent: &[bool], time: f64) -> Vec<Problem> {
    let inner: Vec<Vec<usize>> = rows.elements.iter().map(|element| between_ends(model, element)).collect();
    let component = sharing(&inner, model.links.len());
    let moves = |element: &RowGroup| match element.owner {
        Owner::Drive(drive) => !model.drives[drive].motion.holds_from(time),
        _ => false,
    };
    let moving: Vec<usize> = (0..component.len()).filter(|e| moves(&rows.elements[*e])).map(|e| component[e]).collect();
    let prescribed: Vec<bool> = component.iter().map(|root| moving.contains(root)).collect();
    let dependent = |(_, element): &(usize, &RowGroup)| {
        matches!(element.owner, Owner::Drive(_)) && !independent[element.rows.start]
    };
    let others: Vec<&str> = rows
        .elements
        .iter()
        .filter(|element| matches!(element.owner, Owner::Drive(_)) && independent[element.rows.start])
        .map(|element| element.name.as_str())
        .collect();
    let has = |of: fn(&Owner) -> bool| rows.elements.iter().any(|element| of(&element.owner));
    let (loops, gears) = (has(|owner| matches!(owner, Owner::Loop(_))), has(|owner| matches!(owner, Owner::Gear(_))));
    let rest = match (loops, gears) {
        (true, true) => "the loops and gears",
        (false, true) => "the gears",
        _ => "the loops",
    };
    let all = rows.elements.iter().enumerate().filter(dependent).filter(|(e, _)| prescribed[*e]);
    all.map(|(_, element)| Problem {
        element: place_of(element.owner),
        field: "hinge".to_owned(),
        message: match others.is_empty() {
            true => format!("{} cannot move its hinge: {rest} hold it", element.name),
            false => {
                format!("{} has nothing left to move: {} and {rest} prescribe it", element.name, others.join(", "))
            }
        },
        help: Some("as many drives as the mechanism has degrees of freedom, on hinges that can move".to_owned()),
    })
    .collect()
}

/// Turns and shifts by a little, another one each time.
fn nudge(model: &Model, q: &mut [f64], attempt: usize) {
    let length = model.length_scale();
    let mut step = vec![0.0; model.velocity_count()];
    for (index, link) in model.links.iter().enumerate().skip(1) {
        let size = if link.joint.is_distance() { 0.02 * length } else { 0.1 };
        for i in link.velocity..link.velocity + link.joint.counts().1 {
            if !model.coordinates[i].lock {
                step[i] = size * attempt as f64 * ((1 + index * attempt) as f64 * 1.7 + i as f64).sin();
            }
        }
    }
    crate::motion::displace(model, q, &step);
}

/// The largest change of a coordinate that was given (rad, or part of the scene's length), and the change in words: those of
/// cables are not given.
fn largest_move(model: &Model, from: &[f64], to: &[f64]) -> (f64, String) {
    let (length, mut largest) = (model.length_scale(), (0.0, 0.0, ""));
    let of_cables = |body: usize| {
        let mut cables = model.beams.iter().filter(|beam| beam.is_cable);
        cables.any(|cable| (cable.root..=cable.root + cable.elements.len()).contains(&body))
    };
    for link in model.links.iter().filter(|link| !of_cables(link.body)) {
        let per = link.joint.unit(length);
        let (count, velocities) = link.joint.counts();
        let place = link.position..link.position + count;
        let changes = || place.clone().map(|i| (to[i] - from[i]).abs());
        let most = changes().fold(0.0, f64::max);
        if most / per <= largest.0 {
            continue;
        }
        let (size, unit) = match () {
            () if link.joint.is_distance() => (most, " m"),
            () if link.joint.is_angle() => (most, " rad"),
            // Unit quaternions at a distance of 2 sin(θ/4) are turned by θ against each other.
            () if count > velocities => {
                let chord = changes().map(|change| change * change).sum::<f64>().sqrt();
                (4.0 * (0.5 * chord).min(1.0).asin(), " rad")
            }
            () => (most, ""),
        };
        largest = (most / per, size, unit);
    }
    (largest.0, format!("{}{}", rounded(largest.1), largest.2))
}
