//! The picture: saved, streamed, and refused where there is nobody to look.

use super::fixture::{Motion, record};
use std::time::{Duration, Instant};
use stillpoint::record::view::{Sink, Wishes, view};

#[cfg(not(feature = "view"))]
#[test]
fn without_the_feature_the_error_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swing.mcap");
    record(&path, &Motion::double_link(), 0.1);
    let error = view(&path, &Sink::Save(folder.path().join("swing.rrd")), &Wishes::default())
        .expect_err("no viewer")
        .to_string();
    assert!(error.contains("built without the `view` feature"), "{error}");
    assert!(Instant::now().elapsed() < Duration::from_secs(1));
}

#[cfg(feature = "view")]
mod with_view {
    use super::*;
    use std::path::PathBuf;
    use std::process::{Command, Stdio};
    use stillpoint::record::view::Viewer;
    use stillpoint::record::{ContactPush, Event, Outcome, Recorder, RecordingFile};
    use tempfile::TempDir;

    /// What a call of the `rerun` program prints. It comes with the viewer: `pip install rerun-sdk`.
    fn rerun(arguments: &[&str], rrd: &std::path::Path) -> String {
        let output = Command::new("rerun").args(arguments).arg(rrd).output().expect("the `rerun` program runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// The program reads the file and finds nothing wrong.
    fn verify(rrd: &std::path::Path) {
        rerun(&["rrd", "verify"], rrd);
    }

    fn save_recording(folder: &TempDir) -> PathBuf {
        let (mcap, rrd) = (folder.path().join("swing.mcap"), folder.path().join("swing.rrd"));
        record(&mcap, &Motion::double_link(), 4.0);
        let shown = view(&mcap, &Sink::Save(rrd.clone()), &Wishes::default()).expect("saved");
        assert_eq!((shown.samples, shown.complete, shown.notes.len()), (401, true, 0));
        rrd
    }

    fn save_instant(folder: &TempDir) -> PathBuf {
        let (mcap, rrd) = (folder.path().join("instant.mcap"), folder.path().join("instant.rrd"));
        record(&mcap, &Motion::double_link(), 1.0);
        let wishes = Wishes { at: Some(0.501), reactions: true, ..Wishes::default() };
        let shown = view(&mcap, &Sink::Save(rrd.clone()), &wishes).expect("saved");
        assert_eq!(shown.samples, 1);
        rrd
    }

    fn save_run(folder: &TempDir) -> PathBuf {
        let rrd = folder.path().join("chain.rrd");
        let motion = Motion::chain(40);
        let mut viewer = Viewer::open(&Sink::Save(rrd.clone()), &motion.opening()).expect("open");
        assert_eq!(viewer.notes(), ["Hinges [rad]: the first 8 of 40 are plotted"]);
        for time in Motion::times(1.0) {
            viewer.sample(&motion.at(time).borrow()).expect("drawn");
        }
        viewer.finish(&Outcome { summary: String::new() }).expect("finished");
        rrd
    }

    /// Of a recording, of one instant of it, and of a run while it goes on. The file says in its first bytes what it is.
    #[test]
    fn pictures_are_saved() {
        let folder = tempfile::tempdir().expect("a folder");
        for rrd in [save_recording(&folder), save_instant(&folder), save_run(&folder)] {
            let bytes = std::fs::read(&rrd).expect("a file");
            assert!(bytes.starts_with(b"RRF2") && bytes.len() > 1000, "{}: {} bytes", rrd.display(), bytes.len());
        }
    }

    #[test]
    #[ignore = "needs the `rerun` program"]
    fn the_viewer_finds_nothing_wrong_in_saved_pictures() {
        let folder = tempfile::tempdir().expect("a folder");
        for rrd in [save_recording(&folder), save_instant(&folder), save_run(&folder)] {
            verify(&rrd);
        }
    }

    /// Thousands of things would keep the viewer from moving.
    #[test]
    #[ignore = "needs the `rerun` program"]
    fn many_bodies_are_drawn_as_few_things() {
        let folder = tempfile::tempdir().expect("a folder");
        let (mcap, rrd) = (folder.path().join("chain.mcap"), folder.path().join("chain.rrd"));
        record(&mcap, &Motion::chain(400), 0.05);
        view(&mcap, &Sink::Save(rrd.clone()), &Wishes::default()).expect("saved");
        verify(&rrd);
        let print = rerun(&["rrd", "print"], &rrd);
        assert!(print.contains("/world/bodies/joined"), "{print}");
        assert!(!print.contains("/world/link"), "{print}");
    }

    /// Of a run while it goes on and of its recording alike.
    #[test]
    #[ignore = "needs the `rerun` program"]
    fn what_happens_and_what_is_pushed_is_shown() {
        let folder = tempfile::tempdir().expect("a folder");
        let (mcap, saved, live) =
            (folder.path().join("a.mcap"), folder.path().join("a.rrd"), folder.path().join("b.rrd"));
        let motion = Motion::double_link();
        let events = [(0.105, "lower", "impact of `lower` at 0.5"), (0.2, "integrator", "`sdirk4` takes over")]
            .map(|(time, name, text)| Event { time, name: name.into(), text: text.into() });
        let mut file = RecordingFile::create(&mcap).and_then(|file| file.begin(&motion.opening())).expect("open");
        let mut viewer = Viewer::open(&Sink::Save(live.clone()), &motion.opening()).expect("open");
        for recorder in [&mut file as &mut dyn Recorder, &mut viewer] {
            let mut events = events.iter().peekable();
            for time in Motion::times(0.3) {
                while let Some(event) = events.next_if(|event| event.time <= time) {
                    recorder.event(event).expect("marked");
                }
                recorder.sample(&motion.at(time).borrow()).expect("taken");
            }
            recorder.finish(&Outcome { summary: "{}".into() }).expect("finished");
        }
        view(&mcap, &Sink::Save(saved.clone()), &Wishes::default()).expect("saved");
        for rrd in [saved, live] {
            verify(&rrd);
            let print = rerun(&["rrd", "print", "-vvv"], &rrd);
            for part in [
                "/events/lower",
                "impact of `lower` at 0.5",
                "/events/integrator",
                "/springs/mount",
                "Mesh3D",
                "DEBUG",
                "PT0.105S",
                "/couplings/ring/gap",
                "/couplings/ring/force.x",
                "Couplings [N m]",
                "Gaps [m]",
                "TextLog",
            ] {
                assert!(print.contains(part), "no {part} in {print}");
            }
        }
    }

    /// Arrows of contacts, at the times of samples and as many as bear then: of a run while it goes on and of its recording alike.
    #[test]
    #[ignore = "needs the `rerun` program"]
    fn what_contacts_push_with_is_shown() {
        let folder = tempfile::tempdir().expect("a folder");
        let (mcap, saved, live) =
            (folder.path().join("a.mcap"), folder.path().join("a.rrd"), folder.path().join("b.rrd"));
        let motion = Motion::double_link();
        let push = |slips: bool| ContactPush {
            between: ["upper", "lower"].map(str::to_owned),
            point: [0.25, 0.0, -1.5],
            normal: [0.0, 0.0, 1.0],
            force: [0.0, 0.0, 3.0],
            slips,
        };
        let mut file = RecordingFile::create(&mcap).and_then(|file| file.begin(&motion.opening())).expect("open");
        let mut viewer = Viewer::open(&Sink::Save(live.clone()), &motion.opening()).expect("open");
        for recorder in [&mut file as &mut dyn Recorder, &mut viewer] {
            for (k, time) in Motion::times(0.1).enumerate() {
                let pushes = [vec![push(false), push(true)], Vec::new(), vec![push(true)]];
                recorder.contacts(time, &pushes[k % 3]).expect("taken");
                recorder.sample(&motion.at(time).borrow()).expect("taken");
            }
            recorder.finish(&Outcome { summary: "{}".into() }).expect("finished");
        }
        view(&mcap, &Sink::Save(saved.clone()), &Wishes::default()).expect("saved");
        for rrd in [saved, live] {
            verify(&rrd);
            let print = rerun(&["rrd", "print", "-vvv"], &rrd);
            // Green and orange as Rerun keeps colours: red, green, blue, opacity in one number.
            for part in ["/contacts", "Arrows3D:vectors", &0x2e9e_45ff_u32.to_string(), &0xed7d_1aff_u32.to_string()] {
                assert!(print.contains(part), "no {part} in {print}");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    #[ignore = "needs the `rerun` program"]
    fn a_running_motion_is_streamed_to_a_listening_viewer() {
        let folder = tempfile::tempdir().expect("a folder");
        let got = folder.path().join("got.rrd");
        let port = std::net::TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("free").port();
        // The viewer program without a window: it writes down what it is sent.
        let mut receiver = Command::new("rerun");
        receiver.args(["--bind", "127.0.0.1", "--port", &port.to_string(), "--save"]).arg(&got);
        // The program starts another one: a group of their own, to be stopped together.
        std::os::unix::process::CommandExt::process_group(&mut receiver, 0);
        let spawned = receiver.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let mut receiver = spawned.expect("the `rerun` program runs");
        let motion = Motion::double_link();
        let sink = Sink::Connect(format!("127.0.0.1:{port}"));
        let open = || Viewer::open(&sink, &motion.opening()).ok();
        let viewer = (0..200).find_map(|_| {
            open().or_else(|| {
                std::thread::sleep(Duration::from_millis(100));
                None
            })
        });
        let mut viewer = viewer.expect("it listens within 20 s");
        for time in Motion::times(1.0) {
            viewer.sample(&motion.at(time).borrow()).expect("drawn");
        }
        viewer.finish(&Outcome { summary: String::new() }).expect("all taken in");
        // It writes what it has taken in a little later.
        std::thread::sleep(Duration::from_secs(1));
        Command::new("kill").args(["-KILL", "--", &format!("-{}", receiver.id())]).status().expect("stopped");
        receiver.wait().expect("ended");
        // It was killed in the middle of its file: what it says of that counts, not how it ends.
        let print = Command::new("rerun").args(["rrd", "print"]).arg(&got).output().expect("the `rerun` program runs");
        let print = String::from_utf8_lossy(&print.stdout);
        for part in ["/world/upper - ", "/springs/left", "/energy/kinetic", "Blueprint"] {
            assert!(print.contains(part), "no {part} in {print}");
        }
    }

    #[test]
    fn where_nobody_listens_it_is_said_at_once() {
        let begin = Instant::now();
        let motion = Motion::double_link();
        // Port 1 is reserved and nobody's.
        let error = Viewer::open(&Sink::Connect("127.0.0.1:1".into()), &motion.opening()).err().expect("nobody");
        assert!(error.to_string().contains("no viewer listens at `127.0.0.1:1`"), "{error}");
        assert!(begin.elapsed() < Duration::from_secs(2));
    }

    #[test]
    fn a_listener_that_is_no_viewer_is_given_up() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        // Answers the probe, and closes every connection.
        std::thread::spawn(move || listener.incoming().for_each(drop));
        let motion = Motion::double_link();
        let begin = Instant::now();
        // Whether it is noticed while the opening is sent or later is a matter of luck.
        let lost = Viewer::open(&Sink::Connect(address.to_string()), &motion.opening()).and_then(|mut viewer| {
            Motion::times(2.0).try_for_each(|time| viewer.sample(&motion.at(time).borrow()))?;
            viewer.finish(&Outcome { summary: String::new() })
        });
        assert!(lost.expect_err("no viewer").to_string().contains("the viewer is lost"));
        assert!(begin.elapsed() < Duration::from_secs(30), "{:?}", begin.elapsed());
    }

    #[test]
    fn a_picture_in_a_missing_folder_is_refused() {
        let motion = Motion::double_link();
        let error = Viewer::open(&Sink::Save("/no/such/folder/a.rrd".into()), &motion.opening()).err();
        assert!(error.expect("no folder").to_string().contains("/no/such/folder/a.rrd"));
    }
}
