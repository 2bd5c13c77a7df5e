//! Whether a viewer is there, and what becomes of it, changes no bit of a run.

use rusty_tests::viewed::Viewed;
use rusty_tests::*;

use crate::Opened as _;

const RUN: [&str; 4] = ["--ticks", "300", "--seed", "5"];

#[test]
fn a_viewer_with_its_page_changes_no_bit_of_a_run_and_plays_its_log() {
    let (calm, out, run) = (folder(), folder(), fresh_run("watched"));
    let report = launch("calm", calm.path(), &RUN);
    let viewed = Viewed::launch(&run, out.path(), &[&RUN, &["--pace", "20"]]);
    let mut page = viewed.page();
    let (scene, _) = page.until(|m| m["mode"] == "run");
    assert_eq!((&scene["seed"], &scene["truth"]), (&json!("5"), &json!(true)));
    assert_eq!(scene["estimators"][0]["name"], "dead-reckoning");
    let (_, bytes) = page.until(|m| m["state"] == "ended");
    assert!(bytes > 10_000, "{bytes}");
    let (log, _) = page.until(|m| m["mode"] == "log");
    assert_eq!(log["digest"], report["digest"]);
    let (_, bytes) = page.until(|m| m["state"] == "paused");
    assert!(bytes > 10_000, "{bytes}");
    // The page is closed: the viewer ends, and the launch with it.
    drop(page);
    let (output, errors) = viewed.ends_with(0);
    let watched: Value = serde_json::from_str(&output).unwrap();
    assert_eq!(watched["digest"], report["digest"], "{errors}");
    assert_eq!(fs::read(out.at("run.log")).unwrap(), fs::read(calm.at("run.log")).unwrap());
    assert_eq!(participants(&run), []);
    nothing_left(&run);
}

#[test]
fn viewers_that_are_killed_or_stand_still_cost_the_run_nothing() {
    let calm = launch("calm", folder().path(), &RUN);
    let live = Live::start("launch", "unwatched", &[&RUN, &["--paused"]]);
    until("the run can be controlled", || live.control(&["status"]));
    let view = || Viewed::view(&["--run", live.run.as_str()]);
    let (mut killed, stopped, stalled) = (view(), view(), view());
    // A page that takes nothing, of a viewer that lives.
    let mut page = stalled.page();
    page.until(|m| m["message"] == "scene");
    killed.child.kill().unwrap();
    send_signal(stopped.child.id(), Signal::STOP);
    assert!(live.control(&["step", "50"]));
    // The next viewer frees the place of the one that was killed, in the middle of the run.
    let next = view();
    next.page().until(|m| m["message"] == "scene");
    assert!(live.control(&["resume"]));
    let Live { run, server, .. } = live;
    let ended = server.wait().expect(0);
    assert_eq!(ended.json()["digest"], calm["digest"]);
    drop((killed, stopped, stalled, next));
    nothing_left(&run);
}

#[test]
fn without_the_key_a_page_shows_neither_truth_nor_answers_and_says_so() {
    let live = Live::start("launch", "hidden", &[&RUN, &["--paused"]]);
    until("the run can be controlled", || live.control(&["status"]));
    let viewed = Viewed::view(&["--run", live.run.as_str()]);
    let mut page = viewed.page();
    let (scene, _) = page.until(|m| m["message"] == "scene");
    assert_eq!((&scene["truth"], &scene["seed"]), (&json!(false), &Value::Null));
    assert_eq!((&scene["walls"], &scene["estimators"]), (&json!([]), &json!([])));
    assert!(text(&scene, "remark").contains("--watch"), "{scene}");
    page.until(|m| m["state"] == "paused");
    // A page controls the time.
    page.ask(&json!({ "do": "pace", "factor": 40.0 }));
    page.until(|m| m["pace"] == 40.0);
    page.ask(&json!({ "do": "step", "ticks": 3 }));
    page.until(|m| m["state"] == "paused");
    // Others control it, too, and the page follows.
    assert!(live.control(&["pace", "0.001"]) && live.control(&["resume"]));
    page.until(|m| m["state"] == "running" && m["pace"] == 0.001);
    assert!(live.control(&["stop"]));
    page.until(|m| m["state"] == "ended");
    drop((page, viewed));
    live.ends_with(3);
}

#[test]
fn a_server_leaves_its_viewer_the_key() {
    let live = Live::start("serve", "by-hand", &[&RUN, &["--paused"]]);
    until("the run can be controlled", || live.control(&["status"]));
    let viewed = Viewed::view(&["--run", live.run.as_str()]);
    let mut page = viewed.page();
    let (scene, _) = page.until(|m| m["message"] == "scene");
    assert_eq!((&scene["truth"], &scene["seed"]), (&json!(true), &json!("5")));
    assert!(live.control(&["stop"]));
    drop((page, viewed));
    live.ends_with(3);
}

#[test]
fn what_cannot_be_shown_is_refused_before_there_is_a_page() {
    let out = folder();
    execute("view", &["--run", "nobody-runs-this"]).expect(1).says("nobody-runs-this");
    execute("view", &[&out.write("x.log", "no log")]).expect(1).says("x.log");
    execute("view", &[]).expect(2);
}
