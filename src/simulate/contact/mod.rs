//! Contact in motion, by events: between two events every contact is open, sticks (or rolls), or slips, and the motion is smooth.
//!
//! ```text
//! (1)  M q̈ = f + Pᵀλ,   R q̈ + c = 0
//!      R   the normal of every closed contact, and both tangents of what sticks
//!      P   the same of what sticks; n − μ d of what slips in the direction d, which is not symmetric with R
//! (2)  closed until λ_n < 0;   sticks until |λ_t| > μ_stick λ_n;   slips until u·d < 0;   open until gap < 0
//! ```
//!
//! What follows from an event is decided by one cone problem for all contacts that touch ([`crate::contact::cone`]): on velocities
//! ([`impact`]), then on accelerations ([`decide`]). Forces of (1) come from its rows alone, so that what sticks does not creep.
//!
//! **Linearly dependent rows** (a box on four corners): accelerations are unique if all stick, forces are not; taken are those of least
//! norm. Whether a group still sticks is asked of the cone problem, not of them: there may be others within the cones.
//!
//! **The direction of slip** turns at a rate that grows without bound as the slip gets slower: `|u| φ̇ = a_⊥`, with `a_⊥` what accelerates
//! it across. Where nothing does, it is kept: a row `u_⊥ = 0` whose force λ_⊥ is none ([`STRAIGHT`]) takes the stiffness out, and
//! an event ends it as soon as there is one. A slip that turns has its own direction until it is slower than what the tolerance of the run
//! tells from rest: that is an event, as its direction says nothing any more, and the cone problem says whether it sticks.
//!
//! | file | its one job |
//! |---|---|
//! | `rows` | (1): accelerations with the rows of closed contacts, and states kept on them |
//! | `decide` | an instant: impacts, what touches afterwards, and the state of each contact |
//! | `impact` | what approaching bodies do to their velocities |
//! | `joint` | joints of level bodies: what is carried on over them |
//! | `watch` | (2): the numbers whose change of sign is an event |
//! | `slip` | how a slip begins, goes straight on, turns and comes to rest |
//! | `spring` | compliant contacts |
//! | `capture` | steps that capture all events of an instant |
//! | `moreau` | one such step |
//! | `mode` | what contacts do, as a value: for runs that go on |
//! | `raise` | what has sunk in captured steps is moved apart |
//! | `blocks` | `J M⁻¹ Jᵀ` of many contacts, by trees |

mod active;
mod blocks;
mod capture;
mod coupling;
mod decide;
mod impact;
mod joint;
mod mode;
mod moreau;
mod raise;
mod rows;
mod slip;
mod spring;
mod watch;

use crate::contact::frame::{self, Frame};
use crate::contact::geometry::feature::Meeting;
use crate::contact::pairs::{Key, LOOSE, Pairs, Untouchable};
use crate::dynamics::{Fault, System};
use crate::model::Model;
use crate::motion::Motion;
use crate::record::ContactPush;
use crate::round_off::REBOUND_OF_BODIES;
use crate::spatial::link::LinkAcceleration;
pub(super) use capture::Capture;
pub(super) use decide::Told;
pub(super) use mode::ContactMode;
use nalgebra::{DVector, Vector3};
use std::cell::OnceCell;
use std::collections::VecDeque;
use std::sync::Arc;
pub(super) use watch::Aspect;

/// A gap below this part of a shape's size is none: rounding of positions of some sizes.
const GAP: f64 = 1e-9;
/// More rows than this are not decided event by event.
const MOST_ROWS: usize = 150;
/// Scenes in which more pairs of shapes may meet are not decided event by event.
const MOST_COUPLES: usize = 1000;
/// So many events within this part of the scene's time are a storm.
const STORM: usize = 60;
const BRIEF: f64 = 1e-2;
/// As many of a crowd of closed contacts are one where there are more of them than this part of the accepted steps.
const CROWD: usize = 12;
const BUSY: f64 = 1.0 / 3.0;
/// What pulls by less than this part of the largest force does so by rounding.
const PULLS: f64 = 1e-9;
/// A gap that is found open by this part of the size below zero was missed.
pub(super) const MISSED: f64 = 1e-6;

