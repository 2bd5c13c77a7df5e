//! What filters held possible, for the player of the page.
//!
//! The page has the beliefs of some moments, evenly thinned, as rows of numbers in base
//! 64: of each pose its place in the box of the map (two 16-bit numbers), its heading (256
//! steps of a turn, counter-clockwise) and its share of the area (255: all). A pose
//! outside of the box has a share of 0 and is not drawn.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use rusty_contract::BeliefKind;
use rusty_geometry::trig;
use serde::Serialize;

use super::drawn::Drawn;
use crate::scoring::beliefs::{BeliefMoment, BeliefTrack, MOST_MARKS, Mark};
use crate::scoring::map::possible_look;
use crate::scoring::trace::RunTrace;

/// All poses of a page together; each takes six bytes.
const MOST_POSES: usize = 100_000;
/// All poses that are shown at a tick.
const MOST_SHOWN: usize = 1600;

/// The beliefs of a page.
pub(super) struct Beliefs<'a> {
    tracks: Vec<Thinned<'a>>,
    /// The most poses that are drawn of a filter.
    most: usize,
}

/// Those of one filter.
struct Thinned<'a> {
    track: &'a BeliefTrack,
    /// Place among the estimators, where it is one of them.
    estimator: Option<usize>,
    drawn: Drawn,
    moments: Vec<BeliefMoment>,
    /// The most poses of a moment.
    marks: usize,
}

/// What the page's script needs of one filter.
#[derive(Serialize)]
pub(super) struct TrackData {
    estimator: Option<usize>,
    #[serde(flatten)]
    drawn: Drawn,
    ticks: Vec<u64>,
    /// For each moment: how many poses the filter had, and what they are.
    whole: Vec<u32>,
    kinds: Vec<&'static str>,
    marks: usize,
    poses: String,
}

impl<'a> Beliefs<'a> {
    pub fn of(trace: &'a RunTrace) -> Self {
        let count = trace.beliefs.len().max(1);
        let shown = (MOST_SHOWN / count).clamp(1, MOST_MARKS);
        let most = (MOST_POSES / shown / count).max(1);
        let tracks = trace.beliefs.iter().enumerate().map(|(k, track)| {
            let every = track.moments.len().div_ceil(most).max(1);
            // The last one is kept: the run ends with it.
            let rest = track.moments.len().saturating_sub(1) % every;
            let kept = track.moments.iter().skip(rest).step_by(every);
            let moments: Vec<BeliefMoment> = kept.map(|moment| moment.at_most(shown)).collect();
            let marks = moments.iter().map(|moment| moment.marks.len()).max().unwrap_or(0);
            let estimator = trace.names.iter().position(|name| *name == track.name);
            let drawn = Drawn::of(&track.name, &possible_look(trace, k));
            Thinned { track, estimator, drawn, moments, marks }
        });
        Self { tracks: tracks.collect(), most: shown }
    }

    pub fn is_empty(&self) -> bool {
        self.tracks.is_empty()
    }

    /// What stands below the map.
    pub fn caption(&self) -> String {
        let (mut text, most) = (String::new(), self.most);
        let kinds = |kind| self.tracks.iter().any(|t| t.moments.iter().any(|m| m.kind == kind));
        if !self.is_empty() {
            text.push_str(
                " Arrowheads and bars: poses that a filter held possible, as received beside the run",
            );
        }
        if kinds(BeliefKind::Particles) {
            let _ = write!(text, "; of particles up to {most}, in proportion to their weight");
        }
        if kinds(BeliefKind::Histogram) {
            let _ = write!(text, "; of a histogram the {most} heaviest cells");
        }
        if !self.is_empty() {
            text.push('.');
        }
        text
    }

    /// What is shown at a tick, in words, as the script has them too.
    pub fn now(&self, tick: u64) -> String {
        let words = |track: &Thinned<'_>| match track.at(tick) {
            Some(moment) => {
                let (kind, whole, at) = (words_of(moment.kind), moment.whole, moment.tick);
                format!("{}: {kind} {whole}, tick {at}", track.track.name)
            }
            None => format!("{}: –", track.track.name),
        };
        self.tracks.iter().map(words).collect::<Vec<_>>().join(" · ")
    }

    /// Names with kinds, for the key of the map.
    pub fn entries(&self) -> impl Iterator<Item = String> {
        self.tracks.iter().map(|track| {
            let kind = track.moments.last().map_or("belief", |moment| words_of(moment.kind));
            format!("{kind} of {}", track.track.name)
        })
    }

    /// `bounds_m`: the box of the map.
    pub fn data(&self, bounds_m: [f64; 4]) -> Vec<TrackData> {
        self.tracks.iter().map(|track| track.data(bounds_m)).collect()
    }
}

impl Thinned<'_> {
    /// The latest belief at a tick.
    fn at(&self, tick: u64) -> Option<&BeliefMoment> {
        let after = self.moments.partition_point(|moment| moment.tick <= tick);
        self.moments.get(after.checked_sub(1)?)
    }

    fn data(&self, bounds_m: [f64; 4]) -> TrackData {
        let mut bytes = Vec::with_capacity(6 * self.marks * self.moments.len());
        for moment in &self.moments {
            for place in 0..self.marks {
                bytes.extend(moment.marks.get(place).map_or([0; 6], |mark| packed(bounds_m, mark)));
            }
        }
        TrackData {
            estimator: self.estimator,
            drawn: self.drawn.clone(),
            ticks: self.moments.iter().map(|moment| moment.tick).collect(),
            whole: self.moments.iter().map(|moment| moment.whole).collect(),
            kinds: self.moments.iter().map(|moment| words_of(moment.kind)).collect(),
            marks: self.marks,
            poses: BASE64_STANDARD.encode(bytes),
        }
    }
}

fn words_of(kind: BeliefKind) -> &'static str {
    match kind {
        BeliefKind::Particles => "particles",
        BeliefKind::Histogram => "cells",
    }
}

fn packed([x0, y0, x1, y1]: [f64; 4], mark: &Mark) -> [u8; 6] {
    let share = |value: f32, from: f64, to: f64| (f64::from(value) - from) / (to - from);
    let place = [share(mark.x_m, x0, x1), share(mark.y_m, y0, y1)];
    if !place.iter().all(|share| (0.0..=1.0).contains(share)) || mark.share <= 0.0 {
        return [0; 6];
    }
    let [[x0, x1], [y0, y1]] = place.map(|share| ((share * 65_535.0).round() as u16).to_le_bytes());
    // The remainder is at least 0 and, rounded, at most 256, which is 0 again.
    let (s, c) = trig::sin_cos(f64::from(mark.theta_rad));
    let turns = trig::atan2(s, c) / std::f64::consts::TAU;
    let heading = ((turns.rem_euclid(1.0) * 256.0).round() as u32 % 256) as u8;
    [x0, x1, y0, y1, heading, (f64::from(mark.share) * 255.0).round().max(1.0) as u8]
}
