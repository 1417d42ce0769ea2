//! What is drawn of a scene, and how large: marks, curves, arrows and frames of pictures and reports.

use super::{Bench, shipped};

/// A body without gravity, with more keys of its own, and what else the scene has.
fn scene(body: &str, more: &str) -> String {
    format!(
        "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = 1.0\n[[body]]\nname = \"a\"\nmass = 1.0\n\
         inertia = [0.1, 0.1, 0.1]\n{body}\n{more}"
    )
}

/// A folder with a recording `run.mcap` of a scene.
fn recorded(scene: &str) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", scene);
    bench.call(&["run", "scene.toml", "--out", "run.mcap", "--quiet"]).code(0);
    bench
}

fn picture(bench: &Bench, more: &[&str]) -> String {
    bench.call(&[&["picture", "run.mcap", "-o", "a.svg", "--quiet"][..], more].concat()).code(0);
    std::fs::read_to_string(bench.path().join("a.svg")).expect("a picture")
}

/// How many parts a picture has.
fn parts(bench: &Bench, more: &[&str]) -> u64 {
    let call = [&["picture", "run.mcap", "-o", "a.svg", "--json", "--quiet"][..], more].concat();
    bench.call(&call).code(0).json()["parts"].as_u64().expect("a number")
}

/// All numbers of a text.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'));
    words.filter_map(|word| word.parse().ok()).collect()
}

/// Fills of the paths of an SVG, in their order.
fn fills(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).expect("XML");
    let fills = document.descendants().filter_map(|node| node.attribute("fill"));
    fills.filter(|fill| fill.starts_with('#')).map(str::to_owned).collect()
}

#[test]
fn a_picture_far_from_the_origin_is_the_one_at_the_origin() {
    let at = |x: f64| {
        let hinge =
            format!("hinge = {{ type = \"free\", position = [{x:?}, 0, 0, 1, 0, 0, 0] }}\nshape = {{ sphere = 0.13 }}");
        picture(&recorded(&scene(&hinge, "")), &["--camera", "30,20"])
    };
    let here = at(0.0);
    for far in [1e3, 1e6] {
        let there = at(far);
        // Lengths are written in hundredths of a pixel; at 1e6 m a place is known to 1e-10 m.
        let (a, b) = (numbers(&here), numbers(&there));
        assert_eq!((a.len(), fills(&here)), (b.len(), fills(&there)), "{far} m away");
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 0.15, "{far} m away a point of the picture is {apart} pixels elsewhere");
    }
}

const BEAD: &str = "shape = { sphere = 0.05 }\nhinge = { type = \"prismatic\", axis = [1, 0, 0], stiffness = 100 }";

#[test]
fn an_arrow_is_there_as_long_as_its_load_is() {
    let load = "[[force]]\nname = \"F\"\ntype = \"load\"\non = \"a\"\nforce = [-10, 0, 0]\n\
                over_time = { times = [0.0, 0.5, 0.5], values = [1.0, 1.0, 0.0] }\n";
    let bench = recorded(&scene(BEAD, load));
    for (at, arrows) in [("0", 1), ("0.4", 1), ("0.6", 0), ("1", 0)] {
        assert_eq!(parts(&bench, &["--at", at, "--loads"]) - parts(&bench, &["--at", at]), arrows, "at {at} s");
    }
}

#[test]
fn an_arrow_that_pushes_on_a_body_is_painted_over_it() {
    let load = "[[force]]\ntype = \"load\"\non = { body = \"a\", at = [0, 0, 0.5] }\nforce = [0, 0, -10]\n";
    let body = "shape = { box = [1.0, 1.0, 1.0], color = [0.2, 0.4, 0.9] }\nhinge = { type = \"free\" }";
    let svg = picture(&recorded(&scene(body, load)), &["--loads"]);
    let is_red = |fill: &String| {
        fill.len() == 7 && u8::from_str_radix(&fill[1..3], 16).ok() > u8::from_str_radix(&fill[5..7], 16).ok()
    };
    assert!(fills(&svg).iter().any(is_red), "the arrow is within the body");
}

#[test]
fn reactions_of_bodies_that_are_not_framed_make_no_frame_larger() {
    let far = "[[body]]\nname = \"far\"\nmass = 1.0\ncenter = [0, 0, 1]\nshape = { sphere = 0.1 }\n\
               hinge = { type = \"revolute\", at = [100, 0, 0], axis = [0, 0, 1], velocity = 1.0 }\n";
    let near = "shape = { sphere = 0.1 }\nhinge = { type = \"free\" }";
    let bench = recorded(&scene(near, &far.replace("center = [0, 0, 1]", "center = [1, 0, 0]")));
    let around = ["--around", "a"];
    let frame = |svg: String| svg.lines().find(|line| line.starts_with("<path")).expect("a floor").to_owned();
    let with = [&around[..], &["--reactions"]].concat();
    assert_eq!(frame(picture(&bench, &around)), frame(picture(&bench, &with)));
}

