//! All ticks of a log as one Parquet table, with scans and readings as lists.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use rusty_contract::log::TickRecord;
use rusty_contract::{LandmarkReading, LogHeader, Sensors};
use rusty_geometry::SE2;

use super::error::ExportError;
use super::sheet::Sheet;
use super::walk::{Walk, truth};
use super::{Exported, Rows};

/// Rows of a group: as many as are held in memory.
const GROUP_ROWS: usize = 4096;

const POSE: [&str; 3] = ["x_m", "y_m", "theta_rad"];
const VARIANCES: [&str; 3] = ["var_x_m2", "var_y_m2", "var_theta_rad2"];
const IMU: [&str; 3] = ["yaw_rate_rad_s", "accel_x_m_s2", "accel_y_m_s2"];
const LANDMARKS: [&str; 3] = ["id", "range_m", "bearing_rad"];

/// Writes the ticks of `log` to `out`, with `force` also over a file that is
/// there: a row each, null where there is nothing. The columns are those of
/// [`csv`](super::csv), and `ranges_m`, `sonar_m`, `doors` and `landmarks.…` are
/// lists. The metadata has scenario, seed and time step.
///
/// # Errors
/// [`ExportError`]; nothing is written then.
pub fn export(
    log: &Path,
    out: &Path,
    force: bool,
    stop: &AtomicBool,
) -> Result<Exported, ExportError> {
    let mut walk = Walk::open(log, stop)?;
    let failed = ExportError::parquet(out);
    let dt_s = walk.header.config.dt_s;
    let mut sheet = Sheet::create(out, force)?;
    let mut table = Table::of(&walk.header, &walk.names());
    let mut writer = writer(&mut sheet, &table, &walk.header).map_err(&failed)?;
    let mut rows = Rows::of(&walk);
    while let Some(record) = walk.tick()? {
        rows.see(&record, &walk);
        table.tick(&record, dt_s);
        for estimate in walk.estimates() {
            table.pose(estimate.as_ref().map(|e| &e.pose_in_world));
            let covariance = estimate.and_then(|e| e.covariance);
            table.numbers(covariance.map(|c| [c[0], c[4], c[8]]));
        }
        table.readings(&record);
        if table.rows() == GROUP_ROWS {
            table.write(&mut writer).map_err(&failed)?;
        }
    }
    if table.rows() > 0 {
        table.write(&mut writer).map_err(&failed)?;
    }
    writer.close().map_err(&failed)?;
    Ok(rows.exported(walk, sheet.finish()?))
}

type Writer<'a> = SerializedFileWriter<&'a mut std::io::BufWriter<rusty_contract::Replacement>>;

fn writer<'a>(
    sheet: &'a mut Sheet,
    table: &Table,
    header: &LogHeader,
) -> Result<Writer<'a>, ParquetError> {
    let pair = |name: &str, text: String| KeyValue::new(format!("rusty.{name}"), text);
    let config = &header.config;
    let metadata = vec![
        pair("scenario", config.scenario.clone()),
        pair("seed", config.seed.to_string()),
        pair("dt_s", format!("{:?}", config.dt_s)),
    ];
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(concat!("sim-server ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(metadata))
        // Measurements seldom repeat.
        .set_dictionary_enabled(false)
        .build();
    SerializedFileWriter::new(sheet.out(), table.schema()?, Arc::new(properties))
}

/// The kind of a column. Each may be null.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Whole,
    Number,
    List,
}

/// The cells of a column, and the levels that mark the null ones.
struct Column {
    name: String,
    kind: Kind,
    whole: Vec<i64>,
    numbers: Vec<f64>,
    definitions: Vec<i16>,
    repetitions: Vec<i16>,
}

impl Column {
    fn new(kind: Kind, name: String) -> Self {
        let (definitions, repetitions) = (Vec::new(), Vec::new());
        Self { name, kind, whole: Vec::new(), numbers: Vec::new(), definitions, repetitions }
    }

    fn schema(&self) -> Result<TypePtr, ParquetError> {
        let physical = if self.kind == Kind::Whole { Physical::INT64 } else { Physical::DOUBLE };
        if self.kind != Kind::List {
            let cell = Type::primitive_type_builder(&self.name, physical);
            return Ok(Arc::new(cell.with_repetition(Repetition::OPTIONAL).build()?));
        }
        // As every reader expects a list:
        // https://github.com/apache/parquet-format/blob/master/LogicalTypes.md#lists
        let element = Type::primitive_type_builder("element", physical)
            .with_repetition(Repetition::REQUIRED)
            .build()?;
        let repeated = Type::group_type_builder("list")
            .with_repetition(Repetition::REPEATED)
            .with_fields(vec![Arc::new(element)])
            .build()?;
        let list = Type::group_type_builder(&self.name)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(Some(LogicalType::List))
            .with_fields(vec![Arc::new(repeated)]);
        Ok(Arc::new(list.build()?))
    }

    fn push_list(&mut self, list: Option<impl Iterator<Item = f64>>) {
        let (before, defined) = (self.numbers.len(), i16::from(list.is_some()));
        self.numbers.extend(list.into_iter().flatten());
        let count = self.numbers.len() - before;
        // One level for a list that is null (0) or empty (1), else one for each element.
        self.definitions.extend(std::iter::repeat_n(defined + i16::from(count > 0), count.max(1)));
        self.repetitions.extend((0..count.max(1)).map(|k| i16::from(k > 0)));
    }

    fn write<W: std::io::Write + Send>(
        &mut self,
        group: &mut SerializedRowGroupWriter<'_, W>,
    ) -> Result<(), ParquetError> {
        let repetitions = (self.kind == Kind::List).then_some(&self.repetitions[..]);
        match self.kind {
            Kind::Whole => put::<Int64Type, _>(group, &self.whole, &self.definitions, repetitions)?,
            _ => put::<DoubleType, _>(group, &self.numbers, &self.definitions, repetitions)?,
        }
        self.whole.clear();
        self.numbers.clear();
        self.definitions.clear();
        self.repetitions.clear();
        Ok(())
    }
}

