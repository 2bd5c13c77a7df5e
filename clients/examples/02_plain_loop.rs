//! The same as a plain loop: join, look, answer. A tick that is dropped
//! without an answer abstains, so `continue` is always safe.
use clap::Parser;
use rusty_clients::prelude::*;

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: rusty_clients::ClientArgs,
}

fn main() -> Result<(), ClientError> {
    let mut session = Session::join(&Cli::parse().args)?;
    let drive = session.start().robot.drive;
    let mut pose = session.start().initial_pose.unwrap_or_default();
    let mut last = EncoderTicks::default();
    while let Some(tick) = session.next()? {
        pose = pose.boxplus(&odometry_delta(last, tick.ticks(), &drive));
        last = tick.ticks();
        tick.answer(pose)?;
    }
    Ok(())
}
