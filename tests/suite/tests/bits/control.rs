//! `control`: the time of a run is moved from outside, and no bit of it moves.

use rusty_contract::answer::Message;
use rusty_contract::control::{ControlReply, ControlRequest};
use rusty_contract::{Answer, Phase};
use rusty_tests::*;

const RUN: [&str; 4] = ["--ticks", "300", "--seed", "5"];

#[track_caller]
fn control(live: &Live, request: &[&str]) -> Value {
    let args = [&["control", "--json", live.run.as_str()], request].concat();
    sim_server(&args).expect(0).json()
}

fn under_control(tag: &str, args: &[&[&str]]) -> Live {
    let live = Live::start("launch", tag, args);
    until("the run can be controlled", || live.control(&["status"]));
    live
}

#[test]
fn pauses_and_steps_change_no_bit() {
    let calm = launch("calm", folder().path(), &RUN);
    let live = under_control("steps", &[&RUN, &["--paused"]]);
    assert_eq!(control(&live, &["status"])["ticks_done"], 0);
    let status = control(&live, &["step", "3"]);
    assert_eq!((&status["ticks_done"], &status["paused"]), (&Value::from(3), &Value::from(true)));
    assert_eq!(control(&live, &["step"])["ticks_done"], 4);
    // Paused is paused: it stands where it stood.
    assert_eq!(control(&live, &["status"])["ticks_done"], 4);
    let status = control(&live, &["step", "100"]);
    assert_eq!(status["ticks_done"], 104);
    assert_eq!(status["ticks"], 300);
    control(&live, &["resume"]);
    let after = live.ends_with(0);
    assert_eq!(after.report["digest"], calm["digest"]);
    after.verifies(0);
}

/// Steps that last longer than their reply may wait are no fault of the server.
#[test]
fn steps_that_last_long_go_on_behind_the_time_limit() {
    let live = under_control("long", &[&RUN, &["--paused", "--pace", "0.5"]]);
    let long = ["control", live.run.as_str(), "--timeout", "0.3", "step", "290"];
    sim_server(&long).expect(1).says("the steps go on").says("of 300 ticks");
    control(&live, &["pace", "max"]);
    until("the steps are complete", || control(&live, &["status"])["ticks_done"] == 290);
    control(&live, &["resume"]);
    live.ends_with(0);
}

#[test]
fn a_run_at_its_own_pace_can_be_paused_and_goes_on() {
    let calm = launch("calm", folder().path(), &RUN);
    let live = under_control("pause", &[&RUN, &["--pace", "4"]]);
    let status = control(&live, &["pause"]);
    assert_eq!(status["paused"], true);
    let then = control(&live, &["status"])["ticks_done"].as_u64().unwrap();
    std::thread::sleep(Duration::from_millis(100));
    let now = control(&live, &["status"])["ticks_done"].as_u64().unwrap();
    assert_eq!(now, then);
    assert_eq!(control(&live, &["resume"])["paused"], false);
    let after = live.ends_with(0);
    assert_eq!(after.report["digest"], calm["digest"]);
}

#[test]
fn another_pace_changes_no_bit() {
    let calm = launch("calm", folder().path(), &RUN);
    let live = under_control("pace", &[&RUN, &["--pace", "0.01"]]);
    assert_eq!(control(&live, &["status"])["pace"], 0.01);
    assert_eq!(control(&live, &["pace", "8"])["pace"], 8.0);
    assert_eq!(control(&live, &["pace", "max"])["pace"], Value::Null);
    let after = live.ends_with(0);
    assert_eq!(after.report["digest"], calm["digest"]);
    sim_server(&["control", "x", "pace", "0"]).expect(2);
}

#[test]
fn a_run_can_be_stopped_even_while_it_stands_still() {
    let live = under_control("stop", &[&RUN, &["--paused"]]);
    control(&live, &["step", "7"]);
    control(&live, &["stop"]);
    let after = live.ends_with(3);
    after.ended("interrupted", 7);
}

#[test]
fn a_step_beyond_the_end_returns_at_the_end() {
    let live = under_control("beyond", &[&RUN, &["--paused"]]);
    assert_eq!(control(&live, &["step", "1000"])["ticks_done"], 300);
    live.ends_with(0);
}

#[test]
fn a_participant_has_no_say_in_the_time_of_its_run() {
    let roster = [&ALONE[..], &["--pace", "0.001", "--add", "me"]].concat();
    let live = Live::start("serve", "no-say", &[&roster]);
    let mut link = hand::join(&live.run, "me").unwrap();
    let frame = hand::next_frame(&mut link).unwrap();
    for request in [ControlRequest::Stop, ControlRequest::Pause, ControlRequest::Status] {
        let reply = rusty_link::control(&live.run, request, hand::PATIENCE).unwrap();
        assert!(matches!(reply, ControlReply::Refused(_)), "{reply:?}");
    }
    link.answer(&frame, &Message::Reply(Reply::Abstain), false).unwrap();
    assert_eq!(control(&live, &["stop"])["paused"], false);
    let last = hand::next_frame(&mut link).unwrap();
    assert_eq!(last.phase(), Phase::Interrupted);
    link.send_raw(Answer::carrying(&Message::Leave)).unwrap();
    drop((frame, last, link));
    live.ends_with(3);
}

#[test]
fn a_run_that_is_not_there_is_named() {
    let ended = sim_server(&["control", "nobody-runs-this", "pause"]);
    assert_ne!(ended.code, Some(0));
    ended.says("nobody-runs-this");
    sim_server(&["control", "x", "step", "0"]).expect(2).says("0 is not in 1..");
}
