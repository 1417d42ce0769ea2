//! What the shell gets: help with examples that work, completions, manual pages, colours, a file to start from.

use super::{Answer, Bench, shipped};
use assert_cmd::Command;
use std::path::Path;

/// Commands as `--help` lists them.
fn commands(bench: &Bench) -> Vec<String> {
    let help = bench.call(&["--help"]).code(0).out;
    let list = help.split("Commands:\n").nth(1).expect("a list of commands");
    let names = list.lines().take_while(|line| !line.is_empty());
    // Long descriptions go on in lines that begin further right.
    let names = names.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "help").map(str::to_owned).collect()
}

/// The lines of `--help` that begin with the program's name, long ones with what was wrapped.
fn examples(help: &str) -> Vec<String> {
    let after = help.split("Examples:\n").nth(1).unwrap_or_default();
    let mut all: Vec<String> = Vec::new();
    for line in after.lines().map(str::trim).filter(|line| !line.is_empty()) {
        match all.last_mut() {
            Some(before) if !line.contains("stillpoint") => *before = format!("{before} {line}"),
            _ => all.push(line.to_owned()),
        }
    }
    all.retain(|line| line.starts_with("stillpoint"));
    all
}

/// Runs a line as a shell does, with the program on the path.
fn shell(bench: &Bench, line: &str) -> Answer {
    let program = Path::new(env!("CARGO_BIN_EXE_stillpoint"));
    let path =
        format!("{}:{}", program.parent().expect("a folder").display(), std::env::var("PATH").unwrap_or_default());
    Answer::of(Command::new("sh").current_dir(bench.path()).env("PATH", path).args(["-c", line]))
}

#[cfg(unix)]
#[test]
fn every_example_of_the_help_works() {
    let bench = Bench::new();
    let scenarios = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios");
    std::os::unix::fs::symlink(scenarios, bench.path().join("scenarios")).expect("a link");
    for (scenario, name) in [("pendulum", "pendulum"), ("double_pendulum", "double_pendulum"), ("pendulum", "copy")] {
        let out = format!("{name}.mcap");
        bench.call(&["run", &shipped(scenario), "--quiet", "--set", "simulate.duration=1", "--out", &out]).code(0);
    }
    bench.write(
        "robot.urdf",
        r#"<robot name="r"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
        <inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="shoulder" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"#,
    );
    // What a killed run would leave.
    let whole = std::fs::read(bench.path().join("copy.mcap")).expect("read");
    bench.write("killed.mcap.partial", &whole[..whole.len() - 300]);
    // What `cargo build -p stillpoint-fmu` would leave.
    bench.write("libstillpoint_fmu.so", stillpoint::fmu::MARK);
    let mut names = commands(&bench);
    assert!(names.len() > 15, "{names:?}");
    names.insert(0, String::new());
    // What `study` looks at.
    names.sort_by_key(|name| name != "sweep");
    for name in names {
        // Examples of other commands may have run the pendulum anew.
        std::fs::copy(bench.path().join("copy.mcap"), bench.path().join("pendulum.mcap")).expect("a copy");
        let call: Vec<&str> = [name.as_str(), "--help"].into_iter().filter(|word| !word.is_empty()).collect();
        let lines = examples(&bench.call(&call).code(0).out);
        assert!(!lines.is_empty(), "`{name} --help` has no examples");
        for line in lines {
            // A viewer is not everywhere, and a build may be without Rerun or Parquet.
            let needs_viewer = line.contains(" view ") && !line.contains(".glb");
            let skipped = (needs_viewer && (!line.contains("--save") || cfg!(not(feature = "view"))))
                || (["--parquet", "--out mounts", "study mounts"].iter().any(|words| line.contains(words))
                    && cfg!(not(feature = "parquet")));
            if !skipped {
                let answer = shell(&bench, &line);
                assert_eq!(answer.code, 0, "{line}: {answer:#?}");
            }
        }
    }
    for made in
        ["arm.mcap", "killed.mcap", "tables", "angle.csv", "energies.svg", "pages", "linkage.toml", "machine.fmu"]
    {
        assert!(bench.path().join(made).exists(), "{made}");
    }
}

