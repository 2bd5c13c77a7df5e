//! Unix sockets and nothing else: the obvious program.
//!
//! A socket per client that keeps the borders between messages
//! (`SOCK_SEQPACKET`). The server writes the frame to each, then reads an
//! answer from each, in order. Two system calls per client and tick on either
//! side, and two copies per message; nothing else happens.

use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::io::Errno;
use rustix::net::{
    AddressFamily, RecvFlags, SendFlags, SocketAddrUnix, SocketFlags, SocketType, accept_with,
    bind, connect, listen, recv, send, socket_with,
};
use rusty_contract::{Answer, Frame};

use super::{AnswerFn, ClientEnd, ServerEnd, answer_from, check_frame};
use crate::contender::Wait;
use crate::error::BenchError;

const LIBRARY: &str = "unix sockets";

struct Stream {
    socket: OwnedFd,
    wait: Wait,
}

impl Stream {
    fn send(&self, bytes: &[u8]) -> Result<(), BenchError> {
        let what = "send";
        loop {
            match send(&self.socket, bytes, SendFlags::NOSIGNAL) {
                Ok(sent) if sent == bytes.len() => return Ok(()),
                Ok(sent) => {
                    return Err(BenchError::of(LIBRARY, what)(format!("only {sent} bytes")));
                }
                Err(Errno::INTR) => {}
                Err(e) => return Err(BenchError::of(LIBRARY, what)(e)),
            }
        }
    }

    /// Reads one message into `bytes` and says how long it is.
    fn receive(&self, bytes: &mut [u8]) -> Result<usize, BenchError> {
        let what = "receive";
        let flags = match self.wait {
            Wait::Poll => RecvFlags::DONTWAIT,
            _ => RecvFlags::empty(),
        };
        loop {
            match recv(&self.socket, &mut *bytes, flags) {
                Ok((0, _)) => return Err(BenchError::of(LIBRARY, what)("the other side is gone")),
                Ok((received, _)) => return Ok(received),
                Err(Errno::AGAIN) => std::thread::yield_now(),
                Err(Errno::INTR) => {}
                Err(e) => return Err(BenchError::of(LIBRARY, what)(e)),
            }
        }
    }
}

fn socket() -> Result<OwnedFd, BenchError> {
    socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None)
        .map_err(BenchError::of(LIBRARY, "make a socket"))
}

fn address(folder: &Path) -> Result<SocketAddrUnix, BenchError> {
    SocketAddrUnix::new(folder.join("uds")).map_err(BenchError::of(LIBRARY, "name a socket"))
}

pub struct Server {
    listener: OwnedFd,
    wait: Wait,
    clients: Vec<Stream>,
    frame: Box<Frame>,
    turn: usize,
}

impl Server {
    pub fn open(wait: Wait, folder: &Path) -> Result<Self, BenchError> {
        let listener = socket()?;
        bind(&listener, &address(folder)?).map_err(BenchError::of(LIBRARY, "bind"))?;
        listen(&listener, 64).map_err(BenchError::of(LIBRARY, "listen"))?;
        Ok(Self { listener, wait, clients: Vec::new(), frame: Frame::boxed(), turn: 0 })
    }
}

impl ServerEnd for Server {
    fn gather(&mut self, clients: usize) -> Result<(), BenchError> {
        while self.clients.len() < clients {
            let socket = match accept_with(&self.listener, SocketFlags::CLOEXEC) {
                Err(Errno::INTR) => continue,
                other => other.map_err(BenchError::of(LIBRARY, "accept"))?,
            };
            let stream = Stream { socket, wait: self.wait };
            let mut ready = [0; size_of::<Answer>()];
            let received = stream.receive(&mut ready)?;
            answer_from(LIBRARY, &ready[..received])?;
            self.clients.push(stream);
        }
        Ok(())
    }

    fn publish(&mut self, write: &mut dyn FnMut(&mut Frame)) -> Result<(), BenchError> {
        write(&mut self.frame);
        let bytes = bytemuck::bytes_of(&*self.frame);
        self.turn = 0;
        self.clients.iter().try_for_each(|client| client.send(bytes))
    }

    fn next_answer(&mut self) -> Result<Answer, BenchError> {
        let mut bytes = [0; size_of::<Answer>()];
        let received = self.clients[self.turn].receive(&mut bytes)?;
        self.turn = (self.turn + 1) % self.clients.len();
        answer_from(LIBRARY, &bytes[..received])
    }
}

pub struct Client(Stream);

impl Client {
    /// Connects to the server in `folder`.
    pub fn open(wait: Wait, folder: &Path) -> Result<Self, BenchError> {
        let socket = socket()?;
        connect(&socket, &address(folder)?).map_err(BenchError::of(LIBRARY, "connect"))?;
        Ok(Self(Stream { socket, wait }))
    }
}

impl ClientEnd for Client {
    fn serve(self: Box<Self>, ready: Answer, mut answer: AnswerFn) -> Result<(), BenchError> {
        self.0.send(bytemuck::bytes_of(&ready))?;
        let mut frame = Frame::boxed();
        loop {
            let received = self.0.receive(bytemuck::bytes_of_mut(&mut *frame))?;
            check_frame(LIBRARY, received)?;
            let Some(answer) = answer(&frame)? else { return Ok(()) };
            self.0.send(bytemuck::bytes_of(&answer))?;
        }
    }
}
