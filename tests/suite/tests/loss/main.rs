//! Faults and refusals: what goes wrong is named, the rest ends or goes on, and nothing is left.

mod catch_up;
mod dropped;
mod endings;
mod faults;
mod limits;
mod logging;
mod places;
mod refusals;
