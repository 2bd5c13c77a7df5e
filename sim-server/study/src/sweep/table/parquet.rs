//! The table as Parquet, with its settings in the file's metadata.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::path::Path;
use std::sync::{Arc, Once};

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::Field;
use parquet::record::reader::RowIter;
use parquet::schema::types::Type;
use rusty_contract::input;

use super::columns::{Column, Values};
use super::texts::Texts;
use crate::sweep::settings::Settings;

/// What the names of our metadata begin with.
const PREFIX: &str = "rusty.";

/// The problem of a file on which the library panics.
const DAMAGED: &str = "its data is damaged";

/// The file's bytes: one row group, Snappy, every column as wide as it needs.
///
/// # Errors
/// The library's words.
pub(super) fn bytes(columns: &[Column], settings: &Settings) -> Result<Vec<u8>, String> {
    write(columns, settings).map_err(|e| e.to_string())
}

fn write(columns: &[Column], settings: &Settings) -> Result<Vec<u8>, ParquetError> {
    let fields: Result<Vec<_>, _> = columns.iter().map(field).collect();
    let schema = Type::group_type_builder("rusty_sweep").with_fields(fields?).build()?;
    let metadata =
        settings.parts().map(|(name, text)| KeyValue::new(format!("{PREFIX}{name}"), text));
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(concat!("sim-server ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(metadata.collect()))
        .set_max_row_group_row_count(None)
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        write_column(&mut group, &column.values)?;
    }
    group.close()?;
    writer.into_inner()
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let whole = || LogicalType::integer(64, false);
    let (physical, logical) = match &column.values {
        Values::Whole(_) | Values::Known(_) => (Physical::INT64, Some(whole())),
        Values::Signed(_) => (Physical::INT64, None),
        Values::Number(_) => (Physical::DOUBLE, None),
        Values::Flag(_) => (Physical::BOOLEAN, None),
        Values::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let optional = matches!(column.values, Values::Known(_));
    let repetition = if optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let builder = Type::primitive_type_builder(&column.name, physical);
    Ok(Arc::new(builder.with_repetition(repetition).with_logical_type(logical).build()?))
}

type Group<'a> = SerializedRowGroupWriter<'a, Vec<u8>>;

fn write_column(group: &mut Group<'_>, values: &Values) -> Result<(), ParquetError> {
    // Unsigned numbers are stored by their bits.
    let signed = |v: &u64| *v as i64;
    match values {
        Values::Whole(v) => {
            put::<Int64Type>(group, &v.iter().map(signed).collect::<Vec<_>>(), None)
        }
        Values::Known(v) => {
            let known: Vec<i64> = v.iter().flatten().map(signed).collect();
            let levels: Vec<i16> = v.iter().map(|v| i16::from(v.is_some())).collect();
            put::<Int64Type>(group, &known, Some(&levels))
        }
        Values::Signed(v) => put::<Int64Type>(group, v, None),
        Values::Number(v) => put::<DoubleType>(group, v, None),
        Values::Flag(v) => put::<BoolType>(group, v, None),
        Values::Text(v) => {
            let texts: Vec<ByteArray> = v.iter().map(|t| ByteArray::from(t.as_str())).collect();
            put::<ByteArrayType>(group, &texts, None)
        }
    }
}

fn put<T: DataType>(
    group: &mut Group<'_>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let missing = || ParquetError::General("the schema has fewer columns".to_owned());
    let mut column = group.next_column()?.ok_or_else(missing)?;
    column.typed::<T>().write_batch(values, levels, None)?;
    column.close()
}

/// Calls the library's reader. It panics on some damaged files: that becomes an
/// error, and the panic's message is not printed.
fn guarded<T>(read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    thread_local! {
        static QUIET: Cell<bool> = const { Cell::new(false) };
    }
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let print = take_hook();
        set_hook(Box::new(move |panic| {
            if !QUIET.get() {
                print(panic);
            }
        }));
    });
    QUIET.set(true);
    let read = catch_unwind(AssertUnwindSafe(read));
    QUIET.set(false);
    read.unwrap_or_else(|_| Err(DAMAGED.to_owned()))
}

/// The settings in the metadata of a file.
///
/// # Errors
/// The library's words, or that there are none.
pub(super) fn settings(path: &Path) -> Result<Settings, String> {
    guarded(|| read_settings(path))
}

fn read_settings(path: &Path) -> Result<Settings, String> {
    let file = input::open(path).map_err(|e| e.to_string())?;
    let reader = SerializedFileReader::new(file).map_err(|e| e.to_string())?;
    let metadata = reader.metadata().file_metadata().key_value_metadata();
    let parts = metadata.into_iter().flatten().filter_map(|pair| {
        Some((pair.key.strip_prefix(PREFIX)?, pair.value.as_deref().unwrap_or_default()))
    });
    let settings = Settings::from_parts(parts);
    let none = settings.parts().next().is_none();
    if none { Err("it has no metadata of ours".to_owned()) } else { Ok(settings) }
}

