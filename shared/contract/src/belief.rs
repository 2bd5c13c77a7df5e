//! What a filter holds possible, for looking at.
//!
//! An answer carries one pose and a covariance. A belief that has several peaks
//! or no parameters at all does not fit into that: it is shown as poses with
//! weights, next to the run. No process waits for it and no digest knows it.
//!
//! # The service
//!
//! `beliefs` is a publish-subscribe service of slices of [`WeightedPose`] in the
//! run's domain, each with a [`BeliefHeader`]. The server creates it and has no
//! port on it: filters publish there, viewers subscribe, and neither needs the
//! other. A filter publishes after it has answered, at most once in a tick, and
//! only while a process subscribes. Of a reader that is slow or stands still the
//! oldest slices are dropped; what is read is therefore whatever came in time.
//!
//! Both structs have separate tables ([`tables`]), whose hash is part of the
//! names of their types, and of nothing else: builds that differ in it do not
//! see each other's beliefs and take part in each other's runs all the same.
//!
//! [`BeliefWriter`] and [`BeliefReader`] keep beliefs in a file.

mod file;

pub use file::{BeliefFileError, BeliefFileHeader, BeliefReader, BeliefWriter, Found, file_name};

use bytemuck::{Pod, Zeroable};

use crate::field_table::{Field, Table, field_table, hash_fields};

/// The most poses that are shown at a time. What a belief has more is thinned
/// evenly ([`tidy`]): 640 kB are more than any page can draw.
pub const MAX_POSES: usize = 20_000;

/// A pose and how much of the belief is there.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct WeightedPose {
    /// World frame, m.
    pub x_m: f64,
    /// World frame, m.
    pub y_m: f64,
    /// World frame, rad.
    pub theta_rad: f64,
    /// Its share; those of a belief add up to 1, or are all 0 where the filter
    /// has none.
    pub weight: f64,
}

/// What the poses of a belief are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeliefKind {
    /// Samples.
    Particles,
    /// Centres of the cells of a histogram.
    Histogram,
}

impl BeliefKind {
    /// The number by which a header knows it.
    #[must_use]
    pub const fn number(self) -> u32 {
        match self {
            Self::Particles => 1,
            Self::Histogram => 2,
        }
    }

    /// The kind of this number, if there is one.
    #[must_use]
    pub const fn of_number(number: u32) -> Option<Self> {
        match number {
            1 => Some(Self::Particles),
            2 => Some(Self::Histogram),
            _ => None,
        }
    }
}

impl std::fmt::Display for BeliefKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Particles => "particles",
            Self::Histogram => "histogram",
        })
    }
}

/// What stands before the poses of a belief.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BeliefHeader {
    /// The run, as `Start` has it.
    pub run_id: u64,
    /// The tick after which the filter holds this.
    pub tick: u64,
    /// Time at the end of that tick, s.
    pub time_s: f64,
    /// Name in the roster, filled up with zeros; so viewers need no roster.
    pub name: [u8; 32],
    /// Place in the roster.
    pub participant: u32,
    /// [`BeliefKind::number`].
    pub kind: u32,
    /// How many poses follow.
    pub count: u32,
    /// How many the filter has; more than `count` where they were thinned.
    pub whole: u32,
}

field_table! {
    /// The layout of [`WeightedPose`].
    pub const POSE_FIELDS for WeightedPose, size 32 {
        x_m: "f64" at 0, 8;
        y_m: "f64" at 8, 8;
        theta_rad: "f64" at 16, 8;
        weight: "f64" at 24, 8;
    }
}

field_table! {
    /// The layout of [`BeliefHeader`].
    pub const HEADER_FIELDS for BeliefHeader, size 72 {
        run_id: "u64" at 0, 8;
        tick: "u64" at 8, 8;
        time_s: "f64" at 16, 8;
        name: "[u8; 32]" at 24, 32;
        participant: "u32" at 56, 4;
        kind: "u32" at 60, 4;
        count: "u32" at 64, 4;
        whole: "u32" at 68, 4;
    }
}

