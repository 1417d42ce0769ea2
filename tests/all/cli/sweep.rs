//! Many cases in one call.

use super::{Answer, Bench, SCALE, shipped};

#[test]
fn one_row_for_every_case_whatever_became_of_it() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    // Five springs of no stiffness leave nothing to hold the pan.
    let arguments = ["sweep", "scale.toml", "--over", "pan.stiffness=0,100", "--over", "pan.mass=1:3:5", "--json"];
    let one = bench.call(&[&arguments[..], &["--threads", "1"]].concat()).code(1);
    let four = bench.call(&[&arguments[..], &["--threads", "4"]].concat()).code(1);
    assert_eq!(one.out, four.out, "the number of threads changes nothing");
    let answer = one.json();
    assert_eq!(answer["failed"], 5);
    let cases = answer["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 10);
    for (index, case) in cases.iter().enumerate() {
        let mass = 1.0 + 0.5 * (index % 5) as f64;
        assert_eq!(case["values"]["pan.mass"], mass);
        assert_eq!(case["ok"], index >= 5);
        if index >= 5 {
            // k x = m g, to rounding.
            let sunk = case["result"]["pan.distance"].as_f64().expect("a number");
            assert!((sunk + mass * 9.80665 / 100.0).abs() < 1e-14, "{sunk}");
            let frequency = case["result"]["frequencies_hz[0]"].as_f64().expect("a number");
            assert!((frequency - (100.0 / mass).sqrt() / std::f64::consts::TAU).abs() < 1e-12);
        } else {
            assert!(case["error"].as_str().expect("a reason").contains("no equilibrium"), "{case}");
        }
    }
}

/// Tables have a column for each mode that statics lists, with damping and without, in small scenes and large.
#[test]
fn cases_have_the_modes_of_statics() {
    let bench = Bench::new();
    for (count, damping) in [(63, 0.1), (65, 0.1), (120, 0.1), (65, 0.0), (205, 0.1)] {
        let text = format!(
            "[[body]]\nname = \"b\"\nrepeat = {count}\nmass = 1.0\ncenter = [0.05, 0, 0]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], next = [0.1, 0, 0], stiffness = 5000, damping = {damping} }}\n"
        );
        bench.write("chain.toml", &text);
        let told = bench.call(&["statics", "chain.toml", "--set", "gravity[2]=-9.0", "--json"]).code(0).json();
        let swept = bench.call(&["sweep", "chain.toml", "--over", "gravity[2]=-9.0", "--json"]).code(0).json();
        let result = &swept["cases"][0]["result"];
        let hertz = told["frequencies_hz"].as_array().expect("frequencies");
        for (k, hz) in hertz.iter().enumerate() {
            assert_eq!(result[format!("frequencies_hz[{k}]")], *hz, "{count} {damping}: {k}");
        }
        assert!(
            !hertz.is_empty() && result.get(format!("frequencies_hz[{}]", hertz.len())).is_none(),
            "{count} {damping}"
        );
    }
}

#[test]
fn rows_go_into_a_table_and_may_be_runs() {
    let bench = Bench::new();
    let scenario = shipped("pendulum");
    let arguments = ["sweep", &scenario, "--over", "rod.position=0:1:3", "--run", "--set", "simulate.duration=1"];
    let answer = bench.call(&[&arguments[..], &["--out", "table.csv"]].concat()).code(0);
    assert!(answer.out.ends_with("3 cases\n"), "{answer:#?}");
    let text = std::fs::read_to_string(bench.path().join("table.csv")).expect("a table");
    let lines: Vec<&str> = text.lines().collect();
    let head: Vec<&str> = lines[0].split(',').collect();
    assert_eq!(head[..4], ["case", "rod.position", "ok", "error"]);
    assert_eq!(lines.len(), 4);
    assert!(lines[1].starts_with("0,0.0,true,,"), "{text}");
    let column = |name: &str| head.iter().position(|other| *other == name).expect("a column");
    // The same as one run of that case alone.
    let alone = ["run", &scenario, "--set", "simulate.duration=1", "--set", "rod.position=0.5", "--json"];
    let last = lines[2].split(',').nth(column("final rod.angle")).expect("a column");
    assert!(bench.call(&alone).code(0).out.contains(&format!("\"positions\":{{\"rod\":[{last}]}}")), "{last}");
}

