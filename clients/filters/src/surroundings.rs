//! What stands around the robot, and how far it may go: the rule that keeps a
//! driver off the walls, whatever else it believes.
//!
//! Source: D. Fox, W. Burgard, S. Thrun, *The dynamic window approach to collision
//! avoidance* (IEEE Robotics & Automation Magazine 4(1), 1997), §III: a command
//! (v, ω) moves the robot on a circle; the distance to the first obstacle on it
//! bounds the speed; a speed at which the robot can still stop is *admissible*.
//!
//! Departures, and why:
//! * A command here takes effect at once, so stopping needs no distance: a speed
//!   is admissible if what it drives until another scan can have been answered
//!   is clear ([`Surroundings::limit`]).
//! * Obstacles are points, those of all scans of the last seconds, carried along
//!   by the odometry. A beam without an echo takes nothing away: dropouts, and a
//!   wall that is seen edge on and slips between two beams, were seen before.
//!   What nothing is known of, because no scan came lately, is not driven into; what
//!   no beam of a scan points at is taken for free, so the laser has to look to where
//!   the robot goes.
//! * The distance to a point on a circle is computed for the whole disc of the
//!   body, in closed form ([`clear_along_m`]).

use std::collections::VecDeque;

use clap::Args;
use nalgebra::Point2;
use rusty_contract::Start;
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, Twist, odometry_delta, trig};

use crate::Beams;
use crate::beams::believed_lidar;
use crate::numbers::positive;

/// Points farther off than this are of no concern, m.
const REACH_M: f64 = 3.0;

/// A curvature below this is a straight line: over [`REACH_M`] the two are half
/// a micrometre apart.
const STRAIGHT_PER_M: f64 = 1e-7;

/// How careful a driver is.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Safety")]
pub struct Caution {
    /// Margin around the body, m
    #[arg(long, value_name = "METRES", default_value_t = 0.06, value_parser = positive)]
    pub margin_m: f64,

    /// Time for which a scan is remembered, s
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, value_parser = positive)]
    pub memory_s: f64,

    /// Maximum speed, m/s
    #[arg(long, value_name = "SPEED", default_value_t = 0.5, value_parser = positive)]
    pub speed_m_s: f64,

    /// Maximum turn rate, rad/s
    #[arg(long, value_name = "RATE", default_value_t = 1.5, value_parser = positive)]
    pub turn_rad_s: f64,
}

crate::numbers::default_of_command_line!(Caution);

/// The points that the last scans met, and the body among them.
#[derive(Clone, Debug)]
pub struct Surroundings {
    beams: Beams,
    drive: DiffDrive,
    wheel_limit_rad_s: f64,
    /// Body and margin.
    radius_m: f64,
    /// How long a command may last before what is seen next can change it, s.
    horizon_s: f64,
    /// How many ticks a scan is remembered.
    memory_ticks: u64,
    /// Ticks after which a scan is overdue.
    fresh_ticks: u64,
    now: u64,
    last: EncoderCounts,
    pose_in_odometry: SE2,
    /// Tick and points of each scan, odometry frame.
    scans: VecDeque<(u64, Vec<Point2<f64>>)>,
    has_seen: bool,
    /// The same points in the body frame.
    points: Vec<Point2<f64>>,
}

impl Surroundings {
    /// Of a robot that has not seen anything yet.
    pub fn new(start: &Start, caution: &Caution) -> Self {
        let ticks = |time_s: f64| (time_s / start.dt_s).ceil() as u64;
        // A recording does not say when its scans are.
        let between = start.scan_every.max(1);
        Self {
            beams: Beams::new(&believed_lidar(start)),
            drive: start.robot.drive,
            wheel_limit_rad_s: start.robot.wheel_limit_rad_s,
            radius_m: start.robot.body_radius_m + caution.margin_m,
            horizon_s: (between + 1) as f64 * start.dt_s,
            memory_ticks: ticks(caution.memory_s).max(between),
            fresh_ticks: between.saturating_mul(3),
            now: 0,
            last: EncoderCounts::default(),
            pose_in_odometry: SE2::identity(),
            scans: VecDeque::new(),
            has_seen: false,
            points: Vec::new(),
        }
    }

    /// A tick: encoder counts and, if there is one, the scan at its end.
    pub fn tick(&mut self, ticks: EncoderCounts, ranges_m: Option<&[f64]>) {
        self.now += 1;
        let step = odometry_delta(self.last, ticks, &self.drive);
        self.last = ticks;
        self.pose_in_odometry = self.pose_in_odometry.boxplus(&step);
        if let Some(ranges_m) = ranges_m {
            let pose = self.pose_in_odometry;
            let seen = self.beams.endpoints(ranges_m).filter(|e| e.range_m < REACH_M);
            let points = seen.map(|e| pose.transform_point(&e.in_body)).collect();
            self.scans.push_back((self.now, points));
            self.has_seen = true;
        }
        let oldest = self.now.saturating_sub(self.memory_ticks);
        while self.scans.front().is_some_and(|(at, _)| *at < oldest) {
            self.scans.pop_front();
        }
        let body_from_odometry = self.pose_in_odometry.inverse();
        let (s, c) = trig::sin_cos(body_from_odometry.theta());
        let (x, y) = (body_from_odometry.x(), body_from_odometry.y());
        self.points.clear();
        let all = self.scans.iter().flat_map(|(_, points)| points);
        self.points.extend(all.map(|p| Point2::new(x + c * p.x - s * p.y, y + s * p.x + c * p.y)));
    }

