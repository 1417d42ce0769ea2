//! A state that is bound to a manifold of its own is brought back once per step, and the step goes on from there.

use stillpoint::integrate::{Failure, ImplicitProblem, Method, Point, Problem, Start};

use super::{METHODS, distance, fixed, run};

/// A point that circles the origin once in 2π s, `q̈ = −q`, bound to the unit circle.
#[derive(Default)]
struct Circle {
    projections: u64,
    pivot: f64,
}

impl Problem for Circle {
    fn position_count(&self) -> usize {
        2
    }
    fn velocity_count(&self) -> usize {
        2
    }
    fn acceleration(&mut self, _time: f64, q: &[f64], _v: &[f64], a: &mut [f64]) -> Result<(), Failure> {
        a.copy_from_slice(&[-q[0], -q[1]]);
        Ok(())
    }
    fn position_rate(&self, _q: &[f64], v: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(v);
    }
    fn normalize(&self, _q: &mut [f64]) {}
    fn project(&mut self, _time: f64, q: &mut [f64], v: &mut [f64]) -> Result<bool, Failure> {
        self.projections += 1;
        let radius = q[0].hypot(q[1]);
        q.iter_mut().for_each(|q| *q /= radius);
        let outward = q[0] * v[0] + q[1] * v[1];
        v.iter_mut().zip(&*q).for_each(|(v, q)| *v -= outward * q);
        Ok(true)
    }
    fn scales(&self) -> (&[f64], &[f64]) {
        (&[1.0; 2], &[1.0; 2])
    }
}

impl ImplicitProblem for Circle {
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        q.iter_mut().zip(start).zip(v).for_each(|((q, start), v)| *q = start + step * v);
    }
    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]) {
        q.iter_mut().zip(from).zip(by).for_each(|((q, from), by)| *q = from + by);
    }
    fn residual(&mut self, _time: f64, q: &[f64], _v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure> {
        r.copy_from_slice(&[a[0] + q[0], a[1] + q[1]]);
        Ok(())
    }
    fn reserve(&mut self) {}
    fn factorize(&mut self, _at: Point<'_>, _c1: f64, c2: f64) -> Result<(), Failure> {
        self.pivot = c2 + 1.0;
        Ok(())
    }
    fn solve(&mut self, rhs: &mut [f64]) {
        rhs.iter_mut().for_each(|x| *x /= self.pivot);
    }
}

fn start<'a>() -> Start<'a> {
    Start { time: 0.0, position: &[1.0, 0.0], velocity: &[0.0, 1.0], end: 3.0 }
}

#[test]
fn every_method_projects_once_per_step_and_stays_on_the_manifold() {
    for method in METHODS {
        let mut circle = Circle::default();
        let reached = run(method, &mut circle, &fixed(0.1), start());
        let (q, v) = (reached.position(), reached.velocity());
        // Two roundings of a sum of two squares.
        assert!((q[0].hypot(q[1]) - 1.0).abs() < 1e-15, "{method:?}: {q:?}");
        assert!((q[0] * v[0] + q[1] * v[1]).abs() < 1e-15, "{method:?}: {v:?}");
        assert_eq!(circle.projections, reached.statistics().steps, "{method:?}");
    }
}

/// The error of a step is then along the circle alone; it falls by 2⁴ at least with every halving (less a fifth for the
/// next term) where the stage shared with the next step is taken again at the projected state.
#[test]
fn projecting_costs_no_order() {
    for method in [Method::Rk4, Method::Dopri5, Method::Sdirk4] {
        let error = |step: f64| {
            let reached = run(method, &mut Circle::default(), &fixed(step), start());
            distance(reached.position(), &[3.0_f64.cos(), 3.0_f64.sin()])
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!(order > 3.75, "{method:?}: {order}");
    }
}
