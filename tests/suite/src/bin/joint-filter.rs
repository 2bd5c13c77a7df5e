//! A filter for two robots of one world: it takes part in the runs of both, and knows both
//! ticks before it answers either. The second run is that of robot `b`.

use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::prelude::*;
use rusty_clients::{ClientArgs, ClientError, Session};
use rusty_contract::RunName;

fn main() -> Exit {
    match run() {
        Ok(()) => Exit::Done,
        Err(e) => {
            eprintln!("{e}");
            e.exit()
        }
    }
}

fn run() -> Result<(), ClientError> {
    let first = ClientArgs::from_command_line();
    let name = first.run.as_ref().map(RunName::as_str).unwrap_or_default();
    let name = name.strip_suffix("-a").unwrap_or(name);
    let second = ClientArgs {
        run: RunName::new(&format!("{name}-b")).ok(),
        name: Some(first.name()),
        // The server has started it for the first run; for the second it comes by itself.
        key_stdin: false,
        ..first.clone()
    };
    let (mut a, mut b) = (Session::join(&first)?, Session::join(&second)?);
    let [mut of_a, mut of_b] = [&a, &b].map(|session| DeadReckoning::of_start(session.start()));
    while let (Some(tick_a), Some(tick_b)) = (a.next()?, b.next()?) {
        assert_eq!(tick_a.index(), tick_b.index());
        let (pose_a, pose_b) = (of_a.advance(tick_a.encoders()), of_b.advance(tick_b.encoders()));
        tick_a.answer(pose_a)?;
        tick_b.answer(pose_b)?;
    }
    Ok(())
}
