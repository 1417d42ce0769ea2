//! Formulas: what they mean, their derivatives, their limits, and what is said of those that are wrong.

mod generator;
mod messages;
mod pulses;

use crate::common::Random;
use generator::{Style, Tree};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use stillpoint::formula::{Formula, Jet};

const NAMES: [&str; 3] = ["t", "q", "v"];

fn read(text: &str) -> Formula {
    Formula::parse(text, &NAMES).unwrap_or_else(|error| panic!("{text}: {error:?}"))
}

fn value(text: &str) -> f64 {
    read(text).value(&[2.0, -3.0, 0.5])
}

/// What Python refuses has no value, whatever it is compared with or chosen from; what Python does not look at does not matter.
#[test]
fn nothing_comes_of_what_has_no_value() {
    let undefined = [
        "max(1, sqrt(-1))",
        "max(sqrt(-1), 1)",
        "min(1, 1/0)",
        "min(1/0, 1)",
        "1 < sqrt(-1)",
        "1 != sqrt(-1)",
        "1 == 0/0",
        "1 if 1/0 > 2 else 3",
        "if(0/0, 1, 2)",
        "1/(1/0)",
        "atan(1/0)",
        "not 1/0",
        "1//0 > 1",
        "5 % 0 < 1",
        "0^-1 > 1",
        "log(0) < 1",
        "sqrt(-1) or 1",
        "1/0 and 0",
        "sign(1/0)",
        "(0/0)^0",
        "exp(1000)",
        "exp(1000) - exp(2000)",
        "1e200*1e200/(1e200*1e200)",
        "tanh(1/0)",
        "2 < 3 < 1/0",
    ];
    for text in undefined {
        assert!(value(text).is_nan(), "{text}: {}", value(text));
        let formula = read(text);
        assert!(formula.jet(&[2.0, -3.0, 0.5].map(Jet::variable)).value.is_nan(), "{text}");
        assert!(formula.gradient(&[2.0, -3.0, 0.5], [0, 1]).0.is_nan(), "{text}");
    }
    for (text, expected) in
        [("1 or 1/0", 1.0), ("0 and 1/0", 0.0), ("if(1, 2, 1/0)", 2.0), ("3 if t else 1/0", 3.0), ("3 < 2 < 1/0", 0.0)]
    {
        assert_eq!(value(text), expected, "{text}");
    }
    // What is too large for a number is larger than any.
    for (text, expected) in [
        ("exp(1000) > 1", 1.0),
        ("1/(1 + exp(1000))", 0.0),
        ("min(exp(1000), 3)", 3.0),
        ("atan(-cosh(800))*2", -std::f64::consts::PI),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

/// Operators by their precedence in Python, lowest first: each line would be another number if its rule were another.
#[test]
fn operators_bind_as_in_python() {
    let table = [
        ("-t^2", -4.0),
        ("-t**2", -4.0),
        ("(-t)^2", 4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("2^-2^2", 0.0625),
        ("-2^-2", -0.25),
        ("2*t^2", 8.0),
        ("8/2/2", 2.0),
        ("8/2*2", 8.0),
        ("7//2*2", 6.0),
        ("-7//2", -4.0),
        ("-7%3", 2.0),
        ("7%-3", -2.0),
        ("1-2-3", -4.0),
        ("1-2+3", 2.0),
        ("1+2<4", 1.0),
        ("1<2<3", 1.0),
        ("3>2>2", 0.0),
        ("1<3>2==2", 1.0),
        ("1<2==1", 0.0),
        ("(1<2)==1", 1.0),
        ("not t", 0.0),
        ("not t==3", 1.0),
        ("not 0+1", 0.0),
        ("0 or t", 2.0),
        ("q and t", 2.0),
        ("0 and t", 0.0),
        ("t or 1/0", 2.0),
        ("1 or 0 and 0", 1.0),
        ("not 1 or 1", 1.0),
        ("1 if 0 else 2 if 0 else 3", 3.0),
        ("1 + 1 if t else 5", 2.0),
        ("if(q < 0, t, v)", 2.0),
        ("if(q > 0, 1/0, v)", 0.5),
        ("1e-3 + 2.E1 + .5 + 1_000", 1020.501),
        ("min(t, q, v) + max(t, q, v) + abs(q)", 2.0),
        ("round(0.5) + round(1.5) + round(-2.5)", 0.0),
        ("PI - pi + TAU - 2*π + τ - tau", 0.0),
        ("log(e) + ln(e) + log(8, 2) + log10(100) + log2(4)", 9.0),
        ("sign(q) + sign(0) + sign(t)", 0.0),
        ("atan2(0, -1) / pi + hypot(3, 4) + cbrt(27) + pow(2, 3)", 17.0),
        ("floor(-0.5) + ceil(0.5) + trunc(-1.5) + fract(1.5)", -0.5),
        ("degrees(pi) + radians(180) / pi", 181.0),
        ("{t} × {q} − 1 ≤ 0", 1.0),
        ("True + false", 1.0),
    ];
    for (text, expected) in table {
        // Round-off of a handful of operations.
        assert!((value(text) - expected).abs() < 1e-13, "{text}: {} and not {expected}", value(text));
    }
}

/// A tree means what its evaluation by hand gives, however few brackets it is written with.
#[test]
fn random_formulas_mean_their_trees() {
    let mut random = Random::new(11);
    let (mut finite, cases) = (0, 20_000);
    for _ in 0..cases {
        let tree = Tree::random(&mut random, 5, true);
        let at = [random.between(0.1, 3.0), random.between(-2.0, 2.0), random.between(-5.0, 5.0)];
        let expected = tree.value(&at);
        finite += usize::from(expected.is_finite());
        for style in [Style::Bracketed, Style::Sparse, Style::Python] {
            let text = tree.text(style, 0);
            let found = read(&text).value(&at);
            let same = found == expected || found.is_nan() && expected.is_nan();
            assert!(same, "{text} at {at:?}: {found} and not {expected}");
        }
    }
    assert!(finite > cases / 2, "only {finite} of {cases} have a value");
}

/// Central differences of order six: `(45 (f₁ − f₋₁) − 9 (f₂ − f₋₂) + (f₃ − f₋₃)) / 60 h`.
fn slope(f: impl Fn(f64) -> f64, x: f64, h: f64) -> f64 {
    let odd = |k: f64| f(x + k * h) - f(x - k * h);
    (45.0 * odd(1.0) - 9.0 * odd(2.0) + odd(3.0)) / (60.0 * h)
}

#[test]
fn derivatives_are_those_of_differences() {
    let mut random = Random::new(12);
    let (mut compared, mut without, cases) = (0, 0, 4_000);
    for _ in 0..cases {
        let tree = Tree::random(&mut random, 4, false);
        let formula = read(&tree.text(Style::Sparse, 0));
        let at = [random.between(0.3, 2.0), random.between(0.3, 2.0), random.between(0.3, 2.0)];
        let along = |x: f64| formula.jet(&[Jet::variable(x), Jet::constant(at[1]), Jet::constant(at[2])]);
        let now = along(at[0]);
        let size = |list: [f64; 2]| list.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
        let (coarse, fine) = (2e-3, 1e-3);
        for (exact, f, value) in [
            (now.first, &(|x| along(x).value) as &dyn Fn(f64) -> f64, now.value),
            (now.second, &|x| along(x).first, now.first),
        ] {
            let [wide, near] = [coarse, fine].map(|h| slope(f, at[0], h));
            // Only where differences themselves agree is there something to compare with.
            let scale = size([exact, value]);
            if !((wide - near).abs() < 1e-9 * scale) {
                continue;
            }
            if !exact.is_finite() {
                // What is infinite on the way has a limit, but no derivative.
                without += 1;
                continue;
            }
            compared += 1;
            // What the two differences agree to, and round-off of the values over the step.
            assert!((exact - near).abs() < 1e-8 * scale, "{} at {at:?}: {exact}, {near}", formula.text());
        }
        let (value, [by_q, by_t]) = formula.gradient(&at, [1, 0]);
        let across = formula.jet(&[Jet::constant(at[0]), Jet::variable(at[1]), Jet::constant(at[2])]).first;
        let same = |a: f64, b: f64| a == b || a.is_nan() && b.is_nan();
        assert!(same(value, now.value) && same(by_t, now.first) && same(by_q, across), "{}", formula.text());
    }
    assert!(compared > cases, "only {compared} of {} were compared", 2 * cases);
    assert!(without < cases / 100, "{without} derivatives are not finite");
}

/// Whether Python and mpmath are there; with `CI` set they must be.
fn has_python() -> bool {
    let there = Command::new("python3").args(["-c", "import mpmath"]).output();
    let found = there.is_ok_and(|output| output.status.success());
    assert!(found || std::env::var_os("CI").is_none(), "python3 with tests/python/requirements.txt must be there");
    if !found {
        eprintln!("skipped: python3 with mpmath is not there");
    }
    found
}

fn python(cases: &Value) -> Vec<Value> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("cases.json");
    std::fs::write(&file, cases.to_string()).expect("a file");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/formulas.py");
    let output = Command::new("python3").arg(script).arg(file).output().expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Values as Python's `eval` has them, derivatives as fifty digits give them.
#[test]
fn python_finds_the_same() {
    if !has_python() {
        return;
    }
    let mut random = Random::new(13);
    let mut cases = Vec::new();
    for index in 0..3_000 {
        let tree = Tree::random(&mut random, 4, true);
        let at = [random.between(0.1, 3.0), random.between(-2.0, 2.0), random.between(-5.0, 5.0)];
        let by = if index % 10 == 0 { Some("t") } else { None };
        cases.push((tree.text(Style::Python, 0), at, by));
    }
    let asked = cases.iter().map(|(text, [t, q, v], by)| json!([text, { "t": t, "q": q, "v": v }, by])).collect();
    let (mut values, mut derivatives) = (0, 0);
    for ((text, at, _), found) in cases.iter().zip(python(&asked)) {
        let Some(found) = found.as_array() else { continue };
        let number = |index: usize| found[index].as_f64();
        let ours = read(text).jet(&[Jet::variable(at[0]), Jet::constant(at[1]), Jet::constant(at[2])]);
        let pairs = [(ours.value, number(0), 1e-12), (ours.first, number(1), 1e-7), (ours.second, number(2), 1e-5)];
        for (index, (ours, theirs, digits)) in pairs.into_iter().enumerate() {
            let Some(theirs) = theirs.filter(|x| x.is_finite()) else { continue };
            // Values: the last bits of powers of whole numbers. Derivatives: what cancels in fifteen digits.
            let allowed = digits * theirs.abs().max(1.0);
            assert!((ours - theirs).abs() <= allowed, "{text} at {at:?}, derivative {index}: {ours} and {theirs}");
            *(if index == 0 { &mut values } else { &mut derivatives }) += 1;
        }
    }
    assert!(values > 1_500 && derivatives > 200, "only {values} values and {derivatives} derivatives were compared");
}

/// The cost grows with the length alone: of what made symbolic derivatives explode.
#[test]
fn long_and_deep_formulas_are_cheap() {
    let at = 0.7_f64;
    let jet = |text: &str| Formula::parse(text, &["t"]).expect("a formula").jet(&[Jet::variable(at)]);
    let sum = jet(&["t"; 2000].join("+"));
    assert_eq!((sum.first, sum.second), (2000.0, 0.0));
    // (sinⁿ)' = n sinⁿ cot, (sinⁿ)'' = n sinⁿ (n cot² − csc² )
    let n = 60.0;
    let product = jet(&["sin(t)"; 60].join("*"));
    let cot = at.tan().recip();
    let exact = n * product.value * (n * cot * cot - at.sin().powi(-2));
    assert!((product.first / (n * product.value * cot) - 1.0).abs() < 1e-13);
    assert!((product.second / exact - 1.0).abs() < 1e-13);
    let nested = jet(&format!("{}t{}", "sin(".repeat(60), ")".repeat(60)));
    let chain = (0..60).fold((at, 1.0), |(x, slope), _| (x.sin(), slope * x.cos()));
    assert_eq!(nested.value, chain.0);
    assert!((nested.first / chain.1 - 1.0).abs() < 1e-13);
}

/// Whatever is in a text, the answer is a formula or an error within the text.
#[test]
fn no_text_breaks_the_reader() {
    const PARTS: [&str; 40] = [
        "t",
        "q",
        "sin",
        "cos(",
        "min",
        "if",
        "else",
        "and",
        "or",
        "not",
        "(",
        ")",
        ",",
        "+",
        "-",
        "*",
        "/",
        "//",
        "%",
        "^",
        "**",
        "<",
        "<=",
        "==",
        "=",
        "!",
        "{",
        "}",
        "{t}",
        "1",
        "2.5",
        "1e",
        "1e-3",
        ".",
        "..",
        "π",
        "−",
        "\u{1F600}",
        "\n",
        " ",
    ];
    let (cases, mut random) = Random::for_mutations(50_000, 14);
    for _ in 0..cases {
        let text: String = (0..random.below(14)).map(|_| PARTS[random.below(PARTS.len())]).collect();
        match Formula::parse(&text, &NAMES) {
            Ok(formula) => drop(formula.jet(&[Jet::variable(0.5); 3])),
            Err(error) => {
                assert!(text.get(error.span.clone()).is_some(), "{text:?}: {error:?}");
                assert!(!error.message.is_empty());
            }
        }
    }
}

/// A run ends where a formula has no value: with the element, its text and the time.
#[test]
fn a_formula_without_a_value_ends_the_run() {
    for (list, owner) in [("motor", "motor `d`"), ("drive", "drive `d`")] {
        let text = format!(
            "[simulate]\nduration = 2\nstart = \"given\"\n[[body]]\nname = \"p\"\nmass = 1\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0] }}\n[[{list}]]\nname = \"d\"\nhinge = \"p\"\n\
             type = \"expression\"\nexpression = \"if(t < 1, t, 1/(0*t))\"\n"
        );
        let scenario = stillpoint::scenario::parse("scene.toml", &text, &[]).expect("a scene");
        let model = stillpoint::model::Model::build(&scenario.description).expect("a model");
        let start = stillpoint::simulate::State {
            position: model.start_position.clone(),
            velocity: model.start_velocity.clone(),
        };
        let mut nobody = stillpoint::record::Fanout::new();
        let settings = &scenario.simulate;
        let error = stillpoint::simulate::run(&model, settings, 10.0, &start, &mut nobody, &mut |_, _| true)
            .map(|_| ())
            .expect_err("no value after t = 1")
            .to_string();
        assert!(error.contains(owner) && error.contains("`if(t < 1, t, 1/(0*t))`"), "{error}");
        assert!(error.contains("t = 1") || error.contains("t = 0.999"), "{error}");
    }
}
