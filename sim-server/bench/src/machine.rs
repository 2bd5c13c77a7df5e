//! On what something was measured.

use std::fs;

use serde::{Deserialize, Serialize};

/// The machine and the build, as far as the kernel tells.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// What the kernel calls the CPU.
    pub cpu: Option<String>,
    /// Cores that this process may use.
    pub cores: usize,
    /// Kernel, as in `uname -sr`.
    pub kernel: String,
    /// How the clock of the first core is governed; `None` where the kernel
    /// does not say, as in most virtual machines.
    pub governor: Option<String>,
    /// Memory, bytes; 0 where the kernel does not say.
    pub memory_bytes: u64,
    /// Whether the CPU says that it is not the real one.
    pub is_virtual: bool,
    /// Version of this program.
    pub version: String,
    /// "release", or "debug" where checks of arithmetic are on.
    pub profile: String,
}

impl Machine {
    /// This machine and this build.
    #[must_use]
    pub fn here() -> Self {
        let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let meminfo = fs::read_to_string("/proc/meminfo").unwrap_or_default();
        let governor = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";
        let uname = rustix::system::uname();
        let (system, release) = (uname.sysname(), uname.release());
        Self {
            cpu: cpu_name(&cpuinfo),
            cores: cores(),
            kernel: format!("{} {}", system.to_string_lossy(), release.to_string_lossy()),
            governor: fs::read_to_string(governor).ok().map(|text| text.trim().to_owned()),
            memory_bytes: memory_bytes(&meminfo),
            is_virtual: is_virtual(&cpuinfo),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            profile: if is_debug() { "debug" } else { "release" }.to_owned(),
        }
    }

    /// One line for a person.
    #[must_use]
    pub fn line(&self) -> String {
        let cpu = self.cpu.as_deref().unwrap_or("CPU without a name");
        let kind = if self.is_virtual { ", virtual machine" } else { "" };
        let governor = self.governor.as_deref().unwrap_or("unknown");
        format!(
            "{cpu}, {} cores{kind}, {:.0} GB, {}, governor {governor}, sim-server {} ({})",
            self.cores,
            self.memory_bytes as f64 / 1e9,
            self.kernel,
            self.version,
            self.profile
        )
    }
}

/// Cores that this process may use; 1 where the kernel does not say.
#[must_use]
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Whether this build checks its arithmetic; its times say nothing.
#[must_use]
pub fn is_debug() -> bool {
    cfg!(debug_assertions)
}

/// The first "model name" in the kernel's list of CPUs.
#[must_use]
pub fn cpu_name(cpuinfo: &str) -> Option<String> {
    let line = cpuinfo.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Whether the list of CPUs has the flag that hypervisors set.
fn is_virtual(cpuinfo: &str) -> bool {
    let flags = cpuinfo.lines().find(|line| line.starts_with("flags")).unwrap_or_default();
    flags.split_whitespace().any(|flag| flag == "hypervisor")
}

fn memory_bytes(meminfo: &str) -> u64 {
    let line = meminfo.lines().find(|line| line.starts_with("MemTotal:")).unwrap_or_default();
    let kilobytes = line.split_whitespace().nth(1).and_then(|text| text.parse::<u64>().ok());
    kilobytes.unwrap_or(0).saturating_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cpu_is_named_where_the_kernel_names_it() {
        let list = "processor\t: 0\nmodel name\t: Example 9 @ 1 GHz\nmodel name\t: Another\n";
        assert_eq!(cpu_name(list).as_deref(), Some("Example 9 @ 1 GHz"));
        assert_eq!(cpu_name("processor : 0\n"), None);
    }

    #[test]
    fn a_virtual_machine_shows_by_its_flag() {
        assert!(is_virtual("flags\t\t: fpu vme hypervisor lahf_lm\n"));
        assert!(!is_virtual("flags\t\t: fpu vme\nbugs : hypervisor\n"));
    }

    #[test]
    fn memory_is_in_bytes() {
        assert_eq!(memory_bytes("MemTotal:       2048 kB\nMemFree: 1 kB\n"), 2 << 20);
        assert_eq!(memory_bytes(""), 0);
    }

    #[test]
    fn this_machine_has_a_core_and_a_kernel() {
        let machine = Machine::here();
        assert!(machine.cores >= 1 && machine.kernel.contains(' '), "{machine:?}");
        assert!(machine.line().contains(&machine.profile));
    }
}