/// The structs of the service, header first.
#[must_use]
pub fn tables() -> [Table; 2] {
    [
        Table { name: "BeliefHeader", size: 72, fields: HEADER_FIELDS },
        Table { name: "WeightedPose", size: 32, fields: POSE_FIELDS },
    ]
}

/// The hash of those tables. [`layout_hash`](crate::layout::layout_hash) does
/// not know it.
#[must_use]
pub const fn belief_hash() -> u64 {
    hash_fields(hash_fields(1, HEADER_FIELDS), POSE_FIELDS)
}

impl BeliefHeader {
    /// The name as text; `None` for an invalid one.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        let length = self.name.iter().position(|b| *b == 0).unwrap_or(self.name.len());
        let name = std::str::from_utf8(&self.name[..length]).ok()?;
        crate::names::check_participant_name(name).ok().map(|()| name)
    }

    /// A name as it is in a header, cut to what has room there.
    #[must_use]
    pub fn padded(name: &str) -> [u8; 32] {
        let mut padded = [0; 32];
        padded.iter_mut().zip(name.bytes()).for_each(|(place, byte)| *place = byte);
        padded
    }
}

/// Whether a pose can be shown: made of numbers, with a weight that is not
/// below 0.
fn can_be_shown(pose: &WeightedPose) -> bool {
    let WeightedPose { x_m, y_m, theta_rad, weight } = *pose;
    [x_m, y_m, theta_rad, weight].iter().all(|v| v.is_finite()) && weight >= 0.0
}

/// Makes a belief one that can be shown: takes out what is no pose (a number
/// that is not finite, a weight below 0) and thins it evenly to [`MAX_POSES`]. Says
/// how many poses there were; 0 where nothing is left.
pub fn tidy(poses: &mut Vec<WeightedPose>) -> u32 {
    let whole = poses.len();
    poses.retain(can_be_shown);
    let all = poses.len();
    if all > MAX_POSES {
        for k in 0..MAX_POSES {
            poses[k] = poses[k * all / MAX_POSES];
        }
        poses.truncate(MAX_POSES);
    }
    if all == 0 { 0 } else { u32::try_from(whole).unwrap_or(u32::MAX) }
}

/// A belief in a few figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Effective sample size, 1 / Σ w² for weights that add up to 1
    /// (Liu, *Monte Carlo Strategies in Scientific Computing*, §2.5.3).
    pub effective: f64,
    /// Mean position, world frame, m.
    pub mean_m: [f64; 2],
    /// Mean heading, rad: that of the mean of the unit vectors.
    pub mean_rad: f64,
    /// Root of the mean squared distance from the mean position, m.
    pub spread_m: f64,
    /// Length of the mean of the unit vectors of the headings: 1 where they
    /// agree, 0 where they cancel out.
    pub agreement: f64,
}

