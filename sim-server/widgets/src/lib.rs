//! The world as a module for WebAssembly: no imports, no glue, a few functions.
//!
//! The module holds one run. Text and numbers are in its memory, where the caller reads
//! them until the next call; a call may move them and enlarge the memory.
//!
//! | export | effect and result |
//! |---|---|
//! | `memory` | the module's memory |
//! | `input(length) -> address` | makes room for a text of `length` bytes, UTF-8 |
//! | `begin(seed: u64, keep) -> ok` | begins a run of the scenario in the input, see [`config`], if `keep` is not 0 with the commands of the run before |
//! | `advance(ticks) -> ok` | simulates up to this number of ticks; numbers: a row for each new tick; text: run digest, world digest and number of ticks, a line each |
//! | `scan() -> ok` | numbers: the ranges of the latest scan, m |
//! | `belief(index) -> ok` | numbers: x, y, θ, weight of each pose that the estimator holds possible |
//! | `drive(v, omega) -> ok` | replaces the script by this command from the next tick on, m/s and rad/s |
//! | `kidnap(x, y, theta) -> ok` | puts the robot there at the start of the next tick, world frame; text: the index of that tick |
//! | `commands() -> ok` | numbers: v, ω of each tick up to now |
//! | `lab(first: u64, count) -> ok` | numbers: figures and path of the run with each of these seeds; text: their digests |
//! | `text()`, `text_length()` | the text of the latest call |
//! | `numbers()`, `numbers_length()` | its numbers, f64 |
//!
//! `ok` is 1, or 0 where the text is an error. [`run`] has the rows, [`mod@lab`] the figures.

pub mod config;
pub mod estimators;
#[cfg(feature = "filters")]
pub mod filters;
pub mod lab;
pub mod roster;
pub mod run;

use std::sync::Mutex;

use rusty_geometry::{SE2, Twist};

use crate::run::Run;

static STATE: Mutex<State> =
    Mutex::new(State { input: Vec::new(), text: String::new(), numbers: Vec::new(), run: None });

/// The contents of the module's memory.
struct State {
    input: Vec<u8>,
    text: String,
    numbers: Vec<f64>,
    run: Option<Run>,
}

/// The result of a call: its text, or the text of an error.
type Answer = Result<String, String>;

/// Calls `act` with the state, and leaves its text.
fn with(act: impl FnOnce(&mut State) -> Answer) -> u32 {
    let Ok(mut state) = STATE.lock() else { return 0 };
    state.numbers.clear();
    let answer = act(&mut state);
    let is_ok = answer.is_ok();
    state.text = answer.unwrap_or_else(|error| error);
    u32::from(is_ok)
}

/// Calls `act` with the run and the numbers.
fn with_run(act: impl FnOnce(&mut Run, &mut Vec<f64>) -> Answer) -> u32 {
    with(|state| match &mut state.run {
        Some(run) => act(run, &mut state.numbers),
        None => Err("no run has begun; call begin first".to_owned()),
    })
}

/// Makes room for a text of `length` bytes. Returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn input(length: u32) -> *mut u8 {
    let Ok(mut state) = STATE.lock() else { return std::ptr::null_mut() };
    state.input.clear();
    state.input.resize(length as usize, 0);
    state.input.as_mut_ptr()
}

/// Begins a run of the scenario in the input.
#[unsafe(no_mangle)]
pub extern "C" fn begin(seed: u64, keep: u32) -> u32 {
    with(|state| {
        let kept = state.run.as_ref().filter(|_| keep != 0).map(Run::commands_to_keep);
        let text = std::str::from_utf8(&state.input).map_err(|e| e.to_string())?;
        // A scenario that is refused leaves no run to go on with.
        state.run = None;
        state.run = Some(Run::open(text, seed, kept.unwrap_or_default())?);
        Ok(String::new())
    })
}

/// Simulates up to this number of ticks.
#[unsafe(no_mangle)]
pub extern "C" fn advance(ticks: u32) -> u32 {
    with_run(|run, numbers| {
        while run.tick_count() < u64::from(ticks) {
            run.step(numbers);
        }
        let digests = [run.digest.run_hex(), run.digest.world_hex()];
        Ok(format!("{}\n{}\n{}", digests[0], digests[1], run.tick_count()))
    })
}

/// Returns the ranges of the latest scan.
#[unsafe(no_mangle)]
pub extern "C" fn scan() -> u32 {
    with_run(|run, numbers| {
        numbers.extend(&run.ranges_m);
        Ok(String::new())
    })
}

/// Returns the belief of the estimator at `index`.
#[unsafe(no_mangle)]
pub extern "C" fn belief(index: u32) -> u32 {
    with_run(|run, numbers| {
        run.belief(index as usize, numbers);
        Ok(String::new())
    })
}

/// Replaces the script by a command.
#[unsafe(no_mangle)]
pub extern "C" fn drive(v_m_s: f64, omega_rad_s: f64) -> u32 {
    with_run(|run, _| run.drive(Twist { v_m_s, omega_rad_s }).map(|()| String::new()))
}

/// Puts the robot elsewhere at the start of the next tick.
#[unsafe(no_mangle)]
pub extern "C" fn kidnap(x_m: f64, y_m: f64, theta_rad: f64) -> u32 {
    with_run(|run, _| run.kidnap(SE2::new(x_m, y_m, theta_rad)).map(|tick| tick.to_string()))
}

/// Returns the command of each tick.
#[unsafe(no_mangle)]
pub extern "C" fn commands() -> u32 {
    with_run(|run, numbers| {
        numbers.extend(run.commands.iter().flat_map(|c| [c.v_m_s, c.omega_rad_s]));
        Ok(String::new())
    })
}

/// Makes the runs of `count` seeds.
#[unsafe(no_mangle)]
pub extern "C" fn lab(first: u64, count: u32) -> u32 {
    with_run(|run, numbers| lab::lab(run, first, count, numbers))
}

/// The address of the text of the latest call.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> *const u8 {
    STATE.lock().map_or(std::ptr::null(), |state| state.text.as_ptr())
}

/// Its length, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> u32 {
    STATE.lock().map_or(0, |state| state.text.len() as u32)
}

/// The address of the numbers of the latest call.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f64 {
    STATE.lock().map_or(std::ptr::null(), |state| state.numbers.as_ptr())
}

/// How many numbers there are.
#[unsafe(no_mangle)]
pub extern "C" fn numbers_length() -> u32 {
    STATE.lock().map_or(0, |state| state.numbers.len() as u32)
}
