//! `picture`: one instant of a recording, without a window.

use super::inputs::Inputs;
use super::number::{shown_digits, time};
use super::{Exit, output, pixels, samples};
use crate::model::contact::fits;
use crate::record::drawing::{Drawing, Extras, LoadTime};
use crate::record::picture::{Eye, Frame, svg};
use crate::record::{Beyond, ContactPush, Footage, Moment, OwnedSample};
use crate::spatial::Pose;
use crate::suggest::closest;
use anyhow::{bail, ensure};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording, an MCAP file, finished or not
    recording: PathBuf,
    /// Where the picture goes: its name ends in .svg, .png or .pdf
    #[arg(long, short = 'o', value_name = "FILE.png|svg|pdf")]
    out: PathBuf,
    /// Show the sample nearest to this time; default: the first
    #[arg(long, value_name = "SECONDS", value_parser = time, allow_negative_numbers = true)]
    at: Option<f64>,
    #[command(flatten)]
    looks: Looks,
    /// Draw what the hinges pass to the bodies as arrows
    #[arg(long)]
    reactions: bool,
    /// Draw what contacts push with as arrows: green what sticks, orange what slips
    #[arg(long)]
    contacts: bool,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// How recordings are drawn.
#[derive(Debug, Args)]
pub(super) struct Looks {
    /// Where to look from: auto, front, back, left, right, top, iso, or azimuth and elevation in degrees, as `--camera=-60,20`
    #[arg(long, value_name = "CAMERA", default_value = "auto", value_parser = Eye::parse, allow_hyphen_values = true)]
    camera: Eye,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1200x800", value_parser = size)]
    size: [u32; 2],
    /// Frame these bodies and what is between them; others may leave the picture. Names with commas between them, `*` stands
    /// for anything
    #[arg(long, value_name = "BODIES", value_delimiter = ',')]
    around: Vec<String>,
    /// Draw loads as arrows, as they are at the time that is shown
    #[arg(long)]
    loads: bool,
    /// Draw the axes of the hinges as arrows
    #[arg(long)]
    hinges: bool,
    /// Read mesh files wherever the recording says that they are, not only in its own folder
    #[arg(long)]
    meshes: bool,
}

/// Bodies that have gone this many times the length of what is there at the start leave no room for the others.
const LARGEST_MOTION: f64 = 4.0;
/// Edges that a picture may have (pixels).
const EDGES: std::ops::RangeInclusive<u32> = 64..=8192;

fn size(text: &str) -> Result<[u32; 2], String> {
    let edges = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let allowed = edges.filter(|edges: &[u32; 2]| edges.iter().all(|edge| EDGES.contains(edge)));
    allowed.ok_or_else(|| {
        format!("`{text}` is no size: width and height from {} to {} pixels, as 1200x800", EDGES.start(), EDGES.end())
    })
}

impl Looks {
    /// Opens the recording; what is not drawn of it is said.
    pub(super) fn footage(&self, recording: &Path, quiet: bool) -> anyhow::Result<Footage> {
        let footage = Footage::open(recording, self.meshes)?;
        samples::warn_if_cut(&footage.recording, quiet);
        if !quiet {
            footage.notes.iter().for_each(|note| output::warning(note));
        }
        Ok(footage)
    }

    /// What is drawn, but for loads, with marks that suit the first sample, in a frame that suits the one that is shown; what cannot be drawn, and
    /// what is left outside, is said.
    pub(super) fn drawing(
        &self,
        footage: &Footage,
        [first, shown]: [&OwnedSample; 2],
        quiet: bool,
    ) -> anyhow::Result<Drawing> {
        let mut extras = Extras { hinges: self.hinges, ..Extras::default() };
        if !self.around.is_empty() {
            let names: Vec<&str> = footage.recording.scene.bodies.iter().map(|body| body.name.as_str()).collect();
            if let Some(none) = self.around.iter().find(|pattern| !names.iter().any(|name| fits(pattern, name))) {
                let near = closest(none, names.iter().copied())
                    .map_or(String::new(), |near| format!(": did you mean `{near}`?"));
                bail!("`--around {none}`: no body of `{}` is called so{near}", footage.recording.path.display());
            }
            let framed = |name: &&str| self.around.iter().any(|pattern| fits(pattern, name));
            extras.framed = names.iter().map(framed).collect();
        }
        let mut drawing = footage.drawing(&first.bodies, extras.clone());
        if let Some(stay) = stayed(footage, &drawing, [first, shown]).filter(|_| self.around.is_empty()) {
            let gone = stay.iter().filter(|stays| !**stays).count();
            drawing = footage.drawing(&first.bodies, Extras { framed: stay, ..extras });
            if !quiet {
                let what = if gone == 1 { "1 body is".to_owned() } else { format!("{gone} bodies are") };
                output::note(&format!(
                    "{what} far from where the others are, outside the picture; `--around '*'` frames all"
                ));
            }
        }
        if !quiet {
            drawing.notes.iter().for_each(|note| output::warning(note));
        }
        Ok(drawing)
    }

