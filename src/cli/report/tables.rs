//! Tables: modes, pose, reactions, what couplings bear, energies, events.

use super::super::number::{digits_apart, natural, number_to};
use super::super::sizes::Sizes;
use super::super::text::{UNDAMPED, number, small, without_noise};
use super::material::Material;
use crate::markup::escape;
use crate::record::Scene;
use crate::record::scene::Channel;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Rows of one table that are shown; the data have all.
const MOST_ROWS: usize = 60;

/// A table under a heading; nothing without rows. Cells are HTML.
fn table(out: &mut String, title: &str, heads: &[&str], mut rows: Vec<Vec<String>>) {
    if rows.is_empty() {
        return;
    }
    let is_number = |cell: &str| cell.trim_start_matches(['-', '−']).starts_with(|c: char| c.is_ascii_digit());
    let class = |column: usize| {
        let numbers = rows.iter().all(|row| row[column].is_empty() || is_number(&row[column]));
        if numbers && column > 0 { " class=\"number\"" } else { "" }
    };
    let classes: Vec<&str> = (0..heads.len()).map(class).collect();
    (0..heads.len()).filter(|column| !classes[*column].is_empty()).for_each(|column| align(&mut rows, column));
    // Writing to a `String` cannot fail.
    let _ = write!(out, "<h2>{}</h2><div class=\"scroll\"><table><tr>", escape(title));
    for (column, head) in heads.iter().enumerate() {
        let _ = write!(out, "<th{}>{}</th>", classes[column], escape(head));
    }
    out.push_str("</tr>\n");
    for row in rows.iter().take(MOST_ROWS) {
        out.push_str("<tr>");
        for (column, cell) in row.iter().enumerate() {
            let _ = write!(out, "<td{}>{cell}</td>", classes[column]);
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</table></div>\n");
    if rows.len() > MOST_ROWS {
        let _ = writeln!(out, "<p>… and {} more rows; the saved JSON has all.</p>", rows.len() - MOST_ROWS);
    }
}

/// Fills up the numbers of a column so that their decimal points stand below each other. Lists and powers of ten stay as they are.
fn align(rows: &mut [Vec<String>], column: usize) {
    const FIGURE: &str = "\u{2007}";
    const POINT: &str = "\u{2008}";
    // Where the number ends, and the decimals that it has.
    let number = |cell: &str| -> Option<(usize, usize)> {
        let end = cell.find(|c: char| !(c.is_ascii_digit() || matches!(c, '-' | '−' | '.'))).unwrap_or(cell.len());
        let decimals = cell[..end].find('.').map_or(0, |point| end - point - 1);
        (end > 0 && !cell[end..].starts_with(['e', ','])).then_some((end, decimals))
    };
    let most = rows.iter().filter_map(|row| number(&row[column])).map(|(_, decimals)| decimals).max().unwrap_or(0);
    for cell in rows.iter_mut().map(|row| &mut row[column]) {
        if let Some((end, decimals)) = number(cell).filter(|(_, decimals)| *decimals < most) {
            let point = if decimals == 0 { POINT } else { "" };
            cell.insert_str(end, &format!("{point}{}", FIGURE.repeat(most - decimals)));
        }
    }
}

fn list<'v>(value: &'v Value, key: &str) -> impl Iterator<Item = &'v Value> {
    value[key].as_array().into_iter().flatten()
}

/// What has names, in the order in which people count.
fn map<'v>(value: &'v Value, key: &str) -> impl Iterator<Item = (&'v String, &'v Value)> {
    let mut all: Vec<_> = value[key].as_object().into_iter().flatten().collect();
    all.sort_by(|(one, _), (other, _)| natural(one, other));
    all.into_iter()
}

/// The hinges that carry a motion, and how much of it.
fn carriers(mode: &Value) -> String {
    let share = |share: &Value| {
        let part = share["share"].as_f64().filter(|part| *part >= 0.005)?;
        Some(format!("{} {:.0} %", escape(share["hinge"].as_str()?), 100.0 * part))
    };
    list(mode, "hinges").take(3).filter_map(share).collect::<Vec<_>>().join(", ")
}

