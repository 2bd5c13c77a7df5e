//! What a reply means: an estimate, how sure it is, a command.
//!
//! A [`Reply`] has no separate bytes in shared memory
//! ([`Answer`](crate::Answer) has). In a log it is written by postcard as a
//! variant of `Stored`, whose order is part of the format: what came later is
//! at its end, so that every older log reads as it did.

use rusty_geometry::{SE2, Twist};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A pose that a filter believes in, and how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Believed pose of the body in the world frame.
    pub pose_in_world: SE2,
    /// Row-major 3×3 covariance of the error τ (m, m, rad) in the tangent
    /// space at the estimate: truth = estimate ⊞ τ. `None`: not reported.
    pub covariance: Option<[f64; 9]>,
    /// How surprising this tick's measurements were. `None`: not reported.
    pub innovation: Option<Innovation>,
}

/// How surprising measurements were: the normalised innovation squared (NIS)
/// νᵀ S⁻¹ ν of a filter's updates in one tick, ν being what was measured less
/// what was expected, and S the covariance of ν that the filter believes in.
/// Sums of several updates add up in both numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Innovation {
    /// νᵀ S⁻¹ ν, summed over the updates of the tick; at least 0.
    pub nis: f64,
    /// How many numbers were measured in them: what `nis` is on average for a
    /// filter that is right; at least 1.
    pub degrees: u32,
}

impl Estimate {
    /// A pose, and nothing said of how sure it is.
    #[must_use]
    pub fn new(pose_in_world: SE2) -> Self {
        Self { pose_in_world, covariance: None, innovation: None }
    }

    /// With the covariance of its error, see [`Estimate::covariance`].
    #[must_use]
    pub fn with_covariance(mut self, covariance: [f64; 9]) -> Self {
        self.covariance = Some(covariance);
        self
    }

    /// With the innovations of this tick, see [`Innovation`].
    #[must_use]
    pub fn with_innovation(mut self, nis: f64, degrees: u32) -> Self {
        self.innovation = Some(Innovation { nis, degrees });
        self
    }
}

impl From<SE2> for Estimate {
    fn from(pose_in_world: SE2) -> Self {
        Self::new(pose_in_world)
    }
}

/// What an answer means for the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stored", into = "Stored")]
pub enum Reply {
    /// No answer: the participant had been lost, and the run went on without it.
    #[default]
    Missing,
    /// The frame was read, and nothing is said about it.
    Abstain,
    /// The frame was taken (scorers, loggers, observers).
    Taken,
    /// An estimate.
    Estimate(Estimate),
    /// A command for the next tick.
    Command(Twist),
    /// An estimate and a command.
    Both(Estimate, Twist),
}

impl Reply {
    /// The estimate, if there is one.
    #[must_use]
    pub fn estimate(&self) -> Option<&Estimate> {
        match self {
            Self::Estimate(e) | Self::Both(e, _) => Some(e),
            _ => None,
        }
    }

    /// The command, if there is one.
    #[must_use]
    pub fn command(&self) -> Option<Twist> {
        match self {
            Self::Command(c) | Self::Both(_, c) => Some(*c),
            _ => None,
        }
    }

    /// Whether two replies are equal in every bit (`==` calls 0 and −0 equal,
    /// and no NaN equal to itself).
    #[must_use]
    pub fn same_bits(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other) && self.bits() == other.bits()
    }

    /// All numbers as bits, in a row of fixed length, after a word that says
    /// which there are.
    fn bits(&self) -> [u64; 17] {
        let mut row = [0; 17];
        if let Some(e) = self.estimate() {
            let p = e.pose_in_world;
            row[0] = 1 + u64::from(e.covariance.is_some()) + 2 * u64::from(e.innovation.is_some());
            if let Some(innovation) = &e.innovation {
                row[15] = innovation.nis.to_bits();
                row[16] = u64::from(innovation.degrees);
            }
            for (place, value) in row[1..4].iter_mut().zip([p.x(), p.y(), p.theta()]) {
                *place = value.to_bits();
            }
            for (place, value) in row[4..13].iter_mut().zip(e.covariance.iter().flatten()) {
                *place = value.to_bits();
            }
        }
        if let Some(c) = self.command() {
            row[13] = c.v_m_s.to_bits();
            row[14] = c.omega_rad_s.to_bits();
        }
        row
    }

    /// Checks every number.
    ///
    /// # Errors
    /// Names the first field that is not finite, a covariance whose diagonal is
    /// negative, or an innovation that cannot be one.
    pub fn check(&self) -> Result<(), AnswerError> {
        if let Some(e) = self.estimate() {
            let p = e.pose_in_world;
            finite("estimate x_m", p.x())?;
            finite("estimate y_m", p.y())?;
            finite("estimate theta_rad", p.theta())?;
            for (i, value) in e.covariance.iter().flatten().enumerate() {
                finite(COVARIANCE[i], *value)?;
                if i % 4 == 0 && *value < 0.0 {
                    return Err(AnswerError::NegativeVariance {
                        field: COVARIANCE[i],
                        value: *value,
                    });
                }
            }
            if let Some(innovation) = &e.innovation {
                innovation.check()?;
            }
        }
        if let Some(c) = self.command() {
            finite("command v_m_s", c.v_m_s)?;
            finite("command omega_rad_s", c.omega_rad_s)?;
        }
        Ok(())
    }
}

