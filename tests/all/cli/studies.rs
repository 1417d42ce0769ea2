//! What `study` says of a dataset.

use super::{Bench, SCALE, shipped};
use serde_json::Value;

/// The angle of the rocker of `four_bar_tolerances` at its crank's angle, by the cosine rule.
fn rocker([crank, coupler, rocker, base]: [f64; 4]) -> f64 {
    let (across, up) = (crank * 0.6_f64.sin() - base, crank * 0.6_f64.cos());
    let distance = across.hypot(up);
    let cosine = (rocker * rocker + distance * distance - coupler * coupler) / (2.0 * rocker * distance);
    across.atan2(up) + cosine.acos()
}

/// Lengths and their standard deviations.
const LENGTHS: [(&str, f64, f64); 4] = [
    ("crank", 0.1, 5e-5),
    ("coupler", 0.35, 1e-4),
    ("rocker", 0.3, 1e-4),
    ("base", 0.4, 2e-4 / 1.732_050_807_568_877_2),
];

/// Every row is the cosine rule; the coefficients are derivatives times standard deviations, by differences of the rule.
#[test]
fn what_matters_in_a_four_bar_is_what_the_cosine_rule_says() {
    let bench = Bench::new();
    let vary: Vec<String> = LENGTHS
        .iter()
        .map(|(name, mean, deviation)| match *name {
            "base" => format!("parameters.base=uniform({} mm, {} mm)", 1e3 * (mean - 2e-4), 1e3 * (mean + 2e-4)),
            _ => format!("parameters.{name}=normal({} mm, {} mm)", 1e3 * mean, 1e3 * deviation),
        })
        .collect();
    let mut call = vec!["sweep", "scene", "--cases", "400", "--sample", "latin", "--out", "tolerances", "--quiet"];
    let scene = shipped("four_bar_tolerances");
    call[1] = &scene;
    vary.iter().for_each(|one| call.extend(["--vary", one]));
    bench.call(&call).code(0);
    let rows = super::datasets::rows(&bench.path().join("tolerances"));
    let mut angles = Vec::new();
    for row in &rows {
        let lengths = LENGTHS.map(|(name, ..)| row[&format!("parameters.{name}")].as_f64().expect("a length"));
        let angle = row["rocker.angle"].as_f64().expect("an angle");
        assert!((angle - rocker(lengths)).abs() < 1e-12, "{angle} {}", rocker(lengths));
        angles.push(angle);
    }
    let answer =
        bench.call(&["study", "tolerances", "--of", "rocker.angle", "--svg", "rocker.svg", "--json"]).code(0).json();
    assert_eq!((&answer["cases"], &answer["rows"], &answer["failed"]), (&400.into(), &400.into(), &0.into()));
    let output = &answer["outputs"][0];
    angles.sort_by(f64::total_cmp);
    assert_eq!((output["min"].as_f64(), output["max"].as_f64()), (Some(angles[0]), Some(angles[399])));
    for (part, place) in [("0.01", 3), ("0.05", 19), ("0.5", 199), ("0.95", 379), ("0.99", 395)] {
        assert_eq!(output["quantiles"][part], angles[place], "{part}");
    }
    let mean = angles.iter().sum::<f64>() / 400.0;
    assert!((output["mean"].as_f64().expect("a mean") - mean).abs() < 1e-14);
    let middle = LENGTHS.map(|(_, mean, _)| mean);
    let moved = |k: usize, by: f64| {
        let mut lengths = middle;
        lengths[k] += by;
        rocker(lengths)
    };
    let mut exact: Vec<(String, f64)> = LENGTHS
        .iter()
        .enumerate()
        .map(|(k, (name, _, deviation))| {
            (format!("parameters.{name}"), (moved(k, *deviation) - moved(k, -deviation)) / 2.0)
        })
        .collect();
    let total = exact.iter().map(|(_, effect)| effect * effect).sum::<f64>().sqrt();
    exact.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let effects = output["effects"].as_array().expect("a list");
    assert_eq!(effects.len(), 4);
    for ((name, effect), found) in exact.iter().zip(effects) {
        assert_eq!(found["input"], name.as_str());
        // A Latin hypercube of 400: the deviations of inputs are known to 1 %, their correlations to 1/√400.
        let coefficient = found["coefficient"].as_f64().expect("a number");
        assert!((coefficient - effect / total).abs() < 0.05, "{name}: {coefficient}, not {}", effect / total);
    }
    assert!(output["explained"].as_f64().is_some_and(|explained| explained > 0.999));
    let svg = std::fs::read_to_string(bench.path().join("rocker.svg")).expect("a drawing");
    let all = LENGTHS.iter().all(|(name, ..)| svg.contains(&format!("parameters.{name}")));
    assert!(svg.starts_with("<svg") && svg.contains("rocker.angle (rad)") && all);
    let text = bench.call(&["study", "tolerances"]).code(0).out;
    assert!(text.contains(&format!("what matters most is `{}`", exact[0].0)), "{text}");
}

