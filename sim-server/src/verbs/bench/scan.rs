//! `bench scan`.

use std::time::Duration;

use rusty_contract::config::check_seconds;
use rusty_contract::{Exit, errln};
use rusty_geometry::generated::{Density, Pattern};

use super::super::Verbed;
use crate::cli::{BenchScanArgs, DensityWord, PatternWord};
use rusty_bench::noise::NoiseMeter;
use rusty_bench::report::Report;
use rusty_bench::scan::{Plan, results::ScanResults, run};

/// Measures a beam of a scan in several worlds; exit 4 if the kernel's bits are
/// not the reference's.
///
/// # Errors
/// A time that is none.
pub fn scan(args: &BenchScanArgs) -> Verbed {
    check_seconds("--seconds", args.seconds)?;
    let plan = plan(args);
    let cases = plan.worlds().len() * plan.beams.len();
    let (mut meter, mut number) = (NoiseMeter::begin(), 0);
    let results = run(&plan, |world, beams| {
        number += 1;
        meter.look();
        if !args.common.quiet {
            errln!("{number:3} of {cases}  {world}, {beams} beams");
        }
    })
    .map_err(rusty_bench::BenchError::from)?;
    let differ = results.beams_that_differ;
    let report = Report::new("scan", meter.finish(), results);
    let exit = report.finish(args.common.printing(), ScanResults::print);
    if differ > 0 {
        errln!("sim-server: {differ} ranges are not those of the reference");
        return Ok(Exit::NotBitExact);
    }
    Ok(exit)
}

fn plan(args: &BenchScanArgs) -> Plan {
    let density = |word: &DensityWord| match word {
        DensityWord::Constant => Density::Constant,
        DensityWord::Area => Density::Area,
    };
    let pattern = |word: &PatternWord| match word {
        PatternWord::Rooms => Pattern::Rooms,
        PatternWord::Segments => Pattern::Segments,
    };
    Plan {
        walls: args.walls.iter().map(|&walls| walls as usize).collect(),
        beams: args.beams.clone(),
        densities: args.density.iter().map(density).collect(),
        patterns: args.patterns.iter().map(pattern).collect(),
        time: Duration::from_secs_f64(args.seconds),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args as _, Command, FromArgMatches as _};

    #[test]
    fn without_arguments_it_is_the_plan_of_the_page() {
        let matches = BenchScanArgs::augment_args(Command::new("scan")).get_matches_from(["scan"]);
        let found = plan(&BenchScanArgs::from_arg_matches(&matches).unwrap());
        let usual = Plan::default();
        assert_eq!((found.worlds(), found.beams), (usual.worlds(), usual.beams));
        assert_eq!(found.time, usual.time);
    }
}
