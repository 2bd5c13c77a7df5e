//! What estimates are judged by, where that is a choice.

use rusty_contract::score::Within;

/// What counts as consistent, and what as found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yardstick {
    /// A right filter is called consistent with this probability, 0 to 1.
    pub level: f64,
    /// How near for how long counts as found.
    pub within: Within,
}

impl Default for Yardstick {
    /// 95 %; a quarter of a metre and 10° for a second.
    fn default() -> Self {
        Self { level: 0.95, within: Within::default() }
    }
}
