//! The recorder that draws, and the playing of recordings.

use super::bounds::{Bounds, Outline, expected};
use super::columns::Columns;
use super::connect::{self, failed};
use super::curves::plots;
use super::layout;
use super::link::{Job, Link};
use super::picture::Picture;
use super::{Shown, Sink};
use crate::record::solids::solids;
use crate::record::{Opening, Outcome, RecordError, Recorder, Recording, Sample, Scene};
use rerun::{RecordingStream, RecordingStreamBuilder};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

const APPLICATION: &str = "stillpoint";

/// A running picture is renewed this often, and less often by so much for every body: each renewal of each body costs
/// the viewer about a kilobyte, whatever is in it.
const PERIOD: Duration = Duration::from_millis(50);
const PERIOD_PER_BODY: Duration = Duration::from_micros(200);
/// A picture that nobody waits for is sent in stretches of so many numbers.
const STRETCH: usize = 1 << 22;

/// Draws samples as they come.
pub struct Viewer {
    link: Link,
    picture: Arc<Picture>,
    columns: Columns,
    longest: usize,
    /// `None` where nobody waits for the picture.
    period: Option<Duration>,
    sent: Instant,
    bounds: Bounds,
    /// Whether anything has been drawn.
    begun: bool,
    /// Whether the eye may be placed again at the end: in a file, where nobody has moved it yet.
    replace: bool,
    notes: Vec<String>,
}

impl Viewer {
    /// Finds or starts the viewer, or creates the file.
    ///
    /// # Errors
    /// Within seconds, when there is no viewer, it cannot be started, or the file cannot be created.
    pub fn open(sink: &Sink, opening: &Opening) -> Result<Self, RecordError> {
        Self::with_scene(sink, opening.scene)
    }

    /// What the picture leaves out, in words.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    fn with_scene(sink: &Sink, scene: &Scene) -> Result<Self, RecordError> {
        let mut builder = RecordingStreamBuilder::new(APPLICATION);
        if !scene.title.is_empty() {
            builder = builder.recording_name(scene.title.as_str());
        }
        let stream = connect::open(sink, builder)?;
        let link = Link::start(stream).map_err(|error| failed(format!("no thread for the viewer: {error}"), ""))?;
        let (plots, notes) = plots(scene);
        let solids = solids(scene);
        let outlines = solids.iter().map(|solids| Outline::new(solids)).collect();
        let columns = Columns::new(scene, &plots);
        let picture = Arc::new(Picture { scene: scene.clone(), plots, solids, outlines });
        let numbers_per_sample = 7 * scene.bodies.len() + 6 * scene.lines.len() + 16;
        let saved = matches!(sink, Sink::Save(_));
        Ok(Self {
            link,
            picture,
            columns,
            longest: (STRETCH / numbers_per_sample).clamp(1, 4096),
            period: (!saved).then(|| PERIOD + PERIOD_PER_BODY * u32::try_from(scene.bodies.len()).unwrap_or(u32::MAX)),
            sent: Instant::now(),
            bounds: Bounds::default(),
            begun: false,
            replace: saved,
            notes,
        })
    }

    /// Divides the window, places the eye so that the whole of `bounds` is seen, then draws what stands still: in this
    /// order the viewer never shows a layout of its own first.
    fn begin(&mut self, bounds: Bounds) -> Result<(), RecordError> {
        self.begun = true;
        self.place_eye(bounds)?;
        let picture = self.picture.clone();
        self.tell(move |stream| picture.send(stream).map_err(|error| error.to_string()))
    }

    /// Places the eye so that the whole of `bounds` is seen.
    fn place_eye(&mut self, bounds: Bounds) -> Result<(), RecordError> {
        let picture = self.picture.clone();
        self.tell(move |stream| {
            layout::send(stream, APPLICATION, &picture.scene.title, &picture.plots, &bounds)
                .map_err(|error| error.to_string())
        })
    }

    fn send_columns(&mut self) -> Result<(), RecordError> {
        let columns = self.columns.take();
        let picture = self.picture.clone();
        self.sent = Instant::now();
        self.tell(move |stream| columns.send(stream, &picture.scene, &picture.plots).map_err(|error| error.to_string()))
    }

    fn tell(
        &mut self,
        job: impl FnOnce(&RecordingStream) -> Result<(), String> + Send + 'static,
    ) -> Result<(), RecordError> {
        let job: Job = Box::new(job);
        self.link.send(job).map_err(lost)
    }
}

fn lost(what: String) -> RecordError {
    failed(format!("the viewer is lost: {what}"), "")
}

impl Recorder for Viewer {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        sample.check(&self.picture.scene)?;
        if !self.begun {
            self.begin(expected(&self.picture.scene, &self.picture.outlines, sample.bodies))?;
        }
        self.bounds.include_bodies(&self.picture.outlines, sample.bodies);
        self.bounds.include_lines(&self.picture.scene.lines, sample.bodies);
        self.columns.push(sample, &self.picture.scene, &self.picture.plots);
        let due = self.period.is_some_and(|period| self.sent.elapsed() >= period);
        if due || self.columns.len() >= self.longest {
            self.send_columns()?;
        }
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        if self.columns.len() > 0 {
            self.send_columns()?;
        }
        if !self.begun {
            self.begin(self.bounds)?;
        } else if std::mem::take(&mut self.replace) {
            self.place_eye(self.bounds)?;
        }
        self.link.finish().map_err(lost)
    }
}

/// Plays a recording into the viewer. It is read twice, the first time to see how much room the motion takes.
///
/// # Errors
/// When the recording cannot be read, or there is no viewer.
pub fn view(recording: &Path, sink: &Sink) -> Result<Shown, RecordError> {
    let recording = Recording::open(recording)?;
    let mut viewer = Viewer::with_scene(sink, &recording.scene)?;
    let mut bounds = Bounds::default();
    for sample in recording.samples()? {
        let bodies = sample?.bodies;
        bounds.include_bodies(&viewer.picture.outlines, &bodies);
        bounds.include_lines(&viewer.picture.scene.lines, &bodies);
    }
    viewer.begin(bounds)?;
    viewer.replace = false;
    viewer.period = None;
    let mut samples = 0;
    for sample in recording.samples()? {
        viewer.sample(&sample?.borrow())?;
        samples += 1;
    }
    viewer.finish(&Outcome { summary: String::new() })?;
    Ok(Shown { samples, complete: recording.complete, notes: viewer.notes })
}
