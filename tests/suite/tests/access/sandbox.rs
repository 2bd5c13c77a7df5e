//! The kernel gate: an estimator that tries every way to what it must not know
//! gets nowhere where it is confined, and does where it is not; confined or
//! not, a run has the same bits, and deaths are named the same.

use std::collections::BTreeMap;
use std::fs::File;
use std::net::TcpListener;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram, UnixListener};
use std::sync::OnceLock;

use rusty_tests::*;

/// What a confined participant can still do; `rusty_engine::confine` says why.
const KNOWN_TO_BE_OPEN: [&str; 5] =
    ["stat-log", "send-datagram", "load-itself", "leave-own-memory", "leave-process"];

/// What the settings of a machine may refuse to any user, or to all but root.
const BY_SETTING: [&str; 6] = [
    "call-io_uring_setup",
    "call-bpf",
    "call-perf_event_open",
    "call-keyctl",
    "call-userfaultfd",
    "call-quotactl",
];

/// What the operating system may refuse to a user who is not root even without
/// a sandbox: servers and scorers are not dumpable.
const FOR_ROOT: [&str; 9] = [
    "read-server-environ",
    "read-server-maps",
    "list-server-fd",
    "open-server-mem",
    "link-server-exe",
    "open-scorer-mem",
    "trace-server",
    "peek-server",
    "keep-capabilities",
];

/// A scenario with this estimator, `words` being its program and arguments.
fn scenario(place: &Path, sandbox: &str, words: &[&str]) -> String {
    let entry = estimator("estimator", words, &format!("sandbox = {sandbox}"));
    write(place, "s.toml", format!("name = \"sandbox\"\nticks = 100\n{entry}{RECORDERS}"))
}

/// Whether this kernel can confine in full; prints the reason if it cannot.
fn kernel_can() -> bool {
    static WHY_NOT: OnceLock<Option<String>> = OnceLock::new();
    let why_not = WHY_NOT.get_or_init(|| {
        let place = folder();
        let file = scenario(place.path(), "true", &["dead-reckoning"]);
        let out = place.at("run");
        let out = arg(&out);
        let ended = sim_server(&["launch", &file, "--json", "--out", out, "--ticks", "1"]);
        if ended.code == Some(2) && ended.stderr.contains("cannot be had") {
            return Some(ended.stderr);
        }
        ended.expect(0);
        None
    });
    if let Some(why) = why_not {
        skipped(why.trim());
    }
    why_not.is_none()
}

/// What lies about for a hostile estimator to find.
struct Bait {
    other: Live,
    home: Folder,
    port: TcpListener,
    hidden: String,
    segment: tempfile::NamedTempFile,
    removable: tempfile::NamedTempFile,
    _open: (UnixListener, UnixDatagram, UnixDatagram, File),
}

impl Bait {
    fn lay() -> Self {
        let other = Live::start("serve", "other", &[&LONG]);
        let key = Domain::credentials_file(&other.run, "score");
        until("the other run has a key", || fs::read(&key).is_ok_and(|k| k.len() > 60));
        let home = folder();
        let hidden = format!("{}-hidden", fresh_run("abstract"));
        let name = SocketAddr::from_abstract_name(&hidden).unwrap();
        let memory = || tempfile::NamedTempFile::new_in("/dev/shm").unwrap();
        // A descriptor that the starter of the server forgot to close.
        let forgotten = File::open("/dev/null").unwrap();
        rustix::io::fcntl_setfd(&forgotten, rustix::io::FdFlags::empty()).unwrap();
        let open = (
            UnixListener::bind(home.at("stream")).unwrap(),
            UnixDatagram::bind(home.at("datagram")).unwrap(),
            UnixDatagram::bind_addr(&name).unwrap(),
            forgotten,
        );
        let port = TcpListener::bind("127.0.0.1:0").unwrap();
        Self { other, home, port, hidden, segment: memory(), removable: memory(), _open: open }
    }

