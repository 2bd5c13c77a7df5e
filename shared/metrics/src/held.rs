//! In how many ticks something held the robot.
//!
//! A simulated robot that would touch a wall or a body stays where it is while its wheels
//! and their encoders go on ([`rusty_geometry::World::blocks`] decides). No field
//! of a frame reports it, but truth and command show it, without a tolerance. A
//! tick that moves sets the pose to pose ⊞ τ, a tick that is blocked does not
//! touch its bits. So a pose with the same bits as before, under a command from
//! which the nominal wheels make another pose, is that of a robot that was held.
//!
//! Two cases decide nothing wrong but are worth a word. A command so small that
//! pose ⊞ τ rounds to the pose it began with (below 10⁻¹⁵ m) leaves no trace
//! whether it was blocked or not, and does not count. And a wheel could slip by
//! exactly what it turned; of ε ~ N(0, 0.02²) that is an event of 50 σ.

use rusty_contract::log::Source;
use rusty_contract::{Kidnapping, LogHeader, RunConfig};
use rusty_geometry::{DiffDrive, SE2, Twist};

/// Counts the ticks in which something held the robot.
#[derive(Clone, Debug)]
pub struct Held {
    drive: DiffDrive,
    dt_s: f64,
    /// The last true pose, while every tick up to now had one.
    before: Option<SE2>,
    /// Where the robot is put, and at the start of which tick.
    carried: Vec<(u64, SE2)>,
    next_carried: usize,
    ticks: u64,
}

impl Held {
    /// Of a run with this header, before its first tick. `None` for what was not
    /// simulated: a real robot has no command in its frames, and is never still
    /// to the bit.
    #[must_use]
    pub fn of(header: &LogHeader) -> Option<Self> {
        matches!(header.source, Source::Simulated | Source::Forked { .. })
            .then(|| Self::of_run(&header.config, header.kidnappings()))
    }

    /// Of a simulated run, before its first tick.
    pub fn of_run<'k>(
        config: &RunConfig,
        kidnappings: impl IntoIterator<Item = &'k Kidnapping>,
    ) -> Self {
        Self {
            drive: config.robot.nominal().drive,
            dt_s: config.dt_s,
            before: Some(config.start),
            carried: kidnappings.into_iter().map(|k| (k.tick, k.to)).collect(),
            next_carried: 0,
            ticks: 0,
        }
    }

    /// A tick with its true pose at the end, where known, and the command that
    /// was applied in it.
    pub fn push(&mut self, tick: u64, truth: Option<SE2>, command: Twist) {
        while let Some((_, to)) = self.carried.get(self.next_carried).filter(|(at, _)| *at <= tick)
        {
            self.before = Some(*to);
            self.next_carried += 1;
        }
        if let (Some(before), Some(truth)) = (self.before, truth)
            && bits(&before) == bits(&truth)
        {
            let rates = self.drive.wheel_rates(command);
            let turned_m = |rate_rad_s: f64| rate_rad_s * self.dt_s * self.drive.wheel_radius_m;
            let tau = self.drive.tangent(turned_m(rates.left_rad_s), turned_m(rates.right_rad_s));
            self.ticks += u64::from(bits(&before.boxplus(&tau)) != bits(&before));
        }
        self.before = truth;
    }

    /// How many it were.
    #[must_use]
    pub fn tick_count(&self) -> u64 {
        self.ticks
    }
}

fn bits(pose: &SE2) -> [u64; 3] {
    [pose.x(), pose.y(), pose.theta()].map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_contract::Scenario;

    /// The header of a run of the first scenario.
    fn header() -> LogHeader {
        let world = rusty_geometry::apartment().spec().clone();
        LogHeader::simulated("test", &Scenario::default(), world)
    }

    const AHEAD: Twist = Twist { v_m_s: 0.5, omega_rad_s: 0.0 };

    #[test]
    fn who_stands_under_a_command_is_held_and_who_is_told_to_stand_is_not() {
        let mut held = Held::of(&header()).unwrap();
        let start = header().config.start;
        let on = start.boxplus(&nalgebra::Vector3::new(0.01, 0.0, 0.0));
        let none = Twist::default();
        let tiny = Twist { v_m_s: 1e-16, omega_rad_s: 0.0 };
        let turn = Twist { v_m_s: 0.0, omega_rad_s: -1.0 };
        // Held in the first tick already; then moved; stood; held twice; crept.
        for (tick, (truth, command)) in
            [(start, AHEAD), (on, AHEAD), (on, none), (on, AHEAD), (on, turn), (on, tiny)]
                .into_iter()
                .enumerate()
        {
            held.push(tick as u64, Some(truth), command);
        }
        assert_eq!(held.tick_count(), 3);
        // Between unknown truths it is unknown.
        held.push(6, None, AHEAD);
        held.push(7, Some(on), AHEAD);
        assert_eq!(held.tick_count(), 3);
    }

    #[test]
    fn who_is_carried_begins_where_he_is_put() {
        let (mut header, to) = (header(), SE2::new(9.0, 3.0, 1.0));
        let start = header.config.start;
        header.config.kidnappings =
            vec![Kidnapping { tick: 1, to }, Kidnapping { tick: 3, to: start }];
        let mut held = Held::of(&header).unwrap();
        let moved = start.boxplus(&nalgebra::Vector3::new(0.01, 0.0, 0.0));
        // Carried to `to` and held there; carried back, and moved on.
        for (tick, truth) in [moved, to, to, moved].into_iter().enumerate() {
            held.push(tick as u64, Some(truth), AHEAD);
        }
        assert_eq!(held.tick_count(), 2);
    }

    #[test]
    fn nobody_knows_of_a_recording() {
        let source = Source::Recorded {
            format: "CARMEN".to_owned(),
            file: "a.log".to_owned(),
            remarks: Vec::new(),
            findings: Vec::new(),
        };
        assert!(Held::of(&LogHeader { source, ..header() }).is_none());
    }
}
