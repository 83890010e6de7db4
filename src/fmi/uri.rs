//! Resource locations: `file:` URIs to paths.

use percent_encoding::percent_decode_str;
use std::path::PathBuf;

/// The path that a resource location stands for: a `file:/...`, `file:///...` or `file://localhost/...` URI, percent-decoded, or a plain absolute
/// path, as it is. On Windows also `file://server/share/...` and the path `\\server\share\...`.
///
/// # Errors
/// A sentence that says what is wrong with the location, and what would be right.
pub fn path(location: &str) -> Result<PathBuf, String> {
    found(location, cfg!(windows)).map(PathBuf::from)
}

/// The same for one system or the other.
fn found(location: &str, windows: bool) -> Result<String, String> {
    if location.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("file:")) {
        return of_uri(location, windows);
    }
    if location.starts_with('/') || (windows && (has_drive(location) || location.starts_with('\\'))) {
        return Ok(location.to_string());
    }
    let what = if location.contains("://") { "is not a file: URI" } else { "is neither a file: URI nor an absolute path" };
    let example = if windows { "file:///C:/folder/resources" } else { "file:///folder/resources" };
    Err(format!("the resource location \"{location}\" {what}; expected one like \"{example}\""))
}

fn of_uri(uri: &str, windows: bool) -> Result<String, String> {
    let rest = &uri[5..];
    let (server, rest) = match rest.strip_prefix("//") {
        Some(authority) => authority.split_at(authority.find('/').unwrap_or(authority.len())),
        None => ("", rest),
    };
    let server = if server.eq_ignore_ascii_case("localhost") { "" } else { server };
    if !server.is_empty() && !windows {
        return Err(format!(
            "the resource location \"{uri}\" names the host \"{server}\", which has a meaning on Windows alone; mount its folder and name that: \"file:///...\""
        ));
    }
    if !rest.starts_with('/') || (!server.is_empty() && rest.len() == 1) {
        return Err(format!("the resource location \"{uri}\" is not an absolute path; expected \"file:///...\""));
    }
    let decoded = percent_decode_str(rest).decode_utf8().map_err(|_| format!("the resource location \"{uri}\" is not UTF-8"))?;
    if !server.is_empty() {
        return Ok(format!("//{server}{decoded}").replace('/', "\\"));
    }
    // "/C:/folder" on Windows
    Ok(if windows && has_drive(&decoded[1..]) { decoded[1..].to_string() } else { decoded.into_owned() })
}

fn has_drive(path: &str) -> bool {
    let bytes = path.as_bytes();
    bytes.len() > 1 && bytes[0].is_ascii_alphabetic() && bytes[1] == b':'
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
        for bad in ["", "http://a/b", "a/b", "file:a", "file:", "file://", "file://server", "file:///%ff", "\u{e4}/b"] {
            for windows in [false, true] {
                let message = found(bad, windows).unwrap_err();
                assert!(message.contains(bad) && message.contains("resource location"), "{message}");
            }
        }
        assert!(found("file://server/share/a", false).unwrap_err().contains("the host \"server\""));
        assert!(found("file://server/", true).is_err(), "no share");
        let awkward = Path::new("/tmp/a b/\u{e4}%#/x");
        assert_eq!(path(&from_path(awkward)).unwrap(), awkward);
    }

    #[test]
    fn analytic_plain_paths_and_windows_shares() {
        for (location, unix, windows) in [
            ("/a b/%20", Some("/a b/%20"), "/a b/%20"),
            ("C:\\a\\b", None, "C:\\a\\b"),
            ("c:/a%20b", None, "c:/a%20b"),
            ("\\\\server\\share\\a", None, "\\\\server\\share\\a"),
            ("file:///C:/a%20b", Some("/C:/a b"), "C:/a b"),
            ("file://server/share/a%20b", None, "\\\\server\\share\\a b"),
            ("file:////server/share", Some("//server/share"), "//server/share"),
        ] {
            assert_eq!(found(location, false).ok().as_deref(), unix, "{location}");
            assert_eq!(found(location, true).unwrap(), windows, "{location}");
        }
    }
}
