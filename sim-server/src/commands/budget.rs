//! `budget`: the sources of the odometry error.

use std::io::IsTerminal as _;
use std::sync::atomic::Ordering;

use anyhow::Result;
use clap::Args;
use rusty_contract::{Exit, FieldError, errln};
use rusty_engine::remarks::remarks;
use rusty_engine::scenario_file;
use rusty_study::budget::budget;
use rusty_study::sweep::Seeds;

use super::arguments::Output;
use super::stop_flag;

const AFTER_HELP: &str = "\
The error of dead reckoning has three sources:
  quantization   encoders round to whole counts; the error is negligible
  slip           random, different on every seed, grows with the distance
  bias           wheels or wheelbase differ from their nominal values; the same
                 error on every seed, which averaging does not remove; calibrate
                 it with `sim-server umbmark`
The budget runs the scenario with each source alone and with all together, and
prints the final error of dead reckoning. Quantization is in every row.

Shares are of mean squares, which add up if sources are independent and small.

No scans are made and no clients take part, so a scenario with a driver is refused.
A truth-steered patrol is steered in every row.

Examples:
  sim-server budget patrol --set robot.radius_bias_right=0.01    the chapter's table
  sim-server budget figure-eight --seeds 0..100 --set robot.track_bias=0.005";

#[derive(Args, Clone, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct BudgetArgs {
    /// Built-in (apartment, patrol, office, …) or a file
    #[arg(default_value = "patrol")]
    pub scenario: String,
    /// Seeds A..B (without B), A..=B (with B) or one seed
    #[arg(long, value_name = "A..B", default_value = "0..500")]
    pub seeds: Seeds,
    /// Number of ticks [default: the scenario's]
    #[arg(long)]
    pub ticks: Option<u64>,
    /// Change a field, e.g. robot.radius_bias_right=0.01
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    #[command(flatten)]
    pub output: Output,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
}

/// Limit of the number of seeds, because their figures are in memory together.
const MOST_SEEDS: u64 = 10_000_000;

pub fn run(args: &BudgetArgs) -> Result<Exit> {
    let given = [("seed", "--seeds", true), ("ticks", "--ticks", args.ticks.is_some())];
    scenario_file::check_options(&args.changes, &given)?;
    let mut loaded = scenario_file::load(&args.scenario, &args.changes)?;
    loaded.scenario.ticks = args.ticks.unwrap_or(loaded.scenario.ticks);
    let config = loaded.config_with(rusty_floorplan::read)?;
    if config.script.is_driver() {
        let remedy = "choose a scenario with a script, or --set script='{ kind = \
                      \"straight\", v_m_s = 0.5 }'";
        let problem = "needs a client to drive it, and none takes part here";
        return Err(FieldError::new("script.kind", "driver", problem, remedy).into());
    }
    if let Some(first) = config.kidnappings.first() {
        let remedy = "leave it out by --set 'kidnapping=[]'";
        let problem = "carries the robot, which is no error of its wheels";
        return Err(FieldError::new("kidnapping[0].tick", first.tick, problem, remedy).into());
    }
    let people = config.crowd.map_or(0, |crowd| crowd.people as usize) + config.walkers.len();
    if people > 0 {
        let problem = "stop the robot, which is no error of its wheels";
        let remedy = "leave them out by --set crowd.people=0 --set 'walker=[]'";
        return Err(FieldError::new("people", people, problem, remedy).into());
    }
    remarks(&config, &[]).iter().for_each(|remark| errln!("{remark}"));
    if args.seeds.count() > MOST_SEEDS {
        let remedy = format!("use at most {MOST_SEEDS}");
        return Err(FieldError::new("--seeds", args.seeds, "are too many", remedy).into());
    }
    let stop = stop_flag()?;
    let shown = !(args.quiet || args.output.json) && std::io::stderr().is_terminal();
    let mut at = String::new();
    let report = budget(&config, args.seeds, &mut |row| {
        if shown && row != at {
            errln!("{row} …");
            row.clone_into(&mut at);
        }
        !stop.load(Ordering::Relaxed)
    })?;
    let Some(report) = report else {
        errln!("sim-server: stopped; a budget over fewer --seeds takes less time");
        return Ok(Exit::Lost);
    };
    args.output.print(&report);
    Ok(Exit::Done)
}