pub(super) fn modes(out: &mut String, statics: &Value) {
    let row = |(index, mode): (usize, &Value)| {
        let rate = match mode["growth_rate"].as_f64().unwrap_or_default() {
            growth if growth > 0.0 => format!("grows {} per second", number(growth)),
            _ => format!("{} Hz", number(mode["frequency_hz"].as_f64().unwrap_or_default())),
        };
        let play = format!("<button data-clip=\"mode {}:\">play</button>", index + 1);
        vec![(index + 1).to_string(), rate, carriers(mode), play]
    };
    let rows = list(statics, "modes").enumerate().map(row).collect();
    table(out, "Modes", &["mode", "frequency", "carried by", ""], rows);
    let damped = |mode: &Value| {
        let [decay, hz, ratio] =
            ["decay_rate", "frequency_hz", "damping_ratio"].map(|key| mode[key].as_f64().unwrap_or_default());
        let [decay, ratio] = if ratio.abs() < UNDAMPED { [0.0; 2] } else { [decay, ratio] };
        vec![carriers(mode), number(hz), number(decay), number(ratio)]
    };
    let rows = list(statics, "damped_modes").map(damped).collect();
    table(out, "Modes with damping", &["carried by", "frequency (Hz)", "decay rate (1/s)", "damping ratio ζ"], rows);
}

pub(super) fn pose(out: &mut String, material: &Material) {
    let unit = |body: &str, index: usize| {
        let channels = material.scene.positions.iter().filter(|channel| channel.body == body);
        channels.skip(index).map(|channel| (channel.name.as_str(), channel.unit.as_str())).next().unwrap_or_default()
    };
    let sizes = Sizes::of(&material.scene);
    let mut rows = Vec::new();
    for (body, values) in map(&material.statics, "positions") {
        for (index, value) in values.as_array().into_iter().flatten().enumerate() {
            let (name, unit) = unit(body, index);
            let value = value.as_f64().map_or(String::new(), |value| number(sizes.clean(value, unit)));
            rows.push(vec![escape(body), escape(name), value, escape(unit)]);
        }
    }
    table(out, "Pose", &["hinge of", "coordinate", "value", "unit"], rows);
    outputs(out, "Outputs at the equilibrium", material, &material.statics);
    let rows = map(&material.statics, "unknowns").map(|(name, value)| vec![escape(name), numbers(value)]).collect();
    table(out, "Inputs that were found", &["address", "value"], rows);
}

/// The outputs that an answer has, with their units.
fn outputs(out: &mut String, title: &str, material: &Material, answer: &Value) {
    let sizes = Sizes::of(&material.scene);
    let row = |(name, value): (&String, &Value)| {
        let units = units(material, name);
        let unit = |at: usize| units.get(at).copied().unwrap_or_default();
        let shown = numbers_of(value).into_iter().enumerate().map(|(at, value)| number(sizes.clean(value, unit(at))));
        let mut told: Vec<&str> = units.iter().copied().filter(|unit| *unit != "1").collect();
        told.dedup();
        vec![escape(name), shown.collect::<Vec<_>>().join(", "), escape(&told.join(", "))]
    };
    let rows = map(answer, "outputs").map(row).collect();
    table(out, title, &["output", "value", "unit"], rows);
}

/// The unit of each number of an output; none if the recording does not say it.
fn units<'m>(material: &'m Material, output: &str) -> Vec<&'m str> {
    let is_of = |channel: &&Channel| {
        let rest = channel.name.strip_prefix(output).filter(|_| channel.body.is_empty());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
    };
    material.scene.outputs.iter().filter(is_of).map(|channel| channel.unit.as_str()).collect()
}

/// The numbers of a value that is one or a list of several.
fn numbers_of(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(list) => list.iter().filter_map(Value::as_f64).collect(),
        None => value.as_f64().into_iter().collect(),
    }
}

/// One number, or several.
fn numbers(value: &Value) -> String {
    numbers_of(value).into_iter().map(number).collect::<Vec<_>>().join(", ")
}

/// Force and moment, with zero for round-off of the largest of all.
fn wrench(value: &Value, largest: [f64; 2]) -> Vec<String> {
    let part = |(key, largest): (&str, f64)| {
        let parts = list(value, key).filter_map(Value::as_f64);
        parts.map(|x| number(without_noise(x, largest))).collect::<Vec<_>>()
    };
    [("force", largest[0]), ("moment", largest[1])].into_iter().flat_map(part).collect()
}

