//! `Setting`: the little world a check is played in.

use std::path::PathBuf;

use rusty_contract::scenario::Access;
use rusty_contract::{LogHeader, Participant, Role, Scenario, ScriptConfig};
use rusty_sim::Sim;

use super::Kit;
use rusty_engine::run::RunError;
use rusty_engine::scenario_file::Loaded;
use rusty_engine::source::simulated_header;

/// Ticks of a little run; every fifth has a scan.
pub(super) const TICKS: u64 = 24;

/// The kit's own estimator, so that scorers and loggers have answers to see.
/// It sits on place 0: who answers in the name of place 0 answers for another.
pub(super) const COMPANION: &str = "kit-odometry";

/// Place of the client in the roster.
pub(super) const CLIENT_SLOT: usize = 1;

/// A scenario, and what the client may know of it.
#[derive(Clone)]
pub(super) struct Setting {
    pub(super) scenario: Scenario,
    pub(super) map: Access,
    pub(super) initial_pose: Access,
}

impl Setting {
    /// The Apartment for 24 ticks: a robot that always moves and turns, or is
    /// moved by the client where that is a driver.
    pub(super) fn usual(role: Role) -> Self {
        let script = if role == Role::Driver {
            ScriptConfig::Driver {}
        } else {
            ScriptConfig::FigureEight { v_m_s: 0.4, omega_rad_s: 0.8, half_s: 8.0 }
        };
        let name = "conformance".to_owned();
        let scenario = Scenario { name, ticks: TICKS, script, ..Scenario::default() };
        Self { scenario, map: Access::Given, initial_pose: Access::Given }
    }

    /// The world of this setting, and what a log of it would say.
    pub(super) fn world(&self, kit: &Kit) -> Result<(LogHeader, Sim), RunError> {
        let loaded = Loaded { scenario: self.scenario.clone(), folder: PathBuf::new() };
        let config = loaded.config()?;
        let companion = Participant::new(COMPANION, Role::Estimator);
        let roster = vec![companion, self.client(kit)];
        let header = simulated_header(config.clone(), roster, self.scenario.on_loss);
        Ok((header, Sim::new(config)?))
    }

    /// The client in the roster.
    fn client(&self, kit: &Kit) -> Participant {
        Participant { map: self.map, initial_pose: self.initial_pose, ..kit.participant() }
    }
}
