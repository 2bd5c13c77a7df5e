//! What every driver with an aim has in common: a way that it follows, and eyes
//! for what is in it.
//!
//! The way is followed by pure pursuit ([`crate::pursuit`]), or by the dynamic window
//! approach ([`crate::dynamic_window`]). In pure pursuit, where the circle to
//! the next aim is not clear, because the believed pose is off or the map is not
//! what stands there, the robot turns to a free direction near the aim instead
//! ([`crate::steering`]). Curves are followed without turns on the spot
//! ([`crate::curve_pursuit`]). Whatever the result is, it is made admissible
//! ([`crate::surroundings`]).

use clap::ValueEnum;
use nalgebra::Point2;
use rusty_contract::Start;
use rusty_geometry::{EncoderCounts, SE2, Twist, wrap_angle};

use crate::curve_pursuit::{CurvePursuit, pursue_curve};
use crate::dynamic_window::DynamicWindow;
use crate::planning::Curve;
use crate::pursuit::{Aim, Pursuit, pursue};
use crate::steering::{NEED_M, free_direction, steer};
use crate::surroundings::{Caution, Surroundings};

/// A command of which less than this share is admissible asks for another way.
const HINDERED: f64 = 0.5;

/// A detour goes this far, m, or takes this long, s, before the aim is looked for
/// again: who looks sooner turns to and fro before the same corner.
const DETOUR_M: f64 = 0.15;
const DETOUR_S: f64 = 2.0;

/// A robot that gets no farther along than this in [`STUCK_S`] is stuck, m.
const PROGRESS_M: f64 = 0.05;
/// On ways that are planned anew all the time, this far from where it last got on, m:
/// more than a detour takes it to and fro.
const ELSEWHERE_M: f64 = DETOUR_M + PROGRESS_M;
const STUCK_S: f64 = 6.0;

/// How a way is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Local {
    /// Pure pursuit, with a detour where the way is blocked
    #[default]
    Pursuit,
    /// Dynamic window approach
    Dwa,
}

/// Follows ways.
#[derive(Clone, Debug)]
pub struct Pilot {
    around: Surroundings,
    caution: Caution,
    dt_s: f64,
    way: Option<Pursuit>,
    /// In place of a way.
    curve: Option<CurvePursuit>,
    window: Option<DynamicWindow>,
    /// Whether the window was asked since the last tick.
    asked: bool,
    detour: Option<Detour>,
    /// How far along it was when it last got on, where that was (odometry frame),
    /// and how many ticks ago.
    got_to_m: f64,
    got_to: SE2,
    waited_ticks: u64,
    /// Whether the way goes on from an earlier one.
    goes_on: bool,
}

/// A free direction that is kept for a while.
#[derive(Clone, Copy, Debug)]
struct Detour {
    /// Where it began, odometry frame.
    from: SE2,
    /// Heading in the odometry frame.
    course_rad: f64,
    ticks: u64,
}

/// What the way has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// There is none.
    NoWay,
    /// It is being followed.
    Under,
    /// The end is near.
    Arrived,
    /// The robot has not got on for a while.
    Stuck,
}

impl Pilot {
    /// Without a way.
    pub fn new(start: &Start, caution: &Caution) -> Self {
        Self {
            around: Surroundings::new(start, caution),
            caution: *caution,
            dt_s: start.dt_s,
            way: None,
            curve: None,
            window: None,
            asked: false,
            detour: None,
            got_to_m: 0.0,
            got_to: SE2::identity(),
            waited_ticks: 0,
            goes_on: false,
        }
    }

    /// Follows ways by the dynamic window approach from now on.
    pub fn use_window(&mut self, window: DynamicWindow) {
        self.window = Some(window);
    }

    /// Takes a tick: encoder counts and, if there is one, the scan at its end.
    pub fn tick(&mut self, ticks: EncoderCounts, ranges_m: Option<&[f64]>) {
        self.around.tick(ticks, ranges_m);
        if let Some(window) = self.window.as_mut().filter(|_| !self.asked) {
            window.stop();
        }
        self.asked = false;
    }

    /// Follows another way from now on; one without corners is none.
    pub fn follow(&mut self, corners: Vec<Point2<f64>>) {
        self.follow_on(corners);
        (self.got_to, self.waited_ticks, self.goes_on) = (self.around.pose_in_odometry(), 0, false);
        self.detour = None;
    }

    /// Follows a curve from now on, with a robot that turns on circles of `radius_m` or
    /// more.
    pub fn follow_curve(&mut self, curve: &Curve, radius_m: f64) {
        self.follow(Vec::new());
        self.curve = Some(CurvePursuit::new(curve, radius_m));
    }

