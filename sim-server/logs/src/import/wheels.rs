//! Encoder counts for a robot whose encoders were never recorded.
//!
//! A log has poses of the odometry; a run has counts of two wheels. Between
//! two poses the increment τ = log(prev⁻¹ ∘ cur) gives Δs = τ_x and Δθ = τ_θ,
//! and wheels of any radius and track could have laid down Δs ∓ Δθ·ℓ/2. The
//! travel of each wheel is summed as `f64` and the *sum* is rounded, so an
//! increment of the counts is never off by more than one count (4.8 µm per
//! wheel) and rounding does not accumulate.
//!
//! τ_y, the sideways part, is nothing that two wheels can do: it comes from
//! how the robot itself integrated its wheels, and from the six digits of the
//! file. It is dropped and measured.

use rusty_geometry::{DiffDrive, EncoderCounts, SE2, odometry_delta, trig};

use super::recording::Event;

/// The wheels that are made up: r = 0.1 m, ℓ = 0.4 m, 2¹⁷ counts per
/// revolution, so that a count is 4.8 µm.
pub(super) const WHEELS: DiffDrive =
    DiffDrive { wheel_radius_m: 0.1, track_m: 0.4, ticks_per_rev: 1 << 17 };

/// One tick of the run: what is in its frame but the ranges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tick {
    pub(super) stamp_s: f64,
    pub(super) counts: EncoderCounts,
    /// Corrected pose of the body, at scans.
    pub(super) truth: Option<SE2>,
}

/// The largest of something, and its line.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Peak {
    pub(super) value: f64,
    pub(super) line: u64,
}

impl Peak {
    pub(super) fn see(&mut self, value: f64, line: u64) {
        if value > self.value {
            *self = Self { value, line };
        }
    }
}

/// What the poses of a file are poses of, relative to the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mount {
    /// Laser before the axle, m.
    pub(super) offset_m: f64,
    /// The odometry's poses are the laser's, not the body's.
    pub(super) odometry_is_laser: bool,
    /// The scans' first poses are the laser's.
    pub(super) scans_are_laser: bool,
}

impl Mount {
    fn body(&self, pose: SE2, is_laser: bool) -> SE2 {
        // Without an offset there is nothing to do, bit for bit.
        if !is_laser || self.offset_m == 0.0 {
            return pose;
        }
        pose * SE2::new(-self.offset_m, 0.0, 0.0)
    }
}

/// The chain of increments, as wheels.
#[derive(Clone, Debug)]
pub(super) struct Wheels {
    mount: Mount,
    /// Body pose of the last reading or anchor.
    last: Option<SE2>,
    travel_m: [f64; 2],
    counts: EncoderCounts,
    /// Dead reckoning on the counts, from the identity.
    driven: SE2,
    /// Σ|Δs|, m.
    pub(super) distance_m: f64,
    /// Σ|τ_y|, m.
    pub(super) lateral_total_m: f64,
    /// Largest |τ_y|, m.
    pub(super) lateral: Peak,
    /// Largest |Δs|, m.
    pub(super) step: Peak,
}

impl Wheels {
    pub(super) fn new(mount: Mount) -> Self {
        Self {
            mount,
            last: None,
            travel_m: [0.0; 2],
            counts: EncoderCounts::default(),
            driven: SE2::identity(),
            distance_m: 0.0,
            lateral_total_m: 0.0,
            lateral: Peak::default(),
            step: Peak::default(),
        }
    }

    /// Dead reckoning on the counts so far, from the identity.
    pub(super) fn driven(&self) -> SE2 {
        self.driven
    }

    /// Body pose of the last reading or anchor, in the file's frame.
    pub(super) fn last(&self) -> Option<SE2> {
        self.last
    }

    /// Takes an event; an anchor is no tick. A scan holds the
    /// counts of the last reading, unless it brings its own odometry.
    pub(super) fn take(&mut self, event: &Event<'_>) -> Option<Tick> {
        let (mount, line) = (self.mount, event.line());
        let (stamp_s, truth) = match event {
            Event::Anchor { pose, .. } => {
                self.last = Some(mount.body(*pose, mount.odometry_is_laser));
                return None;
            }
            Event::Reading { pose, stamp_s, .. } => {
                self.go_to(mount.body(*pose, mount.odometry_is_laser), line);
                (*stamp_s, None)
            }
            Event::Scan { pose, odometry, stamp_s, .. } => {
                if let Some(odometry) = odometry {
                    self.go_to(mount.body(*odometry, mount.odometry_is_laser), line);
                }
                (*stamp_s, pose.map(|pose| mount.body(pose, mount.scans_are_laser)))
            }
        };
        Some(Tick { stamp_s, counts: self.counts, truth })
    }

    fn go_to(&mut self, pose: SE2, line: u64) {
        let Some(last) = self.last.replace(pose) else {
            return;
        };
        let tau = pose.boxminus(&last);
        let half_m = 0.5 * WHEELS.track_m * tau.z;
        self.travel_m[0] += tau.x - half_m;
        self.travel_m[1] += tau.x + half_m;
        let angles_rad = self.travel_m.map(|m| m / WHEELS.wheel_radius_m);
        let counts = EncoderCounts::from_wheel_angles(angles_rad, WHEELS.ticks_per_rev);
        let delta = odometry_delta(self.counts, counts, &WHEELS);
        self.driven = self.driven.boxplus(&delta);
        self.counts = counts;
        self.distance_m += tau.x.abs();
        self.lateral_total_m += tau.y.abs();
        self.lateral.see(tau.y.abs(), line);
        self.step.see(tau.x.abs(), line);
    }
}

/// How far before the axle a pose lies, from how it moves sideways in turns.
///
/// A point at x = a on the body moves by a·Δθ sideways when the body turns by
/// Δθ; a robot that integrates in steps adds a part in Δs·Δθ. So τ_y is fitted
/// as b·ΔsΔθ + a·Δθ by least squares over the raw increments.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LeverFit {
    last: Option<SE2>,
    uu: f64,
    uv: f64,
    vv: f64,
    uy: f64,
    vy: f64,
}

impl LeverFit {
    pub(super) fn take(&mut self, event: &Event<'_>) {
        let (pose, counts) = match event {
            Event::Anchor { pose, .. } => (*pose, false),
            Event::Reading { pose, .. } => (*pose, true),
            Event::Scan { odometry, .. } => match odometry {
                Some(pose) => (*pose, true),
                None => return,
            },
        };
        if let (Some(last), true) = (self.last.replace(pose), counts) {
            let tau = pose.boxminus(&last);
            let (u, v) = (tau.x * tau.z, tau.z);
            self.uu += u * u;
            self.uv += u * v;
            self.vv += v * v;
            self.uy += u * tau.y;
            self.vy += v * tau.y;
        }
    }

    /// a, m; `None` where the robot turned too little to tell.
    pub(super) fn arm_m(&self) -> Option<f64> {
        let determinant = self.uu * self.vv - self.uv * self.uv;
        if self.vv < 1e-2 {
            None
        } else if determinant > 1e-9 * self.uu * self.vv {
            Some((self.uu * self.vy - self.uv * self.uy) / determinant)
        } else {
            // One column only: the robot turns in place, or always drives the
            // same arc; then b cannot be told from a and is taken as 0.
            Some(self.vy / self.vv)
        }
    }
}

/// Distance between two positions, m.
pub(super) fn distance_m(a: &SE2, b: &SE2) -> f64 {
    trig::hypot(a.x() - b.x(), a.y() - b.y())
}
