//! Limit analysis of supports against closed forms: what stands, by how much, and how it falls.

use stillpoint::contact::support::{Cone, Supports, Verdict};

const G: f64 = 9.80665;

/// Rigid bodies with six coordinates each (m, then rad about the centre of mass), contacts at points.
struct Pile {
    centers: Vec<[f64; 3]>,
    load: Vec<f64>,
    supports: Supports,
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let size = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    a.map(|a| a / size)
}

impl Pile {
    fn new(bodies: &[([f64; 3], f64)]) -> Self {
        let units = (0..6 * bodies.len()).map(|row| if row % 6 < 3 { 1.0 } else { 0.5 }).collect();
        let weight = |(_, mass): &([f64; 3], f64)| [0.0, 0.0, -mass * G, 0.0, 0.0, 0.0];
        Self {
            centers: bodies.iter().map(|(center, _)| *center).collect(),
            load: bodies.iter().flat_map(weight).collect(),
            supports: Supports::new(units),
        }
    }

    /// A point at which body `b` is pushed along `n` by `a`; `None` is the ground.
    fn contact(&mut self, a: Option<usize>, b: Option<usize>, at: [f64; 3], n: [f64; 3], friction: f64) {
        let n = unit(n);
        let t = unit(cross(n, if n[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] }));
        let columns = [n, t, cross(n, t)].map(|along| {
            let mut column = Vec::new();
            for (body, sign) in [(a, -1.0), (b, 1.0)] {
                let Some(body) = body else { continue };
                let center = self.centers[body];
                let arm = [0, 1, 2].map(|k| at[k] - center[k]);
                let moment = cross(arm, along);
                column.extend((0..3).map(|k| (6 * body + k, sign * along[k])));
                column.extend((0..3).map(|k| (6 * body + 3 + k, sign * moment[k])));
            }
            column
        });
        self.supports.add(Cone::Coulomb { friction }, 1.0, columns);
    }

    fn table(legs: [f64; 2], height: f64, friction: f64, mass: f64) -> Self {
        let mut pile = Self::new(&[([0.0, 0.0, height], mass)]);
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            pile.contact(None, Some(0), [x * legs[0], y * legs[1], 0.0], [0.0, 0.0, 1.0], friction);
        }
        pile
    }

    /// A horizontal load of the weight on every body.
    fn sideways(&self, direction: [f64; 2]) -> Vec<f64> {
        let weight = |row: usize| self.load[row - row % 6 + 2].abs();
        (0..self.load.len()).map(|row| if row % 6 < 2 { direction[row % 6] * weight(row) } else { 0.0 }).collect()
    }

    fn verdict(&self) -> Verdict {
        self.supports.clone().standing(&self.load).unwrap().verdict
    }

    /// The smallest part of friction that holds it.
    fn margin(&self) -> Option<f64> {
        let whole = self.supports.clone().standing(&self.load).unwrap();
        self.supports.clone().friction_margin(&self.load, &whole).unwrap().map(|least| least.part)
    }
}

#[test]
fn a_block_on_an_incline_holds_down_to_the_tangent_of_its_slope() {
    for (angle, friction) in [(0.3_f64, 0.5), (0.1, 0.2), (0.7, 1.3)] {
        let mut block = Pile::new(&[([0.0, 0.0, 0.1], 2.0)]);
        block.load = vec![2.0 * G * angle.sin(), 0.0, -2.0 * G * angle.cos(), 0.0, 0.0, 0.0];
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            block.contact(None, Some(0), [0.4 * x, 0.2 * y, 0.0], [0.0, 0.0, 1.0], friction);
        }
        let margin = block.margin().unwrap();
        assert!((margin - angle.tan() / friction).abs() < 1e-9, "{margin} {}", angle.tan() / friction);
        assert_eq!(block.verdict(), Verdict::Stands);
    }
}

#[test]
fn one_part_in_a_million_decides_whether_a_block_slides() {
    let friction = 0.5_f64;
    for factor in [0.9, 0.999, 1.0 - 1e-6, 1.0 + 1e-6, 1.001, 1.1] {
        let angle = (friction * factor).atan();
        let mut block = Pile::table([0.2, 0.1], 0.1, friction, 2.0);
        block.load = vec![2.0 * G * angle.sin(), 0.0, -2.0 * G * angle.cos(), 0.0, 0.0, 0.0];
        let standing = block.supports.clone().standing(&block.load).unwrap();
        let expected = if factor < 1.0 { Verdict::Stands } else { Verdict::Falls };
        assert_eq!(standing.verdict, expected, "{factor} {standing:?}");
        assert_eq!(standing.slack > 0.0, factor < 1.0);
        if factor > 1.0 {
            assert!(standing.motion[0] > 0.9, "it slides down: {:?}", standing.motion);
        }
        let certificate = standing.certificate;
        assert!(certificate.unbalanced < 1e-12 && certificate.gap < 1e-8, "{certificate:?}");
    }
}

