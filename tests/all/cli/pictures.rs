//! Pictures, films, glTF files, reports and watching: what is written for other programs and people, read by independent readers.

use super::{Answer, Bench, shipped};
use crate::common::Random;
use gltf::animation::Property;
use gltf::animation::util::ReadOutputs;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};
use stillpoint::record::Recording;

/// A scene of bodies with every shape on every hinge, springs, ropes, loads and bushings.
fn random_scene(seed: u64) -> String {
    let random = &mut Random::new(seed);
    let mut text = "[simulate]\nstart = \"given\"\nduration = 0.2\n\n[record]\nrate = 50.0\n".to_owned();
    let size = 10f64.powf(random.between(-2.0, 2.0));
    let point = |random: &mut Random| {
        let [x, y, z] = random.vector(size).into();
        format!("[{x:.6}, {y:.6}, {z:.6}]")
    };
    let count = 1 + random.below(7);
    for body in 0..count {
        let hinge = ["revolute", "prismatic", "spherical", "universal", "free", "cylindrical"][random.below(6)];
        let parent = match random.below(body + 1) {
            0 => "ground".to_owned(),
            k => format!("b{}", k - 1),
        };
        let axis = match hinge {
            "revolute" | "prismatic" | "cylindrical" => ", axis = [0.0, 0.6, 0.8]",
            "universal" => ", axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]",
            _ => "",
        };
        let [a, b, c] = [0; 3].map(|_| random.between(0.05, 0.5) * size);
        let shape = match random.below(6) {
            0 => String::new(),
            1 => format!("shape = {{ box = [{a}, {b}, {c}] }}\n"),
            2 => format!("shape = {{ sphere = {a}, at = {} }}\n", point(random)),
            3 => format!("shape = {{ cylinder = [{a}, {b}], rpy = [0.3, 0.2, 0.1] }}\n"),
            4 => format!("shape = {{ capsule = [{a}, {b}], color = [0.2, 0.5, 0.9, 0.4] }}\n"),
            _ => format!("markers = {{ tip = {} }}\n", point(random)),
        };
        let inertia = 0.1 * size * size;
        let _ = write!(
            text,
            "\n[[body]]\nname = \"b{body}\"\nmass = 1.0\ninertia = [{inertia}, {inertia}, {inertia}]\n{shape}\
             hinge = {{ type = \"{hinge}\", parent = \"{parent}\", at = {}{axis} }}\n",
            point(random)
        );
    }
    for (kind, more) in [("spring", "stiffness = 5.0\nlength = 0.5\n"), ("rope", "stiffness = 5.0\nlength = 0.5\n")] {
        let ends = format!(
            "[{{ body = \"b{}\", at = {} }}, {{ body = \"ground\", at = {} }}]",
            random.below(count),
            point(random),
            point(random)
        );
        let key = if kind == "rope" { "through" } else { "between" };
        let _ = write!(text, "\n[[force]]\nname = \"{kind}\"\ntype = \"{kind}\"\n{key} = {ends}\n{more}");
    }
    let turns = ["body", "inertial"][random.below(2)];
    let _ = write!(
        text,
        "\n[[force]]\ntype = \"load\"\non = {{ body = \"b0\", at = {} }}\nforce = [1.0, 2.0, 0.0]\ntorque = [0.0, 0.0, 0.1]\naxes = \"{turns}\"\n",
        point(random)
    );
    let mount = format!(
        "{{ body = \"ground\", at = {} }}, {{ body = \"b{}\", at = {} }}",
        point(random),
        random.below(count),
        point(random)
    );
    let _ = write!(
        text,
        "\n[[force]]\nname = \"mount\"\ntype = \"bushing\"\nbetween = [{mount}]\nrpy = [0.1, 0.2, 0.3]\nstiffness = [1, 2, 3, 0, 0, 0]\n"
    );
    text
}

/// A folder with the recording `run.mcap` of a random scene.
fn recorded(seed: u64) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", random_scene(seed));
    bench.call(&["run", "scene.toml", "--out", "run.mcap", "--quiet"]).code(0);
    bench
}

fn read(bench: &Bench, name: &str) -> String {
    std::fs::read_to_string(bench.path().join(name)).expect("text")
}

