//! Minima of the potential within limits: random limp trees against an independent potential and an independent descent.

use crate::common::{Random, build};
use nalgebra::{Matrix3, Unit, UnitQuaternion, Vector3};
use std::ops::Range;
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, Want, equilibrium};

const G: f64 = 9.80665;
const SCENES: u64 = 240;

/// What the independent potential knows of a scene.
struct Tree {
    links: Vec<Link>,
    /// Per coordinate: lowest and highest value, and the stiffness of a compliant stop.
    limits: Vec<([f64; 2], Option<f64>)>,
}

struct Link {
    parent: Option<usize>,
    /// Index of its first coordinate: the program keeps branches of a tree together.
    first: usize,
    at: Vector3<f64>,
    axes: Vec<Unit<Vector3<f64>>>,
    slides: bool,
    mass: f64,
    center: Vector3<f64>,
}

impl Tree {
    fn potential(&self, q: &[f64]) -> f64 {
        let springs = (0..q.len()).map(|i| 0.5 * self.stiffness(i) * self.depth(q, i).powi(2));
        self.height(q) + springs.sum::<f64>()
    }

    fn stiffness(&self, i: usize) -> f64 {
        self.limits[i].1.unwrap_or(0.0)
    }

    /// How far a coordinate is beyond its limits, with its sign.
    fn depth(&self, q: &[f64], i: usize) -> f64 {
        let [low, high] = self.limits[i].0;
        (q[i] - high).max(0.0) + (q[i] - low).min(0.0)
    }

    /// The potential of the weights, by forward kinematics.
    fn height(&self, q: &[f64]) -> f64 {
        let mut places: Vec<(UnitQuaternion<f64>, Vector3<f64>)> = Vec::new();
        let mut sum = 0.0;
        for link in &self.links {
            let (turn, origin) = link.parent.map_or((UnitQuaternion::identity(), Vector3::zeros()), |p| places[p]);
            let mut place = (turn, origin + turn * link.at);
            for (axis, x) in link.axes.iter().zip(&q[link.first..]) {
                match link.slides {
                    true => place.1 += place.0 * axis.into_inner() * *x,
                    false => place.0 *= UnitQuaternion::from_axis_angle(axis, *x),
                }
            }
            sum += link.mass * G * (place.1 + place.0 * link.center).z;
            places.push(place);
        }
        sum
    }

    /// Size of the terms, for tolerances.
    fn size(&self) -> f64 {
        self.links.iter().map(|link| link.mass * G * (link.at.norm() + link.center.norm() + 1.0)).sum()
    }

    fn box_of(&self, i: usize) -> [f64; 2] {
        if self.limits[i].1.is_some() { [f64::NEG_INFINITY, f64::INFINITY] } else { self.limits[i].0 }
    }

    fn project(&self, q: &mut [f64]) {
        for (i, x) in q.iter_mut().enumerate() {
            let [low, high] = self.box_of(i);
            *x = x.max(low).min(high);
        }
    }

    /// Of the weights by central differences; that of a compliant stop has a kink, which they would miss by `k h`.
    fn slope(&self, q: &[f64], i: usize) -> f64 {
        let h = 1e-5;
        let mut beside = q.to_vec();
        beside[i] = q[i] + h;
        let up = self.height(&beside);
        beside[i] = q[i] - h;
        (up - self.height(&beside)) / (2.0 * h) + self.stiffness(i) * self.depth(q, i)
    }

    /// Projected gradient with backtracking: the potential of the place where it ends.
    fn descend(&self, mut q: Vec<f64>, steps: usize) -> f64 {
        self.project(&mut q);
        let mut lowest = self.potential(&q);
        let mut length = 1e-2 / self.size();
        for _ in 0..steps {
            let slope: Vec<f64> = (0..q.len()).map(|i| self.slope(&q, i)).collect();
            let mut lower = false;
            for _ in 0..40 {
                let mut next: Vec<f64> = q.iter().zip(&slope).map(|(x, s)| x - length * s).collect();
                self.project(&mut next);
                let potential = self.potential(&next);
                if potential < lowest {
                    (q, lowest, lower, length) = (next, potential, true, 2.0 * length);
                    break;
                }
                length *= 0.3;
            }
            if !lower {
                break;
            }
        }
        lowest
    }
}