/// Column by column: words and counts are the same, numbers to the round-off that 0.1 s of a chain let go make of that of an
/// evaluation.
#[test]
fn runs_side_by_side_are_rows_one_by_one() {
    let bench = Bench::new();
    let chain = shipped("chain_of_twenty");
    let table = |lanes: &str, method: &str| {
        let vary =
            ["--vary", "link[0].position=uniform(-3,3)", "--vary", "link[7].mass=uniform(0.1,1)", "--cases", "6"];
        let method = format!("simulate.integrator={method}");
        let set = ["--set", &method, "--set", "simulate.duration=0.1", "--lanes", lanes, "--out", "x.csv"];
        let answer = bench.call(&[&["sweep", &chain, "--run"], &vary[..], &set[..]].concat()).code(0);
        let text = std::fs::read_to_string(bench.path().join("x.csv")).expect("a table");
        let rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        (answer.out.contains("side by side"), rows.collect::<Vec<_>>())
    };
    for method in ["rk4", "dopri5"] {
        let ((told, beside), (silent, alone)) = (table("auto", method), table("off", method));
        assert!(told && !silent && beside.len() == 7 && beside[0] == alone[0], "{told} {silent} {beside:?}");
        for (here, there) in beside[1..].iter().zip(&alone[1..]) {
            for ((name, here), there) in
                beside[0].iter().zip(here).zip(there).filter(|((name, _), _)| *name != "wall_seconds")
            {
                match (here.parse::<f64>(), there.parse::<f64>()) {
                    (Ok(x), Ok(y)) => assert!((x - y).abs() < 1e-10 * y.abs().max(1.0), "{name}: {x} {y}"),
                    _ => assert_eq!(here, there, "{name}"),
                }
            }
        }
    }
    // Statics is computed one by one.
    let still = bench.call(&["sweep", &chain, "--over", "link[3].mass=0.1:1:4"]).code(0);
    assert!(still.out.ends_with("4 cases\n"), "{}", still.out);
}

/// What no equilibrium follows from is read from the file, and goes side by side all the same; numbers that change what the scene is
/// made of go one by one.
#[test]
fn all_numbers_go_side_by_side() {
    let bench = Bench::new();
    let arm = shipped("spring_arm");
    let table = |lanes: &str, vary: &[&str]| {
        let set = ["simulate.integrator=dopri5", "simulate.duration=0.1", "simulate.start=given"];
        let set = set.iter().flat_map(|set| ["--set", set]).collect::<Vec<_>>();
        let vary = vary.iter().flat_map(|vary| ["--vary", vary]).collect::<Vec<_>>();
        let last = ["--cases", "4", "--lanes", lanes, "--out", "x.csv", "--json"];
        let answer = bench.call(&[&["sweep", &arm, "--run"], &set[..], &vary[..], &last[..]].concat()).code(0);
        let text = std::fs::read_to_string(bench.path().join("x.csv")).expect("a table");
        let rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        (answer.json()["side_by_side"].as_u64().expect("a width"), rows.collect::<Vec<_>>())
    };
    let vary = ["upper_arm.damping=uniform(0,1)", "lamp.velocity[0]=normal(0,1)", "bag.force[0]=normal(0,3)"];
    let ((width, beside), (one, alone)) = (table("auto", &vary), table("off", &vary));
    assert!(width > 1 && one == 1, "{width} {one}");
    for (here, there) in beside[1..].iter().zip(&alone[1..]) {
        let named = beside[0].iter().zip(here).zip(there);
        for ((name, here), there) in named.filter(|((name, _), _)| *name != "wall_seconds") {
            match (here.parse::<f64>(), there.parse::<f64>()) {
                (Ok(x), Ok(y)) => assert!((x - y).abs() < 1e-10 * y.abs().max(1.0), "{name}: {x} {y}"),
                _ => assert_eq!(here, there, "{name}"),
            }
        }
    }
    bench.write(
        "chain.toml",
        "[simulate]\nstart = \"given\"\nduration = 0.01\nintegrator = \"rk4\"\nstep = 0.005\n\
         [[body]]\nname = \"b\"\nrepeat = 2\nmass = 1.0\ncenter = [0.05, 0, 0]\n\
         hinge = { type = \"revolute\", axis = [0, 1, 0], next = [0.1, 0, 0] }\n",
    );
    let answer = bench.call(&["sweep", "chain.toml", "--run", "--over", "b.repeat=2,3,4,5", "--json"]).code(0);
    assert_eq!(answer.json()["side_by_side"], 1);
}

