//! An estimator that tries every way to what it must not know, says on stdout
//! how each went (a JSON line each), and then takes part like any other.

#[path = "hostile-client/calls.rs"]
mod calls;

use std::fs;
use std::io;
use std::os::fd::{AsRawFd as _, BorrowedFd};
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use calls::try_calls;
use clap::Parser;
use rustix::fs::MemfdFlags;
use rustix::process::{Pid, Signal};
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_contract::answer::Message;
use rusty_contract::{Answer, Exit, JoinRequest, Phase, Reply, RunName};
use rusty_link::{ClientLink, Domain, Incoming, LinkError, Peer, WaitPolicy};

#[derive(Parser)]
struct Cli {
    /// Only try to open this file; exit code 0 says that it could
    #[arg(long)]
    peek: Option<PathBuf>,
    /// Only leave this run's process group and outlive the run
    #[arg(long, value_name = "RUN")]
    stay: Option<RunName>,
    /// With --stay: do not start another process first
    #[arg(long)]
    orphan: bool,
    #[arg(long, required_unless_present_any = ["peek", "stay"])]
    run: Option<RunName>,
    #[arg(long, default_value = "hostile")]
    name: String,
    #[arg(long, default_value_t)]
    wait: WaitPolicy,
    #[arg(long)]
    launcher: Option<u32>,
    #[arg(long)]
    key_stdin: bool,
    /// The scenario of this run
    #[arg(long, default_value = ".")]
    scenario: PathBuf,
    /// The folder of this run's log
    #[arg(long, default_value = ".")]
    out: PathBuf,
    /// Another run, which is served by hand
    #[arg(long, default_value = "")]
    other_run: String,
    /// A file in /dev/shm that is not this program's
    #[arg(long, default_value = ".")]
    segment: PathBuf,
    /// A segment of that other run
    #[arg(long, default_value = ".")]
    other_memory: PathBuf,
    /// A file in /dev/shm, to be removed
    #[arg(long, default_value = ".")]
    removable: PathBuf,
    /// A folder as a home would be, with the sockets `stream` and `datagram`
    #[arg(long, default_value = ".")]
    home: PathBuf,
    /// A TCP port with a listener
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// A datagram socket without a path
    #[arg(long, default_value = "")]
    abstract_name: String,
}

fn main() -> Exit {
    // Before anything else is opened.
    let inherited: Vec<i32> = (3..256).filter(|fd| is_open(*fd)).collect();
    let cli = Cli::parse();
    if let Some(path) = &cli.peek {
        return if fs::File::open(path).is_ok() { Exit::Done } else { Exit::Failed };
    }
    if let Some(run) = &cli.stay {
        return stay(run, cli.orphan).map_or(Exit::Failed, |()| Exit::Done);
    }
    let Some(run) = &cli.run else { return Exit::Usage };
    let stop = AtomicBool::new(false);
    let request = JoinRequest::new(&cli.name, std::process::id(), cli.wait.awake_ns(), "hostile");
    let (launcher, timeout) = (cli.launcher.map(Peer::new), Duration::from_secs(20));
    let told = rusty_tests::credentials(cli.key_stdin);
    let joined =
        ClientLink::join_launched(run, launcher.as_ref(), told, &request, cli.wait, timeout, &stop);
    match joined.and_then(|mut link| take_part(&cli, &inherited, &mut link, &stop)) {
        Ok(()) => Exit::Done,
        Err(e) => {
            eprintln!("hostile: {e}");
            Exit::Failed
        }
    }
}

