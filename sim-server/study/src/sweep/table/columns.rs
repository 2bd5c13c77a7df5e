//! The columns of a table, in order.

use crate::sweep::cell::Swept;
use crate::sweep::client_figures::ClientFigures;
use crate::sweep::grid::Axis;
use crate::sweep::row::Row;

/// A column.
pub(super) struct Column {
    pub name: String,
    pub values: Values,
}

/// Its values, a row each.
pub(super) enum Values {
    Whole(Vec<u64>),
    Signed(Vec<i64>),
    Number(Vec<f64>),
    Flag(Vec<bool>),
    Text(Vec<String>),
    /// Whole, and not always known.
    Known(Vec<Option<u64>>),
}

/// How a row gives a figure.
type Figure = fn(&Row) -> f64;

/// Seed, swept fields, estimator, figures, digest. A swept field's values are
/// numbers where all that were asked for are, else text. It is called as on
/// the command line, with `set.` before it where a figure has that name. A sweep
/// with clients has the figures that only they have before the digest.
pub(super) fn of(swept: &Swept, axes: &[Axis], clients: bool) -> Vec<Column> {
    let rows = &swept.rows;
    let column = |name: &str, values| Column { name: name.to_owned(), values };
    let whole = |get: fn(&Row) -> u64| Values::Whole(rows.iter().map(get).collect());
    let text = |get: fn(&Row) -> &String| Values::Text(rows.iter().map(get).cloned().collect());
    let number = |get: Figure| Values::Number(rows.iter().map(get).collect());
    let figures: [(&str, Figure); 10] = [
        ("time_s", |r| r.time_s),
        ("distance_m", |r| r.distance_m),
        ("final_position_error_m", |r| r.final_position_error_m),
        ("final_heading_error_rad", |r| r.final_heading_error_rad),
        ("mean_position_error_m", |r| r.mean_position_error_m),
        ("ate_rmse_m", |r| r.ate_rmse_m),
        ("p95_position_error_m", |r| r.p95_position_error_m),
        ("max_position_error_m", |r| r.max_position_error_m),
        ("rmse_heading_error_rad", |r| r.rmse_heading_error_rad),
        ("max_heading_error_rad", |r| r.max_heading_error_rad),
    ];
    let mut columns = vec![
        column("seed", whole(|r| r.seed)),
        column("estimator", text(|r| &r.estimator)),
        column("ticks", whole(|r| r.ticks)),
    ];
    columns.extend(figures.map(|(name, get)| column(name, number(get))));
    let blocked = Values::Known(rows.iter().map(|r| r.blocked_ticks).collect());
    columns.push(column("blocked_ticks", blocked));
    columns.push(column("z_short", number(|r| r.z_short)));
    if clients {
        columns.extend(of_clients(rows));
    }
    columns.push(column("digest", text(|r| &r.digest)));
    let swept_fields = axes.iter().enumerate().map(|(i, axis)| {
        let taken = columns.iter().any(|c| c.name == axis.key);
        let name = if taken { format!("set.{}", axis.key) } else { axis.key.clone() };
        let value = |row: &Row| row.parameters.get(i).map_or("", |(_, value)| value).to_owned();
        Column { name, values: typed(&axis.values, rows.iter().map(value)) }
    });
    let swept_fields: Vec<Column> = swept_fields.collect();
    // After the seed.
    columns.splice(1..1, swept_fields);
    columns
}

/// The columns that only runs with clients have. Of a row that was made before
/// there were such, nothing is known.
fn of_clients(rows: &[Row]) -> Vec<Column> {
    type Get<T> = fn(&ClientFigures) -> T;
    let number = |(name, get): (&str, Get<f64>)| {
        let values = rows.iter().map(|r| r.clients.as_ref().map_or(f64::NAN, get)).collect();
        Column { name: name.to_owned(), values: Values::Number(values) }
    };
    let whole = |(name, get): (&str, Get<u64>)| {
        let values = rows.iter().map(|r| r.clients.as_ref().map(get)).collect();
        Column { name: name.to_owned(), values: Values::Known(values) }
    };
    let errors: [(&str, Get<f64>); 6] = [
        ("ate_origin_rmse_m", |c| c.ate_origin_rmse_m),
        ("ate_se2_rmse_m", |c| c.ate_se2_rmse_m),
        ("rpe_per_tick_rmse_m", |c| c.rpe_per_tick_rmse_m),
        ("rpe_per_tick_rmse_rad", |c| c.rpe_per_tick_rmse_rad),
        ("rpe_per_metre_rmse_m", |c| c.rpe_per_metre_rmse_m),
        ("rpe_per_metre_rmse_rad", |c| c.rpe_per_metre_rmse_rad),
    ];
    let consistency: [(&str, Get<f64>); 4] = [
        ("nees_mean", |c| c.nees_mean),
        ("nees_last", |c| c.nees_last),
        ("nis_sum", |c| c.nis_sum),
        ("nis_degrees", |c| c.nis_degrees),
    ];
    let times: [(&str, Get<f64>); 10] = [
        ("converged_after_s", |c| c.converged_after_s),
        ("converged_position_rmse_m", |c| c.found.position_rmse_m),
        ("converged_heading_rmse_rad", |c| c.found.heading_rmse_rad),
        ("recovered_after_s", |c| c.recovered_after_s),
        ("goals_after_s", |c| c.goals_after_s),
        ("goals_driven_m", |c| c.goals_driven_m),
        ("compute_reported_p50_s", |c| c.compute_reported_p50_s),
        ("compute_reported_p99_s", |c| c.compute_reported_p99_s),
        ("compute_observed_p50_s", |c| c.compute_observed_p50_s),
        ("compute_observed_p99_s", |c| c.compute_observed_p99_s),
    ];
    let mut columns: Vec<Column> = errors.map(number).into();
    columns.push(whole(("scored_ticks", |c| c.scored_ticks)));
    columns.push(whole(("wrong_ticks", |c| c.wrong_ticks)));
    columns.push(whole(("nees_samples", |c| c.nees_samples)));
    columns.push(whole(("nis_samples", |c| c.nis_samples)));
    columns.push(whole(("kidnapped", |c| c.found.kidnapped)));
    columns.push(whole(("recovered", |c| c.found.recovered)));
    columns.extend(consistency.map(number));
    columns.extend(times.map(number));
    columns
}

/// `values` in the narrowest type that has room for all of `all`: a shard's
/// columns have the types of the whole.
fn typed(all: &[String], values: impl Iterator<Item = String>) -> Values {
    fn read<T: std::str::FromStr>(text: &str) -> Option<T> {
        text.parse().ok()
    }
    fn each<T: std::str::FromStr + Default>(values: impl Iterator<Item = String>) -> Vec<T> {
        values.map(|v| read(&v).unwrap_or_default()).collect()
    }
    if all.iter().all(|v| read::<i64>(v).is_some()) {
        Values::Signed(each(values))
    } else if all.iter().all(|v| read::<f64>(v).is_some_and(f64::is_finite)) {
        Values::Number(each(values))
    } else if all.iter().all(|v| read::<bool>(v).is_some()) {
        Values::Flag(each(values))
    } else {
        Values::Text(values.collect())
    }
}
