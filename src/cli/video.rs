//! `video`: a recording as a film, without a window.

mod colors;

use super::inputs::Inputs;
use super::output::{Interrupt, Progress};
use super::picture::{self, Looks};
use super::{Exit, number, output};
use crate::record::drawing::{Drawing, LoadTime};
use crate::record::gltf::Clip;
use crate::record::picture::{Frame, Painter, Pixels, svg};
use crate::whole_file::WholeFile;
use anyhow::{Context, bail};
use clap::Args;
use colors::Indexed;
use gif::{Encoder, Repeat};
use serde_json::json;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::sync_channel;
use std::thread;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording, an MCAP file, finished or not
    recording: PathBuf,
    /// Where the film goes: its name ends in .gif or .mp4 (if `ffmpeg` is installed, else PNG pictures in a folder of that name)
    #[arg(long, short = 'o', value_name = "FILE.gif|mp4")]
    out: PathBuf,
    /// Pictures per second
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u16).range(1..=100))]
    rate: u16,
    /// Seconds of simulated time in a second of the film
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    speed: f64,
    #[command(flatten)]
    looks: Looks,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// Pictures that are painted before they are needed, at most.
const AHEAD: usize = 2;
/// A film of more pictures is not meant.
const MOST_PICTURES: usize = 100_000;

/// What takes one picture after the other.
trait Reel {
    fn add(&mut self, pixels: &Pixels) -> anyhow::Result<()>;

    /// Ends the film and returns what was written.
    fn finish(self: Box<Self>) -> anyhow::Result<PathBuf>;
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    if !(arguments.speed > 0.0 && arguments.speed.is_finite()) {
        bail!("`--speed {}`: a film has a positive speed", arguments.speed);
    }
    Inputs::new([arguments.recording.as_path()]).spare(&arguments.out)?;
    let footage = arguments.looks.footage(&arguments.recording, arguments.quiet)?;
    let first = picture::sample(&footage, None, arguments.quiet)?;
    let drawing = arguments.looks.drawing(&footage, [&first, &first], arguments.quiet)?;
    let clips = footage.clips()?;
    let interrupt = Interrupt::install()?;
    let poses = clips.iter().flat_map(|clip| &clip.poses).map(Vec::as_slice);
    let (camera, size) = (arguments.looks.camera(), arguments.looks.size());
    let frame = match arguments.looks.loads() {
        true => Frame::new(&drawing.clone().with_loads(LoadTime::All), poses, camera, size),
        false => Frame::new(&drawing, poses, camera, size),
    };
    let shown = moments(&clips, arguments)?;
    let mut reel = arguments.reel()?;
    let mut progress = Progress::new(1.0, arguments.quiet || arguments.json);
    let most = clips.iter().flat_map(|clip| clip.loads.iter().flatten()).copied().fold(0.0, f64::max);
    let has_loads = arguments.looks.loads();
    let (painted, next) = sync_channel(AHEAD);
    let (clips, drawing, frame, order) = (&clips, &drawing, &frame, &shown);
    // One thread paints what the other encodes.
    let is_whole = thread::scope(|scope| {
        scope.spawn(move || {
            let painter = Painter::default();
            for (clip, index) in order {
                let clip = &clips[*clip];
                let with_loads = || drawing.clone().with_loads(LoadTime::At(clip.times[*index]));
                let drawing = if has_loads { &with_loads() } else { drawing };
                if painted.send(paint(&painter, drawing, (clip, *index), frame, most)).is_err() {
                    break;
                }
            }
        });
        // Dropped with a film that ends early, for which nobody paints on.
        for (number, pixels) in next.into_iter().enumerate() {
            if interrupt.requested() {
                return Ok(false);
            }
            progress.part(number as f64 / order.len() as f64);
            reel.add(&pixels?)?;
        }
        anyhow::Ok(true)
    })?;
    if !is_whole {
        return Ok(Exit::Interrupted);
    }
    drop(progress);
    let written = reel.finish()?;
    if arguments.json {
        output::print(&json!({ "video": written.display().to_string(), "pictures": shown.len() }).to_string())?;
    } else if !arguments.quiet {
        let pictures = number::count(shown.len(), "picture", "pictures");
        output::print(&format!("{}: {pictures}, {} per second", written.display(), arguments.rate))?;
    }
    Ok(Exit::Done)
}

/// One picture; `most` is what beams bear at most in all of them.
fn paint(
    painter: &Painter,
    drawing: &Drawing,
    (clip, index): (&Clip, usize),
    frame: &Frame,
    most: f64,
) -> anyhow::Result<Pixels> {
    let poses = &clip.poses[index];
    let picture = match clip.loads.get(index) {
        Some(loads) => svg(&drawing.clone().shaded(loads, most, number::shown_digits()), poses, frame),
        None => svg(drawing, poses, frame),
    };
    painter.paint(&picture, 1).map_err(anyhow::Error::msg)
}

/// For each picture the clip and its frame that is nearest in time.
fn moments(clips: &[Clip], arguments: &Arguments) -> anyhow::Result<Vec<(usize, usize)>> {
    let step = arguments.speed / f64::from(arguments.rate);
    let mut shown = Vec::new();
    for (number, clip) in clips.iter().enumerate() {
        let (begin, end) = (clip.times[0], clip.times[clip.times.len() - 1]);
        let count = ((end - begin) / step).round();
        if !(count + (shown.len() as f64) < MOST_PICTURES as f64) {
            bail!(
                "these would be more than {MOST_PICTURES} pictures: ask for a greater `--speed` or a smaller `--rate`"
            );
        }
        shown.extend((0..=count as usize).map(|k| {
            let time = begin + k as f64 * step;
            let after = clip.times.partition_point(|t| *t < time).min(clip.times.len() - 1);
            let before = after.saturating_sub(1);
            let nearer = time - clip.times[before] <= clip.times[after] - time;
            (number, if nearer { before } else { after })
        }));
    }
    Ok(shown)
}