fn take_part(
    cli: &Cli,
    inherited: &[i32],
    link: &mut ClientLink,
    stop: &AtomicBool,
) -> Result<(), LinkError> {
    let start = link.start().clone();
    let pose = start.initial_pose.unwrap_or_default();
    let mut odometry = DeadReckoning::new(start.robot.drive, pose);
    loop {
        let Incoming::Frame(frame) = link.wait_frame(Duration::from_millis(500), stop)? else {
            continue;
        };
        if frame.phase() != Phase::Tick {
            return link.send_raw(Answer::carrying(&Message::Leave));
        }
        // Everybody is there, and has a few ticks behind it.
        if frame.tick() == 20 {
            try_files(cli);
            try_processes(cli, start.server_pid);
            try_sockets(cli);
            try_itself(inherited);
            try_programs(cli);
            try_calls(start.server_pid);
            try_to_stay(cli);
        }
        let reply = Reply::from(odometry.advance(frame.encoders()));
        link.answer(&frame, &Message::Reply(reply), false)?;
    }
}

fn exited(status: ExitStatus) -> io::Result<String> {
    match status.success() {
        true => Ok(String::new()),
        false => Err(io::Error::other(status.to_string())),
    }
}

fn report(attempt: &str, result: io::Result<String>) {
    let (ok, detail) = match result {
        Ok(detail) => (true, detail),
        Err(e) => (false, e.to_string()),
    };
    println!("{}", serde_json::json!({ "attempt": attempt, "ok": ok, "detail": detail }));
}

fn read(path: &Path) -> io::Result<String> {
    fs::read(path).map(|bytes| format!("{} bytes", bytes.len()))
}

fn list(path: &Path) -> io::Result<String> {
    fs::read_dir(path).map(|entries| format!("{} entries", entries.count()))
}

fn try_files(cli: &Cli) {
    let other = Domain::base().join(&cli.other_run);
    let own = cli.run.as_ref().map(|run| Domain::base().join(run.as_str())).unwrap_or_default();
    report("read-scenario", read(&cli.scenario));
    let append = fs::OpenOptions::new().append(true).open(&cli.scenario);
    report("write-scenario", append.map(|_| String::new()));
    let chmod = fs::metadata(&cli.scenario)
        .and_then(|found| fs::set_permissions(&cli.scenario, found.permissions()));
    report("chmod-scenario", chmod.map(|()| String::new()));
    report("read-log", read(&cli.out.join("run.log")));
    report("list-output", list(&cli.out));
    report("read-other-key", read(&other.join("keys/score")));
    report("list-other-run", list(&other));
    report("list-runs", list(&Domain::base()));
    report("list-own-folder", list(&own));
    report("read-own-key", read(&own.join("keys").join(&cli.name)));
    report("read-control-key", read(&own.join("control-key")));
    report("write-tmp", write(&std::env::temp_dir().join(format!("hostile-{}", cli.name))));
    report("write-home", write(&cli.home.join("planted")));
    report("list-memory", list(Path::new("/dev/shm")));
    report("remove-memory", fs::remove_file(&cli.removable).map(|()| String::new()));
    let watch = rustix::fs::inotify::init(rustix::fs::inotify::CreateFlags::empty());
    report("watch-files", watch.map(|_| String::new()).map_err(io::Error::from));
    report("open-memory-by-name", read(&cli.segment));
    report("open-memory-of-other-run", read(&cli.other_memory));
    // Known to be open; see the documentation of `rusty_engine::confine`.
    report("stat-log", fs::metadata(cli.out.join("run.log")).map(|m| m.len().to_string()));
}

fn write_to(path: &Path) -> io::Result<String> {
    fs::write(path, "x").map(|()| path.display().to_string())
}

fn write(path: &Path) -> io::Result<String> {
    let written = write_to(path)?;
    fs::remove_file(path)?;
    Ok(written)
}

