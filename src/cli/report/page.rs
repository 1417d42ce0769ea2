//! The page: one HTML file with everything in it.
//!
//! Its Content-Security-Policy allows the one script and the one style sheet by their hashes, and nothing from anywhere: whatever a scenario
//! names its bodies, nothing of it runs, and nothing is fetched or sent.

use super::super::number::{count, ordinal, shown_digits};
use super::material::Material;
use super::{curves, tables, words};
use crate::markup::escape;
use crate::record::drawing::shade;
use crate::record::drawing::{Drawing, Extras, Legend};
use crate::record::gltf::{Clip, glb};
use crate::record::picture::{Eye, Frame, svg};
use crate::record::{OwnedSample, Tubes};
use crate::spatial::Pose;
use anyhow::bail;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde_json::json;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::io::Write as _;
use std::time::{SystemTime, UNIX_EPOCH};

const SCRIPT: &str = include_str!("viewer.js");
const STYLE: &str = include_str!("style.css");
const SIZE: [u32; 2] = [1200, 700];
/// Numbers of the run's animation: with four bytes each in letters, and not packed, about 800 kB. Of those of all modes together: 320 kB.
const MOST_KEYS: usize = 150_000;
const MOST_MODE_KEYS: usize = 60_000;
/// The picture opens on all of a motion that takes up to this many times the length of what is there at its start, else on the start: a
/// quarter of the picture's width shows what it is.
const LARGEST_MOTION: f64 = 4.0;
/// Bytes of the still picture that stands where nothing is drawn by the browser.
const MOST_STILL: usize = 350_000;

/// The file, and what it leaves out.
pub(in crate::cli) struct Page {
    pub(super) text: String,
    pub(super) notes: Vec<String>,
}

/// JSON within a `script` element, which ends at the first `</`.
fn json_block(value: &serde_json::Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

pub(super) fn page(material: &Material) -> anyhow::Result<Page> {
    let mut notes = material.notes.clone();
    let stage = stage(material, &mut notes)?;
    let numbers = curves::numbers(material)?;
    if numbers.stride > 1 {
        notes.push(format!("the saved table has every {} sample; the recording has all", ordinal(numbers.stride)));
    }
    let answer = json!({ "statics": material.statics, "run": material.outcome });
    let data = json!({ "name": material.name, "columns": numbers.columns, "answer": answer });
    let bytes: Vec<u8> = numbers.values.iter().flat_map(|x| x.to_le_bytes()).collect();
    let title = if material.scene.title.is_empty() { &material.name } else { &material.scene.title };
    let mut out = head(title);
    let _ = write!(out, "<h1>{}</h1>\n<p class=\"about\">{}</p>\n", escape(title), about(material));
    let verdict = words::verdict(material);
    let class = if verdict.fine { "fine" } else { "wrong" };
    let _ = writeln!(out, "<p class=\"verdict {class}\">{}</p>", prose(&verdict.text));
    out += &stage.html;
    paragraphs(&mut out, "Certificate", &words::certificate(&material.statics));
    tables::modes(&mut out, &material.statics);
    tables::pose(&mut out, material);
    tables::reactions(&mut out, material);
    paragraphs(&mut out, "The run", &words::errors(&material.outcome));
    tables::run(&mut out, material);
    let drawn = curves::curves(material)?;
    if !drawn.is_empty() {
        let _ = writeln!(out, "<h2>Curves</h2>\n<div class=\"curves\">{}</div>", drawn.concat());
    }
    let told = material.statics["notes"].as_array().into_iter().flatten().filter_map(|note| note.as_str());
    notes.extend(told.map(str::to_owned));
    paragraphs(&mut out, "Not taken over from the model", &material.ignored);
    paragraphs(&mut out, "Notes", &notes);
    saves(&mut out, material);
    let _ = write!(
        out,
        "<h2>Scenario</h2>\n<pre id=\"scenario\">{}</pre>\n\
         <script type=\"application/json\" id=\"look\">{}</script>\n<script type=\"application/json\" id=\"data\">{}</script>\n\
         {}{}<script>{SCRIPT}</script>\n</body>\n</html>\n",
        escape(&material.scenario),
        json_block(&stage.look),
        json_block(&data),
        packed("numbers", &bytes)?,
        packed("glb", &stage.glb)?,
    );
    Ok(Page { text: out, notes })
}

/// Bytes in the page, deflated: what moves repeats itself.
fn packed(id: &str, bytes: &[u8]) -> std::io::Result<String> {
    let mut deflated = DeflateEncoder::new(Vec::new(), Compression::best());
    deflated.write_all(bytes)?;
    Ok(format!(
        "<script type=\"application/octet-stream\" id=\"{id}\" data-size=\"{}\">{}</script>\n",
        bytes.len(),
        STANDARD.encode(deflated.finish()?)
    ))
}

/// A sentence, what stands in backticks as code.
fn prose(text: &str) -> String {
    let text = escape(text);
    let parts: Vec<&str> = text.split('`').collect();
    // One that is not closed is no quotation mark.
    let quoted = (parts.len() - 1) / 2;
    let part = |(index, part): (usize, &&str)| match index {
        0 => (*part).to_owned(),
        _ if index > 2 * quoted => format!("`{part}"),
        _ if index % 2 == 1 => format!("<code>{part}"),
        _ => format!("</code>{part}"),
    };
    parts.iter().enumerate().map(part).collect()
}

fn head(title: &str) -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    let policy = format!(
        "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; base-uri 'none'; form-action 'none'",
        hash(SCRIPT),
        hash(STYLE)
    );
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n",
        escape(title)
    )
}

