//! Standard output and standard error, colours, progress, Ctrl-C.

use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// A line on standard output. A reader that went away is no error of ours; a full disk is one.
pub(super) fn print(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// A line on standard error.
pub(super) fn note(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// An error with its causes, those left out that the message before has told already.
pub(super) fn error(error: &anyhow::Error) {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string).filter(|cause| !cause.is_empty()) {
        if !text.contains(&cause) {
            text = if text.is_empty() { cause } else { format!("{text}: {cause}") };
        }
    }
    note(&format!("{} {text}", paint("error:", "1;31", errors_in_color())));
}

/// Something a person should know that stops nothing.
pub(super) fn warning(text: &str) {
    note(&format!("{} {text}", paint("warning:", "1;33", errors_in_color())));
}

fn paint(text: &str, code: &str, color: bool) -> String {
    if color { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() }
}

/// Text made bold where standard output shows it.
pub(super) fn bold(text: &str) -> String {
    paint(text, "1", in_color(std::io::stdout().is_terminal()))
}

/// Whether messages are coloured.
pub(super) fn errors_in_color() -> bool {
    in_color(std::io::stderr().is_terminal())
}

/// The customs of the shell: colours on a terminal, unless `NO_COLOR` is set or `CLICOLOR` is 0; with `CLICOLOR_FORCE`
/// also elsewhere.
fn in_color(terminal: bool) -> bool {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    if set("NO_COLOR").is_some() {
        return false;
    }
    if set("CLICOLOR_FORCE").is_some_and(|value| value != "0") {
        return true;
    }
    terminal && set("CLICOLOR").is_none_or(|value| value != "0")
}

/// Set by the first Ctrl-C; a second one ends the program at once.
#[derive(Clone)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// The one of this program: installed by the first call, the same for all later ones.
    pub(super) fn install() -> anyhow::Result<Self> {
        static INSTALLED: OnceLock<Interrupt> = OnceLock::new();
        if let Some(installed) = INSTALLED.get() {
            return Ok(installed.clone());
        }
        let flag = Arc::new(AtomicBool::new(false));
        let set = flag.clone();
        ctrlc::set_handler(move || {
            if set.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
        })?;
        Ok(INSTALLED.get_or_init(|| Self(flag)).clone())
    }

    pub(super) fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Simulated time against the end, on standard error when that is a terminal.
pub(super) struct Progress {
    bar: ProgressBar,
    end: f64,
    started: Instant,
    drawn: Instant,
}

impl Progress {
    pub(super) fn new(end: f64, quiet: bool) -> Self {
        let bar = ProgressBar::new(1000);
        let shown = !quiet && std::io::stderr().is_terminal();
        bar.set_draw_target(if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() });
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {msg}") {
            bar.set_style(style.progress_chars("━╸─"));
        }
        Self { bar, end, started: Instant::now(), drawn: Instant::now() }
    }

    pub(super) fn at(&mut self, time: f64) {
        if self.is_due() {
            let speed = time / self.started.elapsed().as_secs_f64();
            self.bar.set_position((1000.0 * time / self.end) as u64);
            let speed = super::text::times(speed);
            self.bar.set_message(format!("{time:.2} of {} s simulated, {speed} real time", self.end));
        }
    }

    /// The part of the end that is done, without a time.
    pub(super) fn part(&mut self, part: f64) {
        if self.is_due() {
            self.bar.set_position((1000.0 * part) as u64);
            self.bar.set_message(format!("{:.0} % of the runs", 100.0 * part));
        }
    }

    fn is_due(&mut self) -> bool {
        let due = self.drawn.elapsed() >= Duration::from_millis(50);
        if due {
            self.drawn = Instant::now();
        }
        due
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
