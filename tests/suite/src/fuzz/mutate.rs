//! Inputs from inputs: small damage, drawn from a seed.
//!
//! The operations are those of the usual mutating fuzzers (bits, bytes,
//! truncation, repetition, splices, interesting integers, words); what guides
//! them here is the corpus alone. For guidance by coverage see `tests/fuzz`.

use super::Target;

/// Numbers at the edges of their types, as text.
const NUMBERS: [&str; 16] = [
    "0",
    "-0",
    "1",
    "-1",
    "255",
    "65536",
    "4294967296",
    "9007199254740993",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "1e308",
    "1e999",
    "-1e999",
    "5e-324",
    "0.1",
];

/// A stream of numbers from a seed (splitmix64: S. Vigna, public domain).
pub struct Dice(u64);

impl Dice {
    /// The stream of this seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `n`; 0 for none.
    pub fn below(&mut self, n: usize) -> usize {
        if n == 0 { 0 } else { (self.roll() % n as u64) as usize }
    }

    /// One of several.
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }
}

/// A mutant of one of the corpus: up to four times damaged, never longer than
/// the target allows, its checksums right in half of the cases.
pub fn mutant(target: &Target, corpus: &[Vec<u8>], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = dice.pick(corpus).clone();
    for _ in 0..=dice.below(4) {
        damage(&mut bytes, target, corpus, dice);
    }
    bytes.truncate(target.longest);
    if let Some(mend) = target.mend
        && dice.below(2) == 0
    {
        mend(&mut bytes);
    }
    bytes
}

fn damage(bytes: &mut Vec<u8>, target: &Target, corpus: &[Vec<u8>], dice: &mut Dice) {
    let len = bytes.len();
    let at = dice.below(len);
    let some = 1 + dice.below((len - at).min(64));
    let end = (at + some).min(len);
    match dice.below(11) {
        0 if len > 0 => bytes[at] ^= 1 << dice.below(8),
        1 if len > 0 => bytes[at] = dice.roll() as u8,
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..end)),
        4 => {
            let part = bytes[at..end].to_vec();
            let times = 1 + dice.below(8);
            splice(bytes, at, &part.repeat(times));
        }
        5 => {
            let other = dice.pick(corpus);
            let from = dice.below(other.len());
            let to = from + dice.below(other.len() - from);
            splice(bytes, at, &other[from..to]);
        }
        6 => {
            let other = dice.pick(corpus);
            bytes.truncate(at);
            bytes.extend_from_slice(&other[dice.below(other.len())..]);
        }
        7 | 8 => write_number(bytes, at, dice),
        9 if !target.words.is_empty() => splice(bytes, at, dice.pick(target.words).as_bytes()),
        _ => replace_text_number(bytes, at, dice),
    }
}

fn splice(bytes: &mut Vec<u8>, at: usize, part: &[u8]) {
    drop(bytes.splice(at..at, part.iter().copied()));
}

/// An integer or a double from the edges, over 1, 2, 4 or 8 bytes.
fn write_number(bytes: &mut [u8], at: usize, dice: &mut Dice) {
    let doubles = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -0.0, 5e-324, 1e300];
    let value = match dice.below(4) {
        0 => u64::MAX >> dice.below(64),
        1 => 1 << dice.below(64),
        2 => (dice.below(64) as u64).wrapping_sub(32),
        _ => dice.pick(&doubles).to_bits(),
    };
    let width = 1 << dice.below(4);
    // Fields lie at multiples of their size.
    let at = at / width * width;
    let value = if width == 8 || dice.below(2) == 0 { value } else { value >> 32 };
    for (place, byte) in bytes.iter_mut().skip(at).zip(&value.to_le_bytes()[..width]) {
        *place = *byte;
    }
}

/// Puts another number where digits stand at or behind `at`.
fn replace_text_number(bytes: &mut Vec<u8>, at: usize, dice: &mut Dice) {
    let is_number = |b: &u8| b.is_ascii_digit() || b".-+eE".contains(b);
    let Some(skip) = bytes[at..].iter().position(u8::is_ascii_digit) else { return };
    let from = at + skip;
    let length = bytes[from..].iter().take_while(|b| is_number(b)).count();
    drop(bytes.splice(from..from + length, dice.pick(&NUMBERS).bytes()));
}