/// The names and rows of a file.
///
/// # Errors
/// The library's words.
pub(super) fn rows(path: &Path) -> Result<(Vec<String>, Texts), String> {
    let (names, mut rows) = guarded(|| read_rows(path))?;
    let mut is_damaged = false;
    let rows = std::iter::from_fn(move || {
        // After a panic the reader is not asked again.
        let row = guarded(|| if is_damaged { Ok(None) } else { rows.next().transpose() });
        is_damaged |= row.is_err();
        row.transpose()
    });
    Ok((names, Box::new(rows)))
}

fn read_rows(path: &Path) -> Result<(Vec<String>, Texts), String> {
    let words = |e: ParquetError| e.to_string();
    let file = input::open(path).map_err(|e| e.to_string())?;
    let reader = SerializedFileReader::new(file).map_err(words)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let names = schema.columns().iter().map(|c| c.name().to_owned()).collect();
    let rows = RowIter::from_file_into(Box::new(reader)).map(|row| {
        let fields = row.map_err(|e| e.to_string())?.into_columns();
        Ok(fields.into_iter().map(|(_, field)| text(&field)).collect())
    });
    Ok((names, Box::new(rows)))
}

/// A value as a CSV file has it.
fn text(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Double(v) => format!("{v:?}"),
        Field::Str(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    #[test]
    fn a_changed_byte_anywhere_gives_an_error_or_other_values() {
        let column = |name: &str, values| Column { name: name.to_owned(), values };
        let columns = [
            column("seed", Values::Whole((0..40).collect())),
            column("error_m", Values::Number((0..40).map(f64::from).collect())),
            column("flag", Values::Flag((0..40).map(|i| i % 3 == 0).collect())),
            column("blocked_ticks", Values::Known((0..40).map(|i| (i > 7).then_some(i)).collect())),
            column("estimator", Values::Text((0..40).map(|i| format!("name-{}", i % 2)).collect())),
        ];
        let settings = Settings::read(br#"{"seeds":"0..40"}"#).unwrap();
        let file = bytes(&columns, &settings).unwrap();
        let read = |path: &Path| -> Result<usize, String> {
            super::settings(path)?;
            rows(path)?.1.try_fold(0, |count, row| row.map(|_| count + 1))
        };
        let path = tempfile::NamedTempFile::new().unwrap();
        let mut panics = 0;
        for at in (0..file.len()).step_by(3) {
            for mask in [0x01, 0x80, 0xff] {
                let mut changed = file.clone();
                changed[at] ^= mask;
                std::fs::write(path.path(), &changed).unwrap();
                panics += usize::from(read(path.path()).is_err_and(|e| e == DAMAGED));
            }
        }
        assert!(panics > 0, "no byte makes the library panic: the guard is not needed");
    }

    #[test]
    fn what_is_written_reads_back_and_is_the_same_twice() {
        let text = |words: [&str; 2]| Values::Text(words.map(str::to_owned).to_vec());
        let column = |name: &str, values| Column { name: name.to_owned(), values };
        let columns = [
            column("seed", Values::Whole(vec![3, u64::MAX])),
            column("robot.slip_std", Values::Signed(vec![-1, 1])),
            column("error_m", Values::Number(vec![0.1 + 0.2, f64::NAN])),
            column("flag", Values::Flag(vec![true, false])),
            column("blocked_ticks", Values::Known(vec![None, Some(7)])),
            column("digest", text(["ab", "cé"])),
        ];
        let settings = Settings::read(br#"{"seeds":"3..5","cells":[{"ticks":300}]}"#).unwrap();
        let file = bytes(&columns, &settings).unwrap();
        assert_eq!(file, bytes(&columns, &settings).unwrap());

        let path = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(path.path(), &file).unwrap();
        assert_eq!(super::settings(path.path()).unwrap(), settings);
        let reader = SerializedFileReader::new(File::open(path.path()).unwrap()).unwrap();
        let rows: Vec<Vec<Field>> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| row.unwrap().into_columns().into_iter().map(|(_, field)| field).collect())
            .collect();
        let known = [
            Field::ULong(3),
            Field::Long(-1),
            Field::Double(0.1 + 0.2),
            Field::Bool(true),
            Field::Null,
            Field::Str("ab".to_owned()),
        ];
        assert_eq!(rows[0], known);
        assert_eq!(rows[1][0], Field::ULong(u64::MAX));
        assert!(matches!(rows[1][2], Field::Double(x) if x.is_nan()));
        assert_eq!(rows[1][4..], [Field::ULong(7), Field::Str("cé".to_owned())]);

        // The same as texts, as CSV has them.
        let (names, texts) = super::rows(path.path()).unwrap();
        assert_eq!(names[..3], ["seed", "robot.slip_std", "error_m"]);
        let texts: Vec<Vec<String>> = texts.map(Result::unwrap).collect();
        assert_eq!(texts[0], ["3", "-1", "0.30000000000000004", "true", "", "ab"]);
        assert_eq!(texts[1], ["18446744073709551615", "1", "NaN", "false", "7", "cé"]);
    }
}
