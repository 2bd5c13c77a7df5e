//! What is refused, and in which words: scenarios, arguments, clients, answers
//! and files that cannot be used. A refusal names the thing, says what is
//! wrong with it, has the right exit code, and leaves nothing behind.

use rusty_link::Peer;
use rusty_tests::*;

/// `sim-server` with these arguments ends with this code and says all of this
/// on stderr, without a panic.
#[track_caller]
fn refused(args: &[&str], code: i32, words: &[&str]) {
    says_all(sim_server(args), code, words);
}

#[track_caller]
fn says_all(ended: Ended, code: i32, words: &[&str]) {
    let ended = ended.expect(code);
    words.iter().for_each(|word| _ = ended.says(word));
    assert!(!ended.stderr.contains("panicked"), "{ended:?}");
}

fn a_log(folder: &Path) -> Vec<u8> {
    launch("log", folder, &["--ticks", "40"]);
    fs::read(folder.join("run.log")).unwrap()
}

#[test]
fn a_field_that_cannot_be_used_is_named_with_its_value_in_a_file() {
    let place = folder();
    for (text, words) in [
        ("sede = 1", "unknown field `sede`"),
        ("[robot]\nslip = 0.1", "unknown field `slip`"),
        ("[robot]\nslip_std = nan", "robot.slip_std = NaN: is not a number"),
        ("[robot]\nradius_bias_right = -3.0", "robot.radius_bias_right = -3: is out of range"),
        ("[lidar]\nrange_max_m = -8.0", "lidar.range_max_m = -8: is out of range"),
        ("dt_s = -0.02", "dt_s = -0.02: is out of range"),
        ("[[participant]]\nname = \"a/b\"", "\"a/b\" has another character"),
        ("[[participant]]\nname = \"a\"\n[[participant]]\nname = \"a\"", "is there twice"),
        ("world = \"moon\"", "world = moon: is no built-in world; use open, hallway, apartment"),
        ("world_file = \"moon.toml\"", "moon.toml: No such file"),
        ("ticks = ", "TOML parse error at line 1"),
    ] {
        let file = place.write("s.toml", text);
        refused(&["launch", &file], 2, &[words]);
    }
    refused(&["launch", "nowhere.toml"], 2, &["nowhere.toml: No such file", "built-in", "patrol"]);
}

#[test]
fn a_field_that_cannot_be_used_is_named_with_its_value_on_the_command_line() {
    for (change, words) in [
        ("robot.slip_std=nan", "robot.slip_std=nan: is NaN or infinite"),
        ("robot.slip_std=-0.1", "robot.slip_std = -0.1: is out of range"),
        ("robot.ticks_per_rev=0", "robot.ticks_per_rev = 0: is out of range"),
        ("lidar.beams=5000", "lidar.beams = 5000: is out of range; use a whole number from 1"),
        ("lidar.beams=-1", "--set lidar.beams=-1: "),
        ("lidar.range_max_m=inf", "lidar.range_max_m=inf: is NaN or infinite"),
        ("dt_s=0", "dt_s = 0: is out of range"),
        ("ticks=0", "ticks = 0: is out of range"),
        ("ticks=1e18", "expected u64"),
        ("seed=-1", "--set seed=-1: "),
        ("start.x_m=1e300", "is out of range"),
        ("start.theta_rad=nan", "start.theta_rad=nan: is NaN or infinite"),
        ("start.x_m=0.0", "start = (0, 4.5) m in world \"apartment\": the body"),
        ("start.x_m=200.0", "start = (200, 4.5) m: lies outside the world \"apartment\""),
        ("answer_timeout_s=-1", "answer_timeout_s = -1: is out of range"),
        ("script.leg_s=nan", "script.leg_s=nan: is NaN or infinite"),
        ("script.kind=waltz", "unknown variant `waltz`"),
        ("script={ kind = \"commands\" }", "give `file` or `list`"),
        ("on_loss=maybe", "unknown variant `maybe`"),
        ("lidar.beems=3", "unknown field `beems`"),
        ("robot.slip_std", "has no `=`"),
        ("robot.slip_std.x=1", "goes through a value"),
    ] {
        refused(&["launch", "--set", change], 2, &[words]);
    }
    refused(&["launch", "--ticks", "0"], 2, &["ticks = 0: is out of range"]);
    for seed in [&["--seed=-1"][..], &["--seed", "-1"]] {
        let words = ["'-1' for '--seed", "from 0 to 18446744073709551615"];
        refused(&[&["launch"], seed].concat(), 2, &words);
    }
    refused(&["launch", "--pace", "nan"], 2, &["\"nan\" is no pace; use max, real"]);
    refused(&["launch", "--answer-timeout", "nan"], 2, &["--answer-timeout NaN"]);
    refused(&["launch", "--without", "ghost"], 2, &["ghost: is not there", "score, logger"]);
}

