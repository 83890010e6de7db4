//! What tells libraries of one build from those of another.

/// Stands in every library of this build; `export` looks for it in the library's bytes.
pub const BUILD_MARK: &str = concat!("wheelrail-build-id:", env!("WHEELRAIL_BUILD_ID"), ":");
pub const MARK_PREFIX: &[u8] = b"wheelrail-build-id:";