#[test]
fn a_table_tips_over_its_legs_and_has_six_self_stresses() {
    let table = Pile::table([0.4, 0.3], 1.2, 0.9, 10.0);
    let standing = table.supports.clone().standing(&table.load).unwrap();
    assert_eq!((standing.verdict, standing.self_stresses), (Verdict::Stands, 6));
    for leg in 0..4 {
        assert!((standing.forces[3 * leg] - 24.516625).abs() < 1e-6, "{:?}", standing.forces);
    }
    for (direction, expected) in [([1.0, 0.0], 0.4 / 1.2), ([0.0, 1.0], 0.3 / 1.2)] {
        let limit = table.supports.clone().limit(&table.load, &table.sideways(direction), true).unwrap();
        assert!((limit.value - expected).abs() < 1e-9, "{} {expected}", limit.value);
        // It turns about the legs: rates of tipping, not of sliding.
        assert!(limit.motion[2] > 0.1 || limit.motion[3].abs() + limit.motion[4].abs() > 0.1, "{:?}", limit.motion);
    }
}

#[test]
fn a_ladder_holds_down_to_its_margin() {
    // μ₁ μ₂ s² + 2 s μ₁ tan θ − 1 = 0 for a uniform ladder, θ from the floor.
    let (length, theta, floor, wall) = (4.0, 1.1_f64, 0.4, 0.3);
    let mut ladder = Pile::new(&[([0.5 * length * theta.cos(), 0.0, 0.5 * length * theta.sin()], 10.0)]);
    ladder.contact(None, Some(0), [length * theta.cos(), 0.0, 0.0], [0.0, 0.0, 1.0], floor);
    ladder.contact(None, Some(0), [0.0, 0.0, length * theta.sin()], [1.0, 0.0, 0.0], wall);
    let t = theta.tan();
    let expected = (-t + (t * t + wall / floor).sqrt()) / wall;
    let margin = ladder.margin().unwrap();
    assert!((margin - expected).abs() < 1e-9, "{margin} {expected}");
}

#[test]
fn a_box_in_a_slot_is_wedged_and_one_on_the_floor_of_it_stands() {
    let mut slot = Pile::new(&[([0.0, 0.0, 0.0], 1.0)]);
    slot.contact(None, Some(0), [-0.1, 0.0, 0.0], [1.0, 0.0, 0.0], 0.2);
    slot.contact(None, Some(0), [0.1, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.2);
    assert_eq!(slot.verdict(), Verdict::Wedged);
    assert!((slot.supports.least_squeeze(&slot.load).unwrap() - G / 0.4).abs() < 1e-6);
    slot.contact(None, Some(0), [0.0, 0.0, -0.1], [0.0, 0.0, 1.0], 0.2);
    assert_eq!(slot.verdict(), Verdict::Stands);
}

#[test]
fn a_box_held_by_one_wall_alone_falls() {
    let mut slot = Pile::new(&[([0.0, 0.0, 0.0], 1.0)]);
    slot.contact(None, Some(0), [-0.1, 0.0, 0.0], [1.0, 0.0, 0.0], 5.0);
    assert_eq!(slot.verdict(), Verdict::Falls);
    assert_eq!(slot.margin(), None);
}

#[test]
fn four_balls_need_the_friction_of_their_closed_form() {
    // Three balls on a floor that touch each other, one on top: μ ≥ √3 − √2 at all contacts.
    let r = 0.1_f64;
    let ring = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 3.0;
        let far = 2.0 * r / 3.0_f64.sqrt();
        [far * angle.cos(), far * angle.sin(), r]
    };
    let top = [0.0, 0.0, r + (4.0 * r * r - 4.0 * r * r / 3.0).sqrt()];
    let pile = |friction: f64| {
        let mut pile = Pile::new(&[(ring(0), 1.0), (ring(1), 1.0), (ring(2), 1.0), (top, 1.0)]);
        for k in 0..3 {
            let low = ring(k);
            pile.contact(None, Some(k), [low[0], low[1], 0.0], [0.0, 0.0, 1.0], friction);
            let between = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
            let along = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| b[i] - a[i]);
            pile.contact(Some(k), Some(3), between(low, top), along(low, top), friction);
            let next = ring((k + 1) % 3);
            pile.contact(Some(k), Some((k + 1) % 3), between(low, next), along(low, next), friction);
        }
        pile
    };
    let needed = 3.0_f64.sqrt() - 2.0_f64.sqrt();
    let margin = pile(1.0).margin().unwrap();
    assert!((margin - needed).abs() < 1e-7, "{margin} {needed}");
    assert_eq!(pile(needed * (1.0 + 1e-6)).verdict(), Verdict::Stands);
    assert_eq!(pile(needed * (1.0 - 1e-6)).verdict(), Verdict::Falls);
}

