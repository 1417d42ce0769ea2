//! Distance of two points: `d = |x_b − x_a|`, `δd = u·(δx_b − δx_a)`.

use super::question::{At, Measure, Variation};
use crate::force::end::Anchor;
use crate::model::output::DistanceQuantity;

impl Measure for DistanceQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        let [a, b] = self.ends.map(|end| Anchor::of(&end, &at.balanced.motion().links));
        out[0] = (b.position - a.position).norm();
    }

    /// Without a direction there is none.
    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        let links = &at.balanced.motion().links;
        let anchors = self.ends.map(|end| Anchor::of(&end, links));
        let between = anchors[1].position - anchors[0].position;
        let [a, b] = [0, 1].map(|i| {
            let link = self.ends[i].link;
            anchors[i].vary(&links[link], &by.links[link]).position
        });
        let length = between.norm();
        out[0] = between.dot(&(b - a)) / length;
        length > 0.0
    }
}
