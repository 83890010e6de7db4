//! Resource locations: `file:` URIs to paths.

use percent_encoding::percent_decode_str;
use std::path::PathBuf;

/// The path behind a `file:/...`, `file:///...` or `file://localhost/...` URI, percent-decoded.
///
/// # Errors
/// A sentence that says what is wrong with the URI.
pub fn path(uri: &str) -> Result<PathBuf, String> {
    let lower = uri.get(..5).map(str::to_ascii_lowercase);
    let rest = match lower.as_deref() {
        Some("file:") => &uri[5..],
        _ => return Err(format!("the resource location \"{uri}\" is not a file: URI")),
    };
    let rest = match rest.strip_prefix("//") {
        Some(authority) => match authority.find('/') {
            Some(0) => authority,
            Some(end) if authority[..end].eq_ignore_ascii_case("localhost") => &authority[end..],
            _ => return Err(format!("the resource location \"{uri}\" names another host")),
        },
        None => rest,
    };
    if !rest.starts_with('/') {
        return Err(format!("the resource location \"{uri}\" is not an absolute path"));
    }
    let decoded = percent_decode_str(rest).decode_utf8().map_err(|_| format!("the resource location \"{uri}\" is not UTF-8"))?;
    // "/C:/folder" on Windows
    let bytes = decoded.as_bytes();
    let drive = cfg!(windows) && bytes.len() > 2 && bytes[1].is_ascii_alphabetic() && bytes[2] == b':';
    Ok(PathBuf::from(if drive { &decoded[1..] } else { &decoded[..] }))
}

/// The `file:///` URI of an absolute path.
pub fn from_path(path: &std::path::Path) -> String {
    use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
    const KEEP: &AsciiSet = &NON_ALPHANUMERIC.remove(b'/').remove(b'-').remove(b'_').remove(b'.').remove(b'~').remove(b':');
    let text = path.to_string_lossy().replace('\\', "/");
    let slash = if text.starts_with('/') { "" } else { "/" };
    format!("file://{slash}{}", utf8_percent_encode(&text, KEEP))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn analytic_every_spelling_of_a_file_uri() {
        for uri in ["file:/a/b", "file:///a/b", "file://localhost/a/b", "FILE:///a/b"] {
            assert_eq!(path(uri).unwrap(), Path::new("/a/b"), "{uri}");
        }
        assert_eq!(path("file:///a%20b/%C3%A4%25%23").unwrap(), Path::new("/a b/\u{e4}%#"));
        assert_eq!(path("file:///a b").unwrap(), Path::new("/a b"), "a space that was not encoded");
        for bad in ["", "http://a/b", "/a/b", "file://other/a", "file:a", "file:///%ff"] {
            assert!(path(bad).is_err(), "{bad}");
        }
        let awkward = Path::new("/tmp/a b/\u{e4}%#/x");
        assert_eq!(path(&from_path(awkward)).unwrap(), awkward);
    }
}