#[test]
fn a_name_that_is_none_is_refused() {
    for name in ["../x", "-x", "", ".", "a b", "a/b", "ä", "twenty-five-letters-is-too"] {
        let arg = format!("--run={name}");
        refused(&["launch", &arg], 2, &[&format!("run name {name:?} "), "1 to 24 letters"]);
    }
}

#[test]
fn a_world_that_is_broken_is_refused_with_the_wall() {
    let place = folder();
    let world = "name = \"w\"\nbounds = [0.0, 0.0, 4.0, 3.0]\n\
                 walls = [{ a = [0.0, 0.0], b = [4.0, 0.0], material = \"Wall\" },\n\
                 { a = [4.0, HERE], b = [4.0, 3.0], material = \"Wall\" }]\n";
    let scenario = place.write("s.toml", "world_file = \"w.toml\"\n");
    for (value, words) in [
        ("nan", "wall 1 from [4.0, NaN] to [4.0, 3.0] has a coordinate that is not finite"),
        ("0.005", "wall 0, end `b` at [4.0, 0.0] touches no wall but stops 5.000e-3 m from wall 1"),
        ("3.0", "wall 1 from [4.0, 3.0] to [4.0, 3.0] is 0e0 m long"),
        ("9.0", "wall 1, end `a` at [4.0, 9.0] lies outside `bounds`"),
        ("\"x\"", "TOML parse error at line 4"),
    ] {
        let file = place.write("w.toml", world.replace("HERE", value));
        refused(&["launch", &scenario], 2, &["w.toml: ", words]);
        refused(&["worlds", &file], 2, &["w.toml: ", words]);
    }
    refused(&["worlds", "moon"], 2, &["moon: No such file", "built-in worlds: open"]);
}