/// Every point of the paths of an SVG.
fn points(svg: &str) -> Vec<[f64; 2]> {
    let document = roxmltree::Document::parse(svg).expect("XML");
    let paths = document.descendants().filter_map(|node| node.attribute("d"));
    let strokes = paths.flat_map(|path| path.split(['M', 'L', 'Z'])).filter(|stroke| !stroke.is_empty());
    let point = |stroke: &str| {
        let (x, y) = stroke.split_once(' ')?;
        Some([x.parse().ok()?, y.parse().ok()?])
    };
    strokes.filter_map(point).collect()
}

#[test]
fn pictures_of_random_scenes_hold_all_that_is_drawn() {
    for seed in 0..40 {
        let bench = recorded(seed);
        let camera = ["auto", "front", "back", "left", "right", "top", "iso", "-130,-20"][seed as usize % 8];
        let call =
            ["picture", "run.mcap", "-o", "run.svg", "--camera", camera, "--loads", "--hinges", "--size", "640x480"];
        let answer = bench.call(&[&call[..], &["--reactions", "--at", "0.1"]].concat()).code(0);
        assert!(answer.out.starts_with("run.svg: at 0.1 s"), "{answer:#?}");
        let svg = read(&bench, "run.svg");
        let points = points(&svg);
        assert!(points.len() > 12, "seed {seed}: nothing is drawn: {svg}");
        for [x, y] in points {
            assert!((0.0..=640.0).contains(&x) && (0.0..=480.0).contains(&y), "seed {seed}: {x}, {y}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "seed {seed}");
    }
}

/// Elements of beams have more coordinates than any hinge: what is recorded of them can be read.
#[test]
fn recordings_of_beams_with_all_strains_are_read() {
    let bench = Bench::new();
    let scene = shipped("beams/bathe_bend");
    let all = ["--set", "simulate.duration=0.05", "--set", "arc.degree=2", "--out", "run.mcap", "--quiet"];
    bench.call(&[&["run", &scene][..], &all].concat()).code(0);
    bench.call(&["picture", "run.mcap", "-o", "a.svg", "--at", "0.03"]).code(0);
    bench.call(&["export", "run.mcap", "--csv", "run.csv"]).code(0);
}

/// A stage has two samples at one time: pictures after it are of their own instant, and times of a film increase. What flies away
/// need not be framed.
#[test]
fn pictures_go_on_after_a_stage() {
    let bench = Bench::new();
    bench.call(&["run", &shipped("stages/trapdoor"), "--out", "run.mcap", "--quiet"]).code(0);
    let recording = Recording::open(&bench.path().join("run.mcap")).expect("a recording");
    let times: Vec<f64> = recording.samples().expect("samples").map(|sample| sample.expect("a sample").time).collect();
    assert!(times.windows(2).any(|pair| pair[0] == pair[1]), "no stage");
    for at in [0.2, 0.77, times[times.len() - 1]] {
        let answer = bench.call(&["picture", "run.mcap", "-o", "a.svg", "--at", &at.to_string(), "--json"]).code(0);
        let shown = answer.json()["time"].as_f64().expect("a time");
        let nearest = times.iter().map(|time| (time - at).abs()).fold(f64::INFINITY, f64::min);
        assert!((shown - at).abs() <= nearest, "{shown} s in place of {at} s");
    }
    bench.call(&["view", "run.mcap", "--save", "run.glb"]).code(0);
    let bytes = std::fs::read(bench.path().join("run.glb")).expect("a file");
    let file = gltf::Gltf::from_slice(&bytes).expect("glTF");
    for animation in file.animations() {
        for (name, _, times, _) in keys(&animation, file.blob.as_deref().expect("a blob")) {
            assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{name}: times that do not increase");
        }
    }

    let scale = |more: &[&str]| {
        bench.call(&[&["picture", "run.mcap", "-o", "a.svg", "--at", "0.9"], more].concat()).code(0);
        std::fs::read_to_string(bench.path().join("a.svg")).expect("a picture")
    };
    assert_ne!(scale(&[]), scale(&["--around", "flap"]));
    let wrong = bench.call(&["picture", "run.mcap", "-o", "a.svg", "--around", "flapp"]).code(2);
    assert!(wrong.err.contains("did you mean `flap`"), "{wrong:#?}");
}

#[test]
fn a_picture_is_asked_for_in_words_that_are_checked() {
    let bench = recorded(1);
    for (arguments, said) in [
        (&["-o", "x.jpg"][..], "ends in .svg, .png or .pdf"),
        (&["-o", "x.svg", "--camera", "above"], "is no camera"),
        (&["-o", "x.svg", "--camera", "10,100"], "is no camera"),
        (&["-o", "x.svg", "--size", "10x10"], "is no size"),
        (&["-o", "x.svg", "--at", "nan"], "is no time"),
        (&["-o", "run.mcap"], "ends in .svg, .png or .pdf"),
    ] {
        let answer = bench.call(&[&["picture", "run.mcap"][..], arguments].concat()).code(2);
        assert!(answer.err.contains(said), "{arguments:?}: {answer:#?}");
    }
    assert_eq!(bench.names(), ["run.mcap", "scene.toml"]);
}

#[cfg(feature = "picture")]
#[test]
fn png_gif_and_svg_show_the_same_size() {
    let bench = recorded(2);
    bench.call(&["picture", "run.mcap", "-o", "run.png", "--size", "300x200"]).code(0);
    let png = std::fs::read(bench.path().join("run.png")).expect("a picture");
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    assert_eq!(&png[16..24], [0, 0, 1, 44, 0, 0, 0, 200]);
    let answer = bench.call(&["video", "run.mcap", "-o", "run.gif", "--size", "300x200", "--rate", "10"]).code(0);
    assert!(answer.out.starts_with("run.gif: 3 pictures, 10 per second"), "{answer:#?}");
    let film = std::fs::read(bench.path().join("run.gif")).expect("a film");
    assert_eq!((&film[..6], &film[6..10]), (&b"GIF89a"[..], &[44, 1, 200, 0][..]));
}

/// Times (s) and numbers of each animated property, by name of node.
type Keys = Vec<(String, Property, Vec<f32>, Vec<f32>)>;

fn keys(animation: &gltf::Animation, blob: &[u8]) -> Keys {
    let channel = |channel: gltf::animation::Channel| {
        let reader = channel.reader(|_| Some(blob));
        let times = reader.read_inputs().expect("times").collect();
        let values = match reader.read_outputs().expect("numbers") {
            ReadOutputs::Translations(list) => list.flatten().collect(),
            ReadOutputs::Rotations(list) => list.into_f32().flatten().collect(),
            ReadOutputs::Scales(list) => list.flatten().collect(),
            ReadOutputs::MorphTargetWeights(_) => panic!("nothing is morphed"),
        };
        (channel.target().node().name().expect("a name").to_owned(), channel.target().property(), times, values)
    };
    animation.channels().map(channel).collect()
}

/// Read by another library, every body is at every key where the recording has it, with y up instead of z.
#[test]
fn gltf_of_random_scenes_moves_as_the_recording() {
    let mut compared = 0;
    for seed in 0..40 {
        let bench = recorded(seed);
        bench.call(&["view", "run.mcap", "--save", "run.glb", "--quiet"]).code(0);
        let bytes = std::fs::read(bench.path().join("run.glb")).expect("a file");
        let file = gltf::Gltf::from_slice(&bytes).expect("glTF");
        let blob = file.blob.as_deref().expect("numbers");
        let animations: Vec<gltf::Animation> = file.animations().collect();
        let keys = animations.first().map_or(Vec::new(), |animation| keys(animation, blob));
        let recording = Recording::open(&bench.path().join("run.mcap")).expect("a recording");
        let samples: Vec<_> = recording.samples().expect("samples").map(|sample| sample.expect("a sample")).collect();
        let root = file.scenes().next().expect("a scene").nodes().next().expect("a root");
        for (index, body) in recording.scene.bodies.iter().enumerate() {
            let Some(node) = root.children().find(|node| node.name() == Some(&body.name) && node.mesh().is_none())
            else {
                continue;
            };
            let (at, turn, _) = node.transform().decomposed();
            let of = |property: Property| keys.iter().find(|(name, kind, ..)| *name == body.name && *kind == property);
            for (k, sample) in samples.iter().enumerate() {
                let at = of(Property::Translation).map_or(&at[..], |(.., values)| &values[3 * k..3 * k + 3]);
                let turn = of(Property::Rotation).map_or(&turn[..], |(.., values)| &values[4 * k..4 * k + 4]);
                let turn = Quaternion::new(turn[3], turn[0], turn[1], turn[2]).cast::<f64>();
                let pose = Isometry3::from_parts(
                    Translation3::new(f64::from(at[0]), f64::from(at[1]), f64::from(at[2])),
                    UnitQuaternion::from_quaternion(turn),
                );
                let far = sample.bodies[index].translation.vector.norm().max(1.0);
                for point in [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 1.0)] {
                    let apart = (pose * point - sample.bodies[index] * point).norm();
                    // Single precision of the place, and of a turn.
                    assert!(apart <= 4e-6 * far, "seed {seed}, {} at {} s: {apart}", body.name, sample.time);
                    compared += 1;
                }
            }
            if let Some((_, _, times, _)) = of(Property::Translation) {
                let apart = times.iter().zip(&samples).map(|(t, sample)| (f64::from(*t) - sample.time).abs());
                assert!(times.len() == samples.len() && apart.fold(0.0, f64::max) < 1e-6);
            }
        }
        let up = UnitQuaternion::from_quaternion(Quaternion::from(root.transform().decomposed().1).cast::<f64>());
        assert!((up * Vector3::z() - Vector3::y()).norm() < 1e-6, "z is not up");
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn modes_are_animations_with_their_frequencies() {
    let bench = Bench::new();
    let scene = shipped("double_wishbone");
    let statics = bench.call(&["statics", &scene, "--modes", "modes.mcap", "--json"]).code(0).json();
    bench.call(&["view", "modes.mcap", "--save", "modes.glb"]).code(0);
    let bytes = std::fs::read(bench.path().join("modes.glb")).expect("a file");
    let file = gltf::Gltf::from_slice(&bytes).expect("glTF");
    let names: Vec<String> = file.animations().map(|one| one.name().expect("a name").to_owned()).collect();
    let hertz = statics["frequencies_hz"].as_array().expect("frequencies");
    assert_eq!(names.len(), hertz.len());
    for (k, (name, hz)) in names.iter().zip(hertz).enumerate() {
        assert_eq!(*name, format!("mode {}: {:.4} Hz", k + 1, hz.as_f64().expect("a number")));
    }
}

#[test]
#[ignore = "needs Node with the packages of tests/javascript"]
fn the_validator_of_khronos_finds_nothing() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/javascript/validate_gltf.js");
    for seed in 0..12 {
        let bench = recorded(seed);
        bench.call(&["view", "run.mcap", "--save", "run.glb", "--quiet"]).code(0);
        let answer = Answer::of(assert_cmd::Command::new("node").arg(script).arg(bench.path().join("run.glb"))).code(0);
        assert_eq!(answer.json()["messages"], serde_json::json!([]), "seed {seed}: {answer:#?}");
    }
}

/// What stands between two marks.
fn between<'t>(text: &'t str, begin: &str, end: &str) -> &'t str {
    let (_, rest) = text.split_once(begin).unwrap_or_else(|| panic!("no {begin}"));
    rest.split_once(end).unwrap_or_else(|| panic!("no {end}")).0
}

