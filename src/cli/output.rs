//! Standard output and standard error, colours, progress, Ctrl-C.

use crate::whole_file::{self, WholeFile};
use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::borrow::Cow;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A line on standard output. A reader that went away is no error of ours; a full disk is one.
pub(super) fn print(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{}", visible(text)) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// Whether an error is that of a reader that went away: no error of ours.
pub(super) fn is_closed(error: &anyhow::Error) -> bool {
    let io = |cause: &(dyn std::error::Error + 'static)| {
        let kind = cause.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
        // An error of the tables does not name its source.
        kind.or_else(|| match cause.downcast_ref::<csv::Error>()?.kind() {
            csv::ErrorKind::Io(error) => Some(error.kind()),
            _ => None,
        })
    };
    error.chain().filter_map(io).any(|kind| kind == ErrorKind::BrokenPipe)
}

/// A line on standard output before work whose result goes elsewhere: a disk that is full there is said, and stops
/// nothing. The program ends with an error all the same.
pub(super) fn announce(text: &str) {
    if let Err(error) = print(text)
        && !LOST.swap(true, Ordering::Relaxed)
    {
        warning(&format!("{error:#}; the work goes on"));
    }
}

/// Set where an announcement could not be printed.
static LOST: AtomicBool = AtomicBool::new(false);

/// Whether an announcement could not be printed.
pub(super) fn was_lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// A line on standard error.
pub(super) fn note(text: &str) {
    let write = || {
        let _ = writeln!(std::io::stderr().lock(), "{}", visible(text));
    };
    match WORK.lock().unwrap_or_else(PoisonError::into_inner).as_ref() {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// A text as it may be shown on a terminal. Titles and names come from files, and their control characters would be obeyed
/// there: all but line ends, tabs and colours stand as `\u001b`, and so do the marks that turn the direction of writing.
/// JSON stays the same JSON.
fn visible(text: &str) -> Cow<'_, str> {
    let hidden = |c: char| {
        c.is_control() && !matches!(c, '\n' | '\t') || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    let mut rest = text;
    while let Some(at) = rest.find(hidden) {
        shown += &rest[..at];
        rest = &rest[at..];
        let length = match color(rest) {
            Some(length) => {
                shown += &rest[..length];
                length
            }
            None => {
                let hidden = rest.chars().next().unwrap_or_default();
                shown += &format!("\\u{:04x}", u32::from(hidden));
                hidden.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    shown += rest;
    Cow::Owned(shown)
}

/// The length of the code for a colour or a weight of letters with which a text begins: `ESC [ 1 ; 31 m`.
fn color(text: &str) -> Option<usize> {
    let codes = text.strip_prefix("\u{1b}[")?;
    let length = codes.find(|c: char| !c.is_ascii_digit() && c != ';')?;
    codes[length..].starts_with('m').then_some(length + 3)
}

/// A file that may not grow further (`ulimit -f`) is an error of its writer, with the file's name, and not the end of the
/// program without a word.
#[cfg(unix)]
pub(super) fn survive_file_limits() -> anyhow::Result<()> {
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
    Ok(())
}

/// Other systems have no such signal.
#[cfg(not(unix))]
pub(super) fn survive_file_limits() -> anyhow::Result<()> {
    Ok(())
}

/// Panics of foreign parsers become errors with the file's name: nothing more is said of them.
pub(super) fn quiet_foreign_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !crate::foreign::is_parsing() {
            usual(panic);
        }
    }));
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

/// A verdict on standard output: green if it is the one hoped for, red if it is not.
pub(super) fn verdict(text: &str, fine: bool) -> String {
    paint(text, if fine { "1;32" } else { "1;31" }, in_color(std::io::stdout().is_terminal()))
}

/// A name without the quotes that it has in messages.
pub(super) fn bare(name: &str) -> String {
    name.replace('`', "")
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

/// Writes a file whole or not at all.
///
/// # Errors
/// If it cannot be written, with its name.
pub(super) fn save(path: &Path, content: &[u8]) -> anyhow::Result<()> {
    whole_file::write(path, content).with_context(|| format!("cannot write `{}`", path.display()))
}

/// The file under a table whose rows are all there.
///
/// # Errors
/// If the last rows cannot be written.
pub(super) fn whole(table: csv::Writer<WholeFile>) -> anyhow::Result<WholeFile> {
    Ok(table.into_inner().map_err(csv::IntoInnerError::into_error)?)
}

/// The program's answer when it was told twice to end: that of a shell's.
const INTERRUPTED: i32 = 130;

/// Set by the first Ctrl-C; a second one ends the program at once.
#[derive(Clone)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// The one of this program: installed by the first call, the same for all later ones. To be called after the inputs are
    /// read: until then a signal ends the program at once, whatever pipe it waits for.
    pub(super) fn install() -> anyhow::Result<Self> {
        static INSTALLED: Mutex<Option<Interrupt>> = Mutex::new(None);
        let mut installed = INSTALLED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(installed) = &*installed {
            return Ok(installed.clone());
        }
        let flag = Arc::new(AtomicBool::new(false));
        set_when_interrupted(&flag)?;
        Ok(installed.insert(Self(flag)).clone())
    }

    pub(super) fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Sets the flag on the first signal that asks the program to end; on a second one the program ends at once.
#[cfg(unix)]
fn set_when_interrupted(flag: &Arc<AtomicBool>) -> anyhow::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    for signal in [SIGHUP, SIGINT, SIGTERM] {
        // In this order: the flag is looked at before it is set.
        signal_hook::flag::register_conditional_shutdown(signal, INTERRUPTED, flag.clone())?;
        signal_hook::flag::register(signal, flag.clone())?;
    }
    Ok(())
}

#[cfg(not(unix))]
fn set_when_interrupted(flag: &Arc<AtomicBool>) -> anyhow::Result<()> {
    let flag = flag.clone();
    Ok(ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
    })?)
}

/// What is being worked on, while a line on standard error says so.
static WORK: Mutex<Option<ProgressBar>> = Mutex::new(None);
/// Work that takes no longer is done before anybody asks what goes on.
const PATIENCE: Duration = Duration::from_secs(1);

/// Says on standard error, when that is a terminal, what is being done and for how long, if it takes long: of work whose end nobody knows.
pub(super) struct Work {
    /// Dropped when the work is done.
    done: Option<Sender<()>>,
    teller: Option<JoinHandle<()>>,
}

impl Work {
    pub(super) fn new(what: String, quiet: bool) -> Self {
        if quiet || !std::io::stderr().is_terminal() {
            return Self { done: None, teller: None };
        }
        let (done, waits) = channel();
        let tell = move || {
            if waits.recv_timeout(PATIENCE) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            let bar = ProgressBar::new_spinner().with_message(visible(&what).into_owned()).with_elapsed(PATIENCE);
            if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(100));
            *WORK.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
            let _ = waits.recv();
            *WORK.lock().unwrap_or_else(PoisonError::into_inner) = None;
            bar.finish_and_clear();
        };
        Self { done: Some(done), teller: Some(std::thread::spawn(tell)) }
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        drop(self.done.take());
        // It has nothing to fail at.
        let _ = self.teller.take().map(JoinHandle::join);
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
            let speed = super::number::times(speed);
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

#[cfg(test)]
mod tests {
    use super::visible;

    #[test]
    fn what_a_terminal_would_obey_is_shown() {
        assert_eq!(visible("Körper\n\tplain"), "Körper\n\tplain");
        assert_eq!(visible("\u{1b}[1;31merror:\u{1b}[0m x"), "\u{1b}[1;31merror:\u{1b}[0m x");
        assert_eq!(visible("a\u{1b}]0;title\u{7}b\u{1b}[2Jc\r"), "a\\u001b]0;title\\u0007b\\u001b[2Jc\\u000d");
        assert_eq!(visible("\u{9b}2J\u{7f}\u{202e}"), "\\u009b2J\\u007f\\u202e");
        assert_eq!(visible("\u{1b}[31"), "\\u001b[31");
    }

    #[test]
    fn json_stays_the_same_json() {
        let name = "\u{0}\u{1b}[2J\u{7f}\u{85}\u{9b}\u{202e}ü";
        let text = serde_json::json!({ "name": name }).to_string();
        let shown = visible(&text);
        assert!(!shown.contains(char::is_control), "{shown}");
        let back: serde_json::Value = serde_json::from_str(&shown).expect("JSON");
        assert_eq!(back["name"], name);
    }
}