/// A limp tree of so many links with limits of all kinds, from a random pose that may stand at its limits or beyond.
fn scene(seed: u64, links: Range<usize>) -> (Tree, Arc<Model>) {
    let mut random = Random::new(seed);
    let (count, chain) = (links.start + random.below(links.len()), random.below(2) == 0);
    let mut tree = Tree { links: Vec::new(), limits: Vec::new() };
    let (mut bodies, mut limits) = (Vec::new(), Vec::new());
    for index in 0..count {
        let parent = match (index, chain) {
            (0, _) => None,
            (_, true) => Some(index - 1),
            (_, false) => Some(random.below(index)),
        };
        let (kind, axes, slides) = hinge_kind(&mut random);
        let link = Link {
            parent,
            first: 0,
            at: random.vector(0.4),
            axes: axes.into_iter().map(Unit::new_normalize).collect(),
            slides,
            mass: 10_f64.powf(random.between(-2.0, 1.0)),
            center: random.vector(0.3),
        };
        let mut hinge = HingeDescription::new(kind);
        hinge.at = Point::At(link.at);
        if let Some(parent) = parent {
            hinge.parent = format!("b{parent}");
        }
        for coordinate in 0..link.axes.len() {
            let (range, law) = limit(&mut random, slides);
            if range.iter().any(|x| x.is_finite()) {
                hinge.limits.push(LimitDescription { coordinate, low: range[0], high: range[1], law });
            }
            let stiffness = if let StopLaw::Compliant { stiffness, .. } = law { Some(stiffness) } else { None };
            limits.push((range, stiffness));
            hinge.position.push(start(&mut random, range));
        }
        let inertia = 1e-3 * link.mass * Matrix3::identity();
        let mass = MassProperties { mass: link.mass, center: link.center, inertia };
        bodies.push(BodyDescription {
            name: format!("b{index}"),
            mass,
            markers: Vec::new(),
            shapes: Vec::new(),
            hinge,
        });
        tree.links.push(link);
    }
    let model = build(&Description { bodies, ..Description::default() });
    tree.limits.clone_from(&limits);
    let mut limits = limits.into_iter();
    for (link, body) in tree.links.iter_mut().zip(&model.bodies) {
        link.first = body.hinge.position;
        let own = limits.by_ref().take(link.axes.len());
        own.enumerate().for_each(|(i, limit)| tree.limits[link.first + i] = limit);
    }
    (tree, model)
}

fn hinge_kind(random: &mut Random) -> (HingeKind, Vec<Vector3<f64>>, bool) {
    let first = random.unit();
    match random.below(4) {
        0 => (HingeKind::Prismatic { axis: first }, vec![first], true),
        1 => {
            let second = first.cross(&random.unit()).normalize();
            (HingeKind::Universal { axes: [first, second] }, vec![first, second], false)
        }
        _ => (HingeKind::Revolute { axis: first }, vec![first], false),
    }
}

/// Of a slide two-sided, since nothing else keeps it from falling; of a turn none, one-sided or two-sided.
fn limit(random: &mut Random, slides: bool) -> ([f64; 2], StopLaw) {
    let rigid = StopLaw::Rigid { restitution: 0.0 };
    let low = random.between(-1.5, 0.3);
    let high = low + random.between(0.05, 2.5);
    let law = match random.below(3) {
        0 => StopLaw::Compliant { stiffness: 10_f64.powf(random.between(2.0, 4.0)), damping: 0.0 },
        _ => rigid,
    };
    match random.below(5) {
        _ if slides => ([low, high], law),
        0 => ([f64::NEG_INFINITY, f64::INFINITY], rigid),
        1 => ([low, f64::INFINITY], law),
        2 => ([f64::NEG_INFINITY, high], law),
        _ => ([low, high], law),
    }
}

/// Within the limits, at one of them, or beyond.
fn start(random: &mut Random, range: [f64; 2]) -> f64 {
    let inside = random.between(range[0].max(-2.0), range[1].min(2.0));
    match random.below(6) {
        0 if range[0].is_finite() => range[0],
        1 if range[1].is_finite() => range[1],
        2 => inside + random.between(-0.5, 0.5),
        _ => inside,
    }
}

fn find(model: &Arc<Model>) -> Equilibrium {
    equilibrium(model, &Settings::default(), &model.start_position).expect("a scene that can be evaluated")
}

