//! What a person tells the driver.

/// A command as parts of what the robot can do: ahead and to the left, -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// Part of the greatest speed.
    pub ahead: f64,
    /// Part of the greatest turn rate.
    pub left: f64,
}

impl Command {
    /// Length, bytes.
    pub const BYTES: usize = 16;

    /// The command as bytes.
    #[must_use]
    pub fn to_bytes(self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        bytes[..8].copy_from_slice(&self.ahead.to_le_bytes());
        bytes[8..].copy_from_slice(&self.left.to_le_bytes());
        bytes
    }

    /// Reads a command. `None` of other bytes, or numbers that are not in -1 to 1.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (ahead, left) = bytes.split_first_chunk()?;
        let [ahead, left] = [*ahead, left.try_into().ok()?].map(f64::from_le_bytes);
        let is_part = |part: f64| (-1.0..=1.0).contains(&part);
        (is_part(ahead) && is_part(left)).then_some(Self { ahead, left })
    }
}
