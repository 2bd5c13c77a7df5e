//! Ticks as ROS 2 messages in CDR, for files and for live views.
//!
//! One encoder, several ways out: a file in MCAP, a folder of rosbag2, a WebSocket
//! carry the same bytes. In reading order: [`cdr`] (bytes), [`messages`] (the types),
//! [`schema`] (their definitions as text), [`channel`] (topics), [`description`] (the
//! robot and its run), [`latched`] (map, markers and mounts, sent once) and [`encoder`]
//! (a tick in, messages out).
//!
//! Conventions: units of REP 103 (metres, radians, seconds; x ahead, y left, z up),
//! frames of REP 105 (`map` → `odom` → `base_link` → `laser`), ranges without a return
//! as +∞ (REP 117). Nothing here reads a clock or a file.

pub mod cdr;
pub mod channel;
pub mod description;
pub mod encoder;
pub mod latched;
pub mod messages;
pub mod schema;

pub use cdr::{CdrError, RosMessage, from_cdr};
pub use channel::Channel;
pub use description::Description;
pub use encoder::{Encoded, Encoder, Tick};
