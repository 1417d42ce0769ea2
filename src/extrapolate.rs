//! Derivatives of smooth functions by differences, extrapolated to distance zero (Ridders, 1982).
//!
//! ```text
//! (1)  D(h) = (y(h) − y(−h)) / 2h = y' + c₂h² + c₄h⁴ + …        D₀ₖ = D(h₀ rᵏ)
//! (2)  Dⱼₖ = (Dⱼ₋₁,ₖ − r²ʲ Dⱼ₋₁,ₖ₋₁) / (1 − r²ʲ)                 error: how far Dⱼₖ is from both of them
//! (3)  (y(h) − 2y(0) + y(−h)) / h → 0 with h, unless y has a kink at 0
//! ```
//!
//! Of what is affine the first extrapolation is exact up to round-off, over any distance: `h₀` is large. Round-off grows as distances
//! shrink: differences end when they are as exact as it lets them be. At the end of what is
//! allowed there is one side only; (1) then has all powers of `h`, and (2) `rʲ`.
//!
//! Beyond a switch on either side it may be another branch that is extrapolated to 0: a difference over a small part of the last distance has to
//! agree with what is found.

/// Distances that are tried, at most.
const LEVELS: usize = 9;
/// `r`.
const SHRINK: f64 = 0.25;
/// An error below this part of a derivative's size is small enough to stop.
const FINE: f64 = 1e-10;
/// An error below so many times the round-off of values over the largest distance is that of round-off: no distance is better.
const FLOOR: f64 = 8.0;
/// Where the error is below this part of a derivative's size, and a shorter distance does not halve it, round-off has begun.
const SETTLED: f64 = 1e-8;
/// So many shorter distances, one after the other, that do not halve the error of anything: what is left is round-off, however large the
/// caller takes that to be.
const STALLS: usize = 2;
/// (3) stays above this part of itself at a kink; elsewhere it falls with `r`.
const STAYS: f64 = 0.5;
/// A kink by less than this part of a derivative's size is round-off; so many times as large as that over the largest distance it is clear.
const KINK: f64 = 1e-6;
const CLEAR: f64 = 100.0;
/// The difference over this part of the last distance is alike to this part of it, or the branch is another one. What it has of rounding is
/// how far apart it and those over these parts of its own distance are, so many times.
const CLOSE: f64 = 1e-4;
const ALIKE: f64 = 1e-2;
const CLOSER: [f64; 2] = [0.7, 0.5];
const SPREAD: f64 = 10.0;

/// A derivative, component by component.
#[derive(Debug, Clone)]
pub struct Derivative {
    /// The extrapolated differences.
    pub value: Vec<f64>,
    /// How far the last extrapolations are apart; infinite of what is not known.
    pub error: Vec<f64>,
    /// Whether the function has a kink there: no derivative.
    pub kinks: Vec<bool>,
}

/// The extrapolations (2) of one kind of difference.
struct Tableau {
    /// `r²` or `r`.
    ratio: f64,
    /// The last row, all orders.
    row: Vec<Vec<f64>>,
    best: Derivative,
    /// Whether the last distance has halved the error of a component.
    is_better: bool,
    /// How many distances have not, one after the other.
    stalls: usize,
    /// (3) at the first distance, the least of it at all, and what round-off makes of it at the first distance.
    bends: Option<[Vec<f64>; 3]>,
}

impl Tableau {
    fn new(ratio: f64, count: usize) -> Self {
        let best = Derivative { value: vec![0.0; count], error: vec![f64::INFINITY; count], kinks: vec![false; count] };
        Self { ratio, row: Vec::new(), best, is_better: true, stalls: 0, bends: None }
    }

    /// Takes the difference at the next distance.
    fn push(&mut self, difference: Vec<f64>) {
        let before = self.best.error.clone();
        let mut row = vec![difference];
        let mut ratio = 1.0;
        for (j, before) in self.row.iter().enumerate() {
            ratio *= self.ratio;
            let next: Vec<f64> =
                row[j].iter().zip(before).map(|(new, old)| (new - ratio * old) / (1.0 - ratio)).collect();
            for (i, x) in next.iter().enumerate() {
                let error = (x - row[j][i]).abs().max((x - before[i]).abs());
                if error <= self.best.error[i] {
                    (self.best.value[i], self.best.error[i]) = (*x, error);
                }
            }
            row.push(next);
        }
        self.row = row;
        self.is_better = before.iter().zip(&self.best.error).any(|(before, now)| *now < 0.5 * before);
        // The first distance has no error yet.
        self.stalls = if self.is_better || self.row.len() < 2 { 0 } else { self.stalls + 1 };
    }

