//! Recordings.

use super::{each, edits};
use crate::record::fixture::{Motion, record};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use std::path::Path;
use stillpoint::record::{OwnedSample, Recording};

const WORDS: &[&[u8]] = &[
    b"\0\0\0\0",
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\xff\xff\xff\xff\xff",
    b"\x7f\xff\xff\xff",
    b"\x89MCAP0\r\n",
    b"\x01",
    b"\x02",
    b"\x03",
    b"\x04",
    b"\x05",
    b"\x06",
    b"\x07",
    b"\x08",
    b"\x09",
    b"\x0a",
    b"\x0b",
    b"\x0c",
    b"\x0d",
    b"\x0e",
    b"\x0f",
    b"\x80",
    b"zstd",
    b"lz4",
    b"\x28\xb5\x2f\xfd",
    b"stillpoint",
    b"scene",
    b"json",
    b"{}",
    b"[[[[[[",
    b"1e999",
    b"\x00\x00\x00\x01\x00\x00\x00\x00",
];

/// Whatever is in the file: what is read of it is a prefix of what was written, and saving it gives that again.
fn read(path: &Path, scene: &stillpoint::record::Scene, all: &[OwnedSample]) -> TestCaseResult {
    let Ok(recording) = Recording::open(path) else { return Ok(()) };
    let _ = recording.survey();
    let samples = |recording: &Recording| -> Vec<OwnedSample> {
        recording.samples().into_iter().flatten().map_while(Result::ok).collect()
    };
    let found = samples(&recording);
    let intact = recording.scene == *scene;
    // Changes may put a whole chunk in twice; no number is ever wrong.
    prop_assert!(!intact || found.iter().all(|sample| all.contains(sample)));
    let saved = path.with_extension("saved");
    if recording.recover(&saved).is_ok()
        && let Ok(again) = Recording::open(&saved)
    {
        let again = samples(&again);
        prop_assert!(!intact || again.iter().all(|sample| all.contains(sample)));
    }
    Ok(())
}

#[test]
fn a_damaged_recording_gives_no_wrong_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, path) = (folder.path().join("whole.mcap"), folder.path().join("damaged.mcap"));
    let motion = Motion::double_link();
    record(&whole, &motion, 0.1);
    let bytes = std::fs::read(&whole).expect("read");
    let all: Vec<OwnedSample> = Motion::times(0.1).map(|time| motion.at(time)).collect();
    each(1000, edits(4000, WORDS), |edits| {
        let mut bytes = bytes.clone();
        edits.iter().for_each(|edit| edit.apply(&mut bytes));
        std::fs::write(&path, bytes).expect("written");
        read(&path, &motion.scene, &all)
    });
}

#[test]
fn any_bytes_are_an_answer() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("file.mcap");
    let start = prop_oneof![Just(Vec::new()), Just(b"\x89MCAP0\r\n".to_vec())];
    each(1000, (start, proptest::collection::vec(any::<u8>(), 0..400)), |(mut bytes, rest)| {
        bytes.extend(rest);
        std::fs::write(&path, bytes).expect("written");
        prop_assert!(Recording::open(&path).is_err());
        Ok(())
    });
}

#[test]
fn a_recording_cut_at_any_byte_keeps_what_is_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, path) = (folder.path().join("whole.mcap"), folder.path().join("cut.mcap"));
    let motion = Motion::double_link();
    record(&whole, &motion, 0.02);
    let bytes = std::fs::read(&whole).expect("read");
    let all: Vec<OwnedSample> = Motion::times(0.02).map(|time| motion.at(time)).collect();
    let mut kept = 0;
    // Some hundred of them; all of them where more is asked for.
    let step = if std::env::var_os("ROBUST_CASES").is_some() { 1 } else { 61 };
    for length in (0..bytes.len()).rev().step_by(step) {
        std::fs::write(&path, &bytes[..length]).expect("written");
        let Ok(recording) = Recording::open(&path) else { continue };
        assert!(!recording.complete, "cut at {length} of {}", bytes.len());
        let read: Vec<OwnedSample> =
            recording.samples().expect("opened").map(|sample| sample.expect("whole")).collect();
        // One chunk: it is there or it is not.
        assert!(read == all || read.is_empty(), "cut at {length}: {} samples", read.len());
        kept += usize::from(!read.is_empty());
    }
    assert!(kept > 0 && kept < bytes.len(), "{kept}");
}
