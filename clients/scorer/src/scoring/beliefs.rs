//! Beliefs that a filter showed, as they are drawn: a bounded number of moments,
//! of each a bounded number of poses, in memory that does not grow with the run.
//!
//! What came is kept as it came. Of more moments than there is room for every
//! second one goes, again at the next doubling, and so on; the last one stays. So
//! what was kept once is kept as a whole when it is offered again.

use rusty_contract::{BeliefKind, WeightedPose};

pub use rusty_clients::showing::MOST_MOMENTS;

/// A belief comes at most this many ticks after the frame that it was held after.
const RECENT_FRAMES: usize = 32;
/// The most poses of a belief that are drawn.
pub const MOST_MARKS: usize = 400;

/// A pose as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// World frame, m.
    pub x_m: f32,
    /// World frame, m.
    pub y_m: f32,
    /// World frame, rad.
    pub theta_rad: f32,
    /// Of how large an area: from 0 to 1, the heaviest cell of a histogram; 1
    /// for a particle.
    pub share: f32,
}

impl Mark {
    /// One that is drawn nowhere.
    pub const NOWHERE: Self = Self { x_m: 0.0, y_m: 0.0, theta_rad: 0.0, share: 0.0 };
}

/// What a filter held possible after a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct BeliefMoment {
    /// The tick.
    pub tick: u64,
    /// What its poses are.
    pub kind: BeliefKind,
    /// How many the filter had.
    pub whole: u32,
    /// Those that are drawn.
    pub marks: Vec<Mark>,
    /// [`observable_of`](rusty_contract::digest::observable_of) the frame that it
    /// was held after, where that is known.
    pub observable: Option<u64>,
}

/// The beliefs of one filter, ticks growing.
#[derive(Clone, Debug, PartialEq)]
pub struct BeliefTrack {
    /// Its name.
    pub name: String,
    /// What is kept.
    pub moments: Vec<BeliefMoment>,
}

/// Keeps what there is to draw of beliefs.
#[derive(Clone, Debug, Default)]
pub struct BeliefKeeper {
    keepings: Vec<Keeping>,
    /// Frames that were seen last: tick and observable part.
    frames: [Option<(u64, u64)>; RECENT_FRAMES],
}

/// One filter's.
#[derive(Clone, Debug)]
struct Keeping {
    track: BeliefTrack,
    /// One of this many moments is kept.
    stride: u64,
    /// Moments taken.
    taken: u64,
    /// The last one taken, where it was not kept.
    last: Option<BeliefMoment>,
    /// One that came, of a tick that is not closed.
    pending: Option<BeliefMoment>,
}

impl BeliefMoment {
    /// What is drawn of a belief whose poses are made of numbers.
    #[must_use]
    pub fn of(tick: u64, kind: BeliefKind, whole: u32, poses: &[WeightedPose]) -> Self {
        let marks = match kind {
            BeliefKind::Particles => sampled(poses),
            BeliefKind::Histogram => heaviest(poses),
        };
        Self { tick, kind, whole, marks, observable: None }
    }

    /// Poses of which [`of`](Self::of) makes the same marks.
    #[must_use]
    pub fn poses(&self) -> Vec<WeightedPose> {
        let total: f64 = self.marks.iter().map(|mark| f64::from(mark.share)).sum();
        let pose = |mark: &Mark| {
            let [x_m, y_m, theta_rad, share] =
                [mark.x_m, mark.y_m, mark.theta_rad, mark.share].map(f64::from);
            WeightedPose { x_m, y_m, theta_rad, weight: share / total }
        };
        self.marks.iter().map(pose).collect()
    }

    /// The same with no more poses than this.
    #[must_use]
    pub fn at_most(&self, most: usize) -> Self {
        let all = self.marks.len();
        if all <= most {
            return self.clone();
        }
        let mut marks = self.marks.clone();
        match self.kind {
            // Samples are in order; every so-manieth is as good a sample.
            BeliefKind::Particles => marks = (0..most).map(|k| marks[k * all / most]).collect(),
            BeliefKind::Histogram => {
                marks.sort_by(|a, b| b.share.total_cmp(&a.share));
                marks.truncate(most);
            }
        }
        Self { marks, ..*self }
    }
}

