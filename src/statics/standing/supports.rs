//! The supports of a pose and what they have to bear: eq. (1) of the module.

use super::closed::Scene;
use crate::contact::frame::column_of;
use crate::contact::support::{self, Cone, RimSupport, Supports, Undecided};
use crate::dynamics::{Fault, System};
use crate::model::{Model, Side};
use crate::round_off::BORNE;
use nalgebra::Vector3;
use std::sync::Arc;

/// A coordinate this near to a limit touches it: part of the scene's length, or rad.
const TOUCHES: f64 = 1e-9;
/// A load of strains of beams below this part is: they are known to the balance that they have settled to.
const SETTLED: f64 = 1e-11;

/// Forces of supports balance bodies before they balance strains, which are only that near to their balance: what is left of
/// strains counts by its square over the square of this.
const COARSE: f64 = 30.0;

/// What a support is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Bears {
    /// Index into the contacts of the scene.
    Contact(usize),
    /// Dry friction of a hinge, from this velocity coordinate on.
    Friction { velocity: usize },
    /// A side of a rigid stop that is touched.
    Stop { velocity: usize, side: Side },
    /// A loop, drive, gear or lock.
    Other,
}

/// All supports of a pose and the load on them.
pub(super) struct Bearers {
    pub(super) supports: Supports,
    /// What each support is.
    pub(super) list: Vec<Bears>,
    /// `f(q)` (N, N m).
    pub(super) load: Vec<f64>,
    /// Velocity coordinates that supports push.
    pub(super) pushed: Vec<bool>,
}

impl Bearers {
    pub(super) fn new(model: &Arc<Model>, pose: &[f64], scene: &Scene) -> Result<Self, Fault> {
        let length = model.length_scale();
        let units: Vec<f64> = units(model);
        let pushed = vec![false; model.velocity_count()];
        let (load, terms) = borne(model, pose)?;
        let (supports, list) = (Supports::new(units.clone()).with_terms(terms), Vec::new());
        let mut bearers = Self { supports, list, load, pushed };
        for (k, contact) in scene.contacts.iter().enumerate() {
            let ends = contact.bodies.map(|body| model.bodies[body].link);
            let column = |along: &Vector3<f64>| column_of(model, &scene.motion, ends, &contact.point, along);
            let frame = contact.frame();
            let friction = contact.friction.stick;
            match friction > 0.0 {
                true => {
                    bearers.add(Bears::Contact(k), Cone::Coulomb { friction }, 1.0, frame.iter().map(column).collect())
                }
                false => bearers.add(Bears::Contact(k), Cone::Ray, 1.0, vec![column(&frame[0])]),
            }
        }
        for (rim, contact, known) in &scene.rims {
            let ends = contact.bodies.map(|body| model.bodies[body].link);
            let at = |point: &Vector3<f64>| {
                contact.frame().map(|along| column_of(model, &scene.motion, ends, point, &along))
            };
            let middle = at(&rim.middle);
            let beyond = |arm: &Vector3<f64>| {
                let columns = at(&(rim.middle + arm));
                std::array::from_fn(|k| {
                    columns[k].iter().copied().chain(middle[k].iter().map(|(row, x)| (*row, -x))).collect()
                })
            };
            let columns = [middle.clone(), beyond(&rim.arms[0]), beyond(&rim.arms[1])];
            // Contacts are the first supports.
            let nearest = |angle: &f64| {
                let off = |k: &usize| (scene.contacts[*k].point - rim.at(*angle)).norm();
                let own = (0..scene.contacts.len()).filter(|k| scene.contacts[*k].bodies == contact.bodies);
                own.min_by(|a, b| off(a).total_cmp(&off(b))).map(|support| (*angle, support))
            };
            let (friction, arcs) = (contact.friction.stick, rim.arcs.clone());
            let known = known.iter().filter_map(nearest).collect();
            bearers.supports.add_rim(RimSupport { friction, columns, arcs, known });
        }
        for friction in &model.hinge_friction {
            let (velocity, count) = (friction.velocity, friction.count);
            if model.coordinates[velocity].lock {
                continue;
            }
            let cone = Cone::Ball { bound: friction.friction.stick, size: count };
            let columns = (velocity..velocity + count).map(|i| vec![(i, 1.0)]).collect();
            bearers.add(Bears::Friction { velocity }, cone, units[velocity], columns);
        }
        for stop in model.stops.iter().filter(|stop| stop.is_rigid()) {
            let (at, near) = (pose[stop.position], TOUCHES * if units[stop.velocity] == 1.0 { length } else { 1.0 });
            for side in Side::ALL {
                if (at - stop.limit(side)).abs() <= near {
                    let velocity = stop.velocity;
                    bearers.add(
                        Bears::Stop { velocity, side },
                        Cone::Ray,
                        units[velocity],
                        vec![vec![(velocity, -side.sign())]],
                    );
                }
            }
        }
        for (velocity, _) in model.coordinates.iter().enumerate().filter(|(_, coordinate)| coordinate.lock) {
            bearers.add(Bears::Other, Cone::Free, units[velocity], vec![vec![(velocity, 1.0)]]);
        }
        for column in tied(model, pose) {
            bearers.add(Bears::Other, Cone::Free, 1.0, vec![column]);
        }
        Ok(bearers)
    }

    /// Whether they hold the load. Points of rims that this depends on become contacts of the scene.
    pub(super) fn judge(&mut self, scene: &mut Scene) -> Result<support::Standing, Undecided> {
        let found = self.supports.standing(&self.load)?;
        let known = scene.contacts.len();
        scene.extend(self.supports.added());
        self.list.extend((known..scene.contacts.len()).map(Bears::Contact));
        Ok(found)
    }

