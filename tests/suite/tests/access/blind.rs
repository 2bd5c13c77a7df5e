//! Blind logs: nothing in them tells the truth, and with their key they are
//! scored as if they had never been sealed.

use std::os::unix::fs::PermissionsExt as _;

use rusty_contract::BlindKey;
use rusty_tests::*;

const SEED: u64 = 0x8d3c_51f0_9a7e_6b24;
const SLIP: f64 = 0.043_721;
const BIAS: f64 = 0.012_347;
const SCENARIO: &str = r#"
name = "exam"
ticks = 90
start = { x_m = 6.0321, y_m = 4.4789, theta_rad = 0.0123 }
[[participant]]
name = "dead-reckoning"
command = ["dead-reckoning"]
map = "hidden"
initial_pose = "hidden"
[[participant]]
name = "logger"
role = "logger"
command = ["logger"]
"#;

struct Exam {
    place: Folder,
    log: PathBuf,
}

impl Exam {
    fn of(seed: u64) -> Self {
        let place = folder();
        let scenario = place.at("exam.toml");
        fs::write(&scenario, SCENARIO).unwrap();
        let (seed, out) = (seed.to_string(), place.at("run"));
        let (slip, bias) =
            (format!("robot.slip_std={SLIP}"), format!("robot.radius_bias_right={BIAS}"));
        let args = [arg(&scenario), "--seed", &seed, "--set", &slip, "--set", &bias];
        let report = launch("exam", &out, &args);
        Self { log: log_of(&report), place }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.place.at(name)
    }

