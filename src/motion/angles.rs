//! Sines and cosines of all angles of turns and screws, as many at a time as a register has numbers.

use crate::model::Model;
use crate::spatial::lanes::{Lanes, WIDTH, all};

/// Angles beyond this are left to the standard library: the products of the number of quarter turns with the parts of π/2
/// are exact while it has no more than 20 bits.
const FAR: f64 = 1e6;
/// π/2 in three parts, of 33 bits each but the last.
const QUARTER: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
/// Of `(sin x − x)/x³` and `(cos x − 1 + x²/2)/x⁴` for `|x| ≤ π/4`, by powers of x² (fdlibm, Sun Microsystems 1993).
const SINE: [f64; 6] = [
    -0.166_666_666_666_666_32,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Where the angles are, and their sines and cosines.
#[derive(Debug, Clone)]
pub(super) struct Angles {
    /// Position coordinates that are angles, in the order of the links; filled up to groups.
    at: Vec<[u32; WIDTH]>,
    /// Sine and cosine of each.
    of: Vec<[f64; 2]>,
}

impl Angles {
    pub(super) fn new(model: &Model) -> Self {
        let angles = model.links.iter().filter(|link| link.joint.is_angle());
        let at: Vec<u32> = angles.map(|link| link.position as u32).collect();
        let group = |some: &[u32]| std::array::from_fn(|i| some[i.min(some.len() - 1)]);
        let at: Vec<[u32; WIDTH]> = at.chunks(WIDTH).map(group).collect();
        let of = vec![[0.0, 1.0]; WIDTH * at.len()];
        Self { at, of }
    }

    /// All of them anew.
    #[inline(always)]
    pub(super) fn update(&mut self, q: &[f64]) {
        for (at, of) in self.at.iter().zip(self.of.chunks_exact_mut(WIDTH)) {
            let (sines, cosines) = sine_and_cosine(Lanes::new(at.map(|at| q[at as usize])));
            let (sines, cosines) = (sines.to_array(), cosines.to_array());
            for i in 0..WIDTH {
                of[i] = [sines[i], cosines[i]];
            }
        }
    }

    /// Sine and cosine of every angle.
    #[inline(always)]
    pub(super) fn all(&self) -> &[[f64; 2]] {
        &self.of
    }
}

/// Sines and cosines of angles side by side.
#[inline(always)]
pub(crate) fn sine_and_cosine(angle: Lanes) -> (Lanes, Lanes) {
    if (angle.abs().simd_lt(all(FAR))).all() { near(angle) } else { far(angle) }
}

#[cold]
#[inline(never)]
fn far(angle: Lanes) -> (Lanes, Lanes) {
    let (mut sines, mut cosines) = ([0.0; WIDTH], [0.0; WIDTH]);
    for (i, angle) in angle.to_array().into_iter().enumerate() {
        (sines[i], cosines[i]) = angle.sin_cos();
    }
    (Lanes::new(sines), Lanes::new(cosines))
}

/// Within [`FAR`], to about half a unit in the last place: where a matrix that turns is not quite orthogonal, light bodies between
/// heavy ones feel it. Which quarter turn an angle is in is chosen without leaving the registers.
#[inline(always)]
fn near(angle: Lanes) -> (Lanes, Lanes) {
    let one = all(1.0);
    let series = |x2: Lanes, c: [f64; 6], from: usize| {
        c[from..].iter().rev().skip(1).fold(all(c[5]), |sum, c| sum.mul_add(x2, all(*c)))
    };
    // Less the nearest multiple of π/2: x + tail.
    let turns = (angle * all(std::f64::consts::FRAC_2_PI)).round_ties_even();
    let [first, second, third] = QUARTER.map(all);
    let rough = turns.mul_neg_add(first, angle);
    let taken = turns * second;
    let finer = rough - taken;
    let rest = turns.mul_sub(third, (rough - finer) - taken);
    let x = finer - rest;
    let tail = (finer - x) - rest;
    let (x2, half) = (x * x, all(0.5));
    let x3 = x2 * x;
    let odd = series(x2, SINE, 1);
    let sine = x - ((x2 * (half * tail - x3 * odd) - tail) - x3 * all(SINE[0]));
    let even = x2 * series(x2, COSINE, 0);
    let (halved, rounded) = (half * x2, one - half * x2);
    let cosine = rounded + (((one - rounded) - halved) + (x2 * even - x * tail));
    // 0 to 3
    let quarter = (turns * all(0.25)).floor().mul_neg_add(all(4.0), turns);
    let (beyond_one, beyond_two) = (quarter.simd_gt(half), quarter.simd_gt(all(1.5)));
    let beyond_three = quarter.simd_gt(all(2.5));
    let swap = beyond_one ^ beyond_two ^ beyond_three;
    let (negative, minus) = (beyond_two, beyond_one ^ beyond_three);
    let sign = all(-0.0);
    (swap.select(cosine, sine) ^ (negative & sign), swap.select(sine, cosine) ^ (minus & sign))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the standard library has them, to a unit in the last place, and exactly where it matters most.
    #[test]
    fn sines_and_cosines_are_right_to_the_last_digit() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let some = (0..4000).map(|i| (f64::from(i) * 0.618_033_988_749_894_9).fract() * 2.4e3 - 1.2e3);
        let angles: Vec<f64> = some.chain((-8..=8).map(|i| f64::from(i) * quarter)).chain([9.9e5, 1e-300]).collect();
        for angle in angles {
            let (sines, cosines) = sine_and_cosine(all(angle));
            let (sines, cosines) = (sines.to_array(), cosines.to_array());
            let (sine, cosine) = angle.sin_cos();
            assert!((sines[1] - sine).abs() <= f64::EPSILON * sine.abs(), "{angle}: {} {sine}", sines[1]);
            assert!((cosines[2] - cosine).abs() <= f64::EPSILON * cosine.abs(), "{angle}: {} {cosine}", cosines[2]);
        }
    }
}
