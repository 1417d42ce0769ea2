//! Sines and cosines of all angles of turns and screws, four at a time.

use crate::model::Model;
use wide::f64x4;

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
    /// Position coordinates that are angles, in the order of the links; filled up to fours.
    at: Vec<[u32; 4]>,
    /// Sine and cosine of each.
    of: Vec<[f64; 2]>,
}

impl Angles {
    pub(super) fn new(model: &Model) -> Self {
        let angles = model.links.iter().filter(|link| link.joint.is_angle());
        let at: Vec<u32> = angles.map(|link| link.position as u32).collect();
        let four = |some: &[u32]| std::array::from_fn(|i| some[i.min(some.len() - 1)]);
        let at: Vec<[u32; 4]> = at.chunks(4).map(four).collect();
        let of = vec![[0.0, 1.0]; 4 * at.len()];
        Self { at, of }
    }

    /// All of them anew.
    #[inline(always)]
    pub(super) fn update(&mut self, q: &[f64]) {
        for (at, of) in self.at.iter().zip(self.of.chunks_exact_mut(4)) {
            let angles = at.map(|at| q[at as usize]);
            if angles.iter().all(|angle| angle.abs() < FAR) {
                let (sines, cosines) = sines_cosines(f64x4::new(angles));
                for i in 0..4 {
                    of[i] = [sines[i], cosines[i]];
                }
            } else {
                for i in 0..4 {
                    of[i] = angles[i].sin_cos().into();
                }
            }
        }
    }

    /// Sine and cosine of every angle.
    #[inline(always)]
    pub(super) fn all(&self) -> &[[f64; 2]] {
        &self.of
    }
}

/// Sines and cosines of four angles within [`FAR`], to about half a unit in the last place: where a matrix that turns is
/// not quite orthogonal, light bodies between heavy ones feel it.
#[inline(always)]
fn sines_cosines(angles: f64x4) -> ([f64; 4], [f64; 4]) {
    let one = f64x4::splat(1.0);
    let series = |x2: f64x4, c: [f64; 6], from: usize| {
        c[from..].iter().rev().skip(1).fold(f64x4::splat(c[5]), |sum, c| sum.mul_add(x2, f64x4::splat(*c)))
    };
    // Less the nearest multiple of π/2: x + tail.
    let turns = (angles * f64x4::splat(std::f64::consts::FRAC_2_PI)).round_ties_even();
    let [first, second, third] = QUARTER.map(f64x4::splat);
    let rough = turns.mul_neg_add(first, angles);
    let taken = turns * second;
    let finer = rough - taken;
    let rest = turns.mul_sub(third, (rough - finer) - taken);
    let x = finer - rest;
    let tail = (finer - x) - rest;
    let (x2, half) = (x * x, f64x4::splat(0.5));
    let x3 = x2 * x;
    let odd = series(x2, SINE, 1);
    let sine = x - ((x2 * (half * tail - x3 * odd) - tail) - x3 * f64x4::splat(SINE[0]));
    let even = x2 * series(x2, COSINE, 0);
    let (halved, rounded) = (half * x2, one - half * x2);
    let cosine = rounded + (((one - rounded) - halved) + (x2 * even - x * tail));
    let (mut sines, mut cosines) = (sine.to_array(), cosine.to_array());
    let turns = turns.to_array();
    for i in 0..4 {
        let (s, c) = (sines[i], cosines[i]);
        (sines[i], cosines[i]) = match turns[i] as i64 & 3 {
            0 => (s, c),
            1 => (c, -s),
            2 => (-s, -c),
            _ => (-c, s),
        };
    }
    (sines, cosines)
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
            let (sines, cosines) = sines_cosines(f64x4::splat(angle));
            let (sine, cosine) = angle.sin_cos();
            assert!((sines[1] - sine).abs() <= f64::EPSILON * sine.abs(), "{angle}: {} {sine}", sines[1]);
            assert!((cosines[2] - cosine).abs() <= f64::EPSILON * cosine.abs(), "{angle}: {} {cosine}", cosines[2]);
        }
    }
}
