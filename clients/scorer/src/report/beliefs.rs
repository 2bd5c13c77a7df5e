//! What filters held possible, on the map: arrowheads that point where a pose
//! looks.
//!
//! The page has those of some moments, evenly thinned, as rows of numbers in base
//! 64: of each pose its place on the drawing (two 16-bit numbers in the drawing's
//! own steps), its heading (256 steps of a turn, counter-clockwise) and the share
//! of the area (255: all). A pose that lies on no page has a share of 0 and is
//! not drawn. Each filter has a layer with the classes `belief` and `bK`.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use rusty_contract::BeliefKind;
use rusty_geometry::trig;
use rusty_plot::style::Look;
use rusty_plot::{Axes, Drawing, Layer, Px};
use serde::Serialize;

use super::units::steps;
use crate::scoring::beliefs::{BeliefMoment, BeliefTrack, MOST_MARKS, Mark};
use crate::scoring::map::{draw_possible, possible_look};
use crate::scoring::trace::RunTrace;

/// All poses of a page together; each takes six bytes.
const MOST_POSES: usize = 100_000;
/// All arrowheads of a page together; each takes about a hundred bytes.
const MOST_HEADS: usize = 1600;

/// The beliefs of a page.
pub(super) struct Beliefs<'a> {
    tracks: Vec<Thinned<'a>>,
    /// The most poses that are drawn of a filter.
    heads: usize,
}

/// Those of one filter.
struct Thinned<'a> {
    track: &'a BeliefTrack,
    /// Place among the estimators, where it is one of them.
    estimator: Option<usize>,
    look: Look,
    moments: Vec<BeliefMoment>,
    /// The most poses of a moment.
    marks: usize,
}

/// What the page's script needs of one filter.
#[derive(Serialize)]
pub(super) struct TrackData {
    name: String,
    ticks: Vec<u64>,
    /// For each moment: how many poses the filter had, and what they are.
    whole: Vec<u32>,
    kinds: Vec<String>,
    marks: usize,
    poses: String,
}

impl<'a> Beliefs<'a> {
    pub fn of(trace: &'a RunTrace) -> Self {
        let count = trace.beliefs.len().max(1);
        let heads = (MOST_HEADS / count).clamp(1, MOST_MARKS);
        let most = (MOST_POSES / heads / count).max(1);
        let tracks = trace.beliefs.iter().enumerate().map(|(k, track)| {
            let every = track.moments.len().div_ceil(most).max(1);
            // The last one is kept: the page begins with it.
            let rest = track.moments.len().saturating_sub(1) % every;
            let kept = track.moments.iter().skip(rest).step_by(every);
            let moments: Vec<BeliefMoment> = kept.map(|moment| moment.at_most(heads)).collect();
            let marks = moments.iter().map(|moment| moment.marks.len()).max().unwrap_or(0);
            let estimator = trace.names.iter().position(|name| *name == track.name);
            let look = possible_look(trace, k);
            Thinned { track, estimator, look, moments, marks }
        });
        Self { tracks: tracks.collect(), heads }
    }

    pub fn is_empty(&self) -> bool {
        self.tracks.is_empty()
    }

    /// Draws those that are the latest at a tick.
    pub fn draw(&self, drawing: &mut Drawing, axes: &Axes, tick: u64) {
        for (k, track) in self.tracks.iter().enumerate() {
            let whose = track.estimator.map_or_else(String::new, |i| format!("e e{i} "));
            let layer = Layer::of(format!("{whose}belief b{k}")).within(axes.frame);
            let shown = track.at(tick).map_or(&[][..], |moment| &moment.marks);
            drawing.layer(&layer, |canvas| {
                (0..track.marks).for_each(|place| {
                    let (at, mark) = match shown.get(place) {
                        Some(mark) => (place_px(axes, mark), *mark),
                        None => ([-1000.0; 2], Mark::NOWHERE),
                    };
                    draw_possible(canvas, &track.look, at, &mark)
                })
            });
        }
    }

    /// What stands below the map.
    pub fn caption(&self) -> String {
        let (mut text, heads) = (String::new(), self.heads);
        let kinds = |kind| self.tracks.iter().any(|t| t.moments.iter().any(|m| m.kind == kind));
        if !self.is_empty() {
            text.push_str(
                " Arrowheads: poses that a filter held possible, as received beside the run",
            );
        }
        if kinds(BeliefKind::Particles) {
            let _ = write!(text, "; of particles up to {heads}, in proportion to their weight");
        }
        if kinds(BeliefKind::Histogram) {
            let _ = write!(text, "; of a histogram the {heads} heaviest cells, by area");
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

    /// Names with looks and kinds, for the key of the map.
    pub fn entries(&self) -> impl Iterator<Item = (String, Look)> {
        self.tracks.iter().map(|track| {
            let kind = track.moments.last().map_or("belief", |moment| words_of(moment.kind));
            (format!("{kind} of {}", track.track.name), track.look)
        })
    }

    pub fn data(&self, axes: &Axes) -> Vec<TrackData> {
        self.tracks.iter().map(|track| track.data(axes)).collect()
    }
}

impl Thinned<'_> {
    /// The latest belief at a tick.
    fn at(&self, tick: u64) -> Option<&BeliefMoment> {
        let after = self.moments.partition_point(|moment| moment.tick <= tick);
        self.moments.get(after.checked_sub(1)?)
    }

    fn data(&self, axes: &Axes) -> TrackData {
        let mut bytes = Vec::with_capacity(6 * self.marks * self.moments.len());
        for moment in &self.moments {
            for place in 0..self.marks {
                bytes.extend(moment.marks.get(place).map_or([0; 6], |mark| packed(axes, mark)));
            }
        }
        TrackData {
            name: self.track.name.clone(),
            ticks: self.moments.iter().map(|moment| moment.tick).collect(),
            whole: self.moments.iter().map(|moment| moment.whole).collect(),
            kinds: self.moments.iter().map(|moment| words_of(moment.kind).to_owned()).collect(),
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

fn place_px(axes: &Axes, mark: &Mark) -> Px {
    axes.px([mark.x_m, mark.y_m].map(|v| f64::from(v).clamp(-1e9, 1e9)))
}

fn packed(axes: &Axes, mark: &Mark) -> [u8; 6] {
    let [x, y] = place_px(axes, mark).map(|v| steps(v).round());
    let fits = |v: f64| (0.0..=65_535.0).contains(&v);
    if !(fits(x) && fits(y)) {
        return [0; 6];
    }
    let ([x0, x1], [y0, y1]) = ((x as u16).to_le_bytes(), (y as u16).to_le_bytes());
    // The remainder is at least 0 and, rounded, at most 256, which is 0 again.
    let (s, c) = trig::sin_cos(f64::from(mark.theta_rad));
    let turns = trig::atan2(s, c) / std::f64::consts::TAU;
    let heading = ((turns.rem_euclid(1.0) * 256.0).round() as u32 % 256) as u8;
    [x0, x1, y0, y1, heading, (f64::from(mark.share) * 255.0).round().max(1.0) as u8]
}