/// How contacts of a run are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Regime {
    /// From event to event: closed contacts are rows.
    Events,
    /// By captured steps.
    Captured,
    /// Nothing moves and nothing will, as closed contacts hold everything: accelerations are zero, not rounding.
    Resting,
    /// Nothing moves and nothing will, by the forces of the last captured step.
    Frozen,
}

/// Captured steps that follow each other.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Stretch {
    /// They do not end before (s).
    until: f64,
    /// From their beginning to that (s).
    length: f64,
}

/// What a closed contact does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ContactState {
    /// No relative motion of what touches: it rests, or rolls.
    Stick,
    /// It slips in this direction, inertial axes, or has no friction (zero).
    Slip(Vector3<f64>),
    /// It touches and others bear.
    Spare,
}

/// A closed contact.
#[derive(Debug, Clone)]
pub(super) struct Closed {
    key: Key,
    pub(super) state: ContactState,
    /// Its first tangent when it was closed.
    axis: Vector3<f64>,
    /// The gap that is kept (m).
    gap: f64,
    /// In the last place.
    meeting: Meeting,
    /// On the second body, inertial axes (N).
    pub(super) force: Vector3<f64>,
    /// Of the second body over the first (m/s).
    slip: Vector3<f64>,
    /// Whether it slips along a straight line, and the force across that, in parts of friction.
    straight: bool,
    across: f64,
    /// Whether it has slipped faster than what is told from rest since it began to.
    moved: bool,
    /// The direction in which its slip begins by itself, as read from the last decision.
    begins: Vector3<f64>,
    /// Whether it may bear, since when (s): a compliant one does not where it would pull.
    pushes: bool,
    since: f64,
}

impl Closed {
    fn may_push(&self) -> bool {
        self.state != ContactState::Spare && self.pushes
    }
}

/// The contacts of a run.
#[derive(Debug)]
pub(super) struct Contacts {
    model: Arc<Model>,
    pairs: Pairs,
    pub(super) closed: Vec<Closed>,
    regime: Regime,
    /// The last stretch of captured steps.
    stretch: Stretch,
    /// Below these a speed is none across and along the normal (m/s).
    slow: f64,
    rest: f64,
    /// What forces are compared with (N).
    scale: f64,
    /// What stuck before an instant and has no more than this speed sticks (m/s).
    kept: f64,
    /// A slip that turns and has become as slow as this is at rest (m/s).
    still: f64,
    carried: Vec<LinkAcceleration>,
    frames: Vec<Frame>,
    /// `R M⁻¹ Pᵀ` and what rows lack without forces, in the last place.
    last: (coupling::Coupling, DVector<f64>),
    /// What unit forces of these rows accelerate along every slip that friction brakes, with its own row, if some rows depend on others.
    along_slips: Vec<(usize, DVector<f64>)>,
    /// Rows of closed contacts in their states that are linearly independent.
    independent: Vec<usize>,
    /// How far forces are within their cones in the last place, once that is asked for.
    reserve: OnceCell<f64>,
    /// The gap of each couple and its rate there, once that is asked for.
    gaps: Vec<OnceCell<[f64; 2]>>,
    pub(super) impacts: usize,
    /// Impacts that came back with less than their restitution, which would have gained energy.
    pub(super) held_back: usize,
    /// Velocity coordinates of trees that contacts alone tie to each other.
    trees: blocks::Trees,
    memory: capture::Memory,
    /// Times of the last events (s), and how many steps had been accepted.
    recent: VecDeque<(f64, usize)>,
    accepted: usize,
    /// A gap below this part of a shape's size is none.
    closing: f64,
    /// Sizes of the smallest and of the largest shape that may touch, no more than the scene's length (m): what is far away has no say in how well
    /// contacts are followed.
    lengths: [f64; 2],
}

