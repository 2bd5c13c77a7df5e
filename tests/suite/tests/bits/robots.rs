//! Several robots in one world: a run for each, in step, and every bit of each again.

use rusty_contract::RunName;
use rusty_tests::*;

/// Robot `a` patrols, robot `b` is driven by a participant.
const DRIVEN: &str = r#"
name = "duo"
ticks = 400
[[robot]]
name = "a"
[[robot]]
name = "b"
start = { x_m = 9.0, y_m = 2.0, theta_rad = 1.0 }
[robot.script]
kind = "driver"
[[participant]]
name = "wander"
robot = "b"
role = "driver"
command = ["wander"]
[[participant]]
name = "dead-reckoning"
command = ["dead-reckoning"]
[[participant]]
name = "logger"
role = "logger"
command = ["logger"]
"#;

/// The runs of a scenario's robots, which leave nothing behind: exit code and reports.
#[track_caller]
fn together(place: &Folder, out: &str, scenario: &str, args: &[&str]) -> (Ended, Vec<PathBuf>) {
    let run = fresh_run("r");
    let out = place.at(out);
    let fixed = ["launch", scenario, "--json", "--run", run.as_str(), "--out", arg(&out)];
    let ended = sim_server(&[&fixed, args].concat());
    for robot in ["a", "b"] {
        nothing_left(&RunName::new(&format!("{run}-{robot}")).unwrap());
    }
    (ended, ["a", "b"].map(|robot| out.join(robot).join("run.log")).to_vec())
}

fn digests(ended: &Ended) -> Vec<String> {
    let reports = ended.json();
    let reports = reports.as_array().unwrap();
    reports.iter().map(|report| text(report, "digest").to_owned()).collect()
}

#[test]
fn two_robots_come_again_bit_for_bit_and_each_log_is_enough() {
    let place = folder();
    let args = ["--ticks", "300"];
    let (first, logs) = together(&place, "1", "two-robots", &args);
    let first = first.expect(0);
    let again = together(&place, "2", "two-robots", &args).0.expect(0);
    assert_eq!(digests(&first), digests(&again));
    assert_ne!(digests(&first)[0], digests(&first)[1]);
    let other = together(&place, "3", "two-robots", &["--ticks", "300", "--seed", "7"]).0.expect(0);
    assert!(digests(&first).iter().zip(digests(&other)).all(|(a, b)| *a != b));
    for (log, robot) in logs.iter().zip(["a", "b"]) {
        sim_server(&["verify", arg(log)]).expect(0).prints("bit-exact: 300 ticks");
        let report = replay(log, &place.at(format!("again-{robot}")), &[]).expect(0).json();
        assert_eq!(report["comparison"]["equal"], 300);
        let at = ["fork", arg(log), "--at", "100", "--set", "lidar.dropout=0.5"];
        let fork = run_to("fork", &place.at(format!("fork-{robot}")), &at).expect(0).json();
        assert_eq!(fork["fork"]["frames_equal"], 100);
        assert_eq!(fork["fork"]["truths_differ_at"], Value::Null);
        sim_server(&["verify", text(&fork, "log")]).expect(0);
    }
}

#[test]
fn the_log_of_a_driven_robot_makes_the_others_again() {
    let place = folder();
    let duo = place.write("duo.toml", DRIVEN);
    let (ended, logs) = together(&place, "1", &duo, &[]);
    let ended = ended.expect(0);
    let again = together(&place, "2", &duo, &["--wait", "block"]).0.expect(0);
    assert_eq!(digests(&ended), digests(&again));
    let [a, b] = [arg(&logs[0]), arg(&logs[1])];
    sim_server(&["verify", b]).expect(0);
    sim_server(&["verify", a]).expect(2).says("robot[1] = b: has a driver");
    sim_server(&["verify", a, "--with", a]).expect(2).says("--with");
    sim_server(&["verify", a, "--with", b]).expect(0).prints("bit-exact: 400 ticks");
    // Half of it, and a damaged half.
    let bytes = fs::read(b).unwrap();
    let mut half = bytes[..bytes.len() / 2].to_vec();
    let cut = place.write("cut.log", &half);
    let said = sim_server(&["verify", a, "--with", &cut]).expect(3);
    said.says("the log of robot b ends after").prints("bit-exact");
    let middle = half.len() / 2;
    half[middle] ^= 1;
    let damaged = place.write("damaged.log", &half);
    sim_server(&["verify", a, "--with", &damaged]).expect(1).says("checksum");
    // The other robot of another run.
    let (other, others) = together(&place, "3", &duo, &["--seed", "7"]);
    other.expect(0);
    sim_server(&["verify", a, "--with", arg(&others[1])]).expect(2).says("--with");
    let at = ["fork", a, "--at", "50", "--set", "robot.slip_std=0.1", "--with", b];
    let fork = run_to("fork", &place.at("fork"), &at).expect(0).json();
    assert_eq!(fork["fork"]["frames_equal"], 50);
    sim_server(&["verify", text(&fork, "log"), "--with", b]).expect(0);
    // A log that ends before the branch begins, and one in the folder that would be replaced.
    let late = ["fork", a, "--at", "350", "--with"];
    run_to("fork", &place.at("late"), &[&late[..], &[&cut]].concat()).expect(2).says("robot b");
    let folder = logs[1].parent().unwrap();
    let over = [&late[..], &[b, "--force"]].concat();
    run_to("fork", folder, &over).expect(2).says("another --run or --out");
    assert!(fs::read(b).unwrap() == bytes);
}

