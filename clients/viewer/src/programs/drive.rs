//! `drive`: a person drives the robot, in a page or a terminal.

use rusty_clients::{ClientArgs, ClientError};
use rusty_contract::Exit;
use rusty_link::Domain;

use crate::drive::{Drive, Options};

pub(super) fn main() -> Exit {
    let (args, options) = ClientArgs::with_options::<Options>();
    rusty_clients::run_from(&args, |start| {
        let domain = args.run.as_ref().map(Domain::find).transpose();
        let domain = domain.map_err(rusty_link::LinkError::from)?;
        let folder = domain.as_ref().map(Domain::folder);
        let unusable = |e| ClientError::Unusable(format!("the socket for commands: {e}"));
        Drive::new(start, options, folder).map_err(unusable)
    })
}
