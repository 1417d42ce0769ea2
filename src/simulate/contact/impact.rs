//! Impacts: what bodies that approach each other do to their velocities.
//!
//! ```text
//! (1)  u⁺ = u⁻ + A λ,   K* ∋ (u⁺ + e u_n⁻ n) + μ |u_t⁺| n  ⊥  λ ∈ K(μ)      Newton's restitution, Coulomb's friction
//! (2)  ΔT = ½ λ·(u⁺ + u⁻) + work of drives
//! ```
//!
//! Impacts without restitution are one problem. With it two bodies after the other meet, those first that approach fastest, as in a
//! cradle: their points together, the others being as they are, until nothing approaches. By Kane's paradox (1) may gain
//! energy: then what comes back is the largest part of it that gains none, and the run says so.

use super::{Contacts, Trouble};
use crate::contact::cone::{Answer, Law, Problem};
use crate::contact::frame::{Frame, problem};
use crate::model::problem::rounded;
use nalgebra::Vector3;

/// Impacts one after the other at one instant; of more of them what is left is answered at once and without restitution if it is nearly nothing.
const MOST_IMPACTS: usize = 20_000;
/// Part of the first speed of approach that is nearly nothing.
const SPENT: f64 = 1e-6;
/// Forces that change by less in a sweep are found.
pub(super) const FOUND: f64 = 1e-13;
/// Sweeps of the cone problem.
pub(super) const MOST_SWEEPS: usize = 50_000;
/// How exactly the part of a restitution is found that gains no energy.
const NEARLY: f64 = 1e-9;
/// Energy that an impact may gain: this part of what moves.
const GAINED: f64 = 1e-12;

/// An impact that has been answered.
#[derive(Debug, Clone)]
pub(super) struct Impact {
    pub(super) couple: usize,
    /// Speed of approach (m/s), > 0.
    pub(super) speed: f64,
}

/// What impacts of an instant did.
#[derive(Debug, Default)]
pub(super) struct Impacts {
    pub(super) all: Vec<Impact>,
    /// Energy that they took out at the contacts (J).
    pub(super) lost: f64,
}

impl Contacts {
    /// Whether a contact approaches.
    pub(super) fn approaches(&self, frame: &Frame) -> bool {
        frame.speed.x < -self.rest
    }

    /// (1) at all of `frames`, whose `answers` are those of [`responses`](crate::contact::frame::responses): what becomes of the
    /// velocities `v`.
    ///
    /// # Errors
    /// A problem without a solution that can be certified.
    pub(super) fn strike(
        &mut self,
        frames: &[Frame],
        answers: &[[Vec<f64>; 3]],
        v: &mut [f64],
    ) -> Result<Impacts, Trouble> {
        let mut done = Impacts::default();
        let mut speeds: Vec<Vector3<f64>> = frames.iter().map(|frame| frame.speed).collect();
        let bounces = |frame: &Frame| self.law(frame.key.couple).law.restitution() > 0.0;
        let mut couples: Vec<usize> = frames.iter().map(|frame| frame.key.couple).collect();
        couples.dedup();
        let fastest = speeds.iter().map(|speed| -speed.x).fold(0.0, f64::max);
        let in_turn = couples.len() > 1 && frames.iter().any(|frame| self.approaches(frame) && bounces(frame));
        for impact in 0..=MOST_IMPACTS {
            let worst = (0..frames.len()).min_by(|a, b| speeds[*a].x.total_cmp(&speeds[*b].x));
            let Some(worst) = worst.filter(|worst| speeds[*worst].x < -self.rest) else { break };
            if impact == MOST_IMPACTS && speeds[worst].x < -SPENT * fastest {
                let why = format!(
                    "after {MOST_IMPACTS} impacts at one instant they still approach with {} m/s",
                    rounded(-speeds[worst].x)
                );
                return Err(Trouble::Undecided { between: self.between(frames[worst].key.couple), why });
            }
            let all = !in_turn || impact == MOST_IMPACTS;
            let taking: Vec<usize> =
                (0..frames.len()).filter(|i| all || frames[*i].key.couple == frames[worst].key.couple).collect();
            let part = if impact == MOST_IMPACTS { 0.0 } else { 1.0 };
            let found = self.strike_at(frames, answers, &speeds, &taking, part)?;
            let told = done.all.len();
            for i in taking.iter().filter(|i| speeds[**i].x < -self.rest) {
                let (couple, speed) = (frames[*i].key.couple, -speeds[*i].x);
                match done.all[told..].iter_mut().find(|impact| impact.couple == couple) {
                    Some(impact) => impact.speed = impact.speed.max(speed),
                    None => done.all.push(Impact { couple, speed }),
                }
            }
            let mut change = vec![0.0; v.len()];
            for (k, i) in taking.iter().enumerate() {
                for c in 0..3 {
                    change.iter_mut().zip(&answers[*i][c]).for_each(|(to, x)| *to += found.forces[k][c] * x);
                }
            }
            speeds.iter_mut().zip(frames).for_each(|(speed, frame)| *speed += frame.rates(&change));
            // (2) where the impulses act: a disc that lies down has the speed of another point of its rim.
            let mean: Vec<f64> = v.iter().zip(&change).map(|(v, change)| v + 0.5 * change).collect();
            let each = taking.iter().zip(&found.forces);
            done.lost -= each.map(|(i, force)| force.dot(&frames[*i].rates(&mean))).sum::<f64>();
            v.iter_mut().zip(&change).for_each(|(v, x)| *v += x);
            if all {
                break;
            }
        }
        self.impacts += done.all.len();
        Ok(done)
    }

