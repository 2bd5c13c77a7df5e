//! The only crate that names iceoryx2: loan, fill, send; wait, borrow, answer.
//!
//! In reading order:
//!
//! * [`domain`]: the folder of one run, with its lock, keys and shared memory, and
//!   its removal;
//! * [`memory`]: whether shared memory can be used at all;
//! * [`process`]: what the kernel says of a process: running, stopped, dead;
//! * [`wait`]: look at the data, yield, then block for a bounded while;
//! * [`server`]: the side that loans frames and collects answers;
//! * [`feed`]: how one who comes back is given the ticks it missed;
//! * [`mod@control`]: how another process decides when ticks may happen;
//! * [`client`]: the side that borrows frames and answers;
//! * [`belief`]: what filters show, next to the run, to observers;
//! * [`observer`]: a process that sees a run and has no part in it.
//!
//! For the bench, without a protocol: [`raw`], the transport alone, and
//! [`floor`], the machine alone.
//!
//! Wake-ups are hints. Nothing here waits without a bound, and after every
//! wait the data is looked at. The clock is read to decide who might be
//! asleep; it never reaches a digest.

pub mod belief;
pub mod borrowed;
pub mod client;
pub mod control;
pub mod domain;
mod domain_error;
mod error;
pub mod feed;
pub mod floor;
pub mod keys;
mod lobby;
mod lock;
pub mod memory;
pub mod observer;
mod port;
pub mod process;
pub mod raw;
pub mod server;
mod services;
mod sweep;
mod umask;
pub mod wait;
mod wire;

pub use belief::{BeliefViewer, Beliefs};
pub use borrowed::{BorrowedFrame, BorrowedTally};
pub use client::{ClientLink, Incoming};
pub use control::{ControlCall, control};
pub use domain::{Domain, DomainError, RunState};
pub use error::LinkError;
pub use feed::Feed;
pub use keys::Keys;
pub use memory::{MemoryState, memory_state};
pub use observer::Observer;
pub use process::{Peer, PeerState};
pub use server::{FrameLoan, JoinCall, ReceivedAnswer, ServerLink};
pub use services::MAX_HELD_FRAMES;
pub use umask::with_umask;
pub use wait::{WaitPolicy, monotonic_ns};
