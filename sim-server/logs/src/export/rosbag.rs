//! All ticks of a log as a folder of rosbag2: an MCAP file, and a page about it.
//!
//! Source: the page `metadata.yaml` of rosbag2, version 5: the last one that Humble
//! reads; Jazzy and Kilted read it, too.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use rustix::fs::{CWD, RenameFlags, renameat_with};

use super::error::ExportError;
use super::mcap::{self, RosExported, RosOptions};

/// The page of a bag.
const PAGE: &str = "metadata.yaml";
/// How it begins.
const PAGE_HEAD: &str = "rosbag2_bagfile_information:\n";

/// Writes the ticks of `log` into the folder `out`: all of it or nothing. With
/// [`RosOptions::force`] it takes the place of a bag that is there, and of no other folder.
/// A link stays, and its bag is replaced.
///
/// # Errors
/// [`ExportError`]; nothing is written then.
pub fn export(
    log: &Path,
    out: &Path,
    options: &RosOptions,
    stop: &AtomicBool,
) -> Result<RosExported, ExportError> {
    let shown = out.display().to_string();
    let linked = out.canonicalize().ok().filter(|_| out.is_symlink());
    let out = linked.as_deref().unwrap_or(out);
    let failed = || ExportError::io(out);
    let is_there = fs::symlink_metadata(out).is_ok();
    if is_there && !options.force {
        return Err(ExportError::InTheWay(shown));
    }
    if is_there && !is_bag(out) {
        return Err(ExportError::NotABag(shown));
    }
    let name = out.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| ExportError::NotABag(shown.clone()))?;
    let parent = match out.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mode = fs::Permissions::from_mode(0o755);
    let made = tempfile::Builder::new().prefix(".export-").permissions(mode).tempdir_in(parent);
    let made = made.map_err(failed())?;
    let file = format!("{name}_0.mcap");
    let mut exported = mcap::export(log, &made.path().join(&file), options, stop)?;
    fs::write(made.path().join(PAGE), page(&exported, &file)).map_err(failed())?;
    // What was there goes where the new one was made, and is removed with it.
    let flags = if is_there { RenameFlags::EXCHANGE } else { RenameFlags::NOREPLACE };
    renameat_with(CWD, made.path(), CWD, out, flags).map_err(|e| failed()(e.into()))?;
    exported.path = shown;
    Ok(exported)
}

/// Whether there is a bag and nothing else in its folder.
fn is_bag(folder: &Path) -> bool {
    let Ok(page) = fs::read_to_string(folder.join(PAGE)) else { return false };
    let is_of_bag = |entry: fs::DirEntry| {
        let name = entry.file_name();
        let is_named = name.to_str().is_some_and(|name| name == PAGE || page.contains(name));
        is_named && entry.file_type().is_ok_and(|kind| kind.is_file())
    };
    let mut entries = fs::read_dir(folder).into_iter().flatten();
    page.starts_with(PAGE_HEAD) && entries.all(|entry| entry.is_ok_and(is_of_bag))
}

/// Returns the page. A text of JSON is one of YAML.
fn page(exported: &RosExported, file: &str) -> String {
    let text = |text: &str| serde_json::Value::from(text).to_string();
    let [first, last] = exported.span_ns.unwrap_or_default();
    let (span, count, file) = (last - first, exported.messages(), text(file));
    let topics: String = exported
        .topics
        .iter()
        .map(|topic| {
            format!(
                "    - topic_metadata:\n        name: {}\n        type: {}\n        \
                 serialization_format: cdr\n        offered_qos_profiles: {}\n      \
                 message_count: {}\n",
                text(&topic.name),
                topic.type_name,
                text(&topic.qos),
                topic.messages
            )
        })
        .collect();
    format!(
        "{PAGE_HEAD}  version: 5\n  storage_identifier: mcap\n  duration:\n    \
         nanoseconds: {span}\n  starting_time:\n    nanoseconds_since_epoch: {first}\n  \
         message_count: {count}\n  topics_with_message_count:\n{topics}  \
         compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {file}\n  \
         files:\n    - path: {file}\n      starting_time:\n        \
         nanoseconds_since_epoch: {first}\n      duration:\n        nanoseconds: {span}\n      \
         message_count: {count}\n"
    )
}