fn try_processes(cli: &Cli, server: u32) {
    let of = |pid: u32, file: &str| PathBuf::from(format!("/proc/{pid}/{file}"));
    report("read-server-cmdline", read(&of(server, "cmdline")));
    report("read-server-environ", read(&of(server, "environ")));
    report("read-server-maps", read(&of(server, "maps")));
    report("list-server-fd", list(&of(server, "fd")));
    report("open-server-mem", fs::File::open(of(server, "mem")).map(|_| String::new()));
    let program = fs::read_link(of(server, "exe"));
    report("link-server-exe", program.map(|path| path.display().to_string()));
    report("list-processes", list(Path::new("/proc")));
    report("list-system", list(Path::new("/sys")));
    report("read-own-maps", read(Path::new("/proc/self/maps")));
    let scorer = find_scorer(cli);
    let memory =
        scorer.and_then(|pid| fs::File::open(of(pid, "mem")).map(|_| format!("process {pid}")));
    report("open-scorer-mem", memory);
    report("trace-server", trace(server));
    report("peek-server", peek(server));
    let pid = Pid::from_raw(server as i32).unwrap_or(Pid::INIT);
    let kill = |result: rustix::io::Result<()>| result.map(|()| String::new()).map_err(Into::into);
    report("signal-0-server", kill(rustix::process::test_kill_process(pid)));
    report("signal-server", kill(rustix::process::kill_process(pid, Signal::CONT)));
}

