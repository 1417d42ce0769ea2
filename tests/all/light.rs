//! Light links that carry bodies a million to a billion times heavier: accelerations against twice as many digits.
//!
//! Where the heavy body does not resist a light link's motion (in a straight chain, under a carriage) the pivot of that link is
//! the difference of two inertias of the heavy one. In double numbers nothing of it would be left at 10¹⁶.

use crate::common::{Random, build};
use std::fmt::Write;
use std::ops::{Add, Div, Mul, Neg, Sub};
use stillpoint::dynamics::System;
use stillpoint::scenario;

/// A number of about 32 digits, as the sum of two (Dekker 1971).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Long(f64, f64);

fn sum(a: f64, b: f64) -> Long {
    let s = a + b;
    let part = s - a;
    Long(s, (a - (s - part)) + (b - part))
}

impl From<f64> for Long {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Add for Long {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.0, other.0), sum(self.1, other.1));
        let first = sum(high.0, high.1 + low.0);
        sum(first.0, first.1 + low.1)
    }
}

impl Neg for Long {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Long {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Long {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        sum(product, self.0.mul_add(other.0, -product) + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Long {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self - other * first.into();
        let second = rest.0 / other.0;
        let rest = rest - other * second.into();
        sum(first, second) + (rest.0 / other.0).into()
    }
}

/// Sine and cosine by their series, for angles of up to some radians.
fn sin_cos(x: Long) -> [Long; 2] {
    let (mut term, mut sums) = (Long::from(1.0), [Long::from(0.0); 2]);
    for n in 0..60 {
        let sign = if n % 4 < 2 { term } else { -term };
        sums[1 - n % 2] = sums[1 - n % 2] + sign;
        term = term * x / (n as f64 + 1.0).into();
    }
    sums
}

/// A link of a chain in the plane y = 0, each 1 m below the one before.
struct Link {
    slides: bool,
    ball: bool,
    position: f64,
    mass: f64,
    /// Depth of the centre of mass, and the moment of inertia about it.
    center: f64,
    inertia: f64,
    /// Moment about y that acts on it.
    moment: f64,
    /// Horizontal force at its root marker.
    force: f64,
}

/// `q̈` at rest without weight, from the mass matrix by Jacobians and elimination, all in long numbers.
fn accelerations(chain: &[Link]) -> Vec<f64> {
    let n = chain.len();
    let zero = Long::from(0.0);
    let mut angle = zero;
    let mut root = [zero; 2];
    // Per coordinate: the hinge point, and the axis of a slide.
    let mut joints: Vec<([Long; 2], Option<[Long; 2]>)> = Vec::new();
    let (mut mass, mut load) = (vec![vec![zero; n]; n], vec![zero; n]);
    for (index, link) in chain.iter().enumerate() {
        let [sin, cos] = sin_cos(angle);
        if index > 0 {
            root = [root[0] - sin, root[1] - cos];
        }
        if link.slides {
            let axis = [cos, -sin];
            joints.push((root, Some(axis)));
            root = [root[0] + axis[0] * link.position.into(), root[1] + axis[1] * link.position.into()];
        } else {
            joints.push((root, None));
            angle = angle + link.position.into();
        }
        let [sin, cos] = sin_cos(angle);
        let center = [root[0] - sin * link.center.into(), root[1] - cos * link.center.into()];
        // How a point moves with a coordinate: about +y from z to x.
        let moves = |joint: usize, point: [Long; 2]| match joints[joint] {
            (_, Some(axis)) => axis,
            (at, None) => [point[1] - at[1], at[0] - point[0]],
        };
        let turns = |joint: usize| if joints[joint].1.is_none() { 1.0 } else { 0.0 };
        for i in 0..=index {
            let [a, at_root] = [moves(i, center), moves(i, root)];
            load[i] = load[i] + Long::from(link.moment * turns(i)) + at_root[0] * link.force.into();
            for j in 0..=index {
                let b = moves(j, center);
                let work = (a[0] * b[0] + a[1] * b[1]) * link.mass.into();
                mass[i][j] = mass[i][j] + work + Long::from(link.inertia * turns(i) * turns(j));
            }
        }
    }
    for k in 0..n {
        for i in k + 1..n {
            let part = mass[i][k] / mass[k][k];
            (k..n).for_each(|j| mass[i][j] = mass[i][j] - part * mass[k][j]);
            load[i] = load[i] - part * load[k];
        }
    }
    for k in (0..n).rev() {
        for j in k + 1..n {
            load[k] = load[k] - mass[k][j] * load[j];
        }
        load[k] = load[k] / mass[k][k];
    }
    load.iter().map(|x| x.0).collect()
}

/// One to three light links, and a heavy one; nearly straight.
fn chain(random: &mut Random, ratio: f64) -> Vec<Link> {
    let light = 1 + random.below(3);
    let nearly = |random: &mut Random| {
        if random.below(4) == 0 { 0.0 } else { random.between(-1.0, 1.0) * 10_f64.powf(random.between(-7.0, -2.0)) }
    };
    let mut links: Vec<Link> = (0..light)
        .map(|index| Link {
            slides: index == 0 && random.below(3) == 0,
            ball: random.below(4) == 0,
            position: nearly(random),
            mass: random.between(0.3, 3.0),
            center: random.between(0.2, 1.0),
            inertia: random.between(0.01, 0.3),
            moment: random.between(-5.0, 5.0),
            force: random.between(-5.0, 5.0),
        })
        .collect();
    links[0].position = if links[0].slides { 0.3 } else { random.between(-1.0, 1.0) };
    let mass = ratio * random.between(0.5, 2.0);
    let center = random.between(0.3, 1.5);
    let spread = if random.below(2) == 0 { 1e-9 } else { random.between(0.01, 0.5) };
    let (position, inertia) = (nearly(random), spread * mass);
    let (moment, force) = (random.between(-5.0, 5.0), random.between(-5.0, 5.0));
    links.push(Link { slides: false, ball: false, position, mass, center, inertia, moment, force });
    links
}

fn text(chain: &[Link]) -> String {
    let mut text = "gravity = [0, 0, 0]\n".to_owned();
    for (index, link) in chain.iter().enumerate() {
        let Link { mass, center, inertia, position, moment, force, .. } = link;
        let on = if index == 0 { String::new() } else { format!(", parent = \"l{}\", at = [0, 0, -1]", index - 1) };
        let hinge = match (link.slides, link.ball) {
            (true, _) => format!("type = \"prismatic\", axis = [1, 0, 0], position = {position:?}"),
            (_, true) => {
                let (sin, cos) = (0.5 * position).sin_cos();
                format!("type = \"spherical\", position = [{cos:?}, 0.0, {sin:?}, 0.0]")
            }
            _ => format!("type = \"revolute\", axis = [0, 1, 0], position = {position:?}"),
        };
        let _ = write!(
            text,
            "[[body]]\nname = \"l{index}\"\nmass = {mass:?}\ncenter = [0, 0, -{center:?}]\n\
             inertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nhinge = {{ {hinge}{on} }}\n\
             [[force]]\ntype = \"load\"\non = \"l{index}\"\nforce = [{force:?}, 0, 0]\ntorque = [0, {moment:?}, 0]\n"
        );
    }
    text
}

#[test]
fn light_links_before_heavy_ones_keep_their_digits() {
    let mut worst = [0.0_f64; 4];
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let decade = random.below(4);
        let links = chain(&mut random, [1e6, 1e8, 1e9, 1e12][decade]);
        let text = text(&links);
        let scenario =
            scenario::parse("light.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = build(&scenario.description);
        let still = vec![0.0; model.velocity_count()];
        let mut found = still.clone();
        System::new(&model).at(0.0, &model.start_position, &still).accelerations(&mut found).expect("a regular tree");
        let expected = accelerations(&links);
        let largest = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let found = model
            .bodies
            .iter()
            .zip(&links)
            .map(|(body, link)| found[body.hinge.velocity + usize::from(link.ball && !link.slides)]);
        let error = found.zip(&expected).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max);
        // Angles are known to some 1e-16, of which a relative one of 1e-7 has nine digits.
        assert!(error < 1e-9, "seed {seed}, decade {decade}: {error:.1e}\n{text}");
        worst[decade] = worst[decade].max(error);
    }
    println!("largest errors at 1e6, 1e8, 1e9 and 1e12: {}", worst.map(|error| format!("{error:.1e}")).join(", "));
}

type Long3 = [Long; 3];

fn cross(a: &Long3, b: &Long3) -> Long3 {
    [a[1] * b[2] + -(a[2] * b[1]), a[2] * b[0] + -(a[0] * b[2]), a[0] * b[1] + -(a[1] * b[0])]
}

/// The rotation of a quaternion w, x, y, z of any length.
fn rotation(q: &[f64]) -> [Long3; 3] {
    let [w, x, y, z] = [q[0], q[1], q[2], q[3]].map(Long::from);
    let two = Long::from(2.0) / (w * w + x * x + y * y + z * z);
    let off = |a: Long, b: Long, sign: f64| two * (a + b * sign.into());
    let on = |a: Long, b: Long| Long::from(1.0) - two * (a * a + b * b);
    [
        [on(y, z), off(x * y, w * z, -1.0), off(x * z, w * y, 1.0)],
        [off(x * y, w * z, 1.0), on(x, z), off(y * z, w * x, -1.0)],
        [off(x * z, w * y, -1.0), off(y * z, w * x, 1.0), on(x, y)],
    ]
}

/// `A x = b` by elimination with partial pivoting.
fn solved(mut a: Vec<Vec<Long>>) -> Vec<Long> {
    let n = a.len();
    for k in 0..n {
        let best = (k..n).max_by(|i, j| a[*i][k].0.abs().total_cmp(&a[*j][k].0.abs())).unwrap();
        a.swap(k, best);
        for i in k + 1..n {
            let part = a[i][k] / a[k][k];
            for j in k..=n {
                let taken = part * a[k][j];
                a[i][j] = a[i][j] - taken;
            }
        }
    }
    let mut x = vec![Long::from(0.0); n];
    for k in (0..n).rev() {
        let known = (k + 1..n).fold(a[k][n], |sum, j| sum - a[k][j] * x[j]);
        x[k] = known / a[k][k];
    }
    x
}

/// `q̈` of bodies on balls, each 1 m below the one before, at rest under gravity: momentum and moment of momentum of each body
/// with the forces in the balls as unknowns, all in long numbers.
fn hanging(quaternions: &[f64], masses: &[f64], inertia: [f64; 3]) -> Vec<f64> {
    let (n, zero, gravity) = (masses.len(), Long::from(0.0), -9.81);
    let mut turn = rotation(&[1.0, 0.0, 0.0, 0.0]);
    let mut turns = Vec::new();
    for q in quaternions.chunks(4) {
        let own = rotation(q);
        turn = [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).fold(zero, |sum, k| sum + turn[i][k] * own[k][j])));
        turns.push(turn);
    }
    // Per body its angular acceleration and the force in its ball.
    let mut a = vec![vec![zero; 6 * n + 1]; 6 * n];
    let units: [Long3; 3] = [0, 1, 2].map(|i| [0, 1, 2].map(|k| Long::from(if i == k { 1.0 } else { 0.0 })));
    for (i, mass) in masses.iter().enumerate() {
        let down = |body: usize, length: f64| turns[body].map(|row| row[2] * (-length).into());
        let (own, mass) = (down(i, 0.5), Long::from(*mass));
        let others = (0..i).map(|j| (j, down(j, 1.0)));
        for (j, arm) in others.chain([(i, own)]) {
            for (k, unit) in units.iter().enumerate() {
                let moved = cross(unit, &arm);
                (0..3).for_each(|r| a[6 * i + r][6 * j + k] = a[6 * i + r][6 * j + k] + mass * moved[r]);
            }
        }
        let below = down(i, 0.5);
        for (k, unit) in units.iter().enumerate() {
            let (here, there) = (cross(&own, unit), cross(&below, unit));
            for r in 0..3 {
                let turned = (0..3).fold(zero, |sum, m| sum + turns[i][r][m] * Long::from(inertia[m]) * turns[i][k][m]);
                a[6 * i + 3 + r][6 * i + k] = mass * turned;
                // The ball is at `−own` from the centre of mass, the next one at `below`.
                a[6 * i + 3 + r][6 * i + 3 + k] = here[r];
                if i + 1 < n {
                    a[6 * i + 3 + r][6 * i + 9 + k] = there[r];
                }
            }
            a[6 * i + k][6 * i + 3 + k] = Long::from(-1.0);
            if i + 1 < n {
                a[6 * i + k][6 * i + 9 + k] = Long::from(1.0);
            }
        }
        a[6 * i + 2][6 * n] = mass * gravity.into();
    }
    let found = solved(a);
    let mut relative = Vec::new();
    for i in 0..n {
        for column in 0..3 {
            let part = |k: usize| found[6 * i + k] - if i > 0 { found[6 * i - 6 + k] } else { zero };
            relative.push((0..3).fold(zero, |sum, k| sum + turns[i][k][column] * part(k)).0);
        }
    }
    relative
}