/// The program's potential of the weights.
fn weights(model: &Arc<Model>, q: &[f64]) -> f64 {
    let still = vec![0.0; model.velocity_count()];
    System::new(model).at(0.0, q, &still).energies_at_rest().potential
}

/// First and second order, all of it by the independent potential.
fn is_a_minimum(tree: &Tree, q: &[f64], random: &mut Random) -> Result<(), String> {
    let (here, size) = (tree.potential(q), tree.size());
    // Central differences over 1e-5: truncation 1e-10, round-off 1e-16/1e-5 of the terms.
    let slack = 1e-8 * size;
    for i in 0..q.len() {
        let ([low, high], slope) = (tree.box_of(i), tree.slope(q, i));
        if q[i] < low || q[i] > high {
            return Err(format!("coordinate {i} at {} is beyond {low} … {high}", q[i]));
        }
        let pressed = (q[i] == low && slope > -slack) || (q[i] == high && slope < slack);
        if !pressed && slope.abs() > slack {
            return Err(format!("coordinate {i} at {} within {low} … {high} has the slope {slope:e}", q[i]));
        }
    }
    for _ in 0..5 {
        let mut beside: Vec<f64> = q.iter().map(|x| x + 1e-3 * random.between(-1.0, 1.0)).collect();
        tree.project(&mut beside);
        // Third order of a neutral direction: 1e-9 of the terms.
        let there = tree.descend(beside, 20);
        if there < here - 1e-8 * size {
            return Err(format!("the potential falls by {:e} beside it", here - there));
        }
    }
    Ok(())
}

#[test]
fn limp_trees_settle_among_their_limits() {
    settle(0..SCENES, 2..31);
}

#[test]
fn limp_robots_of_up_to_sixty_links_settle_among_their_limits() {
    settle(SCENES..SCENES + 40, 20..61);
}

fn settle(seeds: Range<u64>, links: Range<usize>) {
    let (mut failed, mut resting, count) = (Vec::new(), 0, seeds.end - seeds.start);
    for seed in seeds {
        let (tree, model) = scene(seed, links.clone());
        let found = find(&model);
        let stands = found.stability.as_ref().is_some_and(|s| s.verdict != StabilityVerdict::Unstable);
        if !(found.converged && stands) {
            failed.push(format!("{seed}: {} {:?}", found.relative_residual, found.notes));
            continue;
        }
        let mut guess = model.start_position.clone();
        tree.project(&mut guess);
        let rises = tree.height(&found.position) - tree.height(&guess);
        let other = weights(&model, &found.position) - weights(&model, &guess);
        assert!(
            (rises - other).abs() < 1e-11 * tree.size(),
            "{seed}: the weights rise by {rises} J, in the program by {other} J"
        );
        let risen = tree.potential(&found.position) - tree.potential(&guess);
        if risen > 1e-9 * tree.size() {
            failed.push(format!("{seed}: the potential rose by {risen:e}"));
        }
        if let Err(why) = is_a_minimum(&tree, &found.position, &mut Random::new(seed + 1_000)) {
            failed.push(format!("{seed}: {why}"));
        }
        resting += found.stops.len();
    }
    assert!(failed.is_empty(), "{} of {count}:\n{}", failed.len(), failed.join("\n"));
    assert!(resting > count as usize, "{resting} stops bear: the scenes ask for nothing");
}

/// A rod on a hinge whose stop keeps it from one side of the vertical.
fn rod(index: usize, center: f64, low: f64, high: f64) -> BodyDescription {
    let mut hinge = HingeDescription::new(HingeKind::Revolute { axis: Vector3::y() });
    hinge.limits.push(LimitDescription { coordinate: 0, low, high, law: StopLaw::Rigid { restitution: 0.0 } });
    hinge.at = Point::At(Vector3::new(index as f64, 0.0, 0.0));
    hinge.position.push(0.0);
    let center = Vector3::new(0.0, 0.0, center);
    let mass = MassProperties { mass: 1.0, center, inertia: 0.1 * Matrix3::identity() };
    BodyDescription { name: format!("rod{index}"), mass, markers: Vec::new(), shapes: Vec::new(), hinge }
}

