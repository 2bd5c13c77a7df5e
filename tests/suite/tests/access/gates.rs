//! What an estimator cannot reach: the truth, the seed, the true parameters
//! and the key, neither in the memory it can map nor in what it is told.

use std::collections::BTreeSet;

use rusty_contract::answer::Message;
use rusty_contract::{Answer, Credentials, DataSheet, Phase, Start, TruthKey};
use rusty_tests::*;

/// Numbers that stand nowhere by chance.
const SEED: u64 = 0x1E37_79B9_7F4A_7C15;
const BIAS: f64 = 0.012_345_678_912_345_679;
const SLIP: f64 = 0.021_313_131_313_131_31;
const DROPOUT: f64 = 0.031_415_161_718_192_02;

/// The usual run with those numbers; `more` goes into the estimator's entry.
fn scenario(more: &str) -> String {
    apartment_scenario()
        .replace("seed = 42", &format!("seed = {SEED}"))
        .replace("slip_std = 0.02", &format!("slip_std = {SLIP}\nradius_bias_right = {BIAS}"))
        .replace("beams = 180", &format!("beams = 180\ndropout = {DROPOUT}"))
        .replace("role = \"estimator\"", &format!("role = \"estimator\"\n{more}"))
}

fn serve(tag: &str, more: &str, args: &[&str]) -> (Live, Folder) {
    let place = folder();
    let file = place.write("s.toml", scenario(more));
    (Live::start("serve", tag, &[&[&file], args]), place)
}

/// Every byte that a process of this user finds of the run without its key:
/// shared memory and the folder, but the file that holds the key itself.
fn snapshot(live: &Live) -> Vec<u8> {
    let files = Domain::traces(&live.run);
    let memory = files.iter().filter(|f| f.to_string_lossy().ends_with(".data")).count();
    assert!(memory > 5, "shared memory is elsewhere: {files:?}");
    let mut bytes = Vec::new();
    for path in files {
        if !path.iter().any(|part| part == "keys" || part == "control-key") {
            // A socket cannot be read, and holds nothing. Of the zeros that
            // most of the memory is, a few will do.
            for page in fs::read(&path).unwrap_or_default().chunks(4096) {
                let touched = page.iter().any(|b| *b != 0);
                bytes.extend(if touched { page } else { &page[..page.len().min(8)] });
            }
        }
    }
    bytes
}

/// The first of the patterns that occurs.
fn first_held<'p>(bytes: &[u8], patterns: &'p [Vec<u8>]) -> Option<&'p Vec<u8>> {
    let mut by_first: Vec<Vec<&Vec<u8>>> = vec![Vec::new(); 256];
    for pattern in patterns {
        by_first[usize::from(pattern[0])].push(pattern);
    }
    let held = |i: usize| {
        by_first[usize::from(bytes[i])].iter().find(|p| bytes[i..].starts_with(p)).copied()
    };
    (0..bytes.len()).find_map(held)
}

/// Which of the sorted patterns occur, at any alignment.
fn found(bytes: &[u8], sorted: &[u64]) -> BTreeSet<u64> {
    let words = bytes.windows(8).map(|w| u64::from_le_bytes(w.try_into().unwrap()));
    words.filter(|w| *w != 0 && sorted.binary_search(w).is_ok()).collect()
}

/// A secret as memory might hold it: its bytes either way round, its text.
fn forms(bits: u64, texts: &[String]) -> Vec<Vec<u8>> {
    let mut forms = vec![bits.to_le_bytes().to_vec(), bits.to_be_bytes().to_vec()];
    forms.extend([format!("{bits:x}"), format!("{bits:X}")].map(String::into_bytes));
    forms.extend(texts.iter().map(|t| t.clone().into_bytes()));
    forms
}

