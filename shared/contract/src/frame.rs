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
//! |    240 |    2 | `flags`        | u16       | bit 0: scan; 1: truth is known; 2: bumper; 3: IMU; 4: sonars; 5: doors; 6: landmarks |
//! |    242 |    1 | `doors`        | u8        | doors detected                                         |
//! |    243 |    1 | `unused`       | u8        | 0                                                      |
//! |    244 |    2 | `beams`        | u16       | ranges in use, 0 without a scan                        |
//! |    246 |    1 | `sonars`       | u8        | sonars read                                            |
//! |    247 |    1 | `landmarks`    | u8        | landmarks seen                                         |
//! |    248 | 10592 | `numbers`     | `[f64; 1324]`| first the [`Readings`], then the range of beam k along its bearing, sensor frame, m |
//!
//! The *observable part* is `tick` up to the last number in use: bytes 192 to
//! 248 + 8·(readings + beams). It is all an estimator may know, it is all the
//! digest covers, and so the digest is the same in every run of the same seed. Run
//! id, clock, losses, tags and ciphertext differ from run to run and are no data.
//! Small sensors that say nothing in a tick take no room: the part is then as it
//! is where there are none.
//!
//! A tag is SipHash-2-4, with the key that the server shares with the participant
//! at that slot, over `run_id`, `tick`, `phase`, `lost` and `digest`.

mod sensed;

use bytemuck::{Pod, Zeroable};
use rusty_geometry::{EncoderCounts, SE2, Twist};
use xxhash_rust::xxh3::xxh3_64;

use crate::auth::AuthKey;
use crate::field_table::{Field, field_table};
use crate::readings::{MAX_READINGS, Present, Readings};
use crate::tally::MAX_PARTICIPANTS;
use crate::truth::{KeyError, SealedTruth, Truth, TruthKey};

/// The most beams a scan can have.
pub const MAX_BEAMS: usize = 1080;

/// The most numbers a frame can hold.
const MAX_NUMBERS: usize = MAX_READINGS + MAX_BEAMS;

const HAS_SCAN: u16 = 1;
const HAS_TRUTH: u16 = 1 << 1;
const HAS_BUMPER: u16 = 1 << 2;
const HAS_IMU: u16 = 1 << 3;
const HAS_SONARS: u16 = 1 << 4;
const HAS_DOORS: u16 = 1 << 5;
const HAS_LANDMARKS: u16 = 1 << 6;
const HAS_READINGS: u16 = HAS_BUMPER | HAS_IMU | HAS_SONARS | HAS_DOORS | HAS_LANDMARKS;

/// Where the observable part begins, in bytes.
pub const OBSERVABLE_FROM: usize = 192;

/// Where the flags end, in bytes of the observable part.
const FLAGS_TO: usize = std::mem::offset_of!(Frame, flags) + 2 - OBSERVABLE_FROM;

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
    flags: u16,
    doors: u8,
    unused: u8,
    beams: u16,
    sonars: u8,
    landmarks: u8,
    numbers: [f64; MAX_NUMBERS],
}

field_table! {
    /// The layout of [`Frame`], field by field.
    pub const FRAME_FIELDS for Frame, size 10840 {
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
        flags: "u16" at 240, 2;
        doors: "u8" at 242, 1;
        unused: "u8" at 243, 1;
        beams: "u16" at 244, 2;
        sonars: "u8" at 246, 1;
        landmarks: "u8" at 247, 1;
        numbers: "[f64; 1324]" at 248, 10592;
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

    /// Starts to write a tick: sets everything but readings and scan, which are
    /// absent until they are written, in the order of the layout.
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
        (self.doors, self.unused) = (0, 0);
        (self.beams, self.sonars, self.landmarks) = (0, 0, 0);
    }

    /// Marks a scan of `beams` ranges as present and lends the place to write
    /// it: metres, one per beam. `beams` above [`MAX_BEAMS`] are cut off. The
    /// readings of the tick must be written.
    pub fn write_scan(&mut self, beams: usize) -> &mut [f64] {
        let beams = beams.min(MAX_BEAMS);
        self.flags |= HAS_SCAN;
        self.beams = beams as u16;
        let from = self.readings_end();
        &mut self.numbers[from..from + beams]
    }

    /// How many numbers come before the scan.
    #[inline]
    fn readings_end(&self) -> usize {
        if self.flags & HAS_READINGS == 0 { 0 } else { self.present().numbers() }
    }

    /// Which readings the frame has.
    fn present(&self) -> Present {
        let has = |flag| self.flags & flag != 0;
        Present {
            bumper: has(HAS_BUMPER),
            imu: has(HAS_IMU),
            sonars: has(HAS_SONARS).then_some(self.sonars),
            doors: has(HAS_DOORS).then_some(self.doors),
            landmarks: has(HAS_LANDMARKS).then_some(self.landmarks),
        }
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

    /// Becomes the sealed tick that `other` is. Of run, clock, losses and tags, which are
    /// still to be written, nothing is taken.
    pub fn copy_tick(&mut self, other: &Self) {
        (self.phase, self.lost) = (other.phase, 0);
        (self.digest, self.sealed) = (other.digest, other.sealed);
        let tick = other.observable();
        bytemuck::bytes_of_mut(self)[OBSERVABLE_FROM..][..tick.len()].copy_from_slice(tick);
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
        let from = self.readings_end();
        (self.flags & HAS_SCAN != 0).then(|| &self.numbers[from..from + self.beams()])
    }

    /// What the small sensors say in this tick, where it lies.
    #[must_use]
    pub fn readings(&self) -> Readings<'_> {
        Readings::new(self.present(), &self.numbers)
    }

    /// Ranges in use.
    fn beams(&self) -> usize {
        if self.flags & HAS_SCAN == 0 { 0 } else { usize::from(self.beams).min(MAX_BEAMS) }
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
        let numbers = self.readings_end() + self.beams();
        let to = std::mem::offset_of!(Self, numbers) + 8 * numbers;
        &bytemuck::bytes_of(self)[OBSERVABLE_FROM..to]
    }

    /// The observable part as it is where no truth is known: all up to and with
    /// the flags, and the rest.
    #[must_use]
    pub fn observable_without_truth(&self) -> ([u8; FLAGS_TO], &[u8]) {
        let (front, rest) = self.observable().split_at(FLAGS_TO);
        let mut bytes = [0; FLAGS_TO];
        bytes.copy_from_slice(front);
        bytes[FLAGS_TO - 2..].copy_from_slice(&(self.flags & !HAS_TRUTH).to_le_bytes());
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
mod tests;
