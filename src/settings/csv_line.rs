//! In which line of a CSV file a record stands.

use csv::StringRecord;

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
    fn regress_comments_and_empty_lines_are_counted() {
        let text = "# what\n\ntime,a\n# more\n\n0,1\n1,2\n\n# end\n2,3\n";
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let header = reader.headers().unwrap().clone();
        assert_eq!(line_of(text, &header), 3);
        let lines: Vec<usize> = reader.records().map(|record| line_of(text, &record.unwrap())).collect();
        assert_eq!(lines, [6, 7, 10]);
    }
}
