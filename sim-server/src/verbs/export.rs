//! `export`: a log for other programs.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rusty_contract::{Exit, errln, outln};
use signal_hook::consts::{SIGINT, SIGTERM};

use super::{Verbed, print_json};
use crate::cli::{ExportArgs, ExportVerb};
use crate::error::VerbError;
use rusty_logs::export::tum::Tum;
use rusty_logs::export::{Exported, StampOrder, csv};

/// Exports a log: exit 0, or 3 if something of it is missing or suspect.
///
/// # Errors
/// [`VerbError`] names file, problem and remedy; nothing is written then.
pub fn export(args: &ExportArgs) -> Verbed {
    let stop = Arc::<AtomicBool>::default();
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(VerbError::io(Path::new("signals")))?;
    }
    let (exported, json, wants_truth) = match &args.what {
        ExportVerb::Tum(args) => {
            let folder = args.output.clone().unwrap_or_else(|| args.log.with_file_name("tum"));
            let tum = Tum { all: args.all, force: args.force };
            (tum.export(&args.log, &folder, &stop)?, args.json, true)
        }
        ExportVerb::Csv(args) => {
            let out = args.output.clone().unwrap_or_else(|| args.log.with_extension("csv"));
            (csv::export(&args.log, &out, args.force, &stop)?, args.json, false)
        }
    };
    say(&exported, json, wants_truth);
    Ok(if exported.walked.is_whole() { Exit::Done } else { Exit::Lost })
}

fn say(exported: &Exported, json: bool, wants_truth: bool) {
    let log = &exported.log;
    if wants_truth && exported.ticks_with_truth == 0 {
        errln!("{log}: no tick has a known true pose: the estimates are written, no truth.tum");
    }
    for name in &exported.without {
        errln!("{log}: {name} answered no pose that can be written");
    }
    if let Some(cut) = &exported.walked.cut {
        errln!("{log}: {cut}; its complete ticks are exported");
    }
    if exported.walked.damaged_records > 0 {
        let damaged = exported.walked.damaged_records;
        errln!("{log}: the checksums of {damaged} records fail; their values are suspect");
    }
    let StampOrder { stamps_repeated: repeated, stamps_backwards: backwards, .. } = exported.stamps;
    if wants_truth && repeated > 0 {
        errln!(
            "{log}: {repeated} ticks have the stamp of the tick before, and evo confuses poses of \
             one stamp; import the recording again, or measure with `score --log {log}`"
        );
    }
    if wants_truth && backwards > 0 {
        errln!("{log}: {backwards} ticks have an earlier stamp than the tick before");
    }
    if json {
        print_json(exported);
        return;
    }
    let ticks = exported.walked.ticks;
    outln!("ticks     {ticks}, {} with a known truth", exported.ticks_with_truth);
    for file in &exported.files {
        outln!("written   {} ({} lines)", file.path, file.lines);
    }
    let of = |is: fn(Option<&str>) -> bool| {
        exported.files.iter().find(|f| is(f.estimator.as_deref())).map(|f| &f.path)
    };
    if let (true, Some(truth), Some(estimate)) =
        (wants_truth && repeated == 0, of(|e| e.is_none()), of(|e| e.is_some()))
    {
        outln!("measure   evo_ape tum {truth} {estimate}");
    }
}
