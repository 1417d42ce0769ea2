//! Numbers with units: what they are worth, where they are taken, and what is said of wrong ones.

use crate::common::Random;
use stillpoint::quantity::{Dimension, Quantity, unit};
use stillpoint::scenario::fields::{ANY_UNIT, Kind, Table};
use stillpoint::scenario::{self, Override, Scenario, format};

fn value(text: &str) -> f64 {
    Quantity::parse(text).unwrap_or_else(|error| panic!("{text}: {error}")).value
}

#[test]
fn units_are_worth_what_they_are() {
    use std::f64::consts::{PI, TAU};
    let table = [
        ("300 mm", 0.3, "m"),
        ("45 deg", PI / 4.0, "rad"),
        ("90°", PI / 2.0, "rad"),
        ("5 N/mm", 5000.0, "N/m"),
        ("2 N m/rad", 2.0, "N m/rad"),
        ("2 Nm/deg", 360.0 / PI, "N m/rad"),
        ("3 kNm", 3000.0, "N m"),
        ("60 rpm", TAU, "rad/s"),
        ("0.5 rev/s", PI, "rad/s"),
        ("36 km/h", 10.0, "m/s"),
        ("1.5 t", 1500.0, "kg"),
        ("250 g", 0.25, "kg"),
        ("7.85 g/cm^3", 7850.0, "kg/m³"),
        ("7850 kg/m3", f64::NAN, ""),
        ("12 kg mm²", 12e-6, "kg m²"),
        ("10 cm", 0.1, "m"),
        ("-2.5e3 µm", -2.5e-3, "m"),
        ("−3 ms", -3e-3, "s"),
        ("210 GPa", 210e9, "N/m²"),
        ("4 1/min", 4.0 / 60.0, "Hz"),
        ("100 Hz", 100.0, "1/s"),
        ("9.81 m s^-2", 9.81, "m/s²"),
        ("9.81 m·s⁻²", 9.81, "m/s²"),
        ("3 N m/(rad s)", 3.0, "N m/rad s^-1"),
        ("2 J", 2.0, "N m"),
        ("1 in", 0.0254, "m"),
        ("1 lbf", 4.448_221_615_260_5, "N"),
        ("1 kW", 1000.0, "N m/s"),
    ];
    for (text, expected, unit) in table {
        if unit.is_empty() {
            assert!(Quantity::parse(text).is_err(), "{text}");
            continue;
        }
        // Round-off of a factor and a product.
        assert!((value(text) / expected - 1.0).abs() < 1e-15, "{text}: {}", value(text));
        let dimension = Dimension::of(&unit.replace("/rad s^-1", "/(rad s)")).expect(unit);
        assert_eq!(Quantity::parse(text).expect(text).dimension, dimension, "{text}");
    }
    // What is exact in decimals stays so.
    assert_eq!([value("300 mm"), value("0.1 N/mm"), value("7 g")], [0.3, 100.0, 0.007]);
}

