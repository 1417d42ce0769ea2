//! Contact that can be seen: collapses as recordings, forces in pictures and tables.

use super::Bench;
use crate::common::Random;
use nalgebra::{Point3, Vector3};
use stillpoint::record::Recording;

const G: f64 = 9.80665;

/// A box of these edges on a floor, gravity turned by a slope (rad) about y, moving with `speed` along x.
fn on_a_floor(edges: [f64; 3], friction: f64, slope: f64, speed: f64) -> String {
    format!(
        "gravity = [{:?}, 0, {:?}]\n[simulate]\nstart = \"given\"\nduration = 1.0\n[[body]]\nname = \"floor\"\n\
         shape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"box\"\ndensity = 500\n\
         shape = {{ box = {edges:?} }}\nhinge = {{ type = \"free\", position = [0, 0, {:?}, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
         [[contact]]\nbetween = [\"floor\", \"box\"]\nfriction = {friction:?}\n",
        G * slope.sin(),
        -G * slope.cos(),
        0.5 * edges[2]
    )
}

#[test]
fn a_box_that_tips_turns_about_its_lower_edge_in_the_recording_of_its_collapse() {
    let bench = Bench::new();
    let mut random = Random::new(0xc0_11a5e);
    for _ in 0..8 {
        let edges = [random.between(0.1, 0.3), random.between(0.2, 0.6), random.between(0.5, 0.9)];
        // Beyond tipping, far from sliding.
        let slope = (edges[0] / edges[2]).atan() + random.between(0.02, 0.2);
        bench.write("scene.toml", on_a_floor(edges, 3.0, slope, 0.0));
        let answer = bench.call(&["statics", "scene.toml", "--collapse", "fall.mcap"]).code(1);
        assert!(answer.out.contains("two seconds: `box` lifts off `floor`"), "{}", answer.out);
        let recording = Recording::open(&bench.path().join("fall.mcap")).expect("a recording");
        let samples: Vec<_> = recording.samples().unwrap().map(|sample| sample.expect("a sample")).collect();
        assert_eq!(samples.len(), 101);
        let body = samples[0].bodies.len() - 1;
        let corner = Point3::new(0.5 * edges[0], 0.5 * edges[1], -0.5 * edges[2]);
        let place = |k: usize| samples[k].bodies[body] * corner;
        let angle = |k: usize| samples[k].bodies[body].rotation.angle();
        let reach = Vector3::from(edges).norm();
        for k in 0..samples.len() {
            // The motion is that of the first instant, carried on: the edge stays to second order.
            let away = (place(k) - place(0)).norm();
            assert!(away <= 0.6 * angle(k).powi(2) * reach + 1e-9, "{k}: {away} at {} rad", angle(k));
            assert!(k == 0 || angle(k) > angle(k - 1), "ever further");
        }
        let turned = samples[100].bodies[body].rotation.scaled_axis();
        assert!(turned.y > 0.05 && turned.x.abs() < 1e-6 && turned.z.abs() < 1e-6, "{turned}");
    }
}

#[test]
fn what_needs_no_friction_has_no_collapse_to_record() {
    let bench = Bench::new();
    bench.write("scene.toml", on_a_floor([0.2; 3], 0.5, 0.0, 0.0));
    let answer = bench.call(&["statics", "scene.toml", "--collapse", "fall.mcap"]).code(0);
    assert!(answer.err.contains("no collapse to record in `fall.mcap`: no friction has to hold it"), "{}", answer.err);
    assert!(!bench.path().join("fall.mcap").exists());
}

/// Rows of a table in CSV without quotes: headings, then numbers.
fn table(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let heads = lines.next().expect("headings").split(',').map(str::to_owned).collect();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
    (heads, lines.map(row).collect())
}

#[test]
fn exported_contacts_obey_coulombs_law() {
    let bench = Bench::new();
    let mut random = Random::new(0x000e_4702);
    for _ in 0..4 {
        let (friction, speed) = (random.between(0.2, 0.6), random.between(0.5, 1.5));
        bench.write("scene.toml", on_a_floor([0.4, 0.3, 0.1], friction, 0.0, speed));
        bench.call(&["run", "scene.toml", "--out", "run.mcap", "--quiet"]).code(0);
        bench.call(&["export", "run.mcap", "--csv", "contacts.csv", "--channel", "contacts", "--quiet"]).code(0);
        let text = std::fs::read_to_string(bench.path().join("contacts.csv")).expect("a table");
        let (heads, rows) = table(&text);
        let at =
            |end: &str| heads.iter().position(|head| head.contains(end)).unwrap_or_else(|| panic!("{end}: {heads:?}"));
        let weight = 500.0 * 0.4 * 0.3 * 0.1 * G;
        let (x, z, points, slipping) = (at("box on floor.force.x"), at("force.z"), at("points"), at("slipping"));
        let stops = speed / (friction * G);
        let mut slid = 0;
        for row in &rows {
            assert!((row[z] - weight).abs() < 1e-8 * weight && row[points] >= 3.0, "{row:?}");
            if row[0] < stops - 1e-6 {
                assert!((row[x] + friction * weight).abs() < 1e-8 * weight && row[slipping] == row[points], "{row:?}");
                slid += 1;
            } else if row[0] > stops + 1e-6 {
                assert!(row[x].abs() < 1e-8 * weight && row[slipping] == 0.0, "{row:?}");
            }
        }
        assert!(slid > 5 && slid < rows.len(), "{slid} of {}", rows.len());
        // A picture of it has an arrow for every point more.
        let parts = |more: &[&str]| {
            let call = [&["picture", "run.mcap", "--json", "-o", "run.svg"][..], more].concat();
            bench.call(&call).code(0).json()["parts"].as_u64().expect("a number")
        };
        assert_eq!(parts(&["--contacts"]), parts(&[]) + rows[0][points] as u64);
    }
}