    /// Whether loads are drawn.
    pub(super) fn loads(&self) -> bool {
        self.loads
    }

    pub(super) fn camera(&self) -> Eye {
        self.camera
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }
}

/// Which bodies are near where they began, if some are so far that nothing could be seen of these, which are the most of what can move.
fn stayed(footage: &Footage, drawing: &Drawing, [first, shown]: [&OwnedSample; 2]) -> Option<Vec<bool>> {
    let reach = LARGEST_MOTION * drawing.length(&[first.bodies.as_slice()]);
    let moved = |(a, b): (&Pose, &Pose)| (a.translation.vector - b.translation.vector).norm();
    let stay: Vec<bool> = first.bodies.iter().zip(&shown.bodies).map(|pair| moved(pair) <= reach).collect();
    let movable = || footage.recording.scene.bodies.iter().zip(&stay).filter(|(body, _)| body.hinge != "fixed");
    let (near, all) = (movable().filter(|(_, stays)| **stays).count(), movable().count());
    (near < all && 2 * near > all).then_some(stay)
}

/// The first sample, or the one nearest to a time; that a time is beyond the recording is said.
pub(super) fn sample(footage: &Footage, at: Option<f64>, quiet: bool) -> anyhow::Result<OwnedSample> {
    if let Some(at) = at {
        ensure!(at.is_finite(), "`--at {at}` is no time");
    }
    let file = footage.recording.path.display();
    let Some(Moment { sample, beyond }) = footage.sample(at)? else {
        bail!("nothing can be drawn of `{file}`: there are no samples in it");
    };
    if let (Some(beyond), Some(at), false) = (beyond, at, quiet) {
        let (what, which) = match beyond {
            Beyond::Start => ("before `FILE` begins", "first"),
            Beyond::End => ("after the end of `FILE`", "last"),
        };
        let what = what.replace("FILE", &file.to_string());
        let time = super::text::number(sample.time);
        output::warning(&format!("`--at {at}` is {what}: its {which} sample is drawn, that at {time} s"));
    }
    Ok(sample)
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let encode = pixels::by_name(&arguments.out)?;
    Inputs::new([arguments.recording.as_path()]).spare(&arguments.out)?;
    let what = format!("drawing {}", arguments.recording.display());
    let work = output::Work::new(what, arguments.quiet || arguments.json);
    let footage = arguments.looks.footage(&arguments.recording, arguments.quiet)?;
    let shown = sample(&footage, arguments.at, arguments.quiet)?;
    let first = sample(&footage, None, arguments.quiet)?;
    let mut drawing = arguments.looks.drawing(&footage, [&first, &shown], arguments.quiet)?;
    if arguments.looks.loads() {
        drawing = drawing.with_loads(LoadTime::At(shown.time));
    }
    if let Some(loads) = footage.loads(&shown) {
        let most = loads.iter().copied().fold(0.0, f64::max);
        drawing = drawing.shaded(&loads, most, shown_digits());
    }
    if arguments.reactions {
        drawing = drawing.with_reactions(&shown.bodies, &shown.reactions);
    }
    if arguments.contacts {
        let instants = footage.recording.contacts()?;
        let nearest = |one: &&(f64, Arc<Vec<ContactPush>>), other: &&(f64, Arc<Vec<ContactPush>>)| {
            (one.0 - shown.time).abs().total_cmp(&(other.0 - shown.time).abs())
        };
        match instants.iter().min_by(nearest) {
            Some((_, pushes)) => drawing = drawing.with_contacts(pushes),
            None => output::warning(&format!("`{}` has no contacts to draw", arguments.recording.display())),
        }
    }
    let [width, height] = arguments.looks.size();
    let frame = Frame::new(&drawing, [&shown.bodies[..]], arguments.looks.camera(), [width, height]);
    output::save(&arguments.out, &encode(svg(&drawing, &shown.bodies, &frame))?)?;
    drop(work);
    let file = arguments.out.display();
    if arguments.json {
        let said = json!({ "picture": file.to_string(), "time": shown.time, "width": width, "height": height, "parts": drawing.parts.len() });
        output::print(&said.to_string())?;
    } else if !arguments.quiet {
        output::print(&format!("{file}: at {} s", super::text::number(shown.time)))?;
    }
    Ok(Exit::Done)
}
