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
        "{path} is not a file of bench reports of this version ({error}); remove it and measure \
         all: `sim-server bench page --write PAGE`"
    )]
    NoDocuments {
        /// Which.
        path: String,
        /// What the parser said.
        error: serde_json::Error,
    },
    /// A benchmark has no report, or one that is not of this version or was changed.
    #[error("the report of bench {bench} {problem}; measure it: add --only {bench}")]
    Report {
        /// The benchmark.
        bench: String,
        /// What is wrong with it.
        problem: String,
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
    /// The template has a placeholder without a value.
    #[error(
        "the template of the page has {{{name}}}, which is neither a benchmark nor one of its \
         facts: use {{goals}}, {{BENCH}} or {{BENCH.FACT}}"
    )]
    StrayPlaceholder {
        /// The text between the braces.
        name: String,
    },
}

impl PageError {
    /// The exit code that goes with it.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::NoSuchBench { .. } | Self::NoDocuments { .. } | Self::StrayPlaceholder { .. } => {
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