/// Rods whose weights stand exactly over or under their hinges, each on the edge of a stop that bears nothing: an upright one
/// falls where its stop lets it, a hanging one stays.
#[test]
fn what_stands_on_the_edge_of_a_stop_falls_to_its_open_side() {
    let mut random = Random::new(5);
    for case in 0..40 {
        let count = 1 + case % 4;
        let (mut bodies, mut ends) = (Vec::new(), Vec::new());
        for index in 0..count {
            let (reach, upright) = (random.between(0.1, 3.0), random.below(3) > 0);
            let (low, high) = if random.below(2) == 0 { (0.0, reach) } else { (-reach, 0.0) };
            let center = random.between(0.2, 2.0);
            bodies.push(rod(index, if upright { center } else { -center }, low, high));
            ends.push(if upright { low + high } else { 0.0 });
        }
        let model = build(&Description { bodies, ..Description::default() });
        let found = find(&model);
        assert!(found.converged, "{case}: {:?}", found.notes);
        for (q, end) in found.position.iter().zip(&ends) {
            assert!((q - end).abs() < 1e-9, "{case}: {q} instead of {end}");
        }
        let any = Settings { want: Want::Any, ..Settings::default() };
        let stays = equilibrium(&model, &any, &model.start_position).expect("statics");
        let verdict = stays.stability.as_ref().expect("an equilibrium").verdict;
        assert!(stays.converged && stays.position.iter().all(|q| *q == 0.0), "{case}: {:?}", stays.notes);
        assert_eq!(verdict == StabilityVerdict::Unstable, ends.iter().any(|end| *end != 0.0), "{case}: {verdict:?}");
    }
}

/// Two slides with springs of 1 N/m and a strut across them that is compressed by `c` N at 1 m, both on stops that bear
/// nothing: the stiffness is `[[1 − c, c], [c, 1 − c]]`. For 0.5 < c < 1 it is negative only in the direction (1, −1), so that
/// the sides of the stops decide; for c > 1 either slide runs away alone.
#[test]
fn the_sides_of_stops_that_bear_nothing_decide() {
    let mut random = Random::new(17);
    let (mut fell, mut stayed) = (0, 0);
    for case in 0..60 {
        let compressed = random.between(0.05, 1.6);
        let sides = [0, 1].map(|_| if random.below(2) == 0 { "[0.0, 0.5]" } else { "[-0.5, 0.0]" });
        let slide = |index: usize| {
            format!(
                "[[body]]\nname = \"s{index}\"\nmass = 1\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], at = [0, {index}, 0], \
                 stiffness = 1.0, limits = {} }}\n",
                sides[index]
            )
        };
        let strut = format!(
            "[[force]]\ntype = \"spring\"\nbetween = [\"s0\", \"s1\"]\nstiffness = 10.0\nlength = {}\n",
            1.0 + compressed / 10.0
        );
        let text = format!("gravity = [0, 0, 0]\n{}{}{strut}", slide(0), slide(1));
        let read = scenario::parse("struts.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        let model = build(&read.description);
        let found = find(&model);
        assert!(found.converged, "{case}: {:?}", found.notes);
        let moved = found.position.iter().any(|q| q.abs() > 1e-3);
        let apart = sides[0] != sides[1];
        let leaves = compressed > 1.0 || (apart && compressed > 0.5);
        assert_eq!(moved, leaves, "{case}: c = {compressed}, {sides:?}, at {:?}", found.position);
        if moved { fell += 1 } else { stayed += 1 }
    }
    assert!(fell > 10 && stayed > 10, "{fell} {stayed}");
}

/// A cart on a rail that touches the end of it and does not press may go the other way, and nothing brings it back.
#[test]
fn what_only_touches_its_stop_and_nothing_brings_back_is_neutral() {
    use stillpoint::statics::{Settings, StabilityVerdict, equilibrium};
    for (position, limits) in [(0.0, "[0.0, 1.0]"), (0.0, "[-1.0, 0.0]"), (0.5, "[0.0, 1.0]")] {
        let text = format!(
            "[[body]]\nname = \"cart\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {position}, limits = {limits} }}\n"
        );
        let scenario = stillpoint::scenario::parse("rail.toml", &text, &[]).expect("a sound scene");
        let model = crate::common::build(&scenario.description);
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        let verdict = found.stability.expect("a verdict").verdict;
        assert_eq!(verdict, StabilityVerdict::Neutral, "{position} within {limits}");
    }
}
