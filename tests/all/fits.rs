//! Fits to measurements: against closed forms and against SciPy's least squares on the same data.

use assert_cmd::Command;
use serde_json::Value;
use std::path::PathBuf;
use stillpoint::scenario::{Override, parse};
use stillpoint::study::fit::table::MeasuredTable;
use stillpoint::study::fit::{Adjusted, Fit, FitQuestion, Trouble, fit};

/// A weight on a spring that carries it at `z = rest − m g / k`.
const SCALE: &str = "[[body]]\nname = \"pan\"\nmass = 2.0\n\
    hinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 100.0, damping = 1.0 }\n\
    [[output]]\nname = \"z\"\ntype = \"coordinate\"\nof = \"pan\"\n";
const G: f64 = 9.80665;

fn question(parameters: &[&str]) -> FitQuestion {
    let parameters = parameters.iter().map(|text| Adjusted::parse(text).unwrap()).collect();
    FitQuestion { parameters, run: false, deviations: Vec::new(), ignored: Vec::new(), level: 0.95 }
}

fn table(columns: &[(&str, &[f64])]) -> MeasuredTable {
    MeasuredTable::new(columns.iter().map(|(name, values)| ((*name).to_owned(), values.to_vec())).collect()).unwrap()
}

fn fitted(text: &str, table: &MeasuredTable, question: &FitQuestion) -> Result<Fit, Trouble> {
    let scenario = parse("scale.toml", text, &[]).unwrap();
    fit(&scenario, &[] as &[Override], table, question, &|| true)
}

const MASSES: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];
const HEIGHTS: [f64; 5] = [-0.05, -0.14, -0.27, -0.33, -0.46];

/// The line through these points: offset, slope, their standard errors, and the degrees of freedom are three.
fn line() -> [f64; 4] {
    let n = MASSES.len() as f64;
    let (mean, high) = (MASSES.iter().sum::<f64>() / n, HEIGHTS.iter().sum::<f64>() / n);
    let square: f64 = MASSES.iter().map(|m| (m - mean).powi(2)).sum();
    let slope = MASSES.iter().zip(HEIGHTS).map(|(m, z)| (m - mean) * (z - high)).sum::<f64>() / square;
    let offset = high - slope * mean;
    let left: f64 = MASSES.iter().zip(HEIGHTS).map(|(m, z)| (z - offset - slope * m).powi(2)).sum();
    let variance = left / (n - 2.0);
    [offset, slope, (variance * (1.0 / n + mean * mean / square)).sqrt(), (variance / square).sqrt()]
}

/// `z = rest − m g / k` is a line in the mass: regression gives `rest` and `g / k`, and errors go from `g / k` to `k` by `k² / g`.
#[test]
fn a_spring_scale_is_calibrated_as_by_linear_regression() {
    let table = table(&[("pan.mass", &MASSES), ("z", &HEIGHTS)]);
    let found = fitted(SCALE, &table, &question(&["pan.stiffness", "pan.rest"])).unwrap();
    let [offset, slope, of_offset, of_slope] = line();
    let k = -G / slope;
    assert!(found.converged && found.by_differences.is_empty(), "{found:?}");
    for (one, expected, error) in [(0, k, k * k / G * of_slope), (1, offset, of_offset)] {
        let one = &found.parameters[one];
        assert!((one.value - expected).abs() < 1e-8 * expected.abs(), "{one:?}: {expected}");
        // The Jacobian is exact to 1e-10 and the minimum found to 1e-9.
        assert!((one.error.unwrap() - error).abs() < 1e-7 * error, "{one:?}: {error}");
        // Student's t of three degrees of freedom, 97.5 %: tables.
        let [low, high] = one.interval.unwrap();
        assert!((0.5 * (high - low) / error - 3.182_446_305).abs() < 1e-6, "{one:?}");
    }
    assert_eq!(found.freedom, 3);
    assert!(found.parameters[0].unit == "N/m" && found.columns[0].count == 5);
}

