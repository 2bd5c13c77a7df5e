//! The figures of one estimator in one run.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::client_figures::ClientFigures;

/// One run of one estimator. The figures are those of
/// [`Score`](rusty_contract::score::Score), by the same arithmetic. NaN where
/// nothing was scored that one could be made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Index of the cell.
    pub cell: usize,
    /// The seed of all noise.
    pub seed: u64,
    /// The cell's swept fields and their values; a journal leaves them out.
    #[serde(skip)]
    pub parameters: Arc<[(String, String)]>,
    /// Name in the roster.
    pub estimator: String,
    /// Complete ticks.
    pub ticks: u64,
    /// Time at the end of the last, s.
    pub time_s: f64,
    /// Distance truly driven, m: the length of the true path.
    pub distance_m: f64,
    /// Distance between the last estimate and its truth, m.
    pub final_position_error_m: f64,
    /// Heading error there, rad, 0 to π.
    pub final_heading_error_rad: f64,
    /// Mean distance over all ticks, m.
    pub mean_position_error_m: f64,
    /// Root of its mean square, m.
    pub ate_rmse_m: f64,
    /// 95th percentile over the ticks, m (linear between ranks).
    pub p95_position_error_m: f64,
    /// The greatest, m.
    pub max_position_error_m: f64,
    /// Root of the mean square of the heading error, rad.
    pub rmse_heading_error_rad: f64,
    /// The greatest heading error, rad, 0 to π.
    pub max_heading_error_rad: f64,
    /// Ticks in which a wall kept the robot where it was; of runs with clients
    /// as the scorer finds it.
    pub blocked_ticks: Option<u64>,
    /// Share of the beams that end in front of the map; NaN where nothing moves but the
    /// robot, and with clients.
    pub z_short: f64,
    /// Run digest, 32 hexadecimal digits: that of `launch` with this seed,
    /// this configuration and these estimators.
    pub digest: String,
    /// What only a run with clients has.
    pub clients: Option<ClientFigures>,
}
