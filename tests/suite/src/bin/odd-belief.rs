//! A filter of dead reckoning whose beliefs are odd in the way it is told:
//! `nan`, `many`, `empty`, `panic`, or `none`.

use rusty_clients::prelude::*;

#[derive(clap::Args)]
struct Options {
    #[arg(long, default_value = "none")]
    odd: String,
}

struct Odd {
    odd: String,
    drive: DiffDrive,
    pose_in_world: SE2,
    last: EncoderCounts,
}

impl Filter for Odd {
    const SHOWS_BELIEF: bool = true;

    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        let moved = odometry_delta(self.last, tick.encoders(), &self.drive);
        self.last = tick.encoders();
        self.pose_in_world = self.pose_in_world.boxplus(&moved);
        self.pose_in_world.into()
    }

    fn belief(&self, poses: &mut Vec<WeightedPose>) -> Option<BeliefKind> {
        let sound = WeightedPose { x_m: 1.0, y_m: 2.0, theta_rad: 0.5, weight: 0.5 };
        match self.odd.as_str() {
            "nan" => {
                poses.extend([sound, WeightedPose { x_m: f64::NAN, ..sound }]);
                poses.push(WeightedPose { weight: -1.0, ..sound });
            }
            "many" => poses.resize(100_000, sound),
            "panic" => panic!("on request"),
            "none" => return None,
            _ => {}
        }
        Some(BeliefKind::Histogram)
    }
}

fn main() -> Exit {
    rusty_clients::run(|start, Options { odd }| {
        let (drive, last) = (start.robot.drive, EncoderCounts::default());
        Ok(Odd { odd, drive, pose_in_world: start.initial_pose.unwrap_or_default(), last })
    })
}
