//! The golden runs of the processor that it is built for: fails where one has other bits.

use std::process::ExitCode;

use rusty_sim::GOLDENS;

fn main() -> ExitCode {
    let mut wrong = 0;
    for golden in &GOLDENS {
        let found = golden.found().unwrap_or_else(|error| error.to_string());
        println!("{:20} {found}", golden.name);
        if found != golden.expected {
            eprintln!("{}: {found}, expected {}", golden.name, golden.expected);
            wrong += 1;
        }
    }
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
