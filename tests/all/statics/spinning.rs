//! Steady motions: frequencies and verdicts with Coriolis forces.

use crate::common::Random;
use std::f64::consts::TAU;
use stillpoint::model::Model;
use stillpoint::scenario::parse;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

/// Two sliders across a shaft that turns: springs `k`, masses of the first and the second.
struct Shaft {
    rate: f64,
    stiffness: [f64; 2],
    mass: [f64; 2],
    damping: f64,
}

impl Shaft {
    fn new(random: &mut Random) -> Self {
        let stiffness = [random.between(5.0, 60.0), random.between(5.0, 60.0)];
        let mass = [random.between(0.1, 1.0), random.between(0.5, 2.0)];
        Self { rate: random.between(0.5, 12.0), stiffness, mass, damping: 0.0 }
    }

    fn found(&self) -> Equilibrium {
        let Self { rate, stiffness: [ky, kz], mass: [first, second], damping } = self;
        let text = format!(
            "gravity = [0.0, 0.0, 0.0]\n[statics]\nwant = \"any\"\n[[body]]\nname = \"hub\"\nmass = 1.0\ninertia = [1, 1, 1]\n\
             hinge = {{ type = \"revolute\", axis = [1, 0, 0] }}\n[[body]]\nname = \"y\"\nmass = {first}\n\
             hinge = {{ type = \"prismatic\", parent = \"hub\", axis = [0, 1, 0], stiffness = {ky}, damping = {damping} }}\n[[body]]\nname = \"z\"\nmass = {second}\n\
             hinge = {{ type = \"prismatic\", parent = \"y\", axis = [0, 0, 1], stiffness = {kz}, damping = {damping} }}\n\
             [[drive]]\nname = \"motor\"\nhinge = \"hub\"\ntype = \"rate\"\nrate = {rate}\n"
        );
        let scenario = parse("shaft.toml", &text, &[]).expect("a scene");
        let model = Model::build(&scenario.description).expect("a model");
        equilibrium(&model, &scenario.statics, &model.start_position).expect("statics")
    }

    /// `ω²` of `(k_y − M_y (Ω² + ω²)) (k_z − M_z (Ω² + ω²)) = (2 Ω ω m)²`, the lower one first; `None` if they are no real numbers.
    fn squares(&self) -> Option<[f64; 2]> {
        let (o, [ky, kz], [my, mz]) =
            (self.rate * self.rate, self.stiffness, [self.mass[0] + self.mass[1], self.mass[1]]);
        let (py, pz) = (ky - my * o, kz - mz * o);
        let (a, b, c) = (my * mz, -(py * mz + pz * my + 4.0 * o * mz * mz), py * pz);
        let root = b * b - 4.0 * a * c;
        (root >= 0.0).then(|| [-1.0, 1.0].map(|sign| (-b + sign * root.sqrt()) / (2.0 * a)))
    }
}

#[test]
fn frequencies_and_verdicts_of_shafts_have_coriolis_forces() {
    let mut random = Random::new(41);
    let (mut stable, mut unstable, mut held_by_coriolis) = (0, 0, 0);
    for case in 0..60 {
        let shaft = Shaft::new(&mut random);
        let found = shaft.found();
        let stability = found.stability.as_ref().expect("an equilibrium");
        match shaft.squares().filter(|squares| squares[0] > 0.0) {
            Some(squares) => {
                assert_eq!(stability.verdict, StabilityVerdict::Stable, "{case}: {squares:?}");
                let hertz: Vec<f64> = stability.frequencies().collect();
                assert_eq!(hertz.len(), 2, "{case}: {hertz:?}");
                for (hz, square) in hertz.iter().zip(squares) {
                    assert!((TAU * hz / square.sqrt() - 1.0).abs() < 1e-7, "{case}: {hertz:?}, {squares:?}");
                }
                stable += 1;
                let softest = (0..2)
                    .map(|i| shaft.stiffness[i] / if i == 0 { shaft.mass[0] + shaft.mass[1] } else { shaft.mass[1] });
                held_by_coriolis += usize::from(softest.fold(f64::INFINITY, f64::min) < shaft.rate * shaft.rate);
            }
            None => {
                assert_eq!(stability.verdict, StabilityVerdict::Unstable, "{case}");
                unstable += 1;
            }
        }
    }
    assert!(stable > 10 && unstable > 5 && held_by_coriolis > 2, "{stable} {unstable} {held_by_coriolis}");
}

