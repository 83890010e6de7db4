//! For the tests of profiles.

use super::Profile;
use crate::settings::{Section, Source};
use std::path::Path;

/// Calls `read` with the settings of `text`.
pub(super) fn with_section<T>(text: &str, read: impl FnOnce(&Section) -> T) -> T {
    in_folder(None, text, read)
}

/// Calls `read` with the settings of `text`, whose files are in `folder`.
pub(super) fn in_folder<T>(folder: Option<&Path>, text: &str, read: impl FnOnce(&Section) -> T) -> T {
    let source = Source { file: "t.toml".into(), text: text.into(), overridden: vec![], folder: folder.map(Path::to_path_buf) };
    let document = toml_edit::Document::parse(text.to_string()).unwrap();
    read(&Section::root(document.as_table(), &source))
}

/// Each derivative agrees with differences of the one before, away from the joints.
pub(super) fn check_derivatives(profile: &dyn Profile) {
    let (first, last) = profile.range();
    let joints = profile.joints();
    let h = 1e-8;
    for i in 0..1000 {
        let x = first + (last - first) * (f64::from(i) + 0.5) / 1000.0;
        if joints.iter().any(|joint| (joint - x).abs() < 2.0 * h) {
            continue;
        }
        let (p, ahead, behind) = (profile.at(x), profile.at(x + h), profile.at(x - h));
        // Rounding of the difference, and the term that the central difference leaves out, from the curvature's scale.
        let scale = 1.0 + p.d1 * p.d1;
        let near = |name: &str, found: f64, wanted: f64, tolerance: f64| {
            assert!((found - wanted).abs() < tolerance, "{name} at {x}: {found}, difference {wanted}");
        };
        near("d1", p.d1, (ahead.value - behind.value) / (2.0 * h), 3e-8 * scale);
        near("d2", p.d2, (ahead.d1 - behind.d1) / (2.0 * h), 1e-6 * scale * (1.0 + p.d2.abs()));
        near("d3", p.d3, (ahead.d2 - behind.d2) / (2.0 * h), 1e-5 * scale * (1.0 + p.d2.abs() + p.d3.abs()));
    }
    for (x, end) in [(first - 1e-3, first), (last + 1e-3, last)] {
        let (p, edge) = (profile.at(x), profile.at(end));
        assert!((p.value - edge.value - edge.d1 * (x - end)).abs() < 1e-12 && (p.d1 - edge.d1).abs() < 1e-9);
        assert!(profile.at(1e3 * x).value.is_finite());
    }
}
