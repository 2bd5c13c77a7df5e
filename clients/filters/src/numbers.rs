//! Numbers on a command line: valid ones, and the defaults.

/// Implements `Default` for options: the values of an empty command line.
macro_rules! default_of_command_line {
    ($options:ty) => {
        impl Default for $options {
            fn default() -> Self {
                $crate::numbers::of_empty_command_line()
            }
        }
    };
}
pub(crate) use default_of_command_line;

/// The options of an empty command line.
pub(crate) fn of_empty_command_line<O: clap::Args>() -> O {
    let command = O::augment_args(clap::Command::new("default"));
    let matches = command.get_matches_from(["default"]);
    O::from_arg_matches(&matches).unwrap_or_else(|e| e.exit())
}

/// A number for which `fits` holds; what is `wanted` is said of any other text.
pub(crate) fn number(text: &str, fits: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    text.parse().ok().filter(|v| fits(*v)).ok_or_else(|| format!("give {wanted}"))
}

/// A number greater than 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v.is_finite(), "a number greater than 0")
}

/// A number that is not negative.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a number, 0 or more")
}

/// A share.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=1.0).contains(&v), "a share from 0 to 1")
}

/// A probability, neither 0 nor 1.
pub(crate) fn probability(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0 && v < 1.0, "a number between 0 and 1")
}

/// A time after the start, s.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0 && v.is_finite(), "a time in seconds, 0 or more")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::*;
    use clap::{Args, Command};

    fn check<O: Args>() {
        let command = rusty_clients::ClientArgs::augment_args(Command::new("filter").version("1"));
        O::augment_args(command).debug_assert();
    }

    #[test]
    fn no_command_line_has_an_option_twice() {
        check::<bayes_hallway::Options>();
        check::<rusty_clients::dead_reckoning::Options>();
        check::<ekf::Options>();
        check::<eif_landmarks::Options>();
        check::<ekf_landmarks::Options>();
        check::<ekf_slam::Options>();
        check::<explore::Options>();
        check::<fastslam::Options>();
        check::<grid_localisation::Options>();
        check::<fit_beam::Options>();
        check::<fit_motion::Options>();
        check::<trajectory::Options>();
        check::<goto::Options>();
        check::<gridmap::Options>();
        check::<mcl::Options>();
        check::<scan_match::ScanMatchOptions>();
        check::<slam::SlamOptions>();
        check::<wander::Options>();
    }

    #[test]
    fn what_fits_is_taken_and_the_rest_is_told_what_would() {
        assert_eq!((positive("0.5"), share("0"), seconds("0")), (Ok(0.5), Ok(0.0), Ok(0.0)));
        for text in ["", "x", "nan", "inf", "-1", "1 m"] {
            assert_eq!(positive(text).unwrap_err(), "give a number greater than 0", "{text}");
            assert_eq!(share(text).unwrap_err(), "give a share from 0 to 1", "{text}");
            assert_eq!(seconds(text).unwrap_err(), "give a time in seconds, 0 or more", "{text}");
        }
        assert!(positive("0").is_err() && share("1.1").is_err());
    }
}
