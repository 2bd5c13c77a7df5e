//! Scripts: where the command of a tick comes from.
//!
//! A command is held for one tick. All built-in scripts but one are open loop; the
//! truth-steered patrol looks at the true pose, see [`crate::steering`]. The
//! encoders follow the commands to a count, so that a patrol steered by odometry
//! would be the open-loop one.

use rusty_contract::{Frame, ScriptConfig};
use rusty_geometry::{SE2, Twist};

use crate::patrol::{Patrol, whole_ticks};
use crate::steering::Steering;

/// A source of commands: a built-in script, a closure, or a type of yours.
/// [`record`](crate::record()) drives a robot with it.
pub trait Script {
    /// The command of the tick that begins, body frame, not yet limited to what the
    /// wheels can do.
    fn command(&mut self, moment: &Moment<'_>) -> Twist;

    /// The configuration with which a scenario gives the same commands. A script
    /// without one is recorded as a list of its commands.
    fn config(&self) -> Option<ScriptConfig> {
        None
    }
}

/// The beginning of a tick, as a script sees it.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// Index of the tick that begins.
    pub tick: u64,
    /// Time at its beginning, s.
    pub time_s: f64,
    /// The frame of the tick before, which is all that a driver sees; `None` in tick 0.
    pub frame: Option<&'a Frame>,
    /// The true pose, world frame. No driver knows it: commands that depend on it give
    /// it away to everyone who sees them.
    pub truth: SE2,
}

/// A closure is a script.
impl<F: FnMut(&Moment<'_>) -> Twist> Script for F {
    fn command(&mut self, moment: &Moment<'_>) -> Twist {
        self(moment)
    }
}

/// A script that a scenario can name.
#[derive(Clone, Debug)]
pub struct BuiltInScript {
    kind: Kind,
    config: ScriptConfig,
}

impl Script for BuiltInScript {
    /// A driven robot stands: there is no driver here.
    fn command(&mut self, moment: &Moment<'_>) -> Twist {
        self.command_at(moment.tick, &moment.truth, None)
    }

    fn config(&self) -> Option<ScriptConfig> {
        (!self.config.is_driver()).then(|| self.config.clone())
    }
}

impl Script for Patrol {
    fn command(&mut self, moment: &Moment<'_>) -> Twist {
        self.command_at(moment.tick)
    }
}

impl Script for Steering {
    fn command(&mut self, moment: &Moment<'_>) -> Twist {
        self.command_at(moment.tick, &moment.truth)
    }
}

#[derive(Clone, Debug)]
enum Kind {
    Patrol(Patrol),
    TruthSteeredPatrol(Steering),
    FigureEight { left: Twist, half: u64 },
    Straight(Twist),
    Commands,
    Driver,
}

impl BuiltInScript {
    /// The script of `config` in ticks of `dt_s` seconds for a robot that starts
    /// at `start`, world frame. The configuration must be checked, see
    /// [`ScriptConfig::check`]. Times are rounded to whole ticks.
    #[must_use]
    pub fn new(config: &ScriptConfig, dt_s: f64, start: SE2) -> Self {
        let kind = match config {
            ScriptConfig::Patrol(patrol) => Kind::Patrol(Patrol::new(patrol, dt_s)),
            ScriptConfig::TruthSteeredPatrol(patrol) => {
                Kind::TruthSteeredPatrol(Steering::new(Patrol::new(patrol, dt_s), dt_s, start))
            }
            ScriptConfig::FigureEight { v_m_s, omega_rad_s, half_s } => Kind::FigureEight {
                left: Twist { v_m_s: *v_m_s, omega_rad_s: *omega_rad_s },
                // A circle shorter than a tick still takes one.
                half: whole_ticks(*half_s, dt_s).max(1),
            },
            ScriptConfig::Straight { v_m_s } => {
                Kind::Straight(Twist { v_m_s: *v_m_s, omega_rad_s: 0.0 })
            }
            ScriptConfig::Commands { .. } => Kind::Commands,
            ScriptConfig::Driver {} => Kind::Driver,
        };
        Self { kind, config: config.clone() }
    }

