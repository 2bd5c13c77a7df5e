//! The kernel gate: a participant that cannot reach what it must not know,
//! whatever it tries.
//!
//! Types keep an honest filter honest, and the seal keeps the truth out of
//! shared memory. Neither stops a program that opens the log file. This does,
//! for participants that ask for `sandbox` and that the server starts itself.
//! The server starts itself again as `sim-server confined …`; that process
//! applies the rules to itself and then becomes the participant: same process
//! number, same group, and no line of the participant's code runs before the
//! rules hold. They hold for all that it starts, for ever, for root as well.
//!
//! # What a confined participant may do
//!
//! * read and run its own program and the dynamic loader; read the system's
//!   libraries (`/lib`, `/lib64`, `/usr/lib`, `/usr/lib64`, `/usr/local/lib`,
//!   `/etc/ld.so.cache`) and what its scenario entry names in `files`;
//! * use `/dev/null`, `/dev/zero`, `/dev/random`, `/dev/urandom`, and its own
//!   output, which is open when it starts;
//! * if its `command` has `{out}`: read and write in a separate folder, named
//!   after it, in the folder to which the run writes;
//! * read its run's lock; in the folder of its run's shared memory: list, read,
//!   write, make and remove files, and make sockets, because the transport does;
//! * make Unix datagram sockets, pairs of connected sockets, threads and child
//!   processes; compute: the system calls of `confine/allowed.rs`.
//!
//! # What it may not
//!
//! `tests/suite/src/bin/hostile-client` tries each of these; the names of the attempts
//! are in parentheses. `tests/suite/tests/access/sandbox.rs` requires that each fails confined
//! and, where the machine's settings allow it, succeeds otherwise.
//!
//! * open any other file or folder: scenario, log, output folder, key files,
//!   home, `/tmp`, all of `/proc` and `/sys` (`read-*`, `write-*`, `list-*`);
//!   list, open, make or remove shared memory of other runs and programs
//!   (`list-memory`, `open-*memory*`, `leave-other-memory`, `remove-memory`);
//!   watch folders, delay others by leases (`watch-files`, `call-dnotify`,
//!   `call-lease`);
//! * start any other program by its path (`run-shell`, `load-shell`), or any
//!   program without one (`run-from-memory`, `call-execveat`,
//!   `call-memfd_create`);
//! * change modes, owners or times of files by name (`chmod-scenario`,
//!   `call-fchownat`, `call-utimensat`); read attributes by name, change
//!   attributes (`call-*xattr*`, `call-file_*`, `call-ioctl-setflags`);
//! * make network sockets of any kind, or Unix sockets other than datagram
//!   sockets (`connect-*`, `listen-tcp`, `make-udp`, `call-netlink`,
//!   `call-seqpacket`); list networks (`call-interfaces`); send to abstract
//!   sockets of others (`send-abstract`);
//! * use System V or POSIX queues, semaphores and memory without files
//!   (`call-shm*`, `call-msg*`, `call-sem*`, `call-mq_*`);
//! * signal, trace or read other processes, or take their descriptors
//!   (`signal-*`, `trace-server`, `peek-server`, `open-*-mem`, `call-kcmp`,
//!   `call-pidfd_getfd`, `call-move_pages`, `call-process_madvise`); change their
//!   limits or priorities (`call-limits-of-server`, `call-scheduler-of-server`,
//!   `call-setpriority`); leave its process group, start siblings, or let others
//!   trace it (`call-setpgid`, `call-clone-sibling`, `call-allow-tracer`);
//! * use capabilities (`keep-capabilities`), name spaces (`call-unshare`,
//!   `call-setns`, `call-clone-new-user`), mounts and file handles (`call-mount`,
//!   `call-open_tree*`, `call-name_to_handle_at`, `call-chroot`), `bpf`,
//!   `io_uring`, `perf`, keyrings (`call-bpf`, `call-io_*`,
//!   `call-perf_event_open`, `call-keyctl`, `call-userfaultfd`);
//! * make any system call that is not in `confine/allowed.rs`, also one that a
//!   later kernel adds (`call-statmount`, `call-quotactl`, `call-landlock`,
//!   `call-clone3`; all numbers: `calls::tests`).
//!
//! Its child processes end with it (`leave-process`): it cannot leave its process
//! group (`leave-group`), and the server kills the group once the participant
//! has ended, and waits until the group is empty.
//!
//! It is handed no environment but a short list (`ENVIRONMENT`) and no
//! descriptors but the standard three (`read-environment`,
//! `inherit-descriptors`).
//!
//! # What remains open
//!
//! * It can write to the shared memory of its run: frames, which others
//!   read (a changed frame fails its digest), and the transport's own notes.
//!   No truth is there in plaintext.
//! * It can load and run, as its own code, any file that it can read: libraries,
//!   and programs in the folders of libraries or in `files`. The dynamic loader
//!   does that for it (`load-itself`), and so does mapping the file. The same
//!   rules hold for that code.
//! * Landlock does not rule over names alone: whether any path exists, its
//!   size and times can be asked for (`stat-log`), and so the length of the log.
//! * A datagram socket that another process of this user has bound to a path
//!   can be sent to: up to Landlock ABI 8 no rule says otherwise. An
//!   accomplice outside can so be talked to.
//! * What it may open it may also lock (`flock`) and, as its owner, change the
//!   mode of; and it can cut and remove the memory of its run. A hostile
//!   participant can spoil its own run, fill memory, take processor time: this
//!   is a defence against looking, not against waste. The server removes the
//!   files that it leaves (`leave-own-memory`), and if the server is killed too,
//!   a scorer, a logger, the next start or `clean`.
//! * If the server is killed by SIGKILL, it kills no process: a hostile participant
//!   can then go on, within its rules.
//! * It can ask for the slot of another participant of its run. For the slots
//!   of scorers and loggers it lacks the key; a map that another estimator is
//!   given it could read.
//! * It can learn whether a process exists, and when it ends (`pidfd_open`): so
//!   participants notice that the server has ended.
//! * Timing: how long others take is visible to all.
//!
//! The server, scorers and loggers are not dumpable ([`close_memory`]): their
//! memory, environment and descriptors are closed to other processes of the
//! same user that are not confined. Root, and who has CAP_SYS_PTRACE, can open
//! them all the same; otherwise no process gets core dumps or attaches a debugger.
//!
//! Sources: Linux `Documentation/userspace-api/landlock.rst`,
//! `seccomp_filter.rst`, `no_new_privs.rst`; ptrace(2), capabilities(7).

