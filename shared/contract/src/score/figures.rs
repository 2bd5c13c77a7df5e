//! The errors of an estimator over a run.

use serde::{Deserialize, Serialize};

/// The errors of an estimator over a run; `None` of each without a scored tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// The last position error, m.
    pub final_position_error_m: Option<f64>,
    /// The last heading error, rad, 0 to π.
    pub final_heading_error_rad: Option<f64>,
    /// Mean position error, m.
    pub mean_position_error_m: Option<f64>,
    /// 95th percentile of it, m (linear between ranks).
    pub p95_position_error_m: Option<f64>,
    /// The greatest, m.
    pub max_position_error_m: Option<f64>,
    /// Root of its mean square, m.
    pub ate_rmse_m: Option<f64>,
    /// Root of the mean square of the heading error, rad.
    pub rmse_heading_error_rad: Option<f64>,
    /// The greatest heading error, rad, 0 to π.
    pub max_heading_error_rad: Option<f64>,
}
