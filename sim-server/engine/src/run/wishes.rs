//! What is said to a run while it goes on: pause, step, resume, stop.

use std::sync::atomic::Ordering;

use rustix::process::{Pid, getpgid};
use rusty_contract::control::{ControlError, ControlReply, ControlRequest, ControlStatus};
use rusty_link::{ControlCall, LinkError};

use super::Run;

/// The most wishes that are heard in one turn.
const WISHES_AT_ONCE: usize = 16;

/// A step whose ticks are not complete yet.
pub(super) struct PendingStep {
    call: ControlCall,
    /// The reply goes out when so many ticks are complete.
    when: u64,
}

impl Run<'_> {
    /// Hears what is said.
    pub(super) fn take_wishes(&mut self) -> Result<(), LinkError> {
        // Who asks without end is heard in turns.
        for _ in 0..WISHES_AT_ONCE {
            let Some(call) = self.link.next_control()? else { break };
            let done = self.lockstep.ticks_done();
            let request = call.request(self.link.keys()).and_then(|(request, number)| {
                let is_new = self.control_numbers.insert(number);
                if is_new { Ok(request) } else { Err(ControlError::Repeated) }
            });
            match request {
                Err(error) => {
                    self.reply(call, &ControlReply::Refused(error.to_string()));
                    continue;
                }
                Ok(_) if self.is_of_a_participant(call.pid()) => {
                    let problem = "a participant has no say in the time of its run".to_owned();
                    self.reply(call, &ControlReply::Refused(problem));
                    continue;
                }
                Ok(_) if self.ended => {
                    let problem = "it has ended".to_owned();
                    self.reply(call, &ControlReply::Refused(problem));
                    continue;
                }
                Ok(ControlRequest::Step(ticks)) => {
                    // The tick that is being worked on is none of them.
                    let when = self.begun.saturating_add(self.clock.step(ticks));
                    self.steps.push(PendingStep { call, when });
                    continue;
                }
                Ok(ControlRequest::Status) => {}
                Ok(ControlRequest::Pause) => {
                    self.clock.pause();
                    // Steps that were to come do not.
                    self.steps.iter_mut().for_each(|s| s.when = s.when.min(self.begun));
                    self.reply_to_steps(done);
                }
                Ok(ControlRequest::Resume) => self.clock.resume(),
                Ok(ControlRequest::Stop) => self.stop.flag().store(true, Ordering::Relaxed),
            }
            let status = self.status(done);
            self.reply(call, &status);
        }
        Ok(())
    }

    /// Whether this process has a seat, or belongs to one that was started here.
    fn is_of_a_participant(&self, pid: u32) -> bool {
        let group = i32::try_from(pid).ok().and_then(Pid::from_raw).and_then(|pid| {
            let group = getpgid(Some(pid)).ok()?;
            u32::try_from(group.as_raw_pid()).ok()
        });
        pid == 0
            || self.lockstep.seats().iter().any(|s| s.pid == pid)
            || self.children.groups().any(|leader| Some(leader) == group)
    }

    fn status(&self, ticks_done: u64) -> ControlReply {
        ControlReply::Status(ControlStatus {
            run: self.setup.run.to_string(),
            paused: self.clock.is_paused() && !self.ended,
            ticks_done,
            ticks: self.source.ticks(),
        })
    }

    /// Replies to steps whose ticks are complete, or never will be.
    pub(super) fn reply_to_steps(&mut self, ticks_done: u64) {
        if self.steps.is_empty() {
            return;
        }
        let ended = self.ended || ticks_done == self.source.ticks();
        for step in std::mem::take(&mut self.steps) {
            if ended || step.when <= ticks_done {
                let status = self.status(ticks_done);
                self.reply(step.call, &status);
            } else {
                self.steps.push(step);
            }
        }
    }

    fn reply(&self, call: ControlCall, reply: &ControlReply) {
        if let Err(e) = call.reply(reply) {
            self.progress.say(&format!("whoever controls the run left before the reply ({e})"));
        }
        // They may be asleep.
        self.link.wake_all();
    }
}