/// Size, version, date and command.
fn about(material: &Material) -> String {
    let size = match material.scene.extent {
        Some(extent) => format!(
            "{}, {}",
            count(extent.bodies, "body", "bodies"),
            count(extent.freedoms, "degree of freedom", "degrees of freedom")
        ),
        // A recording of an old version says no more.
        None => format!("{} hinge coordinates", material.scene.positions.len()),
    };
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let command = material.called.clone().unwrap_or_else(|| {
        let words: Vec<String> = std::env::args().skip(1).collect();
        format!("stillpoint {}", words.join(" "))
    });
    format!(
        "{size}. Computed by stillpoint {} on {}: <code>{}</code>",
        escape(&material.version),
        date(seconds),
        escape(&command)
    )
}

/// The day in the Gregorian calendar, UTC, from seconds since 1970 (Hinnant, chrono-compatible low-level date algorithms, 2013).
fn date(seconds: u64) -> String {
    let days = seconds / 86_400 + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = year_of_era + 400 * era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02}")
}

fn paragraphs(out: &mut String, title: &str, lines: &[String]) {
    if !lines.is_empty() {
        let _ = writeln!(out, "<h2>{title}</h2>");
        lines.iter().for_each(|line| {
            let _ = writeln!(out, "<p>{}</p>", prose(line));
        });
    }
}

/// What moves: HTML, file, and where it is seen from.
struct Stage {
    html: String,
    glb: Vec<u8>,
    look: serde_json::Value,
}

fn stage(material: &Material, notes: &mut Vec<String>) -> anyhow::Result<Stage> {
    let clips = clips(material, notes);
    let Some(first) = clips.iter().flat_map(|clip| &clip.poses).next() else {
        bail!("there is nothing to show: the recording has no samples");
    };
    let mut drawing = Drawing::new(&material.scene, first, Extras::default());
    if let Some(loads) = clips[0].loads.first() {
        let most = clips.iter().flat_map(|clip| clip.loads.iter().flatten()).copied().fold(0.0, f64::max);
        drawing = drawing.shaded(loads, most, shown_digits());
    }
    let legend = drawing.legend.as_ref().map_or(String::new(), |legend| legend_bar(legend, clips[0].loads.len() > 1));
    notes.extend(drawing.notes.iter().cloned());
    let every = clips.iter().flat_map(|clip| clip.poses.iter().step_by(clip.poses.len().div_ceil(64)));
    let whole: Vec<&[Pose]> = every.map(Vec::as_slice).collect();
    let start = [first.as_slice()];
    // A flight of a kilometre would leave nothing to be seen of what it begins with.
    let is_wide = drawing.length(&whole) > LARGEST_MOTION * drawing.length(&start);
    let frame = |poses: &[&[Pose]]| Frame::new(&drawing, poses.iter().copied(), Eye::Auto, SIZE);
    let still = svg(&drawing, first, &frame(if is_wide { &start } else { &whole }));
    let still = if still.len() <= MOST_STILL { still } else { String::new() };
    let html = format!(
        "<div id=\"stage\"><canvas id=\"canvas\" hidden></canvas><div id=\"still\">{still}</div></div>\n\
         <p id=\"still-note\" hidden>This browser draws no WebGL: the picture stays still.</p>\n\
         <div id=\"controls\" hidden><button id=\"play\" title=\"play or stop\">▶</button>\
         <select id=\"clip\" title=\"which motion\"></select>\
         <input id=\"slider\" type=\"range\" min=\"0\" max=\"1\" step=\"any\" value=\"0\" aria-label=\"time\"><span id=\"time\"></span>\
         <button id=\"view\" title=\"what is in the picture\"></button></div>\n{legend}"
    );
    let look = json!({
        "views": { "start": frame(&start).look(&drawing, &start), "all": frame(&whole).look(&drawing, &whole) },
        "opens": if is_wide { "start" } else { "all" },
    });
    let title = &material.scene.title;
    Ok(Stage { html, glb: glb(&drawing, title, first, &clips).bytes, look })
}

