//! Meshes that touch: their convex parts.

use crate::common::{Random, answered};
use nalgebra::Vector3;
use std::path::PathBuf;
use std::sync::Arc;
use stillpoint::contact::support::Verdict;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{Scenario, load};
use stillpoint::simulate::{self, Integrator, Settings, Start, State, run};
use stillpoint::statics::standing::StandingReport;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    }
}

/// The twelve triangles of a box about its middle.
fn cuboid(middle: Vector3<f64>, edges: Vector3<f64>) -> Vec<[Vector3<f64>; 3]> {
    let corner = |i: usize| {
        middle + Vector3::from_fn(|axis, _| if i >> axis & 1 == 1 { 0.5 * edges[axis] } else { -0.5 * edges[axis] })
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]].map(|face| face.map(corner))).collect()
}

fn stl(triangles: &[[Vector3<f64>; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        corners.iter().flatten().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn scene(shape: &str, at: [f64; 3], velocity: [f64; 6], friction: f64) -> String {
    format!(
        "[statics]\nmargin = [\"tilt\"]\n[[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \
         \"part\"\nmass = 2.0\ninertia = [0.02, 0.03, 0.04]\nshape = {shape}\nhinge = {{ type = \"free\", position = [{:?}, {:?}, {:?}, 1, 0, 0, 0], \
         velocity = {velocity:?} }}\n[[contact]]\nbetween = [\"floor\", \"part\"]\nfriction = {friction:?}\n",
        at[0], at[1], at[2]
    )
}

fn read(folder: &Folder, text: &str) -> (Scenario, Arc<Model>) {
    let scenario = load(&folder.write("scene.toml", text)).unwrap_or_else(|error| panic!("{error}"));
    let model = Model::build(&scenario.description).unwrap();
    (scenario, model)
}

fn stands((scenario, model): (Scenario, Arc<Model>)) -> StandingReport {
    let held = answered(&scenario, model).unwrap();
    *held.found.standing.unwrap()
}

fn end(model: &Arc<Model>, duration: f64) -> Vec<f64> {
    let settings = Settings {
        start: Start::Given,
        duration,
        tolerance: 1e-10,
        absolute_tolerance: 1e-10,
        integrator: Integrator::Method(Method::Dop853),
        ..Settings::default()
    };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let found = run(model, &settings, 1.0, &start, &mut memory, &mut |_, _| true);
    found.unwrap_or_else(|error| panic!("{error}")).state.position
}

/// The mesh of a box stands and moves as the box does.
#[test]
fn a_box_and_its_mesh_are_one_solid() {
    let (folder, mut random) = (Folder::new(), Random::new(0x3e54));
    for case in 0..12 {
        // What single precision holds.
        let edges = Vector3::from_fn(|_, _| random.between(0.1, 0.4)).map(|edge| f64::from(edge as f32));
        folder.write("box.stl", stl(&cuboid(Vector3::zeros(), edges)));
        let at = [0.1, -0.2, 0.5 * edges.z];
        let shape = format!("{{ box = [{:?}, {:?}, {:?}] }}", edges.x, edges.y, edges.z);
        let [plain, mesh] = [shape.as_str(), "{ mesh = \"box.stl\" }"]
            .map(|shape| stands(read(&folder, &scene(shape, at, [0.0; 6], 0.7))));
        assert_eq!((plain.verdict, mesh.verdict), (Verdict::Stands, Verdict::Stands));
        for ((name, one, _), (_, other, _)) in plain.margins.tilt.iter().zip(&mesh.margins.tilt) {
            assert!((one - other).abs() < 1e-6, "case {case}: {name} {one} {other}");
        }
        let velocity = [random.between(0.1, 0.5), random.between(-0.5, 0.5), 0.0, 0.0, 0.0, 0.0];
        let [plain, mesh] = [shape.as_str(), "{ mesh = \"box.stl\" }"]
            .map(|shape| end(&read(&folder, &scene(shape, at, velocity, 0.3)).1, 0.5));
        let off = plain.iter().zip(&mesh).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-8, "case {case}: {off:e}");
    }
}

/// A table of five boxes in one file: it tips over the line between two of its feet.
#[test]
fn a_table_tips_over_its_feet() {
    let (folder, mut random) = (Folder::new(), Random::new(0x7ab1e));
    for case in 0..12 {
        let (half, high) = (random.between(0.2, 0.4), random.between(0.5, 0.8));
        let foot = 0.05;
        let mut triangles = cuboid(Vector3::new(0.0, 0.0, high), Vector3::new(2.0 * half, 2.0 * half, 0.04));
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let middle = Vector3::new(x * (half - 0.5 * foot), y * (half - 0.5 * foot), 0.4 * high);
            triangles.extend(cuboid(middle, Vector3::new(foot, foot, 0.8 * high)));
        }
        folder.write("table.stl", stl(&triangles));
        let text = scene("{ mesh = \"table.stl\" }", [0.0; 3], [0.0; 6], 5.0);
        let text = text.replace("mass = 2.0", &format!("mass = 2.0\ncenter = [0, 0, {high:?}]"));
        let found = stands(read(&folder, &text));
        assert_eq!((found.verdict, found.contacts.len()), (Verdict::Stands, 16), "case {case}");
        // The hinge's frame is the body's: tilting pushes at the centre of mass.
        for (name, tilt, _) in &found.margins.tilt {
            assert!((tilt - half / high).abs() < 1e-5, "case {case}: {name} {tilt} {}", half / high);
        }
    }
}

/// A dented mesh is refused with how much of its hull it fills; its hull touches if that is asked for.
#[test]
fn dented_meshes_are_refused_or_taken_as_their_hull() {
    let folder = Folder::new();
    let mut triangles = cuboid(Vector3::zeros(), Vector3::repeat(0.2));
    let pit = Vector3::new(0.0, 0.0, 0.02);
    let top = triangles.split_off(10);
    let rim = [top[0][0], top[0][1], top[0][2], top[1][2]];
    (0..4).for_each(|i| triangles.push([rim[i], rim[(i + 1) % 4], pit]));
    folder.write("pit.stl", stl(&triangles));
    let dented = scene("{ mesh = \"pit.stl\" }", [0.0, 0.0, 0.1], [0.0; 6], 0.5);
    let error = load(&folder.write("scene.toml", &dented)).unwrap_err().to_string();
    assert!(error.contains("not made of convex parts") && error.contains("hull = true"), "{error}");
    let hull = scene("{ mesh = \"pit.stl\", hull = true }", [0.0, 0.0, 0.1], [0.0; 6], 0.5);
    assert_eq!(stands(read(&folder, &hull)).verdict, Verdict::Stands);
    folder.write("open.stl", stl(&triangles[1..]));
    let open = scene("{ mesh = \"open.stl\" }", [0.0, 0.0, 0.1], [0.0; 6], 0.5);
    let error = load(&folder.write("scene.toml", &open)).unwrap_err().to_string();
    assert!(error.contains("not closed"), "{error}");
}