#[test]
fn new_files_are_fine_and_come_to_rest() {
    let bench = Bench::new();
    for kind in ["pendulum", "chain", "robot", "linkage"] {
        let name = format!("{kind}.toml");
        bench.call(&["new", &name, "--kind", kind]).code(0);
        let text = std::fs::read_to_string(bench.path().join(&name)).expect("a file");
        assert!(
            text.contains(&format!("stillpoint statics {name}")) || text.contains(&format!("stillpoint check  {name}")),
            "{text}"
        );
        bench.call(&["check", &name]).code(0);
        let rest = bench.call(&["rest", &name, "--set", "simulate.duration=2", "--json"]).code(0).json();
        assert_eq!((&rest["rested"], &rest["statics"]["stability"]), (&true.into(), &"stable".into()), "{kind}");
        let again = bench.call(&["new", &name, "--kind", "pendulum"]).code(2);
        assert!(again.err.contains("is there already"), "{again:#?}");
        assert_eq!(std::fs::read_to_string(bench.path().join(&name)).expect("a file"), text);
    }
    assert!(bench.call(&["new", "x.toml", "--kind", "robt"]).code(2).err.contains("robot"));
    assert!(bench.call(&["new", "nowhere/x.toml"]).code(2).err.contains("cannot write `nowhere/x.toml`"));
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let bench = Bench::new();
    bench.call(&["man", "pages"]).code(0);
    let main = bench.call(&["man"]).code(0).out;
    for name in commands(&bench) {
        for kind in ["bash", "zsh", "fish", "powershell", "elvish"] {
            assert!(bench.call(&["completions", kind]).code(0).out.contains(&name), "{kind} {name}");
        }
        assert!(main.contains(&name), "{name}");
        let page = std::fs::read_to_string(bench.path().join(format!("pages/stillpoint-{name}.1"))).expect("a page");
        assert!(page.contains(".SH EXAMPLES") && !page.contains("EXTRA"), "{page}");
    }
    if cfg!(unix) {
        let script = bench.call(&["completions", "bash"]).code(0).out;
        bench.write("stillpoint.bash", script);
        let line = "bash -c '. ./stillpoint.bash; COMP_WORDS=(stillpoint rec); COMP_CWORD=1; _stillpoint stillpoint rec stillpoint; echo ${COMPREPLY[@]}'";
        assert_eq!(shell(&bench, line).code(0).out, "recover\n");
    }
}

#[test]
fn colours_follow_the_customs_of_the_shell() {
    let bench = Bench::new();
    bench.write("bad.toml", "[[body]]\nname = 3\n");
    let coloured = |set: &[(&str, &str)]| {
        let mut command = bench.command(&["check", "bad.toml"]);
        command.env_remove("CLICOLOR").envs(set.iter().copied());
        String::from_utf8_lossy(&command.output().expect("the program starts").stderr).contains('\u{1b}')
    };
    assert!(!coloured(&[]), "no terminal");
    assert!(!coloured(&[("CLICOLOR", "1")]), "no terminal");
    assert!(coloured(&[("CLICOLOR_FORCE", "1")]));
    assert!(!coloured(&[("CLICOLOR_FORCE", "0")]));
    assert!(!coloured(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]));
}

#[test]
fn every_command_takes_a_scenario_from_standard_input() {
    let bench = Bench::new();
    let text = bench.call(&["new", "-"]).code(0).out;
    for command in ["check", "statics", "rest", "inspect", "run"] {
        let answer = Answer::of(bench.command(&[command, "-", "--json"]).write_stdin(text.clone())).code(0);
        answer.json();
    }
    assert_eq!(bench.names(), ["recording.mcap"]);
}

#[test]
fn wherever_there_is_an_out_it_is_an_o() {
    let bench = Bench::new();
    let mut with_out = 0;
    for name in commands(&bench) {
        let help = bench.call(&[&name, "--help"]).code(0).out;
        let options = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
        for line in options.filter(|line| line.contains("--out <")) {
            assert!(line.starts_with("-o, --out <"), "{name}: {line}");
            with_out += 1;
        }
    }
    assert!(with_out > 8, "{with_out}");
}