    /// Where the odometry has the body, in a frame that no other code uses.
    pub fn pose_in_odometry(&self) -> SE2 {
        self.pose_in_odometry
    }

    /// Number of ticks so far.
    pub fn tick_count(&self) -> u64 {
        self.now
    }

    /// What to say at the end of a run with ticks, but without a single scan; else nothing.
    pub fn remark(&self) -> &'static str {
        if self.has_seen || self.now == 0 {
            ""
        } else {
            "; no scan came, without which it stands: set scan_every"
        }
    }

    /// Whether a scan came lately.
    pub fn knows(&self) -> bool {
        self.scans.back().is_some_and(|(at, _)| self.now - at < self.fresh_ticks)
    }

    /// What the scans of the last seconds met near the robot, body frame, m.
    pub fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    /// Whether a scan came in this tick.
    pub fn is_new(&self) -> bool {
        self.scans.back().is_some_and(|(at, _)| *at == self.now)
    }

    /// How far the robot can go under `twist` until body and margin meet a
    /// point, m, no more than 3; 0 where nothing is known.
    pub fn clear_m(&self, twist: Twist) -> f64 {
        self.clear_within_m(twist, REACH_M)
    }

    /// The same, no more than `reach_m`, for which fewer points are looked at.
    pub fn clear_within_m(&self, twist: Twist, reach_m: f64) -> f64 {
        if !self.knows() || twist.v_m_s == 0.0 {
            return 0.0;
        }
        // Backwards is forwards in a mirror; the centre of the circle stays.
        let curvature_per_m = twist.omega_rad_s / twist.v_m_s;
        let side = if twist.v_m_s < 0.0 { -1.0 } else { 1.0 };
        let clear = |p: &Point2<f64>| {
            clear_along_m(Point2::new(side * p.x, p.y), curvature_per_m, self.radius_m)
        };
        let square_m2 = (reach_m + self.radius_m) * (reach_m + self.radius_m);
        let near = self.points.iter().filter(|p| p.coords.norm_squared() <= square_m2);
        near.map(clear).fold(reach_m, f64::min)
    }

    /// How far it can go straight in the direction `bearing_rad` from ahead, with a body of
    /// `more_m` of additional margin, m, no more than 3; 0 where nothing is known.
    pub fn clear_towards_m(&self, bearing_rad: f64, more_m: f64) -> f64 {
        if !self.knows() {
            return 0.0;
        }
        let (s, c) = trig::sin_cos(bearing_rad);
        let radius_m = self.radius_m + more_m;
        let clear = |p: &Point2<f64>| {
            let turned = Point2::new(c * p.x + s * p.y, c * p.y - s * p.x);
            clear_along_m(turned, 0.0, radius_m)
        };
        self.points.iter().map(clear).fold(REACH_M, f64::min)
    }

    /// The admissible part of a command: within what the wheels can do, and
    /// slowed down, curvature kept, until what it drives before another scan can
    /// have been answered is clear. A turn on the spot moves no disc and is
    /// always admissible; what is no number is not.
    pub fn limit(&self, twist: Twist) -> Twist {
        let twist = self.drive.limit(twist, self.wheel_limit_rad_s);
        if twist.v_m_s == 0.0 {
            return twist;
        }
        let far_m = twist.v_m_s.abs() * self.horizon_s;
        let clear_m = self.clear_m(twist);
        if far_m <= clear_m {
            return twist;
        }
        let share = clear_m / far_m;
        Twist { v_m_s: twist.v_m_s * share, omega_rad_s: twist.omega_rad_s * share }
    }
}

/// How far a disc of `radius_m`, which starts at the origin towards +x on a
/// circle of this curvature, goes until it meets `point`; infinite if it never
/// does. A disc that has the point in it already goes nowhere but away from it.
pub fn clear_along_m(point: Point2<f64>, curvature_per_m: f64, radius_m: f64) -> f64 {
    let square = point.coords.norm_squared();
    let inside = square < radius_m * radius_m;
    if inside && point.x > 0.0 {
        return 0.0;
    }
    if curvature_per_m.abs() < STRAIGHT_PER_M {
        if point.x <= 0.0 || point.y.abs() >= radius_m {
            return f64::INFINITY;
        }
        return (point.x - (radius_m * radius_m - point.y * point.y).sqrt()).max(0.0);
    }
    // On a circle to the left: mirrored if need be. The centre is (0, r).
    let r = 1.0 / curvature_per_m.abs();
    let y = if curvature_per_m < 0.0 { -point.y } else { point.y };
    let (dx, dy) = (point.x, y - r);
    let from_centre_m = (dx * dx + dy * dy).sqrt();
    // Bearing of the point as the disc's centre passes it, from the start.
    let at_rad = trig::atan2(dx, -dy).rem_euclid(std::f64::consts::TAU);
    if inside {
        // Going away, on a circle that comes back to the same distance.
        return r * (2.0 * at_rad).rem_euclid(std::f64::consts::TAU);
    }
    let cos =
        (r * r + from_centre_m * from_centre_m - radius_m * radius_m) / (2.0 * r * from_centre_m);
    if !(-1.0..1.0).contains(&cos) {
        return f64::INFINITY;
    }
    r * (at_rad - trig::acos(cos)).max(0.0)
}

#[cfg(test)]
#[path = "surroundings_tests.rs"]
pub(crate) mod tests;
