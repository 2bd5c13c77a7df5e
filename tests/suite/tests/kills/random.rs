//! Kills at random moments, drawn from the number of the case.

use std::sync::OnceLock;
use std::time::Instant;

use rustix::process::pidfd_send_signal;
use rusty_tests::*;

/// Everyone has a part: a driver, an estimator, a scorer, a logger.
const RUN: [&str; 10] = [
    "driver",
    "--ticks",
    "1500",
    "--set",
    "scan_every=20",
    "--add",
    "estimator=dead-reckoning",
    "--answer-timeout=60",
    "--join-timeout=60",
    "--quiet",
];
const TICKS: u64 = 1500;

/// Shorter than any time-out of a run that could end it in place of the kernel.
const LIMIT: Duration = Duration::from_secs(40);

/// How many kills, and of how many.
const USUAL: u64 = 250;
const VICTIMS: u64 = 5;

struct Calm {
    ticks: Vec<TickRecord>,
    took: Duration,
    header: u64,
}

fn calm() -> &'static Calm {
    static CALM: OnceLock<Calm> = OnceLock::new();
    CALM.get_or_init(|| {
        let out = folder();
        binaries();
        let began = Instant::now();
        launch("calm", out.path(), &RUN);
        let took = began.elapsed();
        let log = Log::read(&out.at("run.log"));
        let (complete, ticks) = (log.is_complete(), log.intact());
        assert!(complete && ticks.len() as u64 == TICKS);
        // A log longer than this has ticks next to its header.
        let bytes = fs::read(out.at("run.log")).unwrap();
        let header = u32::from_le_bytes(bytes[12..16].try_into().unwrap());
        Calm { ticks, took, header: 20 + u64::from(header) }
    })
}

/// From when on the moment counts.
#[derive(Clone, Copy, Debug)]
enum From {
    /// From where the victim is seen to run.
    Start,
    /// From where the logger has begun its file: the others join, or have joined.
    Log,
    /// From where ticks reach the file.
    Ticks,
    /// From where the scorer has written its drawing: everybody else is done.
    Drawing,
}

#[derive(Debug)]
struct Case {
    victim: &'static str,
    go_on: bool,
    from: From,
    after: Duration,
}

/// The result, to be counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Hit {
    Gathering,
    Running,
    Ending,
    TooLate,
    /// The server left files and no process that could have swept them.
    Alone,
}

impl Case {
    fn draw(victim: &'static str, number: u64) -> Self {
        let mut dice = Dice::of(victim, number);
        let whole = calm().took;
        let sees_the_end = matches!(victim, "sim-server" | "score");
        let (from, limit) = match dice.below(10) {
            0 => (From::Start, Duration::from_millis(4)),
            1 | 2 => (From::Start, Duration::from_millis(60)),
            3 => (From::Start, whole),
            4 | 5 => (From::Log, Duration::from_millis(60)),
            6 if sees_the_end => (From::Drawing, Duration::from_millis(100)),
            _ => (From::Ticks, Duration::from_millis(60)),
        };
        Self { victim, go_on: number % 2 == 1, from, after: dice.time(limit) }
    }

    fn run(&self) -> Hit {
        let on_loss = format!("on_loss={}", if self.go_on { "continue" } else { "abort" });
        let live = Live::start("launch", "kill", &[&RUN, &["--set", &on_loss]]);
        self.kill(&live);
        match self.victim {
            "sim-server" => killed_server(live),
            victim => killed_participant(live, victim, self.go_on),
        }
    }

    fn kill(&self, live: &Live) {
        let server = live.server.pid();
        let ended = || has_ended(server);
        let mut victim = (self.victim == "sim-server").then_some(server);
        until("the victim runs", || {
            if victim.is_none() {
                let all = participants(&live.run).into_iter();
                victim = all.filter(|(_, n)| n == self.victim).map(|(pid, _)| pid).next();
            }
            victim.is_some() || ended()
        });
        let Some(pidfd) = victim.and_then(hold) else { return };
        let out = live.out.path();
        let size = |file: &str| fs::metadata(out.join(file)).map(|m| m.len()).ok();
        let come = || match self.from {
            From::Start => true,
            From::Log => size("run.log").is_some(),
            From::Ticks => size("run.log") > Some(calm().header),
            From::Drawing => size("report.html").is_some(),
        };
        while !come() && !ended() {
            std::thread::sleep(Duration::from_micros(200));
        }
        let from = Instant::now();
        while let Some(rest) = self.after.checked_sub(from.elapsed()) {
            // Sleeping is late by some 50 µs; the last of it is looked at.
            match rest.checked_sub(Duration::from_micros(100)) {
                Some(rest) => std::thread::sleep(rest),
                None => std::hint::spin_loop(),
            }
        }
        let _ = pidfd_send_signal(pidfd, Signal::KILL);
    }
}

/// All cases of a victim; prints when they hit.
pub fn series(victim: &'static str) {
    let per_victim = cases("RUSTY_KILLS", USUAL);
    let range = match per_victim.start {
        0 => 0..per_victim.end.div_ceil(VICTIMS),
        _ => per_victim,
    };
    let mut hits = std::collections::BTreeMap::<Hit, u32>::new();
    for number in range.clone() {
        let case = Case::draw(victim, number);
        let again = format!("RUSTY_KILLS_CASE={number}, this test alone");
        let _repeat = Repeat(format!("{case:?} fails; again: {again}"));
        *hits.entry(case.run()).or_default() += 1;
    }
    println!("{victim}: cases {range:?}: {hits:?}");
    let on_time = range.end - range.start - u64::from(*hits.get(&Hit::TooLate).unwrap_or(&0));
    assert!(range.end - range.start < 20 || on_time > 0, "{victim}: {hits:?}");
}

