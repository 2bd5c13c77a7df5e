//! The programs of the filters and drivers: each joins a run, or works on a log.

use rusty_clients::dead_reckoning::{self, DeadReckoning};
use rusty_clients::{ClientArgs, run, run_from, run_recorder};
use rusty_contract::{Exit, Program};

use crate::bayes_hallway::{self, BayesHallway};
use crate::eif_landmarks::{self, EifLandmarks};
use crate::ekf::{self, Ekf};
use crate::ekf_landmarks::{self, EkfLandmarks};
use crate::ekf_slam::{self, EkfSlam};
use crate::fastslam::{self, FastSlam};
use crate::fit_beam::{self, FitBeam};
use crate::fit_motion::FitMotion;
use crate::grid_localisation::{self, GridLocalisation};
use crate::gridmap::{self, GridMap, GridMapOf, Poses, check_free};
use crate::mcl::{self, Mcl};
use crate::scan_match::{ScanMatch, ScanMatchOptions};
use crate::slam::{Slam, SlamOptions};
use crate::trajectory::{self, Trajectory};
use crate::{explore, goto, wander};

/// The programs of this package.
pub const PROGRAMS: &[Program] = &[
    Program::new("bayes-hallway", "localises in a corridor by its doors", bayes_hallway),
    Program::new("dead-reckoning", "integrates the encoders", dead_reckoning),
    Program::new("eif-landmarks", "localises on landmarks by information", eif_landmarks),
    Program::new("ekf", "localises on a floor plan by straight walls", ekf),
    Program::new("ekf-landmarks", "localises on a map of landmarks", ekf_landmarks),
    Program::new("ekf-slam", "localises and maps landmarks by one Gaussian", ekf_slam),
    Program::new("explore", "drives to the frontiers of the map that it builds", explore),
    Program::new("fastslam", "localises and maps landmarks by particles", fastslam),
    Program::new("fit-beam", "fits the beam model to a log", fit_beam),
    Program::new("fit-motion", "fits the odometry motion model to a log", fit_motion),
    Program::new("goto", "drives to waypoints", goto),
    Program::new("grid-localisation", "localises on a grid of poses", grid_localisation),
    Program::new("gridmap", "builds an occupancy grid from scans and poses", gridmap),
    Program::new("mcl", "localises by particles (Monte Carlo localisation)", mcl),
    Program::new("scan-match", "computes odometry by matching scans", scan_match),
    Program::new("slam", "localises and maps without a given map", slam),
    Program::new("trajectory", "answers with the poses of a file", trajectory),
    Program::new("wander", "drives through free space by the laser only", wander),
];

fn bayes_hallway() -> Exit {
    run(|start, options: bayes_hallway::Options| BayesHallway::new(start, &options))
}

fn dead_reckoning() -> Exit {
    run(|start, options: dead_reckoning::Options| {
        Ok(DeadReckoning::of_start(start).with_options(options))
    })
}

fn eif_landmarks() -> Exit {
    run(|start, options: eif_landmarks::Options| EifLandmarks::new(start, &options))
}

fn ekf() -> Exit {
    run(|start, options: ekf::Options| Ekf::new(start, &options))
}

fn ekf_landmarks() -> Exit {
    run(|start, options: ekf_landmarks::Options| EkfLandmarks::new(start, &options))
}

fn ekf_slam() -> Exit {
    run(|start, options: ekf_slam::Options| EkfSlam::new(start, &options))
}

fn explore() -> Exit {
    let (args, options) = ClientArgs::with_options::<explore::Options>();
    run_from(&args, |start| {
        options.save.iter().try_for_each(|stem| check_free(&args, stem))?;
        Ok(explore::driver(start, options.clone()))
    })
}

fn fastslam() -> Exit {
    run(|start, options: fastslam::Options| FastSlam::new(start, &options))
}

fn fit_beam() -> Exit {
    let (args, options) = ClientArgs::with_options::<fit_beam::Options>();
    run_recorder(&args, |start, brief| {
        args.check_no_answers()?;
        FitBeam::new(start, brief, options.clone())
    })
}

fn fit_motion() -> Exit {
    let (args, options) = ClientArgs::with_options();
    run_recorder(&args, |start, brief| {
        args.check_no_answers()?;
        Ok(FitMotion::new(start, brief, options))
    })
}

fn goto() -> Exit {
    let mut prepared = None;
    run(move |start, options| goto::next_driver(start, options, &mut prepared))
}

fn grid_localisation() -> Exit {
    run(|start, options: grid_localisation::Options| GridLocalisation::new(start, &options))
}

fn gridmap() -> Exit {
    let (args, options) = ClientArgs::with_options::<gridmap::Options>();
    match options.poses {
        Poses::Odometry => run_from(&args, |start| {
            check_free(&args, &options.save)?;
            Ok(GridMap::new(start, &options))
        }),
        Poses::Truth | Poses::Of(_) => run_recorder(&args, |start, brief| {
            args.check_no_answers()?;
            check_free(&args, &options.save)?;
            GridMapOf::new(start, brief, &options)
        }),
    }
}

fn mcl() -> Exit {
    let mut prepared = None;
    run(move |start, options: mcl::Options| Mcl::of_next_start(start, &options, &mut prepared))
}

fn scan_match() -> Exit {
    run(|start, options: ScanMatchOptions| Ok(ScanMatch::new(start, &options)))
}

fn slam() -> Exit {
    let (args, options) = ClientArgs::with_options::<SlamOptions>();
    run_from(&args, |start| {
        options.save_map.iter().try_for_each(|stem| check_free(&args, stem))?;
        options.save_poses.iter().try_for_each(|file| args.check_free(file))?;
        Ok(Slam::new(start, &options))
    })
}

fn trajectory() -> Exit {
    run(|_, options: trajectory::Options| Trajectory::read(options))
}

fn wander() -> Exit {
    run(|start, options| Ok(wander::driver(start, options)))
}