impl From<SE2> for Reply {
    fn from(pose_in_world: SE2) -> Self {
        Self::Estimate(pose_in_world.into())
    }
}

impl From<Estimate> for Reply {
    fn from(estimate: Estimate) -> Self {
        Self::Estimate(estimate)
    }
}

impl From<Twist> for Reply {
    fn from(command: Twist) -> Self {
        Self::Command(command)
    }
}

const COVARIANCE: [&str; 9] = [
    "covariance[0][0]",
    "covariance[0][1]",
    "covariance[0][2]",
    "covariance[1][0]",
    "covariance[1][1]",
    "covariance[1][2]",
    "covariance[2][0]",
    "covariance[2][1]",
    "covariance[2][2]",
];

fn finite(field: &'static str, value: f64) -> Result<(), AnswerError> {
    if value.is_finite() { Ok(()) } else { Err(AnswerError::NotFinite { field, value }) }
}

/// No scan has as many numbers.
const MOST_DEGREES: u32 = 1_000_000;

impl Innovation {
    fn check(&self) -> Result<(), AnswerError> {
        finite("innovation nis", self.nis)?;
        if self.nis < 0.0 || self.degrees == 0 || self.degrees > MOST_DEGREES {
            return Err(AnswerError::NoInnovation { nis: self.nis, degrees: self.degrees });
        }
        Ok(())
    }
}

/// A reply as a log has it.
#[derive(Clone, Copy, Serialize, Deserialize)]
enum Stored {
    Missing,
    Abstain,
    Taken,
    Estimate(StoredEstimate),
    Command(Twist),
    Both(StoredEstimate, Twist),
    EstimateAndInnovation(StoredEstimate, Innovation),
    BothAndInnovation(StoredEstimate, Innovation, Twist),
}

/// An estimate as a log has it: innovations stand behind it.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct StoredEstimate {
    pose_in_world: SE2,
    covariance: Option<[f64; 9]>,
}

impl From<Estimate> for StoredEstimate {
    fn from(Estimate { pose_in_world, covariance, .. }: Estimate) -> Self {
        Self { pose_in_world, covariance }
    }
}

impl StoredEstimate {
    fn with(self, innovation: Option<Innovation>) -> Estimate {
        let Self { pose_in_world, covariance } = self;
        Estimate { pose_in_world, covariance, innovation }
    }
}

impl From<Reply> for Stored {
    fn from(reply: Reply) -> Self {
        match reply {
            Reply::Missing => Self::Missing,
            Reply::Abstain => Self::Abstain,
            Reply::Taken => Self::Taken,
            Reply::Command(c) => Self::Command(c),
            Reply::Estimate(e) => match e.innovation {
                None => Self::Estimate(e.into()),
                Some(i) => Self::EstimateAndInnovation(e.into(), i),
            },
            Reply::Both(e, c) => match e.innovation {
                None => Self::Both(e.into(), c),
                Some(i) => Self::BothAndInnovation(e.into(), i, c),
            },
        }
    }
}

impl From<Stored> for Reply {
    fn from(stored: Stored) -> Self {
        match stored {
            Stored::Missing => Self::Missing,
            Stored::Abstain => Self::Abstain,
            Stored::Taken => Self::Taken,
            Stored::Estimate(e) => Self::Estimate(e.with(None)),
            Stored::Command(c) => Self::Command(c),
            Stored::Both(e, c) => Self::Both(e.with(None), c),
            Stored::EstimateAndInnovation(e, i) => Self::Estimate(e.with(Some(i))),
            Stored::BothAndInnovation(e, i, c) => Self::Both(e.with(Some(i)), c),
        }
    }
}

