//! What a process has used of the machine, as the kernel counts it.

use std::fs;
use std::ops::{Add, Sub};

use serde::Serialize;

/// Nanoseconds of one unit of processor time in `/proc`: the kernel's interface
/// says a hundredth of a second, on every machine that Rust runs Linux on.
const NS_PER_TICK: u64 = 10_000_000;

/// What a process has used since it began; or, as a difference, in a while.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Usage {
    /// Processor time of all its threads, ns.
    pub cpu_ns: u64,
    /// How often its main thread gave its core away because it had to wait.
    pub voluntary_switches: u64,
    /// How often its main thread was put off its core, `sched_yield` included.
    pub involuntary_switches: u64,
    /// Memory that is resident, bytes.
    pub resident_bytes: u64,
    /// The most that ever was, bytes.
    pub peak_resident_bytes: u64,
}

impl Usage {
    /// Of process `pid`; `None` if there is none, or the kernel does not say.
    #[must_use]
    pub fn of(pid: u32) -> Option<Self> {
        Self::read(&format!("/proc/{pid}"))
    }

    /// Of this process.
    #[must_use]
    pub fn own() -> Option<Self> {
        Self::read("/proc/self")
    }

    fn read(folder: &str) -> Option<Self> {
        let status = fs::read_to_string(format!("{folder}/status")).ok()?;
        Some(Self {
            cpu_ns: cpu_ns(folder)?,
            voluntary_switches: field(&status, "voluntary_ctxt_switches:")?,
            involuntary_switches: field(&status, "nonvoluntary_ctxt_switches:")?,
            resident_bytes: field(&status, "VmRSS:").unwrap_or(0) * 1024,
            peak_resident_bytes: field(&status, "VmHWM:").unwrap_or(0) * 1024,
        })
    }
}

impl Add for Usage {
    type Output = Self;

    /// Of two processes together.
    fn add(self, other: Self) -> Self {
        Self {
            cpu_ns: self.cpu_ns + other.cpu_ns,
            voluntary_switches: self.voluntary_switches + other.voluntary_switches,
            involuntary_switches: self.involuntary_switches + other.involuntary_switches,
            resident_bytes: self.resident_bytes + other.resident_bytes,
            peak_resident_bytes: self.peak_resident_bytes + other.peak_resident_bytes,
        }
    }
}

impl Sub for Usage {
    type Output = Self;

    /// What was used between `earlier` and now; memory is that of now.
    fn sub(self, earlier: Self) -> Self {
        Self {
            cpu_ns: self.cpu_ns.saturating_sub(earlier.cpu_ns),
            voluntary_switches: self.voluntary_switches.saturating_sub(earlier.voluntary_switches),
            involuntary_switches: self
                .involuntary_switches
                .saturating_sub(earlier.involuntary_switches),
            ..self
        }
    }
}

/// Processor time of this process and of its children that have ended, ns, in
/// steps of 10 ms; `None` where the kernel does not say.
#[must_use]
pub fn family_cpu_ns() -> Option<u64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    Some(times(&stat)?.iter().sum::<u64>() * NS_PER_TICK)
}

/// The scheduler's own account of every thread is exact to the nanosecond;
/// kernels without it count in hundredths of a second.
fn cpu_ns(folder: &str) -> Option<u64> {
    let exact = || {
        let mut sum = 0;
        for task in fs::read_dir(format!("{folder}/task")).ok()?.flatten() {
            let text = fs::read_to_string(task.path().join("schedstat")).ok()?;
            sum += text.split_whitespace().next()?.parse::<u64>().ok()?;
        }
        Some(sum)
    };
    exact().or_else(|| {
        let stat = fs::read_to_string(format!("{folder}/stat")).ok()?;
        let [user, system, ..] = times(&stat)?;
        Some((user + system) * NS_PER_TICK)
    })
}

/// User and system time, then the same of children that were waited for. The
/// program's name stands before them in parentheses and may hold anything.
fn times(stat: &str) -> Option<[u64; 4]> {
    let (_, after_name) = stat.rsplit_once(')')?;
    let mut fields = after_name.split_whitespace().skip(11).map(str::parse::<u64>);
    let mut next = || fields.next()?.ok();
    Some([next()?, next()?, next()?, next()?])
}

fn field(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_s_name_does_not_shift_the_fields() {
        let stat = "7 (a) b (c) S 1 7 7 0 -1 4194560 100 0 0 0 12 34 5 6 20 0 1 0 99";
        assert_eq!(times(stat), Some([12, 34, 5, 6]));
        assert_eq!(times("7 (short) S 1"), None);
    }

    #[test]
    fn a_field_of_the_status_is_found_by_its_whole_name() {
        let status =
            "VmHWM:\t  2048 kB\nnonvoluntary_ctxt_switches:\t3\nvoluntary_ctxt_switches:\t9\n";
        assert_eq!(field(status, "voluntary_ctxt_switches:"), Some(9));
        assert_eq!(field(status, "VmHWM:"), Some(2048));
        assert_eq!(field(status, "VmRSS:"), None);
    }

    #[test]
    fn this_process_has_used_something() {
        let (before, memory) = (Usage::own().unwrap(), vec![1u8; 1 << 20]);
        let used = Usage::of(std::process::id()).unwrap() - before;
        assert!(before.cpu_ns > 0 && used.resident_bytes >= memory.len() as u64, "{used:?}");
        assert!(family_cpu_ns().is_some());
        assert_eq!(Usage::of(0), None);
    }
}