/// What the colours of beams mean; of a motion those of the largest value in it.
fn legend_bar(legend: &Legend, moves: bool) -> String {
    let stops = (0..=8).map(|k| shade(f64::from(k) / 8.0).map(|part| (255.0 * part).round() as u8));
    let rects = stops.enumerate().map(|(k, [r, g, b])| {
        format!("<rect x=\"{}\" width=\"20\" height=\"12\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>", 20 * k)
    });
    let which = if moves { ", the largest of the motion" } else { "" };
    format!(
        "<p class=\"about\">0 <svg width=\"180\" height=\"12\" role=\"img\" aria-label=\"colours\">{}</svg> {} {}: {}{which}</p>\n",
        rects.collect::<String>(),
        legend.number(),
        legend.unit,
        legend.what
    )
}

/// The run first, then modes; with as many frames as a page can hold.
fn clips(material: &Material, notes: &mut Vec<String>) -> Vec<Clip> {
    let rings = Tubes::new(&material.scene).count();
    let numbers = 7 * (material.scene.bodies.len() + rings)
        + 10 * material.scene.lines.len()
        + 14 * material.scene.bushings.len()
        + 1;
    let frames = |most: usize| (most / numbers).max(2);
    let stride = material.samples.len().div_ceil(frames(MOST_KEYS)).max(1);
    if stride > 1 {
        notes.push(format!("the picture moves by every {} sample; the recording has all", ordinal(stride)));
    }
    let mut clips = Vec::new();
    if !material.samples.is_empty() {
        let kept = || material.samples.iter().step_by(stride);
        let tubes = Tubes::new(&material.scene);
        let placed = |sample: &OwnedSample| {
            let mut poses = sample.bodies.clone();
            tubes.extend(&sample.positions, &mut poses);
            poses
        };
        let (times, poses) = (kept().map(|s| s.time).collect(), kept().map(placed).collect::<Vec<_>>());
        let known = poses.iter().zip(kept()).filter(|_| !tubes.is_empty());
        let loads = known.map(|(poses, sample)| tubes.loads(poses, &sample.reactions)).collect();
        clips.push(Clip { name: "run".to_owned(), times, poses, loads });
    }
    let modes = material.clips.iter().map(|clip| clip.times.len()).sum::<usize>();
    let stride = modes.div_ceil(frames(MOST_MODE_KEYS)).max(1);
    clips.extend(material.clips.iter().map(|clip| Clip {
        name: clip.name.clone(),
        times: clip.times.iter().step_by(stride).copied().collect(),
        poses: clip.poses.iter().step_by(stride).cloned().collect(),
        loads: clip.loads.iter().step_by(stride).cloned().collect(),
    }));
    clips
}

fn saves(out: &mut String, material: &Material) {
    out.push_str("<h2>Save</h2>\n<p class=\"save\"><button id=\"save-scenario\">scenario (TOML)</button> ");
    if !material.samples.is_empty() {
        out.push_str("<button id=\"save-csv\">numbers (CSV, single precision)</button> ");
    }
    out.push_str(
        "<button id=\"save-json\">answers (JSON)</button> <button id=\"save-glb\">picture that moves (glTF)</button></p>\n",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backticks_become_code() {
        assert_eq!(prose("use `--verify` & `<x>`."), "use <code>--verify</code> &amp; <code>&lt;x&gt;</code>.");
        assert_eq!((prose("a ` b").as_str(), prose("plain").as_str()), ("a ` b", "plain"));
    }

    #[test]
    fn days_are_those_of_the_calendar() {
        let days = [0, 951_782_400, 951_868_800, 4_107_542_400, 1_767_225_599];
        assert_eq!(days.map(date), ["1970-01-01", "2000-02-29", "2000-03-01", "2100-03-01", "2025-12-31"]);
    }
}
