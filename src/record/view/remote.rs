//! A viewer at the other end of a connection.

use super::sdk::{LogMsg, MessageProxyServiceClient, ToTransport, WriteMessagesRequest, rrd};
use super::sent::{Failure, PATIENCE, Sent, stuck};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::mpsc::{Sender, channel};
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_stream::wrappers::ReceiverStream;
use tonic::transport::Endpoint;

/// Messages that may wait for the connection: each is a stretch of samples, so that few are enough.
const QUEUE: usize = 4;

/// One call of the viewer's service that takes in messages. The viewer answers when it has taken in the last.
pub(super) struct Remote {
    runtime: Runtime,
    /// `None` once the last message is sent.
    messages: Option<Sender<WriteMessagesRequest>>,
    answer: JoinHandle<Result<(), String>>,
}

impl Remote {
    /// Begins the call to a viewer that was seen to listen at `host:port`.
    pub(super) fn connect(place: &str) -> Sent<Self> {
        let runtime = Builder::new_multi_thread().worker_threads(1).enable_all().build()?;
        let endpoint = Endpoint::from_shared(format!("http://{place}"))?;
        let (messages, queue) = channel(QUEUE);
        let answer = runtime.spawn(async move {
            let connection = endpoint.connect().await.map_err(|error| causes(&error))?;
            let mut viewer = MessageProxyServiceClient::new(connection);
            let answer = viewer.write_messages(ReceiverStream::new(queue)).await;
            answer.map(drop).map_err(|status| causes(&status))
        });
        Ok(Self { runtime, messages: Some(messages), answer })
    }

    /// Sends a message; waits for room, but not for ever.
    pub(super) fn send(&mut self, message: &LogMsg) -> Sent {
        let Some(messages) = &self.messages else { return Err("the connection is closed".into()) };
        let message = WriteMessagesRequest { log_msg: Some(message.to_transport(rrd::Compression::LZ4)?.into()) };
        match self.runtime.block_on(async { timeout(PATIENCE, messages.send(message)).await }) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(self.finish().err().unwrap_or_else(|| "it ended the connection".into())),
            Err(_) => Err(stuck().into()),
        }
    }

    /// Waits until the viewer confirms that it has taken in everything.
    pub(super) fn finish(&mut self) -> Sent {
        self.messages = None;
        let answer = &mut self.answer;
        match self.runtime.block_on(async { timeout(PATIENCE, answer).await }) {
            Ok(Ok(answer)) => answer.map_err(Failure::from),
            Ok(Err(error)) => Err(error.into()),
            Err(_) => Err(stuck().into()),
        }
    }
}

/// An error with its causes, in one line.
fn causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    let mut words: Vec<String> = causes.map(ToString::to_string).collect();
    words.dedup();
    words.join(": ")
}
