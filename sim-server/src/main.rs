//! `sim-server`: the process that owns time.

mod cli;
mod error;
mod report;
mod verbs;

use clap::Parser as _;
use rusty_contract::{Exit, errln, output};

use cli::{Cli, ImportVerb, Verb};

fn main() -> Exit {
    rusty_engine::run::prepare_process();
    let done = match Cli::parse().verb {
        Verb::Launch(args) => verbs::launch(&args),
        Verb::Serve(args) => verbs::serve(&args),
        Verb::Replay(args) => verbs::replay(&args),
        Verb::Verify(args) => verbs::verify(&args),
        Verb::Fork(args) => verbs::fork(&args),
        Verb::Sweep(args) => verbs::sweep(&args),
        Verb::Compare(args) => verbs::compare(&args),
        Verb::Budget(args) => verbs::budget(&args),
        Verb::Umbmark(args) => verbs::umbmark(&args),
        Verb::Diff(args) => verbs::diff(&args),
        Verb::Info(args) => verbs::info(&args),
        Verb::Export(args) => verbs::export(&args),
        Verb::Seal(args) => verbs::seal(&args),
        Verb::Worlds(args) => verbs::worlds(&args),
        Verb::Layout(args) => verbs::layout(&args),
        Verb::Import(ImportVerb::Carmen(args)) => verbs::import_carmen(&args),
        Verb::Control(args) => verbs::control(&args),
        Verb::Doctor(args) => verbs::doctor(&args),
        Verb::Conformance(args) => verbs::conformance(&args),
        Verb::Bench(args) => verbs::bench(&args.what),
        Verb::Runs(args) => verbs::runs(&args),
        Verb::Clean(args) => verbs::clean(&args),
        Verb::BenchPeer(args) => verbs::bench_peer(&args),
        Verb::Confined(args) => verbs::confined(&args),
    };
    output::finish(
        "sim-server",
        done.unwrap_or_else(|e| {
            errln!("sim-server: {e}");
            e.exit()
        }),
    )
}
