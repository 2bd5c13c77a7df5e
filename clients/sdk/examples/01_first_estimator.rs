//! The smallest working estimator: wheels to pose.
use rusty_clients::prelude::*;

fn main() -> Result<(), ClientError> {
    let mut session = Session::from_command_line()?;
    let drive = session.start().robot.drive;
    let mut pose = session.start().initial_pose.unwrap_or_default();
    let mut last = EncoderCounts::default();
    while let Some(tick) = session.next()? {
        pose = pose.boxplus(&odometry_delta(last, tick.encoders(), &drive));
        last = tick.encoders();
        tick.answer(pose)?;
    }
    Ok(())
}
