//! The protocol, event by event. By the hundred thousand schedules it is tried
//! in [`super::schedules`].

use super::*;
use rusty_contract::answer::Message;
use rusty_contract::{Answer, OnLoss};

const RUN: u64 = 77;

fn rules(ticks: u64, on_loss: OnLoss) -> Rules {
    Rules {
        run_id: RUN,
        ticks,
        on_loss,
        join_timeout_ns: 1_000,
        answer_timeout_ns: 1_000,
        leave_timeout_ns: 5_000,
        early_leave_timeout_ns: 2_000,
        slow_after_ns: 100,
    }
}

fn roster() -> Vec<Participant> {
    vec![
        Participant::new("a", Role::Estimator),
        Participant::new("b", Role::Estimator),
        Participant::new("log", Role::Logger),
    ]
}

fn say(slot: u32, tick: u64, digest: u64, message: Message) -> Answer {
    let mut answer = Answer::carrying(&message);
    answer.run_id = RUN;
    answer.participant = slot;
    answer.tick = tick;
    answer.digest_seen = digest;
    answer
}

fn gathered(ticks: u64, on_loss: OnLoss) -> Lockstep {
    let mut machine = Lockstep::new(rules(ticks, on_loss), &roster(), 0);
    for (i, name) in ["a", "b", "log"].iter().enumerate() {
        let request = JoinRequest::new(name, 100 + i as u32, 0, "test");
        assert_eq!(machine.join(&request, 0), Ok(i));
        machine.answer(&say(i as u32, 0, 0, Message::Ready), 1);
    }
    machine
}

fn quiet(_: usize) -> String {
    String::new()
}

const ABSTAIN: Message = Message::Reply(Reply::Abstain);

#[test]
fn a_run_goes_tick_by_tick_to_its_end() {
    let mut m = gathered(2, OnLoss::Abort);
    for tick in 0..2 {
        assert_eq!(m.next(10, quiet), Step::Publish(tick));
        m.published(5, 10);
        for slot in 0..3 {
            assert!(matches!(m.next(11, quiet), Step::Wait { .. }));
            m.answer(&say(slot, tick, 5, ABSTAIN), 11);
        }
        assert_eq!(m.next(12, quiet), Step::Close(tick));
    }
    assert_eq!(m.next(13, quiet), Step::End(Phase::Done));
    m.published(0, 13);
    assert!(matches!(m.next(13, quiet), Step::Wait { .. }));
    for slot in 0..3 {
        m.answer(&say(slot, 2, 0, Message::Leave), 14);
    }
    assert_eq!(m.next(15, quiet), Step::Finished);
    assert_eq!(m.ticks_done(), 2);
}

/// Only a driver ends a run, and only when all have answered the tick.
#[test]
fn a_driver_that_is_done_ends_the_run_with_its_tick() {
    for (role, after) in
        [(Role::Estimator, Step::Publish(1)), (Role::Driver, Step::End(Phase::Done))]
    {
        let mut m = gathered(9, OnLoss::Abort);
        m.slots[0].role = role;
        assert_eq!(m.next(10, quiet), Step::Publish(0));
        m.published(5, 10);
        let mut last = say(0, 0, 5, ABSTAIN);
        last.end_run();
        m.answer(&last, 11);
        assert!(matches!(m.next(11, quiet), Step::Wait { .. }));
        (1..3).for_each(|slot| m.answer(&say(slot, 0, 5, ABSTAIN), 11));
        assert_eq!(m.next(12, quiet), Step::Close(0));
        assert_eq!(m.next(13, quiet), after);
        assert_eq!(m.ticks_done(), 1);
    }
}

#[test]
fn requests_are_refused_in_words() {
    let mut m = Lockstep::new(rules(1, OnLoss::Abort), &roster(), 0);
    let ask = |m: &mut Lockstep, change: fn(&mut JoinRequest)| {
        let mut request = JoinRequest::new("a", 1, 0, "test");
        change(&mut request);
        m.join(&request, 0)
    };
    assert!(matches!(ask(&mut m, |r| r.name = "z".into()), Err(Refusal::Unknown { .. })));
    assert!(matches!(ask(&mut m, |r| r.protocol = 9), Err(Refusal::Protocol { .. })));
    assert!(matches!(ask(&mut m, |r| r.layout ^= 1), Err(Refusal::Layout { .. })));
    assert_eq!(ask(&mut m, |_| {}), Ok(0));
    assert!(matches!(ask(&mut m, |_| {}), Err(Refusal::Taken { pid: 1, .. })));
}

#[test]
fn who_never_attaches_is_named() {
    let mut m = Lockstep::new(rules(1, OnLoss::Abort), &roster(), 0);
    assert_eq!(m.next(999, quiet), Step::Wait { until_ns: 1_000 });
    let Step::Lost(loss) = m.next(1_000, quiet) else { panic!("no loss") };
    assert_eq!((loss.name.as_str(), loss.kind), ("a", LossKind::NeverAttached));
    assert_eq!(loss.tick, None);
}