#[test]
fn what_cannot_be_swept_is_a_wrong_call() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let wrong = |over: &str| bench.call(&["sweep", "scale.toml", "--over", over]).code(2).err;
    assert!(wrong("pan.mas=1:2:3").contains("did you mean `mass`?"));
    assert!(wrong("pan.mass=1:2").contains("from:to:count"));
    assert!(wrong("pan.mass=1:2:9999999999").contains("number of cases"));
    // Some of them may fail.
    let some = bench.call(&["sweep", "scale.toml", "--over", "pan.mass=-1,1"]).code(1);
    assert!(some.out.contains("failed: ") && some.out.contains("1 of 2 cases failed"), "{some:#?}");
    let piped = Answer::of(bench.command(&["sweep", "-", "--over", "pan.mass=1,2"]).write_stdin(SCALE)).code(0);
    assert!(piped.out.contains("2 cases"));
}

/// A sweep asks statics what `statics` asks: of a scene with unknown inputs, the inputs.
#[test]
fn unknown_inputs_are_columns_of_their_addresses() {
    let bench = Bench::new();
    let scenario = shipped("crane_held");
    let over = "gravity=[0,0,-9.81],[0,0,-1.62]";
    let answer = bench.call(&["sweep", &scenario, "--over", over, "--json"]).code(0).json();
    let cases = answer["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 2);
    for (case, gravity) in cases.iter().zip(["gravity=[0,0,-9.81]", "gravity=[0,0,-1.62]"]) {
        let alone = bench.call(&["statics", &scenario, "--set", gravity, "--json"]).code(0).json();
        let unknowns = alone["unknowns"].as_object().expect("unknown inputs");
        assert!(!unknowns.is_empty());
        for (address, value) in unknowns {
            assert_eq!(&case["result"][address], value, "{address}");
        }
    }
    bench.call(&["sweep", &scenario, "--over", over, "--out", "table.csv", "--quiet"]).code(0);
    let text = std::fs::read_to_string(bench.path().join("table.csv")).expect("a table");
    let alone = bench.call(&["statics", &scenario, "--json"]).code(0).json();
    for address in alone["unknowns"].as_object().expect("unknown inputs").keys() {
        assert!(text.lines().next().is_some_and(|head| head.contains(address.as_str())), "{text}");
    }
}

/// A range with units in one pair of quotes, in quotes of its own, and without: the same cases.
#[test]
fn ranges_may_stand_in_quotes() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let table =
        |over: &str| bench.call(&["sweep", "scale.toml", "--over", over, "--json"]).code(0).json()["cases"].clone();
    let cases = table("pan.mass=1000 g:3 kg:3".replace("3 kg", "3000 g").as_str());
    assert_eq!(cases[1]["values"]["pan.mass"], "2000 g");
    for quoted in ["pan.mass=\"1000 g:3000 g:3\"", "pan.mass='1000 g:3000 g:3'", "pan.mass=\"1000 g, 2000 g, 3000 g\""]
    {
        assert_eq!(table(quoted), cases, "{quoted}");
    }
    // What is wrong with a value is shown at the option that it comes from.
    let wrong = bench.call(&["sweep", "scale.toml", "--over", "pan.mass=\"1 m:2 m:2\""]).code(2).err;
    assert!(wrong.contains("--over pan.mass=1 m") && wrong.contains("it is measured in kg"), "{wrong}");
    let counted =
        bench.call(&["sweep", "scale.toml", "--over", "pan.mass=1:2:999999", "--over", "pan.stiffness=1:9:9"]);
    assert!(counted.code(2).err.contains("asks for more than 1000000 cases"));
    // So it is with `statics --compare`.
    let compared = ["statics", "scale.toml", "--compare", "--json", "--over", "pan.mass=\"1 kg:2 kg:2\""];
    assert_eq!(bench.call(&compared).code(0).json()["runs"].as_array().map(Vec::len), Some(2));
}

