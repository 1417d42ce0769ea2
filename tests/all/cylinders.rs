//! Cylinders that touch: gaps and their rates against sampled surfaces and differences, then scenes against closed forms.

use crate::contact_in_motion::{FLOOR, exact, kinds, read, tried};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use stillpoint::contact::geometry::feature::{Boundary, Near};
use stillpoint::contact::geometry::meet::{meeting, pairs};
use stillpoint::contact::geometry::{Core, Solid, touch};
use stillpoint::integrate::Method;

struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(-1.0, 1.0))
    }

    fn pose(&mut self, far: f64) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_scaled_axis(self.vector() * 3.0);
        Isometry3::from_parts(Translation3::from(self.vector() * far), turn)
    }
}

fn cylinder(radius: f64, length: f64) -> Solid {
    Solid::Round(Core::cylinder(radius, length), 0.0)
}

/// Partners of a cylinder.
fn partners() -> Vec<(&'static str, Solid)> {
    vec![
        ("plane", Solid::Plane(Vector3::z())),
        ("ball", Solid::Round(Core::point(), 0.3)),
        ("capsule", Solid::Round(Core::segment(0.8), 0.2)),
        ("box", Solid::Round(Core::cuboid(&Vector3::new(0.5, 0.7, 0.9)), 0.0)),
        ("cylinder", cylinder(0.3, 0.7)),
    ]
}

/// A rigid motion at constant rates: where a pose is after a time.
fn moved(pose: &Isometry3<f64>, velocity: &Vector3<f64>, spin: &Vector3<f64>, time: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(spin * time) * pose.rotation;
    Isometry3::from_parts(Translation3::from(pose.translation.vector + velocity * time), turn)
}

/// First and second rates of every pair of features that counts are those of differences, for bodies that turn and move in any way;
/// its normal and its point move as they are said to.
#[test]
fn rates_of_features_are_differences() {
    let mut random = Random(0x51f1_77aa_02d3);
    let own = Boundary::new(&cylinder(0.4, 0.6));
    for (name, solid) in partners() {
        let (other, mut count) = (Boundary::new(&solid), 0);
        for _ in 0..300 {
            let (a, b) = (random.pose(0.0), random.pose(1.0));
            let velocities = [random.vector(), random.vector()];
            let spins = [random.vector(), random.vector()];
            let at =
                |time: f64| [moved(&a, &velocities[0], &spins[0], time), moved(&b, &velocities[1], &spins[1], time)];
            for swap in [false, true] {
                let order = |x: [Isometry3<f64>; 2]| if swap { [x[1], x[0]] } else { x };
                let flip = |x: [Vector3<f64>; 2]| if swap { [x[1], x[0]] } else { x };
                let shapes = if swap { [&other, &own] } else { [&own, &other] };
                let found = |time: f64, features| {
                    let [p, q] = order(at(time));
                    meeting(&shapes[0].standing(&p), &shapes[1].standing(&q), features, &Near::ALL)
                };
                let [p, q] = order(at(0.0));
                for features in pairs(&shapes[0].standing(&p), &shapes[1].standing(&q)) {
                    let Some(now) = found(0.0, features).filter(|now| now.inside > 0.02 && now.gap > -0.05) else {
                        continue;
                    };
                    let h = 1e-4;
                    let (Some(less), Some(more)) = (found(-h, features), found(h, features)) else { continue };
                    let (vs, ws, places) =
                        (flip(velocities), flip(spins), [p.translation.vector, q.translation.vector]);
                    let arm = |i: usize| now.cores[i] - places[i];
                    let speed = |i: usize| vs[i] + ws[i].cross(&arm(i));
                    let drift = now.drift(places, vs, ws);
                    let rate = now.normal.dot(&(speed(1) - speed(0)));
                    let core = ws[1].cross(&ws[1].cross(&arm(1))) - ws[0].cross(&ws[0].cross(&arm(0)));
                    let second = now.normal.dot(&core) + now.bias(places, vs, ws, &drift);
                    let tilt = now.gap.abs().max(1.0);
                    let differences =
                        [(more.gap - less.gap) / (2.0 * h), (more.gap - 2.0 * now.gap + less.gap) / (h * h)];
                    assert!((rate - differences[0]).abs() < 1e-5 * tilt, "{name} {features:?}: {rate} {differences:?}");
                    // Differences of the second order are known to 1e-16/h² and to h² times the fourth rate.
                    let size = 1.0 + second.abs();
                    assert!(
                        (second - differences[1]).abs() < 1e-3 * size,
                        "{name} {features:?}: {second} {differences:?}"
                    );
                    let turned = (more.normal - less.normal) / (2.0 * h);
                    assert!((drift.normal - turned).norm() < 1e-4 * (1.0 + turned.norm()), "{name} {features:?}");
                    // The point that rates are told for is on the first surface.
                    let on = |m: &stillpoint::contact::geometry::feature::Meeting| m.cores[0] + m.normal * m.radii[0];
                    let point = (on(&more) - on(&less)) / (2.0 * h);
                    assert!(
                        (drift.point - point).norm() < 1e-3 * (1.0 + point.norm()),
                        "{name} {features:?}: {:?} {point:?}",
                        drift.point
                    );
                    count += 1;
                }
            }
        }
        assert!(count > 100, "{name}: {count}");
    }
}