fn find_scorer(cli: &Cli) -> io::Result<u32> {
    let run = cli.run.as_ref().map(ToString::to_string).unwrap_or_default();
    for entry in fs::read_dir("/proc")?.flatten() {
        let Some(pid) = entry.file_name().to_str().and_then(|n| n.parse().ok()) else { continue };
        let line = fs::read(entry.path().join("cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line);
        if line.contains(&run) && line.contains("--key-stdin") && line.contains("score") {
            return Ok(pid);
        }
    }
    Err(io::Error::other("no scorer found"))
}

/// Attaches to a process as a debugger does, and lets it go again.
fn trace(pid: u32) -> io::Result<String> {
    let (none, pid) = (std::ptr::null_mut::<libc::c_void>(), pid as libc::pid_t);
    // SAFETY: the calls take numbers and null pointers only, and `waitpid` a
    // place on this stack; none touches this process's memory otherwise.
    unsafe {
        if libc::ptrace(libc::PTRACE_SEIZE, pid, none, none) < 0 {
            return Err(io::Error::last_os_error());
        }
        let mut status = 0;
        libc::ptrace(libc::PTRACE_INTERRUPT, pid, none, none);
        libc::waitpid(pid, &raw mut status, libc::__WALL);
        libc::ptrace(libc::PTRACE_DETACH, pid, none, none);
    }
    Ok(String::new())
}

/// Reads a byte of another process's memory.
fn peek(pid: u32) -> io::Result<String> {
    let mut byte = 0u8;
    let here = libc::iovec { iov_base: (&raw mut byte).cast(), iov_len: 1 };
    let there = libc::iovec { iov_base: 0x1000 as *mut libc::c_void, iov_len: 1 };
    // SAFETY: the first vector is one byte on this stack; the second is an
    // address in the other process, which the kernel checks.
    let read = unsafe {
        libc::process_vm_readv(pid as libc::pid_t, &raw const here, 1, &raw const there, 1, 0)
    };
    match io::Error::last_os_error() {
        _ if read >= 0 => Ok("read".to_owned()),
        // It was let in; there is nothing at that address.
        e if e.raw_os_error() == Some(libc::EFAULT) => Ok("let in".to_owned()),
        e => Err(e),
    }
}

fn try_sockets(cli: &Cli) {
    let tcp = std::net::TcpStream::connect(("127.0.0.1", cli.port));
    report("connect-tcp", tcp.map(|_| String::new()));
    let listen = std::net::TcpListener::bind("127.0.0.1:0");
    report("listen-tcp", listen.map(|_| String::new()));
    let udp = std::net::UdpSocket::bind("127.0.0.1:0");
    report("make-udp", udp.map(|_| String::new()));
    let stream = UnixStream::connect(cli.home.join("stream"));
    report("connect-unix", stream.map(|_| String::new()));
    let send = |to: &dyn Fn(&UnixDatagram) -> io::Result<()>| {
        let socket = UnixDatagram::unbound()?;
        to(&socket)?;
        socket.send(b"x").map(|_| String::new())
    };
    let hidden = SocketAddr::from_abstract_name(&cli.abstract_name);
    report("send-abstract", hidden.and_then(|to| send(&|socket| socket.connect_addr(&to))));
    // Known to be open; see the documentation of `rusty_engine::confine`.
    report("send-datagram", send(&|socket| socket.connect(cli.home.join("datagram"))));
}

fn try_programs(cli: &Cli) {
    let run = |command: &mut Command| {
        command.stdout(Stdio::null()).stderr(Stdio::null()).status().and_then(exited)
    };
    let loader = ["/lib64/ld-linux-x86-64.so.2", "/lib/ld-linux-aarch64.so.1"];
    let loader = loader.into_iter().find(|path| fs::metadata(path).is_ok()).unwrap_or_default();
    report("run-shell", run(Command::new("/bin/sh").args(["-c", "exit 0"])));
    report("load-shell", run(Command::new(loader).args(["/bin/sh", "-c", "exit 0"])));
    // Known to be open; see the documentation of `rusty_engine::confine`.
    let me = || std::env::current_exe();
    report("load-itself", me().and_then(|me| run(Command::new(loader).arg("--list").arg(me))));
    // Once more, in the hope that the rules are forgotten.
    let again = |program: &Path, file: &Path| run(Command::new(program).arg("--peek").arg(file));
    report("run-itself-again", me().and_then(|me| again(&me, &cli.scenario)));
    let memory = rustix::fs::memfd_create("program", MemfdFlags::empty()).map_err(io::Error::from);
    let from_memory = memory.and_then(|memory| {
        let mut file = fs::File::from(memory);
        io::copy(&mut fs::File::open(me()?)?, &mut file)?;
        // Open for writing, it cannot be run.
        let path = format!("/proc/self/fd/{}", file.as_raw_fd());
        let readable = fs::File::open(&path)?;
        drop(file);
        let path = format!("/proc/self/fd/{}", readable.as_raw_fd());
        again(Path::new(&path), Path::new("/dev/null"))
    });
    report("run-from-memory", from_memory);
}

/// Leaves a process and files. All are known to be possible; the server removes
/// or names them.
fn try_to_stay(cli: &Cli) {
    let Some(run) = &cli.run else { return };
    let own = Domain::find(run).map_err(io::Error::other);
    report("leave-own-memory", own.and_then(|own| write_to(&own.memory().join("left"))));
    let other = Path::new("/dev/shm").join(format!("{run}-left"));
    report("leave-other-memory", write_to(&other));
    report("leave-process", stay_as(run, &[]).and_then(|mut child| exited(child.wait()?)));
}

fn stay_as(run: &RunName, more: &[&str]) -> io::Result<Child> {
    let me = std::env::current_exe()?;
    Command::new(me).args(["--stay", run.as_str()]).args(more).stdin(Stdio::null()).spawn()
}

/// Leaves the group, starts an orphan that stays, and ends.
fn stay(run: &RunName, orphan: bool) -> io::Result<()> {
    if orphan {
        std::thread::sleep(Duration::from_secs(300));
        return Ok(());
    }
    report("leave-group", rustix::process::setsid().map(|_| String::new()).map_err(Into::into));
    stay_as(run, &["--orphan"]).map(drop)
}

fn try_itself(inherited: &[i32]) {
    let secret = std::env::var("RUSTY_TESTS_SECRET").map_err(io::Error::other);
    report("read-environment", secret);
    let found = if inherited.is_empty() { Err(io::Error::other("none")) } else { Ok(()) };
    report("inherit-descriptors", found.map(|()| format!("{inherited:?}")));
    let capable = rustix::thread::capabilities(None).map(|sets| sets.permitted.bits());
    let capable = capable.map_err(io::Error::from).and_then(|bits| match bits {
        0 => Err(io::Error::other("none")),
        bits => Ok(format!("{bits:x}")),
    });
    report("keep-capabilities", capable);
}

fn is_open(fd: i32) -> bool {
    // SAFETY: borrowed for one call, which reads a flag; an error says that no
    // such descriptor is open.
    rustix::io::fcntl_getfd(unsafe { BorrowedFd::borrow_raw(fd) }).is_ok()
}
