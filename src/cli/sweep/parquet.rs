//! The table of a sweep as Parquet, beside the CSV in which it goes on: numbers as numbers, nothing where a run has none, units in the metadata.

use super::table::{Columns, Row};
use crate::cli::results::parquet::{Described, metadata, problem, properties};
use crate::study::variation::parameter::number;
use parquet::basic::{Encoding, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// A column with its unit.
struct Column {
    name: String,
    unit: String,
    values: Values,
}

enum Values {
    Whole(Vec<i64>),
    /// `None`: the run has no such number.
    Numbers(Vec<Option<f64>>),
    Words(Vec<String>),
}

/// `run`, the keys that vary, `state`, `time`, the scalars, `reason`.
fn columns(head: &Columns, rows: &[Row]) -> Vec<Column> {
    let words = |name: &str, of: &dyn Fn(&Row) -> String| {
        let values = Values::Words(rows.iter().map(of).collect());
        Column { name: name.into(), unit: String::new(), values }
    };
    let numbers = |name: &str, unit: &str, values| Column { name: name.into(), unit: unit.into(), values: Values::Numbers(values) };
    let keys = head.keys.iter().enumerate().map(|(at, (key, unit))| {
        let values: Vec<Option<f64>> = rows.iter().map(|row| number(&row.values[at]).map(|found| found.0)).collect();
        match unit {
            Some(unit) if values.iter().all(Option::is_some) => numbers(key, unit, values),
            _ => words(key, &|row| row.values[at].clone()),
        }
    });
    let scalars =
        head.scalars.iter().enumerate().map(|(at, (name, unit))| numbers(name, unit, rows.iter().map(|row| row.scalars[at]).collect()));
    let run = Column { name: "run".into(), unit: String::new(), values: Values::Whole(rows.iter().map(|row| row.run as i64).collect()) };
    let ends = [words("state", &|row| row.state.word().into()), numbers("time", "s", rows.iter().map(|row| row.time).collect())];
    let reason = words("reason", &|row| row.reason.clone());
    std::iter::once(run).chain(keys).chain(ends).chain(scalars).chain([reason]).collect()
}

/// Writes a table.
///
/// # Errors
/// When `out` can't take it.
pub(super) fn write<W: Write + Send>(out: &mut W, head: &Columns, rows: &[Row]) -> std::io::Result<()> {
    written(out, &columns(head, rows)).map_err(problem)
}

fn written<W: Write + Send>(out: &mut W, columns: &[Column]) -> Result<(), ParquetError> {
    let field = |Column { name, values, .. }: &Column| match values {
        Values::Whole(_) => Type::primitive_type_builder(name, PhysicalType::INT64).with_repetition(Repetition::REQUIRED).build(),
        Values::Numbers(_) => Type::primitive_type_builder(name, PhysicalType::DOUBLE).with_repetition(Repetition::OPTIONAL).build(),
        Values::Words(_) => Type::primitive_type_builder(name, PhysicalType::BYTE_ARRAY)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(Some(LogicalType::String))
            .build(),
    };
    let fields = columns.iter().map(|column| field(column).map(Arc::new)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("sweep").with_fields(fields).build()?;
    let kind = |values: &Values| match values {
        Values::Whole(_) => "int64",
        Values::Numbers(_) => "float64",
        Values::Words(_) => "unicode",
    };
    let described: Vec<Described> = columns.iter().map(|own| (own.name.as_str(), own.unit.as_str(), kind(&own.values))).collect();
    let properties = properties(metadata(&described), Encoding::PLAIN)?;
    let mut writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        let Some(mut place) = group.next_column()? else { break };
        match &column.values {
            Values::Whole(values) => place.typed::<Int64Type>().write_batch(values, None, None)?,
            Values::Numbers(values) => {
                let there: Vec<i16> = values.iter().map(|value| value.is_some().into()).collect();
                let values: Vec<f64> = values.iter().flatten().copied().collect();
                place.typed::<DoubleType>().write_batch(&values, Some(&there), None)?
            }
            Values::Words(values) => {
                let values: Vec<ByteArray> = values.iter().map(|text| ByteArray::from(text.as_str())).collect();
                place.typed::<ByteArrayType>().write_batch(&values, None, None)?
            }
        };
        place.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}
