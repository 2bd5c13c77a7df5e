//! The tick over what people would use instead, in the same run as ours.
//!
//! The same frame and the same answers go over ZeroMQ, Zenoh, plain Unix
//! sockets and the shared memory of `sim-server`, in lockstep, between real
//! processes that are all this program. In reading order:
//!
//! * [`cli`]: the command line;
//! * [`contender`]: who is compared, and how they can wait;
//! * [`work`]: what a server and a client do in a tick, the same for everyone;
//! * [`transport`]: how frames and answers travel, a file per library;
//! * [`server`] and [`client`]: the processes of the others;
//! * [`ours`]: the processes of `sim-server`, in the same program;
//! * [`raw`]: the transport of `sim-server` without its protocol;
//! * [`meter`]: what is measured in a server's process;
//! * [`cell`]: one measurement, run and waited for;
//! * [`tour`]: all measurements, in turn;
//! * [`table`]: what they come to.

mod cell;
mod cli;
mod client;
mod contender;
mod error;
mod meter;
mod ours;
mod output;
mod raw;
mod server;
mod stop;
mod table;
mod tour;
mod transport;
mod watchdog;
mod work;

use rusty_contract::Exit;

fn main() -> Exit {
    cli::main()
}
