//! How frames and answers travel, a file per library.
//!
//! Each is the program that a competent user of the library writes for this
//! task, with the settings that its documentation recommends for latency. Each
//! carries whole frames and answers, byte for byte.

mod uds;
#[cfg(feature = "zenoh")]
mod zenoh;
#[cfg(feature = "zmq")]
mod zmq;

use std::path::Path;

use rusty_contract::{Answer, Frame};

use crate::contender::{Contender, Wait};
use crate::error::BenchError;

pub trait ServerEnd {
    /// Waits until N clients are there and would get a frame.
    fn gather(&mut self, clients: usize) -> Result<(), BenchError>;

    /// Sends everyone the frame that `write` writes. What was in its place
    /// before may be anything.
    fn publish(&mut self, write: &mut dyn FnMut(&mut Frame)) -> Result<(), BenchError>;

    /// Waits for the next answer.
    fn next_answer(&mut self) -> Result<Answer, BenchError>;
}

/// What a client says to a frame; nothing to the last one.
pub type AnswerFn = Box<dyn FnMut(&Frame) -> Result<Option<Answer>, BenchError> + Send>;

pub trait ClientEnd {
    /// Says `ready`, then answers every frame, up to the last.
    fn serve(self: Box<Self>, ready: Answer, answer: AnswerFn) -> Result<(), BenchError>;
}

/// Opens the server's end in `folder`.
pub fn server(
    contender: Contender,
    wait: Wait,
    folder: &Path,
) -> Result<Box<dyn ServerEnd>, BenchError> {
    match contender {
        #[cfg(feature = "zmq")]
        Contender::Zmq => Ok(Box::new(zmq::Server::open(wait, folder)?)),
        #[cfg(feature = "zenoh")]
        Contender::Zenoh => Ok(Box::new(zenoh::Server::open(wait, folder)?)),
        Contender::Uds => Ok(Box::new(uds::Server::open(wait, folder)?)),
        other => Err(none(other)),
    }
}

/// Opens a client's end on the server in `folder`.
pub fn client(
    contender: Contender,
    wait: Wait,
    folder: &Path,
) -> Result<Box<dyn ClientEnd>, BenchError> {
    match contender {
        #[cfg(feature = "zmq")]
        Contender::Zmq => Ok(Box::new(zmq::Client::open(wait, folder)?)),
        #[cfg(feature = "zenoh")]
        Contender::Zenoh => Ok(Box::new(zenoh::Client::open(wait, folder)?)),
        Contender::Uds => Ok(Box::new(uds::Client::open(wait, folder)?)),
        other => Err(none(other)),
    }
}

fn none(contender: Contender) -> BenchError {
    let problem = contender.missing().unwrap_or_else(|| "it has its own processes".to_owned());
    BenchError::of(contender.word(), "open a transport")(problem)
}

/// Removes shared memory that a killed process of a library left, where the
/// library does not do so by itself.
pub fn sweep() {
    #[cfg(feature = "zenoh")]
    ::zenoh::shm::cleanup_orphaned_shm_segments();
}

/// Takes what came for an answer.
fn answer_from(library: &'static str, bytes: &[u8]) -> Result<Answer, BenchError> {
    bytemuck::try_pod_read_unaligned(bytes).map_err(|_| answer_size(library, bytes.len()))
}

/// Says no to an answer of another size.
fn answer_size(library: &'static str, bytes: usize) -> BenchError {
    BenchError::Size { library, what: "an answer", bytes, expected: size_of::<Answer>() }
}

/// Says no to a frame of another size.
fn check_frame(library: &'static str, bytes: usize) -> Result<(), BenchError> {
    let expected = size_of::<Frame>();
    if bytes == expected {
        return Ok(());
    }
    Err(BenchError::Size { library, what: "a frame", bytes, expected })
}

#[cfg(test)]
mod tests;