#[test]
fn an_arm_with_dry_friction_holds_an_interval_of_payloads() {
    // A stretched horizontal arm of two links with motors of 30 and 11 N m, friction of 4 and 1.5 N m: the payload at its
    // tip is bounded by one hinge at each end.
    let (m1, l1, m2, l2) = (3.0, 0.5, 2.0, 0.4);
    let mut supports = Supports::new(vec![1.0, 1.0]);
    supports.add(Cone::Ball { bound: 4.0, size: 1 }, 1.0, [vec![(0, 1.0)]]);
    supports.add(Cone::Ball { bound: 1.5, size: 1 }, 1.0, [vec![(1, 1.0)]]);
    // Generalized loads of the relative angles, upwards.
    let weight = [-(m1 * l1 / 2.0 + m2 * (l1 + l2 / 2.0)) * G, -(m2 * l2 / 2.0) * G];
    let load = [30.0 + weight[0], 11.0 + weight[1]];
    let payload = vec![-(l1 + l2), -l2];
    let at = |downwards: f64| -> Vec<f64> { load.iter().zip(&payload).map(|(w, p)| w + downwards * p).collect() };
    let middle = at(14.1);
    let low = 14.1 + supports.clone().limit(&middle, &payload, false).unwrap().value;
    let high = 14.1 + supports.clone().limit(&middle, &payload, true).unwrap().value;
    let ends = |k: usize, bound: f64| ((load[k] - bound) / -payload[k], (load[k] + bound) / -payload[k]);
    let (first, second) = (ends(0, 4.0), ends(1, 1.5));
    assert!((low - first.0.max(second.0)).abs() < 1e-9, "{low} {first:?} {second:?}");
    assert!((high - first.1.min(second.1)).abs() < 1e-9, "{high} {first:?} {second:?}");
    assert_eq!(supports.clone().standing(&middle).unwrap().verdict, Verdict::Stands);
    assert_eq!(supports.clone().standing(&at(20.0)).unwrap().verdict, Verdict::Falls);
}

#[test]
fn what_nothing_loads_stands_and_what_nothing_holds_falls() {
    let mut supports = Supports::new(vec![1.0, 1.0]);
    supports.add(Cone::Ray, 1.0, [vec![(0, 1.0)]]);
    assert_eq!(supports.clone().standing(&[0.0, 0.0]).unwrap().verdict, Verdict::Stands);
    assert_eq!(supports.clone().standing(&[-2.0, 0.0]).unwrap().verdict, Verdict::Stands);
    assert_eq!(supports.clone().standing(&[2.0, 0.0]).unwrap().verdict, Verdict::Falls);
    assert_eq!(supports.clone().standing(&[-2.0, 1.0]).unwrap().verdict, Verdict::Falls);
}

/// A semicircular arch of voussoirs with radial joints, thickness over mean radius given, that cannot slide, in its own plane: x, z and
/// the turn about y of each.
fn arch(count: usize, thickness: f64) -> (Supports, Vec<f64>) {
    let (outer, inner) = (1.0 + 0.5 * thickness, 1.0 - 0.5 * thickness);
    let step = std::f64::consts::PI / count as f64;
    let joint = |k: usize| -std::f64::consts::FRAC_PI_2 + step * k as f64;
    let radius = 2.0 / 3.0 * (outer.powi(3) - inner.powi(3)) / (outer.powi(2) - inner.powi(2)) * (0.5 * step).sin()
        / (0.5 * step);
    let weight = 0.5 * (outer * outer - inner * inner) * step * G;
    let center = |k: usize| [radius * (joint(k) + 0.5 * step).sin(), radius * (joint(k) + 0.5 * step).cos()];
    let mut supports = Supports::new([1.0, 1.0, 0.5].repeat(count));
    for k in 0..=count {
        let (normal, along) = ([joint(k).cos(), -joint(k).sin()], [joint(k).sin(), joint(k).cos()]);
        for r in [inner, outer] {
            let at = along.map(|x| r * x);
            let column = |way: [f64; 2]| {
                let sides = [(k.checked_sub(1), -1.0), (Some(k).filter(|k| *k < count), 1.0)];
                let each = sides.into_iter().filter_map(|(body, sign)| body.map(|body| (body, sign)));
                each.flat_map(|(body, sign)| {
                    let [x, z] = center(body);
                    let moment = (at[1] - z) * way[0] - (at[0] - x) * way[1];
                    [(3 * body, sign * way[0]), (3 * body + 1, sign * way[1]), (3 * body + 2, sign * moment)]
                })
                .collect::<Vec<_>>()
            };
            supports.add(Cone::Ray, 1.0, [column(normal)]);
            supports.add(Cone::Free, 1.0, [column(along)]);
        }
    }
    (supports, [0.0, -weight, 0.0].repeat(count))
}

