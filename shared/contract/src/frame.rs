//! `Frame`: what the world shows each tick, one fixed layout, read where it lies.
//!
//! | offset | size | field          | type      | unit, frame, meaning                                   |
//! |-------:|-----:|----------------|-----------|--------------------------------------------------------|
//! |      0 |    8 | `run_id`       | u64       | this run, drawn afresh at every start                  |
//! |      8 |    8 | `published_ns` | u64       | monotonic clock at send: a hint for waiting, no data   |
//! |     16 |    4 | `phase`        | u32       | 0 tick; otherwise why the run ended, see [`Phase`]     |
//! |     20 |    4 | `lost`         | u32       | bit k: the run no longer waits for slot k |
//! |     24 |    8 | `digest`       | u64       | XXH3-64 of the observable part                         |
//! |     32 |   32 | `sealed`       | `[u8; 32]`  | the true pose and the digest, enciphered               |
//! |     64 |  128 | `tags`         | `[u64; 16]` | for each slot of the roster: that the server sent this |
//! |    192 |    8 | `tick`         | u64       | from 0                                                 |
//! |    200 |    8 | `time_s`       | f64       | s since the start; (tick + 1)·dt, or a recording's own |
//! |    208 |    8 | `left_ticks`   | i64       | cumulative encoder counts, left wheel                  |
//! |    216 |    8 | `right_ticks`  | i64       | cumulative encoder counts, right wheel                 |
//! |    224 |    8 | `v_m_s`        | f64       | command applied in this tick, body frame               |
//! |    232 |    8 | `omega_rad_s`  | f64       | command applied in this tick, body frame               |
//! |    240 |    4 | `flags`        | u32       | bit 0: a scan is present; bit 1: the truth is known    |
//! |    244 |    4 | `beams`        | u32       | ranges in use, 0 without a scan                        |
//! |    248 | 8640 | `ranges_m`     | `[f64; 1080]`| range of beam k along its bearing, sensor frame        |
//!
//! The *observable part* is `tick` up to the last range in use: bytes 192 to
//! 248 + 8·beams. It is all an estimator may know, it is all the digest
//! covers, and so the digest is the same in every run of the same seed. Run
//! id, clock, losses, tags and ciphertext differ from run to run and are no data.
//!
//! A tag is SipHash-2-4, with the key that the server shares with the participant
//! at that slot, over `run_id`, `tick`, `phase`, `lost` and `digest`.

use bytemuck::{Pod, Zeroable};
use rusty_geometry::{EncoderCounts, SE2, Twist};
use xxhash_rust::xxh3::xxh3_64;

use crate::auth::AuthKey;
use crate::field_table::{Field, field_table};
use crate::tally::MAX_PARTICIPANTS;
use crate::truth::{KeyError, SealedTruth, Truth, TruthKey};

/// The most beams a scan can have.
pub const MAX_BEAMS: usize = 1080;

const HAS_SCAN: u32 = 1;
const HAS_TRUTH: u32 = 2;

/// Where the observable part begins, in bytes.
pub const OBSERVABLE_FROM: usize = 192;

/// Where the flags end, in bytes of the observable part.
const FLAGS_TO: usize = std::mem::offset_of!(Frame, flags) + 4 - OBSERVABLE_FROM;

/// One tick of the world. Read it through the methods: they honour `beams`
/// and `flags`, and none of them opens the truth without its key.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Frame {
    /// This run; answers carry it back.
    pub run_id: u64,
    /// Monotonic clock of the sender, ns: a hint for waiting.
    pub published_ns: u64,
    phase: u32,
    lost: u32,
    digest: u64,
    sealed: SealedTruth,
    tags: [u64; MAX_PARTICIPANTS],
    tick: u64,
    time_s: f64,
    left_ticks: i64,
    right_ticks: i64,
    v_m_s: f64,
    omega_rad_s: f64,
    flags: u32,
    beams: u32,
    ranges_m: [f64; MAX_BEAMS],
}