/// How far a solid that is symmetric about its middle goes along a unit vector of its axes (m).
fn support(solid: &Solid, n: &Vector3<f64>) -> f64 {
    let Solid::Round(core, radius) = solid else { panic!("a plane") };
    let corners = core.vertices.iter().map(|v| n.dot(v)).fold(0.0, f64::max);
    corners + radius + core.rim() * n.x.hypot(n.y)
}

/// Wherever a cylinder is pushed into something, a little, one of the pairs of features has that depth and its normal: no way in is
/// open between them. (Depth and normal are those of separating axes.)
#[test]
fn some_features_are_as_deep_as_shapes_are() {
    let mut random = Random(0x3c6e_f372_fe94);
    let own = cylinder(0.4, 0.6);
    let disc = cylinder(0.5, 0.06);
    for (name, solid) in partners().into_iter().skip(1) {
        let mut kinds = std::collections::BTreeSet::new();
        for case in 0..400 {
            let own = if case % 2 == 0 { &own } else { &disc };
            let (a, mut b) = (random.pose(0.0), random.pose(1.0));
            let depth = 1e-5;
            let (mut found, mut slack) = (None, 0.05);
            for _ in 0..200 {
                // Where nothing is near the middles are moved together.
                let towards = (b.translation.vector - a.translation.vector).normalize();
                found = touch(&own.placed(&a), &solid.placed(&b), slack).unwrap();
                let Some(touched) = &found else {
                    b.translation.vector -= towards * 0.04;
                    continue;
                };
                if touched.gap < 0.0 {
                    // Equally good normals are one.
                    slack = 1e-12;
                }
                let step = touched.gap + depth;
                if step.abs() < 1e-12 {
                    break;
                }
                b.translation.vector -= touched.normal * step;
            }
            let touched = found.unwrap_or_else(|| panic!("{name} {case}: nothing is near"));
            assert!((touched.gap + depth).abs() < 1e-9, "{name} {case}: {touched:?}");
            for k in 0..400 {
                // No direction separates them further: around the normal, ever closer.
                let n = touched.normal + random.vector() * 2.0 * 0.96_f64.powi(k);
                let n = n.normalize();
                let apart = n.dot(&(b.translation.vector - a.translation.vector))
                    - support(own, &(a.rotation.inverse() * n))
                    - support(&solid, &(b.rotation.inverse() * n));
                assert!(apart <= touched.gap + 1e-9, "{name} {case}: {apart} along {n}, {touched:?}");
            }
            let (p, q) = (Boundary::new(own), Boundary::new(&solid));
            let (p, q) = (p.standing(&a), q.standing(&b));
            let all: Vec<_> = pairs(&p, &q)
                .into_iter()
                .filter_map(|features| meeting(&p, &q, features, &Near::ALL))
                .filter(|found| found.inside > -1e-7 && found.gap > -0.05 && found.gap < 0.05)
                .collect();
            let fits = |found: &&stillpoint::contact::geometry::feature::Meeting| {
                (found.gap + depth).abs() < 1e-8 && found.normal.dot(&touched.normal) > 1.0 - 1e-8
            };
            // Both are known to round-off, of which two roots of the other search are the larger part.
            let deepest = all.iter().find(fits);
            assert!(deepest.is_some(), "{name} {case}: {touched:?} {all:?}");
            kinds.extend(deepest.map(|found| found.features.map(|feature| format!("{feature:?}"))));
        }
        assert!(kinds.len() > if name == "ball" { 2 } else { 8 }, "{name}: {kinds:?}");
    }
}