    /// Takes (3) at the next distance: of kinks it does not fall. `sizes` of derivatives.
    fn bend(&mut self, bends: Vec<f64>, round_off: impl Fn(usize) -> f64, sizes: &[f64]) {
        let less = |i: usize| (bends[i] - round_off(i)).max(0.0);
        let Some([first, least, hidden]) = &mut self.bends else {
            let seen: Vec<f64> = (0..bends.len()).map(less).collect();
            self.bends = Some([seen.clone(), seen, (0..bends.len()).map(round_off).collect()]);
            return;
        };
        for (i, bend) in bends.iter().enumerate() {
            // Of what was clearly seen round-off may hide all later.
            let is_hidden = round_off(i) > STAYS * first[i] && first[i] > CLEAR * hidden[i];
            least[i] = least[i].min(if is_hidden { *bend } else { less(i) });
            let size = sizes[i].max(self.best.value[i].abs());
            // Over short distances it is round-off that grows again.
            self.best.kinks[i] = least[i] > STAYS * first[i] && least[i] > KINK * size;
        }
    }

    /// Whether it has errors: of all components but those that are no numbers.
    fn is_known(&self) -> bool {
        self.row.len() > 1
    }

    /// Whether no distance is better; `floors` are errors that round-off makes over the largest.
    fn is_fine(&self, sizes: &[f64], floors: &[f64]) -> bool {
        if self.stalls >= STALLS {
            return true;
        }
        let size = |i: usize| sizes[i].max(self.best.value[i].abs());
        let part = if self.is_better { FINE } else { SETTLED };
        (0..sizes.len()).all(|i| self.best.error[i] <= (part * size(i)).max(floors[i]))
    }
}

/// The derivative at zero of a function whose value there is `center`; `first` is the largest distance, `sizes` how large the
/// derivatives may be taken to be, `noise` the round-off of values.
///
/// # Errors
/// Why the function has no values on either side.
pub fn derivative(
    of: &mut dyn FnMut(f64) -> Result<Vec<f64>, String>,
    center: &[f64],
    first: f64,
    (sizes, noise): (&[f64], &[f64]),
) -> Result<Derivative, String> {
    let mut last = first;
    let floors: Vec<f64> = noise.iter().map(|noise| FLOOR * noise / first).collect();
    let mut reason = None;
    let mut central = Tableau::new(SHRINK * SHRINK, center.len());
    let mut sides = [1.0, -1.0].map(|side| (side, Tableau::new(SHRINK, center.len())));
    for level in 0..LEVELS {
        let h = first * SHRINK.powi(level as i32);
        last = h;
        let [after, before] = [h, -h].map(&mut *of);
        if let (Ok(after), Ok(before)) = (&after, &before) {
            let both = || after.iter().zip(before);
            central.push(both().map(|(after, before)| (after - before) / (2.0 * h)).collect());
            let bends = both().zip(center).map(|((after, before), y)| (after - 2.0 * y + before).abs() / h);
            central.bend(bends.collect(), |i| FLOOR * noise[i] / h, sizes);
            if level > 0 && central.is_fine(sizes, &floors) {
                break;
            }
            continue;
        }
        for ((side, tableau), y) in sides.iter_mut().zip([after, before]) {
            match y {
                Ok(y) => tableau.push(y.iter().zip(center).map(|(y, center)| (y - center) / (*side * h)).collect()),
                Err(why) => reason = Some(why),
            }
            if tableau.row.len() > 1 && tableau.is_fine(sizes, &floors) {
                let known = sides.into_iter().map(|(_, tableau)| tableau).find(Tableau::is_known);
                return Ok(known.unwrap_or(central).best);
            }
        }
    }
    if central.is_known() {
        let mut best = central.best;
        doubt(&mut best, of, CLOSE * last, (sizes, noise));
        return Ok(best);
    }
    let [(_, after), (_, before)] = sides;
    let found = [after, before].into_iter().find(Tableau::is_known);
    found.map(|known| known.best).ok_or_else(|| reason.unwrap_or_else(|| "it cannot be changed".to_owned()))
}