#[test]
fn nothing_secret_lies_in_the_memory_of_a_run() {
    let (live, _place) = serve("memory", "", &["--pace", "1", "--ticks", "100000"]);
    let clients = ALL.map(|name| live.join(name, &[]));
    let mut snapshots = Vec::new();
    let key = Domain::credentials_file(&live.run, "score");
    let mut seen = 0;
    until("the log has grown several times", || {
        let length = fs::metadata(live.log()).map_or(0, |m| m.len());
        if length > seen {
            seen = length;
            snapshots.push(snapshot(&live));
        }
        snapshots.len() == 5
    });
    let told = Credentials::from_text(&fs::read_to_string(key).unwrap()).unwrap();
    let key = told.truth.expect("a scorer has the key").to_hex();
    live.server.signal(Signal::INT);
    assert!(clients.map(|c| c.wait().code) == [Some(0); 3]);
    let (records, complete) = live.ends_with(3).records();
    assert!(complete);

    // What everyone may know: estimates, ranges, commands, time, map and start.
    // A true value that equals one of these (the robot stands at its start, a
    // steered heading is exactly 0) is no secret where that one lies.
    let mut public = vec![0u64, 6.0f64.to_bits(), 4.5f64.to_bits()];
    let mut ranges = Vec::new();
    let (mut truths, mut all) = (Vec::new(), 0);
    for r in &records {
        ranges.extend(r.ranges_m.iter().flatten().map(|x| x.to_bits()));
        public.extend([r.time_s(0.02), r.command.v_m_s, r.command.omega_rad_s].map(f64::to_bits));
        for estimate in r.replies.iter().filter_map(|reply| reply.estimate()) {
            let p = estimate.pose_in_world;
            public.extend([p.x(), p.y(), p.theta()].map(f64::to_bits));
        }
        if r.tick >= 5 {
            truths.extend(r.truth.unwrap().map(f64::to_bits));
            all += 3;
        }
    }
    public.extend(&ranges);
    let public: BTreeSet<u64> = public.into_iter().collect();
    truths.retain(|bits| !public.contains(bits));
    assert!(truths.len() * 10 > all * 9, "{} of {all} can be told apart", truths.len());
    ranges.retain(|bits| *bits != 8.0f64.to_bits());
    truths.sort_unstable();
    ranges.sort_unstable();

    let key_bytes: Vec<u8> =
        (0..32).map(|i| u8::from_str_radix(&key[2 * i..2 * i + 2], 16).unwrap()).collect();
    let mut secrets = forms(SEED, &[SEED.to_string()]);
    secrets.extend(forms(BIAS.to_bits(), &[BIAS.to_string(), "0.0123456789".to_owned()]));
    secrets.extend(forms(SLIP.to_bits(), &[SLIP.to_string(), "0.0213131313".to_owned()]));
    secrets.extend(forms(DROPOUT.to_bits(), &[DROPOUT.to_string(), "0.0314151617".to_owned()]));
    secrets.extend([key_bytes[..16].to_vec(), key_bytes[16..].to_vec(), key.into_bytes()]);
    secrets.extend(["slip", "bias", "seed"].map(|word| word.as_bytes().to_vec()));
    let mut scans = 0;
    for bytes in &snapshots {
        assert_eq!(found(bytes, &truths), BTreeSet::new(), "true values lie open");
        let open = first_held(bytes, &secrets).map(|s| String::from_utf8_lossy(s));
        assert_eq!(open, None, "lies open");
        // The same scan does find what is there to be found.
        scans += found(bytes, &ranges).len();
        let told = [b"wheel_radius_m".to_vec()];
        assert!(first_held(bytes, &told).is_some(), "what a participant is told");
    }
    assert!(scans >= 100 * snapshots.len(), "{scans} ranges found");
}

/// Joins as the estimator, receives what it is told, looks at one frame, leaves.
fn told(tag: &str, more: &str) -> Start {
    let (live, _place) = serve(tag, more, &["--without", "score", "--without", "logger"]);
    let mut link = hand::join(&live.run, "dead-reckoning").unwrap();
    let frame = hand::next_frame(&mut link).unwrap();
    assert_eq!((frame.phase(), frame.tick(), frame.truth_known()), (Phase::Tick, 0, true));
    for byte in [0, 1, 0x5A, 0xFF] {
        let error = frame.open_truth(&TruthKey::from_bytes([byte; 32])).unwrap_err().to_string();
        assert!(error.contains("does not open the truth of tick 0"), "{error}");
    }
    assert_eq!(link.next_tally().unwrap().map(|t| t.tick), None, "others' answers");
    drop(frame);
    link.send_raw(Answer::carrying(&Message::Leave)).unwrap();
    let start = link.start().clone();
    drop(link);
    let run = live.run.clone();
    assert_eq!(live.server.wait().expect(1).json()["losses"][0]["kind"], "left");
    nothing_left(&run);
    start
}

#[test]
fn an_estimator_is_told_what_it_may_know_and_cannot_open_the_rest() {
    let start = told("told", "");
    assert!(start.map.is_some() && start.initial_pose.is_some());
    assert_eq!(start.sealed_brief, None);
    let json = serde_json::to_string(&start).unwrap();
    let secrets = [SEED.to_string(), BIAS.to_string(), SLIP.to_string(), DROPOUT.to_string()];
    let words = ["seed", "slip", "bias", "script", "key"].map(str::to_owned);
    for secret in secrets.iter().chain(&words) {
        assert!(!json.contains(secret.as_str()), "{secret} is in {json}");
    }
}

#[test]
fn an_estimator_without_map_and_pose_is_told_neither() {
    let start = told("hidden", "map = \"hidden\"\ninitial_pose = \"hidden\"");
    assert_eq!((&start.map, start.initial_pose), (&None, None));
    assert!(!serde_json::to_string(&start).unwrap().contains("walls"));
}

#[test]
fn an_estimator_is_told_the_figures_that_its_data_sheet_has() {
    let dropout = |tag: &str, more: &str| {
        let start = told(tag, more);
        let json = serde_json::to_string(&start).unwrap();
        assert_eq!(json.contains(&DROPOUT.to_string()), start.data_sheet == DataSheet::Given);
        assert_eq!((start.lidar.beams, start.lidar.range_max_m), (180, 8.0));
        (start.data_sheet, start.lidar.dropout)
    };
    let nominal = (DataSheet::Nominal, Some(0.0));
    assert_eq!(dropout("sheet-default", ""), nominal);
    assert_eq!(dropout("sheet-nominal", "data_sheet = \"nominal\""), nominal);
    let given = (DataSheet::Given, Some(DROPOUT));
    assert_eq!(dropout("sheet-given", "data_sheet = \"given\""), given);
    let hidden = (DataSheet::Hidden, None);
    assert_eq!(dropout("sheet-hidden", "data_sheet = \"hidden\""), hidden);
}