/// Why numbers that were given, or bytes that arrived, are no answer.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AnswerError {
    /// A number is NaN or infinite.
    #[error(
        "{field} is {value}; answer with finite numbers, or abstain on a tick without an estimate"
    )]
    NotFinite {
        /// Which number.
        field: &'static str,
        /// What it was.
        value: f64,
    },
    /// A variance is negative.
    #[error("{field} is {value}; a variance is at least 0: report none rather than a broken one")]
    NegativeVariance {
        /// Which number.
        field: &'static str,
        /// What it was.
        value: f64,
    },
    /// An innovation that cannot be one.
    #[error(
        "innovation nis {nis} of {degrees} degrees: report a sum of squares (at least 0) and how \
         many numbers were measured (1 to 1000000), or none in a tick without a measurement"
    )]
    NoInnovation {
        /// The normalised innovation squared.
        nis: f64,
        /// Its degrees of freedom.
        degrees: u32,
    },
    /// The kind is none of those in the table.
    #[error(
        "answer kind {0} is unknown (known: 0 to 7); build the client against this version of the contract"
    )]
    UnknownKind(u32),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose() -> SE2 {
        SE2::new(1.0, -2.0, 0.5)
    }

    fn bytes(reply: Reply) -> Vec<u8> {
        postcard::to_stdvec(&reply).unwrap()
    }

    #[test]
    fn a_log_of_before_reads_as_it_did() {
        // Variant, then its parts bare: what a derived encoding of pose and
        // covariance alone has always been.
        let command = Twist { v_m_s: 0.5, omega_rad_s: -1.0 };
        let plain = postcard::to_stdvec(&(3u32, pose(), None::<[f64; 9]>)).unwrap();
        assert_eq!(bytes(pose().into()), plain);
        let both = postcard::to_stdvec(&(5u32, pose(), Some([0.5; 9]), command)).unwrap();
        assert_eq!(
            bytes(Reply::Both(Estimate::new(pose()).with_covariance([0.5; 9]), command)),
            both
        );
        assert_eq!(bytes(Reply::Abstain), [1]);
    }

    #[test]
    fn innovations_survive_a_log() {
        let estimate = Estimate::new(pose()).with_covariance([0.5; 9]).with_innovation(2.5, 4);
        let command = Twist { v_m_s: 0.5, omega_rad_s: -1.0 };
        for reply in [Reply::Estimate(estimate), Reply::Both(estimate, command)] {
            let read: Reply = postcard::from_bytes(&bytes(reply)).unwrap();
            assert!(read.same_bits(&reply) && read == reply);
        }
        let other = Estimate::new(pose()).with_covariance([0.5; 9]).with_innovation(2.5, 5);
        assert!(!Reply::Estimate(other).same_bits(&Reply::Estimate(estimate)));
    }

    #[test]
    fn what_is_no_innovation_is_named() {
        for (nis, degrees, said) in [
            (f64::NAN, 1, "innovation nis is NaN"),
            (-1.0, 1, "innovation nis -1 of 1 degrees"),
            (1.0, 0, "innovation nis 1 of 0 degrees"),
            (1.0, u32::MAX, "innovation nis 1 of 4294967295 degrees"),
        ] {
            let reply: Reply = Estimate::new(pose()).with_innovation(nis, degrees).into();
            let error = reply.check().unwrap_err().to_string();
            assert!(error.starts_with(said), "{error}");
        }
    }

    #[test]
    fn every_bit_of_a_reply_counts() {
        let a: Reply = SE2::new(0.0, 1.0, 2.0).into();
        let b: Reply = SE2::new(-0.0, 1.0, 2.0).into();
        assert!(a == b && !a.same_bits(&b) && a.same_bits(&a));
        assert!(!Reply::Abstain.same_bits(&Reply::Taken));
        let c: Reply = Twist { v_m_s: 0.0, omega_rad_s: 0.0 }.into();
        let d: Reply = Twist { v_m_s: 0.0, omega_rad_s: -0.0 }.into();
        assert!(!c.same_bits(&d));
    }
}
