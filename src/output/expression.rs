//! A formula in the time and other outputs; its variation is by the chain rule.

use super::question::{At, Measure, Variation};
use crate::model::output::ExpressionQuantity;

impl Measure for ExpressionQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        out[0] = self.formula.value(at.values);
    }

    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        // What it does not use may be unknown.
        out[0] = self.formula.variation(at.values, by.values);
        out[0].is_finite()
    }
}
