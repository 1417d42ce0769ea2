//! The command line: the only place that prints.

mod baselines;
mod beams;
mod bench;
mod check;
mod compare;
mod completions;
mod conditioning;
mod convert;
mod examples;
mod export;
mod fmu;
mod frame;
mod info;
mod inputs;
mod inspect;
mod json;
mod linearize;
mod man;
mod modals;
mod new;
mod number;
mod output;
mod palette;
mod path;
mod picture;
mod pixels;
mod plot;
mod poses;
mod precision;
mod recording;
mod recover;
mod report;
mod rest;
mod run;
mod samples;
mod scene;
mod sensitivity;
mod sizes;
mod standing;
mod statics;
mod stopwatch;
mod storm;
mod study;
mod sweep;
mod text;
#[cfg(feature = "picture")]
mod video;
mod view;
mod watch;

use crate::linear::StateSpace;
use crate::model::{Description, Model};
use crate::simulate::{State, Summary};
use crate::statics::Equilibrium;
use clap::{Args, Parser, Subcommand};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// How a command ended, as the shell sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Exit {
    /// Done.
    Done,
    /// The answer is no: no equilibrium, not at rest, diverged.
    No,
    /// The input or the call is wrong.
    Wrong,
    /// Stopped by Ctrl-C after everything was written.
    Interrupted,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::No => 1,
            Exit::Wrong => 2,
            Exit::Interrupted => 130,
        })
    }
}

/// A multibody simulator that starts at rest.
///
/// Reads a scenario (TOML), finds its static equilibrium, says what kind it is, and simulates from there.
///
/// Exit codes: 0 done, 1 the answer is no (no equilibrium, not at rest, diverged), 2 the input or the call is wrong,
/// 130 stopped by Ctrl-C.
#[derive(Debug, Parser)]
#[command(name = "stillpoint", version, arg_required_else_help = true, after_help = examples::PROGRAM)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Significant digits of numbers in reports; JSON and tables have all
    #[arg(long, global = true, value_name = "N", default_value_t = number::USUAL_DIGITS)]
    #[arg(value_parser = clap::value_parser!(u8).range(1..=17))]
    digits: u8,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Find the start, simulate, write the recording
    #[command(after_help = examples::RUN)]
    Run(run::Arguments),
    /// Find the equilibrium: pose, residual, stability, natural frequencies, reactions
    #[command(after_help = examples::STATICS)]
    Statics(statics::Arguments),
    /// Prove that a run from the equilibrium stays there; exit code 1 when it leaves
    #[command(after_help = examples::REST)]
    Rest(rest::Arguments),
    /// Measure what every integrator costs for the error it makes: table, CSV and plot
    #[command(after_help = examples::PRECISION)]
    Precision(precision::Arguments),
    /// Ask for the equilibrium, or a run, for many values of some numbers: one row per case
    #[command(after_help = examples::SWEEP)]
    Sweep(sweep::Arguments),
    /// Say what a dataset of `sweep` says: quantiles, correlations, what matters most; or fit a scenario to measurements
    #[command(after_help = examples::STUDY)]
    Study(study::Arguments),
    /// Say what the model is, and its accelerations at the given state; runs nothing
    #[command(after_help = examples::INSPECT)]
    Inspect(inspect::Arguments),
    /// Write the linear equations about the equilibrium: A, B, C, D, eigenvalues, frequency response
    #[command(after_help = examples::LINEARIZE)]
    Linearize(linearize::Arguments),
    /// Measure what this scene's own routines cost: acceleration, Jacobian, tangent, statics, memory
    #[command(after_help = examples::BENCH)]
    Bench(bench::Arguments),
    /// Show a recording in the Rerun viewer, or save it as glTF
    #[command(after_help = examples::VIEW)]
    View(view::Arguments),
    /// Draw one instant of a recording (SVG, PNG, PDF)
    #[command(after_help = examples::PICTURE)]
    Picture(picture::Arguments),
    /// Make a film of a recording (GIF, MP4)
    #[cfg(feature = "picture")]
    #[command(after_help = examples::VIDEO)]
    Video(video::Arguments),
    /// Write one page (HTML) that opens anywhere: picture that moves, verdict, modes, reactions, curves, data
    #[command(after_help = examples::REPORT)]
    Report(report::Arguments),
    /// Find the equilibrium again whenever the file is saved, and say what changed; Ctrl-C ends it
    #[command(after_help = examples::WATCH)]
    Watch(watch::Arguments),
    /// Say what is in a recording: samples, channels and units, statics, whether it is whole
    #[command(after_help = examples::INFO)]
    Info(info::Arguments),
    /// Make a whole recording of one that was cut or damaged
    #[command(after_help = examples::RECOVER)]
    Recover(recover::Arguments),
    /// Write a recording's numbers as CSV or Parquet
    #[command(after_help = examples::EXPORT)]
    Export(export::Arguments),
    /// Write an FMU for co-simulation (FMI 3.0): inputs, outputs and parameters by name, initialized at the equilibrium
    #[command(after_help = examples::FMU)]
    Fmu(fmu::Arguments),
    /// Plot numbers of recordings over time, or over each other (SVG, PNG, PDF)
    #[command(after_help = examples::PLOT)]
    Plot(plot::Arguments),
    /// Say how far two recordings are apart; exit code 1 when further than the tolerance
    #[command(after_help = examples::COMPARE)]
    Compare(compare::Arguments),
    /// Turn a model of another program (URDF, MJCF) into a scenario; what is not taken over is listed line by line
    #[command(after_help = examples::CONVERT)]
    Convert(convert::Arguments),
    /// Validate scenario files
    #[command(after_help = examples::CHECK)]
    Check(check::Arguments),
    /// Write a commented scenario to start from
    #[command(after_help = examples::NEW)]
    New(new::Arguments),
    /// Print the JSON Schema of the scenario format, for editors
    #[command(after_help = examples::SCHEMA)]
    Schema {
        /// Print the format's reference for people instead, in Markdown
        #[arg(long)]
        markdown: bool,
    },
    /// Print the completions for a shell
    #[command(after_help = examples::COMPLETIONS)]
    Completions(completions::Arguments),
    /// Print the manual page, or write those of all commands
    #[command(after_help = examples::MAN)]
    Man(man::Arguments),
}

