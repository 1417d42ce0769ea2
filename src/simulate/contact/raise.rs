//! What has sunk is raised: positions are moved apart behind a captured step, velocities are not.
//!
//! ```text
//! (4)  min ½ dᵀ M d,   J_n d ≥ −0.2 g   where g < 0,   J_n d ≥ −g   of what is near and of rigid stops
//! ```
//!
//! In (2) of [`super::capture`] the same would be asked of velocities: bodies that are jammed have none that part all of them, and forces grew
//! without end. Here the sweeps end where they do: what is left is raised behind the next step.

use super::blocks::Blocks;
use crate::contact::cone::{Law, Problem};
use crate::contact::frame::Frame;
use crate::contact::hinges::{self, Id, Support};
use crate::dynamics::{Fault, System};
use crate::simulate::problem::Equations;
use nalgebra::Vector3;

/// What has sunk by less than this part of a shape's size stays, and what has by more rises by that part of it behind a step.
const SHALLOW: f64 = 1e-4;
const RISES: f64 = 0.2;
/// What is put to rest rises by all of it, down to this part of a shape's size or as far as so many rounds take it.
const NONE: f64 = 1e-9;
const MOST_ROUNDS: usize = 30;
/// What may be missing of that, in parts of it, and sweeps for it.
const NEARLY: f64 = 0.05;
const MOST_SWEEPS: usize = 60;
/// Where what is moved apart pushes something else deeper than anything was, it is moved half as far, so many times at most.
const HALVINGS: usize = 6;
/// What is nearer than so many times what has sunk deepest is not pushed into.
const NEAR: f64 = 2.0;

impl Equations {
    /// Moves apart what has sunk at the end of a step; returns how deep anything still is, in parts of its size.
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    pub(super) fn raise(&mut self, time: f64, position: &mut [f64], velocity: &[f64]) -> Result<f64, Fault> {
        self.part(time, position, velocity, [SHALLOW, RISES])
    }

    /// Moves apart all that has sunk where a scene is put to rest.
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    pub(in crate::simulate) fn raise_to_rest(
        &mut self,
        time: f64,
        position: &mut [f64],
        velocity: &[f64],
    ) -> Result<(), Fault> {
        for _ in 0..MOST_ROUNDS {
            if self.part(time, position, velocity, [NONE, 1.0])? <= NONE {
                break;
            }
        }
        Ok(())
    }

    fn part(
        &mut self,
        time: f64,
        position: &mut [f64],
        velocity: &[f64],
        [shallow, rises]: [f64; 2],
    ) -> Result<f64, Fault> {
        let Self { contacts: Some(contacts), system, .. } = self else { return Ok(0.0) };
        system.at(time, position, velocity);
        let depth = contacts.depth(system);
        if depth <= shallow {
            return Ok(depth);
        }
        let mut change = vec![0.0; velocity.len()];
        let mut mass = system.at_without_contact(time, position, velocity).into_accelerations(&mut change)?;
        let frames = contacts.sunk_ahead(mass.motion());
        let deepest = frames.iter().map(|frame| -frame.meeting.gap).fold(0.0, f64::max);
        let mut supports: Vec<Support> = frames
            .iter()
            .map(|frame| Support {
                id: Id::Contact(frame.key),
                columns: frame.columns.clone(),
                gap: frame.meeting.gap,
                law: Law::Coulomb { stick: 0.0, slide: 0.0 },
                at_rest: None,
            })
            .collect();
        // Rigid stops keep hinges from being moved beyond them.
        let stops = hinges::supports(&contacts.model, position, velocity, 0.0).into_iter();
        supports.extend(stops.filter(|support| matches!(support.id, Id::Stop(_))));
        let blocks = Blocks::new(contacts, &mut mass, &supports);
        let way = |support: &Support| if support.gap < 0.0 { rises * support.gap } else { support.gap };
        let problem = Problem {
            blocks: blocks.matrix(),
            rates: supports.iter().map(|support| Vector3::x() * way(support)).collect(),
            laws: supports.iter().map(|support| support.law).collect(),
        };
        let guess = vec![Vector3::zeros(); supports.len()];
        let swept = problem.sweep_to(&guess, NEARLY * rises * deepest, MOST_SWEEPS);
        change.fill(0.0);
        blocks.push(&swept.forces, &mut change);
        for _ in 0..HALVINGS {
            let mut parted = position.to_vec();
            System::displace(&contacts.model, &mut parted, &change);
            if !contacts.model.stops.is_empty() {
                let mut scratch = vec![0.0; velocity.len()];
                let mut mass = system.at_without_contact(time, position, velocity).into_accelerations(&mut scratch)?;
                hinges::within_limits(&mut mass, &mut parted);
            }
            system.at(time, &parted, velocity);
            let now = contacts.depth(system);
            if now <= depth {
                position.copy_from_slice(&parted);
                return Ok(now);
            }
            change.iter_mut().for_each(|x| *x *= 0.5);
        }
        Ok(depth)
    }
}

impl super::Contacts {
    /// Frames of all contacts that are nearer than what has sunk deepest.
    fn sunk_ahead(&mut self, motion: &crate::motion::Motion) -> Vec<Frame> {
        self.pairs.place(motion);
        let still = vec![0.0; self.pairs.pieces.len()];
        let deepest = self.pairs.near(&still).into_iter().map(|couple| self.pairs.depth(couple)).fold(0.0, f64::max);
        let far = NEAR * deepest;
        let margins = vec![far; self.pairs.pieces.len()];
        self.within(motion, &margins, |_| far)
    }
}
