//! The sealed truth: where the robot really is, for those who hold the key.
//!
//! Each run draws a key of 32 bytes. The true pose of a tick travels as 32
//! bytes of ChaCha20 ciphertext (RFC 8439; nonce: the tick): three doubles and
//! the digest of the frame they belong to, so that a wrong key, or the truth
//! of another frame, is noticed and never believed. The key goes to scorers
//! and loggers by a private channel and is never in shared memory.
//!
//! Departures from RFC 8439: no Poly1305 tag. Participants map frames
//! read-only, so the check against the digest is about mistakes, not forgery.

use bytemuck::{Pod, Zeroable};
use chacha20::ChaCha20;
use chacha20::cipher::{KeyIvInit, StreamCipher};
use rusty_geometry::SE2;
use thiserror::Error;

use crate::hex::hex;

/// Length of a key, bytes.
pub const KEY_BYTES: usize = 32;

/// The key of one run. Its `Debug` shows nothing.
#[derive(Clone)]
pub struct TruthKey([u8; KEY_BYTES]);

/// A true pose and its frame's digest, enciphered.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct SealedTruth([u8; 32]);

/// Where the robot really is. There is no way to make one but to open a
/// [`SealedTruth`] with its key:
///
/// ```
/// # use rusty_contract::{SealedTruth, Truth, TruthKey};
/// # use rusty_geometry::SE2;
/// # let (key, digest) = (TruthKey::from_bytes([7; 32]), 5);
/// # let sealed: SealedTruth = key.seal(0, &SE2::new(1.0, 2.0, 0.5), digest);
/// let truth: Truth = key.open(0, &sealed, digest)?;
/// assert_eq!(truth.pose_in_world(), SE2::new(1.0, 2.0, 0.5));
/// # Ok::<(), rusty_contract::KeyError>(())
/// ```
///
/// The same without the key does not compile: not from a pose,
///
/// ```compile_fail,E0423
/// # use rusty_contract::Truth;
/// # use rusty_geometry::SE2;
/// let truth = Truth(SE2::new(1.0, 2.0, 0.5));
/// ```
///
/// not from nothing,
///
/// ```compile_fail,E0599
/// # use rusty_contract::Truth;
/// let truth = Truth::default();
/// ```
///
/// not from bytes or text,
///
/// ```compile_fail,E0277
/// # use rusty_contract::Truth;
/// let truth: Truth = bytemuck::Zeroable::zeroed();
/// ```
///
/// ```compile_fail,E0277
/// # use rusty_contract::Truth;
/// let truth: Truth = serde_json::from_str("[1.0, 2.0, 0.5]").unwrap();
/// ```
///
/// not from what is sealed,
///
/// ```compile_fail,E0599
/// # use rusty_contract::SealedTruth;
/// let pose = SealedTruth::default().pose_in_world();
/// ```
///
/// and not from a frame.
///
/// ```compile_fail,E0061
/// # use rusty_contract::Frame;
/// let truth = Frame::boxed().open_truth();
/// ```
///
/// ```compile_fail,E0616
/// # use rusty_contract::Frame;
/// let sealed = Frame::boxed().sealed;
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth(SE2);

impl Truth {
    /// The true pose of the body in the world frame.
    #[must_use]
    pub fn pose_in_world(&self) -> SE2 {
        self.0
    }
}

/// Why a truth did not open, or a key is none.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum KeyError {
    /// The key does not belong to this run, or the truth not to this frame.
    #[error(
        "the key does not open the truth of tick {tick}; use the key of this very run \
         (each start draws a new one)"
    )]
    Wrong {
        /// The tick that stayed closed.
        tick: u64,
    },
    /// The text is no key.
    #[error("a key is {digits} hexadecimal digits, this text has {length} characters{detail}")]
    NotAKey {
        /// Digits expected.
        digits: usize,
        /// Characters found.
        length: usize,
        /// What else is wrong.
        detail: String,
    },
    /// The sealed brief of a scorer or logger did not open.
    #[error("the key does not open the run's brief; use the key of this very run")]
    Brief,
}

impl std::fmt::Debug for TruthKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("TruthKey(hidden)")
    }
}

/// What a keystream is for; it fills the last four bytes of the nonce, so that
/// no two uses of a key share a stream.
#[derive(Clone, Copy)]
pub(crate) enum Purpose {
    /// The truth of a tick.
    Frame,
    /// The brief of a run.
    Brief,
    /// The key of the participant at a slot.
    Participant,
    /// The key of those who control the run.
    Control,
    /// The tally of a tick: 0 in the run itself, N in the Nth catch-up.
    Tally(u32),
    /// The key of a later run of a series.
    Run,
}

