//! What implicit methods ask of a system of bodies: residuals of stages, and Newton's matrix.

use super::bordered::Bordered;
use super::differenced::{Differenced, Displaced};
use super::tangent::Tangent;
use crate::dynamics::{Coefficients, System, TangentSolver};
use crate::integrate::{Failure, ImplicitProblem, Point};
use crate::simulate::passage::Passage;
use crate::simulate::problem::Equations;

fn singular() -> Failure {
    Failure { message: "the tangent of the implicit step is singular".to_owned() }
}

impl Equations {
    /// Lowers the sizes of differences over velocity coordinates to what friction allows where accelerations were computed last.
    pub(in crate::simulate) fn refine(&self, sizes: &mut [f64]) {
        self.contacts.iter().for_each(|contacts| contacts.refine(sizes));
    }

    /// The Newton matrix beside contacts that move.
    fn factorize_differenced(&mut self, Point { time, q, v, .. }: Point<'_>, c1: f64, c2: f64) -> Result<(), Failure> {
        let Tangent::Differenced(mut factors) = std::mem::replace(&mut self.tangent, Tangent::None) else {
            return Err(singular());
        };
        let span = self.model().time_scale();
        let scales = std::mem::take(&mut self.velocity_scales);
        let (base, sizes) = factors.begin(v, &scales);
        let stood = self.accelerations(time, q, v, base);
        self.refine(sizes);
        let regular = stood.and_then(|()| {
            factors.factorize(v, [c1, c2], (&scales, span), |at: Displaced<'_>| {
                ImplicitProblem::displace(self, q, at.by, at.position);
                self.accelerations(time, at.position, at.velocity, at.a)
            })
        });
        (self.velocity_scales, self.tangent) = (scales, Tangent::Differenced(factors));
        if regular? { Ok(()) } else { Err(singular()) }
    }
}

impl ImplicitProblem for Equations {
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        self.coordinates.implicit(start, step, v, q);
    }

    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]) {
        q.copy_from_slice(from);
        System::displace(self.system.model(), q, by);
    }

    fn residual(&mut self, time: f64, q: &[f64], v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure> {
        if self.contacts.is_some() {
            self.accelerations(time, q, v, r)?;
            r.iter_mut().zip(a).for_each(|(r, a)| *r = a - *r);
            return Ok(());
        }
        match &mut self.passage {
            // The accelerations that the rows allow, see `passage`; at equal multipliers the difference is M (a − a_c).
            Some(passage) if passage.is_near() => {
                passage.accelerations(&mut self.system, time, q, v, r)?;
                self.allowed.copy_from_slice(r);
                let mut at = self.system.at(time, q, v);
                at.residual(&self.allowed, &mut self.balance)?;
                at.residual(a, r)?;
                r.iter_mut().zip(&self.balance).for_each(|(r, allowed)| *r -= allowed);
            }
            // The multipliers of this state, see `bordered`.
            Some(_) => {
                let mut at = self.system.at(time, q, v);
                at.accelerations(r)?;
                at.residual(a, r)?;
            }
            None => {
                self.system.at(time, q, v).residual(a, r)?;
            }
        }
        if let Some(nonsmooth) = &self.nonsmooth {
            nonsmooth.balance(r);
        }
        Ok(())
    }

    fn asks_for_care(&self) -> bool {
        self.contacts.is_none() && self.system.has_outweighed_links()
    }

    fn reserve(&mut self) {
        let model = self.system.model();
        if self.contacts.is_some() {
            let counts = (model.position_count(), model.velocity_count());
            self.tangent = Tangent::Differenced(Box::new(Differenced::new(counts.0, counts.1)));
        } else if matches!(self.tangent, Tangent::None) {
            self.tangent = match model.is_constrained() {
                true => Tangent::Bordered(Box::new(Bordered::new(&self.system))),
                false => Tangent::Tree(Box::new(TangentSolver::new(model))),
            };
        }
    }

    fn factorize(&mut self, at: Point<'_>, c1: f64, c2: f64) -> Result<(), Failure> {
        let Point { time, q, v, a } = at;
        if self.contacts.is_some() {
            return self.factorize_differenced(at, c1, c2);
        }
        let system = &mut self.system;
        let phase = system.phase();
        let shift = self.nonsmooth.as_mut().map_or(&[][..], |nonsmooth| nonsmooth.diagonal(phase, v, c1));
        let regular = match &mut self.tangent {
            Tangent::None | Tangent::Differenced(_) => false,
            Tangent::Tree(solver) => {
                let with = Coefficients { c1, c2, shift, ..Coefficients::default() };
                system.at(time, q, v).factorize_tangent(solver, a, &with)?
            }
            Tangent::Bordered(factors) => {
                let weak = self.passage.as_ref().filter(|passage| passage.is_near()).map_or(0.0, Passage::weak);
                factors.factorize(system, at, [c1, c2], shift, weak)?
            }
        };
        match regular {
            true => Ok(()),
            false => Err(singular()),
        }
    }

    fn solve(&mut self, rhs: &mut [f64]) {
        match &mut self.tangent {
            Tangent::None => {}
            Tangent::Tree(solver) => solver.solve(rhs),
            Tangent::Bordered(factors) => factors.solve(&mut self.system, rhs),
            Tangent::Differenced(factors) => factors.solve(rhs),
        }
    }
}
