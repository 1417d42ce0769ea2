//! The recorder that draws, and the playing of recordings.

use super::bounds::expected;
use super::columns::Columns;
use super::connect::{self, failed};
use super::curves::plots;
use super::entity::point;
use super::forces::Scales;
use super::layout;
use super::link::{Job, Link};
use super::picture::Picture;
use super::stream::Stream;
use super::survey::{Survey, Trace, center_of_mass};
use super::{Shown, Sink, Wishes, marks, text};
use crate::record::drawing::Legend;
use crate::record::drawing::bounds::{Bounds, Outline};
use crate::record::footage::holds_poses;
use crate::record::meshes;
use crate::record::solids::solids;
use crate::record::{ContactPush, Event, Opening, Outcome, RecordError, Recorder, Recording, Sample, Scene, Tubes};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Significant digits where nobody asks for others, as in reports.
const DIGITS: usize = 4;

/// A running picture is renewed this often, and less often by so much for every thing that moves: each renewal of each
/// of them costs the viewer about a kilobyte, whatever is in it.
const PERIOD: Duration = Duration::from_millis(50);
const PERIOD_PER_BODY: Duration = Duration::from_micros(200);
/// A picture that nobody waits for is sent in stretches of so many numbers.
const STRETCH: usize = 1 << 22;
/// Acceleration of gravity on earth (m/s²), by which arrows of contacts are sized.
const EARTH: f64 = 9.80665;
/// Poses that are drawn at most; from there on every second sample is, then every fourth.
const MOST_POSES: usize = 4_000_000;

/// Draws samples as they come.
pub struct Viewer {
    link: Link,
    scene: Scene,
    statics: Option<String>,
    captions: Vec<(f64, String)>,
    /// Made of the first sample, or of the whole recording.
    picture: Option<Arc<Picture>>,
    known: Option<Survey>,
    reactions: bool,
    columns: Columns,
    /// What contacts push with at the next sample; `None` in a scene without.
    pushes: Option<Vec<ContactPush>>,
    /// What happened and has not been sent.
    events: Vec<Event>,
    longest: usize,
    thinning: Thinning,
    /// `None` if nobody waits for the picture.
    period: Option<Duration>,
    sent: Instant,
    outlines: Vec<Outline>,
    bounds: Bounds,
    trace: Trace,
    traced: usize,
    /// Whether the eye may be placed again at the end: in a file, where nobody has moved it yet.
    replace: bool,
    /// Whether the time runs when the picture is opened, or follows what comes.
    plays: bool,
    notes: Vec<String>,
}

/// Which samples are drawn: all, or every so manieth.
#[derive(Debug, Clone, Copy)]
struct Thinning {
    stride: usize,
    seen: usize,
    drawn: usize,
    most: usize,
}

impl Thinning {
    fn new(samples: Option<usize>, poses: usize) -> Self {
        let most = (MOST_POSES / poses.max(1)).max(1);
        let stride = samples.map_or(1, |samples| samples.div_ceil(most).max(1));
        // Of a number of samples that is known the stride is final.
        Self { stride, seen: 0, drawn: 0, most: if samples.is_some() { usize::MAX } else { most } }
    }

    fn draws(&mut self) -> bool {
        let draws = self.seen.is_multiple_of(self.stride);
        self.seen += 1;
        if draws {
            self.drawn += 1;
            if self.drawn >= self.most {
                self.drawn = self.most / 2;
                self.stride *= 2;
            }
        }
        draws
    }
}

impl Viewer {
    /// Finds or starts the viewer, or creates the file.
    ///
    /// # Errors
    /// Within seconds, when there is no viewer, it cannot be started, or the file cannot be created.
    pub fn open(sink: &Sink, opening: &Opening) -> Result<Self, RecordError> {
        Self::with_scene(sink, opening.scene, opening.statics)
    }