/// Speeds below this part of the scene's are none where what touches slips.
const SLOW: f64 = 1e-9;
/// A slip goes straight on if what holds it there is less than this part of friction.
const STRAIGHT: f64 = 1e-6;
/// Between two steps rows are met to the accuracy of the interpolation only: below this part of the scene's speed what stuck does.
const KEPT: f64 = 1e-4;
impl Contacts {
    /// The contacts of a model, none of them closed yet; at the first instant those are whose gap is at most `closing` of a shape's
    /// size.
    ///
    /// # Errors
    /// A shape that nothing can touch.
    pub(super) fn new(model: &Arc<Model>, closing: f64) -> Result<Self, Untouchable> {
        let speed = model.length_scale() / model.time_scale();
        let acceleration = model.gravity.norm().max(speed / model.time_scale());
        let pairs = Pairs::new(model)?;
        let sizes = || pairs.pieces.iter().map(|piece| piece.size).filter(|size| size.is_finite() && *size > 0.0);
        let length = model.length_scale();
        let largest = sizes().fold(0.0, f64::max);
        let largest = if largest > 0.0 { largest.min(length) } else { length };
        let lengths = [sizes().fold(largest, f64::min), largest];
        let mass: f64 = model.links.iter().map(|link| link.mass).fold(0.0, f64::max);
        Ok(Self {
            model: Arc::clone(model),
            gaps: vec![OnceCell::new(); pairs.couples.len()],
            pairs,
            closed: Vec::new(),
            regime: Regime::Events,
            stretch: Stretch::default(),
            slow: SLOW * speed,
            rest: 4.0 * (2.0 * acceleration * REBOUND_OF_BODIES.of(model.length_scale())).sqrt(),
            scale: mass * acceleration,
            kept: KEPT * speed,
            still: SLOW * speed,
            carried: Vec::new(),
            frames: Vec::new(),
            last: (coupling::Coupling::default(), DVector::zeros(0)),
            along_slips: Vec::new(),
            independent: Vec::new(),
            reserve: OnceCell::new(),
            impacts: 0,
            held_back: 0,
            trees: blocks::Trees::new(model),
            memory: capture::Memory::default(),
            recent: VecDeque::new(),
            accepted: 0,
            closing,
            lengths,
        })
    }

    /// What the tolerance of a run tells from rest (m/s): below `rebound` nothing comes back from impacts; a slip that turns and is as slow as `still`
    /// has come to rest.
    pub(super) fn set_tolerance(&mut self, rebound: f64, still: f64) {
        self.rest = self.rest.max(rebound);
        self.still = still.clamp(self.slow, self.kept);
    }

    /// Whether what moves along a velocity coordinate touches something, by itself or through what hangs together with it.
    pub(super) fn is_beside(&self, velocity: usize) -> bool {
        self.closed.iter().any(|closed| self.hangs_on(closed.key.couple, velocity))
    }

    /// Whether the shapes of a couple hang together with a velocity coordinate.
    fn hangs_on(&self, couple: usize, velocity: usize) -> bool {
        let links = &self.model.links;
        self.pairs.couples[couple].pieces.iter().any(|piece| {
            let way = std::iter::successors(Some(self.pairs.pieces[*piece].link), |at| Some(links[*at].parent));
            let mut way = way.take_while(|at| *at != 0).filter(|at| links[*at].joint.counts().1 > 0);
            way.any(|at| self.trees.hang_together(links[at].velocity, velocity))
        })
    }

    /// Whether the shapes of a couple hang together with dry friction of hinges, or with what is `stopped` (velocity coordinates): captured
    /// steps alone follow both at once.
    fn is_tied(&self, couple: usize, stopped: &[usize]) -> bool {
        let rubs = self.model.hinge_friction.iter().map(|own| own.velocity);
        rubs.chain(stopped.iter().copied()).any(|velocity| self.hangs_on(couple, velocity))
    }

    /// Whether captured steps are at work.
    pub(super) fn is_captured(&self) -> bool {
        self.regime == Regime::Captured
    }

    /// Whether nothing moves and nothing will.
    pub(super) fn is_at_rest(&self) -> bool {
        matches!(self.regime, Regime::Resting | Regime::Frozen)
    }

    /// Whether forces are those of the last captured step.
    fn follows_steps(&self) -> bool {
        matches!(self.regime, Regime::Captured | Regime::Frozen)
    }

    fn law(&self, couple: usize) -> &crate::model::ContactRule {
        &self.model.contacts[self.pairs.couples[couple].rule]
    }

    /// The frames of closed contacts in one place.
    fn stand(&mut self, motion: &Motion) {
        frame::carried(motion, &self.model, &mut self.carried);
        self.pairs.place(motion);
        self.frames.clear();
        for closed in &mut self.closed {
            if let Some(found) = self.pairs.meeting(&closed.key) {
                closed.meeting = found;
            }
            let (key, meeting, axis) = (closed.key, closed.meeting, Some(closed.axis));
            let frame = Frame::new(&self.model, motion, &self.pairs, &self.carried, key, meeting, axis);
            closed.slip = frame.slip();
            self.frames.push(frame);
        }
    }

