//! The commands of the scenarios that come with the repository do not depend on
//! the truth: without laser and map, they say no more than the encoders do.
//!
//! A patrol that is steered on the truth is the counterexample. Its law and its
//! gains are public, so a filter inverts it: from the command of a tick and the
//! planned pose it computes the true pose before that tick.

use rusty_contract::{Frame, RunConfig, Scenario, ScriptConfig};
use rusty_engine::scenario_file::BUILT_IN;
use rusty_geometry::{EncoderCounts, odometry_delta, open, trig, wrap_angle};
use rusty_sim::{Sim, StepOutcome};
use rusty_tests::*;

const SEEDS: u64 = 20;

/// The scenarios that no driver steers.
fn scripted() -> Vec<RunConfig> {
    let folder = repository().join("clients/filters/scenarios");
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let files = files.map(|file| arg(&file).to_owned());
    let names = BUILT_IN.iter().map(|(name, _)| (*name).to_owned());
    let all = names.chain(files).map(|which| config_of(&which, &[]));
    all.filter(|c| !matches!(c.script, ScriptConfig::Driver {})).collect()
}

/// The filter that inverts the steering law of `rusty_sim::steering`.
struct Inverter {
    /// The plan: the same robot without noise, in a world without walls.
    plan: Sim,
    frame: Frame,
    /// The pose before the tick before, and how far the wheels have driven since.
    last: SE2,
    driven_m: f64,
    counts: EncoderCounts,
}

impl Inverter {
    fn new(config: &RunConfig) -> Self {
        let mut plan = config.clone();
        if let ScriptConfig::TruthSteeredPatrol(patrol) = plan.script {
            plan.script = ScriptConfig::Patrol(patrol);
        }
        plan.robot.slip_std = 0.0;
        plan.world = open().spec().clone();
        Self {
            plan: Sim::new(plan).unwrap(),
            frame: *Frame::boxed(),
            last: config.start,
            driven_m: 0.0,
            counts: EncoderCounts::default(),
        }
    }

    /// The pose after the tick of `frame`, from its command and its counts.
    fn estimate(&mut self, frame: &Frame, config: &RunConfig) -> SE2 {
        let planned = self.plan.truth();
        let _ = self.plan.step(None, &mut self.frame);
        let (plan, command) = (self.frame.command(), frame.command());
        let mut pose = self.last;
        for _ in 0..4 {
            let error = pose.inverse().compose(&planned);
            let turn_rad_s = command.omega_rad_s - plan.omega_rad_s;
            let heading_rad = (turn_rad_s - 2.0 * error.y() * plan.v_m_s) / 1.5;
            let turned_rad = wrap_angle(planned.theta() - heading_rad - self.last.theta());
            pose = self.last.boxplus(&[self.driven_m, 0.0, turned_rad].into());
        }
        if plan.v_m_s > 0.0 {
            let error = pose.inverse().compose(&planned);
            let along_m = error.x() - (command.v_m_s - plan.v_m_s);
            pose = pose.boxplus(&[along_m, 0.0, 0.0].into());
        }
        let delta = odometry_delta(self.counts, frame.encoders(), &config.robot.nominal().drive);
        (self.last, self.driven_m, self.counts) = (pose, delta.x, frame.encoders());
        pose.boxplus(&delta)
    }
}

/// Root mean square position errors of a run, m: the inverter's, and dead
/// reckoning's. And how many ticks a wall held the robot.
fn errors(mut config: RunConfig, seed: u64) -> (f64, f64, usize) {
    (config.seed, config.scan_every) = (seed, 0);
    let drive = config.robot.nominal().drive;
    let (mut sim, mut frame) = (Sim::new(config.clone()).unwrap(), Frame::boxed());
    let mut inverter = Inverter::new(&config);
    let (mut reckoned, mut counts) = (config.start, EncoderCounts::default());
    let (mut squares, mut blocked) = ([0.0; 2], 0);
    for _ in 0..config.ticks {
        blocked += usize::from(sim.step(None, &mut frame) == StepOutcome::Blocked);
        let inverted = inverter.estimate(&frame, &config);
        reckoned = reckoned.boxplus(&odometry_delta(counts, frame.encoders(), &drive));
        counts = frame.encoders();
        for (sum, estimate) in squares.iter_mut().zip([inverted, reckoned]) {
            let off = estimate.translation() - sim.truth().translation();
            *sum += trig::hypot(off.x, off.y).powi(2);
        }
    }
    let [inverted_m, reckoned_m] = squares.map(|sum| (sum / config.ticks as f64).sqrt());
    (inverted_m, reckoned_m, blocked)
}

#[test]
fn commands_that_depend_on_the_truth_give_it_away() {
    for seed in 0..SEEDS {
        let steered = config_of("apartment", &["script.kind=truth-steered-patrol"]);
        let (inverted_m, reckoned_m, _) = errors(steered, seed);
        println!("steered on the truth, seed {seed}: {inverted_m:.6} m of {reckoned_m:.4} m");
        assert!(inverted_m < 0.001, "seed {seed}: {inverted_m} m");
        assert!(reckoned_m > 10.0 * inverted_m, "seed {seed}: {reckoned_m} and {inverted_m} m");
    }
}

#[test]
fn the_usual_runs_commands_say_no_more_than_its_encoders_and_no_wall_holds_it() {
    let ekf = filter_scenario("ekf.toml");
    for (which, seed) in
        ["apartment", &ekf].into_iter().flat_map(|s| (0..SEEDS).map(move |n| (s, n)))
    {
        let (inverted_m, reckoned_m, blocked) = errors(config_of(which, &[]), seed);
        println!("{which}, seed {seed}: {inverted_m:.6} m of {reckoned_m:.6} m");
        assert!(
            inverted_m > 0.99 * reckoned_m && reckoned_m > 0.005,
            "{which}, seed {seed}: inverted {inverted_m} m, reckoned {reckoned_m} m"
        );
        assert_eq!(blocked, 0, "{which}, seed {seed}");
    }
}

#[test]
fn no_scenario_s_commands_depend_on_the_truth() {
    let commands = |config: &RunConfig, slip_std: f64| -> Vec<[u64; 2]> {
        let mut config = RunConfig { scan_every: 0, ..config.clone() };
        config.robot.slip_std = slip_std;
        let (mut sim, mut frame) = (Sim::new(config).unwrap(), Frame::boxed());
        let mut command = || {
            let _ = sim.step(None, &mut frame);
            [frame.command().v_m_s, frame.command().omega_rad_s].map(f64::to_bits)
        };
        (0..300).map(|_| command()).collect()
    };
    let all = scripted();
    assert!(all.len() >= 7, "{}", all.len());
    for scenario in &all {
        let name = &scenario.scenario;
        assert_eq!(commands(scenario, 0.0), commands(scenario, 0.3), "{name}");
    }
    // Nor those of a scenario that names no script.
    assert_eq!(Scenario::default().script, config_of("apartment", &[]).script);
    let steered = config_of("apartment", &["script.kind=truth-steered-patrol"]);
    assert_ne!(commands(&steered, 0.0), commands(&steered, 0.3));
}
