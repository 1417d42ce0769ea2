//! What hinges pass on.

use super::applied;
use super::evaluated::Balanced;
use crate::spatial::Wrench;
use nalgebra::Vector3;

impl Balanced<'_> {
    /// What the hinge passes to each named body at its root marker.
    ///
    /// ```
    /// use stillpoint::dynamics::System;
    /// use stillpoint::model::Model;
    /// use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
    ///
    /// // A bob on a string of 2 m that swings through its lowest point at 3 m/s.
    /// let hinge = HingeDescription::revolute([0.0, 1.0, 0.0]);
    /// let bob = BodyDescription::new("bob", hinge).mass(0.5).center([0.0, 0.0, -2.0]);
    /// let model = Model::build(&Description::new("Bob").body(bob)).expect("a sound scene");
    /// let mut system = System::new(&model);
    /// let (q, v) = ([0.0], [3.0 / 2.0]);
    /// let (mut a, mut unbalanced, mut reactions) = ([0.0], [0.0], Vec::new());
    /// let mut at = system.at(0.0, &q, &v);
    /// at.accelerations(&mut a)?;
    /// at.residual(&a, &mut unbalanced)?.reactions(&mut reactions);
    /// // m g + m v² / l
    /// assert!((reactions[0].force.z - 0.5 * (9.80665 + 9.0 / 2.0)).abs() < 1e-12);
    /// assert!(a[0].abs() < 1e-12 && unbalanced[0].abs() < 1e-12);
    /// # Ok::<(), stillpoint::dynamics::Fault>(())
    /// ```
    pub fn reactions(&self, out: &mut Vec<Wrench>) {
        out.clear();
        out.resize(self.system.model.bodies.len(), Wrench::ZERO);
        for (index, body) in self.system.model.bodies.iter().enumerate() {
            if body.link != 0 && self.system.model.links[body.link].body == index {
                out[index] = self.system.balance.reactions[body.link];
            }
        }
        self.weld_reactions(out);
    }

    /// A weld carries what its body and all that hangs on it need.
    fn weld_reactions(&self, out: &mut [Wrench]) {
        let welded = |index: usize| {
            let body = &self.system.model.bodies[index];
            body.link == 0 || self.system.model.links[body.link].body != index
        };
        if !(0..out.len()).any(welded) {
            return;
        }
        // Children after parents is not promised by the order of names: go by depth.
        let mut depth = vec![0_usize; out.len()];
        for (index, slot) in depth.iter_mut().enumerate() {
            let mut above = self.system.model.bodies[index].parent;
            while let Some(parent) = above {
                *slot += 1;
                above = self.system.model.bodies[parent].parent;
            }
        }
        let mut order: Vec<usize> = (0..out.len()).collect();
        order.sort_by_key(|index| std::cmp::Reverse(depth[*index]));
        let mut carried = vec![Wrench::ZERO; out.len()];
        for index in order {
            if welded(index) {
                out[index] = carried[index] + self.body_wrench(index);
            }
            let body = &self.system.model.bodies[index];
            if let Some(parent) = body.parent {
                let rod = self.system.model.links[body.link].joint.rod().filter(|_| body.is_element);
                let (passed, at) = match rod {
                    // What a flexible element passes at its root.
                    Some(rod) => {
                        let root = &self.system.motion.rods[rod].stations[0].link;
                        (self.system.balance.rods[rod].forces[0], root.position)
                    }
                    None => (out[index], self.root_marker(index)),
                };
                carried[parent] += passed.shifted(at - self.root_marker(parent));
            }
        }
    }

    fn root_marker(&self, body: usize) -> Vector3<f64> {
        let body = &self.system.model.bodies[body];
        let link = &self.system.motion.links[body.link];
        link.position + link.turn * body.link_from_body.translation.vector
    }

    /// `M a + b − applied` of one named body at its own root marker.
    fn body_wrench(&self, index: usize) -> Wrench {
        let body = &self.system.model.bodies[index];
        let (link, a) = (&self.system.motion.links[body.link], &self.system.balance.accelerations[body.link]);
        let arm = link.turn * body.link_from_body.translation.vector;
        let turn = link.turn * body.link_from_body.rotation.to_rotation_matrix().matrix();
        let (w, dw, c) = (link.angular_velocity, a.angular, turn * body.mass.center);
        let at_center = a.linear + dw.cross(&(arm + c)) + w.cross(&w.cross(&(arm + c)));
        let inertia = turn * body.mass.inertia * turn.transpose();
        let force = body.mass.mass * (at_center - self.system.model.gravity);
        let moment = c.cross(&force) + inertia * dw + w.cross(&(inertia * w));
        let mut applied = applied::on_body(&self.system.laws, &self.system.motion, index);
        if let Some(constrained) = &self.system.constraints {
            applied += constrained.on_body(index);
        }
        Wrench { force, moment } - applied.shifted(-arm)
    }
}
