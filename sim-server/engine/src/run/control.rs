//! Control requests to a running server: pause, step, resume, stop.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use rustix::process::{Pid, getpgid};
use rusty_contract::RunName;
use rusty_contract::control::{ControlError, ControlReply, ControlRequest, ControlStatus};
use rusty_link::{ControlCall, LinkError};

use super::{Pace, Run};

/// The most requests that are received in one turn.
const REQUESTS_AT_ONCE: usize = 16;
/// Time for a caller to take its reply before the server ends.
const REPLY_TIME: Duration = Duration::from_millis(500);

/// The control requests of a run.
#[derive(Default)]
pub(super) struct Control {
    /// Numbers of the requests so far: each is carried out once.
    numbers: BTreeSet<u64>,
    /// Steps whose ticks are not complete yet.
    steps: Vec<PendingStep>,
    /// Requests whose replies may not be taken yet.
    replied: Vec<ControlCall>,
}

impl Control {
    /// Waits a moment until the replies are taken: with the port of the server goes what
    /// is in it.
    pub(super) fn finish(mut self) {
        let begun = Instant::now();
        while !self.replied.is_empty() && begun.elapsed() < REPLY_TIME {
            std::thread::sleep(Duration::from_millis(1));
            self.replied.retain(ControlCall::is_awaited);
        }
    }
}

struct PendingStep {
    call: ControlCall,
    /// The number of complete ticks at which the reply is sent.
    when: u64,
}

impl Run<'_> {
    /// Receives requests and carries them out.
    pub(super) fn take_requests(&mut self) -> Result<(), LinkError> {
        // A process that asks without end is served in turns.
        for _ in 0..REQUESTS_AT_ONCE {
            let Some(call) = self.wire.link.next_control()? else { break };
            let done = self.lockstep.ticks_done();
            let request = call.request(self.wire.link.keys()).and_then(|(request, number)| {
                let is_new = self.control.numbers.insert(number);
                if is_new { Ok(request) } else { Err(ControlError::Repeated) }
            });
            match request {
                Err(error) => {
                    self.refuse(call, error.to_string());
                    continue;
                }
                Ok(_) if self.is_of_a_participant(call.pid()) => {
                    self.refuse(call, "a participant has no say in the time of its run".to_owned());
                    continue;
                }
                Ok(_) if self.lockstep.has_ended() => {
                    self.refuse(call, "it has ended".to_owned());
                    continue;
                }
                Ok(
                    ControlRequest::Step(_)
                    | ControlRequest::Pause
                    | ControlRequest::Resume
                    | ControlRequest::Pace(_),
                ) if self.leader.is_some() => {
                    let leader = self.leader.iter().map(RunName::as_str).collect::<String>();
                    let problem = "follows the first robot of its world: control its run";
                    self.refuse(call, format!("{problem}, {leader}"));
                    continue;
                }
                Ok(ControlRequest::Step(ticks)) => {
                    let when = self.pacer.step(ticks);
                    self.control.steps.push(PendingStep { call, when });
                    continue;
                }
                Ok(ControlRequest::Describe) => {
                    let start = self.identity.observer_start(self.source.header());
                    self.reply(call, &ControlReply::Start(Box::new(start)));
                    continue;
                }
                Ok(ControlRequest::Pace(Some(factor))) if !(factor.is_finite() && factor > 0.0) => {
                    self.refuse(call, format!("a pace of {factor}: give a number above 0"));
                    continue;
                }
                Ok(ControlRequest::Pace(factor)) => {
                    self.pacer.set_pace(factor.map_or(Pace::Max, Pace::Factor));
                }
                Ok(ControlRequest::Status) => {}
                Ok(ControlRequest::Pause) => {
                    self.pacer.pause();
                    // Steps that were to come do not.
                    let begun = self.pacer.begun;
                    self.control.steps.iter_mut().for_each(|s| s.when = s.when.min(begun));
                    self.reply_to_steps(done);
                }
                Ok(ControlRequest::Resume) => self.pacer.resume(),
                Ok(ControlRequest::Stop) => self.stop.raise(),
            }
            let status = self.status(done);
            self.reply(call, &status);
        }
        Ok(())
    }

    /// Whether this process has a slot, or belongs to one that was started here.
    fn is_of_a_participant(&self, pid: u32) -> bool {
        let group = i32::try_from(pid).ok().and_then(Pid::from_raw).and_then(|pid| {
            let group = getpgid(Some(pid)).ok()?;
            u32::try_from(group.as_raw_pid()).ok()
        });
        pid == 0
            || self.lockstep.slots().iter().any(|s| s.pid == pid)
            // Of all runs of this process: robots of one world share their time.
            || group.is_some_and(|leader| self.stop.groups().has(leader))
    }

    fn status(&self, ticks_done: u64) -> ControlReply {
        ControlReply::Status(ControlStatus {
            run: self.domain.run().to_string(),
            paused: self.pacer.is_paused() && !self.lockstep.has_ended(),
            ticks_done,
            ticks: self.source.tick_count(),
            pace: self.pacer.factor(),
        })
    }

    /// Replies to steps whose ticks are complete, or never will be.
    pub(super) fn reply_to_steps(&mut self, ticks_done: u64) {
        if self.control.steps.is_empty() {
            return;
        }
        let ended = self.lockstep.has_ended() || ticks_done == self.source.tick_count();
        for step in std::mem::take(&mut self.control.steps) {
            if ended || step.when <= ticks_done {
                let status = self.status(ticks_done);
                self.reply(step.call, &status);
            } else {
                self.control.steps.push(step);
            }
        }
    }

    fn refuse(&mut self, call: ControlCall, problem: String) {
        self.reply(call, &ControlReply::Refused(problem));
    }

    fn reply(&mut self, call: ControlCall, reply: &ControlReply) {
        if let Err(e) = call.reply(reply) {
            self.progress.say(&format!("whoever controls the run left before the reply ({e})"));
        }
        // They may be asleep.
        self.wire.link.wake_all();
        self.control.replied.retain(ControlCall::is_awaited);
        self.control.replied.push(call);
    }
}
