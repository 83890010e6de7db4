//! A source file as the rules see it: without comments, without what stands in strings, and without its tests.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// One file of a folder of sources.
pub struct Source {
    /// Below `src/`.
    pub path: PathBuf,
    /// Its text as [`mask`] leaves it; lines and columns stay.
    pub code: String,
    /// The same with test items blanked too; empty where the whole file is a module of tests.
    pub production: String,
}

impl Source {
    /// Lines of production that hold code.
    pub fn lines(&self) -> usize {
        lines(&self.production)
    }

    /// Path of the module that the file is, from the crate's root; `None` for the programs' `main.rs`.
    pub fn module(&self) -> Option<Vec<String>> {
        let mut parts: Vec<String> =
            self.path.with_extension("").components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        match parts.last().map(String::as_str) {
            Some("mod" | "lib") => drop(parts.pop()),
            Some("main") => return None,
            _ => {}
        }
        Some(parts)
    }
}

/// Lines that hold more than white space.
pub fn lines(code: &str) -> usize {
    code.lines().filter(|line| !line.trim().is_empty()).count()
}

/// All files under `src/`.
pub fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&root, &mut files);
    files.sort();
    let mut sources: Vec<Source> = files
        .into_iter()
        .map(|file| {
            let code = mask(&std::fs::read_to_string(&file).unwrap());
            let production = without_tests(&code);
            Source { path: file.strip_prefix(&root).unwrap().to_path_buf(), code, production }
        })
        .collect();
    let tests: BTreeSet<PathBuf> = sources.iter().flat_map(test_files).collect();
    for source in &mut sources {
        let whole = source.code.contains("#![cfg(test)]")
            || tests.iter().any(|test| source.path.starts_with(test) || source.path == test.with_extension("rs"));
        if whole {
            source.production.clear();
        }
    }
    sources
}

pub fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// Modules of tests that stand in files of their own, named without ending.
fn test_files(source: &Source) -> Vec<PathBuf> {
    let folder = match source.path.file_name().and_then(|name| name.to_str()) {
        Some("mod.rs" | "lib.rs" | "main.rs") => source.path.parent().unwrap().to_path_buf(),
        _ => source.path.with_extension(""),
    };
    let items = test_items(&source.code);
    let text = items.iter().map(|item| &source.code[item.clone()]);
    text.filter_map(|item| item.strip_suffix(';')?.rsplit_once("mod ").map(|(_, name)| folder.join(name.trim()))).collect()
}

/// The text with comments blanked, and strings and characters overwritten with their quotes.
pub fn mask(text: &str) -> String {
    let mut masked = text.as_bytes().to_vec();
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        // Behind a letter `r`, `b` and `c` are the end of a name.
        let inside_word = at > 0 && is_word(text.as_bytes()[at - 1]) && !rest.starts_with('"');
        let (length, fill) = if rest.starts_with("//") {
            (rest.find('\n').unwrap_or(rest.len()), b' ')
        } else if rest.starts_with("/*") {
            (block_comment(rest), b' ')
        } else if let Some(length) = string(rest).filter(|_| !inside_word) {
            (length, b'"')
        } else {
            (if rest.starts_with('\'') { character(rest) } else { 0 }, b'\'')
        };
        fill_with(fill, &mut masked[at..at + length]);
        at += length.max(rest.chars().next().map_or(1, char::len_utf8));
    }
    String::from_utf8(masked).expect("whole characters are overwritten")
}