impl Purpose {
    fn number(self) -> u32 {
        match self {
            Self::Frame => 0,
            Self::Brief => 1,
            Self::Participant => 2,
            Self::Control => 3,
            // Below that of `Run`: there are never 2^32 catch-ups.
            Self::Tally(stream) => 4u32.saturating_add(stream).min(u32::MAX - 1),
            Self::Run => u32::MAX,
        }
    }
}

/// Reads `N` bytes from hexadecimal digits; white space around them is ignored.
pub(crate) fn bytes_from_hex<const N: usize>(text: &str) -> Result<[u8; N], KeyError> {
    let text = text.trim();
    let not_a_key = |detail: &str| KeyError::NotAKey {
        digits: 2 * N,
        length: text.chars().count(),
        detail: detail.to_owned(),
    };
    if text.len() != 2 * N || !text.is_ascii() {
        return Err(not_a_key(""));
    }
    // `from_str_radix` would take a sign for a digit.
    if !text.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(not_a_key(", not all of them hexadecimal"));
    }
    let mut bytes = [0; N];
    for (i, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(&text[2 * i..2 * i + 2], 16)
            .map_err(|_| not_a_key(", not all of them hexadecimal"))?;
    }
    Ok(bytes)
}

impl TruthKey {
    /// The key with these bytes.
    #[must_use]
    pub fn from_bytes(bytes: [u8; KEY_BYTES]) -> Self {
        Self(bytes)
    }

    /// The key as 64 hexadecimal digits, for the private channel.
    #[must_use]
    pub fn to_hex(&self) -> String {
        hex(&self.0)
    }

    /// The key of the run with this number in the series that has this key.
    ///
    /// The nonce of a tick has no run in it. Two runs with one key would have the same
    /// keystream at the same tick, and a process that combines their ciphertexts learns the
    /// difference of the two truths. So each run has a key of 32 bytes of a keystream that
    /// nothing else uses. The first has the key of the series, as a single run has.
    ///
    /// The keys of participants stay the same in a series: the tags of frames and answers
    /// cover the run, and that of a request for the next run covers the run before.
    #[must_use]
    pub fn of_run(&self, number: u64) -> Self {
        match number {
            0 => self.clone(),
            _ => Self(self.derive(Purpose::Run, number)),
        }
    }

    /// Reads what [`to_hex`](Self::to_hex) wrote; white space around it is
    /// ignored.
    ///
    /// # Errors
    /// [`KeyError::NotAKey`], without repeating the text.
    pub fn from_hex(text: &str) -> Result<Self, KeyError> {
        Ok(Self(bytes_from_hex(text)?))
    }

    /// A key for `purpose`, derived from this one.
    pub(crate) fn derive<const N: usize>(&self, purpose: Purpose, counter: u64) -> [u8; N] {
        let mut bytes = [0; N];
        self.apply(purpose, counter, &mut bytes);
        bytes
    }

    /// Enciphers bytes, or deciphers them.
    pub(crate) fn apply(&self, purpose: Purpose, counter: u64, bytes: &mut [u8]) {
        self.stream(counter, purpose).apply_keystream(bytes);
    }

    fn stream(&self, counter: u64, purpose: Purpose) -> ChaCha20 {
        let mut nonce = [0; 12];
        nonce[..8].copy_from_slice(&counter.to_le_bytes());
        nonce[8..].copy_from_slice(&purpose.number().to_le_bytes());
        ChaCha20::new(&self.0.into(), &nonce.into())
    }

    /// Seals a pose for a tick, bound to the frame with this digest.
    #[must_use]
    pub fn seal(&self, tick: u64, pose_in_world: &SE2, digest: u64) -> SealedTruth {
        let mut bytes = [0; 32];
        let p = pose_in_world;
        for (place, value) in bytes.as_chunks_mut().0.iter_mut().zip([p.x(), p.y(), p.theta()]) {
            *place = value.to_le_bytes();
        }
        bytes[24..].copy_from_slice(&digest.to_le_bytes());
        self.stream(tick, Purpose::Frame).apply_keystream(&mut bytes);
        SealedTruth(bytes)
    }

