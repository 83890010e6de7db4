//! Text for C.

use std::ffi::CString;

/// Text for the host; inner nulls cannot be shown.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}