/// What a sweep would not heed it refuses.
#[test]
fn nothing_is_varied_in_vain() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    bench.write("path.toml", format!("statics.path = {{ parameter = \"pan.mass\", to = 2 }}\n{SCALE}"));
    let refused = |arguments: &[&str], word: &str| {
        let error = bench.call(&[&["sweep"], arguments].concat()).code(2).err;
        assert!(error.contains(word), "{arguments:?}: {error}");
    };
    refused(&["path.toml", "--over", "pan.mass=1,2"], "does not follow `[statics.path]`");
    refused(&["scale.toml", "--over", "pan.mass=1,2", "--over", "pan.mass=3,4"], "varies `pan.mass` twice");
    let twice = ["scale.toml", "--over", "pan.stiffness=1,2", "--over", "pan.hinge.stiffness=3,4"];
    refused(&twice, "varies `pan.hinge.stiffness` twice");
    refused(&["scale.toml", "--set", "pan.mass=5", "--over", "pan.mass=1,2"], "set and varied at once");
    refused(&["scale.toml", "--over", "simulate.duration=1,2"], "only `--run` simulates");
    refused(&["scale.toml", "--over", "record.rate=1,2"], "only the cases of `--run` have samples");
    refused(&["scale.toml", "--over", "record.ros=true,false", "--run"], "records nothing");
    let given = ["scale.toml", "--set", "simulate.start=given", "--run", "--over", "statics.want=any,stable"];
    refused(&given, "without statics");
    bench.call(&["sweep", "scale.toml", "--run", "--over", "simulate.duration=0.1,0.2"]).code(0);
    // A table that cannot be written is told before the work.
    refused(&["scale.toml", "--over", "pan.mass=1,2", "--out", "no/such/folder.csv"], "cannot write");
}

/// Two bodies, the first with a spring in its hinge, and a stiffness of both.
const TWO_HINGES: &str = "[statics]\nwant = \"any\"\n\
    [[body]]\nname = \"a\"\nmass = 1.0\ncenter = [0, 0, -0.5]\ninertia = [0.1, 0.1, 0.1]\n\
    hinge = { type = \"revolute\", axis = [0, 1, 0], stiffness = 10.0, rest = 0.2 }\n\
    [[body]]\nname = \"b\"\nmass = 1.0\ncenter = [0, 0, -0.5]\ninertia = [0.1, 0.1, 0.1]\n\
    hinge = { type = \"revolute\", parent = \"a\", at = [0, 0, -1], axis = [0, 1, 0], stiffness = 10.0 }\n";

/// A row would show a value that another address has overwritten: both addresses are named, and what they share.
#[test]
fn addresses_that_share_an_entry_are_not_varied_at_once() {
    let bench = Bench::new();
    bench.write("two.toml", TWO_HINGES);
    bench.write("matrix.csv", "a.stiffness,hinge.stiffness\n1,0.5\n0.5,1\n");
    let refused = |arguments: &[&str], words: &[&str]| {
        let error = bench.call(&[&["sweep", "two.toml"], arguments].concat()).code(2).err;
        assert!(words.iter().all(|word| error.contains(word)), "{arguments:?}: {error}");
    };
    let hinges = ["`--over a.stiffness` and `--over hinge.stiffness` both vary `a.stiffness`"];
    refused(&["--over", "a.stiffness=1,20", "--over", "hinge.stiffness=30,40"], &hinges);
    let gravity = ["`--over gravity[2]` and `--over gravity` both vary `gravity[2]`"];
    refused(&["--over", "gravity[2]=-1,-2", "--over", "gravity=[0,0,-3],[0,0,-4]"], &gravity);
    refused(
        &["--over", "gravity[02]=-1,-2", "--over", "gravity[2]=-3"],
        &["`--over gravity[02]`", "both vary `gravity[2]`"],
    );
    let mixed = ["--over", "hinge.damping=1,2", "--vary", "b.damping=uniform(1, 2)", "--cases", "2"];
    refused(&mixed, &["`--over hinge.damping` and `--vary b.damping` both vary `b.damping`"]);
    let drawn = ["--vary", "a.stiffness=uniform(1, 2)", "--vary", "hinge.stiffness=uniform(1, 2)", "--cases", "2"];
    refused(&[&drawn[..], &["--correlate", "matrix.csv"]].concat(), &["both vary `a.stiffness`"]);
    // Entries of their own are varied at once.
    bench.call(&["sweep", "two.toml", "--over", "a.stiffness=1,20", "--over", "b.stiffness=30,40"]).code(0);
    bench.call(&["sweep", "two.toml", "--over", "gravity[0]=0,1", "--over", "gravity[2]=-3,-4"]).code(0);
}