field_table! {
    /// The layout of [`Frame`], field by field.
    pub const FRAME_FIELDS for Frame, size 8888 {
        run_id: "u64" at 0, 8;
        published_ns: "u64" at 8, 8;
        phase: "u32" at 16, 4;
        lost: "u32" at 20, 4;
        digest: "u64" at 24, 8;
        sealed: "[u8; 32]" at 32, 32;
        tags: "[u64; 16]" at 64, 128;
        tick: "u64" at 192, 8;
        time_s: "f64" at 200, 8;
        left_ticks: "i64" at 208, 8;
        right_ticks: "i64" at 216, 8;
        v_m_s: "f64" at 224, 8;
        omega_rad_s: "f64" at 232, 8;
        flags: "u32" at 240, 4;
        beams: "u32" at 244, 4;
        ranges_m: "[f64; 1080]" at 248, 8640;
    }
}

/// What a frame is: a tick of the world, or the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Phase {
    /// The world moved by one tick.
    Tick = 0,
    /// The run is complete.
    Done = 1,
    /// The server was asked to stop.
    Interrupted = 2,
    /// A participant was lost and the scenario says `on_loss = "abort"`.
    Aborted = 3,
}

impl Frame {
    /// A frame of zeros: a place to write into where there is no loan.
    #[must_use]
    pub fn boxed() -> Box<Self> {
        bytemuck::zeroed_box()
    }

    /// Starts to write a tick: sets everything but the scan, which is absent
    /// until [`write_scan`](Self::write_scan).
    pub fn begin(&mut self, tick: u64, time_s: f64, ticks: EncoderCounts, command: Twist) {
        self.phase = Phase::Tick as u32;
        self.lost = 0;
        self.tick = tick;
        self.time_s = time_s;
        self.left_ticks = ticks.left;
        self.right_ticks = ticks.right;
        self.v_m_s = command.v_m_s;
        self.omega_rad_s = command.omega_rad_s;
        self.flags = 0;
        self.beams = 0;
    }

    /// Marks a scan of `beams` ranges as present and lends the place to write
    /// it: metres, one per beam. `beams` above [`MAX_BEAMS`] are cut off.
    pub fn write_scan(&mut self, beams: usize) -> &mut [f64] {
        let beams = beams.min(MAX_BEAMS);
        self.flags |= HAS_SCAN;
        self.beams = beams as u32;
        &mut self.ranges_m[..beams]
    }

    /// Says whether a truth goes with this tick. Call it before
    /// [`seal`](Self::seal): the flag is part of the digest.
    pub fn set_truth_known(&mut self, known: bool) {
        self.flags = if known { self.flags | HAS_TRUTH } else { self.flags & !HAS_TRUTH };
    }

    /// Makes the frame ready to be read: digest of the observable part, then
    /// the truth, enciphered. Without a truth, zeros are sealed.
    pub fn seal(&mut self, key: &TruthKey, pose_in_world: Option<SE2>) {
        self.write_digest(pose_in_world.is_some());
        let pose = pose_in_world.unwrap_or_else(SE2::identity);
        self.sealed = key.seal(self.tick, &pose, self.digest);
    }

    /// The digest that [`seal`](Self::seal) writes, without sealing a truth: for
    /// a process that keeps the frame to itself.
    pub fn write_digest(&mut self, truth_known: bool) {
        self.set_truth_known(truth_known);
        self.digest = self.observable_digest();
    }

    /// Turns the frame into the end of a run.
    pub fn end(&mut self, phase: Phase, ticks_done: u64) {
        self.begin(ticks_done, 0.0, EncoderCounts::default(), Twist::default());
        self.phase = phase as u32;
        self.digest = self.observable_digest();
        self.sealed = SealedTruth::zeroed();
    }

    /// Says who is lost, by places in the roster. Call it after
    /// [`begin`](Self::begin) or [`end`](Self::end), which clear it.
    pub fn set_lost(&mut self, places: impl Iterator<Item = usize>) {
        let bits = places.filter_map(|place| 1u32.checked_shl(place as u32));
        self.lost = bits.fold(0, |all, bit| all | bit);
    }

    /// Signs the frame for the participant at `slot`, which shares `key` with the
    /// server. Nothing may be changed after it but the clock.
    pub fn sign(&mut self, slot: usize, key: &AuthKey) {
        let tag = key.tag(bytemuck::bytes_of(&self.signed()));
        if let Some(place) = self.tags.get_mut(slot) {
            *place = tag;
        }
    }

