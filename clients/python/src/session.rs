//! `Session`: one participant's part in a run, as an iterator of ticks.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyKeyboardInterrupt, PySystemExit, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyType;
use rusty_clients::{Arrival, ClientArgs, ClientError, Session as Sdk};
use rusty_contract::Phase;

use crate::errors::{RustyError, exception, misused};
use crate::gate::{Gate, Loan, Lone, leave_all, pin_all, stop_all};
use crate::meanwhile::{SLICE, join_meanwhile, next_run_meanwhile};
use crate::start::{self, Start};
use crate::tick::Tick;

/// A part in a run, live or on a log: an iterator of its ticks, and a context
/// manager that leaves the run at the end of its block.
///
/// While the next tick is waited for the interpreter is not held, and Ctrl-C ends
/// the wait. A tick before it that was not answered abstains. Iterating raises
/// `ServerGone`, `Dropped`, and `RuntimeError` if another thread waits or this
/// process is a fork of the one that joined. `join` makes it.
#[pyclass(frozen, module = "rusty", weakref)]
pub struct Session {
    gate: Arc<Gate>,
    /// The run that it takes part in.
    current: Mutex<Current>,
    /// Whether it takes part in several runs, see [`runs`](Self::runs).
    stays: AtomicBool,
}

/// One run of a session.
struct Current {
    start: Py<Start>,
    ending: Option<Phase>,
    /// Whether [`Runs`] has returned it.
    is_begun: bool,
}

#[pymethods]
impl Session {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Tick>> {
        loop {
            match self.wait(py)? {
                Wait::Tick(tick) => return Ok(Some(tick)),
                Wait::Over => return Ok(None),
                Wait::Nothing => self.look_around(py)?,
            }
        }
    }

    /// What this participant was told.
    #[getter]
    fn start(&self, py: Python<'_>) -> Py<Start> {
        self.current(|current| current.start.clone_ref(py))
    }

    /// The run that was joined, then each further run that the server offers to this
    /// process: an iterator that returns the same session, whose `start` is then that of the
    /// next run. Make a filter from it anew for each run. Without it a script takes part in
    /// one run, and the server starts it again for the next.
    ///
    /// Iterating raises `ServerGone`, and `RuntimeError` before the current run has ended.
    fn runs(this: PyRef<'_, Self>) -> Runs {
        this.stays.store(true, Ordering::Relaxed);
        Runs(this.into())
    }

    /// How the run ended: "done", "interrupted", "aborted"; None while it has not,
    /// or where the session left before.
    #[getter]
    fn ending(&self) -> Option<&'static str> {
        self.current(|current| current.ending).map(|phase| match phase {
            Phase::Done => "done",
            Phase::Interrupted => "interrupted",
            Phase::Aborted => "aborted",
            Phase::Tick => "tick",
        })
    }

    /// Leaves the run. Before its end that is a failure to the run.
    fn close(&self, py: Python<'_>) {
        py.detach(|| self.gate.leave());
    }

    fn __enter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __exit__(
        &self,
        py: Python<'_>,
        kind: Option<&Bound<'_, PyType>>,
        _value: Option<&Bound<'_, PyAny>>,
        _traceback: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        if kind.is_some_and(|kind| kind.is_subclass_of::<PyKeyboardInterrupt>().unwrap_or(false)) {
            self.gate.stop.store(true, Ordering::Relaxed);
        }
        self.close(py);
        Ok(false)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let start = self.start(py);
        let told = &start.bind(py).get().told;
        format!("<rusty.Session of {:?} ({}) in {:?}>", told.name, told.role, told.scenario)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // The thread that drops it is attached to Python, and no other can be waiting
        // in it: that would hold a reference.
        self.gate.leave();
    }
}

/// What one bounded wait brought.
enum Wait {
    Tick(Tick),
    Nothing,
    Over,
}

/// The runs of a session, one after the other.
#[pyclass(frozen, module = "rusty")]
struct Runs(Py<Session>);

#[pymethods]
impl Runs {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Py<Session>>> {
        let is_next = self.0.get().next_run(py)?;
        Ok(is_next.then(|| self.0.clone_ref(py)))
    }
}