mod allowed;
mod apply;
mod calls;
mod plan;

pub use apply::{Cell, ConfineError};
pub use plan::{Gate, Kernel, Landlock};

use std::convert::Infallible;
use std::ffi::OsString;
use std::os::fd::BorrowedFd;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;

use landlock::{LandlockStatus, RestrictSelf};
use rustix::io::{FdFlags, fcntl_getfd, fcntl_setfd};
use rustix::process::{DumpableBehavior, set_dumpable_behavior};
use rusty_contract::{FieldError, Participant, RunName};

use crate::executable::{Executable, THIS_FILE};

/// The variables that a confined participant keeps, where they are set: how to
/// print, how to report a panic, where Python finds packages and how it hashes.
const ENVIRONMENT: [&str; 7] =
    ["LANG", "LC_ALL", "LC_CTYPE", "TZ", "RUST_BACKTRACE", "PYTHONPATH", "PYTHONHASHSEED"];

/// What this kernel offers. Asks it, and changes nothing.
#[must_use]
pub fn kernel() -> Kernel {
    let seccomp = calls::can_be_filtered();
    // Without flags nothing is restricted: the status alone comes back.
    let status = RestrictSelf::default().no_new_privs(false).apply();
    let (landlock_abi, landlock) = match status.map(|s| s.landlock) {
        Ok(LandlockStatus::Available { effective_abi, kernel_abi }) => {
            let known = effective_abi as u32;
            let abi = kernel_abi.and_then(|abi| u32::try_from(abi).ok()).unwrap_or(known);
            (abi, Landlock::Available)
        }
        Ok(LandlockStatus::NotEnabled) => (0, Landlock::NotEnabled),
        Ok(LandlockStatus::NotImplemented) | Err(_) => (0, Landlock::NotBuilt),
    };
    Kernel { landlock_abi, landlock, seccomp }
}