fn mark(pose: &WeightedPose, share: f64) -> Mark {
    let [x_m, y_m, theta_rad] = [pose.x_m, pose.y_m, pose.theta_rad].map(|v| v as f32);
    Mark { x_m, y_m, theta_rad, share: share as f32 }
}

/// Particles in proportion to their weight, all of one size: systematic
/// sampling, from the middle of each interval (Thrun, Burgard, Fox,
/// *Probabilistic Robotics*, table 4.4, with r a half). Without weights, evenly.
fn sampled(poses: &[WeightedPose]) -> Vec<Mark> {
    let count = poses.len().min(MOST_MARKS);
    let total: f64 = poses.iter().map(|pose| pose.weight).sum();
    if !(total > 0.0 && total.is_finite()) {
        return (0..count).map(|k| mark(&poses[k * poses.len() / count], 1.0)).collect();
    }
    let (mut at, mut below) = (0, poses.first().map_or(0.0, |pose| pose.weight));
    let draw = |k: usize| {
        let wanted = (k as f64 + 0.5) / count as f64 * total;
        while below < wanted && at + 1 < poses.len() {
            at += 1;
            below += poses[at].weight;
        }
        mark(&poses[at], 1.0)
    };
    (0..count).map(draw).collect()
}

/// The heaviest cells, in their order. Without weights, evenly.
fn heaviest(poses: &[WeightedPose]) -> Vec<Mark> {
    let most = poses.iter().map(|pose| pose.weight).fold(0.0, f64::max);
    if most <= 0.0 {
        return sampled(poses);
    }
    let mut order: Vec<usize> = (0..poses.len()).filter(|&k| poses[k].weight > 0.0).collect();
    order.sort_by(|&a, &b| poses[b].weight.total_cmp(&poses[a].weight).then(a.cmp(&b)));
    order.truncate(MOST_MARKS);
    order.sort_unstable();
    order.iter().map(|&k| mark(&poses[k], poses[k].weight / most)).collect()
}

impl BeliefKeeper {
    /// Takes a belief. One that is no later than the last of its filter is left
    /// aside: a filter that comes back shows again what it showed.
    pub fn offer(&mut self, name: &str, mut moment: BeliefMoment) {
        let seen = self.frames[moment.tick as usize % RECENT_FRAMES];
        moment.observable = seen.filter(|(tick, _)| *tick == moment.tick).map(|(_, seen)| seen);
        let known = self.keepings.iter().position(|keeping| keeping.track.name == name);
        let place = known.unwrap_or_else(|| {
            let track = BeliefTrack { name: name.to_owned(), moments: Vec::new() };
            let keeping = Keeping { track, stride: 1, taken: 0, last: None, pending: None };
            self.keepings.push(keeping);
            self.keepings.len() - 1
        });
        self.keepings[place].offer(moment);
    }

    /// The ticks before this one are over: a belief of theirs has come, or does
    /// not count any more. So a tick whose belief was still on its way when the
    /// run ended is left out whether it came or not, and the same run has the
    /// same report.
    pub fn close(&mut self, tick: u64) {
        self.keepings.iter_mut().for_each(|keeping| keeping.close(tick));
    }

    /// A frame was seen; beliefs held after it may have come or may still come.
    pub fn seen(&mut self, tick: u64, observable: u64) {
        self.frames[tick as usize % RECENT_FRAMES] = Some((tick, observable));
        for keeping in &mut self.keepings {
            let moments = &mut keeping.track.moments;
            let place = moments.partition_point(|moment| moment.tick < tick);
            let all = [moments.get_mut(place), keeping.last.as_mut(), keeping.pending.as_mut()];
            let of_tick = all.into_iter().flatten().filter(|moment| moment.tick == tick);
            of_tick.for_each(|moment| moment.observable = Some(observable));
        }
    }

    /// Gives up the result of one filter.
    pub fn forget(&mut self, name: &str) {
        self.keepings.retain(|keeping| keeping.track.name != name);
    }

