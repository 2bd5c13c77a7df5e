//! Filters as processes: accuracy, live runs, logs and replays.

mod bayes_hallway;
mod beliefs;
mod drivers;
mod ekf;
mod fitting;
mod mcl;
mod slam;
mod steering;