#[test]
fn slow_is_a_notice_and_stalled_is_a_loss() {
    let mut m = gathered(1, OnLoss::Continue);
    m.next(0, quiet);
    m.published(5, 0);
    m.answer(&say(0, 0, 5, ABSTAIN), 1);
    m.answer(&say(2, 0, 5, ABSTAIN), 1);
    assert_eq!(m.next(50, quiet), Step::Wait { until_ns: 100 });
    assert_eq!(m.next(150, quiet), Step::Slow { slot: 1, waited_ns: 150 });
    assert_eq!(m.next(160, quiet), Step::Wait { until_ns: 1_000 });
    let Step::Lost(loss) = m.next(1_000, quiet) else { panic!("no loss") };
    assert_eq!((loss.name.as_str(), loss.kind, loss.tick), ("b", LossKind::Stalled, Some(0)));
    assert_eq!(m.next(1_000, quiet), Step::Close(0));
    let replies: Vec<Reply> = m.replies().map(|(_, r)| r).collect();
    assert_eq!(replies, [Reply::Abstain, Reply::Missing]);
}

#[test]
fn a_death_aborts_or_is_survived() {
    for (policy, next) in
        [(OnLoss::Abort, Step::End(Phase::Aborted)), (OnLoss::Continue, Step::Close(0))]
    {
        let mut m = gathered(1, policy);
        m.next(0, quiet);
        m.published(5, 0);
        m.answer(&say(0, 0, 5, ABSTAIN), 1);
        m.answer(&say(2, 0, 5, ABSTAIN), 1);
        m.died(1, "killed by signal 9");
        let Step::Lost(loss) = m.next(2, quiet) else { panic!("no loss") };
        assert_eq!(loss.to_string(), "b dead at tick 0: killed by signal 9");
        assert_eq!(m.next(2, quiet), next);
    }
}

#[test]
fn what_is_no_answer_is_refused_and_what_is_a_second_one_is_ignored() {
    let mut m = gathered(3, OnLoss::Continue);
    m.next(0, quiet);
    m.published(5, 0);
    m.answer(&say(0, 0, 5, ABSTAIN), 1);
    m.answer(&say(0, 0, 5, Message::Reply(Reply::Taken)), 1);
    assert_eq!(m.slots()[0].strays, 1);
    assert_eq!(m.slots()[0].reply, Some(Reply::Abstain));
    let mut stranger = say(0, 0, 5, ABSTAIN);
    stranger.run_id = 1;
    m.answer(&stranger, 1);
    m.answer(&say(9, 0, 5, ABSTAIN), 1);
    m.answer(&say(1, 2, 5, ABSTAIN), 1);
    let Step::Lost(loss) = m.next(2, quiet) else { panic!("no loss") };
    assert!(loss.to_string().contains("answered tick 2, asked was tick 0"), "{loss}");
    m.answer(&say(2, 0, 6, ABSTAIN), 2);
    let Step::Lost(loss) = m.next(2, quiet) else { panic!("no loss") };
    assert!(loss.to_string().contains("saw another frame"), "{loss}");
}

#[test]
fn a_nan_is_named() {
    let mut m = gathered(1, OnLoss::Abort);
    m.next(0, quiet);
    m.published(5, 0);
    let bad = rusty_geometry::SE2::new(f64::NAN, 0.0, 0.0);
    m.answer(&say(1, 0, 5, Message::Reply(bad.into())), 1);
    let Step::Lost(loss) = m.next(2, quiet) else { panic!("no loss") };
    assert!(loss.to_string().contains("estimate x_m is NaN"), "{loss}");
    assert_eq!(m.next(2, quiet), Step::End(Phase::Aborted));
}

#[test]
fn a_participant_that_opens_its_ports_after_the_end_of_run_receives_it_again() {
    let mut m = Lockstep::new(rules(1, OnLoss::Abort), &roster(), 0);
    for name in ["a", "log"] {
        m.join(&JoinRequest::new(name, 1, 0, "test"), 0).unwrap();
    }
    m.answer(&say(0, 0, 0, Message::Ready), 1);
    m.died(1, "exited with code 1");
    let Step::Lost(loss) = m.next(2, quiet) else { panic!("no loss") };
    assert_eq!(loss.name, "b");
    assert_eq!(m.next(2, quiet), Step::End(Phase::Aborted));
    m.published(0, 2);
    m.answer(&say(0, 0, 0, Message::Leave), 3);
    // The logger has joined but is not there yet: it is waited for, and told.
    assert!(matches!(m.next(3, quiet), Step::Wait { .. }));
    m.answer(&say(2, 0, 0, Message::Ready), 4);
    assert_eq!(m.next(4, quiet), Step::End(Phase::Aborted));
    m.published(0, 4);
    m.answer(&say(2, 0, 0, Message::Leave), 5);
    assert_eq!(m.next(5, quiet), Step::Finished);
}

