//! Noise: every random number is a function of (seed, source, tick, index).
//!
//! The generator is ChaCha with 8 rounds, which is a function of a key, a stream
//! number and a counter rather than a state that is used up. The key is the
//! seed (8 bytes, little-endian) followed by 24 fixed bytes; every source of
//! noise owns one stream; every tick owns a place in it, and within that place
//! every draw has a slot of two 32-bit words:
//!
//! | source               | stream | first word of tick t | words per tick     | slot                                  |
//! |----------------------|-------:|---------------------:|-------------------:|---------------------------------------|
//! | slip ([`TickNoise`])   |      1 | 4·t                  | 4                  | 0: ε_L, 2: ε_R                        |
//! | LiDAR ([`LidarNoise`]) |      2 | 8192·t               | 8192 = 4·2048      | 4·k: u of beam k, 4·k + 2: ε of beam k |
//! | IMU                  |      3 | 16·t                 | 16                 | 4·k: walk of axis k (ω, x, y), 4·k + 2: white noise |
//! | IMU, start           |      4 | 0                    | 16, once           | 2·k: bias of axis k                   |
//! | sonars               |      5 | 64·t                 | 64 = 4·16          | 4·k: u of sonar k, 4·k + 2: ε          |
//! | doors                |      6 | 512·t                | 512 = 2·256        | 2·k: u of door number k               |
//! | landmarks            |      7 | 32768·t              | 32768 = 8·4096     | 8·k: u, 8·k + 2: ε_r, 8·k + 4: ε_φ of the landmark with index k |
//! | glass ([`LidarNoise`]) |      8 | 32768·t              | 32768 = 16·2048    | 16·k + 2·j: u of beam k at the pane with index j on its way |
//! | people               |      9 | person k at 2^56·k   | 2 a draw           | speed, place at the start, goals, one after the other |
//! | slip, outliers       |     10 |                  4·t | 4                   | 0: u_L, 2: u_R                        |
//! | your own ([`OwnNoise`]) | 2^63 + n |            2^24·t | 2^24                | 256·k: 128 numbers of 64 bits of slot k |
//!
//! [`Source`] has these numbers as code, and [`Stream`] the words of any source as a
//! [`rand::Rng`]. Positions are known to 2⁶⁸ words, so a tick may be any `u64` below 2⁵³; the
//! contract stops at 2⁴⁰. A new source takes a new stream number; a number or a
//! position in this table never changes, because recorded runs depend on it.
//!
//! What follows from it: changing the number of beams, the dropout, the scan
//! rate or one σ leaves all other noise as it was; tick 10 000 can be computed
//! without the ticks before it; and both draws of a beam are made whether or
//! not its branch uses them (chapter 4, Algorithm `raycast_scan`, line 4).
//!
//! Departures from the chapter: its generator is `SmallRng`, which is documented
//! as not portable. Its normal deviates come from a rejection method, which
//! draws a varying number of words; here [`normal`](rusty_geometry::normal) turns *one* slot into one
//! deviate, so there is nothing to reject and no draw can move another.

mod beams;
mod normal;
mod own;
mod people;
mod stream;
mod tick;

pub use beams::{BEAM_SLOTS, BeamDraw, LidarNoise, PANE_SLOTS};
pub use normal::StandardNormal;
pub use own::OwnNoise;
pub use people::PeopleNoise;
pub use stream::{Source, Stream};
pub use tick::TickNoise;