#[test]
fn a_participant_that_comes_back_changes_no_bit_of_either_robot() {
    let place = folder();
    let calm = place.write("calm.toml", DRIVEN);
    let calm = together(&place, "calm", &calm, &[]).0.expect(0);
    let patient = format!("on_loss = \"restart\"\n{DRIVEN}");
    let patient = place.write("patient.toml", patient);
    let run = fresh_run("r");
    let fixed = ["launch", &patient, "--json", "--paused", "--run", run.as_str()];
    let out = place.at("killed");
    let live = Process::start("sim-server", &[&fixed[..], &["--out", arg(&out)]].concat());
    let [first, second] = ["a", "b"].map(|robot| RunName::new(&format!("{run}-{robot}")).unwrap());
    let control =
        |run: &RunName, words: &[&str]| sim_server(&[&["control", run.as_str()], words].concat());
    until("the run can be controlled", || control(&first, &["status"]).code == Some(0));
    control(&first, &["step", "120"]).expect(0).prints("120 of 400");
    // The pace is the first robot's; the other says so, and where it stands.
    control(&second, &["pause"]).expect(1).says(first.as_str());
    control(&second, &["status"]).expect(0).prints("120 of 400");
    for run in [&first, &second] {
        let victims = participants(run).into_iter().filter(|(_, name)| name == "dead-reckoning");
        victims.for_each(|(pid, _)| send_signal(pid, Signal::KILL));
    }
    control(&first, &["resume"]).expect(0);
    let killed = live.wait().expect(0);
    assert_eq!(digests(&killed), digests(&calm));
    let restarts = killed.json();
    let restarts =
        restarts.as_array().unwrap().iter().map(|r| r["restarts"].as_array().unwrap().len());
    assert_eq!(restarts.collect::<Vec<_>>(), [1, 1]);
}

#[test]
fn a_world_ends_with_the_first_of_its_robots() {
    let place = folder();
    let broken =
        format!("{DRIVEN}\n[[participant]]\nname = \"f\"\nrobot = \"b\"\ncommand = [\"false\"]\n");
    let broken = place.write("broken.toml", broken);
    let (ended, _) = together(&place, "1", &broken, &[]);
    assert_eq!(ended.code, Some(1), "{ended:#?}");
    let reports = ended.json();
    let remarks = reports[0]["remarks"].to_string();
    assert!(remarks.contains("robot b ended after 0 ticks"), "{remarks}");
    assert_eq!(reports[1]["losses"][0]["name"], "f");
}

#[test]
fn one_filter_takes_part_for_two_robots() {
    let place = folder();
    let joint = binary("joint-filter");
    let joint = format!(
        "name = \"duo\"\nticks = 200\n[[robot]]\nname = \"a\"\n[[robot]]\nname = \"b\"\n\
         start = {{ x_m = 9.0, y_m = 2.0, theta_rad = 1.0 }}\n\
         [[participant]]\nname = \"joint\"\nrobot = \"a\"\ncommand = [{:?}]\n\
         [[participant]]\nname = \"joint\"\nrobot = \"b\"\n\
         [[participant]]\nname = \"dead-reckoning\"\ncommand = [\"dead-reckoning\"]\n\
         [[participant]]\nname = \"logger\"\nrole = \"logger\"\ncommand = [\"logger\"]\n",
        arg(&joint)
    );
    let (ended, logs) = together(&place, "1", &place.write("joint.toml", joint), &[]);
    ended.expect(0);
    for log in &logs {
        for tick in records(log) {
            // Both are dead reckoning.
            assert_eq!(tick.replies.len(), 2);
            assert!(tick.replies[0].same_bits(&tick.replies[1]), "tick {}", tick.tick);
        }
    }
}

#[test]
fn a_sweep_takes_the_first_robot_among_others_that_move_by_themselves() {
    let place = folder();
    let csv = place.at("s.csv");
    let sweep = |which: &str, more: &[&str]| {
        let args = ["sweep", which, "--seeds", "0..2", "--ticks", "60", "--out", arg(&csv)];
        sim_server(&[&args[..], more].concat())
    };
    sweep("two-robots", &[]).expect(0);
    sweep("two-robots", &["--clients", "--force"]).expect(2).says("--clients");
    let duo = place.write("duo.toml", DRIVEN);
    for more in [&["--force"][..], &["--force", "--clients"]] {
        sweep(&duo, more).expect(2).says("robot[1].script.kind = driver");
    }
}

#[test]
fn each_robot_has_room_for_a_whole_roster() {
    let place = folder();
    let robots = ["a", "b"].map(|robot| format!("[[robot]]\nname = \"{robot}\"\n"));
    let start = "start = { x_m = 9.0, y_m = 2.0, theta_rad = 1.0 }\n";
    let filter = |robot: &str, k: u32| {
        format!(
            "[[participant]]\nname = \"f{k}\"\nrobot = \"{robot}\"\ncommand = [\"dead-reckoning\"]\n"
        )
    };
    let some = |count: u32| {
        let filters =
            ["a", "b"].map(|robot| (0..count).map(|k| filter(robot, k)).collect::<String>());
        format!("ticks = 20\n{}{start}{}", robots.concat(), filters.concat())
    };
    let nine = place.write("nine.toml", some(9));
    together(&place, "1", &nine, &[]).0.expect(0);
    let many = place.write("many.toml", some(17));
    together(&place, "2", &many, &[]).0.expect(2).says("participant (number of) = 17");
}
