//! CSV files of users: separators, decimals, comments, titles with units, and in which line a record stands.

use crate::units::Dimension;
use csv::{Reader, ReaderBuilder, StringRecord, Trim};

/// A user's table: `#` begins a comment line; `;` or tabs separate where the header has them, and then decimals may follow a comma.
pub(crate) struct CsvText<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    decimal_comma: bool,
}

/// A line [1-based; 0: the file] and what is wrong there.
pub(crate) type Wrong = (usize, String);

/// A row below the header.
pub(crate) struct Row {
    pub line: usize,
    cells: StringRecord,
    decimal_comma: bool,
}

impl Row {
    pub(crate) fn cell(&self, column: usize) -> &str {
        self.cells.get(column).unwrap_or_default()
    }

    /// The number of a cell, which must be finite; the error quotes what stands there.
    pub(crate) fn number(&self, column: usize) -> Result<f64, String> {
        let cell = self.cell(column);
        let comma = self.decimal_comma && cell.matches(',').count() == 1 && !cell.contains('.');
        let value = if comma { cell.replace(',', ".").parse() } else { cell.parse::<f64>() };
        value.ok().filter(|value| value.is_finite()).ok_or_else(|| format!("found \"{cell}\", expected a finite number"))
    }
}

impl<'a> CsvText<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        let header = text.lines().find(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#')).unwrap_or_default();
        let delimiter = [b';', b'\t'].into_iter().find(|other| header.as_bytes().contains(other)).unwrap_or(b',');
        let reader =
            ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).flexible(true).delimiter(delimiter).from_reader(text.as_bytes());
        CsvText { text, reader, decimal_comma: delimiter != b',' }
    }

    /// The titles of the columns.
    pub(crate) fn header(&mut self) -> Result<StringRecord, Wrong> {
        self.reader.headers().cloned().map_err(|error| (1, error.to_string()))
    }

    /// The rows, each of so many cells.
    pub(crate) fn rows(&mut self, columns: usize) -> impl Iterator<Item = Result<Row, Wrong>> {
        let (text, decimal_comma) = (self.text, self.decimal_comma);
        self.reader.records().map(move |cells| {
            let cells = cells.map_err(|error| (error.position().map_or(0, |at| at.line() as usize), error.to_string()))?;
            let line = line_of(text, &cells);
            if cells.len() == columns {
                Ok(Row { line, cells, decimal_comma })
            } else {
                Err((line, format!("found {} columns, expected {columns}", cells.len())))
            }
        })
    }
}

/// Name of a column of lengths and its unit, m: `name [mm]`, metres without.
pub(crate) fn length_title(text: &str) -> Result<(&str, f64), String> {
    let Some((name, unit)) = text.split_once('[') else { return Ok((text.trim(), 1.0)) };
    let name = name.trim();
    let unit = unit.trim_end().strip_suffix(']').map(str::trim).filter(|unit| !unit.is_empty());
    let size = unit.and_then(|unit| Dimension::Length.parse(&format!("1 {unit}")));
    size.map(|size| (name, size)).ok_or_else(|| format!("found \"{text}\", expected a unit of length in brackets, such as \"{name} [mm]\""))
}

/// Name and unit of a column: `name [unit]`. Names may have brackets of their own, without a blank before them.
pub(crate) fn title(text: &str) -> (&str, Option<&str>) {
    match text.strip_suffix(']').and_then(|text| text.rsplit_once(" [")) {
        Some((name, unit)) => (name, Some(unit)),
        None => (text, None),
    }
}

/// 1-based line of a record of `text`; 0 where the reader told none. The reader's own is that of comments (`#`) and empty lines before the record, where there are some.
pub(crate) fn line_of(text: &str, record: &StringRecord) -> usize {
    let Some(position) = record.position() else { return 0 };
    let from = usize::try_from(position.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or_default();
    let skipped = from.lines().take_while(|line| line.trim().is_empty() || line.starts_with('#')).count();
    position.line() as usize + skipped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_decimals_follow_a_comma_where_it_does_not_separate() {
        let numbers = |text: &str| {
            let mut table = CsvText::new(text);
            let columns = table.header().unwrap().len();
            table.rows(columns).map(|row| row.unwrap()).flat_map(|row| [0, 1].map(|column| row.number(column).ok())).collect::<Vec<_>>()
        };
        let both = [Some(-1.5), Some(2e-3)];
        assert_eq!(numbers("u,radius\n-1.5, 2e-3\n"), both);
        assert_eq!(numbers("# , and ;\nu;radius\n-1,5;2e-3\n"), both);
        assert_eq!(numbers("u\tradius\r\n-1,5\t0,002\r\n"), both);
        assert_eq!(numbers("u;radius\n1.234,5;1,234,5\n"), [None, None]);
        assert_eq!(numbers("u;radius\nnan;inf\n"), [None, None]);
    }

    #[test]
    fn prop_lengths_in_titles_have_units() {
        assert_eq!(length_title("u"), Ok(("u", 1.0)));
        assert_eq!(length_title("u[in]"), Ok(("u", 0.0254)));
        assert_eq!(length_title("radius [ mm ]"), Ok(("radius", 1e-3)));
        assert!(length_title("u []").is_err() && length_title("u [kg]").is_err() && length_title("u [mm").is_err());
    }

    #[test]
    fn prop_brackets_of_names_are_no_units() {
        let torque = "truck[1].wheelset[1].driveTorque";
        assert_eq!(title(torque), (torque, None));
        assert_eq!(title("truck[1].wheelset[1].driveTorque [kN m]"), (torque, Some("kN m")));
        assert_eq!(title("cylinder[2]"), ("cylinder[2]", None));
    }

    #[test]
    fn regress_comments_and_empty_lines_are_counted() {
        let text = "# what\n\ntime,a\n# more\n\n0,1\n1,2\n\n# end\n2,3\n";
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let header = reader.headers().unwrap().clone();
        assert_eq!(line_of(text, &header), 3);
        let lines: Vec<usize> = reader.records().map(|record| line_of(text, &record.unwrap())).collect();
        assert_eq!(lines, [6, 7, 10]);
    }
}
