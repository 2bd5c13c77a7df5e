//! `gridmap`: builds an occupancy grid from scans and poses.

use rusty_clients::{ClientArgs, run_from, run_recorder};
use rusty_contract::Exit;
use rusty_filters::gridmap::{GridMap, GridMapOf, Options, Poses, check_free};

fn main() -> Exit {
    let (args, options) = ClientArgs::with_options::<Options>();
    match options.poses {
        Poses::Odometry => run_from(&args, |start| {
            check_free(&args, &options.save)?;
            Ok(GridMap::new(start, &options))
        }),
        Poses::Truth | Poses::Of(_) => run_recorder(&args, |start, brief| {
            check_free(&args, &options.save)?;
            GridMapOf::new(start, brief, &options)
        }),
    }
}
