//! `bench scan`: measure a scan against one ray cast per beam.

use std::time::Duration;

use anyhow::Result;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rusty_bench::noise::NoiseMeter;
use rusty_bench::scan::Plan;
use rusty_contract::config::check_seconds;
use rusty_contract::{Exit, errln};
use rusty_geometry::generated::{Density, Pattern};

use super::CommonArgs;

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Three methods are measured in turns from the same poses, in the Apartment and in
generated worlds: all beams together, one ray per beam (the reference), and the
ray cast of parry. The first two must have the same bits (exit code 4 if not).
Example: sim-server bench scan --walls 4096 --beams 360 --patterns rooms")]
pub struct ScanArgs {
    /// Numbers of walls of the generated worlds
    #[arg(long, value_delimiter = ',', default_value = "64,512,4096,32768", value_name = "N,…",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub walls: Vec<u32>,
    /// Numbers of beams of a scan over the full circle
    #[arg(long, value_delimiter = ',', default_value = "180,1080", value_name = "N,…",
          value_parser = clap::value_parser!(u32).range(1..=1080))]
    pub beams: Vec<u32>,
    /// Quantity held constant when the number of walls grows
    #[arg(long, value_delimiter = ',', default_value = "constant,area", value_name = "WHAT,…",
          value_parser = density())]
    pub density: Vec<Density>,
    /// Arrangements of the walls
    #[arg(long, value_delimiter = ',', default_value = "rooms,segments", value_name = "HOW,…",
          value_parser = pattern())]
    pub patterns: Vec<Pattern>,
    /// Duration per world and number of beams, s
    #[arg(long, default_value_t = 0.5, value_name = "SECONDS")]
    pub seconds: f64,
    #[command(flatten)]
    pub common: CommonArgs,
}

fn density() -> impl TypedValueParser<Value = Density> {
    PossibleValuesParser::new([
        PossibleValue::new("constant").help("Number of walls per area"),
        PossibleValue::new("area").help("Total area"),
    ])
    .map(|word| if word == "area" { Density::Area } else { Density::Constant })
}

fn pattern() -> impl TypedValueParser<Value = Pattern> {
    PossibleValuesParser::new([
        PossibleValue::new("rooms").help("A grid of rooms with doors"),
        PossibleValue::new("segments").help("Free-standing walls in all directions"),
    ])
    .map(|word| if word == "rooms" { Pattern::Rooms } else { Pattern::Segments })
}

/// Exits with 4 if the bits of the ranges differ from those of the reference.
pub fn run(args: &ScanArgs) -> Result<Exit> {
    check_seconds("--seconds", args.seconds)?;
    let plan = plan(args);
    let cases = plan.worlds().len() * plan.beams.len();
    let (mut meter, mut number) = (NoiseMeter::begin(), 0);
    let results = rusty_bench::scan::run(&plan, |world, beams| {
        number += 1;
        meter.look();
        if !args.common.quiet {
            errln!("{number:3} of {cases}  {world}, {beams} beams");
        }
    })
    .map_err(rusty_bench::BenchError::World)?;
    let differ = results.facts["beams_that_differ"].as_u64().unwrap_or(0);
    let exit = args.common.finish("scan", meter, results)?;
    if differ > 0 {
        errln!("sim-server: {differ} ranges are not those of the reference");
        return Ok(Exit::NotBitExact);
    }
    Ok(exit)
}

fn plan(args: &ScanArgs) -> Plan {
    Plan {
        walls: args.walls.iter().map(|&walls| walls as usize).collect(),
        beams: args.beams.clone(),
        densities: args.density.clone(),
        patterns: args.patterns.clone(),
        time: Duration::from_secs_f64(args.seconds),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Command, FromArgMatches as _};

    #[test]
    fn without_arguments_it_is_the_plan_of_the_page() {
        let matches = ScanArgs::augment_args(Command::new("scan")).get_matches_from(["scan"]);
        let found = plan(&ScanArgs::from_arg_matches(&matches).unwrap());
        let usual = Plan::default();
        assert_eq!((found.worlds(), found.beams), (usual.worlds(), usual.beams));
        assert_eq!(found.time, usual.time);
    }
}
