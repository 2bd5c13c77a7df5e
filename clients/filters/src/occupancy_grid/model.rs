//! What a reading is believed to say about cells, as a command line gives it.
//!
//! What could not work is refused: bounds of the log odds within which no cell would
//! ever be occupied or free in a map, and beams that say next to nothing.

use clap::{Args, ValueEnum};

use super::fixed;
use crate::map_server::{FREE_BELOW, OCCUPIED_ABOVE};
use crate::numbers::number;

/// What a beam says that met nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NothingMet {
    /// There is nothing up to the longest range, as the book has it
    Clears,
    /// There is nothing up to what is already held to be occupied
    Stops,
    /// Nothing at all
    Ignored,
}

/// What a reading is believed to say about cells.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "What is believed of a reading (Probabilistic Robotics, Table 9.2)")]
pub struct InverseModel {
    /// Side of a cell, m
    #[arg(long, value_name = "METRES", default_value_t = Self::default().cell_m, value_parser = side)]
    pub cell_m: f64,

    /// How probable a cell is to be occupied where one beam ended
    #[arg(long, value_name = "P", default_value_t = Self::default().p_occupied, value_parser = occupied)]
    pub p_occupied: f64,

    /// and where one went through
    #[arg(long, value_name = "P", default_value_t = Self::default().p_free, value_parser = free)]
    pub p_free: f64,

    /// No cell is more probable to be occupied than this, which is above the 0.65 from
    /// which a map shows it as occupied,
    #[arg(long, value_name = "P", default_value_t = Self::default().p_most, value_parser = most)]
    pub p_most: f64,

    /// nor less than this, which is below the 0.196 under which it shows as free
    #[arg(long, value_name = "P", default_value_t = Self::default().p_least, value_parser = least)]
    pub p_least: f64,

    /// How thick things are (α of the book), m; 0: as thick as the cell in which a
    /// beam ends
    #[arg(long, value_name = "METRES", default_value_t = Self::default().thickness_m, value_parser = length)]
    pub thickness_m: f64,

    /// What a beam says that met nothing
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = Self::default().nothing_met)]
    pub nothing_met: NothingMet,

    /// up to this length, m
    #[arg(long, value_name = "METRES", default_value_t = Self::default().nothing_m, value_parser = side)]
    pub nothing_m: f64,

    /// Use beams up to this length, m; longer ones clear as far as that
    /// [default: the laser's longest]
    #[arg(long, value_name = "METRES", value_parser = side)]
    pub reach_m: Option<f64>,
}

impl Default for InverseModel {
    fn default() -> Self {
        Self {
            cell_m: 0.05,
            p_occupied: 0.7,
            p_free: 0.4,
            p_most: 0.971,
            p_least: 0.1192,
            thickness_m: 0.0,
            nothing_met: NothingMet::Stops,
            nothing_m: 8.0,
            reach_m: None,
        }
    }
}

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