    /// Whether the server signed this frame for the participant at `slot`.
    #[must_use]
    pub fn is_signed_for(&self, slot: usize, key: &AuthKey) -> bool {
        self.tags.get(slot) == Some(&key.tag(bytemuck::bytes_of(&self.signed())))
    }

    /// What a tag covers.
    fn signed(&self) -> [u64; 4] {
        let phase_and_lost = u64::from(self.phase) << 32 | u64::from(self.lost);
        [self.run_id, self.tick, phase_and_lost, self.digest]
    }

    /// Whether the run goes on without the participant at this place of the
    /// roster: what it answers is not looked at any more.
    #[must_use]
    pub fn has_lost(&self, participant: u32) -> bool {
        1u32.checked_shl(participant).is_some_and(|bit| self.lost & bit != 0)
    }

    /// What this frame is. An unknown number is read as [`Phase::Aborted`]:
    /// whatever it means, the run does not go on.
    #[must_use]
    pub fn phase(&self) -> Phase {
        match self.phase {
            0 => Phase::Tick,
            1 => Phase::Done,
            2 => Phase::Interrupted,
            _ => Phase::Aborted,
        }
    }

    /// Number of the tick, from 0. At the end of a run: the number of ticks.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Seconds since the start of the run, at the end of this tick.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Cumulative encoder counts at the end of this tick.
    #[must_use]
    pub fn encoders(&self) -> EncoderCounts {
        EncoderCounts { left: self.left_ticks, right: self.right_ticks }
    }

    /// The command that was applied during this tick, body frame.
    #[must_use]
    pub fn command(&self) -> Twist {
        Twist { v_m_s: self.v_m_s, omega_rad_s: self.omega_rad_s }
    }

    /// The scan taken at the end of this tick, where it lies: one range in
    /// metres per beam, sensor frame; `None` on ticks without a scan.
    #[must_use]
    pub fn ranges_m(&self) -> Option<&[f64]> {
        let beams = (self.beams as usize).min(MAX_BEAMS);
        (self.flags & HAS_SCAN != 0).then(|| &self.ranges_m[..beams])
    }

    /// Whether a true pose is known for this tick (always in a simulation; in
    /// a recording only where the recording has one).
    #[must_use]
    pub fn truth_known(&self) -> bool {
        self.flags & HAS_TRUTH != 0
    }

