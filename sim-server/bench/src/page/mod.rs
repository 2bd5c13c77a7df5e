//! `bench page`: the page of all benches, made from their documents.
//!
//! * [`benches`]: which benches are on it;
//! * [`documents`]: what they measured, kept in a file beside the page, so that
//!   the page can be made again without measuring;
//! * [`notes`]: what people wrote about it, kept in another file;
//! * [`markdown`]: the page;
//! * [`peers`]: the section of a bench that is another program's.
//!
//! A number stands on the page because a bench printed it, and a goal is met or
//! missed by what it says; only the explanations are written by hand.

pub mod benches;
pub mod documents;
pub mod error;
pub mod markdown;
pub mod notes;
pub mod peers;

pub use benches::BENCHES;
pub use documents::Documents;
pub use error::PageError;
pub use notes::Notes;

pub use crate::section::{Finding, Section, Table};