    /// What the picture leaves out, in words.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    fn with_scene(sink: &Sink, scene: &Scene, statics: Option<&str>) -> Result<Self, RecordError> {
        let stream = connect::open(sink, &scene.title)?;
        let link = Link::start(stream).map_err(|error| failed(format!("no thread for the viewer: {error}"), ""))?;
        let saved = matches!(sink, Sink::Save(_));
        Ok(Self {
            link,
            scene: scene.clone(),
            statics: text::equilibrium(statics),
            captions: Vec::new(),
            picture: None,
            known: None,
            reactions: false,
            columns: Columns::default(),
            pushes: None,
            events: Vec::new(),
            longest: 1,
            thinning: Thinning::new(None, 1),
            period: (!saved).then_some(PERIOD),
            sent: Instant::now(),
            outlines: solids(scene).iter().map(|solids| Outline::new(solids)).collect(),
            bounds: Bounds::default(),
            trace: Trace::default(),
            traced: 0,
            replace: saved,
            plays: saved,
            notes: plots(scene, None).1,
        })
    }

    /// Divides the window, places the eye so that the whole of `bounds` is seen, then draws what stands still: in this
    /// order the viewer never shows a layout of its own first.
    fn begin(&mut self, bounds: Bounds, forces: &Survey) -> Result<Arc<Picture>, RecordError> {
        let (plots, notes) = plots(&self.scene, self.known.as_ref());
        self.notes = notes;
        let scales = Scales {
            size: bounds.size().norm(),
            tension: forces.tension,
            reaction: if self.reactions { forces.reaction } else { 0.0 },
            borne: forces.borne,
            weight: EARTH * self.scene.bodies.iter().map(|body| body.mass).sum::<f64>(),
        };
        let mut picture = Picture::new(&self.scene, plots, scales);
        picture.statics = self.statics.clone();
        if let Some(legend) = Legend::new(&Tubes::new(&self.scene), picture.scales.borne, DIGITS) {
            let (most, Legend { what, unit, .. }) = (legend.number(), legend);
            let told = format!("**Beams** are coloured by {what}: grey is none, the darkest red {most} {unit}.\n");
            picture.statics = Some(picture.statics.unwrap_or_default() + &told);
        }
        picture.captions = self.captions.clone();
        let poses = picture.poses();
        self.columns = Columns::new(&picture);
        let surfaces = picture.beams.numbers() + picture.mounts.numbers();
        self.longest = (STRETCH / (7 * poses + 200 * self.scene.lines.len() + surfaces + 16)).clamp(1, 4096);
        self.thinning = Thinning::new(self.known.as_ref().map(|known| known.samples), poses);
        if self.thinning.stride > 1 {
            self.notes.push(format!("one of {} samples is drawn; the curves have them all", self.thinning.stride));
        }
        let things = if picture.crowd.is_some() { 8 } else { self.scene.bodies.len() };
        self.period = self.period.map(|period| period + PERIOD_PER_BODY * u32::try_from(things).unwrap_or(u32::MAX));
        let picture = Arc::new(picture);
        self.picture = Some(picture.clone());
        self.place_eye(&picture, bounds)?;
        let sent = picture.clone();
        self.tell(move |stream| sent.send(stream).map_err(|error| error.to_string()))?;
        Ok(picture)
    }

    /// Places the eye so that the whole of `bounds` is seen.
    fn place_eye(&mut self, picture: &Arc<Picture>, bounds: Bounds) -> Result<(), RecordError> {
        let (picture, plays) = (picture.clone(), self.plays);
        self.tell(move |stream| layout::send(stream, &picture, &bounds, plays).map_err(|error| error.to_string()))
    }

    fn send_columns(&mut self, picture: &Arc<Picture>) -> Result<(), RecordError> {
        let columns = std::mem::replace(&mut self.columns, Columns::new(picture));
        self.sent = Instant::now();
        let sent = picture.clone();
        self.tell(move |stream| columns.send(stream, &sent).map_err(|error| error.to_string()))?;
        self.send_events()?;
        // Anew where it has grown by a quarter, and at the end.
        if 4 * self.trace.points().len() > 5 * self.traced {
            self.send_trace()?;
        }
        Ok(())
    }

    fn send_events(&mut self) -> Result<(), RecordError> {
        let events = std::mem::take(&mut self.events);
        if events.is_empty() {
            return Ok(());
        }
        self.tell(move |stream| marks::send(stream, &events).map_err(|error| error.to_string()))
    }

    fn send_trace(&mut self) -> Result<(), RecordError> {
        let points = self.trace.points().to_vec();
        self.traced = points.len();
        self.tell(move |stream| Picture::send_trace(stream, points).map_err(|error| error.to_string()))
    }

    fn tell(&mut self, job: impl FnOnce(&Stream) -> Result<(), String> + Send + 'static) -> Result<(), RecordError> {
        let job: Job = Box::new(job);
        self.link.send(job).map_err(lost)
    }
}

fn lost(what: String) -> RecordError {
    failed(format!("the viewer is lost: {what}"), "")
}

