//! A model with its forces: accelerations, residuals, their derivatives and energies of a state. The only place where
//! [`applied`] forces and `transfer` meet.
//!
//! | file | its one job |
//! |---|---|
//! | `evaluated` | what follows from one place: accelerations, residuals, energies, each by the borrow that proves it |
//! | [`applied`] | everything that pushes in a scene, its variation and its powers |
//! | `constrained` | loops, drives and gears: multipliers with the accelerations, states kept closed |
//! | `reactions`, `beams` | what hinges pass on, and what beams bear |
//! | `tangent` | what the tangent sweep needs of a system with its forces; `reach` says by which matrices it is solved, `border` and `sparse` are those for elements between distant bodies |
//! | `jacobian`, `linearize`, `dense` | derivatives of accelerations, dense matrices of mass, damping and stiffness, and their factors |
//! | `magnitudes` | how large the terms of a balance are, and their round-off |
//! | `boundaries` | where laws are not smooth |
//! | [`ensemble`] | systems of one structure side by side |

pub mod applied;
mod beams;
mod border;
mod boundaries;
mod constrained;
mod dense;
pub mod ensemble;
mod evaluated;
mod jacobian;
mod linearize;
mod magnitudes;
mod reach;
mod reactions;
mod sparse;
mod tangent;
mod twists;
mod written;

pub(crate) use beams::LockedStrain;
pub use beams::{BeamState, DiagramPoint, Discretization, SectionForces};
pub use constrained::Settled;
pub use dense::Dense;
pub use ensemble::Ensemble;
pub use evaluated::{Balanced, Evaluated, Factorized};
pub use jacobian::AccelerationJacobians;
pub use linearize::Linearization;
pub use magnitudes::Magnitudes;
pub use reach::Matrices;
pub use tangent::{Coefficients, TangentSolver};

use crate::constraint::{Constraints, OpenGap};
pub use crate::constraint::{HeldRow, RowSelection};
use crate::force::{Act, Force, Law};
use crate::model::Model;
use crate::model::motor::Push;
use crate::model::problem::number;
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use crate::transfer::balance::Balance;
pub use crate::transfer::mass::MassAction;
use crate::transfer::reduce::{Reduction, Singular};
use crate::transfer::variation::Variation;
pub use applied::Boundary;
use applied::{Laws, Phase};
use constrained::Constrained;
use std::sync::Arc;

/// A model and the scratch memory to evaluate it. States come in from outside, by [`System::at`].
#[derive(Debug, Clone)]
pub struct System {
    model: Arc<Model>,
    /// What pushes, as the model has it or as a run keeps it.
    laws: Laws,
    /// Positions and velocities of the place.
    motion: Motion,
    reduction: Reduction,
    balance: Balance,
    variation: Variation,
    /// Wrenches of the force elements, one per link.
    applied: Vec<Wrench>,
    /// Hinge forces, and scratch of the same length.
    tau: Vec<f64>,
    scratch: Vec<f64>,
    /// What contacts push links with, at their root markers, and what captured stops and dry friction push hinges with; empty without
    /// contact.
    pressed: Vec<Wrench>,
    pressed_hinges: Vec<f64>,
    /// What motors and curves push with, in the order of [`Model::pushed`].
    pushes: Vec<Push>,
    /// The time at which drives and motors are looked at (s).
    time: f64,
    /// Whether loads or masses follow tables over time.
    is_timed: bool,
    /// Loops, drives and gears, if there are any.
    constraints: Option<Box<Constrained>>,
}