fn put<T: DataType, W: std::io::Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[T::T],
    definitions: &[i16],
    repetitions: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let missing = || ParquetError::General("the schema has fewer columns".to_owned());
    let mut column = group.next_column()?.ok_or_else(missing)?;
    column.typed::<T>().write_batch(values, Some(definitions), repetitions)?;
    column.close()
}

/// A group of rows, which are filled from left to right.
struct Table {
    columns: Vec<Column>,
    next: usize,
    sensors: Sensors,
}

impl Table {
    fn of(header: &LogHeader, names: &[String]) -> Self {
        let sensors = &header.config.sensors;
        let numbers = |parts: &[&str], of: &str| -> Vec<(Kind, String)> {
            parts.iter().map(|part| (Kind::Number, format!("{of}.{part}"))).collect()
        };
        let one = |kind, name: &str| (kind, name.to_owned());
        let mut columns = vec![
            one(Kind::Whole, "tick"),
            one(Kind::Number, "time_s"),
            one(Kind::Whole, "left_ticks"),
            one(Kind::Whole, "right_ticks"),
            one(Kind::Number, "v_m_s"),
            one(Kind::Number, "omega_rad_s"),
        ];
        columns.extend(numbers(&POSE, "truth"));
        for name in names {
            // The truth's columns are called so already.
            let owner = if name == "truth" { "truth.estimate" } else { name };
            columns.extend(numbers(&POSE, owner).into_iter().chain(numbers(&VARIANCES, owner)));
        }
        columns.push(one(Kind::List, "ranges_m"));
        columns.extend(sensors.bumper.iter().map(|_| one(Kind::Whole, "bumper")));
        columns.extend(sensors.imu.iter().flat_map(|_| numbers(&IMU, "imu")));
        columns.extend(sensors.sonar.iter().map(|_| one(Kind::List, "sonar_m")));
        columns.extend(sensors.doors.iter().map(|_| one(Kind::List, "doors")));
        let landmarks = sensors.landmarks.iter().flat_map(|_| LANDMARKS);
        columns.extend(landmarks.map(|part| (Kind::List, format!("landmarks.{part}"))));
        let columns = columns.into_iter().map(|(kind, name)| Column::new(kind, name)).collect();
        Self { columns, next: 0, sensors: sensors.clone() }
    }

    fn schema(&self) -> Result<TypePtr, ParquetError> {
        let fields: Result<Vec<_>, _> = self.columns.iter().map(Column::schema).collect();
        Ok(Arc::new(Type::group_type_builder("rusty_log").with_fields(fields?).build()?))
    }

    /// Rows that are complete.
    fn rows(&self) -> usize {
        self.columns[0].definitions.len()
    }

    fn column(&mut self) -> &mut Column {
        let at = self.next;
        self.next = (at + 1) % self.columns.len();
        &mut self.columns[at]
    }

    fn whole(&mut self, value: Option<i64>) {
        let column = self.column();
        column.whole.extend(value);
        column.definitions.push(i16::from(value.is_some()));
    }

    fn numbers<const N: usize>(&mut self, values: Option<[f64; N]>) {
        for k in 0..N {
            let column = self.column();
            column.numbers.extend(values.map(|values| values[k]));
            column.definitions.push(i16::from(values.is_some()));
        }
    }

    fn pose(&mut self, pose: Option<&SE2>) {
        self.numbers(pose.map(|p| [p.x(), p.y(), p.theta()]));
    }

    fn tick(&mut self, record: &TickRecord, dt_s: f64) {
        self.whole(Some(record.tick as i64));
        self.numbers(Some([record.time_s(dt_s)]));
        self.whole(Some(record.ticks.left));
        self.whole(Some(record.ticks.right));
        self.numbers(Some([record.command.v_m_s, record.command.omega_rad_s]));
        self.pose(truth(record).as_ref());
    }

    /// The scan, and what the small sensors say: the columns that are left.
    fn readings(&mut self, record: &TickRecord) {
        let readings = record.readings.get();
        let scan = record.ranges_m.as_deref();
        self.column().push_list(scan.map(|ranges| ranges.iter().copied()));
        if self.sensors.bumper.is_some() {
            self.whole(readings.bumper().map(i64::from));
        }
        if self.sensors.imu.is_some() {
            let read = readings.imu();
            self.numbers(read.map(|r| [r.yaw_rate_rad_s, r.accel_x_m_s2, r.accel_y_m_s2]));
        }
        if self.sensors.sonar.is_some() {
            self.column().push_list(readings.sonar_ranges_m().map(|r| r.iter().copied()));
        }
        if self.sensors.doors.is_some() {
            self.column().push_list(readings.doors().map(|r| r.iter().copied()));
        }
        if self.sensors.landmarks.is_some() {
            let seen = readings.landmarks();
            let id = |l: &LandmarkReading| l.id().map_or(-1.0, f64::from);
            self.column().push_list(seen.map(|seen| seen.iter().map(id)));
            self.column().push_list(seen.map(|seen| seen.iter().map(|l| l.range_m)));
            self.column().push_list(seen.map(|seen| seen.iter().map(|l| l.bearing_rad)));
        }
    }

    fn write<W: std::io::Write + Send>(
        &mut self,
        writer: &mut SerializedFileWriter<W>,
    ) -> Result<(), ParquetError> {
        let mut group = writer.next_row_group()?;
        self.columns.iter_mut().try_for_each(|column| column.write(&mut group))?;
        group.close().map(drop)
    }
}
