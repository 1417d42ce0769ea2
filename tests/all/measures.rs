//! What formulas of `[parameters]` measure: random formulas of known dimensions in places of known units.

use crate::common::Random;
use stillpoint::formula::Formula;
use stillpoint::quantity::Dimension;
use stillpoint::quantity::measure::Measure;
use stillpoint::scenario;

/// Powers of kg, m and s.
type Powers = [i32; 3];

/// Parameters of one unit each: name, unit, its powers.
const UNITS: [(&str, &str, Powers); 7] = [
    ("mass", "kg", [1, 0, 0]),
    ("width", "mm", [0, 1, 0]),
    ("time", "ms", [0, 0, 1]),
    ("speed", "km/h", [0, 1, -1]),
    ("weight", "kN", [1, 1, -2]),
    ("spring", "N/mm", [1, 0, -2]),
    ("ratio", "", [0, 0, 0]),
];

/// Places of one unit each: what is written before and after the number.
const PLACES: [(&str, Powers); 6] = [
    ("mass", [1, 0, 0]),
    ("length", [0, 1, 0]),
    ("stiffness", [1, 0, -2]),
    ("force", [1, 1, -2]),
    ("damping", [1, 0, -1]),
    ("gravity", [0, 1, -2]),
];

/// A scene with a formula at a place, plain numbers at all others.
fn scene(parameters: &str, place: &str, formula: &str) -> String {
    let at = |name: &str, plain: &str| if name == place { format!("\"{formula}\"") } else { plain.to_owned() };
    format!(
        "gravity = [0, 0, {}]\n[parameters]\n{parameters}[[body]]\nname = \"box\"\nmass = {}\ninertia = [1, 1, 1]\n\
         hinge = {{ type = \"prismatic\", axis = [0, 0, 1] }}\n[[force]]\ntype = \"spring\"\nlength = {}\nstiffness = {}\n\
         damping = {}\nbetween = [\"box\", {{ body = \"ground\", at = [0, 0, 9] }}]\n\
         [[force]]\nname = \"push\"\ntype = \"load\"\non = \"box\"\nforce = [{}, 0, 0]\n",
        at("gravity", "-9.8"),
        at("mass", "1"),
        at("length", "1"),
        at("stiffness", "1"),
        at("damping", "1"),
        at("force", "0"),
    )
}

/// The number at a place of a scene.
fn found(scenario: &scenario::Scenario, place: &str) -> f64 {
    let scene = &scenario.description;
    let of = |force: usize| scene.forces[force].kind.clone();
    use stillpoint::model::description::ForceKind;
    match (place, of(0), of(1)) {
        ("mass", ..) => scene.bodies[0].mass.mass,
        ("gravity", ..) => scene.gravity.z,
        ("length", ForceKind::Spring(spring), _) => spring.length,
        ("stiffness", ForceKind::Spring(spring), _) => spring.stiffness,
        ("damping", ForceKind::Spring(spring), _) => spring.damping,
        ("force", _, ForceKind::Load(load)) => load.force.x,
        _ => panic!("{place}"),
    }
}

struct Maker {
    random: Random,
    /// In SI units.
    values: [f64; UNITS.len()],
}

impl Maker {
    fn new(seed: u64) -> (Self, String) {
        let mut random = Random::new(seed);
        let mut text = String::new();
        let values = UNITS.map(|(name, unit, _)| {
            let number = random.between(0.5, 3.0);
            let written = if unit.is_empty() { format!("{number}") } else { format!("\"{number} {unit}\"") };
            text += &format!("{name} = {written}\n");
            match unit {
                "" => number,
                _ => stillpoint::quantity::Quantity::parse(&format!("{number} {unit}")).expect(unit).value,
            }
        });
        (Self { random, values }, text)
    }