impl Session {
    fn current<T>(&self, with: impl FnOnce(&mut Current) -> T) -> T {
        with(&mut self.current.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Waits for the next run without holding the interpreter. Returns whether there is one.
    fn next_run(&self, py: Python<'_>) -> PyResult<bool> {
        let (is_new, ending) =
            self.current(|run| (!std::mem::replace(&mut run.is_begun, true), run.ending));
        if is_new {
            if let Some(mut turn) = self.gate.turn()
                && let Some(part) = turn.part()
            {
                let _ = part.session.get_mut().next_run();
            }
            return Ok(true);
        }
        if self.gate.is_foreign() {
            return Err(misused("this process is a fork of the one that joined".to_owned()));
        }
        let Some(mut turn) = self.gate.turn() else {
            return Err(misused("another thread waits for the session's next tick".to_owned()));
        };
        turn.reclaim();
        let Some(part) = turn.part() else { return Ok(false) };
        if ending.is_none() {
            let remedy = "take all its ticks, then ask for the next run";
            return Err(misused(format!("the run has not ended: {remedy}")));
        }
        let told = match next_run_meanwhile(py, &mut part.session, &self.gate.stop) {
            Ok(told) => told,
            Err(error) => {
                turn.end();
                return Err(error);
            }
        };
        let Some(told) = told else {
            turn.end();
            return Ok(false);
        };
        drop(turn);
        let start = start::remember(py, told)?;
        self.current(|run| *run = Current { start, ending: None, is_begun: true });
        Ok(true)
    }

    /// Waits for the next tick for a slice, without holding the interpreter.
    fn wait(&self, py: Python<'_>) -> PyResult<Wait> {
        if self.gate.is_foreign() {
            let text =
                "this process is a fork of the one that joined; join in the process that answers";
            return Err(misused(text.to_owned()));
        }
        let Some(mut turn) = self.gate.turn() else {
            if self.gate.is_leaving() {
                return Ok(Wait::Over);
            }
            return Err(misused("another thread waits for the session's next tick".to_owned()));
        };
        let Some(part) = turn.part() else { return Ok(Wait::Over) };
        if let Some(loan) = part.open.take()
            && let Some(frame) = loan.held()
        {
            // If the server has ended, the next look for a frame says so.
            let _ = part.session.get_mut().answer(frame, rusty_contract::Reply::Abstain);
        }
        turn.reclaim();
        let Some(part) = turn.part() else { return Ok(Wait::Over) };
        let session = &mut part.session;
        let arrival = py.detach(|| next_within(session));
        match arrival {
            // A thread waits for the lock, to leave.
            Ok(Some(_)) if self.gate.is_leaving() => Ok(Wait::Over),
            Ok(None) if part.session.get().ending().is_none() && self.gate.is_leaving() => {
                Ok(Wait::Over)
            }
            Ok(Some(frame)) => {
                let loan = Loan::new(frame, &self.gate);
                let tick = loan.held().map(|frame| Tick::new(&loan, frame, &self.gate));
                part.open = Some(loan);
                Ok(tick.map_or(Wait::Nothing, Wait::Tick))
            }
            Ok(None) => match part.session.get().ending() {
                None => Ok(Wait::Nothing),
                Some(phase) => {
                    let broken = part.session.get().log_is_broken();
                    self.current(|current| current.ending = Some(phase));
                    let more = part.session.get().start().more_runs;
                    if broken || !more || !self.stays.load(Ordering::Relaxed) {
                        turn.end();
                    }
                    if broken {
                        return Err(RustyError::new_err("the log is damaged or lacks its end"));
                    }
                    Ok(Wait::Over)
                }
            },
            Err(error) => {
                turn.end();
                Err(exception(error))
            }
        }
    }

    /// Asks Python whether there is an interrupt. Ctrl-C leaves the run.
    fn look_around(&self, py: Python<'_>) -> PyResult<()> {
        py.check_signals().inspect_err(|e| {
            if e.is_instance_of::<PyKeyboardInterrupt>(py) {
                self.gate.stop.store(true, Ordering::Relaxed);
                self.close(py);
            }
        })
    }
}

fn next_within(
    session: &mut Lone<Sdk>,
) -> Result<Option<Lone<rusty_clients::HeldFrame>>, ClientError> {
    Ok(match session.get_mut().next_within(SLICE)? {
        // SAFETY: the caller has the lock of the session's gate, and `Loan` gives the
        // frame back to it.
        Arrival::Frame(frame) => Some(unsafe { Lone::new(frame) }),
        Arrival::Nothing | Arrival::End => None,
    })
}

/// Joins a run, or opens a log; iterate over what it returns.
///
/// With neither `run` nor `log` the command line says which, as a launcher writes
/// it: `--run NAME --name NAME --wait HOW --launcher PID`, or by hand `--run NAME`
/// or `--log PATH`; `--help` lists all. `out`, `wait` and `join_timeout` are then
/// the command line's, too: given here they count for nothing. The script is then
/// a program that takes part: asked to stop (SIGTERM, Ctrl-C) it leaves the run, and
/// it prints one line, not a traceback, if it could not join, was dropped, or the
/// server has ended. With `run`, Ctrl-C in the main thread leaves the run as well.
/// Signal handlers and an excepthook that a program has set stay as they are.
///
/// Args:
///     name: name in the roster, unless the command line has `--name`. Default:
///         the script's name.
///     run: the run to join.
///     log: work on this log instead, without a server.
///     out: with `log`: write the answers to this file as CSV.
///     wait: look for ticks for up to 400 microseconds before sleeping
///         ("balanced"), never sleep ("spin"), or sleep at once ("block").
///     join_timeout: how long to wait for the run to appear, s.
///     argv: read these arguments instead of `sys.argv[1:]`, for a script with
///         other arguments.
///
/// Raises:
///     Refused: the server says no.
///     RustyError: there is no such run or log, or it cannot be used.
///     ValueError: an argument that cannot be used.
///     SystemExit: the command line asks for help, or cannot be used.
#[pyfunction]
#[pyo3(signature = (name = None, *, run = None, log = None, out = None, wait = "balanced", join_timeout = 20.0, argv = None))]
#[allow(clippy::too_many_arguments, reason = "keywords of a Python function")]
fn join(
    py: Python<'_>,
    name: Option<&str>,
    run: Option<&str>,
    log: Option<PathBuf>,
    out: Option<PathBuf>,
    wait: &str,
    join_timeout: f64,
    argv: Option<Vec<OsString>>,
) -> PyResult<Session> {
    let argument =
        |field: &str, problem: String| PyValueError::new_err(format!("{field}: {problem}"));
    let program: Vec<OsString> = py.import("sys")?.getattr("argv")?.extract()?;
    let as_told = run.is_none() && log.is_none();
    let mut args = match (&run, &log) {
        (None, None) => from_command_line(py, &program, argv)?,
        (Some(_), Some(_)) => return Err(PyValueError::new_err("give run or log, not both")),
        _ => ClientArgs {
            run: run
                .map(|run| run.parse().map_err(|e| argument("run", format!("{e}"))))
                .transpose()?,
            // Who asks by an argument has another use for the answers.
            out: out.or_else(|| log.as_ref().map(|_| PathBuf::from("/dev/null"))),
            // A script names its own files, and may run again.
            force: true,
            log,
            wait: wait.parse().map_err(|e| argument("wait", e))?,
            join_timeout,
            ..ClientArgs::default()
        },
    };
    if args.name.is_none() {
        let script = program.first().and_then(|script| Path::new(script).file_stem());
        let script = script.filter(|stem| !stem.is_empty()).map(|stem| stem.to_string_lossy());
        let fallback = || script.map_or_else(|| "client".to_owned(), |stem| stem.into_owned());
        args.name = Some(name.map_or_else(fallback, str::to_owned));
    }
    let manners = if as_told { "take_part" } else { "leave_on_interrupt" };
    py.import("rusty._program")?.call_method0(manners)?;
    take_part(py, args).inspect_err(|error| {
        // For the code that prints it: its traceback says nothing.
        let _ = error.value(py).setattr("_joining", true);
    })
}

/// Joins as it is told.
fn take_part(py: Python<'_>, args: ClientArgs) -> PyResult<Session> {
    let stop = Arc::new(AtomicBool::new(false));
    let session = join_meanwhile(py, args, &stop)?;
    let told = session.get().start().clone();
    let gate = Gate::new(session, stop);
    if told.role.holds_key() {
        gate.leave();
        let text = format!(
            "{:?} is a {} in this run; in Python one takes part as estimator, driver or observer",
            told.name, told.role
        );
        return Err(RustyError::new_err(text));
    }
    let start = start::remember(py, told)?;
    let current = Mutex::new(Current { start, ending: None, is_begun: false });
    Ok(Session { gate, current, stays: AtomicBool::new(false) })
}

/// Reads the arguments that a launcher appends. As for any program, asking for
/// help or writing something else ends it.
fn from_command_line(
    py: Python<'_>,
    program: &[OsString],
    argv: Option<Vec<OsString>>,
) -> PyResult<ClientArgs> {
    let first = program.first().filter(|name| !name.is_empty()).cloned();
    let first = first.unwrap_or_else(|| OsString::from("python"));
    let rest = argv.unwrap_or_else(|| program.get(1..).unwrap_or_default().to_vec());
    ClientArgs::parse_from(std::iter::once(first).chain(rest)).or_else(|usage| {
        let sys = py.import("sys")?;
        let stream = sys.getattr(if usage.code == 0 { "stdout" } else { "stderr" })?;
        stream.call_method1("write", (&usage.text,))?;
        if usage.code != 0 {
            let hint = "\nFrom a script or notebook: rusty.join(run=\"NAME\") or rusty.join(log=\"PATH\")\n";
            stream.call_method1("write", (hint,))?;
        }
        Err(PySystemExit::new_err(usage.code))
    })
}

/// This process was asked to stop.
#[pyfunction]
fn _stop_all(py: Python<'_>) {
    py.detach(stop_all);
}

/// Leaves every run that is still going on: for the interpreter's end.
#[pyfunction]
fn _leave_all(py: Python<'_>) {
    py.detach(leave_all);
}

/// Before a fork: whatever arrays lie over stays where it is.
#[pyfunction]
fn _before_fork() {
    pin_all();
}

/// Adds the session to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Session>()?;
    module.add_class::<Runs>()?;
    module.add_class::<Tick>()?;
    module.add_function(wrap_pyfunction!(join, module)?)?;
    module.add_function(wrap_pyfunction!(_stop_all, module)?)?;
    module.add_function(wrap_pyfunction!(_leave_all, module)?)?;
    module.add_function(wrap_pyfunction!(_before_fork, module)?)
}
