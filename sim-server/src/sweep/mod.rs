//! Many runs: every seed in every cell of a grid of settings.
//!
//! In reading order:
//!
//! * [`seeds`], [`grid`], [`shard`], [`plan`]: what there is to do;
//! * [`cell`], [`row`], [`track`], [`record`]: what comes of it;
//! * [`workers`]: runs side by side, made [`inside`] or with [`clients`];
//! * [`journal`]: what is done, while the rest is not;
//! * [`table`], [`settings`]: what is written in the end;
//! * [`sweeping`]: all of it together;
//! * [`error`].

pub mod cell;
pub mod clients;
pub mod error;
pub mod grid;
pub mod inside;
pub mod journal;
pub mod plan;
pub mod record;
pub mod row;
pub mod seeds;
pub mod settings;
pub mod shard;
pub mod sweeping;
pub mod table;
pub mod track;
pub mod workers;

pub use cell::{Cell, Swept};
pub use error::SweepError;
pub use grid::Axis;
pub use plan::{Plan, Request};
pub use row::Row;
pub use seeds::Seeds;
pub use shard::Shard;
pub use sweeping::{Came, Sweeping};
pub use table::Table;
pub use track::{Sample, Track};