/// Milankovitch's arch (1907): 0.107478 of the mean radius is enough, and thinner ones fall by five hinges, those at the haunches 54.5° from
/// the crown.
#[test]
fn the_least_arch_falls_by_five_hinges() {
    // By bisection over conic programs in Python; continuous joints need 0.107 478 038 (Milankovitch).
    let (count, least) = (400, 0.107_477_949_6);
    let (supports, load) = arch(count, least + 1e-8);
    assert_eq!(supports.clone().standing(&load).unwrap().verdict, Verdict::Stands);
    let (supports, load) = arch(count, least - 1e-8);
    let standing = supports.clone().standing(&load).unwrap();
    assert_eq!(standing.verdict, Verdict::Falls);
    let spin = |k: usize| standing.motion.get(3 * k + 2).copied().unwrap_or(0.0);
    let before = |k: usize| if k == 0 { 0.0 } else { spin(k - 1) };
    let turns: Vec<f64> = (0..=count).map(|k| spin(k) - before(k)).collect();
    let most = turns.iter().fold(0.0_f64, |most, turn| most.max(turn.abs()));
    let hinges: Vec<(usize, f64)> =
        turns.iter().enumerate().filter(|(_, turn)| turn.abs() > 1e-2 * most).map(|(k, turn)| (k, *turn)).collect();
    // Joints beside each other may share one hinge.
    let groups = 1 + hinges.windows(2).filter(|pair| pair[1].0 > pair[0].0 + 1).count();
    assert_eq!(groups, 5, "{hinges:?}");
    let haunch =
        hinges.iter().map(|(k, _)| 90.0 - 180.0 * *k as f64 / count as f64).filter(|deg| *deg > 10.0 && *deg < 80.0);
    let off = haunch.map(|deg| (deg - 54.484).abs()).fold(f64::INFINITY, f64::min);
    assert!(off < 180.0 / count as f64, "{hinges:?}");
}

/// Coordinates that feel no support have loads, as the strains of a beam beside a loop have: what no forces balance falls, with that motion,
/// however badly the program ends on what has no answer.
#[test]
fn loads_that_no_support_feels_fall_beside_free_rows_and_contacts() {
    let mut random = crate::common::Random::new(0xfa115);
    for case in 0..200 {
        let (rows, felt) = (12 + case % 25, 2 + case % 7);
        let mut supports = Supports::new(vec![1.0; rows]);
        let mut load = vec![0.0; rows];
        // Rows feel supports by very different arms, and what they bear is theirs exactly: the rest is left over.
        let mut arm =
            || 10f64.powf(random.between(-3.0, 3.0)) * if random.between(-1.0, 1.0) > 0.0 { 1.0 } else { -1.0 };
        for of in 0..felt {
            let column: Vec<(usize, f64)> =
                (0..felt).map(|row| (row, if row == of { 1.0 } else { 0.1 * arm() })).collect();
            supports.add(Cone::Free, 1.0, [column]);
        }
        load[..felt].iter_mut().for_each(|load| *load = arm());
        let contact = [0, 1, 2].map(|k| vec![(k, 1.0)]);
        if case % 2 == 0 && felt > 2 {
            supports.add(Cone::Coulomb { friction: 0.3 }, 1.0, contact);
        }
        let without = supports.clone().standing(&load);
        assert!(without.is_ok_and(|standing| standing.verdict == Verdict::Stands), "case {case}");
        load[felt..].iter_mut().for_each(|load| *load = arm());
        let standing = supports.standing(&load).unwrap_or_else(|undecided| panic!("case {case}: {undecided}"));
        assert_eq!(standing.verdict, Verdict::Falls, "case {case}");
        let moved = standing.motion[..felt].iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
        assert!(moved < 1e-6, "case {case}: {:?}", standing.motion);
    }
}
