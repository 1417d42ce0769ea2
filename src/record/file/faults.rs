//! Disks that fail while a recording is written: whatever reached them is read as a prefix, and no failure is silent.

use super::Recording;
use super::writer::Output;
use crate::record::scene::{BodyPicture, Channel};
use crate::record::{Opening, Outcome, OwnedSample, RecordError, Scene};
use crate::spatial::{Pose, Wrench};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex};

/// A disk that takes so many bytes, at most so many at once, and fails from then on.
struct Disk {
    held: Arc<Mutex<Vec<u8>>>,
    room: usize,
    at_once: usize,
    fault: ErrorKind,
    writes: Arc<Mutex<Vec<usize>>>,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut held = self.held.lock().expect("one thread");
        let count = bytes.len().min(self.at_once).min(self.room - held.len());
        if count == 0 && !bytes.is_empty() {
            return Err(self.fault.into());
        }
        held.extend_from_slice(&bytes[..count]);
        self.writes.lock().expect("one thread").push(held.len());
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Disk {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        assert_eq!(to, SeekFrom::Current(0), "nothing is patched in place");
        Ok(self.held.lock().expect("one thread").len() as u64)
    }
}

fn scene() -> Scene {
    let body = BodyPicture {
        name: "rod".into(),
        parent: None,
        mass: 1.0,
        center: [0.0; 3],
        inertia: [0.1, 0.1, 0.1, 0.0, 0.0, 0.0],
        markers: vec![("tip".into(), [0.0, 0.0, -1.0])],
        shapes: Vec::new(),
        hinge: "revolute".into(),
        hinge_axes: vec![[0.0, 1.0, 0.0]],
        hinge_at: [0.0; 3],
        own_axes: Vec::new(),
    };
    let channel = |name: &str, unit: &str| Channel { body: "rod".into(), name: name.into(), unit: unit.into() };
    let (positions, velocities) = (vec![channel("angle", "rad")], vec![channel("rate", "rad/s")]);
    Scene { bodies: vec![body], positions, velocities, ..Scene::default() }
}

fn sample(index: usize) -> OwnedSample {
    let time = 0.01 * index as f64;
    OwnedSample {
        time,
        positions: vec![time.sin()],
        velocities: vec![time.cos()],
        accelerations: vec![-time.sin()],
        bodies: vec![Pose::identity()],
        reactions: vec![Wrench::default()],
        ..OwnedSample::default()
    }
}

const SAMPLES: usize = 40;

/// Records onto a disk; what stands there then, where its writes ended, and whether all was said to be well.
fn record(room: usize, at_once: usize, fault: ErrorKind) -> (Vec<u8>, Vec<usize>, bool) {
    let (held, writes) = (Arc::default(), Arc::default());
    let disk = Disk { held: Arc::clone(&held), room, at_once, fault, writes: Arc::clone(&writes) };
    let scene = scene();
    let opening = Opening { scene: &scene, scenario: "title = \"rod\"", statics: None };
    let written = Output::begin(disk, &opening, false).and_then(|mut output| {
        let mut transforms = super::frames::transforms(&scene);
        for index in 0..SAMPLES {
            output.sample(&sample(index).borrow(), &mut transforms)?;
            // A chunk for every few samples, as slow runs make them.
            if index % 5 == 4 {
                output.flush()?;
            }
        }
        output.finish(&Outcome { summary: "{}".to_owned() }).map(drop)
    });
    let bytes = held.lock().expect("one thread").clone();
    let writes = writes.lock().expect("one thread").clone();
    (bytes, writes, written.is_ok())
}

/// What is read of these bytes: samples, and whether the recording is whole.
fn read(bytes: &[u8]) -> Option<(Vec<OwnedSample>, bool)> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap.partial");
    std::fs::write(&path, bytes).expect("written");
    match Recording::open(&path) {
        Ok(recording) => {
            let samples = recording.samples().expect("opened").map(|sample| sample.expect("a sample")).collect();
            Some((samples, recording.complete))
        }
        Err(RecordError::NotARecording { .. }) => None,
        Err(other) => panic!("{} bytes: {other}", bytes.len()),
    }
}

#[test]
fn a_disk_that_fails_at_any_byte_leaves_a_prefix_and_an_error() {
    let (whole, _, fine) = record(usize::MAX, usize::MAX, ErrorKind::StorageFull);
    assert!(fine);
    let all: Vec<OwnedSample> = (0..SAMPLES).map(sample).collect();
    assert_eq!(read(&whole), Some((all.clone(), true)));
    let mut before = 0;
    for room in (0..whole.len()).step_by(7).chain([whole.len() - 1]) {
        let fault = if room % 2 == 0 { ErrorKind::StorageFull } else { ErrorKind::Other };
        let (bytes, _, fine) = record(room, usize::MAX, fault);
        assert!(!fine, "{room} bytes of {} were said to be all", whole.len());
        let Some((samples, complete)) = read(&bytes) else { continue };
        assert!(!complete && samples == all[..samples.len()], "{room} bytes");
        assert!(samples.len() >= before, "a larger disk holds less");
        before = samples.len();
    }
    assert_eq!(before, SAMPLES);
}

#[test]
fn short_writes_lose_nothing() {
    let (whole, ..) = record(usize::MAX, usize::MAX, ErrorKind::StorageFull);
    for at_once in [1, 2, 3, 7, 64, 1000] {
        let (bytes, _, fine) = record(usize::MAX, at_once, ErrorKind::StorageFull);
        assert!(fine && bytes == whole, "at most {at_once} bytes at once");
    }
}

#[test]
fn a_run_killed_after_any_write_leaves_what_was_flushed() {
    let (whole, writes, _) = record(usize::MAX, usize::MAX, ErrorKind::StorageFull);
    let all: Vec<OwnedSample> = (0..SAMPLES).map(sample).collect();
    assert!(writes.len() > SAMPLES / 5, "{} writes", writes.len());
    let kept: Vec<usize> = writes
        .iter()
        .filter_map(|end| read(&whole[..*end]))
        .map(|(samples, _)| {
            assert_eq!(samples, all[..samples.len()]);
            samples.len()
        })
        .collect();
    // Every flush can be seen from outside.
    for flushed in (5..=SAMPLES).step_by(5) {
        assert!(kept.contains(&flushed), "{kept:?}");
    }
}

/// Samples of one step that took long are kept at its end, though a flush has just been.
#[test]
fn a_long_step_is_flushed_as_a_whole() {
    let (held, writes) = (Arc::default(), Arc::default());
    let (room, at_once, fault) = (usize::MAX, usize::MAX, ErrorKind::Other);
    let disk = Disk { held: Arc::clone(&held), room, at_once, fault, writes };
    let scene = scene();
    let opening = Opening { scene: &scene, scenario: "title = \"rod\"", statics: None };
    let mut output = Output::begin(disk, &opening, false).expect("begun");
    let mut transforms = super::frames::transforms(&scene);
    output.pause().expect("a first step");
    std::thread::sleep(std::time::Duration::from_millis(600));
    let kept = || read(&held.lock().expect("one thread")).map_or(0, |(samples, _)| samples.len());
    for index in 0..SAMPLES {
        output.sample(&sample(index).borrow(), &mut transforms).expect("written");
    }
    assert!(kept() < SAMPLES, "nothing is left to flush");
    output.pause().expect("the end of the long step");
    assert_eq!(kept(), SAMPLES);
}
