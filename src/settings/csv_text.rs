//! CSV files of users: separators, comments, titles with units, and in which line a record stands.

use csv::{Reader, ReaderBuilder, StringRecord, Trim};

/// A reader of `text` with `#` for comment lines and `;` for the separator where the header has it.
pub(crate) fn csv_reader(text: &str) -> Reader<&[u8]> {
    let header = text.lines().find(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#')).unwrap_or_default();
    let delimiter = if header.contains(';') { b';' } else { b',' };
    ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).flexible(true).delimiter(delimiter).from_reader(text.as_bytes())
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
