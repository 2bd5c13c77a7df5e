//! A run without a server: a configuration and a script in, a log out.
//!
//! The log is what a logger writes of a run in which no estimator takes part: same
//! records, same digests. It verifies, replays, forks and exports like any other log.
//! The header differs in `writer` and `roster`, which no logger is in here.

use rusty_contract::config::MAX_COMMANDS;
use rusty_contract::log::{Source, TickRecord, TickRef, Trailer};
use rusty_contract::{
    FieldError, Frame, Log, LogHeader, OnLoss, RunConfig, RunDigest, ScriptConfig, TruthKey,
};

use crate::script::{Moment, Script};
use crate::sim::Sim;
use crate::sim_error::SimError;

/// Simulates `config` to its last tick with the commands of `script`, and returns the log.
///
/// The script of `config` is not used. The log has the configuration of `script` if it has
/// one, otherwise the list of its commands, at most a million.
///
/// ```
/// use rusty_contract::Scenario;
/// use rusty_geometry::{Twist, apartment};
/// use rusty_sim::{Moment, record};
///
/// let mut config = Scenario::default().config(apartment().spec().clone());
/// config.ticks = 200;
/// // Ahead, and to the left where a wall is near.
/// let mut shy = |moment: &Moment<'_>| {
///     let ranges_m = moment.frame.and_then(|frame| frame.ranges_m()).unwrap_or(&[]);
///     let is_near = ranges_m.iter().any(|range_m| *range_m < 0.5);
///     Twist { v_m_s: 0.3, omega_rad_s: if is_near { 0.8 } else { 0.0 } }
/// };
/// let log = record(config, &mut shy)?;
/// assert_eq!(log.records.len(), 200);
/// let bytes = log.write(Vec::new()).unwrap();
/// assert!(bytes.starts_with(b"RUSTYLOG"));
/// # Ok::<(), rusty_sim::SimError>(())
/// ```
///
/// # Errors
/// [`SimError`] if the configuration cannot be used, or a command is not a number or out of
/// the range of [`ScriptConfig::check`].
pub fn record(config: RunConfig, script: &mut dyn Script) -> Result<Log, SimError> {
    let named = script.config();
    check_length(&config, named.as_ref())?;
    let mut sim = Sim::new(RunConfig { script: ScriptConfig::Driver {}, ..config })?;
    // The key seals nothing that a log has.
    let (mut frame, key) = (Frame::boxed(), TruthKey::from_bytes([0; 32]));
    let (mut digest, mut records, mut list) = (RunDigest::default(), Vec::new(), Vec::new());
    for tick in 0..sim.config().ticks {
        let moment = Moment {
            tick,
            time_s: tick as f64 * sim.config().dt_s,
            frame: (tick > 0).then_some(&*frame),
            truth: sim.truth(),
        };
        let command = script.command(&moment);
        ScriptConfig::check_command(tick, command)?;
        let _ = sim.step(Some(command), &mut frame);
        frame.seal(&key, Some(sim.truth()));
        digest.absorb_frame(&frame, Some(sim.truth()));
        digest.absorb_replies([].into_iter());
        let dt_s = sim.config().dt_s;
        records.push(TickRecord::from(TickRef::new(&frame, Some(sim.truth()), &[], dt_s)));
        if named.is_none() {
            list.push(command);
        }
    }
    let script = named.unwrap_or(ScriptConfig::Commands { file: None, list });
    let config = RunConfig { script, ..sim.config().clone() };
    config.check()?;
    let header = LogHeader {
        writer: concat!("rusty-sim ", env!("CARGO_PKG_VERSION")).to_owned(),
        source: Source::Simulated,
        config,
        roster: Vec::new(),
        on_loss: OnLoss::default(),
    };
    let (run_digest, world_digest) = (digest.run(), digest.world());
    let trailer = Trailer { ticks: records.len() as u64, run_digest, world_digest };
    Ok(Log { header, records, trailer })
}

/// Checks that a list has room for all commands, before the first of them.
fn check_length(config: &RunConfig, named: Option<&ScriptConfig>) -> Result<(), FieldError> {
    if named.is_some() || config.ticks <= MAX_COMMANDS as u64 {
        return Ok(());
    }
    let problem = "is more than a list of commands can have";
    let remedy = format!("use at most {MAX_COMMANDS} ticks, or a script with a configuration");
    Err(FieldError::new("ticks", config.ticks, problem, remedy))
}
