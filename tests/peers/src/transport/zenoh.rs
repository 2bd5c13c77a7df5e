//! Zenoh: frames in its shared memory, answers and all else on a Unix socket.
//!
//! Everyone is a peer; the clients connect to the server's socket, and no process
//! looks for others (no multicast, no gossip). Settings are those that Zenoh
//! recommends for latency: the low-latency transport, which sends from the
//! caller's thread without queues and batches, `express` messages, blocking
//! instead of dropping. As Zenoh's own ping and pong do, a client that blocks
//! answers inside the callback, on the thread that received the frame, and the
//! server takes answers from a channel.
//!
//! A frame is written in place into a buffer of the shared-memory provider and
//! read where it lies; only its descriptor travels. Answers are below the size
//! from which Zenoh itself would use shared memory (3072 bytes).

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use ::zenoh::bytes::ZBytes;
use ::zenoh::handlers::FifoChannelHandler;
use ::zenoh::pubsub::{Publisher, Subscriber};
use ::zenoh::qos::CongestionControl;
use ::zenoh::sample::Sample;
use ::zenoh::shm::{
    AllocAlignment, BlockOn, GarbageCollect, PosixShmProviderBackend, ShmProvider,
    ShmProviderBuilder,
};
use ::zenoh::{Config, Session, Wait as _};
use rusty_contract::{Answer, Frame};

use super::{AnswerFn, ClientEnd, ServerEnd, answer_from, check_frame};
use crate::contender::Wait;
use crate::error::BenchError;

const LIBRARY: &str = "zenoh";
const FRAMES: &str = "rusty/frames";
const ANSWERS: &str = "rusty/answers";

/// Room for frames in shared memory, bytes; two are in use at a time.
const POOL_BYTES: usize = 1 << 20;

/// Frames are written and read in place.
const FRAME_ALIGNMENT: AllocAlignment = AllocAlignment::for_type::<Frame>();

/// Between two times that a client says it is ready.
const BETWEEN_READY: Duration = Duration::from_millis(5);

fn config(folder: &Path, is_server: bool) -> Result<Config, BenchError> {
    let endpoint = format!("[\"unixsock-stream/{}\"]", folder.join("zenoh").display());
    let (mine, others) = if is_server { ("listen", "connect") } else { ("connect", "listen") };
    let mut config = Config::default();
    for (key, value) in [
        ("mode", "\"peer\""),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
        (&format!("{mine}/endpoints"), &*endpoint),
        (&format!("{others}/endpoints"), "[]"),
        ("connect/timeout_ms", "10000"),
        ("connect/exit_on_failure", "true"),
        ("transport/shared_memory/enabled", "true"),
        // Ready before the first frame, not during it.
        ("transport/shared_memory/mode", "\"init\""),
        ("transport/unicast/qos/enabled", "false"),
        ("transport/unicast/lowlatency", "true"),
    ] {
        config.insert_json5(key, value).map_err(BenchError::of(LIBRARY, "configure"))?;
    }
    Ok(config)
}

fn open(folder: &Path, is_server: bool) -> Result<Session, BenchError> {
    let config = config(folder, is_server)?;
    ::zenoh::open(config).wait().map_err(BenchError::of(LIBRARY, "open a session"))
}

