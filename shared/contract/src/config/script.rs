//! Where the commands come from.

use rusty_geometry::Twist;
use serde::{Deserialize, Serialize};

use super::{FieldError, seconds, within};

/// The most commands a list may have.
pub const MAX_COMMANDS: usize = 1_000_000;

/// Where the commands of a run come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ScriptConfig {
    /// Up and down a corridor, open loop, without the robot's pose.
    Patrol(PatrolConfig),
    /// The same, steered by the server on the true pose, so that the robot
    /// stays in the corridor. The commands go into frame and log, so everyone
    /// who sees them can compute the true pose.
    TruthSteeredPatrol(PatrolConfig),
    /// Left circle, right circle, and again.
    FigureEight {
        /// Forward speed, m/s.
        #[serde(default = "default_eight_v")]
        v_m_s: f64,
        /// Turn rate of the left circle, rad/s; the right one has the opposite.
        #[serde(default = "default_eight_omega")]
        omega_rad_s: f64,
        /// Time for one circle, s.
        #[serde(default = "default_eight_half")]
        half_s: f64,
    },
    /// Straight ahead.
    Straight {
        /// Forward speed, m/s.
        v_m_s: f64,
    },
    /// One command per tick, read from a file; when they are used up the robot
    /// stands.
    Commands {
        /// The file: a line per command, `v_m_s omega_rad_s [ticks]`, `#` for
        /// remarks. Relative to the scenario's folder.
        #[serde(default)]
        file: Option<String>,
        /// The commands themselves; filled from `file` when the run is set up.
        #[serde(default)]
        list: Vec<Twist>,
    },
    /// The answers of the participant with role `driver` are the commands: its
    /// answer to tick t moves the robot in tick t + 1. In tick 0 it stands.
    Driver {},
}

/// The patrol's numbers. Times are rounded to whole ticks of the run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PatrolConfig {
    /// Cruising speed, m/s.
    pub v_m_s: f64,
    /// Turn rate while turning in place, rad/s.
    pub omega_rad_s: f64,
    /// Time to reach and to leave the cruising speed, s.
    pub ramp_s: f64,
    /// Length of the first straight, s.
    pub first_s: f64,
    /// Length of every further straight, s.
    pub leg_s: f64,
    /// Stand before each turn, s.
    pub pause_s: f64,
    /// Length of each turn, s.
    pub turn_s: f64,
}

impl Default for PatrolConfig {
    /// Script G: 23, 123, 3, 10 and 6 ticks at dt = 0.1 s.
    fn default() -> Self {
        Self {
            v_m_s: 0.57,
            omega_rad_s: -3.1363,
            ramp_s: 0.6,
            first_s: 2.3,
            leg_s: 12.3,
            pause_s: 0.3,
            turn_s: 1.0,
        }
    }
}

fn default_eight_v() -> f64 {
    0.5
}
fn default_eight_omega() -> f64 {
    0.6
}
fn default_eight_half() -> f64 {
    10.48
}

impl Default for ScriptConfig {
    /// The patrol of the Apartment's corridor. Its straights are so short that
    /// slip of 2 % does not drive the robot into a wall within 30 s.
    fn default() -> Self {
        Self::Patrol(PatrolConfig { leg_s: 8.3, ..PatrolConfig::default() })
    }
}

impl PatrolConfig {
    fn check(&self) -> Result<(), FieldError> {
        within("script.v_m_s", self.v_m_s, -100.0, 100.0)?;
        within("script.omega_rad_s", self.omega_rad_s, -1e3, 1e3)?;
        within("script.ramp_s", self.ramp_s, 0.0, 3600.0)?;
        within("script.first_s", self.first_s, 0.0, 86_400.0)?;
        seconds("script.leg_s", self.leg_s)?;
        within("script.pause_s", self.pause_s, 0.0, 86_400.0)?;
        within("script.turn_s", self.turn_s, 0.0, 86_400.0)
    }
}