    /// A formula of these powers, and its value.
    fn formula(&mut self, powers: Powers, depth: usize) -> (String, f64) {
        let one = |maker: &mut Self, at: usize| (format!("{{{}}}", UNITS[at].0), maker.values[at]);
        let fits: Vec<usize> = (0..UNITS.len()).filter(|at| UNITS[*at].2 == powers && powers != [0; 3]).collect();
        if depth == 0 {
            return match fits.first() {
                Some(at) => one(self, *at),
                None => self.product(powers),
            };
        }
        match self.random.below(7) {
            0 => {
                let ((a, x), (b, y)) = (self.formula(powers, depth - 1), self.formula(powers, depth - 1));
                (format!("({a} + {b})"), x + y)
            }
            1 => {
                let ((a, x), (b, y)) = (self.formula(powers, depth - 1), self.formula(powers, depth - 1));
                (format!("max({a}, {b})"), x.max(y))
            }
            2 => {
                let (a, x) = self.formula(powers, depth - 1);
                (format!("2*{a}/{{ratio}}"), 2.0 * x / self.values[6])
            }
            3 => {
                let (a, x) = self.formula(powers.map(|power| 2 * power), depth - 1);
                (format!("sqrt({a})"), x.sqrt())
            }
            4 => {
                // The argument of a function is the quotient of two like numbers.
                let at = self.random.below(6);
                let ((a, x), (b, y)) = (one(self, at), self.formula(UNITS[at].2, depth - 1));
                let (c, z) = self.formula(powers, depth - 1);
                (format!("{c}*exp(-min({a}/({b}), 1))"), z * (-(x / y).min(1.0)).exp())
            }
            _ => {
                let other = UNITS[self.random.below(6)];
                let rest = std::array::from_fn(|i| powers[i] - other.2[i]);
                let at = UNITS.iter().position(|unit| unit.0 == other.0).expect("one of them");
                let ((a, x), (b, y)) = (one(self, at), self.formula(rest, depth - 1));
                (format!("{a}*({b})"), x * y)
            }
        }
    }

    /// Powers of kg, m and s themselves.
    fn product(&self, powers: Powers) -> (String, f64) {
        let mut out = ("1".to_owned(), 1.0);
        for (at, power) in powers.iter().enumerate().filter(|(_, power)| **power != 0) {
            out.0 += &format!("*{{{}}}^{power}", UNITS[at].0);
            out.1 *= self.values[at].powi(*power);
        }
        out
    }
}

/// What measures right is taken, what measures anything else is refused at its place, and so is what does not add up.
#[test]
fn random_formulas_stand_only_where_their_units_do() {
    let mut counts = [0; 3];
    for seed in 0..600 {
        let (mut maker, parameters) = Maker::new(seed);
        let (place, powers) = PLACES[maker.random.below(PLACES.len())];
        let depth = 1 + maker.random.below(4);
        let (formula, value) = maker.formula(powers, depth);
        let text = scene(&parameters, place, &formula);
        let scenario = scenario::parse("s.toml", &text, &[]).unwrap_or_else(|error| panic!("{formula}: {error}"));
        // Round-off of a few dozen operations and of powers.
        assert!((found(&scenario, place) / value - 1.0).abs() < 1e-12, "{formula}");
        counts[0] += 1;
        // Another place.
        for (other, wrong) in PLACES.iter().filter(|(_, other)| *other != powers) {
            let error = scenario::parse("s.toml", &scene(&parameters, other, &formula), &[]);
            let error = error.map(|_| ()).expect_err(&formula).to_string();
            assert!(error.contains("is no unit of it") && error.contains("s.toml:"), "{formula} as {wrong:?}: {error}");
            counts[1] += 1;
        }
        // A term of another kind.
        let (other, powers_of_other) = (UNITS[maker.random.below(6)].0, powers);
        if UNITS.iter().any(|unit| unit.0 == other && unit.2 == powers_of_other) {
            continue;
        }
        for wrong in
            [format!("{formula} + {{{other}}}"), format!("min({{{other}}}, {formula})"), format!("sin({formula})")]
        {
            let error = scenario::parse("s.toml", &scene(&parameters, place, &wrong), &[]);
            let error = error.map(|_| ()).expect_err(&wrong).to_string();
            assert!(error.contains("measured in") && error.contains('^'), "{wrong}: {error}");
            counts[2] += 1;
        }
    }
    assert!(counts[0] == 600 && counts[1] > 2500 && counts[2] > 1000, "{counts:?}");
}

