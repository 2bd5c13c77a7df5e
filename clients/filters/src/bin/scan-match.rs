//! `scan-match`: odometry by matching scans.

use rusty_contract::Exit;
use rusty_filters::scan_match::{ScanMatch, ScanMatchOptions};

fn main() -> Exit {
    rusty_clients::run(|start, options: ScanMatchOptions| Ok(ScanMatch::new(start, &options)))
}