#[test]
fn units_missing_cells_and_coordinates_are_understood() {
    let millimetres = HEIGHTS.map(|z| 1e3 * z);
    let mut with_gap = vec![f64::NAN];
    with_gap.extend(millimetres);
    let mut masses = vec![7.0];
    masses.extend(MASSES);
    let table = table(&[("pan.mass", &masses), ("pan.z [mm]", &with_gap)]);
    // The coordinate has a name of its own in tables, and needs no output.
    let name = stillpoint::model::Model::build(&parse("scale.toml", SCALE, &[]).unwrap().description).unwrap();
    let own = name.bodies[0].hinge.kind.positions()[0].0;
    let table = MeasuredTable {
        columns: table
            .columns
            .into_iter()
            .map(|mut column| {
                column.name = column.name.replace("pan.z", &format!("pan.{own}"));
                column
            })
            .collect(),
    };
    let without = SCALE.split("[[output]]").next().unwrap();
    let found = fitted(without, &table, &question(&["pan.stiffness", "pan.rest"])).unwrap();
    let [_, slope, ..] = line();
    assert!((found.parameters[0].value + G / slope).abs() < 1e-6, "{found:?}");
    assert!(found.columns[0].count == 5 && found.columns[0].left[0].is_none());
}

#[test]
fn what_the_data_does_not_determine_is_named() {
    // With one mass alone k and rest make one number: z.
    let same = table(&[("pan.mass", &[2.0; 4]), ("z", &[-0.2, -0.21, -0.19, -0.2])]);
    let found = fitted(SCALE, &same, &question(&["pan.stiffness", "pan.rest"])).unwrap();
    assert!(found.parameters.iter().all(|one| one.error.is_none()), "{found:?}");
    let names: Vec<&str> = found.together[0].iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["pan.stiffness", "pan.rest"]);
    // ∂z/∂k = m g / k² beside ∂z/∂rest = 1: nothing changes along (1, −m g / k²).
    let k = found.parameters[0].value;
    assert!((found.together[0][1].1 + 2.0 * G / (k * k)).abs() < 1e-9, "{found:?}");
    // Damping moves no equilibrium.
    let with = SCALE.replace("damping = 1.0", "damping = \"{c}\"") + "[parameters]\nc = 1.0\n";
    let with = format!("[parameters]\nc = 1.0\n{}", with.replace("[parameters]\nc = 1.0\n", ""));
    let lines = table(&[("pan.mass", &MASSES), ("z", &HEIGHTS)]);
    let found = fitted(&with, &lines, &question(&["pan.stiffness", "parameters.c"])).unwrap();
    assert_eq!(found.unfelt, ["parameters.c"]);
    assert!(found.parameters[0].error.is_some() && found.parameters[1].value == 1.0, "{found:?}");
}

#[test]
fn a_bound_holds() {
    let table = table(&[("pan.mass", &MASSES), ("z", &HEIGHTS)]);
    let [offset, slope, ..] = line();
    let bound = -0.8 * G / slope;
    let range = format!("pan.stiffness=50,10..{bound:?}");
    let found = fitted(SCALE, &table, &question(&[&range, "pan.rest"])).unwrap();
    let [k, rest] = [0, 1].map(|j| &found.parameters[j]);
    assert!(k.is_held && k.value == bound && k.error.is_none(), "{k:?}");
    // With a slope that is given the least squares are through the means.
    let mean = MASSES.iter().sum::<f64>() / 5.0;
    let expected = HEIGHTS.iter().sum::<f64>() / 5.0 + G / bound * mean;
    assert!((rest.value - expected).abs() < 1e-9 && rest.error.is_some(), "{rest:?} {expected} {offset}");
    assert!(found.notes.iter().any(|note| note.contains("`pan.stiffness` is held")), "{:?}", found.notes);
}