#[test]
fn what_is_no_dataset_is_refused() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let refused = |arguments: &[&str], word: &str| {
        let error = bench.call(&[&["study"], arguments].concat()).code(2).err;
        assert!(error.contains(word), "{arguments:?}: {error}");
    };
    refused(&["none"], "no dataset");
    refused(&["."], "no dataset");
    // One case of four fails: it counts, and is in no mean.
    bench.call(&["sweep", "scale.toml", "--over", "pan.mass=-1,1,2,3", "--out", "set"]).code(1);
    let answer = bench.call(&["study", "set", "--of", "pan.distance", "--json"]).code(0).json();
    assert_eq!((&answer["failed"], &answer["outputs"][0]["count"]), (&Value::from(1), &Value::from(3)));
    let mean = answer["outputs"][0]["mean"].as_f64().expect("a mean");
    assert!((mean + 2.0 * 9.80665 / 100.0).abs() < 1e-14, "{mean}");
    refused(&["set", "--of", "pan.distnace"], "did you mean `pan.distance`?");
    refused(&["set", "--of", "pan.distance", "--of", "frequencies_hz[0]", "--svg", "x.svg"], "one column");
    std::fs::remove_file(bench.path().join("set/part-0000002.parquet")).expect("removed");
    assert!(bench.call(&["study", "set"]).code(0).out.contains("3 of 4 cases"));
    bench.write("set/part-0000001.parquet", "cut");
    refused(&["set"], "part-0000001.parquet");
}

/// The square of what is drawn on both sides of zero has no slope on the whole: what matters most is said by what an input explains
/// alone, not by lines that explain nothing. Of `x² + y/100` with both uniform from −1 to 1 that is 4/45 of 4/45 + 1e-4/3.
#[test]
fn what_is_no_line_is_not_ranked_by_lines() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "gravity = [0, 0, 0]\nparameters = { x = 0.0, y = 0.0 }\n\
         [[body]]\nname = \"slide\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = { type = \"prismatic\", axis = [1, 0, 0], stiffness = 100.0, rest = \"{x}\" }\n\
         [[body]]\nname = \"other\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = { type = \"prismatic\", axis = [1, 0, 0], stiffness = 100.0, rest = \"{y}\" }\n\
         [[output]]\nname = \"place\"\ntype = \"coordinate\"\nof = \"slide.distance\"\n\
         [[output]]\nname = \"off\"\ntype = \"coordinate\"\nof = \"other.distance\"\n\
         [[output]]\nname = \"square\"\ntype = \"expression\"\nexpression = \"place^2 + 0.01*off\"\nunit = \"m2\"\n",
    );
    let vary = ["--vary", "parameters.x=uniform(-1, 1)", "--vary", "parameters.y=uniform(-1, 1)"];
    let call = ["sweep", "scene.toml", "--cases", "300", "--sample", "latin", "--out", "rows", "--quiet"];
    bench.call(&[&call[..], &vary[..]].concat()).code(0);
    let of_square = bench.call(&["study", "rows", "--of", "square", "--svg", "square.svg"]).code(0).out;
    assert!(
        of_square.contains("what matters most is `parameters.x`") && of_square.contains("by itself"),
        "{of_square}"
    );
    let svg = std::fs::read_to_string(bench.path().join("square.svg")).expect("a drawing");
    assert!(svg.contains("first-order Sobol index"), "the bars are what ranks");
    let answer = bench.call(&["study", "rows", "--of", "square", "--json"]).code(0).json();
    let [first, second] = [0, 1].map(|at| answer["outputs"][0]["effects"][at].clone());
    let of = |effect: &Value| {
        [&effect["first_order"], &effect["first_order_confidence"]].map(|x| x.as_f64().expect("a number"))
    };
    let exact = (4.0 / 45.0) / (4.0 / 45.0 + 1e-4 / 3.0);
    assert_eq!(first["input"], "parameters.x");
    let [found, within] = of(&first);
    assert!((found - exact).abs() < within && within < 0.005, "{first}");
    assert!(of(&second)[0] < of(&second)[1] + 0.05, "{second}");
    let few = ["--over", "parameters.x=-1:1:5", "--over", "parameters.y=-1:1:4", "--out", "few", "--quiet"];
    bench.call(&[&["sweep", "scene.toml"][..], &few].concat()).code(0);
    let of_few = bench.call(&["study", "few", "--of", "square"]).code(0).out;
    assert!(of_few.contains("what matters most is not a line") && of_few.contains("50 cases"), "{of_few}");
    let of_place = bench.call(&["study", "rows", "--of", "place"]).code(0).out;
    assert!(of_place.contains("what matters most is `parameters.x`"), "{of_place}");
}