#[test]
fn the_curve_of_a_bead_is_drawn() {
    let bench = Bench::new();
    let bead = shipped("bead_on_cycloid");
    bench.call(&["run", &bead, "--out", "run.mcap", "--quiet", "--set", "simulate.duration=0.1"]).code(0);
    assert_eq!(parts(&bench, &[]), 2, "the bead and its wire");
}

/// Two bodies without gravity, a metre apart, and a force.
fn with_force(keys: &str) -> Bench {
    let other = "[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nshape = { box = [0.2, 0.2, 0.2] }\n\
                 hinge = { type = \"free\", position = [1, 0, 0, 1, 0, 0, 0] }\n";
    let own = "shape = { box = [0.2, 0.2, 0.2] }\nhinge = { type = \"free\" }";
    recorded(&scene(own, &format!("{other}{keys}")))
}

#[test]
fn every_kind_of_force_is_drawn() {
    let force = |kind: &str, keys: &str| format!("[[force]]\nname = \"f\"\ntype = \"{kind}\"\n{keys}\n");
    let between = |keys: &str| format!("between = [\"a\", \"b\"]\n{keys}");
    let bare = parts(&with_force(""), &["--loads"]);
    for keys in [
        force("spring", &between("stiffness = 1.0\nlength = 1.0")),
        force("spring", &between("stiffness = 0.0\ndamping = 1.0\nlength = 1.0")),
        force("bushing", &between("stiffness = [1, 1, 2, 0, 0, 0]")),
        force("curve", &between("force = [[-1.0, -1.0], [1.0, 1.0]]\nlength = 1.0")),
        force("curve", &between("force = { rate = [[-1.0, -1.0], [1.0, 1.0]] }")),
        force("rope", "through = [\"a\", \"b\"]\nstiffness = 1.0\nlength = 1.0"),
        force("load", "on = \"a\"\nforce = [1, 0, 0]"),
        force("load", "on = \"a\"\ntorque = [1, 0, 0]"),
        "[[loop]]\nname = \"f\"\ntype = \"rod\"\nlength = 1.0\nbetween = [\"a\", \"b\"]\n".to_owned(),
    ] {
        assert_eq!(parts(&with_force(&keys), &["--loads"]), bare + 1, "{keys}");
    }
}

/// Rubber is darker than all else of the picture.
#[test]
fn a_bushing_is_drawn_as_it_is_sheared() {
    let mount = "[[force]]\ntype = \"bushing\"\nbetween = [{ body = \"ground\", at = [0, 0, -0.5] }, { body = \"a\", at = [0, 0, -0.5] }]\n\
                 stiffness = [0, 0, 1, 0, 0, 0]\n";
    let width = |aside: f64| {
        let body = format!(
            "shape = {{ box = [1.0, 1.0, 1.0], color = \"#ffffff\" }}\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {aside:?} }}"
        );
        let svg = picture(&recorded(&scene(&body, mount)), &["--camera", "front"]);
        let document = roxmltree::Document::parse(&svg).expect("XML");
        let is_rubber = |fill: &str| {
            fill.len() == 7
                && [1, 3, 5].iter().all(|at| u8::from_str_radix(&fill[*at..at + 2], 16).is_ok_and(|part| part < 0x30))
        };
        let rubber = document.descendants().filter(|node| node.attribute("fill").is_some_and(is_rubber));
        // Faces alone, not the shadows, which are seen through.
        let rubber = rubber.filter(|node| !node.has_attribute("fill-opacity"));
        let places: Vec<f64> = rubber.filter_map(|node| node.attribute("d")).flat_map(numbers).collect();
        let across = || places.iter().step_by(2).copied();
        across().fold(0.0, f64::max) - across().fold(f64::INFINITY, f64::min)
    };
    let (relaxed, sheared) = (width(0.0), width(0.03));
    assert!(relaxed > 0.0 && sheared > 1.3 * relaxed, "{relaxed} and {sheared} pixels");
}