/// Without damping and with next to none frequencies are the same.
#[test]
fn little_damping_changes_no_frequency() {
    let mut random = Random::new(5);
    let mut seen = 0;
    for _ in 0..40 {
        let shaft = Shaft::new(&mut random);
        let without = shaft.found();
        let with = Shaft { damping: 1e-9, ..shaft }.found();
        let stability = without.stability.as_ref().expect("an equilibrium");
        if stability.verdict != StabilityVerdict::Stable {
            continue;
        }
        let damped = &with.stability.as_ref().expect("an equilibrium").damped;
        for (hz, mode) in stability.frequencies().zip(damped) {
            assert!((hz / mode.frequency_hz - 1.0).abs() < 1e-6, "{hz} and {}", mode.frequency_hz);
        }
        seen += 1;
    }
    assert!(seen > 10, "{seen}");
}

/// Links on universal hinges, one on the other, along a shaft that turns.
struct Links {
    rate: f64,
    mass: f64,
    length: f64,
    /// About the axes across a link and along it, at its middle.
    inertia: [f64; 2],
    stiffness: f64,
    count: usize,
}

impl Links {
    fn found(&self, rate: f64) -> Equilibrium {
        let Self { mass, length, inertia: [across, along], stiffness, count, .. } = self;
        let text = format!(
            "gravity = [0, 0, 0]\n[statics]\nwant = \"any\"\n[[body]]\nname = \"s\"\nmass = 1.0\ninertia = [1, 1, 1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 0, 1] }}\n[[drive]]\nhinge = \"s\"\ntype = \"rate\"\nrate = {rate:?}\n\
             [[body]]\nname = \"l\"\nrepeat = {count}\nmass = {mass:?}\ncenter = [0, 0, {:?}]\ninertia = [{across:?}, {across:?}, {along:?}]\n\
             markers = {{ t = [0, 0, {length:?}] }}\nhinge = {{ type = \"universal\", parent = \"s\", at = [0, 0, 0], next = \"t\", \
             axes = [[1, 0, 0], [0, 1, 0]], stiffness = {stiffness:?} }}\n",
            0.5 * length
        );
        let scenario = parse("links.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = Model::build(&scenario.description).expect("a model");
        equilibrium(&model, &scenario.statics, &model.start_position).expect("statics")
    }

    fn new(random: &mut Random, count: usize) -> Self {
        let (mass, length) = (10_f64.powf(random.between(-2.0, 1.0)), random.between(0.05, 0.5));
        let across = mass * length * length * random.between(0.01, 0.2);
        let [stiffness, rate] = [random.between(1.0, 7.0), random.between(-2.0, 1.5)].map(|x| 10_f64.powf(x));
        Self { rate, mass, length, inertia: [across, across * random.between(0.1, 1.9)], stiffness, count }
    }
}

fn assert_swings(found: &Equilibrium, expected: &[f64], slack: f64, told: &str) {
    let stability = found.stability.as_ref().expect("an equilibrium");
    assert_eq!((stability.verdict, stability.unstable_directions), (StabilityVerdict::Stable, 0), "{told}");
    assert!(stability.modes.iter().all(|mode| mode.growth_rate == 0.0), "{told}");
    let hertz: Vec<f64> = stability.frequencies().collect();
    assert_eq!(hertz.len(), expected.len(), "{told}: {hertz:?}, {expected:?}");
    for (hz, rate) in hertz.iter().zip(expected) {
        assert!((TAU * hz - rate).abs() < slack, "{told}: {} of {expected:?}", TAU * hz);
    }
}

/// A link of moments `J` across and `A` along it, whose spring is as stiff about both axes: seen from the ground it goes round with the roots
/// of `J λ² − A Ω λ − k = 0`, from the shaft with `λ − Ω`. It is never unstable, how near the two frequencies may be.
#[test]
fn a_link_on_a_shaft_goes_round_as_the_closed_form_says() {
    let mut random = Random::new(77);
    for case in 0..80 {
        let link = Links::new(&mut random, 1);
        let (j, a) = (link.inertia[0] + 0.25 * link.mass * link.length * link.length, link.inertia[1]);
        let spin = a * link.rate;
        let root = (spin * spin + 4.0 * j * link.stiffness).sqrt();
        let mut expected = [1.0, -1.0].map(|sign| ((spin + sign * root) / (2.0 * j) - link.rate).abs());
        expected.sort_by(f64::total_cmp);
        // Roots near zero are those of a stiffness that is nearly zero: they are known to the root of a unit in the last place.
        if expected[0] < 1e-2 * expected[1] {
            continue;
        }
        assert_swings(&link.found(link.rate), &expected, 1e-9 * expected[1], &format!("{case}"));
    }
}

/// Links without inertia about themselves swing on a shaft that turns with `|ω ± Ω|`, `ω` being the frequencies at rest: pairs that are the
/// nearer to each other the slower it turns, and never unstable.
#[test]
fn chains_on_a_shaft_swing_beside_their_frequencies_at_rest() {
    let mut random = Random::new(78);
    for case in 0..24 {
        let mut links = Links::new(&mut random, 1 + case % 6);
        links.inertia[1] = 1e-12 * links.inertia[0];
        let rest = links.found(0.0);
        let at_rest: Vec<f64> =
            rest.stability.as_ref().expect("an equilibrium").frequencies().map(|hz| TAU * hz).collect();
        assert_eq!(at_rest.len(), 2 * links.count, "{case}");
        links.rate = links.rate.min(0.5 * at_rest[0]);
        // Each frequency at rest is one of two that are equal.
        let mut expected: Vec<f64> = at_rest
            .iter()
            .enumerate()
            .map(|(k, rate)| if k % 2 == 0 { rate - links.rate } else { rate + links.rate })
            .collect();
        expected.sort_by(f64::total_cmp);
        // Both are eigenvalue problems of squares: their round-off is that of the highest one.
        let slack = 1e-9 * at_rest[at_rest.len() - 1];
        assert_swings(&links.found(links.rate), &expected, slack, &format!("{case}"));
    }
}

/// A disc on a shaft with springs `k` and dampers `c` that turn with it, in complex numbers `s² + (c/m + 2iΩ) s + ω² − Ω² = 0`: beyond `ω` one
/// of its two motions grows, the other decays. Each mode is told with what is its own.
#[test]
fn of_a_shaft_with_dampers_that_turn_one_motion_grows() {
    let mut random = Random::new(79);
    let mut counts = [0, 0];
    for case in 0..60 {
        let (mass, own) = (random.between(0.2, 5.0), random.between(2.0, 30.0));
        let (rate, decay) = (own * random.between(0.2, 2.5), own * random.between(0.01, 0.2));
        if (rate / own - 1.0).abs() < 0.05 {
            continue;
        }
        let (stiffness, damping) = (mass * own * own, mass * decay);
        let text = format!(
            "gravity = [0, 0, 0]\n[statics]\nwant = \"any\"\n[[body]]\nname = \"shaft\"\nmass = 1\ninertia = [1, 1, 1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 0, 1] }}\n[[body]]\nname = \"x\"\nmass = 0\n\
             hinge = {{ type = \"prismatic\", parent = \"shaft\", axis = [1, 0, 0], stiffness = {stiffness:?}, damping = {damping:?} }}\n\
             [[body]]\nname = \"y\"\nmass = {mass:?}\n\
             hinge = {{ type = \"prismatic\", parent = \"x\", axis = [0, 1, 0], stiffness = {stiffness:?}, damping = {damping:?} }}\n\
             [[drive]]\nhinge = \"shaft\"\ntype = \"rate\"\nrate = {rate:?}\n"
        );
        let scenario = parse("disc.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = Model::build(&scenario.description).expect("a model");
        let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        let stability = found.stability.as_ref().expect("an equilibrium");
        let hertz: Vec<f64> = stability.frequencies().collect();
        let undamped = [(own - rate).abs(), own + rate];
        assert_eq!(hertz.len(), 2, "{text}");
        assert!(hertz.iter().zip(undamped).all(|(hz, rate)| (TAU * hz / rate - 1.0).abs() < 1e-8), "{hertz:?}\n{text}");
        // s = −(d/2 + iΩ) ± √((d/2 + iΩ)² − ω² + Ω²)
        let (re, im) = (0.25 * decay * decay - own * own, decay * rate);
        let growth = (0.5 * (re.hypot(im) + re)).sqrt() - 0.5 * decay;
        let grows = usize::from(growth > 0.0);
        counts[grows] += 1;
        assert_eq!(stability.unstable_directions, grows, "{case}: {growth}\n{text}");
        let rates: Vec<f64> = stability.modes.iter().map(|mode| mode.growth_rate).filter(|rate| *rate > 0.0).collect();
        assert_eq!(rates.len(), grows, "{rates:?}\n{text}");
        if grows == 1 {
            assert!((rates[0] / growth - 1.0).abs() < 1e-8, "{rates:?} {growth}\n{text}");
            assert!((TAU * stability.modes[0].frequency_hz / undamped[0] - 1.0).abs() < 1e-8, "{text}");
        }
    }
    assert!(counts.iter().all(|count| *count > 10), "{counts:?}");
}
