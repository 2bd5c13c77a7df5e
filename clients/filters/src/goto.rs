//! A driver with a floor plan, to a list of waypoints.
//!
//! The plan becomes cells, ways are found over them ([`crate::planning`]) and
//! followed ([`crate::pilot`]) by pure pursuit or in the dynamic window. They are pieces of
//! straight lines, or curves like those of a car. The pose comes from an EKF.

use std::str::FromStr;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use rusty_clients::ClientError;
use rusty_contract::{Start, errln};
use rusty_geometry::Twist;

pub use self::plan::GotoError;
use self::plan::Plan;
use crate::driver::{Driver, Known, Task};
use crate::dynamic_window::{Acceleration, DynamicWindow};
use crate::ekf::{self, Ekf};
use crate::numbers::positive;
use crate::pilot::{Local, Pilot, Progress};
use crate::surroundings::Caution;

/// So often a way to a waypoint is planned anew before it is given up.
const TRIES: u32 = 5;

/// A place to go to, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// m.
    pub x_m: f64,
    /// m.
    pub y_m: f64,
    /// Heading at the end, rad; any where none is given.
    pub heading_rad: Option<f64>,
}

impl FromStr for Waypoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| word.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
        match numbers.as_deref() {
            Some(&[x_m, y_m]) => Ok(Self { x_m, y_m, heading_rad: None }),
            Some(&[x_m, y_m, heading_rad]) => Ok(Self { x_m, y_m, heading_rad: Some(heading_rad) }),
            _ => {
                Err("give x and y in metres, 5.4,7, and a heading in rad if it matters: 5.4,7,1.57"
                    .to_owned())
            }
        }
    }
}

/// How ways are planned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Planner {
    /// Shortest ways over cells, with turns on the spot
    #[default]
    Dijkstra,
    /// Curves of a least radius, forwards and in reverse
    HybridAStar,
}

/// What the curves of `--planner hybrid-a-star` may be like.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Hybrid A*")]
pub struct Turning {
    /// Minimum turning radius, m
    #[arg(requires = "planner")]
    #[arg(long, value_name = "METRES", default_value_t = 0.3, value_parser = positive)]
    pub turning_radius_m: f64,

    /// Cost of a metre in reverse, in metres forwards
    #[arg(requires = "planner")]
    #[arg(long, value_name = "FACTOR", default_value_t = 2.0, value_parser = positive)]
    pub reverse_cost: f64,

    /// Cost of a change of direction, m
    #[arg(requires = "planner")]
    #[arg(long, value_name = "METRES", default_value_t = 0.3, value_parser = positive)]
    pub switch_cost_m: f64,
}

/// Drive to a list of waypoints on a floor plan
///
/// The driver uses its own pose estimate (an EKF on straight walls, like `ekf`). The
/// default waypoints are the middle of every room of the Apartment and back. It sends
/// no command that could touch, before the next scan, a wall that its laser has hit, and
/// none at all while its EKF abstains.
/// It does not see walls between the beams, and it assumes that commands take effect
/// within the time of one scan. With --planner hybrid-a-star it drives like a car: it never
/// turns on the spot, and reverses where that is cheaper. At the end it prints the number
/// of waypoints reached and of ticks used. The scenario needs a script of kind "driver";
/// the role is driver.
#[derive(Args, Clone, Debug)]
// A program that flattens these next to those of a filter has two of this name.
#[group(skip)]
pub struct Options {
    /// Waypoint in the world frame, m, repeatable; --planner hybrid-a-star also takes the
    /// heading there, rad
    #[arg(long = "waypoint", value_name = "X,Y[,HEADING]", allow_hyphen_values = true)]
    pub waypoints: Vec<Waypoint>,

    /// Distance at which a waypoint counts as reached, m
    #[arg(long, value_name = "METRES", default_value_t = 0.15, value_parser = positive)]
    pub within_m: f64,

    /// Preferred distance from walls, m
    #[arg(long, value_name = "METRES", default_value_t = 0.5, value_parser = positive)]
    pub liked_m: f64,

    /// End the run at the last waypoint
    #[arg(long)]
    pub end: bool,

    /// Side of a cell for path planning, m
    #[arg(long, value_name = "METRES", default_value_t = 0.05, value_parser = positive)]
    pub cell_m: f64,

    /// How ways are planned
    #[arg(long, value_enum, default_value_t = Planner::Dijkstra)]
    pub planner: Planner,

    /// How a way is followed
    #[arg(long, value_enum, default_value_t = Local::Pursuit)]
    pub local: Local,

    /// What a curve may be like.
    #[command(flatten)]
    pub turning: Turning,