#[test]
fn chains_of_balls_before_heavy_bodies_keep_their_digits() {
    let mut worst = [0.0_f64; 4];
    for seed in 0..200 {
        let mut random = Random::new(1000 + seed);
        let decade = random.below(4);
        let count = 2 + random.below(5);
        // Thin rods among them, as thin as the round-off of what the heavy body resists allows.
        let mass = [1e6, 1e8, 1e9, 1e10][decade];
        let thin: f64 = [1e-2, 1e-4, 1e-6][random.below(3)];
        let inertia = [0.085, 0.085, thin.max(1e-14 * mass)];
        let mut text = "gravity = [0.0, 0.0, -9.81]\n".to_owned();
        let masses: Vec<f64> = (1..=count).map(|i| if i == count { mass } else { 1.0 }).collect();
        for (index, mass) in masses.iter().enumerate() {
            let on = if index == 0 { String::new() } else { format!(", parent = \"l{}\", at = [0, 0, -1]", index - 1) };
            let q = [0; 4].map(|_| random.between(-1.0, 1.0));
            let _ = write!(
                text,
                "[[body]]\nname = \"l{index}\"\nmass = {mass:?}\ncenter = [0, 0, -0.5]\ninertia = {:?}\n\
                 hinge = {{ type = \"spherical\", position = {:?}{on} }}\n",
                inertia.map(|moment| moment * mass),
                q.map(|part| part / q.iter().map(|x| x * x).sum::<f64>().sqrt()),
            );
        }
        let scenario =
            scenario::parse("balls.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = build(&scenario.description);
        let still = vec![0.0; model.velocity_count()];
        let mut found = still.clone();
        System::new(&model).at(0.0, &model.start_position, &still).accelerations(&mut found).expect("a regular tree");
        let expected = hanging(&model.start_position, &masses, inertia);
        let largest = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let error = found.iter().zip(&expected).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max);
        // What the light bodies' own weights round off, about the thinnest axis.
        let allowed = 32.0 * f64::EPSILON / inertia[2];
        assert!(error < allowed.max(1e-9), "seed {seed}: {error:.1e}\n{text}");
        worst[decade] = worst[decade].max(error);
    }
    println!("largest errors at 1e6, 1e8, 1e9 and 1e10: {}", worst.map(|error| format!("{error:.1e}")).join(", "));
}
