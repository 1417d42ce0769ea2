//! The commands in the documents print what stands below them.

use super::{pages, root};
use assert_cmd::Command;
use std::path::Path;

/// A command with what is shown below it.
#[derive(Debug)]
struct Shown {
    page: String,
    line: usize,
    command: String,
    output: Vec<String>,
}

/// The commands of the `console` blocks of a page, in order.
fn commands(page: &str, text: &str) -> Vec<Shown> {
    let mut found: Vec<Shown> = Vec::new();
    let (mut inside, mut open) = (false, false);
    for (index, line) in text.lines().enumerate() {
        if line.starts_with("```") {
            inside = line == "```console";
            open = false;
        } else if inside && let Some(command) = line.strip_prefix("$ ") {
            // The same program, before it is installed.
            let built = command.strip_prefix("cargo run --release -- ").map(|rest| format!("stillpoint {rest}"));
            let command = built.unwrap_or_else(|| command.to_owned());
            found.push(Shown { page: page.into(), line: index + 1, command, output: Vec::new() });
            open = true;
        } else if inside
            && open
            && let Some(last) = found.last_mut()
        {
            last.output.push(line.to_owned());
        }
    }
    found
}

/// Words of a command line; single quotes keep theirs together, a comment ends it.
fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for c in command.chars() {
        match c {
            '\'' => quoted = !quoted,
            '#' if !quoted && words.last().is_some_and(String::is_empty) => break,
            ' ' if !quoted => words.push(String::new()),
            _ => words.last_mut().expect("a word").push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Whether this test can call it: no placeholders, no other programs, no window.
fn callable(words: &[String]) -> bool {
    let plain = |word: &String| !word.contains(['|', '>', '…', '$']) && !word.starts_with("FILE") && word != "SCENARIO";
    let window = words.get(1).is_some_and(|word| word == "view")
        && !(cfg!(feature = "view") && words.contains(&"--save".to_owned()))
        && !words.iter().any(|word| word.ends_with(".glb"));
    let painted = words.iter().any(|word| word == "video" || word.ends_with(".png")) && cfg!(not(feature = "picture"));
    words[0] == "stillpoint"
        && words.iter().all(plain)
        && !window
        && !painted
        && (cfg!(feature = "parquet") || !of_dataset(words))
}

/// Whether it writes or reads a dataset.
fn of_dataset(words: &[String]) -> bool {
    let command = words.get(1).map_or("", String::as_str);
    let folder = words.windows(2).any(|pair| pair[0] == "--out" && !pair[1].contains('.'));
    command == "study" && !words.contains(&"--fit".to_owned()) || command == "sweep" && folder
}

/// Too long for a build that is not optimised.
fn slow(words: &[String]) -> bool {
    let named = |text: &str| words.iter().any(|word| word.contains(text));
    cfg!(debug_assertions) && (named("--compare") || named("precision") || named("bench"))
}

const UNITS_OF_TIME: [&str; 4] = ["s", "ms", "µs", "ns"];

/// Whether a printed line is the shown one but for times, round-off, and small changes of counts.
fn alike(shown: &str, printed: &str) -> bool {
    let bare = |word: &str| word.trim_matches(|c| "(),;:`".contains(c)).to_owned();
    let split = |line: &str| line.split_whitespace().map(bare).collect::<Vec<_>>();
    let (shown, open) = match shown.trim_end().strip_suffix('…') {
        Some(start) => (split(start), true),
        None => (split(shown), false),
    };
    let printed = split(printed);
    if shown.len() > printed.len() || (!open && shown.len() < printed.len()) {
        return false;
    }
    let timed = |line: &[String], at: usize| {
        line.get(at + 1).is_some_and(|unit| UNITS_OF_TIME.contains(&unit.as_str()) || unit == "×")
    };
    (0..shown.len()).all(|at| {
        let (a, b) = (&shown[at], &printed[at]);
        match (a.parse::<f64>(), b.parse::<f64>()) {
            _ if a == b => true,
            (Ok(_), Ok(_)) if timed(&shown, at) && timed(&printed, at) => true,
            (Ok(x), Ok(y)) if x.abs().max(y.abs()) < 1e-6 => true,
            // Printed with six digits, of errors and residuals with two; a count may be off by some steps.
            (Ok(x), Ok(y)) if !a.contains('.') => (x - y).abs() <= 0.2 * x.abs(),
            (Ok(x), Ok(y)) if a.contains('e') => (x / y).abs().log10().abs() < 1.0,
            // As many digits as are printed, but for a zero at the end.
            (Ok(x), Ok(y)) => (x - y).abs() <= 1e-3 * x.abs() && a.len().abs_diff(b.len()) <= 1,
            _ => UNITS_OF_TIME.contains(&a.as_str()) && UNITS_OF_TIME.contains(&b.as_str()),
        }
    })
}

/// The first shown line that is not among the printed ones in this order.
fn missing<'a>(shown: &'a [String], printed: &str) -> Option<&'a String> {
    let mut rest = printed.lines().skip_while(|_| false);
    shown.iter().filter(|line| !line.trim().is_empty() && line.trim() != "…").find(|line| !rest.any(|p| alike(line, p)))
}

