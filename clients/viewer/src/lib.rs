//! The viewer: a run or a log as a page in a browser, and driving from there.
//!
//! In reading order:
//!
//! * [`record`]: a tick and a belief as the page gets them, in bytes;
//! * [`scene`]: the rest, as JSON: walls, robot, LiDAR, names, state, requests;
//! * [`outbox`], [`hub`]: the pages that are open, and what a page that opens later gets;
//! * [`foxglove`]: the same for Foxglove and Lichtblick, as messages of ROS 2;
//! * [`access`], [`http`], [`server`]: the page and its socket, on loopback only;
//! * [`live`], [`flow`]: a run that goes on, and the part of it that pages get;
//!   [`recording`], [`playback`]: a log;
//! * [`command`], [`hold`], [`drive`]: commands from a page or a terminal to the driver of
//!   a run.
//!
//! The viewer has no part in a run: no process waits for it, and of what it is too
//! slow for it misses ticks. A page that is too slow misses ticks in turn.

pub mod access;
pub mod command;
pub mod drive;
pub mod flow;
pub mod foxglove;
pub mod hold;
pub mod http;
pub mod hub;
pub mod live;
pub mod outbox;
pub mod playback;
mod programs;
pub mod record;
pub mod recording;
pub mod scene;
pub mod server;
mod terminal;

pub use programs::PROGRAMS;
