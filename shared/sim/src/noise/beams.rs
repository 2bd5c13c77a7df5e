//! The noise of the LiDAR: two draws per beam, and one per pane of glass on its way.

use rusty_contract::MAX_BEAMS;

use super::stream::{Source, Stream};
use super::tick::TickNoise;
use rusty_geometry::normal::uniform;
use rusty_geometry::normals::standard_normals;

/// How many beams a tick has room for in the stream.
pub const BEAM_SLOTS: usize = 2048;

/// How many panes on the way of one beam have a draw.
pub const PANE_SLOTS: usize = 8;

// A scan with more beams would run into the noise of the next tick.
const _: () = assert!(MAX_BEAMS <= BEAM_SLOTS);

/// The two draws of one beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamDraw {
    /// Uniform in [0, 1): the beam drops out where it is below the probability.
    pub u: f64,
    /// Standard normal: the range error is ε = σ_r·z.
    pub z: f64,
}

/// Draws for the beams of a LiDAR.
#[derive(Clone, Debug)]
pub struct LidarNoise {
    stream: Stream,
    glass: TickNoise,
    /// Room for the draws of one scan: words as they come, then bits for the
    /// normal numbers, then those.
    words: Vec<[u64; 2]>,
    bits: Vec<u64>,
    normals: Vec<f64>,
    /// Tick and number of beams of the draws that are there.
    drawn: Option<(u64, usize)>,
}

impl LidarNoise {
    /// The LiDAR noise of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let stream = Stream::new(seed, Source::Lidar);
        let glass = TickNoise::glass(seed);
        let (words, bits, normals) = (Vec::new(), Vec::new(), Vec::new());
        Self { stream, glass, words, bits, normals, drawn: None }
    }

    /// The noise of another seed. Keeps the room it has.
    pub fn restart(&mut self, seed: u64) {
        self.stream = Stream::new(seed, Source::Lidar);
        self.glass = TickNoise::glass(seed);
        self.drawn = None;
    }

    /// The uniform number in [0, 1) of `beam` at the pane of glass with the index
    /// `pane` on its way; `None` from [`PANE_SLOTS`] on.
    pub fn at_pane(&mut self, tick: u64, beam: usize, pane: usize) -> Option<f64> {
        let slot = (PANE_SLOTS * beam + pane) as u64;
        (pane < PANE_SLOTS && beam < BEAM_SLOTS).then(|| self.glass.uniform_at(tick, slot))
    }

    /// The draws of the first `beams` beams in tick `tick`, beam 0 first; there
    /// are never more than [`BEAM_SLOTS`]. Any tick may be asked for, in any
    /// order. Allocates when a scan has more beams than any before it.
    pub fn at(&mut self, tick: u64, beams: usize) -> impl Iterator<Item = BeamDraw> + '_ {
        self.draw(tick, beams);
        let draws = self.words.iter().zip(&self.normals);
        draws.map(|([bits, _], z)| BeamDraw { u: uniform(*bits), z: *z })
    }

    /// Makes the draws of [`at`](Self::at), if they are not there.
    pub fn draw(&mut self, tick: u64, beams: usize) {
        let beams = beams.min(BEAM_SLOTS);
        if self.drawn.replace((tick, beams)) == Some((tick, beams)) {
            return;
        }
        self.words.resize(beams, [0; 2]);
        self.normals.resize(beams, 0.0);
        self.stream.seek(u128::from(tick) << 13);
        self.stream.fill(self.words.as_flattened_mut());
        self.bits.clear();
        self.bits.extend(self.words.iter().map(|[_, bits]| bits));
        standard_normals(&self.bits, &mut self.normals);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng as _;

    fn alone(seed: u64, tick: u64) -> Vec<BeamDraw> {
        LidarNoise::new(seed).at(tick, 180).collect()
    }

    #[test]
    fn a_tick_is_the_same_alone_and_after_others() {
        let mut noise = LidarNoise::new(4);
        for (tick, beams) in [(0, 180), (1, 7), (5, 1080), (10_000, 180), (5, 180)] {
            let drawn: Vec<_> = noise.at(tick, beams).collect();
            let shared = beams.min(180);
            assert_eq!(drawn[..shared], alone(4, tick)[..shared], "tick {tick}");
        }
    }

    #[test]
    fn the_room_of_a_tick_ends_where_the_next_begins() {
        let mut noise = LidarNoise::new(4);
        assert_eq!(noise.at(0, usize::MAX).count(), BEAM_SLOTS);
        // The stream now stands at the next tick: no word was skipped or shared.
        assert_eq!(noise.stream.next_u64(), {
            let mut stream = Stream::new(4, Source::Lidar);
            stream.seek(8192);
            stream.next_u64()
        });
    }

    #[test]
    fn every_pane_of_every_beam_has_a_slot() {
        let mut noise = LidarNoise::new(4);
        let at = |noise: &mut LidarNoise, tick, beam, pane| noise.at_pane(tick, beam, pane);
        let last = at(&mut noise, 0, BEAM_SLOTS - 1, PANE_SLOTS - 1);
        let first = at(&mut noise, 1, 0, 0);
        // One past the last slot of tick 0 is the first of tick 1.
        let slots = (BEAM_SLOTS * PANE_SLOTS) as u64;
        assert_eq!(first, Some(TickNoise::glass(4).uniform_at(0, slots)));
        assert_eq!(last, Some(TickNoise::glass(4).uniform_at(0, slots - 1)));
        assert_ne!(at(&mut noise, 0, 3, 0), at(&mut noise, 0, 2, 0));
        assert_ne!(at(&mut noise, 0, 3, 0), at(&mut noise, 0, 3, 1));
        assert_eq!(at(&mut noise, 0, 3, PANE_SLOTS), None);
        assert_eq!(at(&mut noise, 0, BEAM_SLOTS, 0), None);
        let before = at(&mut noise, 0, 3, 0);
        noise.restart(5);
        assert_ne!(at(&mut noise, 0, 3, 0), before);
    }

    #[test]
    fn beams_ticks_and_seeds_differ() {
        let base = alone(4, 2);
        assert!(base.windows(2).all(|pair| pair[0] != pair[1]));
        assert_ne!(base, alone(4, 3));
        assert_ne!(base, alone(5, 2));
    }
}