/// Of `a + b` with correlation r the coefficient of each is 1/√(2 + 2 r), here √5: its square is no share of the variance.
#[test]
fn correlated_inputs_have_no_share_of_the_variance() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "gravity = [0, 0, 0]\nparameters = { a = 1.0, b = 1.0 }\n\
         [[body]]\nname = \"m\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = { type = \"prismatic\", axis = [1, 0, 0], stiffness = 1.0, rest = \"{a}+{b}\" }\n",
    );
    bench.write("matrix.csv", "parameters.a,parameters.b\n1,-0.9\n-0.9,1\n");
    let vary = ["--vary", "parameters.a=normal(1, 0.1)", "--vary", "parameters.b=normal(1, 0.1)"];
    let told = |name: &str, more: &[&str]| {
        let call = ["sweep", "scene.toml", "--cases", "500", "--out", name, "--quiet"];
        bench.call(&[&call[..], &vary[..], more].concat()).code(0);
        bench.call(&["study", name, "--of", "m.distance"]).code(0).out
    };
    let correlated = told("correlated", &["--correlate", "matrix.csv"]);
    let words = "none has a share of the variance of its own; a line in all inputs explains 100 %";
    assert!(
        correlated.contains(words) && correlated.contains("(`parameters.a` and `parameters.b` by -0."),
        "{correlated}"
    );
    assert!(!correlated.contains("% of the variance"), "{correlated}");
    let independent = told("independent", &[]);
    assert!(independent.contains("% of the variance") && !independent.contains("correlated ("), "{independent}");
}

/// A fit of a number and of all of its kind would have the derivatives of neither: both are named, with what they share.
#[test]
fn numbers_that_share_an_entry_are_not_fitted_at_once() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench.write("data.csv", "pan.mass,pan.distance\n1,-0.1\n2,-0.2\n3,-0.3\n");
    bench.write("set.csv", "hinge.stiffness,pan.distance\n100,-0.1\n200,-0.05\n");
    let refused = |data: &str, parameters: &[&str], words: &str| {
        let call = ["study", "scale.toml", "--fit", data, "--parameter"];
        let error = bench.call(&[&call[..], parameters].concat()).code(2).err;
        assert!(error.contains(words), "{parameters:?}: {error}");
    };
    let both = "the parameter `hinge.stiffness` and the parameter `pan.stiffness` both set `pan.stiffness`";
    refused("data.csv", &["hinge.stiffness", "pan.stiffness", "pan.rest"], both);
    refused("set.csv", &["pan.stiffness"], "the column `hinge.stiffness` and the parameter `pan.stiffness` both set");
}

