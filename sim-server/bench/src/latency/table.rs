//! The tables of `bench latency`, for a person.

use rusty_contract::outln;

use super::{Measured, Results, Row, scans};

/// Prints the results.
pub fn print(results: &Results) {
    let pinned = match results.pin.as_slice() {
        [] => "the kernel places them".to_owned(),
        cores => format!("kept on cores {cores:?}"),
    };
    outln!("{} ticks, {} times, waiting {}; {pinned}", results.ticks, results.repeat, results.wait);
    for row in &results.rows {
        print_row(row);
    }
}

fn print_row(row: &Row) {
    outln!("\n{}, {}", row.who, scans(row.scan_every, row.beams));
    outln!(
        "  {:6} {:>8} {:>8} {:>8} {:>8} {:>9}  {:>10}  {:>17}",
        "µs",
        "p50",
        "p90",
        "p99",
        "p99.9",
        "max",
        "per second",
        "p50 of each"
    );
    for (name, measured) in [("tick", &row.tick), ("raw", &row.raw), ("floor", &row.floor)] {
        print_times(name, measured);
    }
    let spread = |s: super::Spread| format!("{:.2} ({:.2} to {:.2})", s.median, s.min, s.max);
    outln!("  tick/raw {}   raw/floor {}", spread(row.tick_over_raw), spread(row.raw_over_floor));
    if let Some(beside) = &row.beside {
        outln!("  with {} in the place of one dead reckoning:", beside.command);
        print_times("tick", &beside.tick);
        let more = beside.more_ns;
        let us = [more.median, more.min, more.max].map(|ns| ns * 1e-3);
        outln!(
            "  {} of the tick without it; {:+.2} µs ({:+.2} to {:+.2})",
            spread(beside.over_tick),
            us[0],
            us[1],
            us[2]
        );
    }
    let (server, clients) = (row.tick.server, row.tick.clients);
    outln!(
        "  a tick uses {:.2} µs of the processor in the server, {:.2} µs in the clients",
        server.cpu_ns * 1e-3,
        clients.cpu_ns * 1e-3
    );
    outln!(
        "  switches: server {:.4} to wait, {:.3} yielded or lost; clients {:.4}, {:.3}",
        server.voluntary_switches,
        server.involuntary_switches,
        clients.voluntary_switches,
        clients.involuntary_switches
    );
    outln!("  system calls beside sched_yield: {}", row.system_calls.line());
}

fn print_times(name: &str, measured: &Measured) {
    let us = |ns: u64| ns as f64 * 1e-3;
    let q = measured.all;
    let each = measured.p50_ns;
    outln!(
        "  {name:6} {:8.2} {:8.2} {:8.2} {:8.2} {:9.2}  {:10.0}  {:8.2} to {:.2}",
        us(q.p50_ns),
        us(q.p90_ns),
        us(q.p99_ns),
        us(q.p99_9_ns),
        us(q.max_ns),
        measured.per_s.median,
        each.min * 1e-3,
        each.max * 1e-3
    );
}