impl Arguments {
    fn reel(&self) -> anyhow::Result<Box<dyn Reel>> {
        let size = self.looks.size();
        let kind = self.out.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        match kind.as_deref() {
            Some("gif") => Ok(Box::new(Gif::create(&self.out, size, self.rate)?)),
            Some("mp4") if installed("ffmpeg") => Ok(Box::new(Mp4::create(&self.out, size, self.rate)?)),
            Some("mp4") => {
                let folder = self.out.with_extension("");
                if !self.quiet {
                    output::warning(&format!(
                        "`ffmpeg` is not installed: the pictures go to the folder `{}` as PNG",
                        folder.display()
                    ));
                }
                Ok(Box::new(Pictures::create(folder)?))
            }
            _ => bail!("`{}`: the name of a film ends in .gif or .mp4", self.out.display()),
        }
    }
}

fn installed(program: &str) -> bool {
    let mut asked = Command::new(program);
    asked.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

struct Gif {
    target: PathBuf,
    whole: WholeFile,
    encoder: Encoder<BufWriter<File>>,
    /// Hundredths of a second.
    delay: u16,
}

impl Gif {
    fn create(target: &Path, size: [u32; 2], rate: u16) -> anyhow::Result<Self> {
        let context = || format!("cannot write `{}`", target.display());
        let whole = WholeFile::create(target).with_context(context)?;
        let [width, height] = size.map(|edge| edge as u16);
        let writer = BufWriter::new(whole.handle().with_context(context)?);
        let mut encoder = Encoder::new(writer, width, height, &[]).with_context(context)?;
        encoder.set_repeat(Repeat::Infinite).with_context(context)?;
        let delay = (100.0 / f64::from(rate)).round() as u16;
        Ok(Self { target: target.to_owned(), whole, encoder, delay })
    }
}

impl Reel for Gif {
    fn add(&mut self, pixels: &Pixels) -> anyhow::Result<()> {
        let [width, height] = pixels.size().map(|edge| edge as u16);
        let Indexed { palette, points } = colors::indexed(&pixels.rgba());
        let mut frame = gif::Frame::from_palette_pixels(width, height, points, palette, None);
        frame.delay = self.delay;
        self.encoder.write_frame(&frame).with_context(|| format!("cannot write `{}`", self.target.display()))
    }

    fn finish(self: Box<Self>) -> anyhow::Result<PathBuf> {
        let Self { target, whole, encoder, .. } = *self;
        let context = || format!("cannot write `{}`", target.display());
        encoder.into_inner().with_context(context)?.flush().with_context(context)?;
        whole.finish().with_context(context)?;
        Ok(target)
    }
}

/// A film that the program `ffmpeg` encodes.
struct Mp4 {
    target: PathBuf,
    whole: WholeFile,
    encoder: Child,
}

impl Mp4 {
    fn create(target: &Path, size: [u32; 2], rate: u16) -> anyhow::Result<Self> {
        let whole = WholeFile::create(target).with_context(|| format!("cannot write `{}`", target.display()))?;
        let [width, height] = size;
        let encoder = Command::new("ffmpeg")
            .args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"])
            .args(["-s", &format!("{width}x{height}"), "-r", &rate.to_string(), "-i", "-"])
            // Half as many colours as points need even edges.
            .args([
                "-vf",
                "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                "-pix_fmt",
                "yuv420p",
                "-movflags",
                "+faststart",
                "-f",
                "mp4",
            ])
            .arg(whole.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .context("`ffmpeg` cannot be started")?;
        Ok(Self { target: target.to_owned(), whole, encoder })
    }
}

impl Reel for Mp4 {
    fn add(&mut self, pixels: &Pixels) -> anyhow::Result<()> {
        let input = self.encoder.stdin.as_mut().context("`ffmpeg` takes no pictures")?;
        input.write_all(&pixels.rgba()).context("`ffmpeg` ended before the film did; what it said stands above")
    }

    fn finish(mut self: Box<Self>) -> anyhow::Result<PathBuf> {
        drop(self.encoder.stdin.take());
        let status = self.encoder.wait()?;
        if !status.success() {
            bail!("`ffmpeg` failed ({status}); what it said stands above");
        }
        let Self { target, whole, .. } = *self;
        whole.finish().with_context(|| format!("cannot write `{}`", target.display()))?;
        Ok(target)
    }
}

/// Numbered pictures in a folder.
struct Pictures {
    folder: PathBuf,
    count: usize,
}

impl Pictures {
    fn create(folder: PathBuf) -> anyhow::Result<Self> {
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot create the folder `{}`", folder.display()))?;
        Ok(Self { folder, count: 0 })
    }
}

impl Reel for Pictures {
    fn add(&mut self, pixels: &Pixels) -> anyhow::Result<()> {
        let png = pixels.png().map_err(anyhow::Error::msg)?;
        output::save(&self.folder.join(format!("{:05}.png", self.count)), &png)?;
        self.count += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> anyhow::Result<PathBuf> {
        Ok(self.folder)
    }
}
