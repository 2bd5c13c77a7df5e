//! Dead reckoning that takes part in many runs, and misbehaves between them on request.

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use rustix::process::{Signal, getpid, kill_process};
use rusty_clients::clap::{self, Parser};
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::{ClientArgs, ClientError, Session};
use rusty_contract::Exit;
use rusty_geometry::SE2;

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: ClientArgs,
    /// carries (its pose, from run to run), once (takes part in one run, then ends),
    /// dawdles (sleeps for N ms at the end of each run), lingers (neither ends nor asks
    /// for another run), dies-asking (SIGKILL 200 ms after it has asked), early (asks for
    /// the next run in the middle of one), reads (takes part in one run, and answers the
    /// origin where the file of --once is there), clock (in one run, and answers the time)
    #[arg(long, default_value = "")]
    mode: String,
    #[arg(long, default_value_t = 1000)]
    sleep_ms: u64,
    /// A file: written at the end of the first run; where it is there, the process behaves
    #[arg(long)]
    once: Option<PathBuf>,
}

fn main() -> Exit {
    let cli = Cli::parse();
    match take_part(&cli) {
        Ok(()) => Exit::Done,
        Err(error) => {
            eprintln!("{error}");
            error.exit()
        }
    }
}

fn take_part(cli: &Cli) -> Result<(), ClientError> {
    let mut session = Session::join(&cli.args)?;
    let is_there = || cli.once.as_ref().is_some_and(|file| file.exists());
    let was_there = is_there();
    let mut carried = DeadReckoning::of_start(session.start());
    while let Some(run) = session.next_run()? {
        let mut fresh = DeadReckoning::of_start(run.start());
        while let Some(tick) = run.next()? {
            let filter = if cli.mode == "carries" { &mut carried } else { &mut fresh };
            let pose = match (filter.advance(tick.encoders()), cli.mode.as_str()) {
                (_, "reads") if was_there => SE2::identity(),
                (_, "clock") => {
                    SE2::new(SystemTime::UNIX_EPOCH.elapsed().unwrap().as_secs_f64(), 0.0, 0.0)
                }
                (pose, _) => pose,
            };
            tick.answer(pose)?;
            if cli.mode == "early" {
                break;
            }
        }
        if cli.mode == "early" {
            return run.next_run().map(drop);
        }
        let behaves = is_there();
        if let Some(file) = &cli.once {
            std::fs::write(file, "").map_err(ClientError::io(file))?;
        }
        let sleep = Duration::from_millis(cli.sleep_ms);
        match cli.mode.as_str() {
            _ if behaves => {}
            "once" | "reads" | "clock" => return Ok(()),
            "dawdles" => std::thread::sleep(sleep),
            "lingers" => {
                drop(session);
                std::thread::sleep(Duration::from_secs(600));
                return Ok(());
            }
            "dies-asking" => drop(std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(200));
                let _ = kill_process(getpid(), Signal::KILL);
            })),
            _ => {}
        }
    }
    Ok(())
}