/// Options of every command that reads a scenario.
#[derive(Debug, Args)]
struct Common {
    /// The scenario file, or that of a model (URDF, MJCF) alone; `-` reads standard input
    scenario: PathBuf,
    /// Change a value of the file, as `simulate.duration=2` or `upper.stiffness=5`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// What a thread has asked of the allocator since it started.
#[derive(Debug, Clone, Copy)]
pub struct Memory {
    /// Requests for memory.
    pub allocations: usize,
    /// Bytes that it has allocated, less those that it has freed, whoever allocated them: may wrap around.
    pub bytes: usize,
}

/// What `statics --json` prints of an equilibrium that took so long (s).
pub fn statics_answer(model: &Arc<Model>, found: &Equilibrium, wall_seconds: f64) -> serde_json::Value {
    let mut answer = json::statics(model, found, wall_seconds);
    if let Ok(asked) = crate::statics::outputs(model, found) {
        answer["outputs"] = json::outputs(model, &asked);
    }
    answer
}

/// What `run --json` prints of a run of this scenario that is not on disk. Of one that starts at an equilibrium `start` is null here: it is
/// the [`statics_answer`] of that.
pub fn run_answer(scenario: &str, starts_as_given: bool, summary: &Summary) -> serde_json::Value {
    let start = if starts_as_given { run::GIVEN.into() } else { serde_json::Value::Null };
    json::run(scenario, "", start, summary)
}

/// What `study --fit --json` prints of a fit, without the names of its files.
pub fn fit_answer(fit: &crate::study::fit::Fit) -> serde_json::Value {
    study::fit_json(fit)
}

/// The equations about an equilibrium, as `linearize` has them: from inputs by their addresses (`None`: all motors of type `input`) to
/// outputs by their names (`None`: all).
///
/// # Errors
/// An input or output that is not known, or a scene that cannot be linearized.
pub fn linearize_about(
    description: &Description,
    model: &Arc<Model>,
    found: &Equilibrium,
    inputs: Option<Vec<String>>,
    outputs: Option<Vec<String>>,
) -> anyhow::Result<StateSpace> {
    linearize::about_equilibrium(description, model, found, inputs.as_deref(), outputs.as_deref())
}

/// These equations about a state as it stands, as `linearize --start` has them; `time` in s.
///
/// # Errors
/// As [`linearize_about`].
pub fn linearize_at(
    description: &Description,
    model: &Arc<Model>,
    (time, state): (f64, State),
    inputs: Option<Vec<String>>,
    outputs: Option<Vec<String>>,
) -> anyhow::Result<StateSpace> {
    linearize::about_state(description, model, (time, state), inputs.as_deref(), outputs.as_deref())
}

/// Runs the program with the arguments it was called with; `memory` tells what it has asked of its allocator, if that is
/// counted.
pub fn main(memory: Option<fn() -> Memory>) -> ExitCode {
    main_with(std::env::args_os(), memory)
}

/// The program with these arguments; the first is what it was called as.
pub fn main_with(arguments: impl IntoIterator<Item = OsString>, memory: Option<fn() -> Memory>) -> ExitCode {
    output::quiet_foreign_panics();
    if let Err(error) = output::survive_file_limits() {
        output::warning(&format!("{error:#}"));
    }
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are answers, everything else is a wrong call; a closed pipe is nobody's fault.
            let _ = error.print();
            return if error.use_stderr() { Exit::Wrong.into() } else { Exit::Done.into() };
        }
    };
    number::show_digits(cli.digits);
    let result = match cli.command {
        Command::Run(arguments) => run::main(&arguments),
        Command::Statics(arguments) => statics::main(&arguments),
        Command::Rest(arguments) => rest::main(&arguments),
        Command::Precision(arguments) => precision::main(&arguments),
        Command::Sweep(arguments) => sweep::main(&arguments),
        Command::Study(arguments) => study::main(&arguments),
        Command::Inspect(arguments) => inspect::main(&arguments),
        Command::Linearize(arguments) => linearize::main(&arguments),
        Command::Bench(arguments) => bench::main(&arguments, memory),
        Command::View(arguments) => view::main(&arguments),
        Command::Picture(arguments) => picture::main(&arguments),
        #[cfg(feature = "picture")]
        Command::Video(arguments) => video::main(&arguments),
        Command::Report(arguments) => report::main(&arguments),
        Command::Watch(arguments) => watch::main(&arguments),
        Command::Info(arguments) => info::main(&arguments),
        Command::Recover(arguments) => recover::main(&arguments),
        Command::Export(arguments) => export::main(&arguments),
        Command::Fmu(arguments) => fmu::main(&arguments),
        Command::Plot(arguments) => plot::main(&arguments),
        Command::Compare(arguments) => compare::main(&arguments),
        Command::New(arguments) => new::main(&arguments),
        Command::Completions(arguments) => completions::main(&arguments),
        Command::Man(arguments) => man::main(&arguments),
        Command::Convert(arguments) => convert::main(&arguments),
        Command::Check(arguments) => check::main(&arguments),
        Command::Schema { markdown: false } => {
            output::print(&format!("{:#}", crate::scenario::schema())).map(|()| Exit::Done)
        }
        Command::Schema { markdown: true } => {
            output::print(crate::scenario::reference().trim_end()).map(|()| Exit::Done)
        }
    };
    match result {
        // The work is done; that nobody could read of it is an error all the same.
        Ok(Exit::Done) if output::was_lost() => Exit::Wrong.into(),
        Ok(exit) => exit.into(),
        Err(error) => {
            output::error(&error);
            Exit::Wrong.into()
        }
    }
}
