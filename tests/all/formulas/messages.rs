//! What is said of formulas that are wrong: exact messages, at their places.

use stillpoint::formula::{DEEPEST_NESTING, Formula, MOST_OPERATIONS};
use stillpoint::scenario;

/// What is said about the formula of a drive.
fn said(formula: &str) -> String {
    let text = format!(
        "[[body]]\nname = \"arm\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [1.0, 0.0, 0.0] }}\n\
         [[drive]]\nname = \"turn\"\nhinge = \"arm\"\ntype = \"expression\"\nexpression = {formula}\n"
    );
    match scenario::parse("scene.toml", &text, &[]) {
        Ok(_) => "nothing".to_owned(),
        Err(diagnostics) => diagnostics.to_string(),
    }
}

#[test]
fn an_unknown_name() {
    insta::assert_snapshot!(said(r#""0.1*sin(2*pi*tt)""#), @r#"
    error: drive `turn`: unknown name `tt`
     --> scene.toml:9:28
      |
    9 | expression = "0.1*sin(2*pi*tt)"
      |                            ^^
      |
      = help: Known here: `t`, the constants `pi`, `tau`, `e`, and the functions `abs`, `min`, `max`, `if`, `sin`, `cos`, `tan`, `asin`, `acos`, `atan`, `atan2`, `sinh`, `cosh`, `tanh`, `asinh`, `acosh`, `atanh`, `exp`, `ln`, `log`, `log2`, `log10`, `sqrt`, `cbrt`, `pow`, `hypot`, `sign`, `signum`, `floor`, `ceil`, `round`, `trunc`, `fract`, `radians`, `degrees`

    scene.toml: 1 error
    "#);
}

#[test]
fn a_name_behind_an_escape() {
    insta::assert_snapshot!(said(r#""\u0074 + w""#), @r#"
    error: drive `turn`: unknown name `w`
     --> scene.toml:9:24
      |
    9 | expression = "\u0074 + w"
      |                        ^
      |
      = help: Known here: `t`, the constants `pi`, `tau`, `e`, and the functions `abs`, `min`, `max`, `if`, `sin`, `cos`, `tan`, `asin`, `acos`, `atan`, `atan2`, `sinh`, `cosh`, `tanh`, `asinh`, `acosh`, `atanh`, `exp`, `ln`, `log`, `log2`, `log10`, `sqrt`, `cbrt`, `pow`, `hypot`, `sign`, `signum`, `floor`, `ceil`, `round`, `trunc`, `fract`, `radians`, `degrees`

    scene.toml: 1 error
    "#);
}

#[test]
fn a_place_in_a_text_of_several_lines() {
    insta::assert_snapshot!(said("'''\n0.1*t +\n  sinn(t)'''"), @r#"
    error: drive `turn`: unknown function `sinn`
      --> scene.toml:11:3
       |
    11 |   sinn(t)'''
       |   ^^^^
       |
       = help: did you mean `sin`? Known are the constants `pi`, `tau`, `e`, and the functions `abs`, `min`, `max`, `if`, `sin`, `cos`, `tan`, `asin`, `acos`, `atan`, `atan2`, `sinh`, `cosh`, `tanh`, `asinh`, `acosh`, `atanh`, `exp`, `ln`, `log`, `log2`, `log10`, `sqrt`, `cbrt`, `pow`, `hypot`, `sign`, `signum`, `floor`, `ceil`, `round`, `trunc`, `fract`, `radians`, `degrees`

    scene.toml: 1 error
    "#);
}

/// Message, the part that it points at, and help.
#[test]
fn every_message() {
    let texts = [
        "",
        " ",
        "sin(",
        "sin(t",
        "(t",
        "t)",
        "t t",
        "2t",
        "2(t)",
        "t(2)",
        "1e",
        "1..2",
        ".",
        "1e999",
        "sin",
        "sin t",
        "sin()",
        "sin(t, t)",
        "min(t)",
        "if(t, 1)",
        "log(1, 2, 3)",
        "t +",
        "* t",
        "t ** ",
        "t, t",
        "t = 1",
        "t && 1",
        "!t",
        "t ? 1",
        "[t]",
        "t $ 2",
        "{t",
        "{w}",
        "else",
        "1 if t",
        "t and",
        "1 + not t",
        "foo(t)",
        "sine(t)",
        "()",
    ];
    let shown: Vec<String> = texts
        .iter()
        .map(|text| match Formula::parse(text, &["t"]) {
            Ok(_) => format!("{text:?}: fine"),
            Err(error) => {
                let help = error.help.as_deref().and_then(|help| help.split("Known").next()).unwrap_or_default();
                let help = if help.is_empty() { String::new() } else { format!(" ({})", help.trim_end()) };
                format!("{text:?} at {:?}: {}{help}", &text[error.span.clone()], error.message)
            }
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"), @r#"
    "" at "": this formula is empty
    " " at " ": this formula is empty
    "sin(" at "": the formula ends where a number, a name or a bracket should follow
    "sin(t" at "(": this bracket is never closed
    "(t" at "(": this bracket is never closed
    "t)" at ")": this bracket was never opened
    "t t" at "t": an operator is missing before `t` (a product is written with `*`)
    "2t" at "2t": `2t` is no number (a product is written with `*`: `2*t`)
    "2(t)" at "(": an operator is missing before `(` (a product is written with `*`)
    "t(2)" at "(": an operator is missing before `(` (a product is written with `*`)
    "1e" at "1e": `1e` is no number (a product is written with `*`: `1*e`)
    "1..2" at "1..": `1..` is no number
    "." at ".": a number needs digits
    "1e999" at "1e999": `1e999` is not a finite number
    "sin" at "sin": the function `sin` has no arguments here (write them in brackets: `sin(…)`)
    "sin t" at "sin": the function `sin` has no arguments here (write them in brackets: `sin(…)`)
    "sin()" at "sin()": `sin` takes one argument, here are 0
    "sin(t, t)" at "sin(t, t)": `sin` takes one argument, here are 2
    "min(t)" at "min(t)": `min` takes two or more arguments, here are 1
    "if(t, 1)" at "if(t, 1)": `if` takes a condition and two values, here are 2
    "log(1, 2, 3)" at "log(1, 2, 3)": `log` takes a number and perhaps a base, here are 3
    "t +" at "": the formula ends where a number, a name or a bracket should follow
    "* t" at "*": `*` stands where a number, a name or a bracket should
    "t ** " at "": the formula ends where a number, a name or a bracket should follow
    "t, t" at ",": a comma stands only between the arguments of a function
    "t = 1" at "=": `=` is no operator (a comparison is written `==`)
    "t && 1" at "&&": `&&` is no operator (write `and`)
    "!t" at "!": `!` is no operator (write `not`, or `!=` for a comparison)
    "t ? 1" at "?": `?` is no operator (a choice is written `if(condition, a, b)`)
    "[t]" at "[": `[` is no operator (brackets are round: `(…)`)
    "t $ 2" at "$": `$` means nothing in a formula
    "{t" at "{": this brace is never closed
    "{w}" at "{w}": unknown name `w`
    "else" at "else": `else` stands where a number, a name or a bracket should
    "1 if t" at "": the formula ends where `else` should follow (a choice is written `a if c else b` or `if(c, a, b)`)
    "t and" at "": the formula ends where a number, a name or a bracket should follow
    "1 + not t" at "not": `not` stands where a number, a name or a bracket should
    "foo(t)" at "foo": unknown function `foo`
    "sine(t)" at "sine": unknown function `sine` (did you mean `sin`?)
    "()" at ")": `)` stands where a number, a name or a bracket should
    "#);
}

#[test]
fn limits_are_named() {
    let message = |text: &str| Formula::parse(text, &["t"]).expect_err("a limit").message;
    let deep = |depth: usize| format!("{}t{}", "(".repeat(depth), ")".repeat(depth));
    assert!(Formula::parse(&deep(DEEPEST_NESTING - 1), &["t"]).is_ok());
    insta::assert_snapshot!(message(&deep(DEEPEST_NESTING)), @"nested too deeply: the most is 64 levels");
    insta::assert_snapshot!(message(&"-".repeat(100)), @"nested too deeply: the most is 64 levels");
    let long = |terms: usize| vec!["t"; terms].join("+");
    assert!(Formula::parse(&long(MOST_OPERATIONS / 2), &["t"]).is_ok());
    insta::assert_snapshot!(message(&long(MOST_OPERATIONS / 2 + 1)), @"too long: the most is 4096 operations");
    insta::assert_snapshot!(message(&"t".repeat(20_000)), @"this formula has 20000 bytes, the most is 16384");
    let involved = format!("{}t{}", "if(t, t, t or t and t < t + t * ".repeat(50), ")".repeat(50));
    insta::assert_snapshot!(message(&involved), @"too involved: the most is 256 intermediate values at one time");
}