    /// The digest the server wrote: XXH3-64 of the observable part.
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.digest
    }

    /// The digest computed afresh from the bytes as they lie.
    #[must_use]
    pub fn observable_digest(&self) -> u64 {
        xxh3_64(self.observable())
    }

    /// The observable part, as bytes.
    #[must_use]
    pub fn observable(&self) -> &[u8] {
        let beams = (self.beams as usize).min(MAX_BEAMS);
        let to = std::mem::offset_of!(Self, ranges_m) + 8 * beams;
        &bytemuck::bytes_of(self)[OBSERVABLE_FROM..to]
    }

    /// The observable part as it is where no truth is known: all up to and with
    /// the flags, and the rest.
    #[must_use]
    pub fn observable_without_truth(&self) -> ([u8; FLAGS_TO], &[u8]) {
        let (front, rest) = self.observable().split_at(FLAGS_TO);
        let mut bytes = [0; FLAGS_TO];
        bytes.copy_from_slice(front);
        bytes[FLAGS_TO - 4..].copy_from_slice(&(self.flags & !HAS_TRUTH).to_le_bytes());
        (bytes, rest)
    }

    /// Opens the truth of this tick. `Ok(None)` where none is known.
    ///
    /// # Errors
    /// [`KeyError::Wrong`] when the key is not this run's.
    pub fn open_truth(&self, key: &TruthKey) -> Result<Option<Truth>, KeyError> {
        let truth = key.open(self.tick, &self.sealed, self.digest)?;
        Ok(self.truth_known().then_some(truth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Box<Frame> {
        let mut frame = Frame::boxed();
        frame.begin(
            7,
            0.16,
            EncoderCounts { left: -3, right: 1 << 40 },
            Twist { v_m_s: 0.5, omega_rad_s: -0.25 },
        );
        frame.write_scan(3).copy_from_slice(&[1.0, 2.0, 8.0]);
        frame
    }

    #[test]
    fn the_digest_covers_what_can_be_seen_and_nothing_else() {
        let key = TruthKey::from_bytes([3; 32]);
        let mut frame = sample();
        frame.seal(&key, Some(SE2::new(1.0, 2.0, 3.0)));
        let digest = frame.digest();
        frame.run_id = 99;
        frame.published_ns = 99;
        frame.ranges_m[3] = 5.0;
        assert_eq!(frame.observable_digest(), digest);
        frame.ranges_m[2] = f64::from_bits(frame.ranges_m[2].to_bits() ^ 1);
        assert_ne!(frame.observable_digest(), digest);
    }

    #[test]
    fn who_is_lost_can_be_read_and_is_no_data() {
        let mut frame = sample();
        frame.seal(&TruthKey::from_bytes([3; 32]), None);
        let digest = frame.digest();
        frame.set_lost([0, 15, 31, 32, usize::MAX].into_iter());
        assert_eq!(frame.observable_digest(), digest);
        let lost: Vec<u32> = (0..100).filter(|place| frame.has_lost(*place)).collect();
        assert_eq!(lost, [0, 15, 31]);
        frame.end(Phase::Done, 8);
        assert!(!frame.has_lost(0));
    }

    #[test]
    fn a_signature_is_for_one_slot_and_holds_for_run_tick_phase_losses_and_digest() {
        let (key, other) = (AuthKey::from_bytes([1; 16]), AuthKey::from_bytes([2; 16]));
        let mut frame = sample();
        frame.run_id = 5;
        frame.write_digest(false);
        let digest = frame.digest();
        frame.sign(3, &key);
        assert!(frame.is_signed_for(3, &key) && !frame.is_signed_for(3, &other));
        assert!(!frame.is_signed_for(2, &key) && !frame.is_signed_for(99, &key));
        frame.published_ns = 99;
        assert!(frame.is_signed_for(3, &key) && frame.observable_digest() == digest);
        let changes: [fn(&mut Frame); 5] = [
            |f| f.run_id ^= 1,
            |f| f.tick ^= 1,
            |f| f.phase = Phase::Done as u32,
            |f| f.set_lost(std::iter::once(0)),
            |f| f.digest ^= 1,
        ];
        for (i, change) in changes.iter().enumerate() {
            let mut changed = frame.clone();
            change(&mut changed);
            assert!(!changed.is_signed_for(3, &key), "change {i}");
        }
    }

    #[test]
    fn two_keys_give_the_same_digest() {
        let (mut a, mut b) = (sample(), sample());
        a.seal(&TruthKey::from_bytes([1; 32]), Some(SE2::identity()));
        b.seal(&TruthKey::from_bytes([2; 32]), Some(SE2::new(4.0, 5.0, 0.1)));
        assert_eq!(a.digest(), b.digest());
        assert_ne!(bytemuck::bytes_of(&a.sealed), bytemuck::bytes_of(&b.sealed));
    }

    #[test]
    fn the_truth_opens_with_its_key_only() {
        let key = TruthKey::from_bytes([9; 32]);
        let mut frame = sample();
        let pose = SE2::new(4.25, -1.5, 0.75);
        frame.seal(&key, Some(pose));
        let truth = frame.open_truth(&key).unwrap().unwrap();
        assert_eq!(truth.pose_in_world(), pose);
        assert!(frame.open_truth(&TruthKey::from_bytes([8; 32])).is_err());
        let bytes = bytemuck::bytes_of(&*frame);
        for value in [4.25f64, -1.5, 0.75] {
            assert!(!bytes.windows(8).any(|w| w == value.to_le_bytes()));
        }
    }

    #[test]
    fn a_frame_without_truth_says_so() {
        let key = TruthKey::from_bytes([9; 32]);
        let mut frame = sample();
        frame.seal(&key, None);
        assert!(frame.open_truth(&key).unwrap().is_none());
    }

    #[test]
    fn beams_out_of_range_are_never_read() {
        let mut frame = sample();
        frame.beams = u32::MAX;
        assert_eq!(frame.ranges_m().map(<[f64]>::len), Some(MAX_BEAMS));
        assert_eq!(frame.observable().len(), 8888 - OBSERVABLE_FROM);
    }
}
