//! Numbers for people: the same figure has the same digits in every table.

/// A length, m: three digits behind the point, fewer of long ones, more of short
/// ones, and a power of ten where it would otherwise show as nothing.
#[must_use]
pub fn metres(value: f64) -> String {
    match value.abs() {
        v if v >= 1e5 || v.is_nan() => large(value),
        v if v >= 99.995 => format!("{value:.1}"),
        v if v >= 9.9995 => format!("{value:.2}"),
        v if v >= 0.01 || v == 0.0 => format!("{value:.3}"),
        v if v >= 0.001 => format!("{value:.4}"),
        _ => format!("{value:.1e}"),
    }
}

/// The mean of `n` numbers and its standard error, which one number does not have.
#[must_use]
pub fn mean_and_error(mean: f64, error: f64, n: usize, text: fn(f64) -> String) -> String {
    match n {
        0 | 1 => text(mean),
        _ => format!("{} ± {}", text(mean), text(error)),
    }
}

/// An angle, degrees: two digits behind the point, more of small ones.
#[must_use]
pub fn degrees(value: f64) -> String {
    match value.abs() {
        v if v >= 1e5 || v.is_nan() => large(value),
        v if v >= 0.1 || v == 0.0 => format!("{value:.2}"),
        v if v >= 0.001 => format!("{value:.4}"),
        _ => format!("{value:.1e}"),
    }
}

/// A number that is too large to be written out, infinite or NaN.
fn large(value: f64) -> String {
    match value {
        v if v.is_nan() => "–".to_owned(),
        v if v.is_finite() => format!("{v:.1e}"),
        v if v > 0.0 => "∞".to_owned(),
        _ => "-∞".to_owned(),
    }
}

/// A point in time or a time step, s: to the nanosecond, without the digits that
/// only rounding made (1.4, not 1.4000000000000001) and without zeros at the end.
#[must_use]
pub fn seconds(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.5e-9 {
        return format!("{value:e}");
    }
    // The time of day has no nanoseconds in a double; there its own digits are fewer.
    let (rounded, exact) = (format!("{value:.9}"), value.to_string());
    let rounded = trimmed(&rounded);
    if rounded.len() < exact.len() { rounded.to_owned() } else { exact }
}

/// A duration in the unit in which it has one to three digits before the point.
#[must_use]
pub fn duration(time_s: f64) -> String {
    let (value, unit) = match time_s {
        s if s < 999.5e-9 => (s * 1e9, "ns"),
        s if s < 999.5e-6 => (s * 1e6, "µs"),
        s if s < 0.9995 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    let digits = if value < 9.95 { 1 } else { 0 };
    format!("{value:.digits$} {unit}")
}

/// 95 or 99.9 of 100: no more digits than there are.
pub(super) fn percent(value: f64) -> String {
    trimmed(&format!("{value:.3}")).to_owned()
}

/// A part of 1 as percent with its unit: "73.3 %".
#[must_use]
pub fn share(of_one: f64) -> String {
    format!("{:.1} %", 100.0 * of_one)
}

/// A number with a point in it, without the zeros at its end.
fn trimmed(text: &str) -> &str {
    text.trim_end_matches('0').trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_keep_digits() {
        let lengths = [0.0, 1.06e-4, 0.0012, 0.012, 0.4574, -0.4574, 9.9996, 14.307, 123.45];
        let shown =
            ["0.000", "1.1e-4", "0.0012", "0.012", "0.457", "-0.457", "10.00", "14.31", "123.5"];
        assert_eq!(lengths.map(metres), shown);
        let odd = [1.25e9, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        assert_eq!(odd.map(metres), ["1.2e9", "∞", "-∞", "–"]);
        assert_eq!(
            [0.0, 8.5e-4, 0.0085, 49.265].map(degrees),
            ["0.00", "8.5e-4", "0.0085", "49.27"]
        );
    }

    #[test]
    fn a_time_has_no_digits_of_rounding() {
        // 14 ticks of 0.1 s are 1.4000000000000001 s in doubles.
        let times = [14.0 * 0.1, 0.0, 0.02, 30.0, -1.5, 976_052_857.337_125, 1e-12];
        let shown = ["1.4", "0", "0.02", "30", "-1.5", "976052857.337125", "1e-12"];
        assert_eq!(times.map(seconds), shown);
    }

    #[test]
    fn durations_have_few_digits() {
        let times = [0.0, 3e-9, 1.234e-6, 9.96e-6, 999.6e-6, 0.05, 2.0];
        let expected = ["0.0 ns", "3.0 ns", "1.2 µs", "10 µs", "1.0 ms", "50 ms", "2.0 s"];
        assert_eq!(times.map(duration), expected);
        assert_eq!([95.0, 99.9, 99.99].map(percent), ["95", "99.9", "99.99"]);
    }
}
