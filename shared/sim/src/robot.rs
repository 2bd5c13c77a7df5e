//! The robot as it truly is: one tick of a differential drive that slips.
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, Algorithm
//! `diff_drive_step`. With wheel rates ω_L, ω_R from the command, wheel radius r
//! and ε_L, ε_R ~ N(0, σ²):
//!
//! * wheel angles += ω·dt, always: this is what the encoders see;
//! * Δs_L = r·ω_L·dt·(1 + ε_L), Δs_R = r·(1 + δ)·ω_R·dt·(1 + ε_R): this is what
//!   the floor delivers;
//! * x ← x ⊞ (½(Δs_R + Δs_L), 0, (Δs_R − Δs_L)/(ℓ·(1 + ε))), the exact arc,
//!   unless it touches a wall.
//!
//! [`crate::slip`] has ε_L, ε_R and their departures. The gap between the first line and the second is all that odometry can never
//! know. σ is per tick on purpose: it is not scaled by √dt.
//!
//! Departures: the whole arc is tested against the walls with the whole body, a
//! disc, where the chapter tests the segment between the two centres; commands
//! beyond the wheels' limit are scaled down first; the track may be off by ε,
//! the other systematic error of J. Borenstein and L. Feng (1996).

use rusty_contract::RobotConfig;
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, Twist};

use crate::outcome::StepOutcome;
use crate::scene::Scene;

/// The robot: true parameters and true state.
#[derive(Clone, Debug)]
pub struct Robot {
    /// As its controller believes it to be.
    drive: DiffDrive,
    /// ℓ·(1 + ε) in place of ℓ.
    true_drive: DiffDrive,
    body_radius_m: f64,
    wheel_limit_rad_s: f64,
    /// r·(1 + δ).
    right_radius_m: f64,
    pose_in_world: SE2,
    /// Where the step that was blocked last would have led.
    blocked_on_way_to: SE2,
    wheel_angles_rad: [f64; 2],
}

impl Robot {
    /// A robot that stands at `start` (world frame) with both wheel angles zero.
    /// The configuration must be checked, see [`RobotConfig::check`].
    #[must_use]
    pub fn new(config: &RobotConfig, start: SE2) -> Self {
        let drive = config.nominal().drive;
        Self {
            drive,
            true_drive: DiffDrive { track_m: drive.track_m * (1.0 + config.track_bias), ..drive },
            body_radius_m: config.body_radius_m,
            wheel_limit_rad_s: config.wheel_limit_rad_s,
            right_radius_m: config.wheel_radius_m * (1.0 + config.radius_bias_right),
            pose_in_world: start,
            blocked_on_way_to: start,
            wheel_angles_rad: [0.0, 0.0],
        }
    }

    /// Takes other parameters and stays where it is, with its wheels as they
    /// are. The configuration must be checked, see [`RobotConfig::check`].
    pub fn reconfigure(&mut self, config: &RobotConfig) {
        let (pose_in_world, wheel_angles_rad) = (self.pose_in_world, self.wheel_angles_rad);
        *self = Self { wheel_angles_rad, ..Self::new(config, pose_in_world) };
    }

    /// `command` as the wheels can follow it: see [`DiffDrive::limit`]. A command
    /// that is not finite comes back as standing still.
    #[must_use]
    pub fn limit(&self, command: Twist) -> Twist {
        self.drive.limit(command, self.wheel_limit_rad_s)
    }

