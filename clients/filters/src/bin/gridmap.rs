//! `gridmap`: builds an occupancy grid from scans and poses.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from, witness::run_witness_from};
use rusty_contract::Exit;
use rusty_filters::OdometryNoise;
use rusty_filters::gridmap::{GridMap, GridMapOf, Options, Poses, check_free};

/// Build an occupancy grid from scans and poses
///
/// The map is written at the end. Each beam marks the cells that it crosses as free
/// and its last cell as occupied; each cell sums the log odds. The poses must be
/// right: a heading error of one degree doubles a wall at 5 m, 9 cm apart.
///
/// With --poses odometry, gridmap is an ordinary estimator, in a run or on a log: it
/// maps with the poses of its odometry, which drift, and answers them. --poses NAME
/// maps with the estimates of another filter. --poses truth shows the best possible
/// map, which no robot can have. These two need access to the truth: a log (with
/// --key-file if it is blind), or in a run the role of a scorer.
///
/// The noise of the wheels (--alpha1 to --alpha4) does not change the map. It sets the
/// covariance of the answers with --poses odometry and has no other effect.
///
///   gridmap --log run.log --poses mcl --save map
///   gridmap --log intel.log --poses truth --until 1326 --save intel
#[derive(Parser)]
#[command(version, verbatim_doc_comment)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,

    #[command(flatten)]
    options: Options,

    #[command(flatten)]
    noise: OdometryNoise,
}

fn main() -> Exit {
    let Cli { args, options, noise } = Cli::parse();
    match options.poses {
        Poses::Odometry => run_from(&args, |start| {
            check_free(&args, &options.save)?;
            Ok(GridMap::new(start, &options, noise))
        }),
        Poses::Truth | Poses::Of(_) => run_witness_from(&args, |start, brief, args| {
            check_free(args, &options.save)?;
            GridMapOf::new(start, brief, &options)
        }),
    }
}
