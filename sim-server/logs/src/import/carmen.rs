//! One line of a CARMEN log.
//!
//! Source: the CARMEN logger's own header, which every log repeats in its
//! comments ("Logging Data and Playing It Back", CARMEN manual):
//!
//! ```text
//! message_name [message contents] ipc_timestamp ipc_hostname logger_timestamp
//! PARAM  param_name param_value
//! ODOM   x y theta tv rv accel
//! FLASER num_readings [range_readings] x y theta odom_x odom_y odom_theta
//! ```
//!
//! Metres, radians, seconds. Of the two stamps `ipc_timestamp`, the field
//! before the host's name, is the time of the measurement. Velocities are
//! checked to be numbers and not used.
//!
//! Departures: messages of other types are counted and skipped; so is
//! `RLASER`, a second laser that a run has no place for.

use rusty_contract::MAX_BEAMS;

use super::error::{ImportError, excerpt};

/// Farthest coordinate of a pose, metres: a world reaches 1000 km from its
/// origin, and needs room around the path.
const MAX_COORDINATE_M: f64 = 9e5;
/// x, y, theta, tv, rv, accel, stamp, host, stamp.
const ODOM_FIELDS: usize = 9;
/// All of a scan but its ranges: n, two poses, stamp, host, stamp.
const FLASER_FIXED_FIELDS: usize = 10;
const ODOM_FORM: &str = "x y theta tv rv accel stamp host stamp";
const FLASER_FORM: &str = "n, n ranges, x y theta odom_x odom_y odom_theta stamp host stamp";
/// Largest time, s: what a count of nanoseconds of 64 bits can hold.
const MAX_TIME_S: f64 = 1e10;
pub(super) const MEND: &str = "correct or delete the line";
// The message below says so.
const _: () = assert!(MAX_BEAMS == 1080);

/// x m, y m, theta rad, as they are in the file.
pub(super) type Triple = [f64; 3];

/// The two times of a message, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stamps {
    /// `ipc_timestamp`: when it was measured. Any bits in an `ODOM` line.
    pub(super) measured_s: f64,
    /// `logger_timestamp`: when it was written.
    pub(super) logged_s: f64,
}

/// Whether a stamp, s, is a time.
pub(super) fn is_time(stamp_s: f64) -> bool {
    stamp_s.abs() <= MAX_TIME_S
}

/// What a line says.
#[derive(Debug, PartialEq)]
pub(super) enum Message<'a> {
    /// Nothing: an empty line or a comment.
    Blank,
    /// A pose of the odometry.
    Odom { pose: Triple, stamps: Stamps },
    /// A scan; its ranges are in the buffer given to [`parse`].
    Flaser { pose: Triple, odometry: Triple, stamps: Stamps },
    /// A parameter of the robot.
    Param { name: &'a str, value: &'a str },
    /// Another type of message.
    Other(&'a str),
}

/// The fields of one message, taken in order.
pub(super) struct Fields<'a> {
    path: &'a str,
    line: u64,
    message: &'static str,
    words: std::str::SplitAsciiWhitespace<'a>,
    field: usize,
}

/// Reads a line. The ranges of a scan go to `ranges_m`, metres; +∞ is allowed
/// there and means that nothing came back.
pub(super) fn parse<'a>(
    path: &'a str,
    line: u64,
    text: &'a str,
    ranges_m: &mut Vec<f64>,
) -> Result<Message<'a>, ImportError> {
    let mut words = text.split_ascii_whitespace();
    let fields = |message, words| Fields { path, line, message, words, field: 0 };
    match words.next() {
        None => Ok(Message::Blank),
        Some(comment) if comment.starts_with('#') => Ok(Message::Blank),
        Some("ODOM") => fields("ODOM", words).odom(),
        Some("FLASER") => fields("FLASER", words).flaser(ranges_m),
        Some("PARAM") => match (words.next(), words.next()) {
            (Some(name), Some(value)) => Ok(Message::Param { name, value }),
            // A parameter without a value says nothing.
            _ => Ok(Message::Blank),
        },
        Some(other) => Ok(Message::Other(other)),
    }
}

