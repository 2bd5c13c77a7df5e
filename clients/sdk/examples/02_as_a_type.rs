//! The same as a type: `update` answers a tick. `run` does the rest: command line,
//! joining, logs, and the report of a panic to the server.
use rusty_clients::prelude::*;

struct Wheels {
    drive: DiffDrive,
    pose_in_world: SE2,
    last: EncoderCounts,
}

impl Filter for Wheels {
    fn update(&mut self, tick: &Tick) -> Reply {
        let delta = odometry_delta(self.last, tick.encoders(), &self.drive);
        self.last = tick.encoders();
        self.pose_in_world = self.pose_in_world.boxplus(&delta);
        self.pose_in_world.into()
    }
}

fn main() -> Exit {
    rusty_clients::run(|start, ()| {
        Ok(Wheels {
            drive: start.robot.drive,
            pose_in_world: start.initial_pose.unwrap_or_default(),
            last: EncoderCounts::default(),
        })
    })
}
