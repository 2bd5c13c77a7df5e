//! People: walkers on their way, and a crowd.

use serde::{Deserialize, Serialize};

use super::{FieldError, at_least, within};

/// The most people in a run.
pub const MAX_PEOPLE: usize = 100;

/// Speed at which people like to walk, m/s (D. Helbing and P. Molnár 1995).
const SPEED_M_S: f64 = 1.34;

/// How a body looks to a LiDAR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// One disc.
    #[default]
    Disc,
    /// Two legs that swing.
    Legs,
}

/// A person who walks from waypoint to waypoint and back to the first, through
/// whatever is there, and stops before the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WalkerConfig {
    /// Where the way leads, `[x, y]` in metres, world frame; it begins at the first.
    #[serde(deserialize_with = "rusty_geometry::exactly::lists")]
    pub waypoints: Vec<[f64; 2]>,
    /// Speed, m/s.
    #[serde(default = "speed_m_s")]
    pub speed_m_s: f64,
    /// Radius of the body, m.
    #[serde(default = "radius_m")]
    pub radius_m: f64,
    /// What the LiDAR sees.
    #[serde(default)]
    pub shape: Shape,
}

fn speed_m_s() -> f64 {
    SPEED_M_S
}

fn radius_m() -> f64 {
    0.25
}

impl WalkerConfig {
    /// Checks a list of walkers.
    ///
    /// # Errors
    /// [`FieldError`] names the first field that cannot be used.
    pub fn check(list: &[Self]) -> Result<(), FieldError> {
        at_least("walker (number of)", list.len() as u64, 0, MAX_PEOPLE as u64)?;
        for (i, walker) in list.iter().enumerate() {
            let field = |name: &str| format!("walker[{i}].{name}");
            let count = walker.waypoints.len() as u64;
            at_least(&field("waypoints (number of)"), count, 1, 1000)?;
            for (k, [x, y]) in walker.waypoints.iter().enumerate() {
                within(&field(&format!("waypoints[{k}][0]")), *x, -1e6, 1e6)?;
                within(&field(&format!("waypoints[{k}][1]")), *y, -1e6, 1e6)?;
            }
            within(&field("speed_m_s"), walker.speed_m_s, 0.0, 10.0)?;
            within(&field("radius_m"), walker.radius_m, 0.01, 10.0)?;
        }
        Ok(())
    }
}

/// People who walk by the social-force model to goals drawn from the seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CrowdConfig {
    /// How many.
    pub people: u32,
    /// Mean of the speeds at which they like to walk, m/s.
    pub speed_m_s: f64,
    /// Standard deviation of those speeds, m/s.
    pub speed_std_m_s: f64,
    /// Radius of a body, m.
    pub radius_m: f64,
    /// What the LiDAR sees.
    pub shape: Shape,
    /// Whether they keep away from the robot as from each other. If not, they stop
    /// only when they would touch it.
    pub avoids_robot: bool,
}

impl Default for CrowdConfig {
    /// Five, with the speeds of Helbing and Molnár (1995).
    fn default() -> Self {
        Self {
            people: 5,
            speed_m_s: SPEED_M_S,
            speed_std_m_s: 0.26,
            radius_m: radius_m(),
            shape: Shape::Disc,
            avoids_robot: true,
        }
    }
}

impl CrowdConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        at_least("crowd.people", self.people.into(), 0, MAX_PEOPLE as u64)?;
        within("crowd.speed_m_s", self.speed_m_s, 0.0, 10.0)?;
        within("crowd.speed_std_m_s", self.speed_std_m_s, 0.0, 10.0)?;
        within("crowd.radius_m", self.radius_m, 0.01, 10.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_is_checked() {
        let walker = WalkerConfig {
            waypoints: vec![[1.0, 2.0]],
            speed_m_s: 1.0,
            radius_m: 0.2,
            shape: Shape::Disc,
        };
        assert!(WalkerConfig::check(std::slice::from_ref(&walker)).is_ok());
        let broken: [fn(&mut WalkerConfig); 4] = [
            |w| w.waypoints.clear(),
            |w| w.waypoints[0][1] = f64::NAN,
            |w| w.speed_m_s = -1.0,
            |w| w.radius_m = 0.0,
        ];
        for (i, break_it) in broken.iter().enumerate() {
            let mut other = walker.clone();
            break_it(&mut other);
            let error = WalkerConfig::check(&[walker.clone(), other]).unwrap_err();
            assert!(error.field.starts_with("walker[1]."), "{i}: {error}");
        }
        assert!(WalkerConfig::check(&vec![walker; 101]).is_err());
        assert!(CrowdConfig::default().check().is_ok());
        for crowd in [
            CrowdConfig { people: 101, ..CrowdConfig::default() },
            CrowdConfig { speed_m_s: f64::NAN, ..CrowdConfig::default() },
            CrowdConfig { speed_std_m_s: -0.1, ..CrowdConfig::default() },
            CrowdConfig { radius_m: 0.0, ..CrowdConfig::default() },
        ] {
            assert!(crowd.check().is_err());
        }
    }
}