/// `x(t) = x₀ e^(−δt) (cos ωt + δ/ω sin ωt)`, `δ = c/2m`, `ω² = k/m − δ²`: what is sampled there is found again.
#[test]
fn a_swinging_weight_gives_its_spring_and_its_damper() {
    let (m, k, c, x0) = (2.0, 130.0_f64, 3.0, 0.1);
    let delta = c / (2.0 * m);
    let omega = (k / m - delta * delta).sqrt();
    // Not on a grid, and one instant twice.
    let times: Vec<f64> = [0.0, 0.11, 0.2, 0.31, 0.31, 0.43, 0.7, 0.95, 1.2, 1.5].to_vec();
    let x = |t: f64| x0 * (-delta * t).exp() * ((omega * t).cos() + delta / omega * (omega * t).sin());
    let heights: Vec<f64> = times.iter().map(|t| x(*t)).collect();
    let text = format!(
        "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\ntolerance = 1e-10\n{}",
        SCALE.replace("damping = 1.0", "damping = 1.0, position = 0.1")
    );
    let question = FitQuestion { run: true, ..question(&["pan.stiffness", "pan.damping=1,0.."]) };
    let found = fitted(&text, &table(&[("time", &times), ("z", &heights)]), &question).unwrap();
    assert!(found.converged, "{found:?}");
    for (one, expected) in found.parameters.iter().zip([k, c]) {
        // What the integrator leaves open of a swing, over what it moves.
        assert!((one.value - expected).abs() < 1e-6 * expected, "{one:?}");
    }
    assert_eq!(found.by_differences, ["pan.stiffness", "pan.damping"]);
}

#[test]
fn what_does_not_fit_together_is_refused_with_its_name() {
    let lines = || table(&[("pan.mass", &MASSES), ("z", &HEIGHTS)]);
    let why = |table: &MeasuredTable, question: &FitQuestion| fitted(SCALE, table, question).unwrap_err().to_string();
    let stiffness = question(&["pan.stiffness"]);
    for (table, question, expected) in [
        (table(&[("pan.mas", &MASSES), ("z", &HEIGHTS)]), stiffness.clone(), "did you mean `pan.mass`?"),
        (table(&[("pan.mass", &MASSES), ("zz", &HEIGHTS)]), stiffness.clone(), "neither an output nor a number"),
        (table(&[("pan.mass", &MASSES)]), stiffness.clone(), "no column is something measured"),
        (table(&[("pan.mass [m]", &MASSES), ("z", &HEIGHTS)]), stiffness.clone(), "measured in kg"),
        (table(&[("pan.mass", &[1.0, f64::NAN]), ("z", &[0.1, 0.2])]), stiffness.clone(), "no number in row 2"),
        (lines(), question(&["pan.stifness"]), "did you mean `stiffness`?"),
        (lines(), question(&["pan.mass"]), "a column of the data and a parameter at once"),
        (lines(), question(&["pan.rest", "pan.rest"]), "a parameter twice"),
        (lines(), question(&["pan.stiffness=500,200..1e3", "pan.rest=3,0..1.5e3"]), ""),
        (lines(), FitQuestion { run: true, ..stiffness.clone() }, "needs a column `time`"),
        (lines(), FitQuestion { ignored: vec!["zz".into()], ..stiffness.clone() }, "no column `zz` to ignore"),
        (
            lines(),
            FitQuestion { deviations: vec![("pan.mass".into(), 1.0)], ..stiffness.clone() },
            "no measured column",
        ),
        (table(&[("time", &MASSES), ("z", &HEIGHTS)]), stiffness.clone(), "`--run`"),
        (table(&[("pan.mass", &[1.0, -1.0]), ("z", &[0.1, 0.2])]), stiffness.clone(), "row 2 of the data"),
    ] {
        if expected.is_empty() {
            assert!(fitted(SCALE, &table, &question).is_ok());
            continue;
        }
        let message = why(&table, &question);
        assert!(message.contains(expected), "{message}");
    }
}