/// Takes for unknown what differences over this distance do not agree with.
fn doubt(
    found: &mut Derivative,
    of: &mut dyn FnMut(f64) -> Result<Vec<f64>, String>,
    h: f64,
    (sizes, noise): (&[f64], &[f64]),
) {
    let mut over = |h: f64| -> Option<Vec<f64>> {
        let [after, before] = [of(h).ok()?, of(-h).ok()?];
        Some(after.iter().zip(&before).map(|(after, before)| (after - before) / (2.0 * h)).collect())
    };
    let Some(close) = over(h) else { return };
    let off = |i: usize, rounding: f64| {
        let (x, other) = (found.value[i], close[i]);
        let allowed = ALIKE * x.abs().max(other.abs()) + KINK * sizes[i] + FLOOR * noise[i] / h + rounding;
        found.error[i].is_finite() && !((x - other).abs() <= allowed)
    };
    let suspects: Vec<usize> = (0..sizes.len()).filter(|i| off(*i, 0.0)).collect();
    if suspects.is_empty() {
        return;
    }
    let closer: Vec<Vec<f64>> = CLOSER.iter().filter_map(|part| over(part * h)).collect();
    let rounding = |i: usize| closer.iter().map(|closer| (closer[i] - close[i]).abs()).fold(0.0, f64::max);
    let wrong: Vec<usize> = suspects.into_iter().filter(|i| off(*i, SPREAD * rounding(*i))).collect();
    wrong.into_iter().for_each(|i| found.error[i] = f64::INFINITY);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(y: impl Fn(f64) -> Option<f64>) -> Result<Derivative, String> {
        let center = [y(0.0).expect("a value")];
        derivative(&mut |h| y(h).map(|y| vec![y]).ok_or_else(|| "no".to_owned()), &center, 0.5, (&[1.0], &[1e-16]))
    }

    #[test]
    fn smooth_functions_are_differentiated_to_round_off() {
        for k in 1..20 {
            let k = f64::from(k);
            let found = of(|h| Some((k * h).sin() + (0.3 * h).exp())).expect("a derivative");
            assert!((found.value[0] - k - 0.3).abs() < 1e-10 * k, "{k}: {found:?}");
            assert!(!found.kinks[0]);
        }
    }

    /// Round-off that is larger than it is said to be ends the differences as soon as it shows.
    #[test]
    fn differences_end_when_they_stall() {
        let mut asked = 0;
        let rough = |h: f64| (1.0 + h).sqrt() + 1e-9 * (1e7 * h).sin();
        let mut of = |h: f64| {
            asked += 1;
            Ok(vec![rough(h)])
        };
        let found = derivative(&mut of, &[1.0], 0.1, (&[1.0], &[1e-16])).expect("a derivative");
        assert!((found.value[0] - 0.5).abs() < 1e-6 && asked < 20, "{found:?} {asked}");
    }

    #[test]
    fn one_side_is_enough_at_the_end_of_what_is_allowed() {
        let found = of(|h| (h >= 0.0).then(|| (1.0 + h).sqrt())).expect("a derivative");
        assert!((found.value[0] - 0.5).abs() < 1e-9, "{found:?}");
        let beyond = of(|h| (h.abs() < 0.01).then(|| (1.0 + h).powi(3))).expect("a derivative");
        assert!((beyond.value[0] - 3.0).abs() < 1e-9, "{beyond:?}");
        assert_eq!(of(|h| (h == 0.0).then_some(1.0)).err(), Some("no".to_owned()));
    }

    /// One component that is no number on one side leaves the others theirs.
    #[test]
    fn components_are_known_by_themselves() {
        let mut of = |h: f64| Ok(vec![h.sqrt(), 3.0 * h]);
        let found = derivative(&mut of, &[0.0, 0.0], 0.1, (&[1.0, 1.0], &[1e-16, 1e-16])).expect("a derivative");
        assert!(found.error[0].is_infinite() && (found.value[1] - 3.0).abs() < 1e-12, "{found:?}");
    }

    /// Two switches, one on either side, have the same slope beyond: that is not the one between them.
    #[test]
    fn another_branch_is_not_taken_for_this_one() {
        let unheard = |x: f64| if x.abs() > 1e-4 { x } else { 0.0 };
        assert!(of(|h| Some(unheard(h))).expect("differences").error[0].is_infinite());
        let near = derivative(&mut |h| Ok(vec![unheard(h)]), &[0.0], 5e-5, (&[1.0], &[1e-16])).expect("a derivative");
        assert!(near.value[0].abs() < 1e-12 && near.error[0] < 1e-12, "{near:?}");
        // Rounding that is larger than it is said to be is none.
        let rough = of(|h| Some((1.0 + h).sqrt() + 1e-7 * (1e9 * h).sin())).expect("a derivative");
        assert!(rough.error[0].is_finite(), "{rough:?}");
    }

    #[test]
    fn kinks_have_no_derivative() {
        assert!(of(|h| Some(h.abs() + h)).expect("differences").kinks[0]);
        assert!(of(|h| Some((2.0 * h).max(h.sin()))).expect("differences").kinks[0]);
        assert!(!of(|h| Some(h.abs() * h)).expect("differences").kinks[0]);
        // Over distances at which round-off hides most of it, too.
        let near = derivative(&mut |h| Ok(vec![h.abs()]), &[0.0], 1e-10, (&[1.0], &[1e-12])).expect("differences");
        assert!(near.kinks[0]);
    }
}
