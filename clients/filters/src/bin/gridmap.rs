//! `gridmap`: scans and poses to an occupancy grid.

use clap::Parser;
use rusty_clients::{ClientArgs, run_from, witness::run_witness_from};
use rusty_contract::Exit;
use rusty_filters::OdometryNoise;
use rusty_filters::gridmap::{GridMap, GridMapOf, Options, Poses, check_free};

/// Makes a map of cells from scans and poses, and writes it down at the end
///
/// Every beam says that the cells it went through are free and that the one in
/// which it ended is not; a cell adds up what it is told in log odds. That is all,
/// as long as the poses are right: a heading that is off by one degree puts a wall
/// at 5 m twice, 9 cm apart.
///
/// With --poses odometry it is an estimator like others, in a run or on a log: it
/// maps with the poses of its own wheels, which drift, and answers them. The other
/// poses are shown to those who may know the truth: on a log that is whoever can
/// read it (with --key-file, if it is blind), in a run a scorer. --poses NAME maps
/// with what another filter believed; --poses truth says how good the map could
/// be, and no robot can have it.
///
/// What is believed of the wheels (--alpha1 to --alpha4) never changes the map: it is
/// the covariance that is answered with --poses odometry, and nothing otherwise.
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
