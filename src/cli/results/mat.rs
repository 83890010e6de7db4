//! MAT files of level 4, laid out as result files of Modelica tools are ("Atrajectory", 1.1, binTrans), so that their readers find outputs by full name and
//! MATLAB, Octave and scipy load the matrices. Own code: crates that are kept up read MAT files (`matfile`) and none writes them.
//!
//! Matrices: `Aclass`; `name` and `description` (unit in brackets), a text of each output in a column; `dataInfo`, four whole numbers of each
//! output in a column (matrix, row, linear interpolation, nothing known outside); `data_1` (begin and end of time) and `data_2` (a row per output, a column per time).
//! Format: MAT-File Format (MathWorks), level 4; Dymola User Manual, result files.

use super::{Table, Values};
use std::io::{Error, Write};

/// Kinds of numbers in a header of level 4, little endian.
const DOUBLE: i32 = 0;
const SINGLE: i32 = 10;
const WHOLE: i32 = 20;
const TEXT: i32 = 51;

/// Writes a table, whose first column must be the time.
///
/// # Errors
/// When `out` can't take it, or a matrix would be larger than the format can say.
pub(super) fn write<W: Write>(out: &mut W, table: &Table) -> std::io::Result<()> {
    let outputs = table.columns.len();
    let rows = table.columns.first().map_or(0, |column| column.len());
    // Text of which each row is stored column by column, as all matrices are.
    let class = ["Atrajectory", "1.1", "", "binTrans"];
    let letters: Vec<u8> = (0..11).flat_map(|place| class.map(|word| word.as_bytes().get(place).copied().unwrap_or(b' '))).collect();
    matrix(out, "Aclass", TEXT, [4, 11], &letters)?;
    texts(out, "name", table.columns.iter().map(|column| column.name.clone()).collect())?;
    texts(out, "description", table.columns.iter().map(|column| format!("[{}]", column.unit)).collect())?;
    let info: Vec<u8> =
        (0..outputs as i32).flat_map(|output| [if output == 0 { 0 } else { 2 }, output + 1, 0, -1]).flat_map(i32::to_le_bytes).collect();
    matrix(out, "dataInfo", WHOLE, [4, outputs], &info)?;
    let times = table.columns.first().filter(|_| rows > 0).map(|time| [time.at(0), time.at(rows - 1)]);
    let ends: Vec<u8> = times.into_iter().flatten().flat_map(f64::to_le_bytes).collect();
    matrix(out, "data_1", DOUBLE, [1, ends.len() / 8], &ends)?;
    // One matrix has one precision.
    let single = table.columns.iter().any(|column| matches!(column.values, Values::Single(_)));
    header(out, "data_2", if single { SINGLE } else { DOUBLE }, [outputs, rows])?;
    for row in 0..rows {
        for column in &table.columns {
            match &column.values {
                Values::Single(values) => out.write_all(&values[row].to_le_bytes())?,
                Values::Double(values) if single => out.write_all(&(values[row] as f32).to_le_bytes())?,
                Values::Double(values) => out.write_all(&values[row].to_le_bytes())?,
            }
        }
    }
    Ok(())
}

/// Texts as columns of equal length.
fn texts<W: Write>(out: &mut W, name: &str, texts: Vec<String>) -> std::io::Result<()> {
    let longest = texts.iter().map(String::len).max().unwrap_or(0);
    let letters: Vec<u8> = texts.iter().flat_map(|text| text.bytes().chain(std::iter::repeat(b' ')).take(longest)).collect();
    matrix(out, name, TEXT, [longest, texts.len()], &letters)
}

fn matrix<W: Write>(out: &mut W, name: &str, kind: i32, size: [usize; 2], data: &[u8]) -> std::io::Result<()> {
    header(out, name, kind, size)?;
    out.write_all(data)
}

fn header<W: Write>(out: &mut W, name: &str, kind: i32, size: [usize; 2]) -> std::io::Result<()> {
    // Readers take the number of values as a 32-bit number, too.
    let whole = |number: usize| {
        i32::try_from(number).map_err(|_| Error::other(format!("{name} is too large for a MAT file; choose fewer --columns or --every")))
    };
    whole(size[0] * size[1])?;
    for number in [kind, whole(size[0])?, whole(size[1])?, 0, name.len() as i32 + 1] {
        out.write_all(&number.to_le_bytes())?;
    }
    out.write_all(name.as_bytes())?;
    out.write_all(&[0])
}
