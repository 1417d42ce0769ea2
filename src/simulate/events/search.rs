//! The first time at which a function of time has passed a level, between two times on both sides of it.

/// How a time is closed in on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::simulate) enum Root {
    /// Halving.
    Bisection,
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
}

impl Search {
    /// That of a run.
    pub(in crate::simulate) const RUN: Self = Self { looks: 5, root: Root::Bisection, stride: 1.0 };
    /// That of the run which checks another: it shares no time with the first, and no longest step. Multiples of the golden section
    /// are as far from whole numbers as can be.
    pub(in crate::simulate) const CHECK: Self =
        Self { looks: 13, root: Root::Illinois, stride: 0.618_033_988_749_894_8 };
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
        let ([mut left, mut right], [mut below, mut above]) = (interval, ends);
        let mut halve = self == Self::Bisection;
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
            halve = self == Self::Bisection || (!halve && right - left > 0.5 * before);
        }
        Ok(right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_end_just_behind_a_root_of_any_order() {
        for root in [Root::Bisection, Root::Illinois] {
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
                    assert!(calls < 120, "{root:?} {at} {power}: {calls} calls");
                }
            }
        }
    }
}
