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
//! | slip ([`SlipNoise`])   |      1 | 4·t                  | 4                  | 0: ε_L, 2: ε_R                        |
//! | LiDAR ([`LidarNoise`]) |      2 | 8192·t               | 8192 = 4·2048      | 4·k: u of beam k, 4·k + 2: ε of beam k |
//!
//! Positions are known to 2⁶⁸ words, so a tick may be any `u64` below 2⁵⁵; the
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
mod slip;
mod stream;

pub use beams::{BEAM_SLOTS, BeamDraw, LidarNoise};
pub use slip::SlipNoise;