    /// Makes a run with the hostile estimator.
    fn run(&self, sandbox: &str) -> Tried {
        let (place, run) = (folder(), fresh_run("hostile"));
        let out = place.at("out");
        let path = |path: &Path| arg(path).to_owned();
        let words = [
            ("", path(&binary("hostile-client"))),
            ("--scenario", path(&place.at("s.toml"))),
            ("--out", path(&out)),
            ("--other-run", self.other.run.to_string()),
            ("--segment", path(self.segment.path())),
            ("--other-memory", path(&segment_of(&self.other.run))),
            ("--removable", path(self.removable.path())),
            ("--home", path(self.home.path())),
            ("--port", self.port.local_addr().unwrap().port().to_string()),
            ("--abstract-name", self.hidden.clone()),
        ];
        let words: Vec<&str> =
            words.iter().flat_map(|(k, v)| [*k, v.as_str()]).filter(|w| !w.is_empty()).collect();
        let file = scenario(place.path(), sandbox, &words);
        let mut server = Command::new(binary("sim-server"));
        server.args(["launch", &file, "--json", "--run", run.as_str(), "--out"]).arg(&out);
        server.env("RUSTY_TESTS_SECRET", "told to the server alone");
        let ended = Process::spawn(&mut server).wait().expect(0);
        nothing_left(&run);
        let said = fs::read_to_string(out.join("estimator.txt")).unwrap();
        let attempts = said.lines().map(|line| {
            let line: Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
            let how = (line["ok"].as_bool().unwrap(), text(&line, "detail").to_owned());
            (text(&line, "attempt").to_owned(), how)
        });
        let attempts = attempts.collect();
        let stays = |words: &[String]| words.windows(2).any(|w| *w == ["--stay", run.as_str()]);
        let left = processes().into_iter().filter(|(_, words)| stays(words));
        let left: Vec<u32> = left.map(|(pid, _)| pid).collect();
        left.iter().for_each(|pid| send_signal(*pid, Signal::KILL));
        let memory = Path::new("/dev/shm").join(format!("{run}-left"));
        let has_left_memory = fs::remove_file(&memory).is_ok();
        Tried { report: ended.json(), attempts, left, has_left_memory }
    }
}

/// Outcome of a run with the hostile estimator.
struct Tried {
    report: Value,
    attempts: BTreeMap<String, (bool, String)>,
    /// Its processes that outlived the run.
    left: Vec<u32>,
    /// Whether a file that it made in shared memory outlived the run.
    has_left_memory: bool,
}

/// A file of shared memory of a run.
fn segment_of(run: &RunName) -> PathBuf {
    let is_memory = |path: &PathBuf| path.extension() == Some("data".as_ref());
    let segment = || Domain::traces(run).into_iter().find(is_memory);
    until("the run has shared memory", || segment().is_some());
    segment().unwrap()
}

#[test]
fn a_hostile_estimator_gets_nowhere_confined_and_everywhere_else_if_not() {
    if !kernel_can() {
        return;
    }
    let bait = Bait::lay();
    let Tried { report: confined, attempts, left, has_left_memory } = bait.run("true");
    assert!(attempts.len() > 95, "{attempts:#?}");
    let is_open = |attempt: &String| KNOWN_TO_BE_OPEN.contains(&attempt.as_str());
    let otherwise: Vec<_> =
        attempts.iter().filter(|(attempt, (ok, _))| *ok != is_open(attempt)).collect();
    assert!(otherwise.is_empty(), "confined: {otherwise:#?}");
    assert!(bait.removable.path().exists());
    let gate = text(&confined["gates"], "estimator");
    assert!(gate.starts_with("kernel: landlock abi") && gate.ends_with("+ seccomp"), "{gate}");

    // Its processes end with it, and so does its memory.
    assert!(left.is_empty(), "confined: {left:?} outlived the run");
    assert!(!has_left_memory);

    // The same attempts, so that the ones above could have succeeded.
    let Tried { report: free, attempts, left, has_left_memory } = bait.run("\"none\"");
    assert_eq!((left.len(), has_left_memory), (1, true));
    for (attempt, (ok, detail)) in &attempts {
        let root_only = FOR_ROOT.contains(&attempt.as_str());
        if attempt == "read-own-key" {
            assert!(!ok, "a run that the server launched has a key file");
            continue;
        }
        // A kernel that is older than the call does not have it.
        let may_fail = BY_SETTING.contains(&attempt.as_str())
            || attempt.starts_with("call-") && detail.starts_with("Function not implemented");
        assert!(*ok || root_only || may_fail, "not confined, {attempt}: {detail}");
        if root_only && !rustix::process::getuid().is_root() {
            assert!(!ok, "not dumpable, but {attempt}: {detail}");
        }
    }
    assert!(text(&free["gates"], "estimator").contains("none was asked for"));
    // It took part properly, and the bits do not show it.
    assert_eq!(confined["digest"], free["digest"]);
    assert_eq!(confined["participants"][0]["answers"], 100);
    assert_eq!(timeless(&confined["scores"]), timeless(&free["scores"]));
    bait.other.server.signal(Signal::INT);
    bait.other.server.wait();
    nothing_left(&bait.other.run);
}