#[test]
fn marks_are_as_large_as_the_start_asks_for() {
    let flying = "[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nshape = { sphere = 0.1 }\nhinge = { type = \"free\", velocity = [900, 0, 0, 0, 0, 0] }\n";
    let held = "shape = { box = [1, 1, 1], color = \"#ffffff\" }\nhinge = { type = \"spherical\" }";
    let svg = picture(&recorded(&scene(held, flying)), &["--at", "1"]);
    let document = roxmltree::Document::parse(&svg).expect("XML");
    let is_dark = |fill: &str| {
        fill.len() == 7
            && [1, 3, 5].iter().all(|at| u8::from_str_radix(&fill[*at..at + 2], 16).is_ok_and(|part| part < 0x60))
    };
    let dark = document.descendants().filter(|node| node.attribute("fill").is_some_and(is_dark));
    // Faces alone, not the shadows, which are seen through.
    let faces: Vec<&str> =
        dark.filter(|node| !node.has_attribute("fill-opacity")).filter_map(|node| node.attribute("d")).collect();
    assert!(!faces.is_empty(), "no mark");
    for path in faces {
        let places = numbers(path);
        let (x, most) = (places.iter().step_by(2), f64::max);
        let width = x.clone().copied().fold(0.0, most) - x.copied().fold(f64::INFINITY, f64::min);
        // The cube is a fiftieth of a metre, in a picture of 900 m; by the extent of that it would be 12 m large.
        assert!(width < 1.0, "a mark of {width} pixels");
    }
}

#[test]
fn a_time_beyond_the_recording_is_said_to_be_so() {
    let bench = recorded(&scene(BEAD, ""));
    let said = |at: &str| bench.call(&["picture", "run.mcap", "-o", "a.svg", "--at", at]).code(0).err;
    assert!(
        said("99").contains("`--at 99` is after the end of `run.mcap`: its last sample is drawn, that at 1 s"),
        "{}",
        said("99")
    );
    assert!(said("-1").contains("before `run.mcap` begins: its first sample is drawn, that at 0 s"), "{}", said("-1"));
    assert_eq!(said("0.5042"), "");
}

#[test]
fn gltf_without_a_motion_says_that_it_has_no_animation() {
    let bench = recorded(&scene("shape = { sphere = 0.1 }\nhinge = { type = \"free\" }", ""));
    let said = bench.call(&["view", "run.mcap", "--save", "a.glb"]).code(0).out;
    assert!(said.contains("101 samples, no animation: nothing moves"), "{said}");
}

#[test]
fn a_report_opens_on_the_start_of_a_flight_and_on_all_of_a_swing() {
    let flight = "shape = { sphere = 0.1 }\nhinge = { type = \"free\", velocity = [50, 0, 0, 0, 0, 0] }";
    let swing = "center = [0, 0, -1]\nshape = { sphere = 0.1, at = [0, 0, -1] }\n\
                 hinge = { type = \"revolute\", axis = [0, 1, 0], velocity = 1.0 }";
    for (body, opens) in [(flight, "start"), (swing, "all")] {
        let bench = recorded(&scene(body, ""));
        bench.call(&["report", "run.mcap", "-o", "a.html"]).code(0);
        let page = std::fs::read_to_string(bench.path().join("a.html")).expect("a page");
        assert!(page.contains(&format!("\"opens\":\"{opens}\"")), "it does not open on {opens}");
    }
}

/// What the page shows of a slender column, of which most is height, as its own script projects it.
#[test]
fn the_whole_of_a_column_is_in_the_picture_of_a_report() {
    let column = "shape = { box = [0.1, 0.1, 4.0] }\nhinge = { type = \"fixed\" }";
    let bench = recorded(&scene(column, ""));
    bench.call(&["report", "run.mcap", "-o", "a.html"]).code(0);
    let page = std::fs::read_to_string(bench.path().join("a.html")).expect("a page");
    let look = page.split("id=\"look\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("a look");
    let look: serde_json::Value = serde_json::from_str(look).expect("JSON");
    let view = &look["views"]["all"];
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let [azimuth, elevation] = ["azimuth", "elevation"].map(|key| number(&view[key]));
    let right = [-azimuth.sin(), azimuth.cos(), 0.0];
    let up = [-elevation.sin() * azimuth.cos(), -elevation.sin() * azimuth.sin(), elevation.cos()];
    for corner in [[-0.05, -0.05], [-0.05, 0.05], [0.05, -0.05], [0.05, 0.05]] {
        for height in [-2.0, 2.0] {
            let corner = [corner[0], corner[1], height];
            for (axis, framed) in [right, up].iter().zip(view["framed"].as_array().expect("width and height")) {
                let along = |k: usize| axis[k] * (corner[k] - number(&view["center"][k]));
                let away = (0..3).map(along).sum::<f64>().abs();
                // Triangles are kept in single precision.
                assert!(away <= 0.5 * number(framed) + 1e-6, "{corner:?} is {away} m off, of {framed} m");
            }
        }
    }
}

/// The texts of an SVG.
fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).expect("XML");
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.filter_map(|node| node.text()).map(|text| text.trim().to_owned()).collect()
}

/// A thrust along a straight column bends it by rounding alone.
#[test]
fn a_column_that_is_not_bent_has_no_colours_of_its_moment() {
    let bench = Bench::new();
    bench.call(&["run", &shipped("beams/held_column"), "--out", "run.mcap", "--quiet"]).code(0);
    let svg = picture(&bench, &[]);
    assert!(!texts(&svg).iter().any(|text| text.contains("moment")), "{:?}", texts(&svg));
}

