//! What a reading is believed to say about cells, as a command line gives it.
//!
//! What could not work is refused: bounds of the log odds within which no cell would
//! ever be occupied or free in a map, and beams that say next to nothing.

use clap::{Args, ValueEnum};

use super::fixed;
use crate::numbers::number;
use rusty_floorplan::map_server::{FREE_BELOW, OCCUPIED_ABOVE};

/// What a beam says that met nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NothingMet {
    /// Free space up to the maximum length
    Clears,
    /// Free space up to the first occupied cell
    Stops,
    /// No information
    Ignored,
}

/// What a reading is believed to say about cells.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Occupancy model (Probabilistic Robotics, Table 9.2)")]
pub struct InverseModel {
    /// Side of a cell, m
    #[arg(long, value_name = "METRES", default_value_t = 0.05, value_parser = side)]
    pub cell_m: f64,

    /// Occupancy probability where one beam ends
    #[arg(long, value_name = "P", default_value_t = 0.7, value_parser = occupied)]
    pub p_occupied: f64,

    /// Occupancy probability where one beam passes
    #[arg(long, value_name = "P", default_value_t = 0.4, value_parser = free)]
    pub p_free: f64,

    /// Maximum occupancy probability of a cell, above 0.65
    #[arg(long, value_name = "P", default_value_t = 0.971, value_parser = most)]
    pub p_most: f64,

    /// Minimum occupancy probability of a cell, below 0.196
    #[arg(long, value_name = "P", default_value_t = 0.1192, value_parser = least)]
    pub p_least: f64,

    /// Thickness of obstacles (α), m, 0 for one cell
    #[arg(long, value_name = "METRES", default_value_t = 0.0, value_parser = length)]
    pub thickness_m: f64,

    /// Meaning of a beam without an echo
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = NothingMet::Stops)]
    pub nothing_met: NothingMet,

    /// Free length of a beam without an echo, m
    #[arg(long, value_name = "METRES", default_value_t = 8.0, value_parser = side)]
    pub nothing_m: f64,

    /// Maximum length of a beam, m [default: the laser's]
    #[arg(long, value_name = "METRES", value_parser = side)]
    pub reach_m: Option<f64>,
}

crate::numbers::default_of_command_line!(InverseModel);

fn side(text: &str) -> Result<f64, String> {
    number(text, |v| (1e-3..=1e3).contains(&v), "a length in metres, 0.001 to 1000")
}

fn length(text: &str) -> Result<f64, String> {
    number(text, |v| (0.0..=1e3).contains(&v), "a length in metres, 0 to 1000")
}

fn occupied(text: &str) -> Result<f64, String> {
    number(text, |v| (0.51..=0.999_999).contains(&v), "a probability from 0.51 to 0.999999")
}

fn free(text: &str) -> Result<f64, String> {
    number(text, |v| (1e-6..=0.49).contains(&v), "a probability from 0.000001 to 0.49")
}

/// With less, no cell would ever be occupied in a map.
fn most(text: &str) -> Result<f64, String> {
    let fits = |v| v <= 0.999_999 && fixed(v) > fixed(OCCUPIED_ABOVE);
    number(text, fits, "a probability above 0.65, at most 0.999999")
}

/// With more, none would ever be free.
fn least(text: &str) -> Result<f64, String> {
    let fits = |v| v >= 1e-6 && fixed(v) < fixed(FREE_BELOW);
    number(text, fits, "a probability below 0.196, at least 0.000001")
}