/// A number that a fit cannot read from the scene wants a start, and is not said to be missing.
#[test]
fn a_parameter_that_reading_sets_wants_a_start() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench.write("data.csv", "pan.distance\n-0.1\n-0.2\n");
    let said = bench.call(&["study", "scale.toml", "--fit", "data.csv", "--parameter", "pan.damping"]).code(2).err;
    assert!(said.contains("`pan.damping` is a number that only reading the file sets: say where it starts"), "{said}");
}

/// A load that keeps its direction or turns with its body, at several masses: of a full grid the part of an input is the variance of the
/// means of its classes over that of all, whatever the input is.
#[test]
fn inputs_of_words_have_their_part_of_the_variance() {
    let bench = Bench::new();
    let scene = "[[body]]\nname = \"b\"\nmass = 1.0\ncenter = [0, 0, -0.3]\ninertia = [0.1, 0.1, 0.1]\n\
        markers = { tip = [0, 0, -0.6] }\nhinge = { type = \"revolute\", axis = [0, 1, 0] }\n\
        [[force]]\nname = \"load\"\ntype = \"load\"\non = \"b.tip\"\naxes = \"inertial\"\nforce = [4, 0, 0]\n";
    bench.write("load.toml", scene);
    let grid = ["--over", "load.axes=inertial,body", "--over", "b.mass=1:1.3:40", "--out", "words", "--quiet"];
    bench.call(&[&["sweep", "load.toml"], &grid[..]].concat()).code(0);
    let rows = super::datasets::rows(&bench.path().join("words"));
    let angle = |row: &serde_json::Map<String, Value>| row["b.angle"].as_f64().expect("an angle");
    let mean = |numbers: &[f64]| numbers.iter().sum::<f64>() / numbers.len() as f64;
    let variance = |numbers: &[f64]| {
        let middle = mean(numbers);
        numbers.iter().map(|x| (x - middle).powi(2)).sum::<f64>() / numbers.len() as f64
    };
    let angles: Vec<f64> = rows.iter().map(angle).collect();
    let of = |word: &str| -> f64 {
        mean(&rows.iter().filter(|row| row["load.axes"] == word).map(angle).collect::<Vec<_>>())
    };
    let share = variance(&[of("inertial"), of("body")]) / variance(&angles);
    assert!((share - 0.672).abs() < 1e-3, "{share}");
    let answer = bench.call(&["study", "words", "--of", "b.angle", "--svg", "words.svg", "--json"]).code(0).json();
    let effects = answer["outputs"][0]["effects"].as_array().expect("effects");
    assert_eq!(effects.iter().map(|effect| &effect["input"]).collect::<Vec<_>>(), ["load.axes", "b.mass"]);
    let number = |key: &str| effects[0][key].as_f64().unwrap_or_else(|| panic!("{key}: {answer}"));
    assert!((number("coefficient").powi(2) / share - 1.0).abs() < 1e-9, "{answer}");
    assert!((number("first_order") - share).abs() < 0.01, "{answer}");
    for word in ["inertial", "body"] {
        assert!((effects[0]["means"][word].as_f64().expect("a mean") - of(word)).abs() < 1e-12, "{answer}");
    }
    let told = bench.call(&["study", "words", "--of", "b.angle"]).code(0).out;
    for part in [
        "what matters most is `load.axes`: 67 %",
        "lines in all numbers and means for all words explain",
        "means by `load.axes`: `inertial`",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
}

/// Words that change nothing are listed as what they are.
#[test]
fn words_that_do_nothing_are_listed_last() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let grid = ["--over", "statics.want=any,stable", "--over", "pan.mass=1:2:60", "--out", "still", "--quiet"];
    bench.call(&[&["sweep", "scale.toml"], &grid[..]].concat()).code(0);
    let answer = bench.call(&["study", "still", "--of", "pan.distance", "--json"]).code(0).json();
    let effects = answer["outputs"][0]["effects"].as_array().expect("effects");
    assert_eq!(effects.iter().map(|effect| &effect["input"]).collect::<Vec<_>>(), ["pan.mass", "statics.want"]);
    assert_eq!(effects[1]["coefficient"], 0.0);
}
