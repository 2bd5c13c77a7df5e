//! Answers with the poses of a file: an estimator that ran elsewhere is scored like
//! one that takes part.
//!
//! Source of the format: the TUM RGB-D benchmark (Sturm et al., IROS 2012), lines of
//! `timestamp tx ty tz qx qy qz qw`, as evo and `sim-server export tum` write them.
//! A pose belongs to the tick that is nearest in time, as in evo (`--t_max_diff`).
//!
//! Departures: poses are planar, so z, roll and pitch are dropped. Six more numbers in
//! a line are the covariance in the frame of the poses: xx, xy, xθ, yy, yθ, θθ (m², m·rad,
//! rad²); `sim-server import trajectory` writes them where a recording has them.

use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::Matrix3;
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Estimate, Reply, errln, input};
use rusty_geometry::{SE2, trig};

use crate::motion::carried;
use crate::numbers::{number, seconds};
use crate::tangent;

/// Longest file that is read, bytes: some five million poses.
const MAX_BYTES: u64 = 1 << 30;
/// Longest offset, s: stamps that carry the time of day differ by 2·10⁹ from those of a run.
const MOST_OFFSET_S: f64 = 1e10;
/// The farthest pose, m: farther than any place on Earth. Figures square it.
const MOST_COORDINATE_M: f64 = 1e8;

/// Answer with the poses of a file in TUM format
///
/// Each line has `timestamp tx ty tz qx qy qz qw`: seconds, metres, a quaternion. Six more
/// numbers are the covariance in the frame of the poses (xx xy xθ yy yθ θθ). At a
/// tick, the estimate is the pose that is nearest in time; without one within --t-max-diff the
/// program abstains. So an estimator that ran elsewhere is scored on a log:
///
///     sim-server import trajectory bag --topic /amcl_pose -o amcl.tum
///     sim-server replay run.log --add amcl="trajectory amcl.tum"
#[derive(Args, Clone, Debug)]
#[command(verbatim_doc_comment)]
pub struct Options {
    /// Trajectory to read
    #[arg(value_name = "FILE")]
    pub file: PathBuf,

    /// Longest time between a tick and its pose, s
    #[arg(long, value_name = "SECONDS", default_value_t = 0.01, value_parser = seconds)]
    pub t_max_diff: f64,

    /// Time that is added to each timestamp of the file, s
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = offset)]
    pub t_offset: f64,
}

/// A difference of two times, s.
fn offset(text: &str) -> Result<f64, String> {
    number(text, |v| v.abs() <= MOST_OFFSET_S, "a time in seconds, at most 10^10 either way")
}

/// The poses of a file, by time.
pub struct Trajectory {
    options: Options,
    /// Time of the run, s, and the estimate; times ascend.
    poses: Vec<(f64, Estimate)>,
    /// Ticks, and those with a pose.
    ticks: u64,
    matched: u64,
    /// First and last time of a tick, s.
    times_s: Option<(f64, f64)>,
}

impl Trajectory {
    /// Reads the file of `options`.
    ///
    /// # Errors
    /// [`ClientError::Unusable`] names file, line, value and remedy.
    pub fn read(options: Options) -> Result<Self, ClientError> {
        let path = &options.file;
        let text = input::read_text_at_most(path, MAX_BYTES)
            .map_err(|error| unusable(path, format!("{error}; give a trajectory in TUM format")))?;
        let mut poses = Vec::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let (time_s, estimate) = parse(line)
                .map_err(|problem| unusable(path, format!("line {number}: {problem}")))?;
            poses.push((time_s + options.t_offset, estimate));
        }
        if poses.is_empty() {
            let problem = "no pose; give lines of `timestamp tx ty tz qx qy qz qw`";
            return Err(unusable(path, problem.to_owned()));
        }
        // The sort is stable, and of one stamp the last line holds.
        poses.sort_by(|a, b| a.0.total_cmp(&b.0));
        poses.dedup_by(|next, kept| {
            let is_same = next.0 == kept.0;
            if is_same {
                *kept = *next;
            }
            is_same
        });
        Ok(Self { options, poses, ticks: 0, matched: 0, times_s: None })
    }

    /// The estimate that is nearest to a time, s, if one is near enough; of two that are
    /// equally near, the earlier.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<&Estimate> {
        let after = self.poses.partition_point(|(at_s, _)| *at_s < time_s);
        let around = self.poses[after.saturating_sub(1)..].iter().take(2);
        let far_s = |pose: &&(f64, Estimate)| (pose.0 - time_s).abs();
        let (nearest_s, estimate) =
            around.min_by(|a, b| far_s(a).total_cmp(&far_s(b))).map(|(at_s, e)| (*at_s, e))?;
        ((nearest_s - time_s).abs() <= self.options.t_max_diff).then_some(estimate)
    }
}

