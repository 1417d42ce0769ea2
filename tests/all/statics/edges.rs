//! Balances at one-sided places: upright poles, geared and held by rods, at stops that bear nothing and at kinks of their springs. Against the
//! lowest stiffness on every face of every cone of motions, by a formula for the stiffness of poles.

use crate::common::{Random, build};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::path::{EventKind, follow};
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, Want, equilibrium};

const SCENES: u64 = 400;
const G: f64 = 9.80665;

/// Upright poles that stand on the ground and on each other.
struct Poles {
    text: String,
    /// The stiffness of each hinge below and above, `None` where a stop keeps it from going there.
    sides: Vec<[Option<f64>; 2]>,
    /// The stiffness of their weights, in hinge angles.
    weights: DMatrix<f64>,
    /// All hinge angles of the independent ones.
    motions: DMatrix<f64>,
}

/// What a hinge is held by: its keys, a motor, and the stiffness on its sides.
fn hold(random: &mut Random, name: &str, size: f64, formulas: bool) -> (String, String, [Option<f64>; 2]) {
    let stiffness = size * random.between(0.0, 2.0);
    let more = size * random.between(0.1, 3.0);
    let motor =
        |text: String| format!("[[motor]]\nhinge = \"{name}\"\ntype = \"expression\"\nexpression = \"{text}\"\n");
    let spring = match formulas {
        true => (String::new(), motor(format!("-{stiffness:?}*q"))),
        false => (format!(", stiffness = {stiffness:?}"), String::new()),
    };
    let with = |limits: &str, sides| (format!("{}, limits = {limits}", spring.0), spring.1.clone(), sides);
    let (once, twice) = (Some(stiffness), Some(stiffness + more));
    match random.below(9) {
        0 => with("[0.0, 1.0]", [None, once]),
        1 => with("[-1.0, 0.0]", [once, None]),
        2 => with(&format!("{{ low = 0.0, stiffness = {more:?} }}"), [twice, once]),
        3 => with(&format!("{{ high = 0.0, stiffness = {more:?} }}"), [once, twice]),
        4 if formulas => (String::new(), motor(format!("-{stiffness:?}*q - {more:?}*max(q, 0)")), [once, twice]),
        4 => {
            let points = [[-1.0, -(stiffness + more)], [0.0, 0.0], [1.0, stiffness]];
            let table = format!(", spring = {{ curve = {points:?}, interpolation = \"linear\" }}");
            (table, String::new(), [twice, once])
        }
        // A table and a compliant stop that begin at one place: what pushes out beyond it may be held by the stop, or not.
        7 | 8 if !formulas => {
            let pushes = size * random.between(-1.0, 3.0);
            let points = [[-1.0, -stiffness], [0.0, 0.0], [1.0, -pushes]];
            let table = format!(", spring = {{ curve = {points:?}, interpolation = \"linear\" }}");
            with_table(&table, more, [once, Some(more - pushes)])
        }
        7 | 8 => (
            format!(", limits = {{ high = 0.0, stiffness = {more:?} }}"),
            motor(format!("-{stiffness:?}*q + {more:?}*max(q, 0)")),
            [once, once],
        ),
        _ => (spring.0, spring.1, [once, once]),
    }
}

fn with_table(table: &str, stop: f64, sides: [Option<f64>; 2]) -> (String, String, [Option<f64>; 2]) {
    (format!("{table}, limits = {{ high = 0.0, stiffness = {stop:?} }}"), String::new(), sides)
}