    /// (1) at some of the contacts, the others being as they are; of the restitution `part`, or as much of that as gains no energy.
    fn strike_at(
        &mut self,
        frames: &[Frame],
        answers: &[[Vec<f64>; 3]],
        speeds: &[Vector3<f64>],
        taking: &[usize],
        part: f64,
    ) -> Result<Answer, Trouble> {
        let own: Vec<Frame> = taking.iter().map(|i| frames[*i].clone()).collect();
        let own_answers: Vec<[Vec<f64>; 3]> = taking.iter().map(|i| answers[*i].clone()).collect();
        let law = |frame: &Frame| {
            let friction = self.law(frame.key.couple).friction;
            Law::Coulomb { stick: friction.slide, slide: friction.slide }
        };
        let laws: Vec<Law> = own.iter().map(law).collect();
        let before: Vec<Vector3<f64>> = taking.iter().map(|i| speeds[*i]).collect();
        let mut problem = problem(&own, &own_answers, before.clone(), laws);
        let rebound = |frame: &Frame, u: &Vector3<f64>| match u.x < -self.rest {
            true => u.x * self.law(frame.key.couple).law.restitution(),
            false => 0.0,
        };
        let rebounds: Vec<f64> = own.iter().zip(&before).map(|(frame, u)| part * rebound(frame, u)).collect();
        let mut with = |share: f64| answer(&mut problem, &before, &rebounds, share);
        let whole = with(1.0);
        if let Tried::Sound(found) = whole {
            return Ok(found);
        }
        // Between none, which gains nothing, and all of it. The part lies anywhere, so that it is halved towards.
        let (mut sound, mut last) = match with(0.0) {
            Tried::Sound(found) => (found, whole),
            not => {
                let why = match not {
                    Tried::Unfound(sweeps) => {
                        format!("the impulses of {} simultaneous contacts are not found in {sweeps} sweeps", own.len())
                    }
                    _ => "every impulse that ends the approach would gain energy".to_owned(),
                };
                return Err(Trouble::Undecided { between: self.between(own[0].key.couple), why });
            }
        };
        let (mut low, mut high) = (0.0, 1.0);
        while high - low > NEARLY {
            let share = 0.5 * (low + high);
            match with(share) {
                Tried::Sound(found) => (low, sound) = (share, found),
                not => (high, last) = (share, not),
            }
        }
        self.held_back += usize::from(matches!(last, Tried::Gains));
        Ok(sound)
    }
}

/// What (1) gives.
enum Tried {
    Sound(Answer),
    /// It gains energy.
    Gains,
    /// After so many sweeps.
    Unfound(usize),
}

/// (1) with a share of these rebounds (m/s).
fn answer(problem: &mut Problem, before: &[Vector3<f64>], rebounds: &[f64], share: f64) -> Tried {
    let rates = before.iter().zip(rebounds).map(|(u, rebound)| u + Vector3::x() * (share * rebound));
    problem.rates = rates.collect();
    let found = problem.solve(&vec![Vector3::zeros(); before.len()], FOUND, MOST_SWEEPS);
    if found.change > 1e-9 || found.forces.iter().any(|f| !f.iter().all(|x| x.is_finite())) {
        return Tried::Unfound(found.sweeps);
    }
    problem.rates = before.to_vec();
    let gained: f64 =
        (0..before.len()).map(|k| 0.5 * found.forces[k].dot(&(before[k] + problem.rate(k, &found.forces)))).sum();
    let size: f64 = before.iter().map(|u| u.norm()).fold(0.0, f64::max);
    let most: f64 = found.forces.iter().map(|f| f.norm() * size).sum();
    if gained <= GAINED * most { Tried::Sound(found) } else { Tried::Gains }
}