impl Filter for Trajectory {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        let time_s = tick.time_s();
        let found = self.at(time_s).copied();
        self.ticks += 1;
        self.matched += u64::from(found.is_some());
        self.times_s = Some((self.times_s.map_or(time_s, |(first_s, _)| first_s), time_s));
        found.map_or(Reply::Abstain, Reply::Estimate)
    }

    /// Says how many ticks have a pose.
    fn finish(self) -> Result<(), ClientError> {
        let Self { options, poses, ticks, matched, times_s } = self;
        let path = &options.file;
        if let (0, Some((from_s, to_s))) = (matched, times_s) {
            let [first_s, last_s] = [poses.first(), poses.last()].map(|p| p.map_or(0.0, |p| p.0));
            let problem = format!(
                "no pose is within {} s of a tick: the poses are from {first_s:?} to {last_s:?} s, the \
                 ticks from {from_s:?} to {to_s:?} s; shift them with --t-offset or widen --t-max-diff",
                options.t_max_diff
            );
            return Err(unusable(path, problem));
        }
        errln!(
            "trajectory: {matched} of {ticks} ticks have one of the {} poses of {} within {} s",
            poses.len(),
            path.display(),
            options.t_max_diff
        );
        Ok(())
    }
}

fn unusable(path: &Path, problem: String) -> ClientError {
    ClientError::Unusable(format!("{}: {problem}", path.display()))
}

/// The time, s, and the estimate of a line.
fn parse(line: &str) -> Result<(f64, Estimate), String> {
    let words: Vec<&str> = line.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
    let mut numbers = [0.0; 14];
    if words.len() != 8 && words.len() != 14 {
        return Err(format!(
            "expected 8 numbers (timestamp tx ty tz qx qy qz qw), or 14 with a covariance, got {}; \
             convert the file to TUM format",
            words.len()
        ));
    }
    for ((number, word), name) in numbers.iter_mut().zip(&words).zip(COLUMNS) {
        *number = word.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
            let word: String = word.chars().take(40).collect();
            format!("{name} = {word:?} is not a finite number; mend the line")
        })?;
    }
    let [time_s, x_m, y_m, _, qx, qy, qz, qw, covariance @ ..] = numbers;
    if x_m.abs().max(y_m.abs()) > MOST_COORDINATE_M {
        return Err(format!(
            "tx = {x_m}, ty = {y_m} is farther than {MOST_COORDINATE_M} m away; take the origin of \
             the file off"
        ));
    }
    let squared = qw * qw + qx * qx + qy * qy + qz * qz;
    // Files round to a few digits.
    if (squared - 1.0).abs() > 0.05 {
        let text = format!(
            "the quaternion ({qx}, {qy}, {qz}, {qw}) has the length {:.3}, not 1; the order is qx qy \
             qz qw",
            squared.sqrt()
        );
        return Err(text);
    }
    let yaw_rad = trig::atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz);
    let pose = SE2::new(x_m, y_m, yaw_rad);
    if words.len() == 8 {
        return Ok((time_s, Estimate::new(pose)));
    }
    let [xx, xy, xt, yy, yt, tt] = covariance;
    if let Some(negative) = [xx, yy, tt].into_iter().find(|variance| *variance < 0.0) {
        return Err(format!(
            "a variance is {negative}; the last six numbers are xx xy xθ yy yθ θθ"
        ));
    }
    let world = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
    let body = tangent::symmetric(&carried(&world, &SE2::new(0.0, 0.0, yaw_rad)));
    Ok((time_s, tangent::estimate(&pose, &body)))
}

