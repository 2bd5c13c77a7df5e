//! Golden runs: small worlds whose digests are constants.
//!
//! A table of short runs that together take every script, every built-in place,
//! every source of noise, every kind of wall and every odd number a
//! configuration may hold. Each has a world digest (see
//! [`RunDigest::world`](rusty_contract::RunDigest::world)) that was computed
//! once and is written down here. A program that computes another one, on whatever
//! machine, in whatever build, in WebAssembly, does not simulate this world.
//!
//! The table is one and is asked from many sides: by `cargo test` in the
//! profiles dev and release and for the CPU at hand, by a module in WebAssembly,
//! and by `sim-server doctor` on the machine of the person who doubts.
//!
//! A digest says *that* a bit differs and never which; for that there are
//! `sim-server verify` and `sim-server diff`. What the table cannot reach: noise
//! farther out than 6.6 standard deviations, which no run this short meets (its
//! arithmetic is pinned in [`rusty_geometry::normal`]).
//!
//! After a change of bits that is meant,
//! `cargo test -p rusty-sim --test goldens -- --ignored mint --nocapture`
//! prints the new table; the change belongs under "Changes bits" in CHANGELOG.md.

mod driver;
mod runs;

use rusty_contract::{Frame, Log, RunConfig, RunDigest, TruthKey};

use crate::record::record;
use crate::script::{BuiltInScript, Moment};
use crate::sim::Sim;
use crate::sim_error::SimError;

pub use driver::driver_command;

/// A run whose digest is known beforehand.
#[derive(Clone, Copy, Debug)]
pub struct Golden {
    /// What it is called: lower case, dashes.
    pub name: &'static str,
    /// What it pins, for the person who sees it fail.
    pub pins: &'static str,
    /// World digest after its last tick, 32 hexadecimal digits.
    pub expected: &'static str,
    config: fn() -> RunConfig,
}

/// All golden runs.
pub const GOLDENS: [Golden; 15] = [
    Golden {
        name: "apartment-steered",
        pins: "a patrol steered on the truth, slip, range noise, a scan in every fifth tick",
        expected: "b0e59c7c7c69f74de5dc1eaa6a9cc8c9",
        config: runs::apartment_steered,
    },
    Golden {
        name: "hallway-patrol",
        pins: "an open-loop timetable, beams that drop out, doors in recesses",
        expected: "0f4de20ebe8d930ea1f41437eb904c09",
        config: runs::hallway_patrol,
    },
    Golden {
        name: "open-eight",
        pins: "arcs without walls or scans: unequal wheels, slip, long sums of angles",
        expected: "5e2cb4ecd3d127795a341d738419b418",
        config: runs::open_eight,
    },
    Golden {
        name: "apartment-blocked",
        pins: "commands beyond the wheels' limit, then a wall: ticks that move nothing but counts",
        expected: "e6741934d85d60b9bb4fd3446d09a752",
        config: runs::apartment_blocked,
    },
    Golden {
        name: "hallway-commands",
        pins: "a list that is used up; noise so coarse that ranges stop at zero and at the limit",
        expected: "99d9b89e53ce05f64bbcdd80bcd09112",
        config: runs::hallway_commands,
    },
    Golden {
        name: "apartment-driven",
        pins: "a driver's commands, and scans of 1080 beams, the most there can be",
        expected: "a185a12527ed165edeeb115a354a7100",
        config: runs::apartment_driven,
    },
    Golden {
        name: "lopsided",
        pins: "nothing is round or even: crooked walls of all materials, 97 beams over 4.1 rad, \
               a LiDAR that sits askew, a tick of 33 ms, 1000 counts per revolution",
        expected: "0468c5b72bfd81bd38149954e195433a",
        config: runs::lopsided,
    },
    Golden {
        name: "apartment-silent",
        pins: "geometry alone: no noise of any kind, so its seed does not matter",
        expected: "a7ddd0fa304d193b3837591996823481",
        config: runs::apartment_silent,
    },
    Golden {
        name: "apartment-sensed",
        pins: "all small sensors on the way into a wall: bumper, IMU, sonars, doors, landmarks",
        expected: "d0163b09647427019ab262257bfec8fa",
        config: runs::apartment_sensed,
    },
    Golden {
        name: "lobby-glass",
        pins: "beams that pass up to three panes, mixed pixels at edges, noise that grows with range",
        expected: "9e6cea6560aa424c93b247cf19cefea2",
        config: runs::lobby_glass,
    },
    Golden {
        name: "apartment-slippery",
        pins: "a left wheel that slips more, slips with outliers, patches of floor that overlap",
        expected: "247fafc07ae39190424e8daeefc785d2",
        config: runs::apartment_slippery,
    },
    Golden {
        name: "corridor",
        pins: "a place that repeats itself, made by rule",
        expected: "327e2b7712d5a51e1f04e2a7f39361e9",
        config: runs::corridor,
    },
    Golden {
        name: "twin-rooms",
        pins: "two rooms that are images of each other, made by rule",
        expected: "64b2ef823400ebba25bf697e5539c776",
        config: runs::twin_rooms,
    },
    Golden {
        name: "workshop",
        pins: "boxes at all angles, drawn from a seed",
        expected: "27ca6c8910ed2d1de01250e7659d29bd",
        config: runs::workshop,
    },
    Golden {
        name: "warehouse",
        pins: "4096 walls, drawn from a seed",
        expected: "042c94a80b773bc959505c4b0842f57f",
        config: runs::warehouse,
    },
];

impl Golden {
    /// The configuration, made afresh.
    #[must_use]
    pub fn config(&self) -> RunConfig {
        (self.config)()
    }

    /// Simulates the run here and now: its world digest, 32 hexadecimal digits.
    ///
    /// # Errors
    /// [`SimError`] if the configuration cannot be used, which a test excludes.
    pub fn found(&self) -> Result<String, SimError> {
        Ok(digest_of(self.config())?.world_hex())
    }

    /// Records the run, with [`driver_command`] where it asks for a driver.
    ///
    /// # Errors
    /// As [`Golden::found`].
    pub fn record(&self) -> Result<Log, SimError> {
        let config = self.config();
        if config.script.is_driver() {
            return record(config, &mut |moment: &Moment<'_>| driver_command(moment.tick));
        }
        let mut script = BuiltInScript::new(&config.script, config.dt_s, config.start);
        record(config, &mut script)
    }
}

/// Simulates `config` to its last tick and digests frames and truths, as a
/// server does. A script that asks for a driver is given [`driver_command`].
/// Pure: no clock, no file, no thread; the key seals nothing that is digested.
///
/// # Errors
/// [`SimError`] if the configuration cannot be used.
pub fn digest_of(config: RunConfig) -> Result<RunDigest, SimError> {
    let key = TruthKey::from_bytes([0; 32]);
    let ticks = config.ticks;
    let mut sim = Sim::new(config)?;
    let mut frame = Frame::boxed();
    let mut digest = RunDigest::default();
    for tick in 0..ticks {
        let _ = sim.step(Some(driver_command(tick)), &mut frame);
        frame.seal(&key, Some(sim.truth()));
        digest.absorb_frame(&frame, Some(sim.truth()));
    }
    Ok(digest)
}