    /// Frames of all contacts that touch in a place: those that were closed and still count, and those whose gap is none.
    fn touching(&mut self, motion: &Motion) -> Vec<Frame> {
        frame::carried(motion, &self.model, &mut self.carried);
        self.pairs.place(motion);
        let mut found: Vec<(Key, Meeting)> = Vec::new();
        let were: Vec<Meeting> = self.closed.iter().filter_map(|closed| self.pairs.meeting(&closed.key)).collect();
        for couple in 0..self.pairs.couples.len() {
            let size = self.pairs.couples[couple].size;
            let (closing, loose) = (self.closing, self.closing.max(LOOSE));
            if self.pairs.apart(couple) > closing * size {
                continue;
            }
            let first = found.len();
            let closed = &self.closed;
            let (rigid, overlap) = (self.is_rigid(couple), OnceCell::new());
            let depth = || *overlap.get_or_init(|| self.pairs.depth(couple));
            let here = |one: &Meeting, other: &Meeting| {
                (other.point - one.point).norm() < 10.0 * LOOSE * size && other.normal.dot(&one.normal) > 1.0 - 1e-6
            };
            // A point that slides over a joint is taken over.
            let goes_on = |meeting: &Meeting| were.iter().any(|was| here(was, meeting));
            self.pairs.meetings(couple, [loose * size; 2], goes_on, |meeting| {
                let key = Key { couple, features: meeting.features };
                let was = closed.iter().any(|closed| closed.key == key);
                let inside = meeting.inside.min(meeting.flat);
                let counts = was || inside >= -closing * size && meeting.gap < closing * size;
                // Deeper than that it is the far side of something thin.
                let double = |(_, other): &(Key, Meeting)| here(other, &meeting);
                let near = match rigid {
                    true => meeting.gap > -closing.max(MISSED) * size,
                    false => self.touches_springs(&meeting, depth, size),
                };
                if counts && near && !found[first..].iter().any(double) {
                    found.push((key, meeting));
                }
            });
        }
        let frame = |(key, meeting)| Frame::new(&self.model, motion, &self.pairs, &self.carried, key, meeting, None);
        found.into_iter().map(frame).collect()
    }

    /// The couples that bear and whether one of their contacts slips, with the relative spin.
    fn told(&self) -> Vec<(usize, bool)> {
        let mut told: Vec<(usize, bool)> = Vec::new();
        for closed in self.closed.iter().filter(|closed| closed.state != ContactState::Spare) {
            let slips = matches!(closed.state, ContactState::Slip(direction) if direction != Vector3::zeros());
            match told.iter_mut().find(|(couple, _)| *couple == closed.key.couple) {
                Some((_, any)) => *any |= slips,
                None => told.push((closed.key.couple, slips)),
            }
        }
        told
    }

    /// What bears in the last place.
    pub(super) fn pushes(&self, out: &mut Vec<ContactPush>) {
        out.clear();
        self.each_push(|couple, meeting, force, slips| {
            out.push(ContactPush {
                between: self.between(couple),
                point: meeting.point.into(),
                normal: meeting.normal.into(),
                force: force.into(),
                slips,
            });
        });
    }

    /// What each contact rule exerts on its second bodies in the last place (N, inertial axes).
    pub(super) fn by_rule(&self, out: &mut Vec<Vector3<f64>>) {
        out.clear();
        out.resize(self.model.contacts.len(), Vector3::zeros());
        self.each_push(|couple, _, force, _| out[self.pairs.couples[couple].rule] += force);
    }

    /// Couple, place and force of what bears in the last place, and whether it slips.
    fn each_push(&self, mut push: impl FnMut(usize, &Meeting, Vector3<f64>, bool)) {
        if !self.follows_steps() {
            for one in self.closed.iter().filter(|closed| closed.state != ContactState::Spare) {
                push(one.key.couple, &one.meeting, one.force, matches!(one.state, ContactState::Slip(_)));
            }
            return;
        }
        for (key, force) in self.memory.pairs() {
            let Some(meeting) = self.pairs.meeting(key) else { continue };
            let normal = meeting.normal.dot(force);
            let across = (force - meeting.normal * normal).norm();
            let limit = self.law(key.couple).friction.slide * normal;
            push(key.couple, &meeting, *force, !self.is_at_rest() && across >= limit * (1.0 - 1e-6));
        }
    }