impl Summary {
    /// Of poses; `None` of none. Where all weights are 0 they count the same.
    #[must_use]
    pub fn of(poses: &[WeightedPose]) -> Option<Self> {
        let given: f64 = poses.iter().map(|p| p.weight).sum();
        let (total, weight): (f64, fn(&WeightedPose) -> f64) = match given > 0.0 {
            true => (given, |p| p.weight),
            false => (poses.len() as f64, |_| 1.0),
        };
        if poses.is_empty() || !total.is_finite() {
            return None;
        }
        let mean = |value: &dyn Fn(&WeightedPose) -> f64| -> f64 {
            poses.iter().map(|p| weight(p) / total * value(p)).sum()
        };
        let mean_m = [mean(&|p| p.x_m), mean(&|p| p.y_m)];
        let turn = |p: &WeightedPose| rusty_geometry::trig::sin_cos(p.theta_rad);
        let (s, c) = (mean(&|p| turn(p).0), mean(&|p| turn(p).1));
        let off = |p: &WeightedPose| {
            let (dx, dy) = (p.x_m - mean_m[0], p.y_m - mean_m[1]);
            dx * dx + dy * dy
        };
        Some(Self {
            effective: 1.0 / mean(&|p| weight(p) / total),
            mean_m,
            mean_rad: rusty_geometry::trig::atan2(s, c),
            spread_m: mean(&off).sqrt(),
            agreement: rusty_geometry::trig::hypot(s, c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(x_m: f64, weight: f64) -> WeightedPose {
        WeightedPose { x_m, y_m: 0.0, theta_rad: 0.0, weight }
    }

    #[test]
    fn what_is_no_pose_is_taken_out_and_too_many_are_thinned_evenly() {
        let mut poses = vec![pose(1.0, 0.5), pose(f64::NAN, 0.5), pose(2.0, -1.0)];
        poses.push(pose(f64::INFINITY, 0.1));
        assert_eq!(tidy(&mut poses), 4);
        assert_eq!(poses, [pose(1.0, 0.5)]);
        let mut none = vec![pose(0.0, f64::NAN); 3];
        assert_eq!((tidy(&mut none), none.len()), (0, 0));
        let mut many: Vec<_> = (0..50_001).map(|k| pose(f64::from(k), 1.0)).collect();
        assert_eq!((tidy(&mut many), many.len()), (50_001, MAX_POSES));
        let gaps: Vec<f64> = many.windows(2).map(|pair| pair[1].x_m - pair[0].x_m).collect();
        assert!(gaps.iter().all(|gap| (2.0..=3.0).contains(gap)));
        assert_eq!(many[0].x_m, 0.0);
        let mut fits: Vec<_> = (0..MAX_POSES).map(|k| pose(k as f64, 1.0)).collect();
        let before = fits.clone();
        assert_eq!((tidy(&mut fits), fits == before), (20_000, true));
    }

    #[test]
    fn a_header_has_a_name_or_none() {
        let mut header = BeliefHeader::default();
        assert_eq!(header.name(), None);
        header.name = BeliefHeader::padded("particle-filter");
        assert_eq!(header.name(), Some("particle-filter"));
        header.name = BeliefHeader::padded(&"x".repeat(32));
        assert_eq!(header.name().map(str::len), Some(32));
        header.name[3] = 0xFF;
        assert_eq!(header.name(), None);
        for kind in [BeliefKind::Particles, BeliefKind::Histogram] {
            assert_eq!(BeliefKind::of_number(kind.number()), Some(kind));
        }
        assert_eq!(BeliefKind::of_number(0), None);
    }

    #[test]
    fn the_protocol_of_the_run_does_not_know_it() {
        let side = tables().map(|table| table.name);
        assert!(crate::layout::tables().iter().all(|table| !side.contains(&table.name)));
        for table in tables() {
            assert_eq!(table.fields.iter().map(|f| f.size).sum::<usize>(), table.size);
        }
        assert_ne!(belief_hash(), crate::layout::layout_hash());
    }

    #[test]
    fn a_summary_is_that_of_the_weights() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let mut poses = vec![pose(0.0, 0.75), pose(4.0, 0.25)];
        let two = Summary::of(&poses).unwrap();
        assert_eq!((two.mean_m, two.mean_rad, two.agreement), ([1.0, 0.0], 0.0, 1.0));
        // 0.75 · 1² + 0.25 · 3² = 3, and 1 / (0.5625 + 0.0625) = 1.6.
        assert!((two.spread_m - 3f64.sqrt()).abs() < 1e-15 && (two.effective - 1.6).abs() < 1e-15);
        poses[0].theta_rad = quarter;
        poses[1].theta_rad = -quarter;
        let apart = Summary::of(&poses).unwrap();
        assert!((apart.mean_rad - quarter).abs() < 1e-15 && (apart.agreement - 0.5).abs() < 1e-15);
        // Without weights each counts the same.
        let same = Summary::of(&[pose(0.0, 0.0), pose(4.0, 0.0)]).unwrap();
        assert_eq!((same.mean_m[0], same.effective, same.spread_m), (2.0, 2.0, 2.0));
        assert_eq!(Summary::of(&[]), None);
    }
}
