//! What a wall is made of.
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, "The world": glass is
//! a wall to a planner and nearly invisible to a LiDAR; doors carry a number so
//! that a later chapter can tell them apart. The angle at which a LiDAR sees glass
//! is a figure of the LiDAR, not of the pane.

use core::fmt;
use core::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The optical kind of a wall. Its text form, in files and messages, is `Wall`,
/// `Glass` or `Door(3)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Material {
    /// An opaque wall.
    Wall,
    /// A pane of glass: solid, but the beam of a LiDAR may pass it.
    Glass,
    /// A closed door with its number.
    Door(u8),
}

/// A text that names no material.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "material: {text:?} is none; write \"Wall\", \"Glass\" or \"Door(n)\" with n from 0 to 255"
)]
pub struct MaterialError {
    /// The text as it was given.
    pub text: String,
}

impl fmt::Display for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wall => f.pad("Wall"),
            Self::Glass => f.pad("Glass"),
            Self::Door(number) => f.pad(&format!("Door({number})")),
        }
    }
}

impl FromStr for Material {
    type Err = MaterialError;

    /// Reads exactly what `Display` writes: case, and the digits of a door's
    /// number (no sign, no leading zero), included.
    fn from_str(text: &str) -> Result<Self, MaterialError> {
        let material = match text {
            "Wall" => Some(Self::Wall),
            "Glass" => Some(Self::Glass),
            _ => text
                .strip_prefix("Door(")
                .and_then(|rest| rest.strip_suffix(')'))
                .and_then(|number| number.parse().ok())
                .map(Self::Door),
        };
        // `u8::from_str` also takes "+7" and "007"; one material, one text.
        material
            .filter(|found| found.to_string() == text)
            .ok_or_else(|| MaterialError { text: text.to_owned() })
    }
}

impl TryFrom<String> for Material {
    type Error = MaterialError;

    fn try_from(text: String) -> Result<Self, MaterialError> {
        text.parse()
    }
}

impl From<Material> for String {
    fn from(material: Material) -> Self {
        material.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_back() {
        let mut all = vec![Material::Wall, Material::Glass];
        all.extend((0..=255).map(Material::Door));
        for material in all {
            assert_eq!(material.to_string().parse(), Ok(material));
            let json = serde_json::to_string(&material).unwrap();
            assert_eq!(json, format!("\"{material}\""));
            assert_eq!(serde_json::from_str::<Material>(&json).unwrap(), material);
        }
        assert_eq!(format!("{:>8}|", Material::Door(3)), " Door(3)|");
    }

    #[test]
    fn what_is_no_material_is_named() {
        for text in
            ["", "wall", "Door", "Door()", "Door(256)", "Door(-1)", "Door(+1)", "Door(01)", " Wall"]
        {
            let error = text.parse::<Material>().unwrap_err();
            assert!(error.to_string().contains(&format!("{text:?}")));
            assert!(error.to_string().contains("Door(n)"));
        }
        let error = serde_json::from_str::<Material>("\"Brick\"").unwrap_err();
        assert!(error.to_string().contains("Brick"), "{error}");
    }
}