fn poles(seed: u64, formulas: bool) -> Poles {
    let random = &mut Random::new(seed);
    let count = 1 + random.below(5);
    let parents: Vec<Option<usize>> =
        (0..count).map(|index| (index > 0 && random.below(2) == 0).then(|| random.below(index))).collect();
    let masses: Vec<f64> = (0..count).map(|_| random.between(0.2, 3.0)).collect();
    let centers: Vec<f64> = (0..count).map(|_| random.between(-0.3, 1.0)).collect();
    let places: Vec<f64> = (0..count).map(|_| random.between(0.2, 1.0)).collect();
    // The moment of the weights about each pole's hinge, as it turns in space.
    let mut carried = masses.clone();
    (0..count).rev().for_each(|index| {
        if let Some(parent) = parents[index] {
            carried[parent] += carried[index];
        }
    });
    let mut moments: Vec<f64> = (0..count).map(|index| G * masses[index] * centers[index]).collect();
    let mut turns: DMatrix<f64> = DMatrix::identity(count, count);
    for index in 0..count {
        let Some(parent) = parents[index] else { continue };
        moments[parent] += G * carried[index] * places[index];
        let row = turns.row(parent).clone_owned();
        let sum = turns.row(index) + row;
        turns.set_row(index, &sum);
    }
    let weights = -(turns.transpose() * DMatrix::from_diagonal(&DVector::from_vec(moments)) * &turns);
    let (mut text, mut sides) = (String::new(), Vec::new());
    for index in 0..count {
        let size = weights[(index, index)].abs();
        let (keys, motor, both) = hold(random, &format!("b{index}"), size, formulas);
        let on = match parents[index] {
            Some(parent) => format!("parent = \"b{parent}\", at = [0, 0, {:?}]", places[index]),
            None => format!("at = [{}, 0, 0]", 5 * index),
        };
        let _ = write!(
            text,
            "[[body]]\nname = \"b{index}\"\nmass = {:?}\ncenter = [0, 0, {:?}]\ninertia = [0.1, 0.1, 0.1]\n\
             markers = {{ tip = [0, 0, 1] }}\nhinge = {{ type = \"revolute\", axis = [0, 1, 0], {on}{keys} }}\n{motor}",
            masses[index], centers[index]
        );
        sides.push(both);
    }
    let mut motions: DMatrix<f64> = DMatrix::identity(count, count);
    let mut free: Vec<usize> = (0..count).collect();
    let mut tied = Vec::new();
    for _ in 0..random.below(1 + count / 2) {
        let [one, other] = [0; 2].map(|_| free.swap_remove(random.below(free.len())));
        let stand = parents[one].is_none() && parents[other].is_none();
        let ratio = if stand && random.below(2) == 0 {
            let length = 5.0 * one.abs_diff(other) as f64;
            let _ = write!(
                text,
                "[[loop]]\ntype = \"rod\"\nbetween = [\"b{one}.tip\", \"b{other}.tip\"]\nlength = {length:?}\n"
            );
            1.0
        } else {
            let ratio = [-1.0, 1.0, 0.5, -2.0][random.below(4)];
            let _ =
                writeln!(text, "[[gear]]\ntype = \"ratio\"\nbetween = [\"b{one}\", \"b{other}\"]\nratio = {ratio:?}");
            ratio
        };
        motions[(one, one)] = 0.0;
        motions[(one, other)] = ratio;
        tied.push(one);
    }
    tied.sort_unstable();
    let motions = motions.remove_columns_at(&tied);
    Poles { text, sides, weights, motions }
}

impl Poles {
    /// The lowest stiffness of a motion, beside the largest of its terms.
    fn lowest(&self) -> f64 {
        let count = self.sides.len();
        let scale =
            self.weights.amax() + self.sides.iter().flatten().flatten().fold(0.0_f64, |most, k| most.max(k.abs()));
        let mut lowest = f64::INFINITY;
        for cone in 0..1_usize << count {
            let side = |i: usize| cone >> i & 1;
            // Where neither side is another one there is no need to tell them apart, and a stop leaves one.
            if (0..count)
                .any(|i| self.sides[i][side(i)].is_none() || (side(i) == 1 && self.sides[i][0] == self.sides[i][1]))
            {
                continue;
            }
            let springs = DVector::from_iterator(count, (0..count).map(|i| self.sides[i][side(i)].unwrap_or(0.0)));
            let stiffness = &self.weights + DMatrix::from_diagonal(&springs);
            let form = self.motions.transpose() * stiffness * &self.motions;
            let rows: Vec<DVector<f64>> = (0..count)
                .filter(|i| self.sides[*i][0] != self.sides[*i][1])
                .map(|i| self.motions.row(i).transpose() * if side(i) == 1 { -1.0 } else { 1.0 })
                .collect();
            lowest = lowest.min(lowest_within(&form, &rows));
        }
        lowest / scale
    }
}

