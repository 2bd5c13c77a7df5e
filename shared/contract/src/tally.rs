//! `Tally`: the answers of one tick, for those who score and log.
//!
//! The server publishes it after the last answer of a tick is in, to scorers
//! and loggers only. Estimators never see each other's answers. Entries are
//! those of the *answering* participants (estimators and drivers) in roster
//! order; acknowledgements of scorers and loggers are no data.
//!
//! | offset | size | field          | type            | meaning                              |
//! |-------:|-----:|----------------|-----------------|--------------------------------------|
//! |      0 |    8 | `run_id`       | u64             | the run                              |
//! |      8 |    8 | `tick`         | u64             | the tick that is complete            |
//! |     16 |    4 | `count`        | u32             | entries in use                       |
//! |     20 |    4 | `stream`       | u32             | 0 in the run, N in the Nth catch-up  |
//! |     24 |   16 | `run_digest`   | `[u8; 16]`        | the run digest up to and with it     |
//! |     40 |   16 | `world_digest` | `[u8; 16]`        | the same, over frames alone          |
//! |     56 | 3328 | `entries`      | `[TallyEntry; 16]`| one per answering participant        |
//!
//! It travels through memory that every participant can map, so all from the
//! digests to the last entry in use is enciphered with the key of the run
//! (ChaCha20; nonce: tick and stream). The digests in it would otherwise let an
//! estimator try out where the robot started.

use bytemuck::{Pod, Zeroable};

use crate::answer::{Answer, Message};
use crate::field_table::{Field, field_table};
use crate::reply::Reply;
use crate::truth::{Purpose, TruthKey};

/// The most participants a run can have.
pub const MAX_PARTICIPANTS: usize = 16;

/// The answers of one tick. See the module for the layout.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Tally {
    /// The run.
    pub run_id: u64,
    /// The tick that is complete.
    pub tick: u64,
    count: u32,
    stream: u32,
    /// The run digest up to and with this tick.
    pub run_digest: [u8; 16],
    /// The digest of the frames alone, up to and with this tick.
    pub world_digest: [u8; 16],
    entries: [TallyEntry; MAX_PARTICIPANTS],
}

field_table! {
    /// The layout of [`Tally`], field by field.
    pub const TALLY_FIELDS for Tally, size 3384 {
        run_id: "u64" at 0, 8;
        tick: "u64" at 8, 8;
        count: "u32" at 16, 4;
        stream: "u32" at 20, 4;
        run_digest: "[u8; 16]" at 24, 16;
        world_digest: "[u8; 16]" at 40, 16;
        entries: "[TallyEntry; 16]" at 56, 3328;
    }
}

/// One participant's answer, as it travelled, and what it took.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct TallyEntry {
    /// The answer; all zeros but the participant where none came.
    pub answer: Answer,
    /// From publication to the arrival of the answer, ns, as the server saw it.
    pub latency_ns: u64,
    /// 1 where the participant had been lost, otherwise 0.
    missing: u64,
}

field_table! {
    /// The layout of [`TallyEntry`], field by field.
    pub const TALLY_ENTRY_FIELDS for TallyEntry, size 208 {
        answer: "Answer" at 0, 192;
        latency_ns: "u64" at 192, 8;
        missing: "u64" at 200, 8;
    }
}

impl TallyEntry {
    /// An entry for a participant that had been lost.
    #[must_use]
    pub fn missing(participant: u32) -> Self {
        let mut answer = Answer::default();
        answer.participant = participant;
        Self { answer, latency_ns: 0, missing: 1 }
    }

    /// An entry for an answer that came after `latency_ns`.
    #[must_use]
    pub fn answered(answer: Answer, latency_ns: u64) -> Self {
        Self { answer, latency_ns, missing: 0 }
    }

    /// What the participant replied. The server put only checked answers in;
    /// should the bytes say otherwise, the reply counts as missing.
    #[must_use]
    pub fn reply(&self) -> Reply {
        match (self.missing, self.answer.message()) {
            (0, Ok(Message::Reply(reply))) => reply,
            _ => Reply::Missing,
        }
    }
}

