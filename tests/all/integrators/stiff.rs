//! probe
use stillpoint::integrate::{Method, Options, Start};
use super::problems::{Body, Scalar};
use super::{METHODS, adaptive, distance, fixed, run};

#[test]
fn probe() {
    for (name, k, c) in [("damp1e6", 0.0, 1e6), ("spring1e8", 1e8, 2e4), ("both", 1e6, 1e6), ("spring1e10 light damp", 1e10, 2e4)] {
        for tol in [1e-3, 1e-5, 1e-7, 1e-9] {
            let mut p = Scalar::oscillator(k, c, move |t: f64| k * t.sin() + c * t.cos() - t.sin());
            let start = Start { time: 0.0, position: &[0.0], velocity: &[1.0], end: 10.0 };
            let r = run(Method::Sdirk4, &mut p, &adaptive(tol), start);
            println!("{name} {tol:e} err {:e} {:e} {:?}", (r.position()[0] - 10f64.sin()).abs(), (r.velocity()[0] - 10f64.cos()).abs(), r.statistics());
            let start = Start { time: 0.0, position: &[0.1], velocity: &[5.0], end: 10.0 };
            let mut p = Scalar::oscillator(k, c, move |t: f64| k * t.sin() + c * t.cos() - t.sin());
            let r = run(Method::Sdirk4, &mut p, &adaptive(tol), start);
            println!("     off manifold {name} {tol:e} err {:e} {:e} {:?}", (r.position()[0] - 10f64.sin()).abs(), (r.velocity()[0] - 10f64.cos()).abs(), r.statistics());
        }
    }
    for tol in [1e-3, 1e-5, 1e-7, 1e-9] {
        let start = Start { time: 0.0, position: &[2.0], velocity: &[0.0], end: 2000.0 };
        let r = run(Method::Sdirk4, &mut Scalar::van_der_pol(1000.0), &adaptive(tol), start);
        println!("vdp {tol:e} {:?} {:?} {:?}", r.position(), r.velocity(), r.statistics());
    }
    for h in [0.1, 0.05, 0.025, 0.0125] { 
      for c in [1e1, 1e3, 1e6] {
            let mut p = Scalar::oscillator(0.0, c, move |t: f64| c * t.cos() - t.sin());
            let start = Start { time: 0.0, position: &[0.0], velocity: &[1.0], end: 10.0 };
            let r = run(Method::Sdirk4, &mut p, &fixed(h), start);
            println!("fixed {c:e} {h} err {:e} {:e}", (r.position()[0] - 10f64.sin()).abs(), (r.velocity()[0] - 10f64.cos()).abs());
      }
    }
    let start = Start { time: 0.0, position: &[0.0], velocity: &[0.0], end: 20.0 };
    let body = || Body::new([1.0, 1.6, 2.2], [0.5, 0.3, -0.8]);
    let bs = Start { time: 0.0, position: &[0.8, 0.6, 0.0, 0.0], velocity: &[0.5, 1.0, -0.7], end: 10.0 };
    let refp = run(Method::Dopri5, &mut Scalar::pendulum(), &adaptive(1e-13), start);
    let refb = run(Method::Dopri5, &mut body(), &adaptive(1e-13), bs);
    for m in [Method::Dopri5, Method::Sdirk4] { for tol in [1e-4, 1e-6, 1e-8, 1e-10, 1e-11] {
        let r = run(m, &mut Scalar::pendulum(), &adaptive(tol), start);
        println!("pend {m:?} {tol:e} ratio {} {:?}", distance(r.position(), refp.position())/tol, r.statistics());
        let r = run(m, &mut body(), &adaptive(tol), bs);
        println!("body {m:?} {tol:e} ratio {} {} {:?}", distance(r.position(), refb.position())/tol, distance(r.velocity(), refb.velocity())/tol, r.statistics());
    }}
    let _ = (METHODS, Options::default());
}
