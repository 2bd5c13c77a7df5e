//! Checks of single numbers, and the error they share.

use thiserror::Error;

/// A field or command-line option that cannot be used as it is.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{field}{}{value}: {problem}; {remedy}", separator(field))]
pub struct FieldError {
    /// Path of the field, as in the scenario file; or the option, as `--set`.
    pub field: String,
    /// What was found there.
    pub value: String,
    /// What is wrong with it.
    pub problem: String,
    /// What to write instead.
    pub remedy: String,
}

impl FieldError {
    /// An error about `field`, which holds `value`.
    pub fn new(
        field: impl Into<String>,
        value: impl ToString,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            field: field.into(),
            value: value.to_string(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

/// Returns what is written between field and value: `dt_s = 0`, `--at 0`.
fn separator(field: &str) -> &'static str {
    if field.starts_with("--") { " " } else { " = " }
}

/// A number between two bounds, both allowed.
///
/// # Errors
/// [`FieldError`] names `field`.
pub fn within(field: &str, value: f64, low: f64, high: f64) -> Result<(), FieldError> {
    if value.is_nan() {
        return Err(FieldError::new(
            field,
            value,
            "is not a number",
            format!("use a number from {low} to {high}"),
        ));
    }
    if value < low || value > high {
        return Err(FieldError::new(
            field,
            value,
            "is out of range",
            format!("use a number from {low} to {high}"),
        ));
    }
    Ok(())
}

/// A whole number of at least `low` and at most `high`.
pub(crate) fn at_least(field: &str, value: u64, low: u64, high: u64) -> Result<(), FieldError> {
    if value < low || value > high {
        return Err(FieldError::new(
            field,
            value,
            "is out of range",
            format!("use a whole number from {low} to {high}"),
        ));
    }
    Ok(())
}

/// A time that a person would wait: above 0, at most a day, s.
///
/// # Errors
/// [`FieldError`] names `field`.
pub fn seconds(field: &str, value: f64) -> Result<(), FieldError> {
    within(field, value, 0.001, 86_400.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_names_field_value_and_remedy() {
        let error = within("robot.slip_std", -0.5, 0.0, 1.0).unwrap_err();
        assert_eq!(
            error.to_string(),
            "robot.slip_std = -0.5: is out of range; use a number from 0 to 1"
        );
        let error = within("dt_s", f64::NAN, 0.0, 1.0).unwrap_err();
        assert!(error.to_string().contains("dt_s = NaN: is not a number"));
        assert!(within("dt_s", f64::INFINITY, 0.0, 1.0).is_err());
        assert!(at_least("ticks", 0, 1, 10).is_err());
        let error = within("--side", 0.0, 0.5, 1.0).unwrap_err().to_string();
        assert!(error.starts_with("--side 0: "), "as it was typed: {error}");
    }
}