impl Default for Tally {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl Tally {
    /// Empties the tally for a tick.
    pub fn begin(&mut self, run_id: u64, tick: u64) {
        self.run_id = run_id;
        self.tick = tick;
        self.count = 0;
        self.stream = 0;
    }

    /// Adds the entry of the next answering participant. More than
    /// [`MAX_PARTICIPANTS`] do not fit; a roster that long is refused earlier.
    pub fn push(&mut self, entry: TallyEntry) {
        if let Some(place) = self.entries.get_mut(self.count as usize) {
            *place = entry;
            self.count += 1;
        }
    }

    /// Enciphers the tally; `stream` is 0 in the run and N in its Nth catch-up,
    /// so that no keystream is used for two texts. Returns the bytes in use.
    pub fn seal(&mut self, key: &TruthKey, stream: u32) -> &[u8] {
        self.stream = stream;
        self.apply(key);
        &bytemuck::bytes_of(self)[..self.used_bytes()]
    }

    /// Copies a sealed tally and deciphers the copy. With another key the
    /// digests and entries are noise.
    pub fn open_into(&self, key: &TruthKey, opened: &mut Self) {
        let used = self.used_bytes();
        bytemuck::bytes_of_mut(opened)[..used].copy_from_slice(&bytemuck::bytes_of(self)[..used]);
        opened.apply(key);
    }

    /// Header and entries; the rest is not read.
    fn used_bytes(&self) -> usize {
        let entries = (self.count as usize).min(MAX_PARTICIPANTS);
        std::mem::offset_of!(Self, entries) + entries * size_of::<TallyEntry>()
    }

    fn apply(&mut self, key: &TruthKey) {
        let (tick, stream) = (self.tick, self.stream);
        let to = self.used_bytes();
        let secret = &mut bytemuck::bytes_of_mut(self)[std::mem::offset_of!(Self, run_digest)..to];
        key.apply(Purpose::Tally(stream), tick, secret);
    }

    /// The entries in roster order.
    #[must_use]
    pub fn entries(&self) -> &[TallyEntry] {
        &self.entries[..(self.count as usize).min(MAX_PARTICIPANTS)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sealed_tally_shows_no_answer_and_no_digest_and_opens_with_its_key() {
        let (key, other) = (TruthKey::from_bytes([1; 32]), TruthKey::from_bytes([2; 32]));
        let estimate = Reply::from(rusty_geometry::SE2::new(4.25, -1.5, 0.75));
        let mut tally = Tally::zeroed();
        tally.begin(1, 2);
        tally.world_digest = [7; 16];
        tally.push(TallyEntry::answered(Answer::carrying(&Message::Reply(estimate)), 5));
        let (plain, mut opened) = (tally, Tally::zeroed());
        tally.seal(&key, 0);
        let bytes = bytemuck::bytes_of(&tally);
        for value in [4.25f64, -1.5, 0.75] {
            assert!(!bytes.windows(8).any(|w| w == value.to_le_bytes()));
        }
        assert!(!bytes.windows(16).any(|w| w == [7; 16]));
        tally.open_into(&key, &mut opened);
        assert_eq!(bytemuck::bytes_of(&opened), bytemuck::bytes_of(&plain));
        tally.open_into(&other, &mut opened);
        assert_ne!(opened.world_digest, [7; 16]);
        let mut again = plain;
        again.seal(&key, 1);
        assert_ne!(bytemuck::bytes_of(&again)[24..], bytes[24..]);
    }

    #[test]
    fn a_tally_holds_what_was_pushed_and_no_more() {
        let mut tally = Tally::zeroed();
        tally.begin(1, 2);
        for i in 0..20 {
            tally.push(TallyEntry::missing(i));
        }
        assert_eq!(tally.entries().len(), MAX_PARTICIPANTS);
        assert_eq!(tally.entries()[3].reply(), Reply::Missing);
        tally.begin(1, 3);
        tally.push(TallyEntry::answered(Answer::carrying(&Message::Reply(Reply::Abstain)), 5));
        assert_eq!(tally.entries().len(), 1);
        assert_eq!(tally.entries()[0].reply(), Reply::Abstain);
    }
}