/// A ball is as far away as the nearest point of the cylinder is from its middle: on a face, on the side or on a rim.
#[test]
fn balls_touch_faces_sides_and_rims() {
    let mut random = Random(0x7e57_0d1c);
    let (radius, length, size) = (0.4, 0.6, 0.3);
    let (solid, ball) = (cylinder(radius, length), Solid::Round(Core::point(), size));
    for case in 0..200 {
        // Where it touches, and the outward normal there.
        let (angle, part, turn) = (random.within(0.0, 6.2), random.within(0.0, 1.0), random.within(0.0, 1.5));
        let out = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
        let (point, normal) = match case % 3 {
            0 => (out * radius * part + Vector3::z() * 0.5 * length, Vector3::z()),
            1 => (out * radius + Vector3::z() * (part - 0.5) * length, out),
            _ => (out * radius + Vector3::z() * 0.5 * length, out * f64::cos(turn) + Vector3::z() * f64::sin(turn)),
        };
        let (gap, a) = (random.within(-1e-4, 1e-4), random.pose(1.0));
        let b =
            a * Isometry3::from_parts(Translation3::from(point + normal * (size + gap)), UnitQuaternion::identity());
        let found = touch(&solid.placed(&a), &ball.placed(&b), 2e-4).unwrap().expect("they touch");
        assert!((found.gap - gap).abs() < 1e-12, "{case}: {} {gap}", found.gap);
        assert!((found.normal - a.rotation * normal).norm() < 1e-9, "{case}");
        let middle = a * (Translation3::from(point + normal * (0.5 * gap)) * nalgebra::Point3::origin());
        assert!(found.points.len() == 1 && (found.points[0] - middle.coords).norm() < 1e-9, "{case}: {found:?}");
    }
}

/// An edge of a box on a rim: their common normal is across both.
#[test]
fn edges_touch_rims() {
    let mut random = Random(0x0b0e_0f15);
    let (radius, length, edges) = (0.4, 0.6, Vector3::new(0.5, 0.7, 0.9));
    let (solid, cuboid) = (cylinder(radius, length), Solid::Round(Core::cuboid(&edges), 0.0));
    for case in 0..200 {
        let (angle, slope, skew, lean, along) = (
            random.within(0.0, 6.2),
            random.within(0.1, 1.4),
            random.within(0.2, 2.9),
            random.within(-0.6, 0.6),
            random.within(-0.3, 0.3),
        );
        let out = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
        let (point, tangent) = (out * radius + Vector3::z() * 0.5 * length, Vector3::z().cross(&out));
        let normal = out * f64::cos(slope) + Vector3::z() * f64::sin(slope);
        let edge = tangent * f64::cos(skew) + normal.cross(&tangent) * f64::sin(skew);
        // The box stands on that edge, leaning to one side, its z along the edge.
        let side = edge.cross(&normal);
        let diagonal = UnitQuaternion::from_scaled_axis(edge * (lean - std::f64::consts::FRAC_PI_4)) * normal;
        let x = diagonal;
        let y = edge.cross(&x);
        let frame = nalgebra::Matrix3::from_columns(&[x, y, edge]);
        assert!(x.dot(&normal) > 0.05 && y.dot(&normal) > 0.05 && side.norm() > 0.9, "{case}");
        let turn = UnitQuaternion::from_matrix(&frame);
        let middle = point + x * (0.5 * edges.x) + y * (0.5 * edges.y) + edge * along;
        let a = random.pose(1.0);
        let b = a * Isometry3::from_parts(Translation3::from(middle), turn);
        let found = touch(&solid.placed(&a), &cuboid.placed(&b), 1e-6).unwrap().expect("they touch");
        assert!(found.gap.abs() < 1e-12, "{case}: {}", found.gap);
        assert!((found.normal - a.rotation * normal).norm() < 1e-7, "{case}: {} {}", found.normal, a.rotation * normal);
        assert!(found.points.len() == 1, "{case}: {found:?}");
        assert!((found.points[0] - a.transform_point(&point.into()).coords).norm() < 1e-7, "{case}: {found:?}");
    }
}

