//! The names of the clients that this binary contains. `build.rs` has no other module.

/// The names, in the order of `sim-server programs`.
pub const NAMES: &[&str] = &[
    "bayes-hallway",
    "dead-reckoning",
    "eif-landmarks",
    "ekf",
    "ekf-landmarks",
    "ekf-slam",
    "explore",
    "fastslam",
    "fit-beam",
    "fit-motion",
    "goto",
    "grid-localisation",
    "gridmap",
    "mcl",
    "scan-match",
    "slam",
    "trajectory",
    "wander",
    "logger",
    "score",
    "belief",
    "view",
    "drive",
];