/// Random products of powers of prefixed symbols, against the product of their factors.
#[test]
fn products_of_units_are_products() {
    const PREFIXES: [(&str, f64); 7] =
        [("", 1.0), ("k", 1e3), ("M", 1e6), ("G", 1e9), ("m", 1e-3), ("u", 1e-6), ("n", 1e-9)];
    let mut random = Random::new(21);
    for _ in 0..20_000 {
        let number = random.between(-10.0, 10.0);
        let (mut text, mut factor, mut powers) = (format!("{number} "), 1.0_f64, [0_i32; 4]);
        for part in 0..1 + random.below(4) {
            let (symbol, worth, dimension, prefixed) = unit::SYMBOLS[random.below(unit::SYMBOLS.len())];
            let (prefix, scale) = if prefixed { PREFIXES[random.below(PREFIXES.len())] } else { ("", 1.0) };
            // `m` and `in` behind a prefix could be read as minutes and the like: one symbol may look like two.
            if prefix == "m" && symbol == "in"
                || unit::SYMBOLS.iter().any(|(other, ..)| !prefix.is_empty() && *other == format!("{prefix}{symbol}"))
            {
                continue;
            }
            let power = 1 + random.below(2) as i32;
            let divides = random.below(2) == 0;
            let sign = if divides { -power } else { power };
            if part > 0 && text.contains(|c: char| c.is_alphabetic()) {
                text += " ";
            }
            text += &format!("{prefix}{symbol}^{sign}");
            factor *= (worth * scale).powi(sign);
            (0..4).for_each(|i| powers[i] += sign * i32::from(dimension[i]));
        }
        if !text.contains('^') {
            continue;
        }
        let found = Quantity::parse(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
        // Round-off of some ten factors and powers.
        assert!((found.value - number * factor).abs() <= 1e-13 * (number * factor).abs(), "{text}");
        let base = ["kg", "m", "s", "rad"].iter().zip(powers).filter(|(_, power)| *power != 0);
        let written: Vec<String> = base.map(|(symbol, power)| format!("{symbol}^{power}")).collect();
        if powers.iter().all(|power| power.abs() <= 9) && !written.is_empty() {
            assert_eq!(found.dimension, Dimension::of(&written.join(" ")).expect("a unit"), "{text}");
        }
    }
}

#[test]
fn wrong_units_are_refused() {
    let texts = [
        ("45 degg", "unknown unit `degg`"),
        ("45 dge", "unknown unit `dge`"),
        ("1 N/m s", "two ways"),
        ("1 N/", "where a unit should"),
        ("1 N)", "never opened"),
        ("1 N/(m s", "never closed"),
        ("1 m^0", "a power"),
        ("1 m^99", "a power"),
        ("1 m^", "a power"),
        ("1e400 m", "larger than any"),
        ("1e308 km", "not a finite number"),
        ("mm", "begins with a number"),
        ("1 kmin", "unknown unit"),
        ("1 m$", "where a unit should"),
    ];
    for (text, words) in texts {
        let error = Quantity::parse(text).expect_err(text);
        assert!(error.message.contains(words), "{text}: {}", error.message);
        assert!(text.get(error.span.clone()).is_some(), "{text}: {:?}", error.span);
    }
}

/// Every key with a number says what it measures, or that it is a pure number.
#[test]
fn every_declared_unit_is_a_unit() {
    fn look(table: &'static Table, seen: &mut Vec<&'static str>) {
        for key in table.keys {
            if key.unit != ANY_UNIT {
                for unit in key.unit.split(" or ").flat_map(|unit| unit.split(" and ")).filter(|unit| !unit.is_empty())
                {
                    Dimension::of(unit).unwrap_or_else(|error| panic!("{} of {}: {error}", key.name, table.name));
                    seen.push(unit);
                }
            }
            deeper(&key.kind, seen);
        }
    }
    fn deeper(kind: &'static Kind, seen: &mut Vec<&'static str>) {
        match kind {
            Kind::Table(table) => look(table, seen),
            Kind::List(of, _) | Kind::Map(of) => deeper(of, seen),
            Kind::Either(kinds) => kinds.iter().for_each(|kind| deeper(kind, seen)),
            _ => {}
        }
    }
    let mut seen = Vec::new();
    look(&format::SCENARIO, &mut seen);
    assert!(seen.len() > 60, "{}", seen.len());
}

/// A scene with every kind of number, `@` before those that have a unit.
const SCENE: &str = r#"
gravity = ["0 m/s^2", 0, "-9.8 m/s²"]
[simulate]
duration = "2 min"
[record]
rate = "0.1 kHz"
[[body]]
name = "arm"
mass = "1500 g"
center = [0, "100 mm", 0]
inertia = ["1000 kg cm^2", 0.1, 0.1]
markers = { tip = ["10 cm", 0, 0] }
shape = { cylinder = ["20 mm", 1.0], rpy = ["90 deg", 0, 0] }
hinge = { type = "revolute", axis = [0, 1, 0], position = "45 deg", velocity = "60 rpm", stiffness = "2 N m/rad", limits = ["-90 deg", "90 deg"] }
[[body]]
name = "nut"
mass = 1
inertia = [1, 1, 1]
hinge = { type = "cylindrical", axis = [0, 0, 1], at = ["1 m", 0, 0], position = ["30 mm", "30 deg"], damping = ["1 N s/mm", "2 Nm s/rad"], spring = { curve = [["-30 mm", "-5 N"], ["3 cm", "5 N"]] }, damper = [{ coordinate = 1, curve = [["-60 rpm", "-1 N m"], [0, 0], ["2 rev/s", "2 N m"]] }], limits = { coordinate = 1, low = "-1 rev", high = "1 rev" } }
[[body]]
name = "link"
repeat = 2
mass = ["2 kg", "3000 g"]
inertia = [1, 1, 1]
hinge = { type = "prismatic", axis = [0, 0, 1], force = ["1 kN", 5], armature = "200 g" }
[[force]]
type = "bushing"
between = ["arm", "ground"]
stiffness = [1, 2, "3 N/mm", 4, 5, "6 N m/rad"]
damping = { translation = "1 N s/mm", rotation = [1, 2, "3 N m s/rad"] }
[[force]]
type = "curve"
between = ["arm.tip", "nut"]
length = "1 m"
force = { extension = [["-1 cm", "-2 N"], [0, 0], ["10 mm", "1 kN"]], rate = [["-1 km/h", "-3 N"], [0, 0], ["2 m/s", "4 N"]] }
[[force]]
type = "curve"
between = ["arm", "link[1]"]
length = "40 cm"
force = [["-10 mm", "-5 N"], ["1 cm", "5 N"]]
[[drive]]
hinge = "link[1]"
type = "sine"
amplitude = "5 mm"
frequency = "120 1/min"
phase = "90 deg"
[[motor]]
hinge = "arm"
type = "table"
over = "speed"
at = [0, "30 rpm"]
forces = ["3 N m", 0]
[[motor]]
hinge = "nut"
coordinate = 1
type = "pd"
stiffness = "3 Nm/rad"
target = { type = "ramp", to = "90 deg", duration = "500 ms" }
"#;

fn read(text: &str, set: &[&str]) -> Result<Scenario, String> {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).expect("path and value")).collect();
    scenario::parse("scene.toml", text, &set).map_err(|problems| problems.to_string())
}