    /// What was kept, in the order of `names`, then by name.
    #[must_use]
    pub fn finish(self, names: &[String]) -> Vec<BeliefTrack> {
        let tracks = self.keepings.into_iter().map(|mut keeping| {
            keeping.track.moments.extend(keeping.last);
            keeping.track
        });
        let mut tracks: Vec<BeliefTrack> = tracks.filter(|t| !t.moments.is_empty()).collect();
        let place = |name: &str| names.iter().position(|n| n == name).unwrap_or(names.len());
        tracks.sort_by(|a, b| (place(&a.name), &a.name).cmp(&(place(&b.name), &b.name)));
        tracks
    }
}

impl Keeping {
    fn offer(&mut self, moment: BeliefMoment) {
        let before = self.pending.as_ref().or(self.last.as_ref()).or(self.track.moments.last());
        if before.is_some_and(|before| before.tick >= moment.tick) {
            return;
        }
        let tick = moment.tick;
        self.close(tick);
        self.pending = Some(moment);
    }

    fn close(&mut self, tick: u64) {
        if let Some(moment) = self.pending.take_if(|moment| moment.tick < tick) {
            self.take(moment);
        }
    }

    fn take(&mut self, moment: BeliefMoment) {
        let before = self.last.take();
        let moments = &mut self.track.moments;
        // The first one without room was the last one until now.
        if moments.len() == MOST_MOMENTS && self.taken > MOST_MOMENTS as u64 * self.stride {
            let mut place = 0;
            moments.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            self.stride *= 2;
            moments.extend(before);
        }
        match self.taken.is_multiple_of(self.stride) && moments.len() < MOST_MOMENTS {
            true => moments.push(moment),
            false => self.last = Some(moment),
        }
        self.taken += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(x_m: f64, weight: f64) -> WeightedPose {
        WeightedPose { x_m, y_m: 0.0, theta_rad: 0.0, weight }
    }

    fn moment(tick: u64) -> BeliefMoment {
        BeliefMoment::of(tick, BeliefKind::Particles, 1, &[pose(tick as f64, 1.0)])
    }

    fn at(marks: &[Mark]) -> Vec<f32> {
        marks.iter().map(|mark| mark.x_m).collect()
    }

    #[test]
    fn particles_are_drawn_in_proportion_to_their_weight() {
        let of =
            |poses: &[WeightedPose]| BeliefMoment::of(0, BeliefKind::Particles, 0, poses).marks;
        assert_eq!(at(&of(&[pose(1.0, 0.5), pose(2.0, 0.5)])), [1.0, 2.0]);
        assert_eq!(at(&of(&[pose(1.0, 0.9), pose(2.0, 0.1)])), [1.0, 1.0]);
        assert_eq!(at(&of(&[pose(1.0, 0.0), pose(2.0, 0.0)])), [1.0, 2.0]);
        assert!(of(&[]).is_empty());
        // One of 5000 holds half of the weight: half of what is drawn is there.
        let mut many: Vec<_> = (0..5000).map(|k| pose(f64::from(k), 0.5 / 4999.0)).collect();
        many[77].weight = 0.5;
        let marks = of(&many);
        let there = marks.iter().filter(|mark| mark.x_m == 77.0).count();
        assert!(marks.len() == MOST_MARKS && there.abs_diff(MOST_MARKS / 2) <= 1, "{there}");
    }

    #[test]
    fn of_a_histogram_the_heaviest_cells_are_drawn_by_their_weight() {
        let of =
            |poses: &[WeightedPose]| BeliefMoment::of(0, BeliefKind::Histogram, 0, poses).marks;
        let marks = of(&[pose(1.0, 0.2), pose(2.0, 0.0), pose(3.0, 0.8)]);
        assert_eq!((at(&marks), marks[0].share, marks[1].share), (vec![1.0, 3.0], 0.25, 1.0));
        let many: Vec<_> = (0..1000).map(|k| pose(f64::from(k), f64::from(k))).collect();
        let marks = of(&many);
        assert_eq!((marks.len(), marks[0].x_m, marks[399].x_m), (400, 600.0, 999.0));
        assert_eq!(of(&[pose(1.0, 0.0)]).len(), 1);
        let few = BeliefMoment::of(0, BeliefKind::Histogram, 0, &many).at_most(2);
        assert_eq!(at(&few.marks), [999.0, 998.0]);
        let few =
            BeliefMoment::of(0, BeliefKind::Particles, 0, &vec![pose(1.0, 1.0); 9]).at_most(4);
        assert_eq!(few.marks.len(), 4);
    }

    #[test]
    fn moments_are_bounded_evenly_spread_and_the_last_one_stays() {
        for count in [1u64, 2, 256, 257, 5000] {
            let mut keeper = BeliefKeeper::default();
            for tick in 0..count {
                keeper.offer("a", moment(5 * tick));
                keeper.close(5 * tick + 1);
            }
            let tracks = keeper.finish(&[]);
            let ticks: Vec<u64> = tracks[0].moments.iter().map(|m| m.tick).collect();
            assert!(ticks.len() <= MOST_MOMENTS + 1 && ticks.len() as u64 >= count.min(128));
            assert_eq!((ticks[0], ticks[ticks.len() - 1]), (0, 5 * (count - 1)));
            let step = count.div_ceil(256).next_power_of_two() * 5;
            assert!(ticks.windows(2).all(|pair| pair[1] - pair[0] <= step), "{count}: {ticks:?}");
        }
    }

    #[test]
    fn what_was_kept_is_the_same_when_it_is_read_again() {
        let weights = |k: u64| [0.1, 0.7, k as f64 / 7.0, 0.2];
        for kind in [BeliefKind::Particles, BeliefKind::Histogram] {
            for count in [1u64, 256, 257, 258, 511, 512, 513, 1030] {
                let mut keeper = BeliefKeeper::default();
                for tick in 0..count {
                    let poses = weights(tick).map(|w| pose(tick as f64 + w, w));
                    keeper.offer("a", BeliefMoment::of(tick, kind, 9, &poses));
                    keeper.close(tick + 1);
                }
                let kept = keeper.finish(&[]);
                let mut again = BeliefKeeper::default();
                for moment in &kept[0].moments {
                    let BeliefMoment { tick, kind, whole, .. } = *moment;
                    again.offer("a", BeliefMoment::of(tick, kind, whole, &moment.poses()));
                }
                again.close(u64::MAX);
                assert!(again.finish(&[]) == kept, "{kind} {count}");
            }
        }
    }

    #[test]
    fn a_belief_knows_its_frame_whichever_comes_first() {
        let mut keeper = BeliefKeeper::default();
        for tick in [0, 5, 10] {
            keeper.offer("early", moment(tick));
        }
        for tick in 0..=10 {
            keeper.seen(tick, 100 + tick);
            keeper.close(tick);
        }
        keeper.offer("late", moment(10));
        keeper.close(11);
        let tracks = keeper.clone().finish(&[]);
        let known = |k: usize| tracks[k].moments.iter().map(|m| m.observable).collect::<Vec<_>>();
        assert_eq!(known(0), [Some(100), Some(105), Some(110)]);
        assert_eq!(known(1), [Some(110)]);
        keeper.forget("late");
        assert_eq!(keeper.finish(&[]).len(), 1);
    }

    #[test]
    fn what_comes_twice_or_at_the_very_end_does_not_count() {
        let mut keeper = BeliefKeeper::default();
        for tick in [0, 5, 3, 5, 6] {
            keeper.offer("b", moment(tick));
        }
        keeper.offer("a", moment(6));
        keeper.close(6);
        let names = ["b".to_owned()];
        let tracks = keeper.clone().finish(&names);
        let ticks: Vec<u64> = tracks[0].moments.iter().map(|m| m.tick).collect();
        assert_eq!((tracks.len(), tracks[0].name.as_str(), ticks), (1, "b", vec![0, 5]));
        keeper.close(7);
        let names: Vec<String> = keeper.finish(&names).into_iter().map(|t| t.name).collect();
        assert_eq!(names, ["b", "a"]);
        assert!(BeliefKeeper::default().finish(&[]).is_empty());
    }
}