fn rig(data: &str, more: &[&str]) -> (Option<i32>, Value, String) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios/fits");
    let mut command = Command::cargo_bin("stillpoint").unwrap();
    command.arg("study").arg(folder.join("test_rig.toml")).arg("--fit").arg(folder.join(data)).arg("--json").args(more);
    let answer = command.output().unwrap();
    let json = serde_json::from_slice(&answer.stdout).unwrap_or(Value::Null);
    (answer.status.code(), json, String::from_utf8(answer.stderr).unwrap())
}

/// By SciPy: value and standard error of `arm.stiffness` and `arm.rest` at rest, of these and `arm.damping` while it swings.
const STATIC: [[f64; 2]; 2] = [[32.365_712_001_574, 0.075_745_304_033], [0.120_960_553_668, 0.000_753_305_078]];
const SWING: [[f64; 2]; 3] = [
    [32.487_217_425_562, 0.008_936_838_157],
    [0.119_749_688_621, 0.000_206_893_46],
    [0.179_983_514_487, 0.000_403_596_232],
];
/// Root of the mean square of what is left (rad).
const STATIC_RMS: f64 = 0.001_254_931_763;
const SWING_RMS: f64 = 0.002_079_607_909;
/// Of stiffness and rest, at rest.
const CORRELATION: f64 = -0.894_454_304_5;

/// Values, standard errors and rms of `scipy.optimize.least_squares` (trf, exact Jacobian) on the same files: of the balance
/// `k (q − q₀) = −(m g l + F L) cos q`, and of its equation of motion integrated with DOP853 to 1e-12.
#[test]
fn the_test_rig_is_fitted_as_by_scipy() {
    let (code, still, error) = rig("test_rig_static.csv", &["--parameter", "arm.stiffness", "arm.rest"]);
    assert_eq!(code, Some(0), "{error}");
    let (code, swing, error) =
        rig("test_rig_swing.csv", &["--run", "--parameter", "arm.stiffness", "arm.rest", "arm.damping=0.1"]);
    assert_eq!(code, Some(0), "{error}");
    let expected: [(&Value, &[[f64; 2]], f64, f64); 2] = [
        (&still, &STATIC, STATIC_RMS, 1e-6),
        // Differences between runs at 1e-9.
        (&swing, &SWING, SWING_RMS, 1e-4),
    ];
    for (found, parameters, rms, tolerance) in expected {
        for (one, [value, error]) in found["parameters"].as_array().unwrap().iter().zip(parameters) {
            let of = |key: &str| one[key].as_f64().unwrap();
            // The minimum is found far closer than the data determines it.
            assert!((of("value") - value).abs() < tolerance * error, "{one}: {value}");
            assert!((of("standard_error") - error).abs() < 10.0 * tolerance * error, "{one}: {error}");
        }
        let left = found["columns"][0]["rms"].as_f64().unwrap();
        assert!((left - rms).abs() < 1e-6 * rms, "{left} {rms}");
    }
    assert!((still["correlations"][0][1].as_f64().unwrap() - CORRELATION).abs() < 1e-6);
    assert!(still["set"][0].as_str().unwrap().starts_with("arm.stiffness=32.3657"));
}

#[test]
fn the_program_says_which_line_is_no_number() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data.csv");
    std::fs::write(&data, "weight.force[2],angle\n-1,0.1\n-2,much\n").unwrap();
    let (code, _, error) = rig(data.to_str().unwrap(), &["--parameter", "arm.stiffness"]);
    assert_eq!(code, Some(2));
    assert!(error.contains("line 3: `much` in `angle`"), "{error}");
}

/// A table in which nothing was measured is refused with its file and the column.
#[test]
fn a_column_without_a_measurement_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data.csv");
    std::fs::write(&data, "weight.force[2],angle\n-1,\n-2,nan\n").unwrap();
    let (code, _, error) = rig(data.to_str().unwrap(), &["--parameter", "arm.stiffness"]);
    assert_eq!(code, Some(2));
    assert!(error.contains("data.csv: nothing was measured in `angle`"), "{error}");
}