/// A folder with all that is in it.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        match path.is_dir() {
            true => copy(&path, &target),
            false => drop(std::fs::copy(&path, &target).expect("a copy")),
        }
    }
}

/// What the pages take for granted in the folder they work in.
fn prepare(folder: &Path) {
    let scenarios = root().join("scenarios");
    copy(&scenarios, &folder.join("scenarios"));
    let brick = "[[body]]\nname = \"brick\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"free\" }\n";
    std::fs::write(folder.join("brick.toml"), brick).expect("a file");
    let mobile = std::fs::read_to_string(scenarios.join("calder_mobile.toml")).expect("the mobile");
    let at = mobile.find("parent = \"ceiling_wire\"").expect("a body on the wire");
    let mut broken = mobile.clone();
    broken.replace_range(at..at + 23, "parent = \"celing_wire\"");
    let leaf = broken.find("name = \"red_leaf\"").expect("a red leaf");
    let density = leaf + broken[leaf..].find("density").expect("its density");
    broken.replace_range(density..density + 7, "densty");
    std::fs::write(folder.join("broken.toml"), broken).expect("a file");
}

#[test]
fn commands_print_what_the_pages_show() {
    let mut wrong = Vec::new();
    let mut called = 0;
    for (page, text) in pages() {
        let shown = commands(&page, &text);
        if !shown.iter().any(|shown| shown.command.starts_with("stillpoint")) {
            continue;
        }
        let folder = tempfile::tempdir().expect("a folder");
        prepare(folder.path());
        let mut code = None;
        for shown in shown {
            let words = words(&shown.command);
            if shown.command == "echo $?" {
                if let Some(code) = code.filter(|code: &i32| *code != shown.output[0].parse::<i32>().expect("a number"))
                {
                    wrong.push(format!("{}:{}: exit code {code}", shown.page, shown.line));
                }
                continue;
            }
            code = None;
            if words.is_empty() || !callable(&words) || slow(&words) {
                continue;
            }
            called += 1;
            // The rest of the command does the same without the window.
            let words: Vec<String> = words.into_iter().filter(|word| word != "--view").collect();
            let mut command = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
            let output = command.current_dir(folder.path()).args(&words[1..]).output().expect("the program starts");
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            let printed = text(&output.stderr) + &text(&output.stdout);
            code = output.status.code();
            if let Some(line) = missing(&shown.output, &printed) {
                wrong.push(format!(
                    "{}:{}: {}\n  not printed: {line}\n{printed}",
                    shown.page, shown.line, shown.command
                ));
            }
            if code == Some(2) && !shown.output.iter().any(|line| line.starts_with("error")) {
                wrong.push(format!("{}:{}: {}\n{printed}", shown.page, shown.line, shown.command));
            }
        }
    }
    assert!(called > 15, "only {called} commands were called");
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn a_wrong_line_is_noticed() {
    assert!(alike(
        "simulated 5 s in 134.6 ms (37 × real time) with dopri5",
        "simulated 5 s in 2.1 s (2 × real time) with dopri5"
    ));
    assert!(alike("  steps        1678 (411 rejected), …", "  steps  1650 (400 rejected), 12536 accelerations"));
    assert!(!alike("  1 body, 6 degrees of freedom", "  2 bodies, 6 degrees of freedom"));
    assert!(!alike("growth 9.168 per second", "growth 9.268 per second"));
    assert!(!alike("growth 9.16826 per second", "growth 9.168 per second"));
    assert!(!alike("stable equilibrium", "unstable equilibrium"));
    assert_eq!(missing(&["a".into(), "…".into(), "c".into()], "a\nb\nc"), None);
    assert_eq!(missing(&["c".into(), "a".into()], "a\nb\nc"), Some(&"a".into()));
}