impl Recorder for Viewer {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        sample.check(&self.scene)?;
        let picture = match self.picture.clone() {
            Some(picture) => picture,
            None => {
                let mut forces = Survey::new(&self.scene);
                forces.include_forces(sample, &self.scene);
                self.begin(expected(&self.scene, &self.outlines, sample.bodies), &forces)?
            }
        };
        self.bounds.include_bodies(&self.outlines, sample.bodies);
        self.bounds.include_ends(self.scene.ends(), sample.bodies);
        self.scene.curves.iter().for_each(|curve| self.bounds.include_curve(curve, sample.bodies));
        self.columns.push(sample, &picture);
        if self.thinning.draws() {
            self.columns.push_poses(sample, &picture);
            if let Some(pushes) = &self.pushes {
                self.columns.push_contacts(sample.time, pushes, &picture);
            }
        }
        if let Some(center) = center_of_mass(&self.scene, sample.bodies) {
            self.trace.push(point(&center));
        }
        let due = self.period.is_some_and(|period| self.sent.elapsed() >= period);
        if due || self.columns.len() >= self.longest {
            self.send_columns(&picture)?;
        }
        Ok(())
    }

    fn contacts(&mut self, _time: f64, contacts: &[ContactPush]) -> Result<(), RecordError> {
        let pushes = self.pushes.get_or_insert_default();
        pushes.clear();
        pushes.extend_from_slice(contacts);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordError> {
        self.events.push(event.clone());
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        let picture = match self.picture.clone() {
            Some(picture) => picture,
            None => self.begin(self.bounds, &Survey::new(&self.scene.clone()))?,
        };
        if self.columns.len() > 0 {
            self.send_columns(&picture)?;
        }
        self.send_events()?;
        if self.trace.points().len() > 1 {
            self.send_trace()?;
        }
        if std::mem::take(&mut self.replace) {
            self.place_eye(&picture, self.bounds)?;
        }
        self.link.finish().map_err(lost)
    }
}

/// Plays a recording into the viewer. It is read twice, the first time to see what moves, and how far.
///
/// # Errors
/// When the recording cannot be read, or there is no viewer.
pub fn view(recording: &Path, sink: &Sink, wishes: &Wishes) -> Result<Shown, RecordError> {
    let mut recording = Recording::open(recording)?;
    if holds_poses(recording.outcome.as_deref()) {
        recording.scene.hold_loads();
    }
    let left_out = if wishes.meshes { Vec::new() } else { meshes::keep_own(&mut recording.scene, &recording.path) };
    let mut viewer = Viewer::with_scene(sink, &recording.scene, recording.statics.as_deref())?;
    // Of one instant alone there is nothing to tell.
    viewer.events = if wishes.at.is_none() { recording.events()? } else { Vec::new() };
    viewer.scene.watched = !viewer.events.is_empty();
    viewer.captions = text::captions(recording.outcome.as_deref(), recording.statics.as_deref());
    viewer.reactions = wishes.reactions;
    let mut known = Survey::new(&recording.scene);
    let mut nearest: Option<(usize, f64)> = None;
    for (index, sample) in recording.samples()?.enumerate() {
        let sample = sample?;
        known.include(&sample.borrow(), &recording.scene, &viewer.outlines);
        let away = wishes.at.map_or(0.0, |at| (sample.time - at).abs());
        if nearest.is_none_or(|(_, least)| away < least) {
            nearest = Some((index, away));
        }
    }
    let only = wishes.at.and(nearest).map(|(index, _)| index);
    let bounds = known.bounds;
    viewer.plays = only.is_none();
    viewer.known = Some(known.clone());
    viewer.begin(bounds, &known)?;
    viewer.replace = false;
    viewer.period = None;
    // One instant of contacts a sample, in scenes that have them.
    let mut contacts = recording.contacts()?.into_iter();
    let mut samples = 0;
    for (index, sample) in recording.samples()?.enumerate() {
        let sample = sample?;
        if let Some((_, pushes)) = contacts.next() {
            viewer.pushes = Some(Vec::clone(&pushes));
        }
        if only.is_none_or(|only| only == index) {
            viewer.sample(&sample.borrow())?;
            samples += 1;
        }
    }
    viewer.finish(&Outcome { summary: String::new() })?;
    let notes = left_out.into_iter().chain(viewer.notes).collect();
    Ok(Shown { samples, complete: recording.complete, notes })
}
