//! What can go wrong with the page.

use rusty_contract::Exit;
use thiserror::Error;

/// Why there is no page.
#[derive(Debug, Error)]
pub enum PageError {
    /// A file cannot be read or written.
    #[error("{path}: {error}")]
    Io {
        /// Which.
        path: String,
        /// What the operating system said.
        error: std::io::Error,
    },
    /// A file holds something else.
    #[error(
        "{path} is no file of bench documents ({error}); one is written by \
         `sim-server bench page --write PAGE`"
    )]
    NoDocuments {
        /// Which.
        path: String,
        /// What the parser said.
        error: serde_json::Error,
    },
    /// A bench is not among the documents.
    #[error("there is no document of bench {bench}; measure it: add --only {bench}")]
    Missing {
        /// Which.
        bench: &'static str,
    },
    /// A document has another form than this version's.
    #[error(
        "the document of bench {bench} is not of this version ({error}); measure it again: \
         add --only {bench}"
    )]
    OldDocument {
        /// Which.
        bench: &'static str,
        /// What does not fit.
        error: serde_json::Error,
    },
    /// A document's results do not belong to its hash.
    #[error(
        "the results of bench {bench} were changed after they were measured: their hash is \
         another one; measure it again: add --only {bench}"
    )]
    Changed {
        /// Which.
        bench: &'static str,
    },
    /// No such bench.
    #[error("there is no bench {name:?} on the page; there are: {known}")]
    NoSuchBench {
        /// Asked for.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// A bench failed.
    #[error("`sim-server bench {bench}` failed ({how}); its own words stand above")]
    Failed {
        /// Which.
        bench: &'static str,
        /// Exit code or signal.
        how: String,
        /// Whether it said that bits differ.
        not_exact: bool,
    },
    /// The notes speak of something that is not there.
    #[error("{path} has a note on {key:?}, which is neither a goal nor a bench; known: {known}")]
    StrayNote {
        /// The notes.
        path: String,
        /// The heading.
        key: String,
        /// All headings that there may be.
        known: String,
    },
}

impl PageError {
    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::NoSuchBench { .. } | Self::NoDocuments { .. } | Self::StrayNote { .. } => {
                Exit::Usage
            }
            Self::Failed { not_exact: true, .. } => Exit::NotBitExact,
            _ => Exit::Failed,
        }
    }

    /// Wraps an error about a file.
    pub(super) fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.display().to_string();
        move |error| Self::Io { path, error }
    }
}
