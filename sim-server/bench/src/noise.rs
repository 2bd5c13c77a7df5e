//! How much the machine was disturbed while something was measured.
//!
//! A fixed piece of work, always the same chain of integer operations, is
//! timed again and again before, between and after the measurements: on a
//! machine that is left alone it always takes the same time. Next to it is
//! what the kernel counts: the time that other processes had, the time that a
//! hypervisor took away, and how often this process was put off its core while
//! it did that work.

use std::fs;
use std::hint::black_box;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::machine::is_debug;
use super::quantiles::Quantiles;
use super::results::{Results, Row};
use super::usage::{Usage, family_cpu_ns};

/// Operations in one piece of work, each waiting for the one before; together
/// about half a millisecond.
const STEPS: u64 = 400_000;
/// Pieces that are timed at a look.
const PIECES: usize = 40;
/// Nanoseconds of a unit of `/proc/stat`.
const NS_PER_TICK: f64 = 1e7;

/// Whether the times that were measured can be believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing disturbed the machine that would show.
    Quiet,
    /// Something did; ratios within the run hold, times do not.
    Noisy,
    /// So much did that nothing can be concluded.
    NotToBeBelieved,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Quiet => "quiet",
            Self::Noisy => "noisy",
            Self::NotToBeBelieved => "not to be believed",
        })
    }
}

/// How much the machine was disturbed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// What follows.
    pub verdict: Verdict,
    /// Why it is not quiet, in words.
    pub reasons: Vec<String>,
    /// The measurements; `None` where a document does not keep them.
    #[serde(flatten)]
    pub disturbances: Option<Disturbances>,
}

/// What was measured of the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Disturbances {
    /// How long the fixed piece of work took.
    pub work: Quantiles,
    /// Its 90 % quantile over its shortest time, less one.
    pub work_stretch: f64,
    /// Share of a core's time in which this process was put off its core while
    /// it did that work: involuntary switches per second of it.
    pub put_off_per_s: f64,
    /// Cores' worth of time that processes other than this one and its
    /// children had; `None` where the kernel does not say.
    pub others_cores: Option<f64>,
    /// Cores' worth of time that a hypervisor took away; `None` likewise.
    pub stolen_cores: Option<f64>,
}

impl Noise {
    /// Returns the measurements as the results of `bench noise`.
    #[must_use]
    pub fn results(&self) -> Results {
        let found = self.disturbances.unwrap_or_default();
        let mut machine = Row::new("machine")
            .with("work_stretch", found.work_stretch)
            .with("put_off_per_s", found.put_off_per_s);
        let cores = [("others_cores", found.others_cores), ("stolen_cores", found.stolen_cores)];
        for (name, cores) in cores {
            machine = cores.into_iter().fold(machine, |row, cores| row.with(name, cores));
        }
        let tables: [&[_]; 2] = [
            &[("count", 0), ("p50_ns", 0), ("p90_ns", 0), ("p99_ns", 0), ("max_ns", 0)],
            &[("work_stretch", 3), ("put_off_per_s", 1), ("others_cores", 2), ("stolen_cores", 2)],
        ];
        let work = Row::new("fixed piece of work").with_quantiles("", &found.work);
        Results::new(&tables, [work, machine])
    }

    /// One line for a person.
    #[must_use]
    pub fn line(&self) -> String {
        if self.reasons.is_empty() {
            return format!("the machine was {}", self.verdict);
        }
        format!("the machine was {}: {}", self.verdict, self.reasons.join("; "))
    }
}

/// Watches the machine. [`look`](Self::look) now and then, while nothing that
/// is measured runs; [`finish`](Self::finish) when all children have ended.
pub struct NoiseMeter {
    began: Instant,
    cpu: Option<CpuTimes>,
    family_ns: Option<u64>,
    pieces_ns: Vec<u64>,
    put_off: u64,
}

impl NoiseMeter {
    /// Begins, with a first look.
    #[must_use]
    pub fn begin() -> Self {
        let mut meter = Self {
            began: Instant::now(),
            cpu: CpuTimes::now(),
            family_ns: family_cpu_ns(),
            pieces_ns: Vec::new(),
            put_off: 0,
        };
        // The first pieces warm the core up.
        (0..PIECES).for_each(|_| work());
        meter.look();
        meter
    }

    /// Times the piece of work some times (about 20 ms).
    pub fn look(&mut self) {
        let switches = || Usage::own().map_or(0, |usage| usage.involuntary_switches);
        let before = switches();
        for _ in 0..PIECES {
            let began = Instant::now();
            work();
            self.pieces_ns.push(began.elapsed().as_nanos() as u64);
        }
        self.put_off += switches() - before;
    }

    /// Looks once more and says what there is to say.
    #[must_use]
    pub fn finish(mut self) -> Noise {
        self.look();
        let elapsed_ns = self.began.elapsed().as_nanos() as f64;
        let family = family_cpu_ns().zip(self.family_ns).map(|(now, then)| (now - then) as f64);
        let spent = CpuTimes::now().zip(self.cpu).map(|(now, then)| now.since(then));
        let others = spent.zip(family).map(|(spent, family)| {
            ((spent.busy as f64 * NS_PER_TICK - family) / elapsed_ns).max(0.0)
        });
        let in_work_s = self.pieces_ns.iter().sum::<u64>() as f64 * 1e-9;
        let shortest = self.pieces_ns.iter().copied().min().unwrap_or(1).max(1);
        let work = Quantiles::of(&mut self.pieces_ns);
        let disturbances = Disturbances {
            work,
            work_stretch: work.p90_ns as f64 / shortest as f64 - 1.0,
            put_off_per_s: self.put_off as f64 / in_work_s,
            others_cores: others,
            stolen_cores: spent.map(|spent| spent.stolen as f64 * NS_PER_TICK / elapsed_ns),
        };
        let (verdict, reasons) = judge(&disturbances, is_debug());
        Noise { verdict, reasons, disturbances: Some(disturbances) }
    }
}

