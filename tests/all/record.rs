//! Recordings: what is written comes back, whatever happens to the file in between.

mod damage;
mod fixture;
mod python;
mod view;

use fixture::{Motion, OUTCOME, SCENARIO, STATICS, record};
use stillpoint::record::{
    Fanout, Memory, Opening, Outcome, OwnedSample, RecordError, Recorder, Recording, RecordingFile, Sample,
};

#[test]
fn a_file_gives_back_what_memory_keeps() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let motion = Motion::double_link();
    let mut memory = Memory::new(&motion.opening());
    let file = record(&path, &motion, 2.0);
    for time in Motion::times(2.0) {
        memory.sample(&motion.at(time).borrow()).expect("kept");
    }

    let recording = Recording::open(&path).expect("a recording");
    assert_eq!(file, path);
    assert!(recording.complete);
    assert_eq!(recording.scene, motion.scene);
    assert_eq!(recording.scenario, SCENARIO);
    assert_eq!(recording.statics.as_deref(), Some(STATICS));
    assert_eq!(recording.outcome.as_deref(), Some(OUTCOME));
    assert_eq!(recording.version, env!("CARGO_PKG_VERSION"));
    let samples: Vec<OwnedSample> = recording.samples().expect("samples").map(|sample| sample.expect("one")).collect();
    assert_eq!(samples.len(), memory.samples.len());
    for (read, kept) in samples.iter().zip(&memory.samples) {
        assert_eq!(bits(read), bits(kept), "at {} s", kept.time);
    }
}

/// Every number of a sample, as bits. Protobuf leaves zeros out of Foxglove's messages, and their sign with them: poses
/// count without it.
fn bits(sample: &OwnedSample) -> Vec<u64> {
    let energy = &sample.energy;
    let mut numbers = vec![sample.time, energy.kinetic, energy.potential, energy.work, energy.dissipated, energy.error];
    numbers.extend(sample.positions.iter().chain(&sample.velocities).chain(&sample.accelerations));
    for pose in &sample.bodies {
        numbers.extend(pose.translation.vector.iter().chain(pose.rotation.coords.iter()).map(|number| number + 0.0));
    }
    for reaction in &sample.reactions {
        numbers.extend(reaction.force.iter().chain(reaction.moment.iter()));
    }
    numbers.into_iter().map(f64::to_bits).collect()
}

#[test]
fn an_empty_scene_without_samples_is_a_recording_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("nothing.mcap");
    let scene = stillpoint::record::Scene::default();
    let opening = Opening { scene: &scene, scenario: "", statics: None };
    let mut writer = RecordingFile::create(&path).and_then(|file| file.begin(&opening)).expect("open");
    writer.finish(&Outcome { summary: "{}".into() }).expect("finished");
    let recording = Recording::open(&path).expect("a recording");
    assert!(recording.complete && recording.statics.is_none());
    assert_eq!(recording.samples().expect("samples").count(), 0);
}

#[test]
fn a_scene_of_thousands_of_bodies_fits() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("chain.mcap");
    // More hinge coordinates than protobuf has field numbers before its reserved range.
    let motion = Motion::chain(20_000);
    record(&path, &motion, 0.02);
    let recording = Recording::open(&path).expect("a recording");
    let samples: Vec<_> = recording.samples().expect("samples").map(|sample| sample.expect("one")).collect();
    assert_eq!(samples, Motion::times(0.02).map(|time| motion.at(time)).collect::<Vec<_>>());
}

#[test]
fn the_file_has_another_name_until_it_is_finished() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let partial = folder.path().join("swing.mcap.partial");
    let motion = Motion::double_link();
    let file = RecordingFile::create(&path).expect("created");
    assert!(partial.exists() && !path.exists());
    let busy = RecordingFile::create(&path).expect_err("locked");
    assert!(matches!(busy, RecordError::Busy { .. }), "{busy}");
    let mut writer = file.begin(&motion.opening()).expect("begun");
    writer.sample(&motion.at(0.0).borrow()).expect("written");
    writer.finish(&Outcome { summary: OUTCOME.into() }).expect("finished");
    assert!(!partial.exists() && path.exists());
    writer.finish(&Outcome { summary: OUTCOME.into() }).expect("nothing more to do");
}

