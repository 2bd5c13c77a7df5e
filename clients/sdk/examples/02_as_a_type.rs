//! The same as a type: `start` is told what an estimator may know, `tick`
//! answers. `run` does the rest: command line, joining, logs, goodbye, and a
//! panic that the server hears of.
use rusty_clients::prelude::*;

struct Wheels {
    drive: DiffDrive,
    pose_in_world: SE2,
    last: EncoderTicks,
}

impl Estimator for Wheels {
    fn start(start: &Start) -> Self {
        Wheels {
            drive: start.robot.drive,
            pose_in_world: start.initial_pose.unwrap_or_default(),
            last: EncoderTicks::default(),
        }
    }

    fn tick(&mut self, tick: &Tick) -> Reply {
        let delta = odometry_delta(self.last, tick.ticks(), &self.drive);
        self.last = tick.ticks();
        self.pose_in_world = self.pose_in_world.boxplus(&delta);
        self.pose_in_world.into()
    }
}

fn main() -> Exit {
    rusty_clients::run::<Wheels>()
}
