//! Section forces of a beam by the balance of what is beyond the section.

use crate::dynamics::evaluated::Balanced;
use crate::element::{Rod, RodMotion, joined, quadrature};
use crate::force::Act;
use crate::model::beam::BeamElement;
use crate::spatial::Wrench;
use crate::transfer::flexible::RodBalance;
use nalgebra::{Vector3, Vector6};

impl Balanced<'_> {
    /// What a beam bears at a distance from its root (m).
    pub(crate) fn section(&self, beam: usize, s: f64) -> Vector6<f64> {
        let elements = &self.system.model.beams[beam].elements;
        let element = elements.iter().rev().find(|element| element.from <= s).or(elements.first());
        element.map_or(Vector6::zeros(), |element| self.section_of(element, s - element.from))
    }

    /// What an element bears at a distance from its root: what the tip bears and the loads on the way to it, interpolated
    /// between the stations by the polynomial through them. If its integral differs from the sum of the stations at the root, the
    /// difference is shared out along the element: at both ends it bears what the balance says.
    pub(super) fn section_of(&self, element: &BeamElement, s: f64) -> Vector6<f64> {
        let system = self.system;
        let (rod, at) = (&system.model.rods[element.rod], &system.motion.rods[element.rod]);
        let (felt, gravity) = (&system.balance.rods[element.rod], &system.model.gravity);
        let (last, root) = (rod.steps(), &at.stations[0].link);
        let place = |s: f64| {
            let (turn, place) = rod.pose_at(s, &at.q);
            (root.turn * turn, root.turn * place)
        };
        let per_length = |k: usize| needed(rod, at, felt, k, gravity).times(1.0 / rod.slices[k].length);
        let of_stations: Vec<Wrench> = (0..=last).map(per_length).collect();
        let part = |k: usize, s: f64| {
            let others = (0..=last).filter(|j| *j != k);
            others.map(|j| (s - rod.slices[j].at) / (rod.slices[k].at - rod.slices[j].at)).product::<f64>()
        };
        // The slice at the tip belongs to the link there.
        let mut end = felt.forces[last];
        end.add_times(-1.0, &needed(rod, at, felt, last, gravity));
        let beyond = |s: f64| {
            let here = place(s).1;
            let mut sum = end.shifted(place(rod.length).1 - here);
            for (node, weight) in quadrature() {
                let there = s + node * (rod.length - s);
                let mut load = Wrench::ZERO;
                of_stations.iter().enumerate().for_each(|(k, own)| load.add_times(part(k, there), own));
                sum.add_times(weight * (rod.length - s), &load.shifted(place(there).1 - here));
            }
            sum
        };
        let mut missed = felt.forces[0] + needed(rod, at, felt, 0, gravity);
        missed.add_times(-1.0, &beyond(0.0));
        let (mut sum, turn) = (beyond(s), place(s).0);
        sum.add_times(1.0 - s / rod.length, &missed);
        // What is put on both ends in place of a load between them: beyond the load nothing, before it all of it.
        let links = &system.motion.links;
        for load in system.laws.forces.iter().filter_map(|force| force.law.within(element.link, links)) {
            let from = |link: usize| links[link].position - root.position - place(s).1;
            match s < load.at {
                true => sum.add_times(-1.0, &load.on[0].shifted(from(load.root))),
                false => sum.add_times(1.0, &load.on[1].shifted(from(element.link))),
            }
        }
        -joined(&turn.tr_mul(&sum.force), &turn.tr_mul(&sum.moment))
    }
}

/// What a slice needs: its inertia with its weight, less the load on it.
fn needed(rod: &Rod, at: &RodMotion, felt: &RodBalance, k: usize, gravity: &Vector3<f64>) -> Wrench {
    let (slice, link, a) = (&rod.slices[k], &at.stations[k].link, &felt.accelerations[k]);
    let w = link.angular_velocity;
    Wrench {
        force: slice.mass * (a.linear - gravity) - rod.load_at(k, &link.turn),
        moment: link.inertia * a.angular + w.cross(&(link.inertia * w)),
    }
}
