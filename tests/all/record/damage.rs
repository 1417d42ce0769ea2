//! Files that were cut, damaged, or are something else.

use super::fixture::{Motion, OUTCOME, record};
use stillpoint::record::{Outcome, OwnedSample, RecordError, Recorder, Recording, RecordingFile};

#[test]
fn a_file_cut_anywhere_gives_a_prefix() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = folder.path().join("whole.mcap");
    let cut = folder.path().join("cut.mcap");
    let motion = Motion::double_link();
    record(&whole, &motion, 30.0);
    let bytes = std::fs::read(&whole).expect("read");
    let all = samples(&Recording::open(&whole).expect("a recording"));
    let mut lengths: Vec<usize> = (0..bytes.len()).step_by(bytes.len() / 150).collect();
    lengths.extend(bytes.len() - 40..bytes.len());
    let mut partly = 0;
    for length in lengths {
        std::fs::write(&cut, &bytes[..length]).expect("written");
        match Recording::open(&cut) {
            Ok(recording) => {
                let read = samples(&recording);
                assert!(!recording.complete, "cut at {length} of {}", bytes.len());
                assert_eq!(read, all[..read.len()]);
                partly += usize::from(!read.is_empty() && read.len() < all.len());
            }
            Err(RecordError::NotARecording { .. }) => {}
            Err(other) => panic!("cut at {length}: {other}"),
        }
    }
    assert!(partly > 0, "no cut fell between two chunks");
}

#[test]
fn damaged_bytes_are_an_error_or_a_prefix_but_never_wrong_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let motion = Motion::double_link();
    record(&path, &motion, 1.0);
    let whole = std::fs::read(&path).expect("read");
    let all = samples(&Recording::open(&path).expect("a recording"));
    for position in (0..whole.len()).step_by(whole.len() / 300) {
        let mut bytes = whole.clone();
        bytes[position] ^= 0x55;
        std::fs::write(&path, &bytes).expect("written");
        let Ok(recording) = Recording::open(&path) else { continue };
        // A damaged name in the description changes which scene is read; the numbers are the chunks'.
        let Ok(iterator) = recording.samples() else { continue };
        let read: Vec<OwnedSample> = iterator.map_while(Result::ok).collect();
        assert!(read.len() <= all.len());
        if recording.scene == motion.scene {
            assert_eq!(read, all[..read.len()], "byte {position}");
        }
    }
}

#[test]
fn a_killed_run_keeps_what_was_flushed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let motion = Motion::double_link();
    let mut writer = RecordingFile::create(&path).and_then(|file| file.begin(&motion.opening())).expect("open");
    for time in Motion::times(0.5) {
        writer.sample(&motion.at(time).borrow()).expect("written");
    }
    // Longer than the flush period, as when the run goes on.
    std::thread::sleep(std::time::Duration::from_millis(600));
    writer.sample(&motion.at(0.51).borrow()).expect("written and flushed");
    writer.sample(&motion.at(0.52).borrow()).expect("still in the open chunk");
    std::mem::forget(writer);

    let recording = Recording::open(&folder.path().join("swing.mcap.partial")).expect("readable");
    assert!(!recording.complete && recording.outcome.is_none());
    let read = samples(&recording);
    assert_eq!(read.len(), 52);
    assert_eq!(read[51], motion.at(0.51));
}

