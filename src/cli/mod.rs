//! The command line: the only place that prints.

mod bench;
mod check;
mod compare;
mod convert;
mod inspect;
mod json;
mod output;
mod palette;
mod path;
mod poses;
mod precision;
mod rest;
mod run;
mod scene;
mod statics;
mod stopwatch;
mod text;
mod view;

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

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
#[command(name = "stillpoint", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Find the start, simulate, write the recording
    ///
    /// Example: stillpoint run scenarios/hanging_chain.toml --out chain.mcap --set simulate.duration=2
    Run(run::Arguments),
    /// Find the equilibrium: pose, residual, stability, natural frequencies, reactions
    ///
    /// Example: stillpoint statics scenarios/calder_mobile.toml --json
    Statics(statics::Arguments),
    /// Prove that a run from the equilibrium stays there; exit code 1 when it leaves
    ///
    /// Example: stillpoint rest scenarios/machine_on_mounts.toml
    Rest(rest::Arguments),
    /// Measure what every integrator costs for the error it makes: table, CSV and plot
    ///
    /// Example: stillpoint precision scenarios/double_pendulum.toml --set simulate.duration=3 --error 1e-6
    Precision(precision::Arguments),
    /// Say what the model is, and its accelerations at the given state; runs nothing
    ///
    /// Example: stillpoint inspect scenarios/pendulum.toml --set rod.position=0.5
    Inspect(inspect::Arguments),
    /// Measure what this scene's own routines cost: acceleration, Jacobian, tangent, statics, memory
    ///
    /// Example: stillpoint bench scenarios/hanging_chain.toml --json
    Bench(bench::Arguments),
    /// Show a recording in the Rerun viewer
    ///
    /// Example: stillpoint view hanging_chain.mcap --save hanging_chain.rrd
    View(view::Arguments),
    /// Turn a model of another program (URDF) into a scenario; what is not taken over is listed line by line
    ///
    /// Example: stillpoint convert robot.urdf -o robot.toml
    Convert(convert::Arguments),
    /// Validate scenario files
    ///
    /// Example: stillpoint check scenarios/*.toml
    Check(check::Arguments),
    /// Print the JSON Schema of the scenario format, for editors
    ///
    /// Example: stillpoint schema > scenario.schema.json
    Schema {
        /// Print the format's reference for people instead, in Markdown
        #[arg(long)]
        markdown: bool,
    },
}

/// Options of every command that reads a scenario.
#[derive(Debug, Args)]
struct Common {
    /// The scenario file; `-` reads standard input
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

/// What the program has asked of its allocator since it started.
#[derive(Debug, Clone, Copy)]
pub struct Memory {
    /// Requests for memory.
    pub allocations: usize,
    /// Bytes in use.
    pub bytes: usize,
}

/// Runs the program with the arguments it was called with; `memory` tells what it has asked of its allocator.
pub fn main(memory: fn() -> Memory) -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are answers, everything else is a wrong call; a closed pipe is nobody's fault.
            let _ = error.print();
            return if error.use_stderr() { Exit::Wrong.into() } else { Exit::Done.into() };
        }
    };
    let result = match cli.command {
        Command::Run(arguments) => run::main(&arguments),
        Command::Statics(arguments) => statics::main(&arguments),
        Command::Rest(arguments) => rest::main(&arguments),
        Command::Precision(arguments) => precision::main(&arguments),
        Command::Inspect(arguments) => inspect::main(&arguments),
        Command::Bench(arguments) => bench::main(&arguments, memory),
        Command::View(arguments) => view::main(&arguments),
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
        Ok(exit) => exit.into(),
        Err(error) => {
            output::error(&error);
            Exit::Wrong.into()
        }
    }
}