/// Why a system could not be evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A hinge that nothing with inertia resists.
    #[error(
        "the hinge of `{body}` has no inertia to accelerate in this position, or next to none beside what it carries (pivot {pivot:.1e}): a point mass on its own axis needs `inertia`; a link far lighter than its load needs more of it, or a `fixed` hinge; a gimbal lock needs another position"
    )]
    Singular {
        /// Body.
        body: String,
        /// Pivot (kg or kg m²).
        pivot: f64,
    },
    /// A loop that opens, or a drive or gear that cannot be followed.
    #[error(
        "{} cannot be closed: a gap of {} remains (a position that cannot be reached or where the mechanism is singular)",
        .0.element, .0.words()
    )]
    Open(OpenGap),
    /// A row that depended linearly on others at the start and no longer does.
    #[error(
        "{} opens by {} in a condition that depended on others at the start: the mechanism has fewer ways to move here (axes or points given with few digits, or of a special start?)",
        .0.element, .0.words()
    )]
    Independent(OpenGap),
    /// Something that knows trees only.
    #[error("`{method}` knows no loops, drives or gears yet")]
    Tied {
        /// Its name.
        method: &'static str,
    },
    /// Something that knows rigid bodies only.
    #[error(
        "`{method}` has a pose of its own for every body, and beams, modal bodies and curves have coordinates between bodies: it knows none of them; \
         `relaxation` does"
    )]
    Flexible {
        /// Its name.
        method: &'static str,
    },
    /// A formula of a drive or motor without a finite value or derivative.
    #[error("the formula `{text}` of {element} has no finite value or derivative at t = {} s", number(*.time))]
    Formula {
        /// Which.
        element: String,
        /// The formula, as written.
        text: String,
        /// Time (s).
        time: f64,
    },
    /// Directions of negative curvature that cannot be counted.
    #[error("stable or not cannot be decided: the stiffness with a shift of {part:e} is singular to working precision")]
    Undecided {
        /// Part of the size of the stiffness terms that it was shifted by, or the eigenvalue below which was counted (1/s²).
        part: f64,
    },
    /// A scene whose matrices are too large.
    #[error(
        "the matrices of this scene's {coordinates} coordinates would take about {gigabytes:.1} GB, and {allowed:.1} GB are allowed: \
         they are {kind}; a smaller scene, or one whose far springs and loops span fewer hinges, takes less"
    )]
    Memory {
        /// Velocity coordinates.
        coordinates: usize,
        /// Which matrices.
        kind: &'static str,
        /// Estimate (10⁹ bytes).
        gigabytes: f64,
        /// What is allowed (10⁹ bytes).
        allowed: f64,
    },
    /// A spring or rope without a direction.
    #[error(
        "{what} of `{element}` are in one place, where its direction is not determined: move one of them, or begin from another position"
    )]
    OnePlace {
        /// Which points.
        what: &'static str,
        /// The force element.
        element: String,
    },
    /// A number that is not finite.
    #[error("{what} of `{element}` is not a finite number")]
    NotFinite {
        /// Which number.
        what: &'static str,
        /// Body or force element.
        element: String,
    },
}

/// Kinetic and potential energy (J).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic, armatures included.
    pub kinetic: f64,
    /// Gravity, springs, and loads and motors that have a potential.
    pub potential: f64,
}

impl Energies {
    /// The sum of their sizes (J).
    pub fn size(&self) -> f64 {
        self.kinetic.abs() + self.potential.abs()
    }
}

/// Powers without a potential (W).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Powers {
    /// Put in by loads and motors.
    pub input: f64,
    /// Taken out by dampers, ≥ 0.
    pub dissipated: f64,
}

impl System {
    /// Scratch memory for a model with its loops, drives and gears.
    pub fn new(model: &Arc<Model>) -> Self {
        let rows = Constraints::new(model);
        Self::with(
            model,
            rows.map(|rows| Constrained::new(model, &RowSelection::default(), rows, &model.start_position)),
        )
    }

    /// Scratch memory for a model with a selection of its rows. Which of these are independent is decided at a time (s) and a
    /// position.
    pub fn with_rows(model: &Arc<Model>, selection: &RowSelection, time: f64, q: &[f64]) -> Self {
        let mut rows = Constraints::selected(model, selection, time, q);
        rows.iter_mut().for_each(|rows| rows.set_time(time));
        Self::with(model, rows.map(|rows| Constrained::new(model, selection, rows, q)))
    }