    /// Opens what [`seal`](Self::seal) closed.
    ///
    /// # Errors
    /// [`KeyError::Wrong`] if key, tick and digest do not belong together.
    pub fn open(&self, tick: u64, sealed: &SealedTruth, digest: u64) -> Result<Truth, KeyError> {
        let mut bytes = sealed.0;
        self.stream(tick, Purpose::Frame).apply_keystream(&mut bytes);
        let [x, y, theta, check]: [u64; 4] = bytemuck::cast(bytes);
        if check != digest {
            return Err(KeyError::Wrong { tick });
        }
        Ok(Truth(SE2::new(f64::from_bits(x), f64::from_bits(y), f64::from_bits(theta))))
    }

    /// Seals the brief of a scorer or logger: the part of its `Start` that
    /// no other process may read. Sixteen bytes of digest go in front.
    #[must_use]
    pub fn seal_brief(&self, run_id: u64, brief: &[u8]) -> Vec<u8> {
        let mut bytes = xxhash_rust::xxh3::xxh3_128(brief).to_le_bytes().to_vec();
        bytes.extend_from_slice(brief);
        self.stream(run_id, Purpose::Brief).apply_keystream(&mut bytes);
        bytes
    }

    /// Opens what [`seal_brief`](Self::seal_brief) closed.
    ///
    /// # Errors
    /// [`KeyError::Brief`] if the key is not this run's.
    pub fn open_brief(&self, run_id: u64, sealed: &[u8]) -> Result<Vec<u8>, KeyError> {
        let mut bytes = sealed.to_vec();
        self.stream(run_id, Purpose::Brief).apply_keystream(&mut bytes);
        let (check, brief) = bytes.split_at_checked(16).ok_or(KeyError::Brief)?;
        if check != xxhash_rust::xxh3::xxh3_128(brief).to_le_bytes() {
            return Err(KeyError::Brief);
        }
        Ok(brief.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_opens_with_its_key_tick_and_digest_only() {
        let key = TruthKey::from_bytes([7; 32]);
        let pose = SE2::new(1.5, -0.25, 3.0);
        let sealed = key.seal(41, &pose, 0xDEAD);
        assert_eq!(key.open(41, &sealed, 0xDEAD).unwrap().pose_in_world(), pose);
        assert_eq!(key.open(42, &sealed, 0xDEAD), Err(KeyError::Wrong { tick: 42 }));
        assert_eq!(key.open(41, &sealed, 0xDEAE), Err(KeyError::Wrong { tick: 41 }));
        let other = TruthKey::from_bytes([8; 32]);
        assert_eq!(other.open(41, &sealed, 0xDEAD), Err(KeyError::Wrong { tick: 41 }));
    }

    #[test]
    fn a_key_survives_its_text_and_hides_in_debug() {
        let key = TruthKey::from_bytes(std::array::from_fn(|i| i as u8 * 7));
        assert_eq!(TruthKey::from_hex(&format!(" {}\n", key.to_hex())).unwrap().0, key.0);
        assert_eq!(format!("{key:?}"), "TruthKey(hidden)");
        assert!(TruthKey::from_hex("abc").is_err());
        assert!(TruthKey::from_hex(&"é".repeat(32)).is_err());
        assert!(TruthKey::from_hex(&"zz".repeat(32)).is_err());
        assert!(TruthKey::from_hex(&"+f".repeat(32)).is_err());
    }

    #[test]
    fn the_runs_of_a_series_share_no_keystream() {
        let series = TruthKey::from_bytes([7; 32]);
        let pose = SE2::new(1.5, -0.25, 3.0);
        let sealed = |number| series.of_run(number).seal(5, &pose, 0xDEAD).0;
        assert_eq!(sealed(0), series.seal(5, &pose, 0xDEAD).0);
        let all: Vec<[u8; 32]> = (0..4).map(sealed).collect();
        for (i, one) in all.iter().enumerate() {
            assert!(!all[..i].contains(one), "run {i}");
        }
        let of_later = series.of_run(2).seal(5, &pose, 0xDEAD);
        assert!(series.open(5, &of_later, 0xDEAD).is_err());
        assert!(series.of_run(2).open(5, &of_later, 0xDEAD).is_ok());
    }

    #[test]
    fn a_brief_opens_with_its_key_only() {
        let key = TruthKey::from_bytes([7; 32]);
        let sealed = key.seal_brief(5, b"seed = 42");
        assert!(!sealed.windows(4).any(|w| w == b"seed"));
        assert_eq!(key.open_brief(5, &sealed).unwrap(), b"seed = 42");
        assert_eq!(key.open_brief(6, &sealed), Err(KeyError::Brief));
        assert_eq!(key.open_brief(5, &sealed[..10]), Err(KeyError::Brief));
    }
}
