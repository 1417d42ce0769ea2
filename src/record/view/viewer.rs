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

/// A running picture is renewed this often …
const PERIOD: Duration = Duration::from_millis(50);
/// … and anything longer is sent in stretches of at most so many numbers.
const STRETCH: usize = 1 << 20;

/// Draws samples as they come.
pub struct Viewer {
    link: Link,
    picture: Arc<Picture>,
    columns: Columns,
    longest: usize,
    sent: Instant,
    bounds: Bounds,
    /// Whether the eye has been placed.
    placed: bool,
    /// Whether the eye may be placed again at the end: in a file, where nobody has moved it yet.
    replace: bool,
    notes: Vec<String>,
}

impl Viewer {
    /// Finds or starts the viewer, or creates the file, and draws what stands still.
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
        let mut viewer = Self {
            link,
            picture: picture.clone(),
            columns,
            longest: (STRETCH / numbers_per_sample).clamp(1, 4096),
            sent: Instant::now(),
            bounds: Bounds::default(),
            placed: false,
            replace: matches!(sink, Sink::Save(_)),
            notes,
        };
        viewer.tell(move |stream| picture.send(stream).map_err(|error| error.to_string()))?;
        Ok(viewer)
    }

    /// Places the eye so that the whole of `bounds` is seen.
    fn place_eye(&mut self, bounds: Bounds) -> Result<(), RecordError> {
        self.placed = true;
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
        if !self.placed {
            let bounds = expected(&self.picture.scene, &self.picture.outlines, sample.bodies);
            self.place_eye(bounds)?;
        }
        self.bounds.include_bodies(&self.picture.outlines, sample.bodies);
        self.columns.push(sample, &self.picture.scene, &self.picture.plots);
        if self.columns.len() >= self.longest || self.sent.elapsed() >= PERIOD {
            self.send_columns()?;
        }
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        if self.columns.len() > 0 {
            self.send_columns()?;
        }
        if self.replace {
            self.replace = false;
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
        bounds.include_bodies(&viewer.picture.outlines, &sample?.bodies);
    }
    viewer.place_eye(bounds)?;
    viewer.replace = false;
    let mut samples = 0;
    for sample in recording.samples()? {
        viewer.sample(&sample?.borrow())?;
        samples += 1;
    }
    viewer.finish(&Outcome { summary: String::new() })?;
    Ok(Shown { samples, complete: recording.complete, notes: viewer.notes })
}
