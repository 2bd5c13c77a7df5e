//! ZeroMQ over `ipc://`: frames by PUB and SUB, answers by PUSH and PULL.
//!
//! One call sends a frame to every client, and the answers of all come into one
//! queue: what the library's guide uses where one speaks to many and collects.
//! ROUTER and DEALER would make the server send a frame once per client. The
//! publisher is an XPUB, which is a PUB that learns of subscriptions: so the
//! first frame waits for everyone instead of for a guess of seconds.
//!
//! Messages are handed over at once: ZeroMQ has no timer that would hold them
//! back, and in lockstep there is never a second one to be batched with. Each
//! side has the library's usual single I/O thread.

use std::path::Path;

use ::zmq::{Context, Socket, SocketType};
use rusty_contract::{Answer, Frame};

use super::{AnswerFn, ClientEnd, ServerEnd, answer_from, answer_size, check_frame};
use crate::contender::Wait;
use crate::error::BenchError;

const LIBRARY: &str = "zmq";

/// Reads one message into `bytes` and says how long it is; more than there is
/// room for is cut off, but counted.
fn receive(socket: &Socket, wait: Wait, bytes: &mut [u8]) -> Result<usize, BenchError> {
    let flags = if wait == Wait::Poll { ::zmq::DONTWAIT } else { 0 };
    loop {
        match socket.recv_into(bytes, flags) {
            Ok(received) => return Ok(received),
            Err(::zmq::Error::EAGAIN) => std::thread::yield_now(),
            Err(::zmq::Error::EINTR) => {}
            Err(e) => return Err(BenchError::of(LIBRARY, "receive")(e)),
        }
    }
}

fn send(socket: &Socket, bytes: &[u8]) -> Result<(), BenchError> {
    loop {
        match socket.send(bytes, 0) {
            Ok(()) => return Ok(()),
            Err(::zmq::Error::EINTR) => {}
            Err(e) => return Err(BenchError::of(LIBRARY, "send")(e)),
        }
    }
}

fn endpoint(folder: &Path, name: &str) -> String {
    format!("ipc://{}", folder.join(name).display())
}

fn socket(context: &Context, kind: SocketType) -> Result<Socket, BenchError> {
    context.socket(kind).map_err(BenchError::of(LIBRARY, "make a socket"))
}

fn receive_answer(socket: &Socket, wait: Wait) -> Result<Answer, BenchError> {
    let mut bytes = [0; size_of::<Answer>()];
    let received = receive(socket, wait, &mut bytes)?;
    match bytes.get(..received) {
        Some(whole) => answer_from(LIBRARY, whole),
        None => Err(answer_size(LIBRARY, received)),
    }
}

pub struct Server {
    frames: Socket,
    answers: Socket,
    wait: Wait,
    frame: Box<Frame>,
}

impl Server {
    /// Binds its sockets in `folder`.
    pub fn open(wait: Wait, folder: &Path) -> Result<Self, BenchError> {
        let context = Context::new();
        let frames = socket(&context, SocketType::XPUB)?;
        // Every subscription is reported, not only the first to a topic.
        frames.set_xpub_verbose(true).map_err(BenchError::of(LIBRARY, "set XPUB_VERBOSE"))?;
        frames.bind(&endpoint(folder, "frames")).map_err(BenchError::of(LIBRARY, "bind"))?;
        let answers = socket(&context, SocketType::PULL)?;
        answers.bind(&endpoint(folder, "answers")).map_err(BenchError::of(LIBRARY, "bind"))?;
        Ok(Self { frames, answers, wait, frame: Frame::boxed() })
    }
}

impl ServerEnd for Server {
    fn gather(&mut self, clients: usize) -> Result<(), BenchError> {
        for _ in 0..clients {
            let mut subscription = [0; 8];
            receive(&self.frames, Wait::Block, &mut subscription)?;
        }
        for _ in 0..clients {
            receive_answer(&self.answers, Wait::Block)?;
        }
        Ok(())
    }

    fn publish(&mut self, write: &mut dyn FnMut(&mut Frame)) -> Result<(), BenchError> {
        write(&mut self.frame);
        send(&self.frames, bytemuck::bytes_of(&*self.frame))
    }

    fn next_answer(&mut self) -> Result<Answer, BenchError> {
        receive_answer(&self.answers, self.wait)
    }
}

pub struct Client {
    frames: Socket,
    answers: Socket,
    wait: Wait,
}

impl Client {
    /// Connects to the server in `folder`.
    pub fn open(wait: Wait, folder: &Path) -> Result<Self, BenchError> {
        let context = Context::new();
        let frames = socket(&context, SocketType::SUB)?;
        frames.connect(&endpoint(folder, "frames")).map_err(BenchError::of(LIBRARY, "connect"))?;
        frames.set_subscribe(b"").map_err(BenchError::of(LIBRARY, "subscribe"))?;
        let answers = socket(&context, SocketType::PUSH)?;
        answers
            .connect(&endpoint(folder, "answers"))
            .map_err(BenchError::of(LIBRARY, "connect"))?;
        Ok(Self { frames, answers, wait })
    }
}

impl ClientEnd for Client {
    fn serve(self: Box<Self>, ready: Answer, mut answer: AnswerFn) -> Result<(), BenchError> {
        send(&self.answers, bytemuck::bytes_of(&ready))?;
        let mut frame = Frame::boxed();
        loop {
            let received = receive(&self.frames, self.wait, bytemuck::bytes_of_mut(&mut *frame))?;
            check_frame(LIBRARY, received)?;
            let Some(answer) = answer(&frame)? else { return Ok(()) };
            send(&self.answers, bytemuck::bytes_of(&answer))?;
        }
    }
}