/// The lowest `xᵀ K x` of unit `x` with no row positive: on the inside of some face it is an eigenvalue there.
fn lowest_within(form: &DMatrix<f64>, rows: &[DVector<f64>]) -> f64 {
    let n = form.nrows();
    let mut lowest = f64::INFINITY;
    for face in 0..1_usize << rows.len() {
        let mut squares: DMatrix<f64> = DMatrix::zeros(n, n);
        rows.iter()
            .enumerate()
            .filter(|(k, _)| face >> k & 1 == 1)
            .for_each(|(_, row)| squares += row * row.transpose());
        let eigen = SymmetricEigen::new(squares);
        let along: Vec<DVector<f64>> = (0..n)
            .filter(|k| eigen.eigenvalues[*k] < 1e-9)
            .map(|k| eigen.eigenvectors.column(k).clone_owned())
            .collect();
        if along.is_empty() {
            continue;
        }
        let basis = DMatrix::from_columns(&along);
        let inner = SymmetricEigen::new(basis.transpose() * form * &basis);
        for (k, value) in inner.eigenvalues.iter().enumerate() {
            let x = &basis * inner.eigenvectors.column(k);
            let within = |sign: f64| rows.iter().all(|row| sign * row.dot(&x) < 1e-9);
            if within(1.0) || within(-1.0) {
                lowest = lowest.min(*value);
            }
        }
    }
    lowest
}