/// Heights that are the better explained the stiffer the spring is: the pan hangs below zero, and was read above.
const ABOVE: [f64; 3] = [0.02, 0.04, 0.05];

fn above(parameters: &[&str]) -> Fit {
    fitted(SCALE, &table(&[("pan.mass", &MASSES[..3]), ("z", &ABOVE)]), &question(parameters)).unwrap()
}

/// `z = −m g / k` comes from below to zero, from which the readings are on the other side.
#[test]
fn a_sum_of_squares_that_falls_all_the_way_is_no_minimum() {
    let found = above(&["pan.stiffness"]);
    let k = &found.parameters[0];
    assert!(!found.converged && k.runs_off && k.error.is_none() && k.interval.is_none(), "{found:?}");
    assert!(
        found.notes[0].contains("`pan.stiffness` runs off: the sum of squares has no minimum"),
        "{:?}",
        found.notes
    );
    assert!(!found.notes.iter().any(|note| note.contains("stays where it was")), "{:?}", found.notes);
}

/// Beside it the weight of the pan makes `z` the better the lighter it is; there is no mass of zero.
#[test]
fn what_falls_towards_zero_runs_off_too() {
    let scene = SCALE.replace("mass = 2.0", "mass = 1.0");
    let table = table(&[("gravity[2]", &[-8.0, -9.0, -10.0]), ("z", &ABOVE)]);
    let found = fitted(&scene, &table, &question(&["pan.mass"])).unwrap();
    assert!(!found.converged && found.parameters[0].runs_off, "{found:?}");
    assert!(found.notes[0].contains("to zero"), "{:?}", found.notes);
    assert!(found.parameters[0].value < 1e-3, "{found:?}");
}

/// Of two parameters the one that has a minimum is not said to run off: at infinite stiffness `rest` would be the mean.
#[test]
fn only_what_runs_off_is_named_beside_others() {
    // Heights that fall less with the mass than any spring lets them: they rise.
    let found = above(&["pan.stiffness", "pan.rest"]);
    assert!(!found.converged && found.parameters[0].runs_off && !found.parameters[1].runs_off, "{found:?}");
    let mean = ABOVE.iter().sum::<f64>() / 3.0;
    assert!((found.parameters[1].value - mean).abs() < 1e-3, "{found:?}");
}

#[test]
fn what_falls_as_far_as_a_bound_is_held_there() {
    for end in [1e3, 1e9, 1e15] {
        let found = above(&[&format!("pan.stiffness=100,1..{end:?}")]);
        let k = &found.parameters[0];
        assert!(found.converged && k.is_held && k.value == end && !k.runs_off, "{end}: {found:?}");
    }
}

/// A cell that is `nan` counts as an empty one, and that is said.
#[test]
fn cells_without_a_number_are_counted() {
    let mut heights = HEIGHTS;
    heights[1] = f64::NAN;
    let found =
        fitted(SCALE, &table(&[("pan.mass", &MASSES), ("z", &heights)]), &question(&["pan.stiffness"])).unwrap();
    assert_eq!(found.columns[0].count, 4);
    let said = "1 cell of `z` is empty or `nan`: nothing was measured there";
    assert!(found.notes.iter().any(|note| note == said), "{:?}", found.notes);
}

#[test]
fn a_fit_that_runs_off_has_exit_code_one() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("up.csv");
    std::fs::write(&data, "weight.force[2],angle\n0,0.05\n-5,0.09\n-9,0.12\n").unwrap();
    let (code, json, error) = rig(data.to_str().unwrap(), &["--parameter", "arm.stiffness"]);
    assert_eq!(code, Some(1), "{error}");
    assert!(json["converged"] == false && json["parameters"][0]["runs_off"] == true, "{json}");
}
