//! `ekf`: follows the robot on a floor plan by its straight walls.

use rusty_contract::Exit;
use rusty_filters::ekf::{Ekf, Options};

fn main() -> Exit {
    rusty_clients::run(|start, options: Options| Ekf::new(start, &options))
}
