//! [`StartOptions`]: how sure a filter is of the initial pose that it is given.

use clap::Args;
use nalgebra::Matrix3;

use crate::numbers::positive;
use crate::tangent::independent;

/// What is believed of the start.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Start")]
pub struct StartOptions {
    /// Standard deviation of the start, each axis, m
    #[arg(long, value_name = "METRES", default_value_t = 0.02, value_parser = positive)]
    pub start_std_m: f64,

    /// Standard deviation of the initial heading, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 1.0, value_parser = positive)]
    pub start_std_deg: f64,
}

impl StartOptions {
    /// The covariance of the error of the initial pose, m, m and rad.
    pub(crate) fn covariance(&self) -> Matrix3<f64> {
        independent(self.start_std_m, self.start_std_deg.to_radians())
    }
}