/// Rims that meet in the middle between face and side part as fast as they met, and what turns them is across the arms from their middles.
#[test]
fn drums_clash_rim_on_rim() {
    let text = std::fs::read_to_string("scenarios/contact/drums_clash.toml").unwrap();
    let summary = exact(&text, 0.4);
    assert_eq!((kinds(&summary), summary.impacts), (vec!["strikes"], 1));
    assert!((summary.events[0].time - 0.1).abs() < 1e-10, "{:?}", summary.events);
    let (radius, length) = (0.2_f64, 0.1_f64);
    let masses = [500.0, 700.0].map(|density| density * std::f64::consts::PI * radius * radius * length);
    // Both arms are as long across the normal, and across the axes.
    let arm = (radius - 0.5 * length) * std::f64::consts::FRAC_1_SQRT_2;
    let about = masses.map(|mass| mass * (3.0 * radius * radius + length * length) / 12.0);
    let push = 2.0 / (0..2).map(|i| 1.0 / masses[i] + arm * arm / about[i]).sum::<f64>();
    let v = &summary.state.velocity;
    for (i, speed) in [1.0 - push / masses[0], push / masses[1]].into_iter().enumerate() {
        assert!((v[6 * i] - speed).abs() < 1e-9, "{i}: {v:?}");
        let spin = (v[6 * i + 3].powi(2) + v[6 * i + 4].powi(2) + v[6 * i + 5].powi(2)).sqrt();
        assert!((spin - push * arm / about[i]).abs() < 1e-9, "{i}: {v:?}");
    }
    assert!(summary.dissipated.abs() < 1e-9, "{}", summary.dissipated);
}

/// Whatever is thrown together with a drum is kept apart from it, by rims, too, and gains no energy.
#[test]
fn drums_are_kept_apart_from_whatever_meets_them() {
    let mut random = Random(0x9b05_688c_2b3e);
    for case in 0..40 {
        let mut size = || random.within(0.05, 0.25);
        let drum = format!("{{ cylinder = [{}, {}] }}", size(), size());
        let other = match case % 4 {
            0 => format!("{{ box = [{}, {}, {}] }}", size(), size(), size()),
            1 => format!("{{ cylinder = [{}, {}] }}", size(), size()),
            2 => format!("{{ capsule = [{}, {}] }}", 0.4 * size(), 2.0 * size()),
            _ => format!("{{ sphere = {} }}", size()),
        };
        let (friction, restitution) = ([0.0, 0.3, 0.8][case % 3], [0.0, 0.4][case % 2]);
        let mut text = FLOOR.to_owned();
        for (k, (name, shape)) in [("drum", drum), ("other", other)].into_iter().enumerate() {
            let turn = random.pose(0.0).rotation;
            let spin = random.vector() * 4.0;
            text += &format!(
                "[[body]]\nname = \"{name}\"\ndensity = 1000\nshape = {shape}\nhinge = {{ type = \"free\", position = [0, 0, {:?}, {:?}, {:?}, {:?}, {:?}], velocity = [0, 0, 0, {:?}, {:?}, {:?}] }}\n",
                0.35 + 0.6 * k as f64,
                turn.w,
                turn.i,
                turn.j,
                turn.k,
                spin.x,
                spin.y,
                spin.z
            );
        }
        text += &format!("[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = {friction}\nrestitution = {restitution}\n");
        let summary = tried(&read(&text), 0.7, 1e-8, Method::Dop853)
            .unwrap_or_else(|error| panic!("case {case}: {error}\n{text}"));
        // Captured steps compare to 2 % at most, and what is moved apart comes from nowhere.
        assert!(
            summary.dissipated > 0.0 && summary.energy_drift < 1e-2 * summary.energy_largest,
            "case {case}: {summary:?}\n{text}"
        );
    }
}

