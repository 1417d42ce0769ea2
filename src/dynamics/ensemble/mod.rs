//! An ensemble: systems of one structure that differ in their numbers, evaluated side by side in the lanes of the registers.
//!
//! It gives what [`System`] gives for each of them, to round-off. A system in which a pivot has lost digits, or whose numbers are
//! not finite, is evaluated by itself, by the same code as any other.

mod acting;

use super::{Fault, System};
use crate::model::Model;
use crate::spatial::lanes::{Lanes, all};
use crate::transfer::lanes::{Sweep, Tree};
use acting::Acting;
use std::sync::Arc;

pub use crate::spatial::lanes::WIDTH;

/// Systems side by side. States and times come in from outside: of every number one for each system.
#[derive(Debug, Clone)]
pub struct Ensemble {
    tree: Tree,
    sweep: Sweep,
    acting: Acting,
    systems: LaneSystems,
}

/// The systems one by one, and scratch of one of them.
#[derive(Debug, Clone)]
struct LaneSystems {
    all: [System; WIDTH],
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

/// Where the systems are.
#[derive(Debug, Clone, Copy)]
struct Numbers<'a> {
    time: &'a [f64; WIDTH],
    q: &'a [[f64; WIDTH]],
    v: &'a [[f64; WIDTH]],
}

impl Ensemble {
    /// Whether systems of this model can be in an ensemble: rigid bodies on elementary hinges without loops, drives, gears, stops,
    /// contacts, dry friction, and without loads or masses that follow tables over time.
    pub fn covers(model: &Model) -> bool {
        let smooth = model.stops.is_empty() && model.hinge_friction.is_empty() && model.contacts.is_empty();
        let steady = model.burns.is_empty() && model.table_times().next().is_none() && model.stages.is_none();
        smooth && steady && model.rods.is_empty() && model.modals.is_empty() && !model.is_constrained()
    }

    /// Systems of these models; `None` if they are not [covered](Self::covers) or differ in more than numbers.
    pub fn new(models: &[Arc<Model>; WIDTH]) -> Option<Self> {
        if !models.iter().all(|model| Self::covers(model)) {
            return None;
        }
        let acting = Acting::new(models)?;
        let tree = Tree::new(models, acting.has_elements())?;
        let first = &models[0];
        let systems = LaneSystems {
            all: models.each_ref().map(System::new),
            q: first.start_position.clone(),
            v: first.start_velocity.clone(),
            a: first.start_velocity.clone(),
        };
        Some(Self { sweep: Sweep::new(&tree), tree, acting, systems })
    }

    /// The systems one by one.
    pub fn systems(&mut self) -> &mut [System; WIDTH] {
        &mut self.systems.all
    }

    /// `a ← q̈(t, q, v)` of every system, in O(n). The times (s) are each system's own; so are positions, velocities and
    /// accelerations, with one array per coordinate. Systems that are not `asked` may get any numbers.
    ///
    /// # Errors
    /// Of every system that cannot be evaluated the reason, as [`super::Evaluated::accelerations`] has it.
    ///
    /// # Panics
    /// If `q`, `v` or `a` have fewer entries than the models have positions or velocities.
    pub fn accelerations(
        &mut self,
        asked: &[bool; WIDTH],
        time: &[f64; WIDTH],
        (q, v): (&[[f64; WIDTH]], &[[f64; WIDTH]]),
        a: &mut [[f64; WIDTH]],
    ) -> Result<(), Box<[Option<Fault>; WIDTH]>> {
        let Self { tree, sweep, acting, systems } = self;
        let links = sweep.place(tree, q, v);
        acting.gather(systems, links, &Numbers { time, q, v });
        let good = sweep.accelerations(tree, &acting.applied, &acting.tau, a);
        // What is not finite makes 0 · a something else than 0.
        let finite = a.iter().fold(all(0.0), |sum, a| sum + all(0.0) * Lanes::new(*a)).simd_eq(all(0.0)).to_bitmask();
        let left = |lane: usize| asked[lane] && !(good[lane] && finite & (1 << lane) != 0);
        if !(0..WIDTH).any(left) {
            return Ok(());
        }
        let faults = std::array::from_fn(|lane| match left(lane) {
            true => systems.alone(lane, &Numbers { time, q, v }, a).err(),
            false => None,
        });
        if faults.iter().all(Option::is_none) { Ok(()) } else { Err(Box::new(faults)) }
    }
}

impl LaneSystems {
    /// One system by itself.
    #[cold]
    fn alone(&mut self, lane: usize, place: &Numbers<'_>, a: &mut [[f64; WIDTH]]) -> Result<(), Fault> {
        self.q.iter_mut().zip(place.q).for_each(|(own, q)| *own = q[lane]);
        self.v.iter_mut().zip(place.v).for_each(|(own, v)| *own = v[lane]);
        self.all[lane].at(place.time[lane], &self.q, &self.v).accelerations(&mut self.a)?;
        a.iter_mut().zip(&self.a).for_each(|(a, own)| a[lane] = *own);
        Ok(())
    }
}