impl<'a> Fields<'a> {
    fn odom(mut self) -> Result<Message<'a>, ImportError> {
        self.check_count(ODOM_FIELDS, ODOM_FORM)?;
        let pose = self.pose(["x", "y", "theta"])?;
        for name in ["tv", "rv", "accel"] {
            self.number(&name)?;
        }
        let stamps = self.stamps()?;
        Ok(Message::Odom { pose, stamps })
    }

    fn flaser(mut self, ranges_m: &mut Vec<f64>) -> Result<Message<'a>, ImportError> {
        ranges_m.clear();
        let beams = self.beams()?;
        self.check_count(FLASER_FIXED_FIELDS + beams, FLASER_FORM)?;
        for beam in 0..beams {
            let range_m = self.number(&format_args!("range of beam {beam}"))?;
            if range_m.is_nan() || range_m < 0.0 {
                let name = format!("range of beam {beam}");
                let problem = "is no distance";
                return Err(self.error(&name, &range_m.to_string(), problem, MEND));
            }
            ranges_m.push(range_m);
        }
        let pose = self.pose(["x", "y", "theta"])?;
        let odometry = self.pose(["odom_x", "odom_y", "odom_theta"])?;
        let stamps = self.stamps()?;
        if !is_time(stamps.measured_s) {
            // Two fields back: the stamp, then host and logger's stamp.
            self.field -= 2;
            let found = stamps.measured_s.to_string();
            return Err(self.error("stamp", &found, "is no time", MEND));
        }
        Ok(Message::Flaser { pose, odometry, stamps })
    }

    /// The number of beams, 1 to [`MAX_BEAMS`].
    fn beams(&mut self) -> Result<usize, ImportError> {
        let word = self.word();
        let problem = match word.parse::<usize>() {
            Ok(0) => "a scan has at least one beam",
            Ok(n) if n > MAX_BEAMS => "a scan has at most 1080 beams",
            Ok(n) => return Ok(n),
            Err(_) => "is no whole number",
        };
        Err(self.error("number of beams", word, problem, MEND))
    }

    /// Checks how many fields there are, the ones already taken included.
    fn check_count(&self, expected: usize, form: &'static str) -> Result<(), ImportError> {
        let found = self.field + self.words.clone().count();
        if found == expected {
            return Ok(());
        }
        let problem = format!(
            "{} has {found} fields after its name, {expected} are needed ({form}); the line is cut \
             off or mixed up: correct or delete it",
            self.message
        );
        Err(ImportError::line(self.path, self.line, problem))
    }

    fn word(&mut self) -> &'a str {
        self.field += 1;
        self.words.next().unwrap_or_default()
    }

    fn number(&mut self, name: &dyn std::fmt::Display) -> Result<f64, ImportError> {
        let word = self.word();
        word.parse().map_err(|_| self.error(&name.to_string(), word, "is no number", MEND))
    }

    fn pose(&mut self, names: [&'static str; 3]) -> Result<Triple, ImportError> {
        let mut pose = [0.0; 3];
        for (i, (place, name)) in pose.iter_mut().zip(names).enumerate() {
            let value = self.number(&name)?;
            let problem = if !value.is_finite() {
                "is not finite"
            } else if i < 2 && value.abs() > MAX_COORDINATE_M {
                "lies more than 900 km out"
            } else {
                *place = value;
                continue;
            };
            let remedy = "correct or delete the line, or shift the log's origin (metres, radians)";
            return Err(self.error(name, &value.to_string(), problem, remedy));
        }
        Ok(pose)
    }

    fn stamps(&mut self) -> Result<Stamps, ImportError> {
        let measured_s = self.number(&"stamp")?;
        self.word();
        let logged_s = self.number(&"logger's stamp")?;
        Ok(Stamps { measured_s, logged_s })
    }

    fn error(&self, name: &str, found: &str, problem: &str, remedy: &str) -> ImportError {
        let (message, field, found) = (self.message, self.field, excerpt(found));
        let problem = format!("{message} field {field} ({name}) = {found:?}: {problem}; {remedy}");
        ImportError::line(self.path, self.line, problem)
    }
}
