//! From counts and true poses to errors and what they may come from.

use nalgebra::{Matrix2, Matrix3, Vector2};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, odometry_delta, tick_length};
use serde::Serialize;

use crate::{Motion, OdometryNoise};

/// Between two true poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Truth less odometry: ahead (m) and round (rad), in the tangent space at the
    /// end.
    pub error: Vector2<f64>,
    /// Covariance of that for each α, were it 1 and the others 0.
    pub of_alpha: [Matrix2<f64>; 4],
    /// Covariance that is known: of counts in whole numbers and of the true poses.
    pub known: Matrix2<f64>,
    /// Way ahead, m, and round, rad, that the counts say.
    pub driven: Vector2<f64>,
    /// How many ticks it has.
    pub ticks: u64,
}

/// What was left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Left {
    /// Windows in which the wheels stood.
    pub standing: u64,
    /// Windows in which the wheels turned and the robot stood: something held it.
    pub held: u64,
    /// Windows in which it came much farther than the wheels did: carried.
    pub carried: u64,
}

/// Collects windows, tick by tick.
#[derive(Clone, Debug)]
pub struct Windows {
    drive: DiffDrive,
    /// Variance of the difference of two true poses, ahead (m²) and round (rad²).
    of_reference: Vector2<f64>,
    last: EncoderCounts,
    /// True pose at the start of the window.
    from: Option<SE2>,
    motions: [Motion; 4],
    way_m: f64,
    driven: Vector2<f64>,
    ticks: u64,
    /// The finished ones.
    pub all: Vec<Window>,
    /// How many were left out.
    pub left: Left,
}

/// Each α by itself.
fn unit(place: usize) -> OdometryNoise {
    let of = |k| if k == place { 1.0 } else { 0.0 };
    OdometryNoise { alpha1: of(0), alpha2: of(1), alpha3: of(2), alpha4: of(3) }
}

/// Ahead and round of ahead, sideways and round.
fn ahead_and_round(m: &Matrix3<f64>) -> Matrix2<f64> {
    Matrix2::new(m[(0, 0)], m[(0, 2)], m[(2, 0)], m[(2, 2)])
}

impl Windows {
    /// Before the first tick, with counts of zero; the true poses have these standard
    /// deviations, ahead (m) and round (rad), each for itself.
    pub fn new(drive: DiffDrive, reference: Vector2<f64>) -> Self {
        Self {
            drive,
            of_reference: reference.component_mul(&reference) * 2.0,
            last: EncoderCounts::default(),
            from: None,
            motions: [Motion::default(); 4],
            way_m: 0.0,
            driven: Vector2::zeros(),
            ticks: 0,
            all: Vec::new(),
            left: Left::default(),
        }
    }

    /// The next tick does not follow from the one before: the robot was lifted.
    pub fn interrupt(&mut self) {
        self.from = None;
    }

    /// Takes a tick: counts at its end, and the true pose where it is known.
    pub fn tick(&mut self, counts: EncoderCounts, truth: Option<SE2>) {
        let step = odometry_delta(self.last, counts, &self.drive);
        self.last = counts;
        for (k, motion) in self.motions.iter_mut().enumerate() {
            motion.push(&step, &unit(k).of_step(&step));
        }
        self.way_m += step.x.abs() + 0.5 * self.drive.track_m * step.z.abs();
        self.driven += Vector2::new(step.x, step.z);
        self.ticks += 1;
        let Some(truth) = truth.filter(SE2::is_finite) else { return };
        if let Some(from) = self.from {
            self.end(&from, &truth);
        }
        self.from = Some(truth);
        self.motions = [Motion::default(); 4];
        (self.way_m, self.driven, self.ticks) = (0.0, Vector2::zeros(), 0);
    }

    fn end(&mut self, from: &SE2, to: &SE2) {
        let odometry = self.motions[0].now_in_then;
        let truly = from.inverse().compose(to);
        let error = truly.boxminus(&odometry);
        let went = truly.log();
        let went_m =
            (went.x * went.x + went.y * went.y).sqrt() + 0.5 * self.drive.track_m * went.z.abs();
        let count_m = tick_length(&self.drive);
        if self.way_m <= 0.0 {
            self.left.standing += 1;
        } else if went_m <= 1e-3 * self.way_m && self.way_m > 4.0 * count_m {
            self.left.held += 1;
        } else if went_m > 5.0 * self.way_m + 0.1 {
            self.left.carried += 1;
        } else {
            // Two roundings a wheel, each uniform within half a count.
            let count_m2 = count_m * count_m;
            let track_m2 = self.drive.track_m * self.drive.track_m;
            let of_counts = Vector2::new(count_m2 / 12.0, count_m2 / (3.0 * track_m2));
            self.all.push(Window {
                error: Vector2::new(error.x, error.z),
                of_alpha: self.motions.map(|m| ahead_and_round(&m.covariance)),
                known: Matrix2::from_diagonal(&(of_counts + self.of_reference)),
                driven: self.driven,
                ticks: self.ticks,
            });
        }
    }
}