#[test]
fn who_says_ready_again_and_again_does_not_keep_the_run_from_ending() {
    let mut m = gathered(1, OnLoss::Continue);
    m.interrupt();
    assert_eq!(m.next(10, quiet), Step::End(Phase::Interrupted));
    m.published(0, 10);
    let mut now = 10;
    while m.next(now, quiet) != Step::Finished {
        assert!(now < 10_000, "it never ends");
        now += 50;
        m.answer(&say(1, 0, 0, Message::Ready), now);
    }
}

#[test]
fn a_participant_that_reads_the_end_of_run_before_its_summary_may_leave() {
    let mut m = Lockstep::new(rules(9, OnLoss::Abort), &roster(), 0);
    for (i, name) in ["a", "b"].iter().enumerate() {
        assert_eq!(m.join(&JoinRequest::new(name, 100 + i as u32, 0, "test"), 0), Ok(i));
    }
    m.died(0, "killed");
    assert!(matches!(m.next(1, quiet), Step::Lost(_)));
    assert_eq!(m.next(1, quiet), Step::End(Phase::Aborted));
    m.published(0, 1);
    // Its ports were open in time for the end of run; both answers come at once.
    m.answer(&say(1, 0, 0, Message::Ready), 2);
    m.answer(&say(1, 0, 0, Message::Leave), 2);
    assert_eq!(m.next(2, quiet), Step::End(Phase::Aborted));
    m.published(0, 2);
    m.died(2, "ended");
    assert_eq!(m.next(3, quiet), Step::Finished);
    assert_eq!(m.slots()[1].loss(), None);
}

#[test]
fn who_is_lost_comes_back_and_is_given_everything_again() {
    let mut m = gathered(5, OnLoss::Restart);
    for tick in 0..2 {
        assert_eq!(m.next(10, quiet), Step::Publish(tick));
        m.published(40 + tick, 10);
        for slot in 0..3 {
            m.answer(&say(slot, tick, 40 + tick, ABSTAIN), 11);
        }
        assert_eq!(m.next(12, quiet), Step::Close(tick));
    }
    assert_eq!(m.next(13, quiet), Step::Publish(2));
    m.published(42, 13);
    m.answer(&say(0, 2, 42, ABSTAIN), 14);
    m.answer(&say(2, 2, 42, ABSTAIN), 14);
    m.died(1, "killed by signal 9");
    assert!(matches!(m.next(15, quiet), Step::Restart(loss) if loss.name == "b"));
    // Time stands still until it is back, and no longer than the join timeout.
    assert_eq!(m.next(16, quiet), Step::Wait { until_ns: 1_015 });
    assert_eq!(m.join(&JoinRequest::new("b", 200, 0, "test"), 7), Ok(1));
    // What the dead one had sent before is no participant's answer now.
    m.answer(&say(1, 2, 42, ABSTAIN), 17);
    assert_eq!(m.slots()[1].strays, 1);
    let again = |tick: u64, message| {
        let mut answer = say(1, tick, 40 + tick, message);
        answer.ticket = 7;
        answer
    };
    m.answer(&again(0, Message::Ready), 17);
    for tick in 0..3 {
        assert_eq!(m.next(18, quiet), Step::Feed { slot: 1, tick });
        m.fed(1, 40 + tick, 18);
        assert_eq!(m.next(18, quiet), Step::Wait { until_ns: 1_018 });
        m.answer(&again(tick, ABSTAIN), 19);
        if tick < 2 {
            let echo = Step::Echo { slot: 1, tick, reply: Reply::Abstain };
            assert_eq!(m.next(19, quiet), echo);
        }
    }
    assert_eq!(m.next(20, quiet), Step::Close(2));
    assert_eq!(m.next(20, quiet), Step::Publish(3));
    assert_eq!(m.slots()[1].restarts, 1);
}

#[test]
fn who_never_gets_anywhere_is_lost_for_good() {
    let mut m = gathered(5, OnLoss::Restart);
    m.next(10, quiet);
    m.published(5, 10);
    for round in 0..3 {
        m.died(1, "killed");
        assert!(matches!(m.next(11, quiet), Step::Restart(_)), "round {round}");
    }
    m.died(1, "killed");
    assert!(matches!(m.next(12, quiet), Step::Lost(_)));
    assert_eq!(m.next(12, quiet), Step::End(Phase::Aborted));
}

#[test]
fn one_that_cannot_start_is_not_started_again() {
    for (given_up, expected) in [(false, "restart"), (true, "lost")] {
        let mut m = Lockstep::new(rules(5, OnLoss::Restart), &roster(), 0);
        if given_up {
            m.give_up(0);
        }
        m.died(0, "its process exited with code 2");
        let what = match m.next(1, quiet) {
            Step::Restart(_) => "restart",
            Step::Lost(_) => "lost",
            other => panic!("{other:?}"),
        };
        assert_eq!(what, expected);
    }
}
