//! Slip of the wheels: its figures, and patches of the floor with others.

use serde::{Deserialize, Serialize};

use super::{FieldError, at_least, within};

/// The most patches in a run.
const MOST_PATCHES: usize = 100;

/// The law of the slip of a wheel: with probability `outlier_rate` a draw is
/// `outlier_factor` times as large as one of N(0, `std`²).
///
/// Source: the contaminated normal distribution of J. W. Tukey, *A survey of sampling
/// from contaminated distributions*, in: Contributions to Probability and Statistics,
/// Stanford 1960, pp. 448-485. With rate p and factor k the variance is σ²(1 - p + pk²)
/// and the kurtosis 3(1 - p + pk⁴)/(1 - p + pk²)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipFigures {
    /// σ per *tick* (not scaled by √dt).
    pub std: f64,
    /// Probability p of an outlier.
    pub outlier_rate: f64,
    /// k: how many times as large an outlier is.
    pub outlier_factor: f64,
}

impl SlipFigures {
    /// Checks all figures of the table `name`.
    pub(super) fn check(&self, name: &str) -> Result<(), FieldError> {
        // A negative σ would be accepted by the distribution and mirror the noise.
        within(&format!("{name}.slip_std"), self.std, 0.0, 1.0)?;
        within(&format!("{name}.slip_outlier_rate"), self.outlier_rate, 0.0, 1.0)?;
        within(&format!("{name}.slip_outlier_factor"), self.outlier_factor, 1.0, 1e3)
    }
}

/// An area of the floor on which wheels slip otherwise, from ice to carpet. A wheel is
/// on it where its contact point is; of patches that overlap, the last one counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PatchConfig {
    /// Corners of a polygon, `[x, y]` in metres, world frame.
    #[serde(deserialize_with = "rusty_geometry::exactly::lists")]
    pub corners: Vec<[f64; 2]>,
    /// σ of the slip of a wheel on it, per *tick*.
    pub slip_std: f64,
    /// Probability of an outlier.
    #[serde(default)]
    pub slip_outlier_rate: f64,
    /// How many times as large an outlier is.
    #[serde(default = "outlier_factor")]
    pub slip_outlier_factor: f64,
}

/// The default of `slip_outlier_factor`.
pub(super) const fn outlier_factor() -> f64 {
    10.0
}

impl PatchConfig {
    /// The law of the slip of a wheel on it.
    #[must_use]
    pub fn figures(&self) -> SlipFigures {
        SlipFigures {
            std: self.slip_std,
            outlier_rate: self.slip_outlier_rate,
            outlier_factor: self.slip_outlier_factor,
        }
    }

    /// Checks a list of patches.
    ///
    /// # Errors
    /// [`FieldError`] names the first field that cannot be used.
    pub fn check(list: &[Self]) -> Result<(), FieldError> {
        at_least("patch (number of)", list.len() as u64, 0, MOST_PATCHES as u64)?;
        for (i, patch) in list.iter().enumerate() {
            let count = patch.corners.len() as u64;
            at_least(&format!("patch[{i}].corners (number of)"), count, 3, 100)?;
            for (k, [x, y]) in patch.corners.iter().enumerate() {
                within(&format!("patch[{i}].corners[{k}][0]"), *x, -1e6, 1e6)?;
                within(&format!("patch[{i}].corners[{k}][1]"), *y, -1e6, 1e6)?;
            }
            if !encloses_area(&patch.corners) {
                let (field, remedy) = (format!("patch[{i}].corners"), "give corners of a polygon");
                let corners = format!("{:?}", patch.corners);
                return Err(FieldError::new(field, corners, "lie on one line", remedy));
            }
            patch.figures().check(&format!("patch[{i}]"))?;
        }
        Ok(())
    }
}

/// Whether not all corners lie on one line.
fn encloses_area(corners: &[[f64; 2]]) -> bool {
    let [x, y] = corners[0];
    let cross = |a: &[f64; 2], b: &[f64; 2]| (a[0] - x) * (b[1] - y) - (b[0] - x) * (a[1] - y);
    corners.windows(2).any(|pair| cross(&pair[0], &pair[1]) != 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_of_a_patch_is_checked() {
        let square = PatchConfig {
            corners: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            slip_std: 0.1,
            slip_outlier_rate: 0.0,
            slip_outlier_factor: 10.0,
        };
        PatchConfig::check(std::slice::from_ref(&square)).unwrap();
        type Change = fn(&mut PatchConfig);
        let broken: [(Change, &str); 7] = [
            (|p| p.corners.truncate(2), "patch[1].corners (number of)"),
            (|p| p.corners = vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], "patch[1].corners"),
            (|p| p.corners[2][0] = f64::NAN, "patch[1].corners[2][0]"),
            (|p| p.corners[0][1] = 1e7, "patch[1].corners[0][1]"),
            (|p| p.slip_std = -0.1, "patch[1].slip_std"),
            (|p| p.slip_outlier_rate = 1.5, "patch[1].slip_outlier_rate"),
            (|p| p.slip_outlier_factor = 0.5, "patch[1].slip_outlier_factor"),
        ];
        for (break_it, field) in broken {
            let mut list = [square.clone(), square.clone()];
            break_it(&mut list[1]);
            assert_eq!(PatchConfig::check(&list).unwrap_err().field, field);
        }
        assert!(PatchConfig::check(&vec![square; 101]).is_err());
    }
}