/// The same scene in plain numbers.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for (index, part) in text.split('"').enumerate() {
        match Quantity::parse(part) {
            Ok(quantity) if index % 2 == 1 => out += &format!("{:?}", quantity.value),
            _ if index % 2 == 1 => out += &format!("\"{part}\""),
            _ => out += part,
        }
    }
    out
}

#[test]
fn a_scene_with_units_is_the_scene_in_plain_numbers() {
    let with = read(SCENE, &[]).unwrap_or_else(|error| panic!("{error}"));
    let without = read(&plain(SCENE), &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(!plain(SCENE).contains("deg") && plain(SCENE).contains("rate = 100.0"));
    assert_eq!(with.description, without.description);
    assert_eq!((with.simulate, with.record), (without.simulate, without.record));
}

/// Every quantity of the scene in a unit of another kind is refused, at its place.
#[test]
fn wrong_dimensions_are_refused_everywhere() {
    let quantities: Vec<(usize, &str)> = SCENE
        .match_indices('"')
        .zip(SCENE.match_indices('"').skip(1))
        .step_by(2)
        .map(|((start, _), (end, _))| (start + 1, &SCENE[start + 1..end]))
        .filter(|(_, text)| Quantity::parse(text).is_ok_and(|quantity| quantity.unit_start < text.len()))
        .collect();
    assert!(quantities.len() > 50, "{}", quantities.len());
    for (at, text) in quantities {
        let dimension = Quantity::parse(text).expect(text).dimension;
        for wrong in ["m", "rad", "kg", "s", "N m", "N/m", "rad/s", "m/s"] {
            if Dimension::of(wrong) == Ok(dimension) {
                continue;
            }
            let changed = format!("{}1 {wrong}{}", &SCENE[..at], &SCENE[at + text.len()..]);
            let error = read(&changed, &[]).map(|_| ()).expect_err(&format!("`{wrong}` for `{text}`"));
            let line = SCENE[..at].lines().count();
            assert!(error.contains(&format!("scene.toml:{line}:")), "`{wrong}` for `{text}`: {error}");
            assert!(error.contains("is measured in") || error.contains("is no unit of it"), "{error}");
        }
    }
}

#[test]
fn quantities_are_taken_from_the_command_line() {
    let set = ["arm.position=10 deg", "link[1].force=2 kN", "nut.position[1]=\"0.1 rev\"", "simulate.duration=1 h"];
    let scenario = read(SCENE, &set).unwrap_or_else(|error| panic!("{error}"));
    let hinge = |index: usize| &scenario.description.bodies[index].hinge;
    assert_eq!(hinge(0).position, [value("10 deg")]);
    assert_eq!((hinge(3).force.clone(), hinge(2).force.clone()), (vec![2000.0], vec![1000.0]));
    assert_eq!(hinge(1).position, [0.03, value("0.1 rev")]);
    assert_eq!(scenario.simulate.duration, 3600.0);
    assert!(read(SCENE, &["arm.position=10 mm"]).expect_err("a length").contains("it is measured in rad"));
}

#[test]
fn messages_point_at_the_unit() {
    insta::assert_snapshot!(read(&SCENE.replace("\"45 deg\"", "\"45 mm\""), &[]).expect_err("a length"), @r#"
    error: hinge of body `arm`: `position`: `mm` is no unit of it
      --> scene.toml:14:63
       |
    14 | hinge = { type = "revolute", axis = [0, 1, 0], position = "45 mm", velocity = "60 rpm", stiffness = "2 N m/rad", limits = ["-90 deg"...
       |                                                               ^^
       |
       = help: it is measured in rad; `mm` measures a length

    scene.toml: 1 error
    "#);
    insta::assert_snapshot!(read(&SCENE.replace("\"1500 g\"", "\"1500\""), &[]).expect_err("no unit"), @r#"
    error: body `arm`: `mass`: the text "1500" has no unit
     --> scene.toml:9:9
      |
    9 | mass = "1500"
      |         ^^^^
      |
      = help: write `1500` without quotes, or `"1500 kg"`

    scene.toml: 1 error
    "#);
    insta::assert_snapshot!(read(&SCENE.replace("\"2 min\"", "\"2 mins\""), &[]).expect_err("unknown"), @r#"
    error: [simulate]: `duration`: unknown unit `mins`
     --> scene.toml:4:15
      |
    4 | duration = "2 mins"
      |               ^^^^
      |
      = help: did you mean `min`?

    scene.toml: 1 error
    "#);
}

#[test]
fn parameters_are_shared() {
    let text = SCENE
        .replace("gravity", "parameters = { m = \"500 g\", length = 0.2, double = \"2*{length}\" }\ngravity")
        .replace("\"1500 g\"", "\"3*{m}\"")
        .replace("\"100 mm\"", "\"{length}/2\"")
        .replace("\"10 cm\"", "\"{double} - 0.3\"")
        + "[[motor]]\nhinge = \"arm\"\ntype = \"expression\"\nexpression = \"-m*v + {length}*sin(t)\"\n";
    let plain = read(SCENE, &[]).expect("the scene").description.bodies;
    let bodies = |set: &[&str]| read(&text, set).unwrap_or_else(|error| panic!("{error}")).description.bodies;
    let same = bodies(&[]);
    assert_eq!((same[0].mass.mass, same[0].mass.center), (plain[0].mass.mass, plain[0].mass.center));
    assert!((same[0].markers[0].1.x - 0.1).abs() < 1e-15);
    let heavier = bodies(&["parameters.m=2 kg"]);
    assert_eq!(heavier[0].mass.mass, 6.0);
    let error = read(&text, &["parameters.lenght=1"]).expect_err("a slip");
    assert!(error.contains("did you mean `parameters.length`?"), "{error}");
    let error = read(&text.replace("{m}", "{n}"), &[]).expect_err("unknown");
    assert!(error.contains("unknown name `n`"), "{error}");
}

#[test]
fn start_files_take_quantities() {
    let scene = read(SCENE, &[]).expect("the scene").description;
    let text = "[positions]\narm = [\"45 deg\"]\nnut = [\"30 mm\", \"0.1 rev\"]\n\"link[0]\" = [0.0]\n\"link[1]\" = [\"1 cm\"]\n\
                [velocities]\narm = [\"60 rpm\"]\n[inputs]\n\"link[1].force\" = \"2 kN\"\n";
    let start =
        |text: &str| scenario::start::parse_start("start.toml", text, &scene).map_err(|problems| problems.to_string());
    let started = start(text).unwrap_or_else(|error| panic!("{error}"));
    let hinge = |index: usize| &started.description.bodies[index].hinge;
    assert_eq!((hinge(0).position[0], hinge(0).velocity[0]), (value("45 deg"), value("60 rpm")));
    assert_eq!((&hinge(1).position[..], hinge(3).position[0]), (&[0.03, value("0.1 rev")][..], 0.01));
    assert_eq!(hinge(3).force, [2000.0]);
    for (right, wrong) in [("45 deg", "45 mm"), ("30 mm", "30 deg"), ("60 rpm", "60 deg"), ("2 kN", "2 Nm")] {
        let error = start(&text.replace(right, wrong)).map(|_| ()).expect_err(wrong);
        assert!(error.contains("it is measured in") && error.contains("1 error"), "{wrong}: {error}");
    }
}

/// Values of events and setpoints of controllers have the units of what they are compared with.
#[test]
fn what_is_compared_with_an_output_has_its_unit() {
    let text = "[[body]]\nname = \"cart\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [1, 0, 0] }\n\
                [[body]]\nname = \"arm\"\nmass = 1.0\ncenter = [0, 0, -1]\nhinge = { type = \"revolute\", parent = \"cart\", axis = [0, 1, 0] }\n\
                [[motor]]\nname = \"push\"\ntype = \"input\"\nhinge = \"cart\"\n\
                [[output]]\nname = \"x\"\ntype = \"coordinate\"\nof = \"cart\"\n\
                [[output]]\nname = \"angle\"\ntype = \"coordinate\"\nof = \"arm\"\n\
                [[output]]\nname = \"hold\"\ntype = \"reaction\"\nof = \"arm\"\n";
    let event = |of: &str, value: &str| format!("{text}[[event]]\nname = \"e\"\n{of}\nvalue = \"{value}\"\n");
    let controller = |rest: &str| {
        format!(
            "{text}[[controller]]\nname = \"c\"\nperiod = 0.01\nsenses = [\"x\", \"angle\"]\ndrives = [\"push\"]\ntype = \"gain\"\nmatrix = [[1.0, 2.0]]\n{rest}\n"
        )
    };
    let read = |text: &str| scenario::parse("e.toml", text, &[]);
    let taken = [
        (event("output = \"x\"", "20 mm"), 0.02),
        (event("output = \"angle\"", "180 deg"), std::f64::consts::PI),
        (event("output = \"hold[0]\"", "2 kN"), 2000.0),
        (event("hinge = \"cart\"", "1 cm"), 0.01),
        (event("hinge = \"arm\"", "90 deg"), std::f64::consts::FRAC_PI_2),
        (event("on = \"arm\"", "-3 mm"), -0.003),
    ];
    for (text, value) in taken {
        let scenario = read(&text).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        assert!((scenario.description.events[0].value - value).abs() < 1e-15, "{text}");
    }
    let beam = "[[beam]]\nname = \"boom\"\nlength = 1.0\nsection = { circle = 0.01 }\nmaterial = { young = 2e11, density = 7800.0 }\n\
                hinge = { type = \"revolute\", axis = [0, 1, 0] }\n[[event]]\nhinge = \"boom\"\nvalue = \"5 N\"\n"
        .to_owned();
    let refused = [
        (event("output = \"x\"", "-3 deg"), "`x` is measured in m, not in this unit"),
        (event("output = \"angle\"", "20 mm"), "`angle` is measured in rad, not in this unit"),
        (event("output = \"hold[0]\"", "1 m"), "`hold[0]` is measured in N, not in this unit"),
        (event("hinge = \"cart\"", "1 deg"), "`cart` is measured in m, not in this unit"),
        (event("hinge = \"arm\"", "1 m"), "`arm` is measured in rad, not in this unit"),
        (event("on = \"arm\"", "1 deg"), "`e` is measured in m, not in this unit"),
        (beam, "`boom` is measured in rad, not in this unit"),
        (controller("setpoint = [\"2 cm\", \"1 m\"]"), "`angle` is measured in rad, not in this unit"),
    ];
    for (text, message) in refused {
        let problems = read(&text).expect_err(message).to_string();
        assert!(problems.contains(message), "{problems}");
    }
    read(&controller("setpoint = [\"2 cm\", \"10 deg\"]")).expect("a setpoint with units");
}

/// Gains have the unit of what they drive over that of what they sense, biases and limits that of what they drive.
#[test]
fn gains_of_controllers_have_units() {
    use stillpoint::model::controller::ControlLawDescription;
    let scene = |law: &str, senses: &str| {
        let text = "[[body]]\nname = \"cart\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [1, 0, 0] }\n\
                    [[body]]\nname = \"arm\"\nmass = 1.0\ncenter = [0, 0, -1]\nhinge = { type = \"revolute\", parent = \"cart\", axis = [0, 1, 0] }\n\
                    [[motor]]\nname = \"push\"\ntype = \"input\"\nhinge = \"cart\"\n[[motor]]\nname = \"turn\"\ntype = \"input\"\nhinge = \"arm\"\n\
                    [[output]]\nname = \"x\"\ntype = \"coordinate\"\nof = \"cart\"\n[[output]]\nname = \"angle\"\ntype = \"coordinate\"\nof = \"arm\"\n\
                    [[controller]]\nname = \"c\"\nperiod = 0.01\n";
        scenario::parse("c.toml", &format!("{text}senses = {senses}\n{law}\n"), &[])
    };
    let both = "[\"x\", \"angle\"]\ndrives = [\"push\", \"turn\"]";
    let law = |text: &str, senses: &str| {
        let scenario = scene(text, senses).unwrap_or_else(|problems| panic!("{problems}"));
        scenario.description.controllers[0].law.clone()
    };
    let gain =
        "type = \"gain\"\nmatrix = [[\"2 N/mm\", \"3 N/rad\"], [\"4 N\", \"1 N m/deg\"]]\nbias = [\"1 kN\", \"2 N m\"]";
    let ControlLawDescription::Gain { matrix, bias, .. } = law(gain, both) else { panic!("a gain") };
    assert!((matrix[1][1] - 180.0 / std::f64::consts::PI).abs() < 1e-12, "{matrix:?}");
    assert_eq!((matrix[0].clone(), matrix[1][0], bias), (vec![2000.0, 3.0], 4.0, vec![1000.0, 2.0]));
    let one = "\"x\"\ndrives = \"push\"";
    let pid = "type = \"pid\"\nproportional = \"1 N/mm\"\nintegral = \"2 N/(mm s)\"\nderivative = \"3 N s/m\"\nlimit = \"2 kN\"\nbias = \"1 N\"";
    let ControlLawDescription::Pid { proportional, integral, derivative, limit, .. } = law(pid, one) else {
        panic!("a pid")
    };
    assert_eq!((proportional, integral, derivative, limit), (1000.0, 2000.0, 3.0, Some(2000.0)));
    let refused = [
        (gain.replace("2 N/mm", "2 N/s"), both, "this gain is measured in N per m, not in this unit"),
        (gain.replace("1 N m/deg", "1 N/deg"), both, "this gain is measured in N m per rad, not in this unit"),
        (gain.replace("2 N m", "2 N"), both, "`turn` is measured in N m, not in this unit"),
        (pid.replace("1 N/mm", "1 N"), one, "this gain is measured in N per m, not in this unit"),
        (pid.replace("2 N/(mm s)", "2 N/mm"), one, "this gain is measured in N per m and second, not in this unit"),
        (pid.replace("3 N s/m", "3 N/m"), one, "this gain is measured in N per m, times a second, not in this unit"),
        (pid.replace("2 kN", "2 N m"), one, "`push` is measured in N, not in this unit"),
    ];
    for (law, senses, message) in refused {
        let problems = scene(&law, senses).map(|_| ()).expect_err(message).to_string();
        assert!(problems.contains(message), "{problems}");
    }
}

/// An output that counts in degrees or millimetres is compared with degrees or millimetres, whatever unit the number is written in.
#[test]
fn outputs_in_units_of_their_own_are_compared_in_those() {
    let text = "[[body]]\nname = \"arm\"\nmass = 1.0\ncenter = [0.3, 0, 0]\nhinge = { type = \"revolute\", axis = [0, -1, 0], stiffness = 20.0 }\n\
                [[motor]]\nname = \"turn\"\ntype = \"input\"\nhinge = \"arm\"\n\
                [[output]]\nname = \"angle\"\ntype = \"coordinate\"\nof = \"arm\"\n\
                [[output]]\nname = \"deg\"\ntype = \"expression\"\nexpression = \"degrees(angle)\"\nunit = \"deg\"\n";
    let read = |more: &str| {
        scenario::parse("deg.toml", &format!("{text}{more}"), &[]).unwrap_or_else(|problems| panic!("{problems}"))
    };
    for (value, expected) in [("\"30 deg\"", 30.0), ("\"0.1 rad\"", 18.0 / std::f64::consts::PI), ("30.0", 30.0)] {
        let scenario = read(&format!("[[event]]\noutput = \"deg\"\nvalue = {value}\n"));
        let found = scenario.description.events[0].value;
        assert!((found - expected).abs() < 1e-12, "{value}: {found}");
        let scenario = read(&format!("[statics]\nunknown = [\"arm.rest\"]\n[statics.aim]\ndeg = {value}\n"));
        assert!((scenario.aim[0].value - expected).abs() < 1e-12, "{value}: {:?}", scenario.aim);
    }
    // Torque by an angle in degrees: so many newton metres for each of these.
    let controller = |law: &str| {
        let scenario = read(&format!("[[controller]]\nperiod = 0.01\nsenses = \"deg\"\ndrives = \"turn\"\n{law}\n"));
        scenario.description.controllers[0].law.clone()
    };
    use stillpoint::model::controller::ControlLawDescription;
    let pid = "type = \"pid\"\nproportional = \"2 N m/rad\"\nsetpoint = \"45 deg\"";
    let ControlLawDescription::Pid { proportional, setpoint, .. } = controller(pid) else { panic!("a pid") };
    assert!((setpoint - 45.0).abs() < 1e-12 && (proportional - std::f64::consts::PI / 90.0).abs() < 1e-12);
    let gain = "type = \"gain\"\nmatrix = [[\"2 N m/deg\"]]\nsetpoint = [\"45 deg\"]";
    let ControlLawDescription::Gain { matrix, setpoint, .. } = controller(gain) else { panic!("a gain") };
    assert!((setpoint[0] - 45.0).abs() < 1e-12 && (matrix[0][0] - 2.0).abs() < 1e-12, "{matrix:?} {setpoint:?}");
}

/// A name that stands for a parameter and for a variable of a formula is no guess.
#[test]
fn parameters_are_not_taken_for_variables_of_formulas() {
    let scene = |parameter: &str, rest: &str| {
        let text = format!(
            "[parameters]\n{parameter} = 3.0\n[[body]]\nname = \"a\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0] }}\n[[output]]\nname = \"z\"\ntype = \
             \"coordinate\"\nof = \"a\"\n{rest}\n"
        );
        scenario::parse("p.toml", &text, &[]).map(|_| ()).map_err(|problems| problems.to_string())
    };
    let motor = |formula: &str| {
        format!("[[motor]]\nname = \"m\"\ntype = \"expression\"\nhinge = \"a\"\nexpression = \"{formula}\"")
    };
    let output = |formula: &str| format!("[[output]]\nname = \"y\"\ntype = \"expression\"\nexpression = \"{formula}\"");
    let curve = |formula: &str| {
        format!(
            "[[body]]\nname = \"b\"\nmass = 1.0\nhinge = {{ type = \"along\", curve = {{ parameter = \"u\", x = \"u\", z = \"{formula}\", range = \
             [0, 2] }} }}"
        )
    };
    for (parameter, rest) in
        [("t", motor("2*{t}")), ("v", motor("2*v")), ("z", output("{z} + 1")), ("u", curve("0.1*{u}"))]
    {
        let error = scene(parameter, &rest).expect_err(parameter);
        assert!(error.contains(&format!("`{parameter}` is a variable of this formula")), "{error}");
    }
    for rest in [motor("2*{w}*t"), output("w*z"), curve("0.1*{w}*u^2")] {
        scene("w", &rest).unwrap_or_else(|error| panic!("{rest}: {error}"));
    }
}