    /// Seals a log as NAME.log and NAME.key.
    fn seal(&self, log: &Path, name: &str) -> Ended {
        let (blind, key) = (self.at(&format!("{name}.log")), self.at(&format!("{name}.key")));
        seal(log, &blind, &key)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.at(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

fn score(log: &Path, key: Option<&Path>, out: &Path) -> Ended {
    let mut args = vec!["--log", arg(log), "--force", "--out", arg(out)];
    args.extend(key.iter().flat_map(|key| ["--key-file", arg(key)]));
    execute("score", &args)
}

/// `score.json`, but for the paths of pictures and report.
fn scores(out: &Path) -> Value {
    let mut scores = json_file(&out.join("score.json"));
    scores["pictures"].take();
    scores["report"].take();
    scores
}

/// What the header and the truths tell and nothing that anyone may see does.
fn secrets(header: &LogHeader, records: &[TickRecord]) -> Vec<f64> {
    // What is in the frames and replies, by design.
    let mut public = vec![0u64];
    for r in records {
        public.extend([r.command.v_m_s, r.command.omega_rad_s].map(f64::to_bits));
        public.extend(r.ranges_m.iter().flatten().map(|x| x.to_bits()));
        for p in r.replies.iter().filter_map(|r| Some(r.estimate()?.pose_in_world)) {
            public.extend([p.x(), p.y(), p.theta()].map(f64::to_bits));
        }
    }
    let start = header.config.start;
    let mut secrets = vec![SLIP, BIAS, start.x(), start.y(), start.theta()];
    secrets.extend(records.iter().flat_map(|r| r.truth.unwrap()));
    secrets.retain(|value| !public.contains(&value.to_bits()));
    secrets
}

#[test]
fn a_blind_log_tells_no_truth_no_seed_and_no_true_parameter() {
    let exam = Exam::of(SEED);
    let report = exam.seal(&exam.log, "blind").expect(0).json();
    assert_eq!((&report["ticks"], &report["ticks_with_truth"]), (&90.into(), &90.into()));
    let (blind, key) = (exam.at("blind.log"), exam.at("blind.key"));
    assert_eq!(fs::metadata(&key).unwrap().permissions().mode() & 0o777, 0o600);

    let (header, records) = load(&exam.log);
    let secrets = secrets(&header, &records);
    assert!(secrets.len() > 200, "{}", secrets.len());
    let files = [&exam.log, &blind, &key].map(|file| fs::read(file).unwrap());
    let [open, sealed, kept] = &files;
    let seed = SEED.to_string();
    for (bytes, there) in [(open, true), (sealed, false), (kept, true)] {
        assert_eq!(holds(bytes, seed.as_bytes()), there);
        for (i, value) in secrets.iter().enumerate() {
            let shown = format!("{value:?}");
            let raw = holds(bytes, &value.to_le_bytes());
            // Parameters are in the header's text, truths in raw bytes.
            let found = raw || holds(bytes, shown.as_bytes());
            assert_eq!(found, there, "{shown}, secret {i}");
        }
    }
    assert!(!holds(sealed, &SEED.to_le_bytes()) && !holds(sealed, b"patrol"));
    assert!(!holds(sealed, b"\"walls\":[{") && holds(open, b"\"walls\":[{"));

    // All else is as it was.
    let (blind_header, blind_records) = load(&blind);
    for (a, b) in records.into_iter().zip(&blind_records) {
        assert_eq!(*b, TickRecord { truth: None, ..a });
    }
    assert_eq!(blind_header.roster, header.roster);
    let info = |log: &Path| about("info", log, &["--json"]).expect(0).json();
    let (open, sealed) = (info(&exam.log), info(&blind));
    assert_eq!(open["observable_digest"], sealed["observable_digest"]);
    assert_eq!(sealed["source"]["observable_digest"], sealed["observable_digest"]);
    assert_eq!((&sealed["seed"], &sealed["ticks_with_truth"]), (&Value::Null, &0.into()));
    let said = about("info", &blind, &[]).expect(0).stdout;
    for words in ["none: the log is blind", "world     hidden", "start     hidden"] {
        assert!(said.contains(words) && !said.contains("slip"), "{said}");
    }
    about("info", &blind, &["--tick", "9"]).expect(0).prints("unknown");
    sim_server(&["diff", arg(&exam.log), arg(&blind)])
        .expect(4)
        .prints("first difference: tick 0, truth\n");
    let said = sim_server(&["verify", "--clients", arg(&blind)]).expect(0).stdout;
    assert!(said.starts_with("intact: 90 ticks, digest "), "{said}");
    assert!(said.ends_with(", 90 answers of dead-reckoning\n"), "{said}");

    // With the key it is the log that it was made from, to the bit.
    let out = exam.at("opened");
    let args = ["--log", arg(&blind), "--key-file", arg(&key), "--out", arg(&out)];
    execute("logger", &args).expect(0);
    assert!(fs::read(out.join("run.log")).unwrap() == files[0], "another log");
    score(&exam.log, None, &exam.at("a")).expect(0);
    score(&blind, Some(&key), &exam.at("b")).expect(0);
    assert_eq!(scores(&exam.at("a")), scores(&exam.at("b")));
    let svg = |out: &str| fs::read(exam.at(out).join("report.svg")).unwrap();
    assert!(svg("a") == svg("b"), "another picture");
}

#[test]
fn a_replay_of_a_blind_log_says_that_it_has_no_truth_and_is_scored_with_the_key() {
    let exam = Exam::of(SEED);
    exam.seal(&exam.log, "blind").expect(0);
    let (blind, key) = (exam.at("blind.log"), exam.at("blind.key"));
    // The newcomer would be told map and
    // start by right, and cannot be.
    let mine = format!("mine={}", binary("probe-client").display());
    let (mut header, records) = load(&exam.log);
    header.roster.push(rusty_contract::Participant::new("score", rusty_contract::Role::Scorer));
    let newcomer = ["--add", mine.as_str()];
    let report = replay(&blind, &exam.at("played"), &newcomer).expect(0).json();
    assert_eq!(report["seed"], Value::Null);
    let comparison = &report["comparison"];
    assert_eq!((&comparison["compared"], &comparison["equal"]), (&90.into(), &90.into()));
    let played = log_of(&report);
    let (_, answered) = load(&played);
    let first = answered[0].replies[1].estimate().unwrap().pose_in_world;
    assert!(first.x().abs() < 0.1 && first.y() == 0.0, "{first:?}");
    assert_eq!(answered[0].ranges_m, records[0].ranges_m);
    let verdict = sim_server(&["verify", arg(&played)]).expect(0).stdout;
    assert!(verdict.starts_with("intact: 90 ticks"), "{verdict}");

    score(&exam.log, None, &exam.at("open")).expect(0);
    score(&played, Some(&key), &exam.at("with")).expect(0);
    let (open, with) = (scores(&exam.at("open")), scores(&exam.at("with")));
    assert_eq!(with["scores"][0], open["scores"][0]);
    assert_eq!(with["scores"][1]["name"], "mine");
    assert_eq!(with["scores"][1]["scored_ticks"], 90);
    assert_eq!(with["seed"], SEED);

    // A scorer that only observes has nothing to compare with, and no zeros to show.
    let scorer = exam.at("scorer.log");
    let bytes = fs::read(&blind).unwrap();
    let (blind_header, _) = load(&blind);
    let roster = [&blind_header.roster[..1], &header.roster[2..]].concat();
    let json = serde_json::to_vec(&LogHeader { roster, ..blind_header }).unwrap();
    let old = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let (length, check) = ((json.len() as u32).to_le_bytes(), crc32fast::hash(&json).to_le_bytes());
    let copy = [&bytes[..12], &length, &check, &json, &bytes[old..]].concat();
    fs::write(&scorer, copy).unwrap();
    let report = replay(&scorer, &exam.at("looked"), &[]).expect(0).json();
    assert_eq!(report["scores"], json!([]));
    assert!(text(&report, "unscored").contains("a blind log"), "{report}");
}

/// The command ends with this code, names what is wrong, and prints nothing.
#[track_caller]
fn refused(ended: Ended, code: i32, words: &str) {
    assert_eq!(ended.expect(code).says(words).stdout, "");
}

#[test]
fn what_does_not_fit_together_is_refused_by_name() {
    let (exam, other) = (Exam::of(SEED), Exam::of(SEED + 1));
    exam.seal(&exam.log, "blind").expect(0);
    other.seal(&other.log, "blind").expect(0);
    let (blind, key) = (exam.at("blind.log"), exam.at("blind.key"));
    let (bytes, secret) = (fs::read(&exam.log).unwrap(), fs::read(&key).unwrap());
    let out = exam.at("out");

    let with = |log: &Path, key: &Path| score(log, Some(key), &out);
    refused(with(&blind, &other.at("blind.key")), 1, "not of this log: the frame of tick 0 is");
    let mut late = BlindKey::from_bytes(&secret).unwrap();
    late.ticks[41].observable ^= 1;
    let late = exam.write("late.key", &late.to_bytes().unwrap());
    refused(with(&blind, &late), 1, "the frame of tick 41 is another, those before it are");
    let cut_key = exam.write("cut.key", &secret[..secret.len() - 9]);
    refused(with(&blind, &cut_key), 1, &format!("has {} bytes and should", secret.len() - 9));
    let mut flipped = secret.clone();
    flipped[500] ^= 4;
    refused(with(&blind, &exam.write("flip.key", &flipped)), 1, "the key's checksum fails");
    let words = exam.write("words.key", "12".repeat(32).as_bytes());
    refused(with(&blind, &words), 1, "this is no key of a blind log");
    refused(with(&blind, &exam.at("no.key")), 1, "no.key: No such file");
    refused(with(&exam.log, &key), 1, "is not blind: it has its own truth");
    refused(score(&blind, None, &out), 1, "is blind, nothing in it can be scored");

    refused(exam.seal(&blind, "twice"), 2, "is blind already");
    let new = |name: &str| exam.at(name);
    refused(seal(&exam.log, &exam.log, &new("k")), 2, "is the log that is to be sealed");
    refused(seal(&exam.log, &new("b"), &exam.log), 2, "is the log that is to be sealed");
    refused(seal(&exam.log, &new("b"), &new("b")), 2, "whoever gets the log would get the truth");
    refused(seal(&exam.log, &new("b"), &key), 2, "is there already, and nothing is written over");
    refused(seal(&exam.log, &blind, &new("k")), 2, "is there already, and nothing is written over");
    refused(seal(&exam.log, &new("no/b"), &new("k")), 1, "no/b: No such file");
    let mut damaged = bytes.clone();
    let half = damaged.len() / 2;
    damaged[half] ^= 1;
    refused(
        exam.seal(&exam.write("damaged", &damaged), "d"),
        1,
        "a blind log of it would look whole",
    );
    for left in ["b", "k", "d.log", "d.key", "twice.log", "twice.key"] {
        assert!(!exam.at(left).exists(), "{left} was left behind");
    }
    assert!(fs::read(&key).unwrap() == secret && fs::read(&exam.log).unwrap() == bytes);

    // A log without an end: what it has is sealed and scored, and that is said.
    let cut = exam.write("cut", &bytes[..bytes.len() - 100]);
    let report = exam.seal(&cut, "short").expect(3).json();
    assert_eq!((&report["ticks"], &report["complete"]), (&89.into(), &false.into()));
    score(&cut, None, &exam.at("cut-open")).expect(3);
    with(&exam.at("short.log"), &exam.at("short.key")).expect(3);
    assert_eq!(scores(&out), scores(&exam.at("cut-open")));
    with(&exam.at("short.log"), &key).expect(3).says("has 89 of the 90 ticks of its key");
    refused(with(&blind, &exam.at("short.key")), 1, "the key has 89 ticks, the log has more");
}

#[test]
fn a_recording_is_sealed_like_a_run() {
    let place = folder();
    let at = |name: &str| place.at(name);
    let mut carmen = "# by hand\nPARAM robot_front_laser_max 8.0\n".to_owned();
    for k in 0..=10 {
        let (x, stamp) = (0.1 * f64::from(k), 100.0 + 0.1 * f64::from(k));
        let (truth, scan) = (0.0173 + 1.02 * x, stamp + 0.05);
        let ranges = " 2.5".repeat(181);
        carmen += &format!("ODOM {x} 0 0 0.5 0 0 {stamp} robot {stamp}\n");
        carmen += &format!("FLASER 181{ranges} {truth} 0.25 0 {x} 0 0 {scan} robot {scan}\n");
    }
    fs::write(at("lab.log"), carmen).unwrap();
    import(&at("lab.log"), &at("real"), &[]).expect(0);
    let report = seal(&at("real"), &at("blind"), &at("key")).expect(0).json();
    assert_eq!((&report["ticks"], &report["ticks_with_truth"]), (&22.into(), &11.into()));
    let bytes = fs::read(at("blind")).unwrap();
    let (_, records) = load(&at("real"));
    for truth in records.iter().filter_map(|r| r.truth) {
        assert!(!holds(&bytes, &truth[0].to_le_bytes()), "{truth:?}");
    }
    assert!(!holds(&bytes, b"lab.log"));

    let again = |log: &str, to: &str| replay(&at(log), &at(to), &[]).expect(0).json();
    let (open, blind) = (again("real", "a"), again("blind", "b"));
    assert_eq!(blind["scores"], json!([]));
    score(Path::new(text(&open, "log")), None, &at("open")).expect(0);
    score(Path::new(text(&blind, "log")), Some(&at("key")), &at("with")).expect(0);
    let (open, with) = (scores(&at("open")), scores(&at("with")));
    assert_eq!(open["ticks_with_truth"], 11);
    assert_eq!(open, with);
}
