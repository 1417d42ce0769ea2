//! The thread that talks to the viewer, so that nobody else waits for it.

use rerun::RecordingStream;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, channel, sync_channel};
use std::time::{Duration, Instant};

/// Something to tell the viewer.
pub(super) type Job = Box<dyn FnOnce(&RecordingStream) -> Result<(), String> + Send>;

/// Jobs that may wait while one is being done.
const QUEUE: usize = 16;
/// How long one job may take. A viewer that takes in nothing for so long is given up.
const PATIENCE: Duration = Duration::from_secs(10);

/// A queue of jobs for one viewer.
pub(super) struct Link {
    jobs: Option<SyncSender<Job>>,
    end: Receiver<Result<(), String>>,
}

impl Link {
    /// Starts the thread. The viewer behind `stream` has been seen to listen.
    pub(super) fn start(stream: RecordingStream) -> std::io::Result<Self> {
        let (jobs, queue) = sync_channel(QUEUE);
        let (report, end) = channel();
        std::thread::Builder::new().name("viewer".into()).spawn(move || {
            let done = work(&stream, &queue);
            // Those who wait for room in the queue see at once that it is over.
            drop(queue);
            if done.is_err() {
                // Before dropping: that waits for the viewer, perhaps for ever.
                let _ = report.send(done);
                drop(stream);
            } else {
                drop(stream);
                let _ = report.send(done);
            }
        })?;
        Ok(Self { jobs: Some(jobs), end })
    }

    /// Queues a job; waits for room, but not for ever.
    pub(super) fn send(&mut self, job: Job) -> Result<(), String> {
        let Some(jobs) = &self.jobs else { return Err("the viewer was given up".into()) };
        let start = Instant::now();
        let mut job = job;
        loop {
            match jobs.try_send(job) {
                Ok(()) => return Ok(()),
                Err(TrySendError::Disconnected(_)) => {
                    self.jobs = None;
                    return Err(self.end.recv_timeout(PATIENCE).ok().and_then(Result::err).unwrap_or_else(stuck));
                }
                Err(TrySendError::Full(_)) if start.elapsed() > PATIENCE => {
                    self.jobs = None;
                    return Err(stuck());
                }
                Err(TrySendError::Full(back)) => job = back,
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Waits until everything queued has been taken in, as long as the viewer takes in anything at all.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        if self.jobs.take().is_none() {
            return Ok(());
        }
        // Every job in the queue has its own time; the thread reports the first that takes too long.
        match self.end.recv_timeout(PATIENCE * (QUEUE as u32 + 2)) {
            Ok(done) => done,
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => Err(stuck()),
        }
    }
}

fn work(stream: &RecordingStream, queue: &Receiver<Job>) -> Result<(), String> {
    for job in queue {
        job(stream)?;
        stream.flush_with_timeout(PATIENCE).map_err(|error| error.to_string())?;
    }
    Ok(())
}

fn stuck() -> String {
    format!("it took in nothing for {} s", PATIENCE.as_secs())
}
