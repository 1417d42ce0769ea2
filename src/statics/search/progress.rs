//! Whether a search down a potential gets anywhere.

/// Stagnation window: steps in which a search that neither falls by the part `PROGRESS` of its fall since the first window nor halves
/// its least residual makes no progress. Forty thousand such steps would gain less than a ten-thousandth. The fall in the first window
/// does not count: the stiff springs that it relaxes hold more energy than there is to gain in the valley after it.
const WINDOW: usize = 500;
const PROGRESS: f64 = 1e-6;

/// What the steps have gained since it was last asked.
pub(super) struct Progress {
    /// The potential when it was first asked.
    first: Option<f64>,
    last: f64,
    /// The least residual when it was last asked, and now.
    residual: f64,
    least: f64,
}

impl Progress {
    pub(super) fn new(potential: f64) -> Self {
        Self { first: None, last: potential, residual: f64::INFINITY, least: f64::INFINITY }
    }

    /// Whether a step, by its number, ends a window without progress at this potential and residual.
    pub(super) fn goes_on(&mut self, step: usize, potential: f64, residual: f64) -> bool {
        self.least = self.least.min(residual);
        if step % WINDOW != WINDOW - 1 {
            return true;
        }
        let first = *self.first.get_or_insert(potential);
        let fell = self.last - potential > PROGRESS * (first - potential);
        let halved = self.least < 0.5 * self.residual;
        (self.last, self.residual) = (potential, self.least);
        fell || halved
    }
}