/// Decides for everyone in the roster, in its order, how they are started.
///
/// # Errors
/// [`FieldError`] names the participant whose sandbox cannot be had, or whose
/// `files` are not there, and the remedy.
pub(crate) fn gates(roster: &[Participant], by_hand: bool) -> Result<Vec<Gate>, FieldError> {
    let kernel = kernel();
    let decide = |(i, p): (usize, &Participant)| {
        let by_hand = by_hand || p.command.is_empty();
        let gate = plan::gate(&format!("participant[{i}].sandbox"), p.sandbox, by_hand, kernel)?;
        for file in p.files.iter().filter(|_| gate.confines()) {
            std::fs::metadata(file).map_err(|e| {
                let remedy = "name files and folders relative to the scenario's folder";
                FieldError::new(format!("participant[{i}].files"), file, e.to_string(), remedy)
            })?;
        }
        Ok(gate)
    };
    roster.iter().enumerate().map(decide).collect()
}

/// The command that starts a participant's program confined; its arguments may
/// be added as to any command. In `own_folder` it may write.
#[must_use]
pub(crate) fn command(
    program: &Executable,
    run: &RunName,
    participant: &Participant,
    own_folder: Option<&Path>,
) -> Command {
    let mut command = Command::new(THIS_FILE);
    command.arg0("sim-server").arg("confined").args(["--cell", run.as_str()]);
    command.args(["--sandbox", participant.sandbox.word()]);
    for file in &participant.files {
        command.args(["--file", file]);
    }
    if let Some(folder) = own_folder {
        command.arg("--own-folder").arg(folder);
    }
    if let Some(name) = program.name() {
        command.args(["--as", name]);
    }
    command.arg("--").arg(program.file());
    command
}

/// Confines this process and becomes the cell's program.
///
/// # Errors
/// [`ConfineError`]: the process lives on, confined or not, and should end.
pub fn become_confined(cell: &Cell, args: &[OsString]) -> Result<Infallible, ConfineError> {
    keep_standard_descriptors()?;
    let mut program = Command::new(&cell.program);
    program.args(args).env_clear();
    if let Some(name) = &cell.name {
        program.arg0(name);
    }
    for name in ENVIRONMENT {
        if let Some(value) = std::env::var_os(name) {
            program.env(name, value);
        }
    }
    apply::apply(cell)?;
    let error = program.exec();
    Err(ConfineError::Exec { program: cell.program.display().to_string(), error })
}

/// Marks all descriptors but the standard three to be closed when this process
/// becomes another. The server's own are marked already; the process that started the
/// server may have left some open.
fn keep_standard_descriptors() -> Result<(), ConfineError> {
    let io = |error| ConfineError::Os { what: "list the open descriptors", error };
    for entry in std::fs::read_dir("/proc/self/fd").map_err(io)? {
        let name = entry.map_err(io)?.file_name();
        let Some(n) = name.to_str().and_then(|n| n.parse().ok()).filter(|n| *n > 2) else {
            continue;
        };
        // SAFETY: the number was just listed as an open descriptor of this
        // process, which has one thread; it is borrowed for two calls. Marking
        // a descriptor takes it from no other, and a closed one gives an error.
        let fd = unsafe { BorrowedFd::borrow_raw(n) };
        if let Ok(flags) = fcntl_getfd(fd) {
            fcntl_setfd(fd, flags | FdFlags::CLOEXEC)
                .map_err(ConfineError::os("close a descriptor"))?;
        }
    }
    Ok(())
}

/// Closes this process's memory to other processes of the same user (no core
/// dumps, no debugger, `/proc` entries owned by root).
///
/// # Errors
/// What the kernel said.
pub fn close_memory() -> std::io::Result<()> {
    Ok(set_dumpable_behavior(DumpableBehavior::NotDumpable)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::process::dumpable_behavior;

    #[test]
    fn asking_the_kernel_changes_nothing() {
        let before = rustix::thread::no_new_privs().unwrap();
        let found = kernel();
        assert_eq!(kernel(), found);
        assert_eq!(rustix::thread::no_new_privs().unwrap(), before);
        assert_eq!(found.landlock_abi > 0, found.landlock == Landlock::Available);
        // Nothing is confined by having been asked.
        assert!(std::fs::read_dir("/").is_ok());
    }

    #[test]
    fn memory_can_be_closed() {
        let before = dumpable_behavior().unwrap();
        close_memory().unwrap();
        assert_eq!(dumpable_behavior().unwrap(), DumpableBehavior::NotDumpable);
        set_dumpable_behavior(before).unwrap();
    }
}