    fn with(model: &Arc<Model>, constraints: Option<Box<Constrained>>) -> Self {
        let n = model.links.len();
        let mut system = Self {
            model: Arc::clone(model),
            laws: Laws::new(model),
            motion: Motion::new(model),
            reduction: Reduction::new(model),
            balance: Balance::new(model),
            variation: Variation::new(model),
            applied: vec![Wrench::ZERO; n],
            tau: vec![0.0; model.velocity_count()],
            scratch: vec![0.0; model.velocity_count()],
            pressed: vec![Wrench::ZERO; if model.contacts.is_empty() { 0 } else { n }],
            pressed_hinges: vec![0.0; if model.contacts.is_empty() { 0 } else { model.velocity_count() }],
            pushes: vec![Push::default(); model.pushed().count()],
            time: 0.0,
            is_timed: model.table_times().next().is_some(),
            constraints,
        };
        if system.is_timed {
            // Takes a model and laws of its own: from here on no memory is asked for.
            system.follow_tables(0.0);
        }
        system
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Whether some links carry bodies a thousand times heavier, or more: the residual of their balance is far more than what moves the links.
    pub fn has_outweighed_links(&self) -> bool {
        self.balance.is_outweighed()
    }

    /// What follows from positions and velocities at a time (s), with everything of the model acting; stops and sliding friction of
    /// hinges push in the phase of a run alone, at first none does. Positions are `position_count` numbers, velocities `velocity_count`. Costs one outward sweep.
    pub fn at<'a>(&'a mut self, time: f64, q: &'a [f64], v: &'a [f64]) -> Evaluated<'a> {
        self.set_time(time);
        self.motion.update(&self.model, q, v);
        Evaluated { system: self, q, v }
    }

    /// [`System::at`] without what contacts pushed with so far.
    pub(crate) fn at_without_contact<'a>(&'a mut self, time: f64, q: &'a [f64], v: &'a [f64]) -> Evaluated<'a> {
        self.let_go_of_contacts();
        self.at(time, q, v)
    }

    /// What motors of type `input` are asked to push with from now on, in the order of [`Model::inputs`] (N or N m); each pushes
    /// within its limit. At first what the scene gives them.
    pub fn inputs(&mut self) -> &mut [f64] {
        &mut self.laws.inputs
    }

    /// The force elements, in the order of the model.
    pub(crate) fn forces(&self) -> &[Force] {
        &self.laws.forces
    }

    /// Puts another law in the place of a force element's, from now on.
    pub(crate) fn set_force(&mut self, element: usize, law: Law) {
        Arc::make_mut(&mut self.laws.forces)[element].law = law;
    }

    /// The time at which drives, motors, loads and masses are looked at (s); nothing else depends on time.
    fn set_time(&mut self, time: f64) {
        let before = std::mem::replace(&mut self.time, time);
        if self.is_timed && before != time {
            self.follow_tables(time);
        }
        if let Some(constrained) = &mut self.constraints {
            constrained.rows.set_time(time);
        }
    }

    /// Loads and masses by tables as they are at a time (s).
    #[inline(never)]
    fn follow_tables(&mut self, time: f64) {
        if self.laws.forces.iter().any(|force| !force.law.times().is_empty()) {
            Arc::make_mut(&mut self.laws.forces).iter_mut().for_each(|force| force.law.set_time(time));
        }
        if !self.model.burns.is_empty() {
            let reduction = &mut self.reduction;
            Arc::make_mut(&mut self.model).burn(time, |link, now| reduction.set_mass(link, now.mass));
        }
    }

    /// Which compliant stops push and what dry friction does, in every evaluation.
    pub(crate) fn phase(&self) -> &Phase {
        &self.laws.phase
    }

    /// [`System::phase`], to be changed at an event.
    pub(crate) fn phase_mut(&mut self) -> &mut Phase {
        &mut self.laws.phase
    }

    /// Forgets what contacts push with: evaluations take that in until then.
    pub(crate) fn let_go_of_contacts(&mut self) {
        self.pressed.fill(Wrench::ZERO);
        self.pressed_hinges.fill(0.0);
    }

    /// Where every link is and how fast it moves, at the last place.
    pub(crate) fn links(&self) -> &[LinkMotion] {
        &self.motion.links
    }

    /// `product ← M x` at the last place, in O(n).
    pub(crate) fn mass_times(&self, action: &mut MassAction, x: &[f64], product: &mut [f64]) {
        action.times(&self.model, &self.motion, x, product);
    }

    /// The time of the last place (s).
    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    /// The factorization of the last accelerations at `q` and `v`, which they may have been beside. For contact alone, where that is
    /// as good: others keep what [`Evaluated::accelerations`] gives, which proves the place.
    pub(crate) fn factorized_beside<'a>(&'a mut self, q: &'a [f64], v: &'a [f64]) -> Factorized<'a> {
        Factorized { system: self, q, v }
    }

    fn singular(&self, singular: &Singular, q: &[f64], v: &[f64]) -> Fault {
        let body = self.model.bodies[self.model.links[singular.link].body].name.clone();
        if singular.pivot.is_finite() {
            Fault::Singular { body, pivot: singular.pivot }
        } else {
            self.not_finite_state(q, v).unwrap_or(Fault::NotFinite { what: "the position", element: body })
        }
    }

    /// The drive or motor whose formula has no finite value or derivative at this state.
    pub(super) fn not_finite_formula(&self) -> Option<Fault> {
        let fault = |element: String, text: &str| Fault::Formula { element, text: text.to_owned(), time: self.time };
        let drive = self.model.drives.iter().find(|drive| !drive.motion.at(self.time).is_finite());
        if let Some((drive, text)) = drive.and_then(|drive| Some((drive, drive.motion.formula()?))) {
            return Some(fault(format!("drive `{}`", drive.name), text));
        }
        let mut motors = self.model.motors.iter().zip(&self.pushes);
        let (motor, _) = motors.find(|(_, push)| !push.force.is_finite())?;
        Some(fault(format!("motor `{}`", motor.name), motor.formula()?))
    }

    /// Names the cause: a position or velocity that came in, else a formula, else a force element, else the first hinge.
    fn check_finite(&self, what: &'static str, numbers: &[f64], q: &[f64], v: &[f64]) -> Result<(), Fault> {
        let Some(bad) = numbers.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        if let Some(fault) = self.not_finite_state(q, v) {
            return Err(fault);
        }
        if let Some(fault) = self.not_finite_formula() {
            return Err(fault);
        }
        if let Some(force) = applied::in_one_place(&self.laws, &self.motion) {
            let what = if force.law.ends().len() > 2 { "two points, one after the other," } else { "both ends" };
            return Err(Fault::OnePlace { what, element: force.name.clone() });
        }
        if let Some((force, what)) = applied::not_finite(&self.laws, &self.motion) {
            return Err(Fault::NotFinite { what, element: force.name.clone() });
        }
        Err(Fault::NotFinite { what, element: self.model.owner(bad).to_owned() })
    }

    fn not_finite_state(&self, q: &[f64], v: &[f64]) -> Option<Fault> {
        let bad = |list: &[f64], from: usize, count: usize| list[from..from + count].iter().any(|x| !x.is_finite());
        self.model.bodies.iter().find_map(|body| {
            let (hinge, (positions, velocities)) = (&body.hinge, body.hinge.kind.counts());
            let what = match bad(q, hinge.position, positions) {
                true => "the position",
                false if bad(v, hinge.velocity, velocities) => "the velocity",
                false => return None,
            };
            Some(Fault::NotFinite { what, element: body.name.clone() })
        })
    }

    /// [`crate::motion::displace`].
    pub fn displace(model: &Model, q: &mut [f64], step: &[f64]) {
        crate::motion::displace(model, q, step);
    }
}