    /// How fast it changes its motion.
    #[command(flatten)]
    pub acceleration: Acceleration,

    /// How careful it is.
    #[command(flatten)]
    pub caution: Caution,

    /// The filter.
    #[command(flatten)]
    pub ekf: ekf::Options,
}

crate::numbers::default_of_command_line!(Options);

/// A plan, for the next run in which the same is told.
#[derive(Debug)]
pub struct Prepared {
    told: Start,
    plan: Arc<Plan>,
}

/// Goes from place to place.
#[derive(Debug)]
pub struct Goto {
    plan: Arc<Plan>,
    within_m: f64,
    next: usize,
    /// Whether there is a way to the next one, and how often it was planned.
    planned: bool,
    tries: u32,
    missed: usize,
    /// When it was done.
    done_at: Option<u64>,
    /// Whether the run ends then.
    end: bool,
}

/// Makes a driver to waypoints.
///
/// # Errors
/// [`GotoError`], as text: no map, no pose, no waypoint, no way there; or the
/// filter's.
pub fn driver(start: &Start, options: Options) -> Result<Driver<Ekf, Goto>, ClientError> {
    next_driver(start, options, &mut None)
}

/// Makes a driver to waypoints, whose plan takes long to make: that of `prepared` is taken
/// where all is told that was told then, and kept there for the next run. The options are
/// those of then.
///
/// # Errors
/// As [`driver`].
pub fn next_driver(
    start: &Start,
    options: Options,
    prepared: &mut Option<Prepared>,
) -> Result<Driver<Ekf, Goto>, ClientError> {
    let told = start.without_run();
    let plan = match prepared.take().filter(|known| known.told == told) {
        Some(known) => known.plan,
        None => {
            let plan = Plan::new(start, &options);
            Arc::new(plan.map_err(|e| ClientError::Unusable(e.to_string()))?)
        }
    };
    *prepared = Some(Prepared { told, plan: Arc::clone(&plan) });
    let (within_m, end) = (options.within_m, options.end);
    let done_at = None;
    let task = Goto { plan, within_m, next: 0, planned: false, tries: 0, missed: 0, done_at, end };
    let mut driver = Driver::new(start, &options.caution, Ekf::new(start, &options.ekf)?, task);
    if options.local == Local::Dwa {
        driver.pilot.use_window(DynamicWindow::new(options.acceleration));
    }
    Ok(driver)
}

impl Goto {
    fn go_on(&mut self, ticks: u64) {
        (self.next, self.planned, self.tries) = (self.next + 1, false, 0);
        if self.next == self.plan.waypoints.len() {
            self.done_at = Some(ticks);
        }
    }

    /// How many waypoints it believes to have been at.
    pub fn reached(&self) -> usize {
        self.next - self.missed
    }

    /// In which tick it was done, from 1.
    pub fn done_at(&self) -> Option<u64> {
        self.done_at
    }
}

impl Task<Ekf> for Goto {
    const NEEDS_POSE: bool = true;

    fn command(&mut self, pilot: &mut Pilot, known: &Known<'_, Ekf>) -> Twist {
        let pose = &known.pose_in_world;
        if self.next == self.plan.waypoints.len() {
            return Twist::default();
        }
        if !self.planned {
            self.plan.begin(self.next, pilot, pose, self.tries > 0);
            (self.planned, self.tries) = (true, self.tries + 1);
        }
        let (command, progress) = pilot.command(pose, self.within_m);
        match progress {
            Progress::Under => {}
            Progress::Arrived => self.go_on(pilot.around().tick_count()),
            Progress::Stuck | Progress::NoWay if self.tries < TRIES => self.planned = false,
            Progress::Stuck | Progress::NoWay => {
                self.missed += 1;
                self.go_on(pilot.around().tick_count());
            }
        }
        command
    }

    /// Plans anew from where it turned out to be; the way before does not count as a try.
    fn relocated(&mut self) {
        (self.planned, self.tries) = (false, self.tries.saturating_sub(1));
    }

    fn is_done(&self) -> bool {
        self.end && self.done_at.is_some()
    }

    /// Prints how many waypoints were reached.
    fn finish(self, name: &str, pilot: &Pilot, _: &Ekf) -> Result<(), ClientError> {
        let (reached, all) = (self.reached(), self.plan.waypoints.len());
        let (when, remark) = (pilot.when(self.done_at), pilot.around().remark());
        errln!("{name}: {reached} of {all} waypoints, {when}{remark}");
        Ok(())
    }
}