/// A `--set` of nothing but what is varied would be lost; of more than that the rest stands.
#[test]
fn what_is_set_is_not_lost_to_what_is_varied() {
    let bench = Bench::new();
    bench.write("two.toml", TWO_HINGES);
    let call = |over: &[&str], set: &str| bench.call(&[&["sweep", "two.toml", "--json", "--set", set], over].concat());
    let lost = call(&["--over", "hinge.stiffness=5,6"], "a.stiffness=500").code(2).err;
    let words =
        "`--set a.stiffness` would be lost: all that it sets, `a.stiffness`, is varied by `--over hinge.stiffness`";
    assert!(lost.contains(words), "{lost}");
    let both = ["--over", "a.stiffness=5,6", "--over", "b.stiffness=5,6"];
    let lost = call(&both, "hinge.stiffness=500").code(2).err;
    assert!(lost.contains("varied by `--over a.stiffness` and `--over b.stiffness`"), "{lost}");
    let cases = call(&["--over", "a.stiffness=5,6"], "hinge.stiffness=500").code(0).json()["cases"].clone();
    let alone = call(&["--over", "a.stiffness=5,6"], "b.stiffness=500").code(0).json()["cases"].clone();
    for (one, other) in cases.as_array().expect("cases").iter().zip(alone.as_array().expect("cases")) {
        assert_eq!((&one["values"], &one["result"]["b.angle"]), (&other["values"], &other["result"]["b.angle"]));
        assert!(one["result"]["b.angle"].is_number(), "{one}");
    }
}

/// Columns are named as they are written, and words in them stand without quotes.
#[test]
fn a_table_names_its_columns_as_written_and_has_words_without_quotes() {
    let bench = Bench::new();
    let boom = shipped("beams/crane_boom");
    for address in ["boom.young", "boom.material.young"] {
        bench.call(&["sweep", &boom, "--over", &format!("{address}=200e9"), "--out", "boom.csv", "--quiet"]).code(0);
        let table = std::fs::read_to_string(bench.path().join("boom.csv")).expect("a table");
        assert!(table.starts_with(&format!("case,{address},ok,")), "{address}: {table}");
    }
    bench.write("scale.toml", SCALE);
    let over = ["--over", "simulate.integrator=\"rk4\",dopri5", "--run", "--set", "simulate.duration=0.01"];
    let answer = bench.call(&[&["sweep", "scale.toml", "--out", "words.csv"], &over[..]].concat()).code(0);
    let table = std::fs::read_to_string(bench.path().join("words.csv")).expect("a table");
    let words: Vec<String> = table.lines().map(|line| line.split(',').nth(1).expect("a cell").to_owned()).collect();
    assert_eq!(words, ["simulate.integrator", "rk4", "dopri5"]);
    assert!(answer.out.contains("simulate.integrator = rk4 "), "{}", answer.out);
}

