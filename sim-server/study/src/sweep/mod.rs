//! Many runs: every seed in every cell of a grid of settings.
//!
//! In reading order:
//!
//! * [`seeds`], [`grid`], [`plan`]: what there is to do;
//! * [`cell`], [`row`] with its [`client_figures`], [`track`], [`record`]: what
//!   results from it;
//! * [`workers`]: runs side by side, made [`inside`] or with [`clients`], by [`crews`] of
//!   processes or by [`launches`];
//! * [`journal`]: what is done, while the rest is not;
//! * [`table`], [`settings`] with the `program_files`: what is written in the end;
//! * [`job`]: all of it together;
//! * [`manifest`], [`shard`], [`part`], [`mod@merge`] and the shards that make it
//!   [`incomplete`], with a [`pilot`] for the size of a shard: the same on many machines;
//! * [`mod@summary`] with its [`band`]s, [`mod@growth`], [`mod@anees`], [`paired`]: what
//!   the rows and tracks say: means, spreads over distance ([`growth_text`] for
//!   people), whether covariances are right, [`mod@overview`] of estimators, differences
//!   on the same seeds;
//! * [`drawing`]: the fan and the growth, drawn;
//! * [`report`]: what a person is told;
//! * [`error`].

pub mod anees;
mod answer_digests;
pub mod band;
pub mod bands_text;
pub mod cell;
pub mod client_figures;
pub mod clients;
pub mod crews;
pub mod drawing;
pub mod error;
#[cfg(test)]
mod fixtures;
pub mod grid;
pub mod growth;
pub mod growth_text;
pub mod incomplete;
pub mod inside;
pub mod job;
pub mod journal;
pub mod launches;
mod lines;
pub mod manifest;
pub mod merge;
pub mod overview;
pub mod paired;
pub mod part;
pub mod pilot;
pub mod plan;
mod program_files;
pub mod record;
pub mod report;
pub mod row;
pub(crate) mod run_report;
pub mod seeds;
pub mod settings;
pub mod shard;
mod short;
pub mod summary;
pub mod table;
pub mod track;
pub mod workers;

pub use anees::{AneesText, anees};
pub use bands_text::Bands;
pub use cell::{Cell, Swept};
pub use error::SweepError;
pub use grid::{Axis, axes};
pub use growth::growth;
pub use growth_text::GrowthText;
pub use incomplete::Incomplete;
pub use job::{SweepJob, SweepOutcome};
pub use manifest::Manifest;
pub use merge::merge;
pub use overview::{OverviewText, overview};
pub use paired::ab;
pub use part::{Part, PartFault};
pub use pilot::run_time_s;
pub use plan::{Plan, Request};
pub use report::Report;
pub use row::Row;
pub use seeds::Seeds;
pub use shard::Shard;
pub use summary::{Summary, summary};
pub use table::Table;
pub use track::{Sample, Track};
