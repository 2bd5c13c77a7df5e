//! What a person tells the driver.

use rusty_geometry::Twist;

/// A command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Parts of what the robot can do, -1 to 1.
    Parts {
        /// Part of the greatest speed.
        ahead: f64,
        /// Part of the greatest turn rate.
        left: f64,
    },
    /// A velocity; a driver limits it to what the robot can do.
    Velocity(Twist),
}

impl Command {
    /// Length, bytes.
    pub const BYTES: usize = 17;

    /// The command as bytes.
    #[must_use]
    pub fn to_bytes(self) -> [u8; Self::BYTES] {
        let (kind, numbers) = match self {
            Self::Parts { ahead, left } => (0, [ahead, left]),
            Self::Velocity(Twist { v_m_s, omega_rad_s }) => (1, [v_m_s, omega_rad_s]),
        };
        let mut bytes = [kind; Self::BYTES];
        bytes[1..].copy_from_slice(numbers.map(f64::to_le_bytes).as_flattened());
        bytes
    }

    /// Reads a command. `None` of other bytes, parts that are not in -1 to 1, or a velocity
    /// that is not finite.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (kind, numbers) = bytes.split_first()?;
        let (first, second) = numbers.split_first_chunk()?;
        let [first, second] = [*first, second.try_into().ok()?].map(f64::from_le_bytes);
        let are_parts = [first, second].iter().all(|part| (-1.0..=1.0).contains(part));
        match kind {
            0 if are_parts => Some(Self::Parts { ahead: first, left: second }),
            1 if first.is_finite() && second.is_finite() => {
                Some(Self::Velocity(Twist { v_m_s: first, omega_rad_s: second }))
            }
            _ => None,
        }
    }

    /// Returns the velocity, of a robot with these greatest ones.
    #[must_use]
    pub fn velocity(self, greatest: Twist) -> Twist {
        let Twist { v_m_s: most_v, omega_rad_s: most_omega } = greatest;
        match self {
            Self::Parts { ahead, left } => {
                Twist { v_m_s: ahead * most_v, omega_rad_s: left * most_omega }
            }
            Self::Velocity(Twist { v_m_s, omega_rad_s }) => Twist {
                v_m_s: v_m_s.min(most_v).max(-most_v),
                omega_rad_s: omega_rad_s.min(most_omega).max(-most_omega),
            },
        }
    }
}

impl Default for Command {
    /// The robot stands.
    fn default() -> Self {
        Self::Parts { ahead: 0.0, left: 0.0 }
    }
}