/// An output that is called like the column that its number has anyway is that column; called like another one it is refused before any
/// case, at its place. In runs the names of outputs have ends of their own.
#[test]
fn outputs_may_be_called_like_the_column_that_they_are() {
    let scene = format!(
        "{SCALE}[[body]]\nname = \"ball\"\nmass = 1.0\ninertia = [1, 1, 1]\n\
         hinge = {{ type = \"spherical\", parent = \"pan\", stiffness = 5.0 }}\n\
         [[motor]]\nname = \"push\"\ntype = \"input\"\nhinge = \"pan\"\nforce = 3.0\n\
         [[force]]\nname = \"stay\"\ntype = \"rope\"\nthrough = [\"pan\", {{ body = \"ground\", at = [0, 0, 2] }}]\nstiffness = 50.0\nlength = 1.5\n\
         [[body]]\nname = \"slide\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", parent = \"pan\", axis = [1, 0, 0] }}\n\
         [[drive]]\nname = \"hold\"\nhinge = \"slide\"\ntype = \"hold\"\n"
    );
    let output =
        |name: &str, kind: &str, of: &str| format!("[[output]]\nname = \"{name}\"\ntype = \"{kind}\"\nof = \"{of}\"\n");
    let bench = Bench::new();
    let sweep = |text: &str, more: &[&str]| {
        bench.write("scale.toml", text);
        bench.call(&[&["sweep", "scale.toml", "--over", "pan.mass=1,2"], more].concat())
    };
    let plain = sweep(&scene, &["--json"]).code(0).json();
    let columns: Vec<String> = plain["cases"][0]["result"].as_object().expect("columns").keys().cloned().collect();
    for (name, kind, of) in [
        ("pan.distance", "coordinate", "pan"),
        ("pan.distance", "coordinate", "pan.distance"),
        ("motors.push", "force", "push"),
        ("pulls.stay", "force", "stay"),
        ("drives.hold", "force", "hold"),
    ] {
        assert!(columns.iter().any(|column| column == name), "{name}: {columns:?}");
        // Beside other outputs, whose places among the numbers stay.
        let text = format!(
            "{scene}{}{}{}",
            output("before", "orientation", "ball"),
            output(name, kind, of),
            output("after", "rate", "pan")
        );
        let told = sweep(&text, &["--json"]).code(0).json();
        for case in 0..2 {
            let row = &told["cases"][case]["result"];
            assert_eq!(row[name], plain["cases"][case]["result"][name], "{name}");
            assert!(row["before[0]"] == 1.0 && row["after"] == 0.0, "{row}");
        }
        sweep(&text, &["--out", "t.csv", "--quiet"]).code(0);
        let table = std::fs::read_to_string(bench.path().join("t.csv")).expect("the table");
        let head: Vec<&str> = table.lines().next().expect("a head").split(',').collect();
        assert_eq!(head.iter().filter(|column| **column == name).count(), 1, "{head:?}");
        assert!(table.lines().all(|line| line.split(',').count() == head.len()), "{table}");
        let folder = format!("{name} {of}");
        sweep(&text, &["--out", &folder, "--quiet"]).code(0);
        #[cfg(feature = "parquet")]
        for (case, row) in super::datasets::rows(&bench.path().join(&folder)).iter().enumerate() {
            assert_eq!(row[name], told["cases"][case]["result"][name], "{name}");
        }
    }
    let others = ["case", "ok", "error", "wall_seconds", "pan.mass", "stability", "iterations", "frequencies_hz[0]"];
    for name in others.into_iter().chain(columns.iter().map(String::as_str)) {
        let text = format!("{scene}{}", output(name, "energy", "potential"));
        let line = text.lines().position(|line| *line == format!("name = \"{name}\"")).expect("a line") + 1;
        for out in ["t.csv", "other"] {
            let refused = sweep(&text, &["--out", out]).code(2);
            for part in [&format!("scale.toml:{line}:"), &format!("cannot be called `{name}`"), "another name"] {
                assert!(refused.err.contains(part), "{part}: {}", refused.err);
            }
            assert!(refused.err.contains("scale.toml: 1 error"), "{}", refused.err);
        }
        if columns.iter().any(|column| column == name) {
            let ran = sweep(&format!("[simulate]\nduration = 0.01\nstart = \"given\"\n{text}"), &["--run", "--json"])
                .code(0)
                .json();
            assert!(ran["cases"][0]["result"][format!("{name}.end")].is_number(), "{ran}");
        }
    }
    assert!(!bench.path().join("other").exists());
}