    /// How much of a direction of loads makes them as large again.
    pub(super) fn as_large_again(&self, direction: &[f64]) -> f64 {
        let size = |loads: &[f64]| {
            let parts = loads.iter().enumerate().map(|(row, load)| (load / self.supports.unit(row)).abs());
            parts.fold(0.0, f64::max)
        };
        let (loads, direction) = (size(&self.load), size(direction));
        if loads > 0.0 && direction > 0.0 { loads / direction } else { 1.0 }
    }

    /// What bears without friction that a squeeze alone may load; `None` if nothing can be squeezed.
    pub(super) fn unsqueezed(&self) -> Result<Option<Self>, Undecided> {
        let supports = self.supports.unsqueezed(&self.load)?;
        let (list, load, pushed) = (self.list.clone(), self.load.clone(), self.pushed.clone());
        Ok(supports.map(|supports| Self { supports, list, load, pushed }))
    }

    /// Adds a support that bears whatever it has to along a direction of the coordinates.
    pub(super) fn free(&mut self, direction: &[f64]) {
        let column = direction.iter().copied().enumerate().filter(|(_, entry)| *entry != 0.0).collect();
        self.add(Bears::Other, Cone::Free, 1.0, vec![column]);
    }

    fn add(&mut self, bears: Bears, cone: Cone, lever: f64, columns: Vec<Vec<(usize, f64)>>) {
        self.list.push(bears);
        // What pushes a coordinate by rounding alone, as a normal through the axis of a capsule turns it about that, does not.
        let pushes = |(row, entry): &&(usize, f64)| !BORNE.hides(*entry, self.supports.unit(*row));
        columns.iter().flatten().filter(pushes).for_each(|(row, _)| self.pushed[*row] = true);
        self.supports.add(cone, lever, columns);
    }
}

/// 1 for distances, the scene's length for turns (m), more for strains.
fn units(model: &Model) -> Vec<f64> {
    let mut units = vec![model.length_scale(); model.velocity_count()];
    for link in model.links.iter().skip(1).filter(|link| link.joint.is_distance()) {
        units[link.velocity] = 1.0;
    }
    for link in model.links.iter().filter(|link| link.joint.is_flex()) {
        units[link.velocity..link.velocity + link.joint.counts().1].iter_mut().for_each(|unit| *unit *= COARSE);
    }
    units
}

/// What supports have to bear: [`load`] without what is rounding of forces that cancel; and the sizes of these.
fn borne(model: &Arc<Model>, pose: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    let rest = vec![0.0; model.velocity_count()];
    let (mut system, mut residual) = (System::new(model), rest.clone());
    let sizes = system.at(0.0, pose, &rest).residual(&rest, &mut residual)?.magnitudes().force;
    let mut load = load(model, pose)?;
    let mut least: Vec<f64> = sizes.iter().map(|size| BORNE.of(*size)).collect();
    // A pose that is known to a part of the scene's length has moments of its forces at that part of it.
    let units = units(model);
    for own in hinges(model) {
        let largest = own.iter().fold(0.0, |most: f64, i| most.max(least[*i] / units[*i]));
        own.iter().for_each(|i| least[*i] = largest * units[*i]);
    }
    for link in model.links.iter().filter(|link| link.joint.is_flex()) {
        let own = link.velocity..link.velocity + link.joint.counts().1;
        let largest = sizes[own.clone()].iter().fold(0.0, |most: f64, size| most.max(*size));
        least[own].fill(SETTLED * largest);
    }
    load.iter_mut().zip(&least).filter(|(f, least)| f.abs() <= **least).for_each(|(f, _)| *f = 0.0);
    Ok((load, sizes))
}

/// The velocity coordinates of each hinge that does not bend.
fn hinges(model: &Model) -> Vec<Vec<usize>> {
    let mut of_body: Vec<Vec<usize>> = vec![Vec::new(); model.bodies.len()];
    for link in model.links.iter().skip(1).filter(|link| !link.joint.is_flex()) {
        of_body[link.body].extend(link.velocity..link.velocity + link.joint.counts().1);
    }
    of_body
}

/// What the balance of the coordinates lacks at rest (N, N m): gravity, springs, motors, loads.
pub(super) fn load(model: &Arc<Model>, pose: &[f64]) -> Result<Vec<f64>, Fault> {
    let rest = vec![0.0; model.velocity_count()];
    let (mut system, mut residual) = (System::new(model), rest.clone());
    system.at(0.0, pose, &rest).residual(&rest, &mut residual)?;
    for stop in &model.stops {
        residual[stop.velocity] += stop.pressed(pose).map_or(0.0, |[stiffness, depth]| stiffness * depth);
    }
    residual.iter_mut().for_each(|residual| *residual = -*residual);
    Ok(residual)
}

/// The columns of loops, drives and gears.
fn tied(model: &Arc<Model>, pose: &[f64]) -> Vec<Vec<(usize, f64)>> {
    if !model.is_constrained() {
        return Vec::new();
    }
    let rest = vec![0.0; model.velocity_count()];
    let matrix = System::new(model).at(0.0, pose, &rest).constraint_matrix();
    let row =
        |row: usize| (0..matrix.ncols()).map(|i| (i, matrix[(row, i)])).filter(|(_, entry)| *entry != 0.0).collect();
    (0..matrix.nrows()).map(row).collect()
}
