//! `belief`: shows the beliefs of filters during a run.

use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Parser;
use rusty_clients::{parsed, stop_by_signal};
use rusty_contract::belief::{Summary, tidy};
use rusty_contract::{BeliefHeader, BeliefKind, Exit, RunName, errln, outln, output};
use rusty_link::BeliefViewer;
use serde::Serialize;

/// Show the beliefs of the filters of a run
///
/// Each belief is one line: particles or histogram, number of poses, effective sample
/// size, mean and spread.
///
/// It does not participate in the run: the run does not wait for it, no bit depends on
/// it, and it misses beliefs if it is too slow. Filters with a single pose publish
/// no belief; their covariance is in their answers.
#[derive(Parser)]
#[command(name = "belief", version)]
struct Cli {
    /// Run to observe
    #[arg(long, value_name = "NAME")]
    run: RunName,

    /// Show the beliefs of this participant only
    #[arg(long, value_name = "NAME")]
    name: Option<String>,

    /// End after N lines
    #[arg(long, value_name = "N")]
    lines: Option<u64>,

    /// Print one JSON object per line
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Line<'a> {
    tick: u64,
    time_s: f64,
    name: &'a str,
    kind: String,
    /// Poses that were received, and poses of the filter.
    count: u32,
    whole: u32,
    effective: f64,
    mean_x_m: f64,
    mean_y_m: f64,
    mean_theta_rad: f64,
    spread_m: f64,
    heading_agreement: f64,
}

pub(super) fn main() -> Exit {
    let cli: Cli = parsed();
    let exit = match observe(&cli) {
        Ok(()) => Exit::Done,
        Err(e) => {
            errln!("belief: {e}");
            Exit::Failed
        }
    };
    output::finish("belief", exit)
}

fn observe(cli: &Cli) -> Result<(), Box<dyn std::error::Error>> {
    let stop = stop_by_signal();
    let viewer = BeliefViewer::open(&cli.run)?;
    if !cli.json {
        let columns = "    tick    time s  name                      kind         poses  effective  \
                       mean x m  mean y m   mean °  spread m";
        outln!("{columns}");
    }
    let (mut poses, mut lines) = (Vec::new(), 0);
    let is_wanted = |lines| output::is_open() && cli.lines.is_none_or(|most| lines < most);
    while !stop.load(Ordering::Relaxed) && is_wanted(lines) {
        // Before the wait, so that the last belief of a run is seen.
        let over = viewer.is_over();
        let Some(header) = viewer.wait(Duration::from_millis(50), &mut poses) else {
            if over {
                break;
            }
            continue;
        };
        tidy(&mut poses);
        let (Some(name), Some(summary)) = (header.name(), Summary::of(&poses)) else { continue };
        if cli.name.as_deref().is_some_and(|wanted| wanted != name) {
            continue;
        }
        print(&header, name, &summary, cli.json)?;
        lines += 1;
    }
    Ok(())
}

fn print(
    header: &BeliefHeader,
    name: &str,
    summary: &Summary,
    json: bool,
) -> serde_json::Result<()> {
    let kind = BeliefKind::of_number(header.kind).map_or("?".to_owned(), |kind| kind.to_string());
    let &BeliefHeader { tick, time_s, count, whole, .. } = header;
    let Summary { effective, mean_m: [x_m, y_m], mean_rad, spread_m, agreement } = *summary;
    if !json {
        let degrees = mean_rad.to_degrees();
        outln!(
            "{tick:8}  {time_s:8.2}  {name:24}  {kind:10}  {whole:6}  {effective:9.1}  {x_m:8.3}  \
             {y_m:8.3}  {degrees:7.2}  {spread_m:8.3}"
        );
        return Ok(());
    }
    let line = Line {
        tick,
        time_s,
        name,
        kind,
        count,
        whole,
        effective,
        mean_x_m: x_m,
        mean_y_m: y_m,
        mean_theta_rad: mean_rad,
        spread_m,
        heading_agreement: agreement,
    };
    outln!("{}", serde_json::to_string(&line)?);
    Ok(())
}
