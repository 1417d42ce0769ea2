//! What the part of a beam beyond a section exerts on the part before it.

use super::question::{At, Measure};
use crate::model::output::SectionQuantity;

impl Measure for SectionQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        let all = at.balanced.section(self.beam, self.s);
        match self.component {
            Some(Self::STRESS) => {
                let section = at.balanced.system().model().beams[self.beam].section_at(self.s);
                out[0] = section.stress(&all).map_or(f64::NAN, |stress| stress.von_mises);
            }
            Some(index) => out[0] = all[index],
            None => out.copy_from_slice(all.as_slice()),
        }
    }
}