#[test]
fn a_report_allows_its_own_script_alone_and_fetches_nothing() {
    use base64::Engine;
    use sha2::Digest;
    let bench = Bench::new();
    let hostile = "</script><img src=x onerror=alert(1)>";
    let scene = format!(
        "title = \"{hostile}\"\n\n[[body]]\nname = \"{hostile}\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
         center = [0.0, 0.0, -1.0]\nhinge = {{ type = \"revolute\", axis = [0.0, 1.0, 0.0], position = 0.3 }}\n\n\
         [simulate]\nstart = \"given\"\nduration = 0.1\n"
    );
    bench.write("scene.toml", scene);
    bench.call(&["report", "scene.toml", "-o", "page.html"]).code(0);
    let page = read(&bench, "page.html");
    assert!(!page.contains("<img"), "a name became markup");
    let policy = between(&page, "Content-Security-Policy\" content=\"", "\"");
    assert!(
        policy.starts_with("default-src 'none';") && !policy.contains("unsafe") && !policy.contains("http"),
        "{policy}"
    );
    let hash = |text: &str| base64::engine::general_purpose::STANDARD.encode(sha2::Sha256::digest(text.as_bytes()));
    assert!(policy.contains(&hash(between(&page, "\n<script>", "</script>"))), "{policy}");
    assert!(policy.contains(&hash(between(&page, "<style>", "</style>"))), "{policy}");
    let addresses = page.matches("://").count() - page.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(addresses, 0, "the page names an address");
}

#[test]
fn reports_say_the_verdict_and_stay_small() {
    let bench = Bench::new();
    let call = |arguments: &[&str]| bench.call(arguments);
    let wishbone = shipped("double_wishbone");
    let rate = ["--set", "simulate.duration=4", "--set", "record.rate=250"];
    let answer = call(&[&["report", &wishbone, "-o", "a.html", "--verify"][..], &rate].concat()).code(0);
    assert!(answer.out.starts_with("a.html: Stable equilibrium; simulated 4 s"), "{answer:#?}");
    let page = read(&bench, "a.html");
    assert!(page.len() < 2_000_000, "{} bytes for 1001 samples", page.len());
    for part in
        ["Modes with damping", "Reactions of the hinges", "Energy ledger", "estimated by a second", "Double wishbone"]
    {
        assert!(page.contains(part), "no {part}");
    }
    // Of a recording the same, but for what only a scenario has.
    call(&["run", &wishbone, "--out", "run.mcap", "--quiet"]).code(0);
    call(&["report", "run.mcap", "-o", "b.html"]).code(0);
    let page = read(&bench, "b.html");
    assert!(page.contains("Stable equilibrium; simulated") && !page.contains("modes do not play"));
    // What was set beside the scenario is not recorded, and its modes are not those that the scenario leads to.
    call(&["run", &wishbone, "--set", "gravity=[0, 0, -5]", "--out", "other.mcap", "--quiet"]).code(0);
    call(&["report", "other.mcap", "-o", "other.html"]).code(0);
    assert!(read(&bench, "other.html").contains("modes do not play"));
    // No equilibrium is said, and is the answer no.
    bench.write("brick.toml", super::BRICK);
    let answer = call(&["report", "brick.toml", "-o", "c.html", "--json"]).code(1).json();
    assert_eq!((&answer["verdict"], &answer["fine"]), (&"No equilibrium was found".into(), &false.into()));
    assert!(read(&bench, "c.html").contains("class=\"verdict wrong\""));
    assert!(call(&["report", "run.mcap", "--verify", "-o", "d.html"]).code(2).err.contains("for scenarios"));
}

/// The page as a browser without a network shows it.
fn shown(page: &Path) -> String {
    let mut browser = assert_cmd::Command::new("chromium");
    browser.args(["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]);
    browser.args(["--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=4000", "--dump-dom"]);
    browser.arg(format!("file://{}", page.display()));
    String::from_utf8_lossy(&browser.output().expect("the browser").stdout).into_owned()
}

#[test]
#[ignore = "needs chromium"]
fn a_browser_without_a_network_draws_the_report() {
    let bench = Bench::new();
    let wishbone = shipped("double_wishbone");
    bench.call(&["report", &wishbone, "-o", "page.html"]).code(0);
    bench.call(&["run", &wishbone, "--out", "run.mcap", "--quiet"]).code(0);
    bench.call(&["report", "run.mcap", "-o", "recorded.html"]).code(0);
    for page in ["page.html", "recorded.html"] {
        let page = shown(&bench.path().join(page));
        assert!(page.contains("data-shown=\"yes\""), "the script did not reach its end");
        assert!(page.contains("<option value=\"1\">mode 1: 0.8294 Hz</option>"), "no modes to play");
    }
}

#[test]
#[ignore = "needs Node"]
fn pages_unpack_what_zlib_packs() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let script = root.join("tests/javascript/unpack.js");
    let page = root.join("src/cli/report/viewer.js");
    let answer = Answer::of(assert_cmd::Command::new("node").arg(script).arg(page)).code(0);
    assert!(answer.out.contains("240 cases"), "{}", answer.out);
}

/// The boom has its modes in the page, too: twelve that play, of 92 bodies and rings.
#[test]
fn a_report_of_a_boom_is_as_small_as_a_letter() {
    let bench = Bench::new();
    bench.call(&["report", &shipped("beams/crane_boom"), "-o", "boom.html"]).code(0);
    let size = std::fs::metadata(bench.path().join("boom.html")).expect("a page").len();
    assert!(size < 2_000_000, "{size}");
}

/// What `watch` prints of a scene that is saved once more.
fn watched(before: &str, after: &str) -> String {
    let bench = Bench::new();
    bench.write("scene.toml", before);
    let mut watch = std::process::Command::new(env!("CARGO_BIN_EXE_stillpoint"))
        .current_dir(bench.path())
        .args(["watch", "scene.toml", "--times", "2", "--report", "scene.html"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    let end = Instant::now() + Duration::from_secs(60);
    while !bench.path().join("scene.html").exists() {
        assert!(Instant::now() < end, "no first report");
        std::thread::sleep(Duration::from_millis(20));
    }
    // Files that are saved within one tick of the clock may look alike: wait until the first look is over.
    std::thread::sleep(Duration::from_millis(300));
    bench.write("scene.toml", after);
    let output = loop {
        assert!(Instant::now() < end, "the change was not seen");
        if watch.try_wait().expect("a state").is_some() {
            break watch.wait_with_output().expect("its output");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn watching_tells_what_a_change_does() {
    let out = watched(super::SCALE, &super::SCALE.replace("mass = 1.0", "mass = 2.0"));
    // m g / k and √(k / m) / 2π, g = 9.80665 m/s².
    assert!(out.contains("pan.distance         -0.09807 → -0.1961 (-0.09807)"), "{out}");
    assert!(out.contains("mode 1               1.592 → 1.125 Hz (-29.29 %)"), "{out}");
}

/// It hangs straight down: an angle that is zero but for rounding, by another one each time.
#[test]
fn watching_tells_no_round_off() {
    let scene = "[[body]]\nname = \"a\"\nmass = 1.0\ncenter = [0, 0, -0.5]\ninertia = [0.1, 0.1, 0.01]\n\
                 hinge = { type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]], position = [0.2, 0.1] }\n";
    let out = watched(scene, &scene.replace("-0.5", "-0.9"));
    assert!(out.contains("mode 1") && !out.contains("angle"), "{out}");
}

/// Balls that have flown away leave what stays in the picture, which says so; of what flies as a whole all is framed.
#[test]
fn what_stays_is_framed_where_others_fly_away() {
    let bench = Bench::new();
    let ball = |name: &str, speed: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 1.0\nshape = {{ sphere = 0.2 }}\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = {speed:?} }}\n"
        )
    };
    let scene = |speeds: [f64; 3]| {
        let balls: String = ["a", "b", "c"].iter().zip(speeds).map(|(name, speed)| ball(name, speed)).collect();
        format!("simulate = {{ start = \"given\", duration = 2.0 }}\n{balls}")
    };
    for (speeds, said) in [([0.0, 0.1, 90.0], true), ([90.0, 91.0, 92.0], false)] {
        bench.write("scene.toml", scene(speeds));
        bench.call(&["run", "scene.toml", "--quiet", "--out", "a.mcap"]).code(0);
        let call = ["picture", "a.mcap", "--at", "2", "-o", "a.svg"];
        let told = bench.call(&call).code(0).err;
        assert_eq!(told.contains("1 body is far from where the others are"), said, "{told}");
        let near = std::fs::read(bench.path().join("a.svg")).expect("a picture");
        let told = bench.call(&[&call[..], &["--around", "*"]].concat()).code(0).err;
        assert!(!told.contains("far from"), "{told}");
        let all = std::fs::read(bench.path().join("a.svg")).expect("a picture");
        assert_eq!(near != all, said);
    }
}
