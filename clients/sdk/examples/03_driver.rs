//! A driver: an estimator whose command moves the robot. It goes straight
//! until the scan shows something within half a metre ahead, then turns left.
//! Use it with `[script] kind = "driver"` and `role = "driver"`.
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::prelude::*;

struct Bouncer {
    odometry: DeadReckoning,
    /// Beams within 20° of straight ahead.
    ahead: std::ops::Range<usize>,
    blocked: bool,
}

impl Filter for Bouncer {
    fn update(&mut self, tick: &Tick) -> Reply {
        let pose = self.odometry.advance(tick.encoders());
        if let Some(ranges_m) = tick.ranges_m() {
            self.blocked = ranges_m[self.ahead.clone()].iter().any(|r| *r < 0.5);
        }
        let command = if self.blocked {
            Twist { v_m_s: 0.0, omega_rad_s: 1.0 }
        } else {
            Twist { v_m_s: 0.4, omega_rad_s: 0.0 }
        };
        Reply::Both(pose.into(), command)
    }
}

fn main() -> Exit {
    rusty_clients::run(|start, ()| {
        let ahead = |k: &u32| start.lidar.bearing_rad(*k).abs() < 0.35;
        let first = (0..start.lidar.beams).find(ahead).unwrap_or(0) as usize;
        let count = (0..start.lidar.beams).filter(ahead).count();
        let odometry = DeadReckoning::of_start(start);
        Ok(Bouncer { odometry, ahead: first..first + count, blocked: false })
    })
}
