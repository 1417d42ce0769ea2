//! What contacts push with at one instant of a run.

#[cfg(feature = "record")]
use super::Scene;
#[cfg(feature = "record")]
use std::collections::HashSet;
use std::sync::Arc;

/// One contact that bears.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPush {
    /// Names of both bodies.
    pub between: [String; 2],
    /// Where, inertial axes (m).
    pub point: [f64; 3],
    /// From the first body to the second, inertial axes.
    pub normal: [f64; 3],
    /// On the second body, inertial axes (N).
    pub force: [f64; 3],
    /// Whether what touches slips there; else it sticks or rolls.
    pub slips: bool,
}

/// Times of samples (s), and what contacts push with then: one and the same list where nothing has changed.
pub type ContactInstants = Vec<(f64, Arc<Vec<ContactPush>>)>;

#[cfg(feature = "record")]
impl ContactPush {
    /// The force that is drawn (N): on the second body, but on the first one if only that moves.
    pub(super) fn drawn(&self, still: &HashSet<String>) -> [f64; 3] {
        let [first, second] = [0, 1].map(|side| still.contains(&self.between[side]));
        if second && !first { self.force.map(|part| -part) } else { self.force }
    }
}

/// Names of the bodies that are fixed to the ground.
#[cfg(feature = "record")]
pub(super) fn still(scene: &Scene) -> HashSet<String> {
    let is_still = |mut body: usize| {
        while scene.bodies[body].hinge == "fixed" {
            match scene.bodies[body].parent {
                Some(parent) if parent < body => body = parent,
                Some(_) => return false,
                None => return true,
            }
        }
        false
    };
    (0..scene.bodies.len()).filter(|body| is_still(*body)).map(|body| scene.bodies[body].name.clone()).collect()
}

#[cfg(all(test, feature = "record"))]
mod tests {
    use super::*;

    #[test]
    fn the_force_on_what_moves_is_drawn() {
        let still = HashSet::from(["floor".to_owned(), "wall".to_owned()]);
        let drawn = |between: [&str; 2]| {
            let between = between.map(str::to_owned);
            let push = ContactPush {
                between,
                point: [0.0; 3],
                normal: [0.0, 0.0, 1.0],
                force: [1.0, -2.0, 3.0],
                slips: false,
            };
            push.drawn(&still)
        };
        assert_eq!(drawn(["foot", "floor"]), [-1.0, 2.0, -3.0]);
        for between in [["floor", "foot"], ["foot", "crate"], ["floor", "wall"]] {
            assert_eq!(drawn(between), [1.0, -2.0, 3.0]);
        }
    }
}