/// A machine that stays on its mounts trembles by rounding, at the frequency of stiff rubber.
#[test]
fn a_plot_of_what_stays_is_flat_and_has_one_axis_of_time() {
    let bench = Bench::new();
    bench.call(&[
        "run",
        &shipped("machine_on_mounts"),
        "--out",
        "run.mcap",
        "--quiet",
        "--set",
        "simulate.duration=0.1",
    ]);
    bench.call(&["plot", "run.mcap", "hinges", "-o", "a.svg"]).code(0);
    let told = texts(&std::fs::read_to_string(bench.path().join("a.svg")).expect("a plot"));
    let noise = told.iter().filter_map(|text| text.parse::<f64>().ok()).find(|x| *x != 0.0 && x.abs() < 1e-9);
    assert_eq!(noise, None, "{told:?}");
    assert_eq!(told.iter().filter(|text| *text == "time (s)").count(), 1, "{told:?}");
    assert!(told.iter().any(|text| text == "quaternion") && !told.iter().any(|text| text == "value"), "{told:?}");
}

#[test]
fn a_report_gives_each_coupling_its_own_unit() {
    let bench = Bench::new();
    let body = |name: &str, kind: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 1.0\ncenter = [0.5, 0, 0]\n\
             hinge = {{ type = \"{kind}\", axis = [0, 1, 0], limits = {{ low = 0.0, high = 1.0 }}, force = -3.0 }}\n\
             [[drive]]\nname = \"hold {name}\"\nhinge = \"{name} driven\"\ntype = \"hold\"\n\
             [[body]]\nname = \"{name} driven\"\nmass = 1.0\ncenter = [0.5, 0, 0]\nhinge = {{ type = \"{kind}\", axis = [0, 1, 0], force = 2.0 }}\n"
        )
    };
    bench.write(
        "scene.toml",
        format!("gravity = [0, 0, 0]\n{}{}", body("slide", "prismatic"), body("door", "revolute")),
    );
    bench.call(&["report", "scene.toml", "--statics", "-o", "a.html"]).code(0);
    let page = std::fs::read_to_string(bench.path().join("a.html")).expect("a page");
    let unit = |of: &str| {
        let row =
            page.split("<h2>Couplings</h2>").nth(1)?.split(&format!("<td>{of}</td>")).nth(1)?.split("</tr>").next()?;
        row.trim_end().strip_suffix("</td>")?.rsplit('>').next()
    };
    for (of, expected) in [("slide", "N"), ("door", "N m"), ("hold slide", "N"), ("hold door", "N m")] {
        assert_eq!(unit(of), Some(expected), "{of}");
    }
}

/// Green is what stands and was not stopped.
#[test]
fn reports_of_what_does_not_stand_are_not_green() {
    let bench = Bench::new();
    for (scene, class) in [("pendulum", "fine"), ("pencil", "wrong")] {
        let answer = bench.call(&["report", &shipped(scene), "--statics", "-o", "a.html", "--json"]).code(0).json();
        assert_eq!(answer["fine"], class == "fine", "{answer}");
        let page = std::fs::read_to_string(bench.path().join("a.html")).expect("a page");
        assert!(page.contains(&format!("class=\"verdict {class}\"")), "{scene}");
    }
}

#[test]
fn a_report_has_units_and_no_round_off() {
    let bench = Bench::new();
    let wishbone = shipped("double_wishbone");
    bench.call(&["report", &wishbone, "-o", "a.html", "--set", "simulate.duration=0.2", "--quiet"]).code(0);
    let page = std::fs::read_to_string(bench.path().join("a.html")).expect("a page");
    let camber = page.split("<td>camber</td>").nth(1).and_then(|rest| rest.split("</tr>").next()).expect("a row");
    assert!(camber.contains("<td>rad</td>"), "{camber}");
    let cells =
        page.split("<td").skip(1).filter_map(|cell| cell.split_once('>')?.1.split('<').next()?.parse::<f64>().ok());
    // The largest numbers are some 1e4 N; what is below 1e-12 of them is round-off, of lengths below 1e-13 m.
    let noise: Vec<f64> = cells.filter(|x| *x != 0.0 && x.abs() < 1e-12).collect();
    assert!(noise.is_empty(), "{noise:?}");
    let said = bench.call(&["run", &wishbone, "--set", "simulate.duration=0.2", "--out", "a.mcap"]).code(0).out;
    assert!(page.contains("of their size: the residual is") && !page.contains("N along slides"));
    let size = said.lines().find(|line| line.contains("degrees of freedom")).and_then(|line| line.split(", ").next());
    assert!(page.contains(size.expect("a size").trim()), "{said}");
}