/// The verdict, and why it is not better.
fn judge(found: &Disturbances, debug: bool) -> (Verdict, Vec<String>) {
    let mut reasons = Vec::new();
    let mut verdict = Verdict::Quiet;
    // Each with what is still quiet, and with what is still believed.
    let mut weigh = |value: f64, (quiet, believed): (f64, f64), reason: String| {
        let one = match value {
            v if v <= quiet => return,
            v if v <= believed => Verdict::Noisy,
            _ => Verdict::NotToBeBelieved,
        };
        verdict = verdict.max(one);
        reasons.push(reason);
    };
    let percent = 100.0 * found.work_stretch;
    let text = format!("a fixed piece of work took up to {percent:.0} % longer than at best");
    weigh(found.work_stretch, (0.10, 0.50), text);
    let text = format!("{:.0} times a second this process lost its core", found.put_off_per_s);
    weigh(found.put_off_per_s, (20.0, 200.0), text);
    let others = found.others_cores.unwrap_or(0.0);
    let text = format!("other processes had {others:.2} cores");
    weigh(others, (0.10, 0.50), text);
    let stolen = found.stolen_cores.unwrap_or(0.0);
    let text = format!("the hypervisor took {stolen:.2} cores");
    weigh(stolen, (0.02, 0.10), text);
    if debug {
        weigh(1.0, (0.0, 0.0), "this is no release build: use cargo build --release".to_owned());
    }
    (verdict, reasons)
}

/// One piece: a chain in which every operation waits for the one before.
fn work() {
    let mut x = black_box(0x9E37_79B9_7F4A_7C15u64);
    for step in 0..STEPS {
        x = (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9).wrapping_add(step);
    }
    black_box(x);
}

/// The kernel's account of all cores, in hundredths of a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct CpuTimes {
    /// In which they did something.
    busy: u64,
    /// In which the hypervisor ran something else.
    stolen: u64,
}

impl CpuTimes {
    fn now() -> Option<Self> {
        Self::parse(&fs::read_to_string("/proc/stat").ok()?)
    }

    /// From "cpu user nice system idle iowait irq softirq steal …".
    fn parse(stat: &str) -> Option<Self> {
        let line = stat.lines().next()?.strip_prefix("cpu ")?;
        let times: Option<Vec<u64>> = line.split_whitespace().map(|t| t.parse().ok()).collect();
        let times = times?;
        let at = |place: usize| times.get(place).copied().unwrap_or(0);
        let found = Self { busy: at(0) + at(1) + at(2) + at(5) + at(6), stolen: at(7) };
        // All zeros: a sandbox that hides the machine.
        (found.busy + at(3) > 0).then_some(found)
    }

    fn since(self, earlier: Self) -> Self {
        Self {
            busy: self.busy.saturating_sub(earlier.busy),
            stolen: self.stolen.saturating_sub(earlier.stolen),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn still() -> Disturbances {
        Disturbances { others_cores: Some(0.01), stolen_cores: Some(0.0), ..Default::default() }
    }

    #[test]
    fn a_machine_that_is_left_alone_is_quiet() {
        assert_eq!(judge(&still(), false), (Verdict::Quiet, Vec::new()));
        let hidden = Disturbances { others_cores: None, stolen_cores: None, ..still() };
        assert_eq!(judge(&hidden, false).0, Verdict::Quiet);
    }

    #[test]
    fn the_worst_disturbance_decides_and_all_are_named() {
        let noisy = Disturbances { work_stretch: 0.2, ..still() };
        assert_eq!(judge(&noisy, false).0, Verdict::Noisy);
        let worse = Disturbances { others_cores: Some(1.4), ..noisy };
        let (verdict, reasons) = judge(&worse, false);
        assert_eq!((verdict, reasons.len()), (Verdict::NotToBeBelieved, 2));
        assert!(reasons[0].contains("20 %") && reasons[1].contains("1.40 cores"), "{reasons:?}");
        let stolen = Disturbances { stolen_cores: Some(0.05), ..still() };
        assert_eq!(judge(&stolen, false).0, Verdict::Noisy);
        let put_off = Disturbances { put_off_per_s: 1000.0, ..still() };
        assert_eq!(judge(&put_off, false).0, Verdict::NotToBeBelieved);
    }

    #[test]
    fn a_debug_build_is_not_to_be_believed() {
        let (verdict, reasons) = judge(&still(), true);
        assert_eq!(verdict, Verdict::NotToBeBelieved);
        assert!(reasons[0].contains("--release"));
    }

    #[test]
    fn the_kernel_s_account_is_read() {
        let stat = "cpu  10 20 30 400 5 6 7 8 0 0\ncpu0 1 2 3 4\n";
        assert_eq!(CpuTimes::parse(stat), Some(CpuTimes { busy: 73, stolen: 8 }));
        assert_eq!(CpuTimes::parse("cpu  0 0 0 0 0 0 0 0 0 0\n"), None);
        assert_eq!(CpuTimes::parse("intr 1\n"), None);
    }

    #[test]
    fn the_meter_counts_its_pieces() {
        let noise = NoiseMeter::begin().finish();
        let results = noise.results();
        assert_eq!(results.rows[0].number("count"), 2.0 * PIECES as f64);
        assert!(results.rows[1].number("work_stretch") >= 0.0);
        assert!(noise.line().contains("the machine was"));
    }
}
