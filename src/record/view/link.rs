//! The thread that talks to the viewer, so that nobody else waits for it.

use super::sent::{PATIENCE, stuck};
use super::stream::Stream;
use std::sync::mpsc::{Receiver, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::time::{Duration, Instant};

/// Something to tell the viewer.
pub(super) type Job = Box<dyn FnOnce(&Stream) -> Result<(), String> + Send>;

/// Jobs that may wait while one is being done.
const QUEUE: usize = 16;

/// A queue of jobs for one viewer.
pub(super) struct Link {
    jobs: Option<SyncSender<Job>>,
    news: Receiver<News>,
}

/// What the thread tells.
enum News {
    /// A job is done; the viewer is alive.
    Done,
    /// Nothing more will be done.
    Over(Result<(), String>),
}

impl Link {
    /// Starts the thread. The viewer behind `stream` has been seen to listen.
    pub(super) fn start(stream: Stream) -> std::io::Result<Self> {
        let (jobs, queue) = sync_channel(QUEUE);
        let (report, news) = channel();
        std::thread::Builder::new().name("viewer".into()).spawn(move || {
            let worked = work(&stream, queue, &report);
            let _ = report.send(News::Over(worked.and_then(|()| stream.finish().map_err(|error| error.to_string()))));
        })?;
        Ok(Self { jobs: Some(jobs), news })
    }

    /// Queues a job; waits for room, but not for ever.
    pub(super) fn send(&mut self, mut job: Job) -> Result<(), String> {
        let Some(jobs) = &self.jobs else { return Err("it was given up before".into()) };
        let start = Instant::now();
        let failure = loop {
            match jobs.try_send(job) {
                Ok(()) => break None,
                Err(TrySendError::Disconnected(_)) => break Some(self.wait().err().unwrap_or_else(stuck)),
                Err(TrySendError::Full(_)) if start.elapsed() > PATIENCE => break Some(stuck()),
                Err(TrySendError::Full(back)) => job = back,
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        match failure {
            Some(failure) => {
                self.jobs = None;
                Err(failure)
            }
            None => self
                .news
                .try_iter()
                .find_map(|news| if let News::Over(end) = news { Some(end) } else { None })
                .unwrap_or(Ok(())),
        }
    }

    /// Waits until everything queued has been taken in, as long as the viewer takes in anything at all.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        if self.jobs.take().is_some() { self.wait() } else { Ok(()) }
    }

    fn wait(&self) -> Result<(), String> {
        // A job's own time-out comes first, and says more.
        while let Ok(news) = self.news.recv_timeout(PATIENCE + Duration::from_secs(1)) {
            if let News::Over(end) = news {
                return end;
            }
        }
        Err(stuck())
    }
}

fn work(stream: &Stream, queue: Receiver<Job>, report: &Sender<News>) -> Result<(), String> {
    for job in queue {
        job(stream)?;
        // Nobody may be listening any more; the jobs are done all the same.
        let _ = report.send(News::Done);
    }
    Ok(())
}