/// Columns of elements that would have one name: the file, the line and both elements are named.
#[test]
fn elements_whose_columns_would_have_one_name_are_named() {
    let bench = Bench::new();
    let body = |name: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 1.0\ncenter = [0, 0, -0.5]\ninertia = [0.1, 0.1, 0.1]\n\
                 hinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n"
        )
    };
    let drive = "[[drive]]\nname = \"angle\"\ntype = \"rate\"\nhinge = \"b\"\nrate = 1.0\n";
    let motor = "[[motor]]\nname = \"angle\"\ntype = \"constant\"\nhinge = \"b\"\nforce = 1.0\n";
    for (kind, list, element) in [("drive", "drives", drive), ("motor", "motors", motor)] {
        let text = [body("b"), body(list), element.to_owned()].concat();
        let line = text.lines().position(|line| line == "name = \"angle\"").expect("a line") + 1;
        bench.write("scene.toml", &text);
        let error = bench.call(&["sweep", "scene.toml", "--over", "b.mass=1,2"]).code(2).err;
        for part in [
            &format!("scene.toml:{line}:"),
            &format!("would be called `{list}.angle`"),
            &format!("the {kind} `angle`"),
            &format!("the coordinate `angle` of the body `{list}`"),
            "give one of them another name",
        ] {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}

/// A list has units on all of its numbers or on none: one unit at its end reads as that of all.
#[test]
fn units_stand_on_every_value_of_a_list() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let over = |values: &str| bench.call(&["sweep", "scale.toml", "--over", &format!("pan.mass={values}"), "--json"]);
    for (values, said) in [
        ("1,2,3 g", "`1` has no unit, and `3 g` has one: write the unit on each value"),
        ("1 g,2,3 g", "`2` has no unit, and `3 g` has one"),
        ("3,5 kg", "in a number with decimals the point is `.`"),
    ] {
        let error = over(values).code(2).err;
        assert!(error.contains(said), "{values}: {error}");
    }
    let cases = over("1000 g,2 kg").code(0).json()["cases"].clone();
    let masses: Vec<_> = (0..2).map(|case| cases[case]["values"]["pan.mass"].clone()).collect();
    assert!(masses.iter().all(|mass| !mass.is_null()), "{cases}");
    over("1,2,3").code(0);
}

/// Least, largest and mean square of outputs are those of the samples: how many these are does change them.
#[test]
fn runs_may_differ_in_their_samples() {
    let bench = Bench::new();
    let output = "[[output]]\nname = \"z\"\ntype = \"coordinate\"\nof = \"pan\"\n";
    let start = "[simulate]\nduration = 1.0\nstart = \"given\"\n";
    bench.write("scale.toml", format!("{start}{SCALE}{output}"));
    let swept = bench.call(&["sweep", "scale.toml", "--run", "--over", "record.rate=3,50", "--json"]).code(0).json();
    let rms = |case: usize| swept["cases"][case]["result"]["z.rms"].as_f64().expect("a number");
    for (case, rate) in ["record.rate=3", "record.rate=50"].into_iter().enumerate() {
        let alone = ["sweep", "scale.toml", "--run", "--over", "pan.mass=1", "--set", rate, "--json"];
        let alone = bench.call(&alone).code(0).json();
        assert_eq!(alone["cases"][0]["result"]["z.rms"].as_f64(), Some(rms(case)), "{rate}");
    }
    assert!((rms(0) / rms(1) - 1.0).abs() > 1e-3, "{swept}");
}

/// What is missing of a call, and what a number may be, is said in one sentence.
#[test]
fn what_a_sweep_lacks_is_said() {
    let bench = Bench::new();
    bench.write("scale.toml", SCALE);
    let refused = |rest: &[&str]| bench.call(&[&["sweep", "scale.toml"][..], rest].concat()).code(2).err;
    for rest in [&["--cases", "3"][..], &[]] {
        let said = refused(rest);
        assert!(said.contains("nothing is varied: give `--over PATH=VALUES` or `--vary PATH=DISTRIBUTION`"), "{said}");
    }
    let over = ["--over", "pan.mass=1,2"];
    for (option, value) in [("--cases", "3"), ("--seed", "1"), ("--sample", "sobol")] {
        let said = refused(&[&over[..], &[option, value]].concat());
        assert!(said.contains(&format!("`{option}` is for what is drawn")) && said.contains("give `--vary"), "{said}");
    }
    let vary = ["--vary", "pan.mass=uniform(1,2)"];
    for cases in ["-3", "0", "2000000000", "some"] {
        let said = refused(&[&vary[..], &["--cases", cases]].concat());
        assert!(said.contains(cases) && said.contains("a whole number from 1 to 1000000000"), "{said}");
    }
    let said = refused(&[&vary[..], &["--cases", "2", "--seed", "-1"]].concat());
    assert!(said.contains("'-1'") && said.contains("a whole number from 0 to 18446744073709551615"), "{said}");
}
