//! The files of a recording: one MCAP file, or those of a folder of rosbag2.

use std::path::{Path, PathBuf};

use rusty_contract::input;
use serde::Deserialize;

use crate::import::ImportError;

/// Longest page that is read, bytes.
const MAX_PAGE_BYTES: u64 = 1 << 20;

/// The page of a bag, as far as it matters here.
#[derive(Deserialize)]
struct Page {
    rosbag2_bagfile_information: Information,
}

#[derive(Deserialize)]
struct Information {
    storage_identifier: String,
    #[serde(default)]
    relative_file_paths: Vec<String>,
    #[serde(default)]
    compression_mode: String,
}

/// Returns the files of `input`, which is a bag where `is_bag` says so.
pub(super) fn files(input: &Path, is_bag: bool) -> Result<Vec<PathBuf>, ImportError> {
    let ending = input.extension().unwrap_or_default();
    // A folder may have any name.
    if (ending == "bag" || ending == "db3") && !input.is_dir() {
        return Err(other_storage(input, &ending.to_string_lossy()));
    }
    if !is_bag {
        return Ok(vec![input.to_owned()]);
    }
    let path = input.join("metadata.yaml");
    let text = input::read_text_at_most(&path, MAX_PAGE_BYTES).map_err(|error| {
        let problem = format!(
            "{error}; expected a folder of rosbag2, which has this file: for an MCAP file alone \
             use `sim-server import mcap`"
        );
        ImportError::file(&path, problem)
    })?;
    let page: Page = serde_saphyr::from_str(&text).map_err(|error| {
        let problem = format!("{}; expected the page of a rosbag2", error.to_string().trim());
        ImportError::file(&path, problem)
    })?;
    let Information { storage_identifier, relative_file_paths, compression_mode } =
        page.rosbag2_bagfile_information;
    if storage_identifier != "mcap" {
        return Err(other_storage(input, &storage_identifier));
    }
    if !["", "none"].contains(&&*compression_mode.to_ascii_lowercase()) {
        let storage = format!("mcap packed by {compression_mode}");
        return Err(other_storage(input, &storage));
    }
    // Old pages have the folder in front; no page leads out of the folder.
    let file = |name: &String| Some(input.join(Path::new(name).file_name()?));
    let files: Vec<PathBuf> = relative_file_paths.iter().filter_map(file).collect();
    if files.is_empty() {
        let problem = "relative_file_paths: expected the files of the bag, got none; record again";
        return Err(ImportError::file(&path, problem));
    }
    Ok(files)
}

fn other_storage(input: &Path, storage: &str) -> ImportError {
    let problem = format!(
        "expected storage mcap, got {storage}; convert it: pip install rosbags, then \
         rosbags-convert --src {} --dst bag --dst-storage mcap",
        input.display()
    );
    ImportError::file(input, problem)
}
