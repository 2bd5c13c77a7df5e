//! One lap: a square driven by odometry, and where it really ended.

use rusty_contract::{Frame, RunConfig, ScriptConfig};
use rusty_geometry::{EncoderCounts, SE2, Twist, trig, wrap_angle};
use rusty_sim::{Sim, SimError};
use serde::Serialize;
use thiserror::Error;

use super::belief::Belief;

/// Which way round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// Clockwise: right turns.
    Clockwise,
    /// Counter-clockwise: left turns.
    CounterClockwise,
}

impl Way {
    /// Both, in the order of the paper's tables.
    pub const BOTH: [Self; 2] = [Self::Clockwise, Self::CounterClockwise];

    /// −1 or +1: the sign of its turns.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Clockwise => -1.0,
            Self::CounterClockwise => 1.0,
        }
    }

    /// As in tables.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Clockwise => "cw",
            Self::CounterClockwise => "ccw",
        }
    }
}

/// The programmed path and how it is driven.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Square {
    /// Length L of a side, m.
    pub side_m: f64,
    /// Speed along the sides, m/s.
    pub speed_m_s: f64,
    /// Turn rate on the corners, rad/s.
    pub turn_rad_s: f64,
}

/// Where a lap ended: true less believed pose, in the frame of the start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Return {
    /// Which way round.
    pub way: Way,
    /// The seed of its slip.
    pub seed: u64,
    /// ε_x, m.
    pub x_m: f64,
    /// ε_y, m.
    pub y_m: f64,
    /// ε_θ, rad.
    pub theta_rad: f64,
    /// The true path, a place for each of its ticks; not part of documents.
    #[serde(skip)]
    pub path_m: Vec<[f64; 2]>,
}

/// Why a lap was not driven.
#[derive(Debug, Error)]
pub enum LapError {
    /// The world cannot be made.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The robot did not believe itself back in time.
    #[error(
        "after {ticks} ticks the robot does not believe to be back at its start; give it a \
         shorter --side, finer encoders (robot.ticks_per_rev), or faster wheels \
         (robot.wheel_limit_rad_s)"
    )]
    Lost {
        /// How long was waited.
        ticks: u64,
    },
}

/// Drives the square once, in the open, on what the encoders say: every side
/// until the robot believes to be at the corner, every corner until it believes
/// to look along the next side, so that it believes to have driven a perfect
/// square. `config` gives robot and time step.
///
/// # Errors
/// [`LapError`] if the configuration cannot be used, or leads nowhere.
pub fn lap(
    config: &RunConfig,
    belief: &Belief,
    square: &Square,
    way: Way,
    seed: u64,
) -> Result<Return, LapError> {
    let mut sim = Sim::new(RunConfig {
        seed,
        scan_every: 0,
        start: SE2::identity(),
        script: ScriptConfig::Driver {},
        world: rusty_geometry::open().spec().clone(),
        sensors: rusty_contract::Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
        ..config.clone()
    })?;
    let mut frame = Frame::boxed();
    let mut driver = Driver { belief, square, way, dt_s: config.dt_s, done: 0 };
    let (mut believed, mut last) = (SE2::identity(), EncoderCounts::default());
    let mut path_m = vec![[0.0, 0.0]];
    let most = driver.patience();
    while let Some(wanted) = driver.wanted(&believed) {
        if sim.tick() >= most {
            return Err(LapError::Lost { ticks: most });
        }
        let _ = sim.step(Some(belief.command(wanted)), &mut frame);
        believed = belief.advance(&believed, last, frame.encoders());
        last = frame.encoders();
        path_m.push([sim.truth().x(), sim.truth().y()]);
    }
    let truth = sim.truth();
    Ok(Return {
        way,
        seed,
        x_m: truth.x() - believed.x(),
        y_m: truth.y() - believed.y(),
        theta_rad: wrap_angle(truth.theta() - believed.theta()),
        path_m,
    })
}

/// Follows the square by what is believed.
struct Driver<'a> {
    belief: &'a Belief,
    square: &'a Square,
    way: Way,
    dt_s: f64,
    /// Sides and corners that are done, 0 to 8.
    done: u8,
}

impl Driver<'_> {
    /// Heading of a side, rad; sides are numbered from 0.
    fn heading_rad(&self, side: u8) -> f64 {
        wrap_angle(self.way.sign() * core::f64::consts::FRAC_PI_2 * f64::from(side))
    }

    /// The corner at which a side begins.
    fn corner_m(&self, side: u8) -> [f64; 2] {
        let (l, s) = (self.square.side_m, self.way.sign());
        [[0.0, 0.0], [l, 0.0], [l, s * l], [0.0, s * l]][usize::from(side % 4)]
    }

    /// What is left of the side or corner at hand: m, or rad with its sign.
    fn rest(&self, believed: &SE2) -> f64 {
        let side = self.done / 2;
        if self.done % 2 == 1 {
            return wrap_angle(self.heading_rad(side + 1) - believed.theta());
        }
        let (s, c) = trig::sin_cos(self.heading_rad(side));
        let [x, y] = self.corner_m(side);
        self.square.side_m - (c * (believed.x() - x) + s * (believed.y() - y))
    }

    /// The next command; `None` once the robot believes to be back.
    ///
    /// What is left can always be driven exactly in one tick, and the encoders
    /// round each wheel to half a count before and after; so a rest below one
    /// count of ground, or of a turn, is as good as none.
    fn wanted(&mut self, believed: &SE2) -> Option<Twist> {
        let count_m = self.belief.count_m();
        while self.done < 8 {
            let rest = self.rest(believed);
            let stand = Twist::default();
            if self.done.is_multiple_of(2) && rest > count_m {
                return Some(Twist { v_m_s: self.square.speed_m_s.min(rest / self.dt_s), ..stand });
            }
            let turned = 2.0 * count_m / self.belief.track_m;
            if !self.done.is_multiple_of(2) && rest.abs() > turned {
                let most = self.square.turn_rad_s;
                return Some(Twist { omega_rad_s: (rest / self.dt_s).clamp(-most, most), ..stand });
            }
            self.done += 1;
        }
        None
    }

    /// Ticks after which to give up: ten times what the lap should take.
    fn patience(&self) -> u64 {
        let along_s = 4.0 * self.square.side_m / self.square.speed_m_s;
        let turning_s = core::f64::consts::TAU / self.square.turn_rad_s;
        (10.0 * (along_s + turning_s) / self.dt_s) as u64 + 1000
    }
}