/// A lying log falls onto the rim of a standing drum that runs along it where they meet, or nearly: it strikes where its side comes to the
/// rim, `z = h + √(r² − (x cos ψ − R)²)`.
#[test]
fn logs_strike_rims_that_run_along_them() {
    for (x, yaw) in [(0.22, 0.0), (0.22, 0.01), (0.22, -0.01), (0.245, 0.1), (0.205, 1e-7), (0.22, 0.2)] {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let text = format!(
            "[[body]]\nname = \"rock\"\nshape = {{ cylinder = [0.2, 0.2] }}\nhinge = {{ type = \"fixed\" }}\n\
             [[body]]\nname = \"log\"\ndensity = 1000\nshape = {{ cylinder = [0.05, 0.2] }}\nhinge = {{ type = \"free\", \
             position = [{x:?}, 0, 0.25, {:?}, {:?}, {:?}, {:?}] }}\n[[contact]]\nbetween = [\"rock\", \"log\"]\nfriction = 0.3\n",
            turn.w, turn.i, turn.j, turn.k
        );
        let summary =
            tried(&read(&text), 0.2, 1e-9, Method::Dop853).unwrap_or_else(|error| panic!("{x} {yaw}: {error}"));
        let beside = x * f64::cos(yaw) - 0.2;
        let height = 0.1 + (0.05 * 0.05 - beside * beside).sqrt();
        let struck = summary.events.iter().find(|event| event.kind.name() == "strikes").expect("a strike");
        assert!((struck.time - (2.0 * (0.25 - height) / 9.80665).sqrt()).abs() < 1e-8, "{x} {yaw}: {}", struck.time);
        assert!(summary.energy_drift < 1e-6 * summary.energy_largest, "{x} {yaw}: {}", summary.energy_drift);
    }
}

/// A log rolls, or slides, over the top of a drum and off its rim, which runs along it: it goes about the rim and falls, and keeps its energy.
#[test]
fn logs_go_over_rims_that_run_along_them() {
    for friction in [0.0, 1.0] {
        let text = format!(
            "[[body]]\nname = \"rock\"\nshape = {{ cylinder = [0.2, 0.2] }}\nhinge = {{ type = \"fixed\" }}\n\
             [[body]]\nname = \"log\"\ndensity = 1000\nshape = {{ cylinder = [0.05, 0.2] }}\nhinge = {{ type = \"free\", \
             position = [0.19, 0, 0.15, 0.7071067811865476, 0.7071067811865475, 0, 0], velocity = [0.3, 0, 0, 0, 0, 0] }}\n\
             [[contact]]\nbetween = [\"rock\", \"log\"]\nfriction = {friction:?}\n"
        );
        let summary =
            tried(&read(&text), 0.4, 1e-8, Method::Dop853).unwrap_or_else(|error| panic!("{friction}: {error}"));
        assert!(summary.state.position[2] < 0.0, "{friction}: {:?}", summary.state.position);
        assert!(summary.energy_drift < 1e-5 * summary.energy_largest, "{friction}: {}", summary.energy_drift);
    }
}