/// A radian counts as 1 in products of two quantities, and is kept otherwise.
#[test]
fn angles_are_kept_until_they_are_multiplied() {
    let units = [("a", "rad"), ("w", "rad/s"), ("r", "m"), ("k", "N m/rad"), ("l", "N/m"), ("f", "N"), ("t", "s")];
    let names = units.map(|(name, _)| name);
    let variables = units.map(|(_, unit)| (1.5, Measure::from(Dimension::of(unit).expect(unit))));
    let measure = |text: &str| Formula::parse(text, &names).expect(text).measure(&variables).expect(text);
    let fits = |text: &str, unit: &str| measure(text).fits(Dimension::of(unit).expect(unit));
    let right = [
        ("2*a", "rad"),
        ("w*r", "m/s"),
        ("w*t", "rad"),
        ("k*a", "N m"),
        ("l*r^2", "N m/rad"),
        ("l*r^2", "N m"),
        ("f*r/a", "N m/rad"),
        ("atan2(r, 2*r)", "rad"),
        ("asin(r/(2*r))*r", "m"),
        ("sin(a)*r", "m"),
        ("exp(-0.3*a)*f", "N"),
        ("1/(1/w)", "rad/s"),
        ("0", "kg"),
        ("a if w*r < r/t else -a", "rad"),
    ];
    right.iter().for_each(|(text, unit)| assert!(fits(text, unit), "{text} is {unit}, not {}", measure(text)));
    let wrong =
        [("2*a", "m"), ("2*k", "N m"), ("w", "m/s"), ("f*r", "N/m"), ("r/r", "kg"), ("w*t", "s"), ("asin(1)", "m")];
    wrong.iter().for_each(|(text, unit)| assert!(!fits(text, unit), "{text} is not {unit}"));
    for (text, place) in
        [("r + 2*t", 0..7), ("2^r", 2..3), ("3*cos(r)", 6..7), ("max(1, a, f)", 4..11), ("r if 1 else t", 0..13)]
    {
        let error = Formula::parse(text, &names).expect(text).measure(&variables).expect_err(text);
        assert_eq!(error.span, place, "{text}: {error}");
    }
}

/// The reproducer of the kind.
#[test]
fn a_length_is_no_mass() {
    let text = scene("m = \"500 mm\"\n", "mass", "{m}");
    insta::assert_snapshot!(scenario::parse("s.toml", &text, &[]).expect_err("a length"), @r#"
    error: body `box`: `mass`: this formula: `m` is no unit of it
     --> s.toml:6:9
      |
    6 | mass = "{m}"
      |         ^^^
      |
      = help: it is measured in kg; `m` measures a length; in a product a number without a unit is a pure number

    s.toml: 1 error
    "#);
    assert!(scenario::parse("s.toml", &scene("m = 0.5\n", "mass", "{m}"), &[]).is_ok(), "plain numbers fit everywhere");
}

/// A number that is set without a unit is meant in the SI unit of the one that it replaces.
#[test]
fn a_parameter_that_is_set_keeps_its_unit() {
    let text = scene("m = \"500 g\"\na = \"2 m/s^2\"\n", "force", "{m}*{a}");
    let read = |change: &str| {
        let change = scenario::Override::parse(change).expect("path and value");
        scenario::parse("s.toml", &text, &[change]).map(|scenario| found(&scenario, "force"))
    };
    assert_eq!(read("parameters.m=3").expect("kilograms"), 6.0);
    assert_eq!(read("parameters.m=3 g").expect("grams"), 0.006);
    assert!(read("parameters.m=3 m").expect_err("metres").to_string().contains("is no unit of it"));
}
