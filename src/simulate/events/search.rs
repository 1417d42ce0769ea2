//! The first time at which a function of time has passed a level, between two times on both sides of it.

/// How a time is closed in on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::simulate) enum Root {
    /// Interpolate, truncate and project (Oliveira and Takahashi, *ACM Trans. Math. Softw.* 47, 2021): of functions that are smooth it takes a
    /// quarter of the calls of bisection, of no function more than a few beyond them.
    Itp,
    /// The Illinois variant of regula falsi (Dowell and Jarratt, *BIT* 11, 1971).
    Illinois,
}

/// How events are looked for, and how long steps are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulate) struct Search {
    /// Looks within a step, its end included.
    pub(in crate::simulate) looks: u32,
    /// Between two looks.
    pub(in crate::simulate) root: Root,
    /// Longest steps are this part of what they may be.
    pub(in crate::simulate) stride: f64,
    /// Captured steps are this part of what they may be, and differ from their halves by no more than the square of it.
    pub(in crate::simulate) captured: f64,
}

impl Search {
    /// That of a run.
    pub(in crate::simulate) const RUN: Self = Self { looks: 5, root: Root::Itp, stride: 1.0, captured: 1.0 };
    /// That of the run which checks another: it shares no time with the first, and no longest step. Multiples of the golden section
    /// are as far from whole numbers as can be.
    pub(in crate::simulate) const CHECK: Self =
        Self { looks: 13, root: Root::Illinois, stride: 0.618_033_988_749_894_8, captured: 0.125 };
}

impl Root {
    /// The end of an interval of at most `width`, within `interval`, at whose start `function` is ≤ 0 and at whose end it is
    /// above: there the event has happened. `ends` are its values at the ends of `interval`.
    ///
    /// # Errors
    /// The errors of the function.
    pub(in crate::simulate) fn locate<E>(
        self,
        interval: [f64; 2],
        ends: [f64; 2],
        width: f64,
        mut function: impl FnMut(f64) -> Result<f64, E>,
    ) -> Result<f64, E> {
        match self {
            Self::Itp => itp(interval, ends, width, &mut function),
            Self::Illinois => illinois(interval, ends, width, &mut function),
        }
    }
}

/// The part of the interval by which an interpolation is moved towards its middle, times its length in parts of the first.
const TRUNCATION: f64 = 0.2;
/// Calls beyond those of bisection.
const SLACK: f64 = 1.0;

fn itp<E>(
    [mut left, mut right]: [f64; 2],
    [mut below, mut above]: [f64; 2],
    width: f64,
    function: &mut impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let first = right - left;
    // Half the longest interval that bisection could still close in on from here.
    let mut reach = 0.5 * width * ((first / width).log2().ceil().max(0.0) + SLACK).exp2();
    while right - left > width {
        let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
        let secant = right - above * (right - left) / (above - below);
        let look = if secant.is_finite() {
            let (side, off) = ((middle - secant).signum(), (middle - secant).abs());
            let truncation = TRUNCATION * (right - left) * ((right - left) / first);
            let look = middle - side * (off - truncation).clamp(0.0, (reach - half).max(0.0));
            // Half the width inside, so that both ends close in.
            look.clamp(left + 0.5 * width, right - 0.5 * width)
        } else {
            middle
        };
        if !(look > left && look < right) {
            break;
        }
        let value = function(look)?;
        if value > 0.0 {
            (right, above) = (look, value);
        } else {
            (left, below) = (look, value);
        }
        reach *= 0.5;
    }
    Ok(right)
}

fn illinois<E>(
    [mut left, mut right]: [f64; 2],
    [mut below, mut above]: [f64; 2],
    width: f64,
    function: &mut impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let mut halve = false;
    while right - left > width {
        let middle = match halve || !(above - below).is_finite() {
            true => 0.5 * (left + right),
            // Half the width inside, so that both ends close in.
            false => {
                let secant = right - above * (right - left) / (above - below);
                secant.clamp(left + 0.5 * width, right - 0.5 * width)
            }
        };
        if !(middle > left && middle < right) {
            break;
        }
        let (value, before) = (function(middle)?, right - left);
        if value > 0.0 {
            (right, above, below) = (middle, value, 0.5 * below);
        } else {
            (left, below, above) = (middle, value, 0.5 * above);
        }
        halve = !halve && right - left > 0.5 * before;
    }
    Ok(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_end_just_behind_a_root_of_any_order() {
        for root in [Root::Itp, Root::Illinois] {
            for at in [1e-9, 0.3, 0.7, 1.0 - 1e-9] {
                for power in [1, 3, 7] {
                    let mut calls = 0;
                    let function = |t: f64| (t - at).powi(power);
                    let found = root.locate([0.0, 1.0], [function(0.0), function(1.0)], 1e-13, |t| {
                        calls += 1;
                        Ok::<f64, ()>(function(t))
                    });
                    let found = found.expect("no error");
                    // The powers of small numbers vanish.
                    let reach = 1e-12 + if power > 1 { 1e-40_f64.powf(1.0 / f64::from(power)) } else { 0.0 };
                    assert!((found - at).abs() <= reach, "{root:?} {at} {power}: {found}");
                    // Bisection takes 44; half a width at either end takes some more.
                    let most = if root == Root::Itp { 50 } else { 120 };
                    assert!(calls <= most, "{root:?} {at} {power}: {calls} calls");
                }
            }
        }
    }

    /// Of smooth functions it takes a fraction of the calls of bisection, of a jump no more than a few beyond them.
    #[test]
    fn interpolation_pays_and_never_costs() {
        let bend = |t: f64| (1.0 + t).ln() - 0.3 + 0.1 * (7.0 * t).sin();
        let drop = |t: f64| -0.5 * 9.81 * t * t + 3.0 * t * t.sqrt() - 0.1 + t;
        let jump = |t: f64| if t > 0.123_456 { 1e9 } else { -1e-9 };
        // Zero before it has passed, as what has been at rest.
        let rest = |t: f64| (t - 0.01).max(0.0).powi(2);
        for (function, most) in [(&bend as &dyn Fn(f64) -> f64, 10), (&drop, 10), (&jump, 50), (&rest, 50)] {
            let end = (1..100).map(|k| f64::from(k) / 100.0).find(|t| function(*t) > 0.0).expect("a change");
            let mut calls = 0;
            let found = Root::Itp.locate([0.0, end], [function(0.0), function(end)], 1e-13, |t| {
                calls += 1;
                Ok::<f64, ()>(function(t))
            });
            let found = found.expect("no error");
            assert!(function(found) > 0.0 && function(found - 1e-13) <= 0.0 && calls <= most, "{found}: {calls} calls");
        }
    }
}
