//! Filters as processes: accuracy, live runs, logs and replays.

mod bayes_hallway;
mod beliefs;
mod dead_reckoning;
mod drivers;
mod ekf;
mod figures;
mod fitting;
mod grid_localisation;
mod hard_places;
mod landmarks;
mod mcl;
mod recordings;
mod slam;
mod steering;