    /// The command of tick `tick`, body frame, not yet limited to what wheels
    /// can do. `truth` is the true pose before that tick, world frame. `driver`
    /// is the driver's latest command: without one a driven robot stands, and
    /// every other script ignores it. A list of commands that is used up stands.
    #[must_use]
    pub fn command_at(&mut self, tick: u64, truth: &SE2, driver: Option<Twist>) -> Twist {
        match &mut self.kind {
            Kind::Patrol(patrol) => patrol.command_at(tick),
            Kind::TruthSteeredPatrol(steering) => steering.command_at(tick, truth),
            Kind::FigureEight { left, half } => {
                let turn_left = (tick / *half).is_multiple_of(2);
                Twist {
                    v_m_s: left.v_m_s,
                    omega_rad_s: if turn_left { left.omega_rad_s } else { -left.omega_rad_s },
                }
            }
            Kind::Straight(command) => *command,
            Kind::Commands => match &self.config {
                ScriptConfig::Commands { list, .. } => usize::try_from(tick)
                    .ok()
                    .and_then(|index| list.get(index))
                    .copied()
                    .unwrap_or_default(),
                _ => Twist::default(),
            },
            Kind::Driver => driver.unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::config::PatrolConfig;

    fn twist(v_m_s: f64, omega_rad_s: f64) -> Twist {
        Twist { v_m_s, omega_rad_s }
    }

    fn script(config: ScriptConfig, dt_s: f64) -> impl FnMut(u64) -> Twist {
        let mut script = BuiltInScript::new(&config, dt_s, SE2::identity());
        move |tick| script.command_at(tick, &SE2::identity(), Some(twist(9.0, 9.0)))
    }

    #[test]
    fn the_figure_eight_changes_sides_every_524_ticks() {
        let mut command =
            script(ScriptConfig::FigureEight { v_m_s: 0.5, omega_rad_s: 0.6, half_s: 10.48 }, 0.02);
        for (tick, omega_rad_s) in [(0, 0.6), (523, 0.6), (524, -0.6), (1047, -0.6), (1048, 0.6)] {
            assert_eq!(command(tick), twist(0.5, omega_rad_s), "tick {tick}");
        }
    }

    #[test]
    fn a_list_is_followed_and_then_the_robot_stands() {
        let list = vec![twist(0.1, 0.0), twist(0.2, -0.3)];
        let mut command = script(ScriptConfig::Commands { file: None, list }, 0.1);
        assert_eq!(command(0), twist(0.1, 0.0));
        assert_eq!(command(1), twist(0.2, -0.3));
        assert_eq!(command(2), Twist::default());
        assert_eq!(command(u64::MAX), Twist::default());
    }

    #[test]
    fn only_a_driven_robot_listens_to_the_driver() {
        assert_eq!(script(ScriptConfig::Driver {}, 0.1)(5), twist(9.0, 9.0));
        let straight = ScriptConfig::Straight { v_m_s: 0.4 };
        assert_eq!(script(straight, 0.1)(5), twist(0.4, 0.0));
        let mut driven = BuiltInScript::new(&ScriptConfig::Driver {}, 0.1, SE2::identity());
        assert_eq!(driven.command_at(0, &SE2::identity(), None), Twist::default());
    }

    #[test]
    fn steering_on_the_plan_is_the_plan() {
        let patrol = PatrolConfig::default();
        let start = SE2::new(6.0, 4.5, 0.2);
        let mut plain = BuiltInScript::new(&ScriptConfig::Patrol(patrol), 0.1, start);
        let mut steered = BuiltInScript::new(&ScriptConfig::TruthSteeredPatrol(patrol), 0.1, start);
        let mut pose = start;
        for tick in 0..300 {
            let plan = plain.command_at(tick, &pose, None);
            let command = steered.command_at(tick, &pose, None);
            assert!((plan.v_m_s - command.v_m_s).abs() < 1e-12);
            assert!((plan.omega_rad_s - command.omega_rad_s).abs() < 1e-12);
            let tau = nalgebra::Vector3::new(plan.v_m_s * 0.1, 0.0, plan.omega_rad_s * 0.1);
            pose = pose.boxplus(&tau);
        }
    }

    #[test]
    fn steering_turns_back_to_the_plan() {
        let config = ScriptConfig::TruthSteeredPatrol(PatrolConfig::default());
        let mut steered = BuiltInScript::new(&config, 0.1, SE2::identity());
        // In tick 10 the plan drives; the robot lags behind, left of it, turned left.
        let planned_m: f64 = (0..10)
            .map(|tick| Patrol::new(&PatrolConfig::default(), 0.1).command_at(tick).v_m_s * 0.1)
            .sum();
        let truth = SE2::new(planned_m - 0.1, 0.05, 0.2);
        let command = steered.command_at(10, &truth, None);
        assert!(command.v_m_s > 0.57 && command.omega_rad_s < 0.0);
        // By hand: R(−0.2)(0.1, −0.05), e_θ = −0.2.
        assert!((command.v_m_s - (0.57 + 0.088_073_19)).abs() < 1e-8, "{command:?}");
        let expected_rad_s = -0.3 + 2.0 * 0.57 * -0.068_870_26;
        assert!((command.omega_rad_s - expected_rad_s).abs() < 1e-8, "{command:?}");
        // Out of order gives the same: the command is a function of tick and truth.
        let _ = steered.command_at(200, &truth, None);
        assert_eq!(steered.command_at(10, &truth, None), command);
    }
}