    /// Where forces are not unique those of least norm may pull at some point, or be more than friction holds: others that are within their
    /// cones and accelerate everything as they do.
    fn others(&self) -> Option<Vec<Vector3<f64>>> {
        let leaves = |one: &Closed| one.may_push() && self.inward(one, &one.force) < -PULLS * self.scale;
        if !self.closed.iter().any(leaves) {
            return None;
        }
        self.best().filter(|(slack, _)| *slack >= -PULLS).map(|(_, forces)| forces)
    }

    /// Pushes with [`Contacts::others`] at the last place, so that what hinges pass on is in balance with them.
    pub(super) fn take_others(&mut self, system: &mut System, q: &[f64], v: &[f64]) {
        let Some(others) = self.others().filter(|_| !self.follows_steps()) else { return };
        self.closed.iter_mut().zip(others).for_each(|(closed, force)| closed.force = force);
        system.let_go_of_contacts();
        self.press(&mut system.factorized_beside(q, v));
    }

    /// Names of the bodies of a couple.
    fn between(&self, couple: usize) -> [String; 2] {
        self.pairs.couples[couple].pieces.map(|piece| self.model.bodies[self.pairs.pieces[piece].body].name.clone())
    }

    /// Events could not go on at a time (s): captured steps do for a while.
    pub(super) fn capture_from(&mut self, time: f64) {
        let brief = BRIEF * self.model.time_scale();
        let Stretch { until, length } = self.stretch;
        // Twice as long as the last time, if that is not long ago.
        let length = if time - until < 10.0 * length { 2.0 * length } else { 5.0 * brief };
        self.stretch = Stretch { until: time + length, length };
        self.recent.clear();
        self.memory.restart();
        self.follow_steps(Regime::Captured);
    }

    /// Whether anything pushed in the last place.
    pub(super) fn pushes_any(&self) -> bool {
        !self.closed.is_empty() || self.follows_steps()
    }

    /// Forces are those of captured steps from now on.
    fn follow_steps(&mut self, regime: Regime) {
        self.regime = regime;
        self.closed.clear();
        self.frames.clear();
    }

    /// Whether anything touches, or has since events go on.
    pub(super) fn is_busy(&self) -> bool {
        !self.closed.is_empty() || !self.recent.is_empty()
    }

    /// Takes note of an event; true if events come too often, or too much touches, to go on by them: captured steps do.
    pub(super) fn note_event(&mut self, time: f64) -> bool {
        self.recent.push_back((time, self.accepted));
        let brief = BRIEF * self.model.time_scale();
        if self.recent.len() > STORM {
            self.recent.pop_front();
        }
        let crowd = 3 * self.closed.len() > MOST_ROWS || self.pairs.couples.len() > MOST_COUPLES;
        let crowd = crowd && !self.is_at_rest();
        let (since, steps) = self.recent[0];
        let busy = self.closed.len() > CROWD && BUSY * ((self.accepted - steps + STORM) as f64) < STORM as f64;
        let storm = self.recent.len() >= STORM && (busy || time - since < brief);
        if storm || crowd {
            self.capture_from(time);
        }
        storm || crowd
    }

    /// Nothing moves any more: captured steps have found forces that hold everything.
    pub(super) fn freeze(&mut self) {
        self.follow_steps(Regime::Frozen);
    }

    /// The length of a captured step where one was last (s).
    pub(super) fn captured_step(&self) -> f64 {
        self.memory.step
    }

    /// Captured steps so far.
    pub(super) fn captured(&self) -> usize {
        self.memory.steps
    }

    /// Power that slips take out at the last place (W).
    pub(super) fn dissipated(&self) -> f64 {
        self.closed.iter().map(|closed| -closed.force.dot(&closed.slip)).sum::<f64>() + self.damped()
    }
}

/// What went wrong at a contact.
#[derive(Debug, Clone)]
pub(super) enum Trouble {
    Fault(Fault),
    /// Which bodies, and what.
    Contact {
        between: [String; 2],
        why: String,
    },
    /// What one cone problem does not decide: captured steps may go on.
    Undecided {
        between: [String; 2],
        why: String,
    },
}

impl From<Fault> for Trouble {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}