    /// Goes on along another way to the same or another aim: a robot that has
    /// waited for long has still waited, and a detour goes on.
    pub fn follow_on(&mut self, corners: Vec<Point2<f64>>) {
        self.way = (!corners.is_empty()).then(|| Pursuit::new(corners));
        self.curve = None;
        (self.got_to_m, self.goes_on) = (0.0, true);
    }

    /// The obstacles around the robot.
    pub fn around(&self) -> &Surroundings {
        &self.around
    }

    /// Returns the ticks and the time until `done_at`, for the message at the end.
    pub(crate) fn when(&self, done_at: Option<u64>) -> String {
        let (word, ticks) = match done_at {
            Some(ticks) => ("done in", ticks),
            None => ("not done in", self.around.tick_count()),
        };
        format!("{word} {ticks} ticks ({:.1} s)", ticks as f64 * self.dt_s)
    }

    /// The command for the next tick, and what the way has come to, for a robot
    /// that believes to be here and has arrived `within_m` of the end.
    pub fn command(&mut self, pose_in_world: &SE2, within_m: f64) -> (Twist, Progress) {
        if self.curve.is_some() {
            return self.command_on_curve(pose_in_world, within_m);
        }
        let stand = Twist::default();
        let Some(aim) = self.way.as_mut().and_then(|way| way.aim(pose_in_world)) else {
            return (stand, Progress::NoWay);
        };
        if aim.left_m + aim.off_m < within_m {
            return (stand, Progress::Arrived);
        }
        let progress = self.progress(self.way.as_ref().map_or(0.0, Pursuit::done_m));
        (self.towards(&aim), progress)
    }

    /// The same on a curve, which is followed to its very end. A robot that has come off it
    /// by more than `within_m` is stuck.
    fn command_on_curve(&mut self, pose_in_world: &SE2, within_m: f64) -> (Twist, Progress) {
        let stand = Twist::default();
        let Some(curve) = &mut self.curve else { return (stand, Progress::NoWay) };
        let Some(aim) = curve.aim(pose_in_world) else { return (stand, Progress::Arrived) };
        if aim.off_m > within_m {
            return (stand, Progress::Stuck);
        }
        let done_m = curve.done_m();
        let given = self.around.limit(pursue_curve(&aim, &self.caution));
        (given, self.progress(done_m))
    }

    /// Whether the robot, which is so far along, has got on lately.
    fn progress(&mut self, done_m: f64) -> Progress {
        self.waited_ticks += 1;
        let here = self.around.pose_in_odometry();
        let moved_m = (here.translation() - self.got_to.translation()).norm();
        if done_m > self.got_to_m + PROGRESS_M && (!self.goes_on || moved_m > ELSEWHERE_M) {
            (self.got_to_m, self.got_to, self.waited_ticks) = (done_m, here, 0);
        }
        let stuck = self.waited_ticks as f64 * self.dt_s > STUCK_S;
        if stuck { Progress::Stuck } else { Progress::Under }
    }

    fn towards(&mut self, aim: &Aim) -> Twist {
        if let Some(window) = &mut self.window {
            self.asked = true;
            return window.command(&self.around, aim, &self.caution, self.dt_s);
        }
        if let Some(command) = self.on_detour() {
            return command;
        }
        let wanted = pursue(aim, &self.caution);
        let given = self.around.limit(wanted);
        if wanted.v_m_s == 0.0 || given.v_m_s >= HINDERED * wanted.v_m_s || !self.around.knows() {
            return given;
        }
        let need_m = aim.in_body.coords.norm().min(NEED_M);
        let (free_rad, clear_m) = free_direction(&self.around, aim.bearing_rad(), need_m);
        if clear_m <= 0.0 {
            return given;
        }
        let from = self.around.pose_in_odometry();
        let course_rad = from.theta() + free_rad;
        self.detour = Some(Detour { from, course_rad, ticks: 0 });
        self.on_detour().unwrap_or(given)
    }

    /// The command of a detour that is not over.
    fn on_detour(&mut self) -> Option<Twist> {
        let detour = self.detour.as_mut()?;
        let here = self.around.pose_in_odometry();
        let gone_m = (here.translation() - detour.from.translation()).norm();
        let off_rad = wrap_angle(detour.course_rad - here.theta());
        let given = steer(&self.around, off_rad, &self.caution);
        detour.ticks += 1;
        let late = detour.ticks as f64 * self.dt_s > DETOUR_S;
        let blocked = given == Twist::default();
        if gone_m > DETOUR_M || late || blocked {
            self.detour = None;
            return None;
        }
        Some(given)
    }
}
