//! Roots of a number between two arguments.

/// Most evaluations.
const MOST: usize = 60;

/// Where a number passes zero between two arguments, by the Illinois rule (regula falsi in which an end that stays loses half of its
/// weight), with what was computed there.
///
/// `ends` are arguments with their values, of different signs. `of` gives the value at an argument and what belongs to it; if it has
/// none, the best so far is the answer. A value of at most `small` ends the search.
pub(in crate::statics) fn illinois<T>(
    ends: [(f64, f64); 2],
    small: f64,
    mut of: impl FnMut(f64) -> Option<(f64, T)>,
) -> Option<(f64, T)> {
    let [mut low, mut high] = ends;
    let mut best: Option<(f64, T, f64)> = None;
    for _ in 0..MOST {
        let mut s = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let (least, most) = (low.0.min(high.0), low.0.max(high.0));
        if !(s > least && s < most) {
            s = 0.5 * (low.0 + high.0);
        }
        let Some((value, found)) = of(s) else { break };
        if best.as_ref().is_none_or(|(_, _, least)| value.abs() <= *least) {
            best = Some((s, found, value.abs()));
        }
        if value.abs() <= small || most - least <= 4.0 * f64::EPSILON * most.abs() {
            break;
        }
        if value.signum() == high.1.signum() {
            high = (s, value);
            low.1 *= 0.5;
        } else {
            low = high;
            high = (s, value);
        }
    }
    best.map(|(s, found, _)| (s, found))
}
