//! Repetitions of a measurement, put together.

use crate::quantiles::{Quantiles, Spread};
use crate::results::Row;
use crate::stamps::Sample;
use crate::usage::Usage;

/// Rounds of one kind.
pub(super) struct Measured {
    /// The rounds of all repetitions.
    all: Quantiles,
    /// The medians of the repetitions, ns.
    p50_ns: Spread,
    /// Rounds per second in the repetitions.
    per_s: Spread,
    /// What the server used, and all clients together.
    used: [Usage; 2],
}

/// The repetitions of one kind, put together.
pub(super) struct Repeated {
    /// The median of each, ns.
    p50_ns: Vec<f64>,
    /// All of them.
    pub(super) measured: Measured,
}

impl Repeated {
    /// Puts the repetitions together.
    pub(super) fn of(samples: Vec<Sample>) -> Self {
        let (mut p50_ns, mut per_s, mut all) = (Vec::new(), Vec::new(), Vec::new());
        let mut used = [Usage::default(); 2];
        for mut sample in samples {
            let q = Quantiles::of(&mut sample.durations_ns);
            p50_ns.push(q.p50_ns as f64);
            per_s.push(if q.mean_ns > 0.0 { 1e9 / q.mean_ns } else { 0.0 });
            used = [used[0] + sample.used[0], used[1] + sample.used[1]];
            all.append(&mut sample.durations_ns);
        }
        let measured = Measured {
            all: Quantiles::of(&mut all),
            p50_ns: Spread::of(p50_ns.iter().copied()),
            per_s: Spread::of(per_s),
            used,
        };
        Self { p50_ns, measured }
    }

    /// The ratio of the medians in each repetition.
    pub(super) fn over(&self, other: &Self) -> Spread {
        self.compared(other, |a, b| a / b.max(1.0))
    }

    /// Compares the medians in each repetition.
    pub(super) fn compared(&self, other: &Self, by: fn(f64, f64) -> f64) -> Spread {
        Spread::of(self.p50_ns.iter().zip(&other.p50_ns).map(|(a, b)| by(*a, *b)))
    }
}

impl Measured {
    /// Adds all of it to a row, with `prefix` before the names.
    pub(super) fn put(&self, row: Row, prefix: &str) -> Row {
        let name = |name: &str| format!("{prefix}{name}");
        let each = |count: u64| count as f64 / self.all.count.max(1) as f64;
        let [server, clients] = self.used;
        row.with_quantiles(prefix, &self.all)
            .with(&name("p50_by_repetition_ns"), self.p50_ns)
            .with(&name("per_s"), self.per_s)
            .with(&name("server_cpu_ns"), each(server.cpu_ns))
            .with(&name("server_sleeps"), each(server.voluntary_switches))
            .with(&name("server_yields"), each(server.involuntary_switches))
            .with(&name("clients_cpu_ns"), each(clients.cpu_ns))
            .with(&name("clients_sleep"), each(clients.voluntary_switches))
            .with(&name("clients_yield"), each(clients.involuntary_switches))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repetitions_are_put_together() {
        let used = Usage { cpu_ns: 900, voluntary_switches: 2, ..Usage::default() };
        let sample = |ns: u64| Sample { durations_ns: vec![ns; 4], used: [used; 2] };
        let repeated = Repeated::of(vec![sample(1000), sample(3000), sample(2000)]);
        assert_eq!(repeated.measured.all.count, 12);
        let p50 = repeated.measured.p50_ns;
        assert_eq!((p50.min, p50.median, p50.max), (1000.0, 2000.0, 3000.0));
        assert_eq!(repeated.measured.per_s.median, 500_000.0);
        let row = repeated.measured.put(Row::new("tick"), "raw_");
        assert_eq!(row.number("raw_clients_cpu_ns"), 2700.0 / 12.0);
        assert_eq!(row.number("raw_server_sleeps"), 0.5);
    }
}