#[test]
fn a_participant_that_cannot_be_started_is_named_and_the_others_end() {
    for (command, words) in [
        ("no-such-program", "\"no-such-program\" is neither beside "),
        ("dead-reckonin", "did you mean \"dead-reckoning\"?"),
        ("/no/such", "cannot start /no/such: No such file"),
        ("/etc/passwd", "cannot start /etc/passwd: Permission denied"),
    ] {
        let add = format!("ghost={command}");
        let ended = run_to("ghost", folder().path(), &["launch", "--add", &add]);
        says_all(ended, 1, &["participant \"ghost\": ", words]);
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let place = folder();
    let file = place.write("file", "");
    for (out, code, words) in
        [(file.clone(), 2, " is a file"), (format!("{file}/x"), 1, ": Not a directory")]
    {
        let ended = run_to("out", Path::new(&out), &["launch"]);
        says_all(ended, code, &[&format!("{out}{words}")]);
    }
}

#[test]
fn a_name_is_served_once_at_a_time() {
    let live = Live::start("serve", "once", &[]);
    until("it serves", || Domain::find(&live.run).is_ok_and(|d| d.server_pid() != 0));
    let pid = live.server.pid().to_string();
    for verb in ["serve", "launch"] {
        let in_use = format!("run {:?} is in use by process {pid}", live.run.as_str());
        refused(&[verb, "--run", live.run.as_str()], 1, &[&in_use, "--run"]);
    }
    live.server.signal(Signal::TERM);
    live.ends_with(3);
}

#[test]
fn a_client_that_does_not_fit_is_told_why() {
    let live = Live::start("serve", "fit", &[&["--join-timeout", "600"]]);
    let strange = live.join("dead-reckoning", &["--name", "stranger"]).wait().expect(1);
    let words = "the roster has no participant \"stranger\"; it has: dead-reckoning, score, logger";
    strange.says(words);
    for (mode, words) in [
        ("wrong-layout", "the client was built for layout "),
        ("wrong-protocol", "the client speaks protocol 3, the server 2; build both"),
    ] {
        let args = ["--name", "dead-reckoning", "--mode", mode];
        let client = live.join("probe-client", &args).wait().expect(1);
        assert!(client.stderr.contains(words), "{mode}: {}", client.stderr);
    }
    live.join("score", &["--name", "dead-reckoning"])
        .wait()
        .expect(1)
        .says("has the role estimator");
    // That one had taken the slot, and its failure ends the run.
    let after = live.ends_with(1);
    let said = after.stderr.matches("refused a client: ").count();
    assert_eq!(said, 3, "{}", after.stderr);
}

#[test]
fn the_second_of_a_name_is_refused_and_the_first_stays() {
    let live = Live::start("serve", "twice", &[]);
    let pair = [(); 2].map(|()| live.join("dead-reckoning", &[]));
    let ended = |p: &Process| Peer::new(p.pid()).is_dead();
    until("one of two is refused", || pair.iter().any(ended));
    let [first, second] = pair;
    let (refused, stays) = if ended(&first) { (first, second) } else { (second, first) };
    let words = format!("\"dead-reckoning\" has joined already (process {})", stays.pid());
    refused.wait().expect(1).says(&words);
    let recorders = ["score", "logger"].map(|name| live.join(name, &[]));
    assert_eq!(stays.wait().code, Some(0));
    assert!(recorders.map(|c| c.wait().code) == [Some(0); 2]);
    live.ends_with(0).verifies(0);
}

#[test]
fn a_required_participant_that_is_refused_ends_the_run_in_its_words() {
    for (mode, words) in [("wrong-layout", "built for layout"), ("wrong-protocol", "protocol 3")] {
        let after = with_probe("refused", mode, &[&["--ticks", "50"]]).ends_with(1);
        after.lost("dead-reckoning", "dead", "exited with code 1; it printed:\n    probe: refused");
        let detail = text(&after.report["losses"][0], "detail");
        assert!(detail.contains(words) && after.stderr.contains(words), "{detail}");
    }
}

#[test]
fn an_answer_that_is_none_is_named_and_its_sender_lost() {
    for (mode, words) in [
        ("nan-estimate", "estimate x_m is NaN"),
        ("nan-command", "command v_m_s is NaN"),
        ("future-tick", "it answered tick 11, asked was tick 10"),
        ("wrong-digest", "it saw another frame at tick 10: digest "),
    ] {
        let ticks = ["--ticks", "50"];
        let aborted = with_probe("invalid", mode, &[&ticks]).ends_with(1);
        aborted.lost_as("dead-reckoning", "invalid", "sent an invalid answer", words);
        assert_eq!(
            (&aborted.report["ticks"], aborted.verifies(0)["ticks"].as_u64()),
            (&10.into(), Some(10))
        );
        let went_on = with_probe("invalid", mode, &[&ticks, &GO_ON]).ends_with(3);
        went_on.lost_as("dead-reckoning", "invalid", "sent an invalid answer", words);
        went_on.went_on_without_the_estimator();
    }
}

#[test]
fn an_answer_to_a_tick_that_is_over_counts_as_a_stray() {
    let ticks = ["--ticks", "50"];
    let doubled = with_probe("double", "double", &[&ticks]).ends_with(0);
    let strays = doubled.report["participants"][0]["strays"].as_u64().unwrap();
    // The second answers to the last ticks may come when no process asks any more.
    assert!((30..=40).contains(&strays), "{strays}");
    let out = folder();
    assert_eq!(doubled.report["digest"], launch("calm", out.path(), &ticks)["digest"]);
    let timeout = ["--answer-timeout", "1"];
    let old = with_probe("old", "old-tick", &[&ticks, &timeout]).ends_with(1);
    old.lost("dead-reckoning", "stalled", "no answer to tick 10 within 1 s");
    assert_eq!(old.report["participants"][0]["strays"], 1);
}

#[test]
fn a_full_disk_is_the_logger_s_loss_and_what_was_written_can_be_read() {
    for go_on in [&[][..], &GO_ON] {
        let Some(disk) = Disk::mount("") else { return };
        // The logger alone writes there.
        let logger = format!("command = [\"logger\", \"--out\", {:?}]", disk.0.path());
        let place = folder();
        let text = apartment_scenario().replace("command = [\"logger\"]", &logger);
        let scenario = place.write("s.toml", text);
        let after = Live::start("launch", "full", &[&[&scenario], go_on])
            .ends_with(if go_on.is_empty() { 1 } else { 3 });
        after.lost("logger", "failed", "it reported a failure of its own");
        let remarks = after.report["remarks"].to_string();
        assert!(remarks.contains("logger: its process exited with code 1"), "{remarks}");
        assert!(remarks.contains("run.log: No space left on device"), "{remarks}");
        if !go_on.is_empty() {
            assert_eq!(after.report["ticks"], 1500);
        }
        let log = disk.0.at("run.log");
        let verdict = sim_server(&["verify", "--json", arg(&log)]).expect(3).json();
        assert_eq!(verdict["bit_exact"], true);
        assert!(verdict["ticks"].as_u64().unwrap() > 0);
    }
}

#[test]
fn a_full_disk_for_everything_a_run_writes_is_said_by_the_server() {
    for (go_on, code) in [(&[][..], 1), (&GO_ON, 3)] {
        let Some(disk) = Disk::mount("") else { return };
        let out = disk.0.path();
        let ended = run_to("full", out, &[&["launch"], go_on].concat()).expect(code);
        let report = ended.json();
        let mut losses = list(&report, "losses").iter();
        assert!(losses.any(|l| l["name"] == "logger" && l["kind"] == "failed"), "{report}");
        let said = list(&report, "remarks").iter().filter_map(|r| r.as_str());
        let logger: Vec<&str> = said.filter(|r| r.starts_with("logger: ")).collect();
        assert!(logger[0].contains("exited with code 1;"), "{logger:?}");
        assert!(logger[0].contains("No space left on device"), "{logger:?}");
        let verdict = about("verify", &out.join("run.log"), &["--json"]).expect(3).json();
        assert!(verdict["bit_exact"] == true && verdict["ticks"].as_u64().unwrap() > 0);
    }
}

#[test]
fn a_run_does_not_care_whether_its_talk_can_be_written() {
    let (run, out) = (fresh_run("deaf"), folder());
    let args = ["launch", "--ticks", "50", "--run", run.as_str(), "--out", arg(out.path())];
    let mut shell = shell("exec \"$0\" \"$@\" 2>/dev/full", "sim-server", &args);
    Process::spawn(&mut shell).wait().expect(0).prints("digest ");
    nothing_left(&run);
}

#[test]
fn a_file_that_is_no_log_is_refused_by_everyone_who_reads_logs() {
    let place = folder();
    let bytes = a_log(place.path());
    let good = arg(&place.at("run.log")).to_owned();
    let header = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let png = fs::read(place.at("report.png")).unwrap();
    let (mut version, mut broken) = (bytes.clone(), bytes.clone());
    version[8] = 77;
    broken[header / 2] ^= 1;
    let mut cases = vec![
        (place.write("empty", ""), "this is no run log".to_owned()),
        (place.write("png", png), "this is no run log".to_owned()),
        (place.write("version", version), "log format 77, this build reads 1".to_owned()),
        (place.write("broken", broken), "header, byte 20: its checksum fails".to_owned()),
        (arg(place.path()).to_owned(), "Is a directory".to_owned()),
        (format!("{good}.gone"), "No such file".to_owned()),
    ];
    for cut in (50..header).step_by(50) {
        let file = place.write(&format!("cut{cut}"), &bytes[..cut]);
        cases.push((file, format!("header, byte {cut}: the file ends here")));
    }
    for (file, words) in cases {
        for args in [&["verify"][..], &["info"], &["replay"], &["diff", &good]] {
            refused(&[args, &[&file]].concat(), 1, &[&file, &words]);
        }
    }
    // A log without a tick is a log, but none to play.
    let bare = place.write("bare", &bytes[..header]);
    sim_server(&["info", &bare]).expect(3);
    sim_server(&["verify", &bare]).expect(3);
    refused(&["replay", &bare], 1, &["there is no complete tick in it to play"]);
}

#[test]
fn a_replay_whose_participant_is_gone_names_it() {
    let place = folder();
    // Under its name the binary is this client.
    let gone = place.at("dead-reckoning");
    fs::copy(binary("dead-reckoning"), &gone).unwrap();
    let (out, log) = (place.at("run"), place.at("run/run.log"));
    launch("mine", &out, &["--ticks", "20", "--add", &format!("mine={}", gone.display())]);
    fs::remove_file(&gone).unwrap();
    let again = place.at("again");
    let words = ["participant \"mine\": cannot start ", "No such file"];
    says_all(replay(&log, &again, &[]), 1, &words);
    replay(&log, &again, &["--without", "mine"]).expect(0);
}

#[test]
fn a_tick_that_a_log_does_not_have_is_refused() {
    let place = folder();
    a_log(place.path());
    let log = arg(&place.at("run.log")).to_owned();
    sim_server(&["info", &log, "--tick", "39"]).expect(0);
    for tick in ["40", "18446744073709551615"] {
        let words = format!("has no tick {tick}: it has 40 ticks, numbered from 0");
        refused(&["info", &log, "--tick", tick], 2, &[&words]);
    }
    refused(&["info", &log, "--tick=-1"], 2, &["'-1' for '--tick"]);
}