    /// One tick of `dt_s` seconds with the constant command `applied` (body
    /// frame, already limited) and the slips ε of both wheels, `[left, right]`.
    pub fn step<'a>(
        &mut self,
        scene: impl Into<Scene<'a>>,
        applied: Twist,
        dt_s: f64,
        slip: [f64; 2],
    ) -> StepOutcome {
        let rates = self.drive.wheel_rates(applied);
        let turned_rad = [rates.left_rad_s * dt_s, rates.right_rad_s * dt_s];
        self.wheel_angles_rad[0] += turned_rad[0];
        self.wheel_angles_rad[1] += turned_rad[1];

        let grip = slip.map(|slip| 1.0 + slip);
        let ds_left_m = self.drive.wheel_radius_m * turned_rad[0] * grip[0];
        let ds_right_m = self.right_radius_m * turned_rad[1] * grip[1];
        let tau = self.true_drive.tangent(ds_left_m, ds_right_m);
        let next = self.pose_in_world.boxplus(&tau);
        if scene.into().blocks(&self.pose_in_world, &next, self.body_radius_m) {
            self.blocked_on_way_to = next;
            return StepOutcome::Blocked;
        }
        self.pose_in_world = next;
        StepOutcome::Moved { ds_m: tau.x, dtheta_rad: tau.z }
    }

    /// The robot is lifted and put down elsewhere. Its wheels do not turn.
    pub fn put(&mut self, pose_in_world: SE2) {
        self.pose_in_world = pose_in_world;
    }

    /// The true pose, world frame.
    #[must_use]
    pub fn pose_in_world(&self) -> SE2 {
        self.pose_in_world
    }

    /// Where the step that was blocked last would have led.
    #[must_use]
    pub fn blocked_on_way_to(&self) -> SE2 {
        self.blocked_on_way_to
    }

    /// How far the wheels have turned since the start, `[left, right]`, rad.
    #[must_use]
    pub fn wheel_angles_rad(&self) -> [f64; 2] {
        self.wheel_angles_rad
    }

    /// What the encoders show: the cumulative angles in whole counts. Rounding
    /// the sum and not the increments keeps the error below one count for ever.
    #[must_use]
    pub fn encoder_ticks(&self) -> EncoderCounts {
        EncoderCounts::from_wheel_angles(self.wheel_angles_rad, self.drive.ticks_per_rev)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{apartment, open};

    const AHEAD: Twist = Twist { v_m_s: 0.5, omega_rad_s: 0.0 };

    fn rusty(start: SE2) -> Robot {
        Robot::new(&RobotConfig::default(), start)
    }

    #[test]
    fn worked_example_of_one_step() {
        // Wheels lay down 0.72 m and 0.88 m: Δs = 0.80, Δθ = 1.00.
        let mut robot = rusty(SE2::identity());
        let command = Twist { v_m_s: 0.8, omega_rad_s: 1.0 };
        let outcome = robot.step(&open(), command, 1.0, [0.0, 0.0]);
        let StepOutcome::Moved { ds_m, dtheta_rad } = outcome else {
            panic!("{outcome:?}");
        };
        assert!((ds_m - 0.8).abs() < 1e-14 && (dtheta_rad - 1.0).abs() < 1e-14);
        let pose = robot.pose_in_world();
        assert!((pose.x() - 0.673_176_788).abs() < 1e-9);
        assert!((pose.y() - 0.367_758_155).abs() < 1e-9);
        let ticks = robot.encoder_ticks();
        assert_eq!((ticks.left, ticks.right), (14_223, 17_384));
    }

    #[test]
    fn slip_moves_the_floor_and_not_the_wheels() {
        let (mut plain, mut slips) = (rusty(SE2::identity()), rusty(SE2::identity()));
        let world = open();
        let _ = plain.step(&world, AHEAD, 0.1, [0.0, 0.0]);
        let outcome = slips.step(&world, AHEAD, 0.1, [0.02, 0.02]);
        assert_eq!(plain.wheel_angles_rad(), slips.wheel_angles_rad());
        let StepOutcome::Moved { ds_m, dtheta_rad } = outcome else {
            panic!("{outcome:?}");
        };
        assert!((ds_m - 0.05 * 1.02).abs() < 1e-15);
        assert_eq!(dtheta_rad, 0.0);
    }

    #[test]
    fn a_larger_right_wheel_turns_the_robot_left() {
        let config = RobotConfig { radius_bias_right: 0.01, ..RobotConfig::default() };
        let mut robot = Robot::new(&config, SE2::identity());
        let _ = robot.step(&open(), AHEAD, 1.0, [0.0, 0.0]);
        let expected_rad = 0.01 * 0.5 / 0.16;
        assert!((robot.pose_in_world().theta() - expected_rad).abs() < 1e-14);
    }

    #[test]
    fn a_track_longer_than_believed_turns_the_robot_less() {
        let config = RobotConfig { track_bias: 0.01, ..RobotConfig::default() };
        let mut robot = Robot::new(&config, SE2::identity());
        let spin = Twist { v_m_s: 0.0, omega_rad_s: 1.0 };
        let _ = robot.step(&open(), spin, 1.0, [0.0, 0.0]);
        assert!((robot.pose_in_world().theta() - 1.0 / 1.01).abs() < 1e-14);
        // The wheels turn as for the track that was said.
        let mut plain = rusty(SE2::identity());
        let _ = plain.step(&open(), spin, 1.0, [0.0, 0.0]);
        assert_eq!(robot.wheel_angles_rad(), plain.wheel_angles_rad());
    }

    #[test]
    fn a_blocked_robot_stays_while_its_wheels_count_on() {
        // Head-on into the wall x = 12 of the living room.
        let world = apartment();
        let mut robot = rusty(SE2::new(11.0, 3.0, 0.0));
        let mut outcomes = Vec::new();
        for _ in 0..30 {
            outcomes.push(robot.step(&world, AHEAD, 0.1, [0.0, 0.0]));
        }
        let first = outcomes.iter().position(|o| *o == StepOutcome::Blocked);
        // 0.89 m of free way at 0.05 m a tick: 17 ticks, and the 18th is blocked.
        assert_eq!(first, Some(17), "{outcomes:?}");
        assert!(outcomes[17..].iter().all(|o| *o == StepOutcome::Blocked));
        let pose = robot.pose_in_world();
        assert!((pose.x() - 11.85).abs() < 1e-12 && pose.y() == 3.0);
        let counted_m = robot.wheel_angles_rad()[0] * 0.033;
        assert!((counted_m - 1.5).abs() < 1e-12, "{counted_m}");
    }

    #[test]
    fn commands_are_limited_before_they_reach_the_wheels() {
        let robot = rusty(SE2::identity());
        let fast = robot.limit(Twist { v_m_s: 2.0, omega_rad_s: 0.0 });
        assert!((fast.v_m_s - 20.0 * 0.033).abs() < 1e-12);
        assert_eq!(robot.limit(AHEAD), AHEAD);
    }
}