#[test]
fn an_unused_file_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    drop(RecordingFile::create(&folder.path().join("swing.mcap")).expect("created"));
    assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 0);
}

#[test]
fn a_folder_that_is_missing_is_named() {
    let path = std::path::Path::new("/no/such/folder/swing.mcap");
    let error = RecordingFile::create(path).expect_err("no folder").to_string();
    assert!(error.contains("/no/such/folder/swing.mcap") && error.contains("No such file"), "{error}");
    let folder = tempfile::tempdir().expect("a folder");
    let error = RecordingFile::create(folder.path()).expect_err("a folder").to_string();
    assert!(error.contains("directory"), "{error}");
}

#[test]
fn a_sample_that_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let motion = Motion::double_link();
    let file = RecordingFile::create(&folder.path().join("swing.mcap")).expect("created");
    let mut writer = file.begin(&motion.opening()).expect("begun");
    let mut sample = motion.at(0.5);
    sample.velocities.pop();
    let error = writer.sample(&sample.borrow()).expect_err("too short").to_string();
    assert_eq!(error, "the sample at 0.5 s has 7 velocities, the scene has 8");
    writer.sample(&motion.at(0.5).borrow()).expect("the next one is taken");
}

#[test]
fn an_onlooker_that_fails_is_dropped_and_the_recording_goes_on() {
    struct Broken;
    impl Recorder for Broken {
        fn sample(&mut self, _: &Sample) -> Result<(), RecordError> {
            Err(RecordError::View { what: "gone".into(), hint: String::new() })
        }
        fn finish(&mut self, _: &Outcome) -> Result<(), RecordError> {
            unreachable!("dropped before")
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    let motion = Motion::double_link();
    let writer = RecordingFile::create(&path).and_then(|file| file.begin(&motion.opening())).expect("open");
    let mut fanout = Fanout::new().recorder(writer).onlooker(Broken).onlooker(Memory::new(&motion.opening()));
    for time in Motion::times(0.1) {
        fanout.sample(&motion.at(time).borrow()).expect("recorded");
    }
    fanout.finish(&Outcome { summary: OUTCOME.into() }).expect("finished");
    assert_eq!(fanout.take_lost().len(), 1);
    assert!(Recording::open(&path).expect("a recording").complete);
}

/// Who decodes every channel as protobuf must not meet another encoding unasked.
#[test]
fn ros_messages_are_written_where_they_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let motion = Motion::double_link();
    for ros in [false, true] {
        let path = folder.path().join("swing.mcap");
        let file = RecordingFile::create(&path).expect("created").with_ros(ros);
        let mut writer = file.begin(&motion.opening()).expect("open");
        writer.sample(&motion.at(0.5).borrow()).expect("written");
        writer.finish(&Outcome { summary: String::new() }).expect("finished");
        let bytes = std::fs::read(&path).expect("read");
        let messages = mcap::MessageStream::new(&bytes).expect("MCAP");
        let cdr: Vec<(String, usize)> = messages
            .map(|message| message.expect("a message"))
            .filter(|message| message.channel.message_encoding != "protobuf")
            .map(|message| (message.channel.topic.clone(), message.data.len()))
            .collect();
        // Encapsulation, time, an empty frame, two names, and three times two numbers, each on its boundary.
        let joints = 4 + 8 + 5 + 3 + 4 + 10 + 2 + 10 + 2 + 3 * (4 + 4 + 16);
        match ros {
            false => assert!(cdr.is_empty(), "{cdr:?}"),
            true => {
                assert_eq!(
                    (cdr.len(), cdr[0].0.as_str(), cdr[1].0.as_str()),
                    (2, "/robot_description", "/joint_states")
                );
                assert!(cdr[1].1.abs_diff(joints) < 8, "{cdr:?}");
            }
        }
        let samples: Vec<_> = Recording::open(&path).expect("ours").samples().expect("samples").collect();
        assert_eq!(samples.len(), 1, "nothing of ours minds them");
    }
}