#[test]
fn a_run_that_panics_leaves_all_its_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let motion = Motion::double_link();
    let mut writer = RecordingFile::create(&path).and_then(|file| file.begin(&motion.opening())).expect("open");
    writer.sample(&motion.at(0.0).borrow()).expect("written");
    drop(writer);
    let recording = Recording::open(&folder.path().join("swing.mcap.partial")).expect("readable");
    assert!(!recording.complete);
    assert_eq!(samples(&recording), [motion.at(0.0)]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_with_the_file_named_and_no_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    std::os::unix::fs::symlink("/dev/full", &path).expect("linked");
    let error = RecordingFile::create(&path).and_then(|file| file.begin(&Motion::double_link().opening()));
    let error = error.err().expect("no room").to_string();
    assert!(error.contains("swing.mcap") && error.contains("No space left"), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_in_the_middle_leaves_what_was_flushed() {
    // A limit on the size of files (4 MiB, some chunks) stands for the disk. It belongs to the process, so it needs one
    // of its own.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let program = env!("CARGO_BIN_EXE_stillpoint");
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/double_pendulum.toml");
    let script = format!(
        "trap '' XFSZ; ulimit -f 4096; exec '{program}' run '{scenario}' --set simulate.duration=1000 --out '{}'",
        path.display()
    );
    let run = std::process::Command::new("bash").args(["-c", &script]).output().expect("run");
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(said.contains("swing.mcap.partial") && said.contains("too large"), "{said}");
    assert!(!path.exists(), "no recording under the final name");
    let recording = Recording::open(&folder.path().join("swing.mcap.partial")).expect("readable");
    assert!(!recording.complete);
    let read = samples(&recording);
    assert!(read.len() > 100, "{} samples", read.len());
    let due = |k: usize| k as f64 / 100.0;
    assert!(read.iter().enumerate().all(|(k, sample)| sample.time == due(k)), "no gaps");
}

#[test]
fn what_is_no_recording_is_said_to_be_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("file");
    let error = || Recording::open(&path).expect_err("no recording").to_string();
    assert!(error().contains("No such file"), "{}", error());
    std::fs::write(&path, b"").expect("written");
    assert!(error().contains("the file is empty"), "{}", error());
    std::fs::write(&path, b"MCAP").expect("written");
    assert!(error().contains("it ends before its description"), "{}", error());
    std::fs::write(&path, vec![0x2a; 100_000]).expect("written");
    assert!(error().contains("it is not an MCAP file"), "{}", error());
    let mut foreign = mcap::Writer::new(std::fs::File::create(&path).expect("created")).expect("an MCAP file");
    foreign.finish().expect("finished");
    drop(foreign);
    assert!(error().contains("an MCAP file of another program"), "{}", error());
    let folder = Recording::open(folder.path()).expect_err("a folder").to_string();
    assert!(folder.contains("directory"), "{folder}");
}

/// A chunk whose checksums are right may hold what no run writes: everyone who reads it says so, and what is recovered has none of it.
#[test]
fn times_that_no_run_has_are_damage_for_everyone() {
    let folder = tempfile::tempdir().expect("a folder");
    let motion = Motion::double_link();
    for (times, whole) in [
        (&[0.0, 0.01, 0.01, 0.02][..], 4),
        (&[0.0, 0.01, f64::NAN, 0.02], 2),
        (&[0.0, f64::INFINITY, 0.02], 1),
        (&[0.0, 0.02, 0.01], 2),
        (&[f64::NAN, 0.01], 0),
    ] {
        let path = folder.path().join("swing.mcap");
        let mut writer = RecordingFile::create(&path).and_then(|file| file.begin(&motion.opening())).expect("open");
        for (count, time) in times.iter().enumerate() {
            let sample = OwnedSample { time: *time, ..motion.at(0.01 * count as f64) };
            writer.sample(&sample.borrow()).expect("written");
        }
        writer.finish(&Outcome { summary: OUTCOME.into() }).expect("finished");
        let recording = Recording::open(&path).expect("a recording");
        let is_whole = whole == times.len();
        let read: Vec<_> = recording.samples().expect("opened").collect();
        assert_eq!(read.iter().take_while(|sample| sample.is_ok()).count(), whole, "{times:?}");
        assert_eq!(read.iter().all(Result::is_ok), is_whole, "{times:?}");
        let damage = recording.survey().expect("counted").damage;
        assert_eq!(damage.is_none(), is_whole, "{times:?}: {damage:?}");
        let saved = folder.path().join("saved.mcap");
        let recovered = recording.recover(&saved).expect("recovered");
        assert_eq!(recovered.is_all(), is_whole, "{times:?}");
        assert!(Recording::open(&saved).expect("a recording").survey().expect("counted").damage.is_none());
        std::fs::remove_file(&path).expect("there");
    }
}

fn samples(recording: &Recording) -> Vec<OwnedSample> {
    recording.samples().expect("opened").map(|sample| sample.expect("a sample")).collect()
}