fn largest(values: &[&Value]) -> [f64; 2] {
    ["force", "moment"].map(|key| {
        let parts = values.iter().flat_map(|value| list(value, key)).filter_map(Value::as_f64);
        parts.fold(0.0_f64, |largest, x| largest.max(x.abs()))
    })
}

const AXES: [&str; 7] = ["", "Fx (N)", "Fy (N)", "Fz (N)", "Mx (N m)", "My (N m)", "Mz (N m)"];

pub(super) fn reactions(out: &mut String, material: &Material) {
    let (statics, sizes) = (&material.statics, Sizes::of(&material.scene));
    for (key, title, head) in [
        ("reactions", "Reactions of the hinges, at the root markers, inertial axes", "hinge of"),
        ("loop_reactions", "Reactions of the loops, inertial axes", "loop"),
    ] {
        let all: Vec<&Value> = map(statics, key).map(|(_, value)| value).collect();
        let largest = sizes.of_wrenches(largest(&all));
        let row = |(name, value): (&String, &Value)| {
            let mark = if value["unique"] == false { " (not unique)" } else { "" };
            [vec![format!("{}{mark}", escape(name))], wrench(value, largest)].concat()
        };
        let mut heads = AXES;
        heads[0] = head;
        let rows = map(statics, key).map(row).filter(|row| row.len() == heads.len()).collect();
        table(out, title, &heads, rows);
    }
    couplings(out, material);
}

/// What drives, motors, ropes, curves, locks and stops bear.
fn couplings(out: &mut String, material: &Material) {
    let (statics, sizes) = (&material.statics, Sizes::of(&material.scene));
    let row = |name: &str, kind: &str, value: &Value, unit: &str| {
        let shown = numbers_of(value).into_iter().map(|force| number(sizes.clean(force, unit)));
        vec![escape(name), escape(kind), shown.collect::<Vec<_>>().join(", "), unit.to_owned()]
    };
    let along = |name: &str, kind: &str, value: &Value| row(name, kind, value, force_unit(&material.scene, name));
    let mut rows = Vec::new();
    let kind = |name: &str| if is_lock(material, name) { "lock" } else { "drive" };
    rows.extend(map(statics, "drives").map(|(name, value)| along(name, kind(name), value)));
    rows.extend(map(statics, "motors").map(|(name, value)| along(name, "motor", value)));
    rows.extend(map(statics, "pulls").map(|(name, value)| row(name, "rope or curve", value, "N")));
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    rows.extend(list(statics, "holding").map(|held| along(&text(&held["hinge"]), "lock", &held["force"])));
    let stop = |stop: &Value| along(&text(&stop["hinge"]), &format!("stop ({})", text(&stop["side"])), &stop["load"]);
    rows.extend(list(statics, "stops").map(stop));
    table(out, "Couplings", &["of", "kind", "bears", "unit"], rows);
}

/// What is borne along a coordinate is measured in, by the name of the drive or motor or that of the coordinate: `arm`, `arm (second_rate)`,
/// `arm.lock[1]`. Empty if the recording does not say it.
fn force_unit<'s>(scene: &'s Scene, name: &str) -> &'s str {
    let is_push = |channel: &&Channel| channel.body == name && matches!(channel.name.as_str(), "force" | "torque");
    if let Some(push) = scene.couplings.iter().find(is_push) {
        return &push.unit;
    }
    let (body, of_lock) = name.split_once(".lock").map_or((name, None), |(body, index)| (body, Some(index)));
    let (body, coordinate) = body.split_once(" (").map_or((body, None), |(body, rest)| (body, rest.strip_suffix(')')));
    let of_body = || scene.velocities.iter().filter(|channel| channel.body == body);
    let index = of_lock.and_then(|index| index.trim_matches(['[', ']']).parse().ok()).unwrap_or(0);
    let named = of_body().chain(&scene.positions).find(|one| one.body == body && Some(one.name.as_str()) == coordinate);
    match named.or_else(|| of_body().nth(index)).map(|channel| channel.unit.as_str()) {
        Some("m" | "m/s") => "N",
        Some("rad" | "rad/s") => "N m",
        _ => "",
    }
}

