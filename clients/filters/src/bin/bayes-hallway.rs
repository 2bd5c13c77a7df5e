//! `bayes-hallway`: localises the robot in a corridor by its doors.

use rusty_contract::Exit;
use rusty_filters::bayes_hallway::{BayesHallway, Options};

fn main() -> Exit {
    rusty_clients::run(|start, options: Options| BayesHallway::new(start, &options))
}
