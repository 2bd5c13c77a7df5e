//! Events while a run waits: answers, requests to join, deaths.

use rusty_contract::layout::layout_hash;
use rusty_contract::{JoinReply, JoinRequest, MAX_PARTICIPANTS, PROTOCOL_VERSION, Refusal, Start};
use rusty_link::{Domain, JoinCall, LinkError, Peer, ReceivedAnswer, monotonic_ns};

use super::Run;
use crate::lockstep::ParticipantState;

/// Refusals that are reported: a client that asks without end fills no disk.
const REFUSALS_REPORTED: u32 = 50;

impl Run<'_> {
    /// Waits for an event, unless answers are there; says whether they were.
    pub(super) fn listen(&mut self, at_most_ns: u64) -> Result<bool, LinkError> {
        // Answers without end keep no check from being made.
        let is_idle = self.take_answers()? == 0;
        let (participants, lockstep) = (&self.participants, &self.lockstep);
        let peers = || participants.present(lockstep);
        if self.wire.pause(is_idle, peers, at_most_ns) || self.lockstep.is_gathering() {
            // First what came while this process did not run: who answered in
            // time is not late because the server was stopped.
            self.take_answers()?;
            self.take_requests()?;
            self.take_joins()?;
            self.look_for_deaths()?;
            if self.stop.is_raised() {
                self.lockstep.interrupt();
            }
        }
        Ok(!is_idle)
    }

    fn take_answers(&mut self) -> Result<usize, LinkError> {
        let (lockstep, mut forged) = (&mut self.lockstep, None);
        let taken = self.wire.link.take_answers(|received: ReceivedAnswer| {
            let answer = received.answer;
            match received.forged_by {
                None => lockstep.answer(&answer, monotonic_ns()),
                Some(pid) => forged = Some((answer.participant, pid)),
            }
        })?;
        if let Some((slot, pid)) = forged
            && !std::mem::replace(&mut self.participants.forged, true)
        {
            self.progress.say(&format!(
                "process {pid} (as it says) answers for slot {slot} of the roster without that \
                 participant's key; such answers are dropped"
            ));
        }
        Ok(taken)
    }

    pub(super) fn take_joins(&mut self) -> Result<(), LinkError> {
        // As many as can be seated; who asks without end is served in turns.
        for _ in 0..MAX_PARTICIPANTS {
            let Some(call) = self.wire.link.next_join()? else { break };
            self.admit(call)?;
            self.wire.link.wake_all();
        }
        Ok(())
    }

    pub(super) fn admit(&mut self, call: JoinCall) -> Result<(), LinkError> {
        // Without randomness one ticket is as good as another.
        let ticket = getrandom::u32().unwrap_or(self.wire.looks);
        let request = call.request().and_then(|r| self.check_signature(&r).map(|()| r));
        if let Ok(request) = &request
            && self.is_for_next_run(request)
        {
            let pid = request.pid;
            self.keep_for_next_run(pid, call);
            return Ok(());
        }
        let seated = request.and_then(|r| Ok((self.lockstep.join(&r, ticket)?, r)));
        let reply = match seated {
            Ok((slot, request)) => {
                self.participants.peers[slot] = Some(Peer::new(request.pid));
                let catch_up = self.catch_up(slot)?;
                let start = self.identity.start(self.source.header(), slot);
                JoinReply::Start(Box::new(Start { ticket, catch_up, ..start }))
            }
            Err(refusal) => {
                self.participants.refused += 1;
                if self.participants.refused <= REFUSALS_REPORTED {
                    self.progress.say(&format!("refused a client: {refusal}"));
                }
                JoinReply::Refused(refusal)
            }
        };
        if let Err(e) = call.reply(&reply) {
            // The caller has ended; if it had a slot, its death shows next.
            self.progress.say(&format!("a client left while it was being answered ({e})"));
        }
        Ok(())
    }

    /// Refuses a request that is not signed with the key of the participant that
    /// it names, or that a process sent which has ended since: an old request.
    /// What else is wrong with it, the protocol's machine says.
    fn check_signature(&self, request: &JoinRequest) -> Result<(), Refusal> {
        let speaks_the_same =
            request.protocol == PROTOCOL_VERSION && request.layout == layout_hash();
        let slot = self.lockstep.slots().iter().position(|s| s.name == request.name);
        let (true, Some(slot)) = (speaks_the_same, slot) else { return Ok(()) };
        let (name, pid) = (request.name.clone(), request.pid);
        if !self.wire.link.keys().has_signed_request(request, slot) {
            let key_file = Domain::credentials_file(self.domain.run(), &name).display().to_string();
            return Err(Refusal::Unsigned { name, pid, key_file });
        }
        if Peer::new(pid).is_dead() {
            return Err(Refusal::Unreadable(format!("process {pid}, which it names, has ended")));
        }
        Ok(())
    }

    fn look_for_deaths(&mut self) -> Result<(), LinkError> {
        for slot in 0..self.participants.peers.len() {
            if matches!(
                self.lockstep.slots()[slot].state,
                ParticipantState::Left | ParticipantState::Lost(_)
            ) {
                continue;
            }
            // Looked at first: of one that is dead, the child's status is there.
            let joined_dead = self.participants.peers[slot].as_ref().is_some_and(Peer::is_dead);
            // A slot that was taken again by hand is no longer the child's.
            let pid = self.lockstep.slots()[slot].pid;
            let child = self.participants.children.ended(slot, pid);
            if child.is_none() && !joined_dead {
                continue;
            }
            // What it said before it ended still counts.
            self.take_answers()?;
            if pid == 0 && self.participants.children.is_misused(slot) {
                self.lockstep.give_up(slot);
            }
            let how = child.unwrap_or_else(|| "its process has ended".to_owned());
            self.lockstep.died(slot, &how);
        }
        Ok(())
    }
}
