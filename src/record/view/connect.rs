//! Finding a viewer that listens before anything is sent to it: the viewer's library would wait for ever.

use super::Sink;
use super::sdk::CrateVersion;
use super::stream::Stream;
use crate::record::RecordError;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tonic::codegen::http::uri::Authority;

/// The viewer's usual port.
const PORT: u16 = 9876;
/// How long a listener may take to answer.
const PROBE: Duration = Duration::from_millis(1000);
/// How long a new viewer may take to listen.
const START: Duration = Duration::from_secs(20);

/// Opens a stream of a recording of that title to the sink.
pub(super) fn open(sink: &Sink, title: &str) -> Result<Stream, RecordError> {
    match sink {
        Sink::Save(path) => {
            Stream::save(path, title).map_err(|error| failed(format!("`{}`: {error}", path.display()), ""))
        }
        Sink::Connect(address) => connect(address, title),
        Sink::Spawn => {
            spawn("rerun", PORT)?;
            stream(&format!("127.0.0.1:{PORT}"), title)
        }
    }
}

fn connect(given: &str, title: &str) -> Result<Stream, RecordError> {
    let place = place(given)?;
    let hint = "start the viewer with `rerun`, or let `--view` start one";
    let addresses = place.to_socket_addrs().map_err(|error| failed(format!("`{place}`: {error}"), hint))?;
    if !addresses.into_iter().take(2).any(|address| listens(&address)) {
        return Err(failed(format!("no viewer listens at `{place}`"), hint));
    }
    stream(place, title)
}

fn stream(place: &str, title: &str) -> Result<Stream, RecordError> {
    // What the listener does with the first messages may be known before the last of them is sent.
    Stream::connect(place, title)
        .map_err(|error| failed(format!("the viewer is lost: `{place}`: {error}"), ADDRESS_HINT))
}

const ADDRESS_HINT: &str = "addresses look like `rerun+http://127.0.0.1:9876/proxy` or `127.0.0.1:9876`";

/// The `host:port` of an address.
fn place(given: &str) -> Result<&str, RecordError> {
    let full = ["rerun+http://", "http://"].iter().find_map(|scheme| given.strip_prefix(scheme));
    let place = match full {
        Some(full) => full.strip_suffix("/proxy").unwrap_or_default(),
        None => given,
    };
    let port = place.parse::<Authority>().ok().and_then(|authority| authority.port_u16());
    if port.is_none() || place.contains('@') {
        return Err(failed(format!("`{given}` is not a viewer's address"), ADDRESS_HINT));
    }
    Ok(place)
}

fn listens(address: &SocketAddr) -> bool {
    TcpStream::connect_timeout(address, PROBE).is_ok()
}

/// Starts a viewer unless one listens already, and waits until it does.
fn spawn(program: &str, port: u16) -> Result<(), RecordError> {
    let address = SocketAddr::from(([127, 0, 0, 1], port));
    if listens(&address) {
        return Ok(());
    }
    let mut viewer = start(program, port).map_err(|error| {
        let version = CrateVersion::LOCAL;
        let hint = format!("install it with `pip install rerun-sdk=={version}`, or save an `.rrd` file instead");
        match error.kind() {
            std::io::ErrorKind::NotFound => failed(format!("the viewer program `{program}` is not installed"), &hint),
            _ => failed(format!("the viewer program `{program}` does not start: {error}"), &hint),
        }
    })?;
    let begin = Instant::now();
    while begin.elapsed() < START {
        if listens(&address) {
            return Ok(());
        }
        if let Ok(Some(status)) = viewer.try_wait()
            && !status.success()
        {
            let hint = "it needs a display and a graphics driver; without them save an `.rrd` file instead";
            return Err(failed(format!("the viewer ended at once ({status})"), hint));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Err(failed(format!("the viewer does not listen after {} s", START.as_secs()), "start it by hand with `rerun`"))
}

/// A viewer that outlives this program and that other machines cannot reach.
fn start(program: &str, port: u16) -> std::io::Result<Child> {
    let mut command = Command::new(program);
    command.args(["--bind", "127.0.0.1", "--port", &port.to_string(), "--expect-data-soon"]);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // Its own group: stopping the run from the terminal must not close the viewer.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.spawn()
}

pub(super) fn failed(what: String, hint: &str) -> RecordError {
    RecordError::View { what, hint: hint.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_may_be_short() {
        for given in ["127.0.0.1:1234", "rerun+http://127.0.0.1:1234/proxy", "http://127.0.0.1:1234/proxy"] {
            assert_eq!(place(given).expect("an address"), "127.0.0.1:1234");
        }
        assert_eq!(place("[::1]:9876").expect("an address"), "[::1]:9876");
        for wrong in ["http://[", "rerun://127.0.0.1:9876/catalog", "localhost", "localhost:no", "a@b:1", "", "::"] {
            let error = place(wrong).expect_err("no address").to_string();
            assert!(error.contains(&format!("`{wrong}`")) && error.contains("9876/proxy"), "{error}");
        }
    }

    #[test]
    fn a_missing_viewer_program_is_named() {
        let begin = Instant::now();
        // A port of the range that systems keep for nobody to listen on.
        let error = spawn("no-such-viewer-program", 1).expect_err("cannot start").to_string();
        assert!(error.contains("no-such-viewer-program") && error.contains("pip install"), "{error}");
        assert!(begin.elapsed() < Duration::from_secs(2));
    }
}
