//! Where a participant writes.

use std::path::{Path, PathBuf};

use rusty_contract::Brief;
use rusty_contract::output::make_folder;

use crate::{ClientArgs, ClientError};

/// Returns the folder that a recorder writes to, and makes it: `--out`, or the run's
/// folder, or that of the log.
///
/// # Errors
/// [`ClientError::Io`] names the folder that cannot be made.
pub fn output_folder(brief: &Brief, args: &ClientArgs) -> Result<PathBuf, ClientError> {
    let folder = match (&args.out, &brief.out_dir) {
        (Some(out), _) => out.clone(),
        (None, Some(out)) => PathBuf::from(out),
        (None, None) => {
            args.log.as_ref().and_then(|log| log.parent().map(Path::to_owned)).unwrap_or_default()
        }
    };
    if !folder.as_os_str().is_empty() {
        make_folder(&folder).map_err(ClientError::io(&folder))?;
    }
    Ok(folder)
}