fn publisher(session: &Session, key: &'static str) -> Result<Publisher<'static>, BenchError> {
    session
        .declare_publisher(key)
        .congestion_control(CongestionControl::Block)
        .express(true)
        .wait()
        .map_err(BenchError::of(LIBRARY, "declare a publisher"))
}

type Channel = Subscriber<FifoChannelHandler<Sample>>;

fn channel(session: &Session, key: &'static str) -> Result<Channel, BenchError> {
    session.declare_subscriber(key).wait().map_err(BenchError::of(LIBRARY, "declare a subscriber"))
}

/// Waits for the next message.
fn receive(from: &Channel, wait: Wait) -> Result<Sample, BenchError> {
    if wait != Wait::Poll {
        return from.recv().map_err(BenchError::of(LIBRARY, "receive"));
    }
    loop {
        match from.try_recv().map_err(BenchError::of(LIBRARY, "receive"))? {
            Some(sample) => return Ok(sample),
            None => std::thread::yield_now(),
        }
    }
}

fn put(to: &Publisher<'_>, bytes: impl Into<ZBytes>) -> Result<(), BenchError> {
    to.put(bytes).wait().map_err(BenchError::of(LIBRARY, "put"))
}

pub struct Server {
    frames: Publisher<'static>,
    answers: Channel,
    wait: Wait,
    memory: ShmProvider<PosixShmProviderBackend>,
    // Last: it outlives what was declared on it.
    _session: Session,
}

impl Server {
    pub fn open(wait: Wait, folder: &Path) -> Result<Self, BenchError> {
        let session = open(folder, true)?;
        let memory = ShmProviderBuilder::default_backend((POOL_BYTES, FRAME_ALIGNMENT))
            .wait()
            .map_err(BenchError::of(LIBRARY, "make shared memory"))?;
        let answers = channel(&session, ANSWERS)?;
        let frames = publisher(&session, FRAMES)?;
        Ok(Self { frames, answers, wait, memory, _session: session })
    }

    fn next(&self) -> Result<Answer, BenchError> {
        let sample = receive(&self.answers, self.wait)?;
        answer_from(LIBRARY, &sample.payload().to_bytes())
    }
}

impl ServerEnd for Server {
    /// A client's subscription travels before its word that it is ready, on the
    /// same link, so a client that is ready gets frames.
    fn gather(&mut self, clients: usize) -> Result<(), BenchError> {
        let mut ready = std::collections::BTreeSet::new();
        while ready.len() < clients {
            ready.insert(self.next()?.participant);
        }
        Ok(())
    }

    fn publish(&mut self, write: &mut dyn FnMut(&mut Frame)) -> Result<(), BenchError> {
        let layout = (size_of::<Frame>(), FRAME_ALIGNMENT);
        let mut buffer = self
            .memory
            .alloc(layout)
            .with_policy::<BlockOn<GarbageCollect>>()
            .wait()
            .map_err(BenchError::of(LIBRARY, "allocate shared memory"))?;
        let place = bytemuck::try_from_bytes_mut(&mut buffer)
            .map_err(BenchError::of(LIBRARY, "write a frame in place"))?;
        write(place);
        put(&self.frames, buffer)
    }

    fn next_answer(&mut self) -> Result<Answer, BenchError> {
        loop {
            let answer = self.next()?;
            // A client may have said once more that it is ready.
            if answer.message() != Ok(rusty_contract::answer::Message::Ready) {
                return Ok(answer);
            }
        }
    }
}

pub struct Client {
    session: Session,
    wait: Wait,
}

impl Client {
    /// Connects to the server in `folder`.
    pub fn open(wait: Wait, folder: &Path) -> Result<Self, BenchError> {
        Ok(Self { session: open(folder, false)?, wait })
    }
}

/// What a client does with what comes.
struct Answering {
    answer: AnswerFn,
    answers: Publisher<'static>,
    begun: Arc<AtomicBool>,
}

impl Answering {
    /// Answers a frame; says whether it was the last.
    fn take(&mut self, sample: &Sample) -> Result<bool, BenchError> {
        self.begun.store(true, Ordering::Relaxed);
        let bytes = sample.payload().to_bytes();
        check_frame(LIBRARY, bytes.len())?;
        let answered = match bytemuck::try_from_bytes::<Frame>(&bytes) {
            Ok(frame) => (self.answer)(frame)?,
            // Without shared memory it lies wherever the library read it.
            Err(_) => (self.answer)(&bytemuck::pod_read_unaligned(&bytes))?,
        };
        let Some(answer) = answered else { return Ok(true) };
        put(&self.answers, bytemuck::bytes_of(&answer))?;
        Ok(false)
    }
}

/// Says it until the first frame has come: the server may receive it late.
fn say_ready(session: &Session, ready: &Answer, begun: &AtomicBool) -> Result<(), BenchError> {
    let answers = publisher(session, ANSWERS)?;
    while !begun.load(Ordering::Relaxed) {
        put(&answers, bytemuck::bytes_of(ready))?;
        std::thread::sleep(BETWEEN_READY);
    }
    Ok(())
}

impl ClientEnd for Client {
    fn serve(self: Box<Self>, ready: Answer, answer: AnswerFn) -> Result<(), BenchError> {
        let begun = Arc::new(AtomicBool::new(false));
        let answers = publisher(&self.session, ANSWERS)?;
        let mut answering = Answering { answer, answers, begun: Arc::clone(&begun) };
        if self.wait == Wait::Poll {
            let frames = channel(&self.session, FRAMES)?;
            let session = self.session.clone();
            let saying = std::thread::spawn(move || say_ready(&session, &ready, &begun));
            while !answering.take(&receive(&frames, self.wait)?)? {}
            return saying.join().unwrap_or(Ok(()));
        }
        let (tell_end, end) = mpsc::channel();
        let answering = Mutex::new(answering);
        let _frames = self
            .session
            .declare_subscriber(FRAMES)
            .callback(move |sample| {
                let mut answering = answering.lock().unwrap_or_else(PoisonError::into_inner);
                match answering.take(&sample) {
                    Ok(false) => {}
                    Ok(true) => drop(tell_end.send(Ok(()))),
                    Err(e) => drop(tell_end.send(Err(e))),
                }
            })
            .wait()
            .map_err(BenchError::of(LIBRARY, "declare a subscriber"))?;
        say_ready(&self.session, &ready, &begun)?;
        end.recv().map_err(BenchError::of(LIBRARY, "learn of the end"))?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read_where_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let mut server = Server::open(Wait::Block, folder.path()).unwrap();
        let session = open(folder.path(), false).unwrap();
        let frames = channel(&session, FRAMES).unwrap();
        // The subscription takes a while to reach the server.
        let sample = (0..1000).find_map(|_| {
            server.publish(&mut |frame| frame.end(rusty_contract::Phase::Done, 7)).unwrap();
            frames.recv_timeout(Duration::from_millis(20)).unwrap()
        });
        let sample = sample.unwrap();
        assert!(sample.payload().as_shm().is_some(), "not in shared memory");
        let bytes = sample.payload().to_bytes();
        assert_eq!(bytemuck::try_from_bytes::<Frame>(&bytes).unwrap().tick(), 7);
    }
}