pub(super) fn run(out: &mut String, material: &Material) {
    let (outcome, sizes) = (&material.outcome, Sizes::of(&material.scene));
    let rows: Vec<(&str, &str)> = vec![
        ("kinetic and potential at the start", "energy_start"),
        ("kinetic and potential at the end", "energy_end"),
        ("put in by motors, drives and loads", "energy_work"),
        ("taken out by dampers, friction and impacts", "energy_dissipated"),
    ];
    let largest = rows.iter().filter_map(|(_, key)| outcome[*key].as_f64()).fold(0.0_f64, |m, x| m.max(x.abs()));
    let scale = sizes.of_energies(largest);
    let mut ledger: Vec<Vec<String>> = rows
        .iter()
        .filter_map(|(what, key)| Some(vec![(*what).to_owned(), number(without_noise(outcome[*key].as_f64()?, scale))]))
        .collect();
    if let Some(drift) = outcome["energy_drift"].as_f64() {
        ledger.push(vec!["not accounted for, at most".to_owned(), small(without_noise(drift, scale))]);
    }
    table(out, "Energy ledger", &["", "J"], ledger);
    events(out, material, scale);
    outputs(out, "Outputs at the end", material, outcome);
}

/// Whether a drive is what holds a hinge that a stage has locked: `body.lock`, `body.lock[1]`, and no drive of the scene.
fn is_lock(material: &Material, name: &str) -> bool {
    let held = name.split_once(".lock").filter(|(_, rest)| rest.is_empty() || rest.starts_with('['));
    held.is_some_and(|(body, _)| material.scene.bodies.iter().any(|one| one.name == body))
}

/// The events of a run. Stages are at no place: of them it is told what energy (J) the change has taken out, and their outputs.
fn events(out: &mut String, material: &Material, energy: f64) {
    let (outcome, sizes) = (&material.outcome, Sizes::of(&material.scene));
    let is_stage = |event: &Value| event["kind"] == "stage";
    let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (label, value) in list(outcome, "events").flat_map(|event| map(event, "outputs")) {
        values.entry(label).or_default().extend(value.as_f64());
    }
    let digits: BTreeMap<&str, usize> = values.iter().map(|(label, values)| (*label, digits_apart(values))).collect();
    let told = |event: &Value| {
        let each = |(label, value): (&String, &Value)| {
            let unit = units(material, label).into_iter().next().filter(|unit| *unit != "1");
            let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
            let digits = digits.get(label.as_str()).copied().unwrap_or_default();
            value.as_f64().map(|value| format!("{} {}{}", escape(label), number_to(value, digits), escape(&unit)))
        };
        map(event, "outputs").filter_map(each).collect::<Vec<_>>().join(", ")
    };
    let row = |event: &Value| {
        let text = |key: &str| escape(event[key].as_str().unwrap_or_default());
        let value = |key: &str| event[key].as_f64().map_or(String::new(), |x| number(sizes.clean_coordinate(x)));
        let time = event["time"].as_f64().map_or(String::new(), number);
        let place = match event["unit"].as_str().filter(|_| !is_stage(event)) {
            Some("1") => [value("value"), value("speed") + " 1/s"],
            Some(unit) => {
                [format!("{} {unit}", value("value")), format!("{} {unit}/s", value("speed"))].map(|one| escape(&one))
            }
            None => [String::new(), String::new()],
        };
        let lost = event["value"].as_f64().filter(|_| is_stage(event));
        let lost = lost.map_or(String::new(), |lost| number(without_noise(lost, energy)));
        let [at, speed] = place;
        vec![time, text("kind"), text("name"), at, speed, lost, told(event)]
    };
    let mut rows: Vec<Vec<String>> = list(outcome, "events").map(row).collect();
    let mut heads = vec!["time (s)", "what", "of", "at", "speed", "taken out (J)", "outputs"];
    for column in [6, 5] {
        if rows.iter().all(|row| row[column].is_empty()) {
            heads.remove(column);
            rows.iter_mut().for_each(|row| drop(row.remove(column)));
        }
    }
    table(out, "Events", &heads, rows);
}