impl ScriptConfig {
    /// Name of the kind, as in the scenario file.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Patrol(_) => "patrol",
            Self::TruthSteeredPatrol(_) => "truth-steered-patrol",
            Self::FigureEight { .. } => "figure-eight",
            Self::Straight { .. } => "straight",
            Self::Commands { .. } => "commands",
            Self::Driver {} => "driver",
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        match self {
            Self::Patrol(p) | Self::TruthSteeredPatrol(p) => p.check(),
            Self::FigureEight { v_m_s, omega_rad_s, half_s } => {
                within("script.v_m_s", *v_m_s, -100.0, 100.0)?;
                within("script.omega_rad_s", *omega_rad_s, -1e3, 1e3)?;
                seconds("script.half_s", *half_s)
            }
            Self::Straight { v_m_s } => within("script.v_m_s", *v_m_s, -100.0, 100.0),
            Self::Commands { list, .. } => {
                let mut commands = (0..).zip(list);
                commands.try_for_each(|(tick, command)| Self::check_command(tick, *command))
            }
            Self::Driver {} => Ok(()),
        }
    }

    /// Whether a participant gives the commands.
    #[must_use]
    pub fn is_driver(&self) -> bool {
        matches!(self, Self::Driver {})
    }

    /// Checks the command of a tick, body frame, as part of a list.
    ///
    /// # Errors
    /// [`FieldError`] names the first number that cannot be used.
    pub fn check_command(tick: u64, command: Twist) -> Result<(), FieldError> {
        Self::check_speeds(command, |name| format!("script.list[{tick}].{name}"))
    }

    fn check_speeds(command: Twist, field: impl Fn(&str) -> String) -> Result<(), FieldError> {
        // A name is made for those that are refused only: there may be a million.
        let bounded = [("v_m_s", command.v_m_s, 100.0), ("omega_rad_s", command.omega_rad_s, 1e3)];
        let mut bad =
            bounded.into_iter().filter(|(_, value, most)| value.is_nan() || value.abs() > *most);
        bad.next().map_or(Ok(()), |(name, value, most)| within(&field(name), value, -most, most))
    }
}

/// Reads a list of commands: a line each, `v_m_s omega_rad_s [ticks]`. `file` is the name of
/// the file that has it.
///
/// # Errors
/// [`FieldError`] names file, line, text and form.
pub fn parse_commands(file: &str, text: &str) -> Result<Vec<Twist>, FieldError> {
    let mut list = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let body = line.split('#').next().unwrap_or_default().trim();
        if body.is_empty() {
            continue;
        }
        let place = format!("{file}, line {}", i + 1);
        let error = |problem: &str| {
            let remedy = "write `v_m_s omega_rad_s [ticks]`, e.g. `0.5 -0.2 100`";
            FieldError::new(&place, body, problem, remedy)
        };
        let words: Vec<&str> = body.split_whitespace().collect();
        let [v, omega, rest @ ..] = words.as_slice() else {
            return Err(error("has fewer than two numbers"));
        };
        let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
        let (Some(v_m_s), Some(omega_rad_s)) = (number(v), number(omega)) else {
            return Err(error("has a word that is no finite number"));
        };
        let command = Twist { v_m_s, omega_rad_s };
        ScriptConfig::check_speeds(command, |name| format!("{place}: {name}"))?;
        let times = match rest {
            [] => 1,
            [n] => n.parse::<usize>().map_err(|_| error("has no whole number of ticks"))?,
            _ => return Err(error("has more than three words")),
        };
        // Compared without a sum: any number may stand there.
        if times > MAX_COMMANDS - list.len() {
            return Err(error("makes the list longer than a million commands"));
        }
        list.extend(std::iter::repeat_n(command, times));
    }
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_commands_is_read_line_by_line() {
        let list = parse_commands("a.txt", "# start\n0.5 0 2\n\n 0.1 -0.2 # turn\n").unwrap();
        assert_eq!(list.len(), 3);
        assert_eq!(list[2], Twist { v_m_s: 0.1, omega_rad_s: -0.2 });
        for (text, why) in [
            ("0.5", "line 1 = 0.5: has fewer"),
            ("0 0\nNaN 0", "line 2 = NaN 0: has a word"),
            ("0 0 500\n101 0", "line 2: v_m_s = 101: is out of range"),
            ("0 0 -1", "no whole number"),
            ("0 0 1 1", "more than three"),
            ("0 0 1000001", "longer than a million"),
            ("0 0\n0 0 18446744073709551615", "line 2 = 0 0 18446744073709551615: makes the list"),
        ] {
            let error = parse_commands("a.txt", text).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