fn solved(text: &str, want: Want) -> (Arc<Model>, Equilibrium) {
    let scenario = scenario::parse("edges.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    let (model, _) = assemble(build(&scenario.description)).expect("an assembly");
    let settings = Settings { want, ..Settings::default() };
    let found = equilibrium(&model, &settings, &model.start_position).expect("statics");
    (model, found)
}

fn assert_verdicts(formulas: bool) {
    let (mut counts, mut failed, mut kept) = ([0, 0], Vec::new(), 0);
    for seed in 0..SCENES {
        let poles = poles(seed, formulas);
        let lowest = poles.lowest();
        if lowest.abs() < 1e-6 {
            continue;
        }
        let (model, found) = solved(&poles.text, Want::Any);
        let upright = found.position.iter().all(|q| q.abs() < 1e-12);
        let verdict = found.stability.as_ref().map(|stability| stability.verdict);
        let expected = if lowest > 0.0 { StabilityVerdict::Stable } else { StabilityVerdict::Unstable };
        counts[usize::from(lowest > 0.0)] += 1;
        if !upright || verdict != Some(expected) {
            failed.push(format!("{seed}: {verdict:?} of {lowest:e}, {:?}\n{}", found.notes, poles.text));
        }
        // A table that pushes out further than its stop holds pushes for ever: there may be no stable equilibrium.
        let may_stand = poles.sides.iter().flatten().flatten().all(|stiffness| *stiffness >= 0.0);
        if lowest < 0.0 && !formulas && may_stand {
            let (_, left) = solved(&poles.text, Want::Stable);
            let stands = left.stability.as_ref().is_some_and(|one| one.verdict != StabilityVerdict::Unstable);
            let passes = |stop: &stillpoint::model::Stop| {
                stop.is_rigid() && stop.passed(left.position[stop.position], 1e-9).is_some()
            };
            if !left.converged && left.notes.iter().any(|note| note.contains("only an unstable equilibrium")) {
                // The search knows no way to one that is stable, and says so.
                kept += 1;
            } else if !(left.converged && stands) || model.stops.iter().any(passes) {
                failed.push(format!("{seed} is not left: {:?}\n{}", left.notes, poles.text));
            }
        }
    }
    assert!(20 * kept < counts[0], "{kept} of {counts:?} are not left");
    assert!(failed.is_empty(), "{} of {counts:?}:\n{}", failed.len(), failed[..failed.len().min(6)].join("\n"));
    assert!(counts.iter().all(|count| *count > SCENES / 10), "{counts:?}");
}

/// The stiffness is negative on some side of stops that bear nothing and of kinks, or on none: the verdict says so, and what is
/// unstable is left.
#[test]
fn poles_at_one_sided_places_are_stable_if_they_are_on_every_side() {
    assert_verdicts(false);
}

/// The same springs as formulas have no potential that is known: their motion says the same.
#[test]
fn poles_at_one_sided_places_are_judged_by_their_motion_if_loads_have_no_potential() {
    assert_verdicts(true);
}

/// An upright pole at a stop that bears nothing falls off it until its spring is `m g c` stiff: a path has its bifurcation there, and the
/// branch `k q = m g c sin q` on the open side.
#[test]
fn a_path_at_a_stop_that_bears_nothing_bifurcates_where_the_open_side_gives_way() {
    for seed in 0..12 {
        let random = &mut Random::new(seed);
        let (mass, center) = (random.between(0.2, 3.0), random.between(0.2, 1.0));
        let critical = mass * G * center;
        let (limits, side) = [("[0.0, 2.9]", 1.0), ("[-2.9, 0.0]", -1.0)][random.below(2)];
        let (from, to) = (0.5 * critical, critical * random.between(1.5, 3.0));
        let text = format!(
            "[statics]\nwant = \"any\"\npath = {{ parameter = \"p.stiffness\", from = {from:?}, to = {to:?} }}\n\
             [[body]]\nname = \"p\"\nmass = {mass:?}\ncenter = [0, 0, {center:?}]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], limits = {limits}, stiffness = {from:?} }}\n"
        );
        let scenario = scenario::parse("edge.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let settings = scenario.path.as_ref().expect("a path");
        let path = follow(&scenario.description, &scenario.statics, settings, &mut |_| true).expect("a path");
        let events: Vec<(EventKind, f64)> =
            path.events().map(|(_, point)| (point.event.as_ref().expect("an event").kind, point.parameter)).collect();
        assert_eq!(events.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), [EventKind::Bifurcation], "{text}");
        // Stiffness counts from 1e-9 of its terms on.
        assert!((events[0].1 / critical - 1.0).abs() < 1e-8, "{events:?} of {critical}\n{text}");
        for point in &path.branches[0].points {
            let expected = match point.parameter {
                k if k < critical * (1.0 - 1e-8) => StabilityVerdict::Unstable,
                k if k > critical * (1.0 + 1e-8) => StabilityVerdict::Stable,
                _ => StabilityVerdict::Neutral,
            };
            assert_eq!(point.verdict, expected, "at {} of {critical}\n{text}", point.parameter);
        }
        assert_eq!(path.branches.len(), 2, "{:?}\n{text}", path.notes);
        for point in &path.branches[1].points {
            let q = point.position[0];
            assert!(
                side * q > 0.0 && (point.parameter * q - critical * q.sin()).abs() < 1e-8 * critical,
                "{q}\n{text}"
            );
            assert_eq!(point.verdict, StabilityVerdict::Stable, "{text}");
        }
    }
}

/// Two upright poles, one on the other, at stops that both bear nothing: the upper one leaves its stop, and what it weighs then presses the
/// lower one onto the other stop. The branch is that of the upper pole alone, `k q = m g c sin q`.
#[test]
fn a_branch_that_leaves_a_stop_may_close_another() {
    for seed in 0..16 {
        let random = &mut Random::new(seed);
        let (mass, center) = (random.between(0.2, 3.0), random.between(0.2, 1.0));
        let side = if seed % 2 == 0 { 1.0 } else { -1.0 };
        let critical = mass * G * center;
        let (from, to) = (critical * random.between(1.5, 3.0), critical * random.between(0.7, 0.95));
        let ends = |sign: f64| if sign > 0.0 { "{ low = 0.0 }" } else { "{ high = 0.0 }" };
        let text = format!(
            "[statics]\nwant = \"any\"\npath = {{ parameter = \"b.stiffness\", from = {from:?}, to = {to:?} }}\n\
             [[body]]\nname = \"a\"\nmass = 1.0\ncenter = [0, 0, 0.5]\nmarkers = {{ t = [0, 0, 1] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], stiffness = {:?}, limits = {} }}\n\
             [[body]]\nname = \"b\"\nmass = {mass:?}\ncenter = [0, 0, {center:?}]\n\
             hinge = {{ type = \"revolute\", parent = \"a\", at = \"t\", axis = [0, 1, 0], stiffness = {from:?}, limits = {} }}\n",
            // The lower pole stands by itself.
            2.0 * G * (0.5 + mass * (1.0 + center)),
            ends(side),
            ends(-side),
        );
        let scenario = scenario::parse("edge.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let settings = scenario.path.as_ref().expect("a path");
        let path = follow(&scenario.description, &scenario.statics, settings, &mut |_| true).expect("a path");
        assert_eq!(path.branches.len(), 2, "{:?}\n{text}", path.notes);
        let last = path.branches[1].points.last().expect("points");
        for point in &path.branches[1].points {
            let [a, b] = [0, 1].map(|i| point.position[i]);
            let left = point.parameter * b - critical * b.sin();
            assert!(a.abs() < 1e-12 && side * b < 0.0 && left.abs() < 1e-8 * critical, "{a} {b}\n{text}");
        }
        assert!((last.parameter / to - 1.0).abs() < 1e-9, "{}\n{text}", last.parameter);
    }
}