/// The log holds what the calm run had: all of a tick before `replies_until`,
/// the world's part of it before `world_until`. It is simulated again, whatever
/// was answered. Returns how many ticks it has, and whether it is complete.
fn log_is_sound(out: &Path, replies_until: u64, world_until: u64) -> Option<(u64, bool)> {
    let path = out.join("run.log");
    let log = Log::try_read(&path)?;
    let (complete, ticks) = (log.is_complete(), log.intact());
    for (record, calm) in ticks.iter().zip(&calm().ticks) {
        assert_eq!(record.tick, calm.tick);
        assert!(record.tick >= replies_until || record == calm, "tick {}", record.tick);
        let world = |r: &TickRecord| TickRecord { replies: Vec::new(), ..r.clone() };
        assert!(record.tick >= world_until || world(record) == world(calm), "{}", record.tick);
    }
    let verdict = about("verify", &path, &["--json"]);
    let verdict = verdict.expect(if complete { 0 } else { 3 }).json();
    assert_eq!(verdict["bit_exact"], true, "{verdict}");
    assert_eq!(verdict["ticks"], ticks.len());
    Some((ticks.len() as u64, complete))
}

fn talk(out: &Path) -> Vec<(String, String)> {
    let files = fs::read_dir(out).unwrap().flatten();
    let texts = files.filter(|f| f.path().extension().is_some_and(|e| e == "txt"));
    let read = |f: fs::DirEntry| {
        (f.file_name().into_string().unwrap(), fs::read_to_string(f.path()).unwrap_or_default())
    };
    let talk: Vec<_> = texts.map(read).collect();
    for (name, said) in &talk {
        assert!(!said.contains("panicked") && !said.contains("do not trust"), "{name}: {said}");
    }
    talk
}

fn killed_server(live: Live) -> Hit {
    let Live { run, out, server } = live;
    let ended = server.wait_within(LIMIT);
    until_within(LIMIT, "everyone has ended", || processes_of(&run).is_empty());
    if ended.code == Some(0) {
        nothing_left(&run);
        return Hit::TooLate;
    }
    assert_eq!(ended.code, None, "{ended:#?}");
    let said = talk(out.path());
    let log = log_is_sound(out.path(), TICKS, TICKS);
    let mut hit = match log {
        Some((_, true)) => Hit::Ending,
        Some((1.., false)) => Hit::Running,
        _ => Hit::Gathering,
    };
    // A process that notices that the server has ended sweeps. Before the first and
    // after the last participant there is none.
    if !said.iter().any(|(_, said)| said.contains("is gone")) && !Domain::traces(&run).is_empty() {
        sim_server(&["clean", "--json"]).expect(0);
        hit = Hit::Alone;
    }
    nothing_left(&run);
    hit
}

fn killed_participant(live: Live, victim: &str, go_on: bool) -> Hit {
    let Live { run, out, server } = live;
    let ended = server.wait_within(LIMIT);
    let left = processes_of(&run);
    assert!(left.is_empty(), "processes of the run live on: {left:?}");
    nothing_left(&run);
    talk(out.path());
    let report = ended.json();
    let losses = list(&report, "losses");
    let Some(loss) = losses.first() else {
        // It had left.
        assert_eq!(text(&report, "ended"), "done", "{ended:#?}");
        assert!(matches!(ended.code, Some(0 | 3)), "{ended:#?}");
        let blamed = format!("{victim}: its process was killed by signal 9");
        let remarks = list(&report, "remarks");
        let fair = |r: &Value| r.as_str().unwrap().starts_with(&blamed);
        let scoreless = |r: &Value| victim == "score" && r == "there are no scores of this run";
        assert!(remarks.iter().all(|r| fair(r) || scoreless(r)), "{ended:#?}");
        assert_eq!(ended.code == Some(0), remarks.is_empty());
        return Hit::TooLate;
    };
    assert_eq!(losses.len(), 1, "{ended:#?}");
    assert_eq!((text(loss, "name"), text(loss, "kind")), (victim, "dead"), "{ended:#?}");
    assert!(text(loss, "detail").contains("its process was killed by signal 9"), "{loss}");
    ended.says(&format!("lost: {victim} dead"));
    let tick = loss["tick"].as_u64();
    let ending = tick == Some(TICKS);
    let aborted = !go_on && !ending;
    let (word, code) = if aborted { ("aborted", 1) } else { ("done", 3) };
    assert_eq!((text(&report, "ended"), ended.code), (word, Some(code)), "{ended:#?}");
    let ticks = report["ticks"].as_u64().unwrap();
    assert_eq!(ticks, if aborted { tick.unwrap_or(0) } else { TICKS });
    let replies_until = tick.unwrap_or(0);
    let world_until = if victim == "wander" { replies_until } else { TICKS };
    let log = log_is_sound(out.path(), replies_until, world_until);
    // No other log is cut; a run without a tick has perhaps no log.
    if victim != "logger" && ticks > 0 {
        assert_eq!(log, Some((ticks, true)), "{ended:#?}");
    }
    match tick {
        None => Hit::Gathering,
        Some(TICKS) => Hit::Ending,
        Some(_) => Hit::Running,
    }
}
