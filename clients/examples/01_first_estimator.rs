//! The smallest working estimator: wheels to pose.
use rusty_clients::prelude::*;

struct First(SE2, EncoderTicks, DiffDrive);

impl Estimator for First {
    fn start(start: &Start) -> Self {
        First(start.initial_pose.unwrap_or_default(), EncoderTicks::default(), start.robot.drive)
    }
    fn tick(&mut self, tick: &Tick) -> Reply {
        self.0 = self.0.boxplus(&odometry_delta(self.1, tick.ticks(), &self.2));
        self.1 = tick.ticks();
        self.0.into()
    }
}

fn main() -> Exit {
    rusty_clients::run::<First>()
}