#[test]
fn dead_reckoning_has_the_same_bits_confined_and_its_log_replays() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    let run = |tag: &str, sandbox: &str| {
        let out = folder();
        let file = scenario(place.path(), sandbox, &["dead-reckoning"]);
        (launch(tag, out.path(), &[&file]), out)
    };
    let ((free, free_out), (confined, out)) = (run("free", "false"), run("cell", "\"required\""));
    assert_eq!(confined["digest"], free["digest"]);
    assert_eq!(confined["ended"], "done");
    // Nothing was printed, by the program or on its way into the cell.
    assert!(!out.at("estimator.txt").exists());
    // The log says that it was confined, and a replay confines it again; one
    // of a log that says nothing does if it is told to.
    for (log, more) in [(out, &[][..]), (free_out, &["--sandbox", "required"])] {
        let again = folder();
        let replayed = replay(&log.at("run.log"), again.path(), more).expect(0).json();
        assert_eq!(replayed["digest"], confined["digest"]);
        assert!(text(&replayed["gates"], "estimator").contains("landlock abi"));
    }
}

#[test]
fn the_death_of_a_confined_participant_is_named_as_any_other() {
    if !kernel_can() {
        return;
    }
    let probe = binary("probe-client");
    let probe = arg(&probe);
    for (mode, words) in [
        ("abort", "its process was killed by signal 6"),
        ("exit", "its process exited with code 7"),
        ("panic", "on request"),
    ] {
        let place = folder();
        let file = scenario(place.path(), "true", &[probe, "--mode", mode]);
        let out = place.at("run");
        let report = launch_to("death", &out, &[&file], 1);
        let loss = &report["losses"][0];
        assert_eq!(text(loss, "name"), "estimator", "{report}");
        let detail = text(loss, "detail");
        let said = fs::read_to_string(out.join("estimator.txt")).unwrap_or_default();
        assert!(detail.contains(words) || said.contains(words), "{mode}: {detail}\n{said}");
    }
    // A program that is not there is named before anybody waits for it, and so
    // is one that the kernel does not start by itself.
    let place = folder();
    let out = place.at("run");
    let file = scenario(place.path(), "true", &["./no-such-program"]);
    sim_server(&["launch", &file, "--out", arg(&out)])
        .expect(1)
        .says("cannot start ./no-such-program");
    let script = place.at("script");
    fs::write(&script, "#!/bin/sh\nexit 0\n").unwrap();
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    fs::set_permissions(&script, mode).unwrap();
    let file = scenario(place.path(), "true", &[arg(&script)]);
    let report = launch_to("script", &out, &[&file], 1);
    assert!(text(&report["losses"][0], "detail").contains("name the interpreter"), "{report}");
}

#[test]
fn files_that_are_declared_can_be_read_and_no_others() {
    if !kernel_can() {
        return;
    }
    let place = folder();
    for (file, files, code) in [("given.bin", "[\"given.bin\"]", 0), ("other.bin", "[]", 1)] {
        fs::write(place.at(file), "x").unwrap();
        let path = place.at(file);
        let words = [binary("hostile-client"), "--peek".into(), path];
        let words: Vec<&str> = words.iter().map(|w| arg(w)).collect();
        let scenario = scenario(place.path(), "true", &words);
        let text = fs::read_to_string(&scenario).unwrap();
        // Relative to the folder of the scenario, wherever the server runs.
        let text = text.replace("sandbox = true", &format!("sandbox = true\nfiles = {files}"));
        fs::write(&scenario, text).unwrap();
        // It only peeks and ends, so the run does not begin.
        let report = launch_to("files", &place.at("run"), &[&scenario], 1);
        let detail = report["losses"][0]["detail"].as_str().unwrap();
        assert!(detail.contains(&format!("exited with code {code}")), "{file}: {report}");
    }
    let scenario = scenario(place.path(), "true\nfiles = [\"missing\"]", &["dead-reckoning"]);
    sim_server(&["launch", &scenario]).expect(2).says("participant[0].files = ");
}

#[test]
fn what_the_server_does_not_start_cannot_be_required_to_be_confined() {
    let place = folder();
    let file = scenario(place.path(), "\"required\"", &["dead-reckoning"]);
    let run = fresh_run("by-hand");
    let ended = sim_server(&["serve", &file, "--run", run.as_str()]).expect(2);
    for word in ["participant[0].sandbox = required", "by hand", "launch", "if-possible"] {
        ended.says(word);
    }
    nothing_left(&run);
    // Wished for only: it is said, and the run goes on as if it were not.
    let file = scenario(place.path(), "\"if-possible\"", &["dead-reckoning"]);
    let live = Live::start("serve", "wished", &[&[&file, "--set", "ticks=5"]]);
    let clients = [("dead-reckoning", "estimator"), ("score", "score"), ("logger", "logger")]
        .map(|(program, name)| live.join(program, &["--name", name]));
    for client in clients {
        client.wait().expect(0);
    }
    let after = live.ends_with(0);
    after.says("estimator: kernel gate down: it is started by hand");
    let gate = text(&after.report["gates"], "estimator");
    assert!(gate.contains("kernel gate down"), "{gate}");
}