fn fill_with(fill: u8, bytes: &mut [u8]) {
    bytes.iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = fill);
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Length of the block comment that begins here; they nest.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        match text.as_bytes().get(at..at + 2) {
            Some(b"/*") => depth += 1,
            Some(b"*/") => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// Length of the string that begins here, with its prefix and marks; `None` where none begins.
fn string(text: &str) -> Option<usize> {
    let prefix = text.find(|c| !matches!(c, 'b' | 'c' | 'r'))?;
    let hashes = text[prefix..].find(|c| c != '#')?;
    let inside = prefix + hashes + 1;
    if prefix > 2 || !text[prefix + hashes..].starts_with('"') {
        return None;
    }
    if text[..prefix].contains('r') {
        let close = format!("\"{}", "#".repeat(hashes));
        return text[inside..].find(&close).map(|length| inside + length + close.len());
    }
    let mut escaped = false;
    let length = text[inside..].bytes().position(|byte| {
        let close = byte == b'"' && !escaped;
        escaped = byte == b'\\' && !escaped;
        close
    })?;
    (hashes == 0).then_some(inside + length + 1)
}

/// Length of the character that begins at this apostrophe; 0 for a lifetime.
fn character(text: &str) -> usize {
    let mut inner = text[1..].chars();
    match inner.next() {
        // What is escaped may be an apostrophe or several letters.
        Some('\\') => text.get(3..).and_then(|rest| rest.find('\'')).map_or(0, |length| 3 + length + 1),
        Some(c) if inner.next() == Some('\'') => c.len_utf8() + 2,
        _ => 0,
    }
}

/// The items of masked code that only tests have, from the attribute to the item's end.
fn test_items(code: &str) -> Vec<Range<usize>> {
    let attributes = ["#[cfg(test)]", "#[cfg(all(test", "#[test]"];
    attributes.iter().flat_map(|attribute| code.match_indices(attribute)).map(|(at, _)| at..item_end(code, at)).collect()
}

/// Code without its test items.
pub fn without_tests(code: &str) -> String {
    let mut bytes = code.as_bytes().to_vec();
    test_items(code).into_iter().for_each(|item| fill_with(b' ', &mut bytes[item]));
    String::from_utf8(bytes).expect("whole items are blanked")
}

/// End of the item whose first attribute begins at `at`.
fn item_end(code: &str, mut at: usize) -> usize {
    while code[at..].trim_start().starts_with("#[") {
        at += code[at..].find('[').unwrap_or_default();
        at += group(&code[at..]);
    }
    let words = code[at..].split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty());
    let mut words = words.skip_while(|word| matches!(*word, "pub" | "crate" | "super" | "in" | "unsafe" | "async"));
    let (keyword, next) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    // These end with their first braces; a `use`, a constant, a field or a statement may hold braces.
    let braced = matches!(keyword, "mod" | "fn" | "impl" | "struct" | "enum" | "trait")
        || (keyword == "const" && matches!(next, "fn" | "unsafe"))
        || code[at..].trim_start().starts_with('{');
    while at < code.len() {
        match code.as_bytes()[at] {
            open @ (b'{' | b'(' | b'[') => {
                at += group(&code[at..]);
                if braced && open == b'{' {
                    return at;
                }
                continue;
            }
            b';' => return at + 1,
            b',' if !braced => return at + 1,
            b'}' | b')' | b']' => return at,
            _ => at += 1,
        }
    }
    at
}

/// Length of the brackets that open here in masked code, with all that they hold.
pub fn group(code: &str) -> usize {
    let mut depth = 0;
    for (at, byte) in code.bytes().enumerate() {
        match byte {
            b'{' | b'(' | b'[' => depth += 1,
            b'}' | b')' | b']' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    code.len()
}

/// A function of masked code.
pub struct Function<'a> {
    pub name: &'a str,
    /// Its attributes and doc comments excluded.
    pub text: &'a str,
    /// What stands in its braces; empty where it has none.
    pub body: &'a str,
    /// Where it begins in the code.
    pub at: usize,
    /// Has the attribute `#[test]`, and `#[should_panic]`.
    pub is_test: bool,
    pub should_panic: bool,
}

/// All functions, those inside others too.
pub fn functions(code: &str) -> Vec<Function<'_>> {
    let begins = code.match_indices("fn ").map(|(at, _)| at).filter(|at| *at == 0 || !is_word(code.as_bytes()[at - 1]));
    begins
        .map(|begin| {
            let text = &code[begin..];
            let name = &text[3..3 + text[3..].find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or_default()];
            let mut at = 0;
            while at < text.len() && !matches!(text.as_bytes()[at], b'{' | b';') {
                at += if matches!(text.as_bytes()[at], b'(' | b'[') { group(&text[at..]) } else { 1 };
            }
            let end = at + if text[at..].starts_with('{') { group(&text[at..]) } else { 0 };
            let before = code[..begin].rsplit([';', '}', '{']).next().unwrap_or_default();
            let (is_test, should_panic) = (before.contains("#[test]"), before.contains("#[should_panic"));
            Function { name, text: &text[..end], body: &text[at..end], at: begin, is_test, should_panic }
        })
        .collect()
}