/// The numbers of a line.
const COLUMNS: [&str; 14] = [
    "timestamp",
    "tx",
    "ty",
    "tz",
    "qx",
    "qy",
    "qz",
    "qw",
    "covariance xx",
    "covariance xy",
    "covariance xθ",
    "covariance yy",
    "covariance yθ",
    "covariance θθ",
];

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use rusty_contract::tum::line;

    use super::*;

    fn read(text: &str) -> Result<Trajectory, ClientError> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.tum");
        std::fs::write(&file, text).unwrap();
        Trajectory::read(Options { file, t_max_diff: 0.01, t_offset: 0.0 })
    }

    #[test]
    fn the_nearest_pose_within_the_limit_is_the_answer() {
        let text =
            "\u{feff}# time x y z q\n2.00 2 0 0 0 0 0 1\n1.00 1 0 0 0 0 0 1\n1.015 9 0 0 0 0 0 1\n";
        let trajectory = read(text).unwrap();
        let x_m = |time_s: f64| trajectory.at(time_s).map(|e| e.pose_in_world.x());
        assert_eq!(x_m(1.0), Some(1.0));
        assert_eq!(x_m(1.007), Some(1.0));
        assert_eq!(x_m(1.008), Some(9.0));
        assert_eq!(x_m(0.991), Some(1.0));
        assert_eq!(x_m(0.989), None);
        assert_eq!(x_m(1.5), None);
        assert_eq!(x_m(2.009), Some(2.0));
        assert_eq!(x_m(2.011), None);
    }

    #[test]
    fn a_line_reads_back() {
        let pose = SE2::new(-1.25, 1e-17, -3.1);
        let (time_s, estimate) = parse(&line(0.1 + 0.2, &pose)).unwrap();
        assert_eq!(time_s, 0.1 + 0.2);
        assert_eq!(estimate.pose_in_world.translation(), pose.translation());
        assert!((estimate.pose_in_world.theta() - pose.theta()).abs() < 1e-15);
    }

    #[test]
    fn of_one_stamp_the_last_line_holds() {
        let trajectory = read("1 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n").unwrap();
        assert_eq!(trajectory.at(1.0).unwrap().pose_in_world.x(), 2.0);
    }

    #[test]
    fn a_covariance_turns_from_the_world_into_the_body() {
        // Heading +y: what is along x in the world is along −y in the body.
        let half = trig::sin(0.5 * FRAC_PI_2);
        let line = format!("1 0 0 0 0 0 {half} {half} 4 0 0.5 1 0.25 0.01");
        let (_, estimate) = parse(&line).unwrap();
        assert!((estimate.pose_in_world.theta() - FRAC_PI_2).abs() < 1e-12);
        let found = Matrix3::from_row_slice(&estimate.covariance.unwrap());
        let expected = Matrix3::new(1.0, 0.0, 0.25, 0.0, 4.0, -0.5, 0.25, -0.5, 0.01);
        assert!((found - expected).norm() < 1e-12, "{found}");
    }

    #[test]
    fn a_line_that_is_no_pose_is_named() {
        let cases = [
            ("1 2 3\n", ["line 1", "8 numbers"]),
            ("\n1 0 0 0 0 0 0 1\n2 0 x 0 0 0 0 1\n", ["line 3", "ty = \"x\""]),
            ("1 0 0 0 0 0 0 nan\n", ["line 1", "qw"]),
            ("1 0 0 0 1 0 0 1\n", ["line 1", "length 1.414"]),
            ("1 0 0 0 0 0 0 1 1 0 0 -2 0 1\n", ["line 1", "variance is -2"]),
            ("# nothing\n", ["a.tum", "no pose"]),
        ];
        for (text, wanted) in cases {
            let error = read(text).err().unwrap().to_string();
            assert!(wanted.iter().all(|wanted| error.contains(wanted)), "{error}");
        }
    }
}