mod plan;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surroundings::tests::start;
    use rusty_geometry::{SE2, apartment, hallway};

    fn begin(told: &Start, waypoints: &[&str]) -> Result<usize, String> {
        let waypoints = waypoints.iter().map(|w| w.parse().unwrap()).collect();
        let options = Options { waypoints, ..Options::default() };
        let begun = driver(told, options);
        begun.map(|driver| driver.task.plan.waypoints.len()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_plan_serves_the_next_run_in_which_the_same_is_told() {
        let mut prepared = None;
        let mut plan =
            |told: &Start| next_driver(told, Options::default(), &mut prepared).unwrap().task.plan;
        let told = start(&apartment(), SE2::new(6.0, 4.5, 0.0));
        let first = plan(&told);
        let next = plan(&Start { run_id: 9, run_number: 1, ticket: 3, ..told });
        assert!(Arc::ptr_eq(&first, &next));
        let elsewhere = plan(&start(&apartment(), SE2::new(6.0, 4.6, 0.0)));
        assert!(!Arc::ptr_eq(&first, &elsewhere));
        assert_ne!(first.waypoints, elsewhere.waypoints);
    }

    #[test]
    fn curves_are_checked_before_the_run() {
        let told = start(&apartment(), SE2::new(6.0, 4.5, 0.0));
        let begin = |waypoint: &str, options: Options| {
            let options = Options { waypoints: vec![waypoint.parse().unwrap()], ..options };
            driver(&told, options).map(|_| ()).map_err(|e| e.to_string())
        };
        let curves = Options { planner: Planner::HybridAStar, ..Options::default() };
        assert_eq!(begin("5.4,7,-1.6", curves.clone()), Ok(()));
        let why = begin("5.4,7,-1.6", Options::default()).unwrap_err();
        assert!(why.contains("waypoint 1 has a heading"), "{why}");
        let why = begin("5.4,7", Options { local: Local::Dwa, ..curves.clone() }).unwrap_err();
        assert!(why.contains("--local dwa"), "{why}");
        let turning = Turning { turning_radius_m: 20.0, ..curves.turning };
        let why = begin("5.4,7,-1.6", Options { turning, ..curves }).unwrap_err();
        assert!(why.contains("turning radius of 20 m"), "{why}");
    }

    #[test]
    fn what_a_curve_may_be_like_needs_a_planner() {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            options: Options,
        }
        let parse = |words: &[&str]| {
            let words = ["goto", "--turning-radius-m", "1"].iter().chain(words);
            <Line as clap::Parser>::try_parse_from(words).map(|line| line.options)
        };
        let refused = parse(&[]).unwrap_err();
        assert_eq!(refused.kind(), clap::error::ErrorKind::MissingRequiredArgument, "{refused}");
        let options = parse(&["--planner", "hybrid-a-star"]).unwrap();
        assert_eq!(options.turning.turning_radius_m, 1.0);
    }

    #[test]
    fn who_cannot_begin_says_why() {
        let told = start(&apartment(), SE2::new(6.0, 4.5, 0.0));
        assert_eq!(begin(&told, &[]), Ok(6));
        assert_eq!(begin(&told, &["9.6,4.5", "1, 7"]), Ok(2));
        let why = begin(&told, &["9.6,4.5", "3.2,8.7"]).unwrap_err();
        assert!(why.starts_with("waypoint 2 (3.2, 8.7) cannot be reached"), "{why}");
        let why = begin(&Start { map: None, ..told.clone() }, &[]).unwrap_err();
        assert!(why.contains("no map") && why.contains("map = \"given\""), "{why}");
        let why = begin(&Start { initial_pose: None, ..told.clone() }, &[]).unwrap_err();
        assert!(why.contains("initial_pose = \"given\""), "{why}");
        let why = begin(&start(&hallway(), SE2::new(1.0, 0.8, 0.0)), &[]).unwrap_err();
        assert!(why.contains("no tour of \"hallway\"") && why.contains("--waypoint"), "{why}");
        let options = Options { cell_m: 0.001, ..Options::default() };
        let why = driver(&told, options).unwrap_err().to_string();
        assert!(
            why.contains("12 m × 9 m in cells of 0.001 m") && why.contains("--cell-m"),
            "{why}"
        );
        let why = begin(&start(&apartment(), SE2::new(-5.0, 4.5, 0.0)), &[]).unwrap_err();
        assert!(why.contains("starts at (-5, 4.5)"), "{why}");
        for text in ["5", "a,b", "1,nan", "1,2,3,4", "1,2,inf"] {
            assert!(text.parse::<Waypoint>().is_err(), "{text}");
        }
    }
}
