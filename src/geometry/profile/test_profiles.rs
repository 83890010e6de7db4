//! Profiles that tests name as scenes do.

use super::{Part, Profile, parse};
use crate::settings::{Section, Source};
use std::sync::Arc;

/// From the text of a profile table.
pub(crate) fn built_in(text: &str, part: Part) -> Arc<dyn Profile> {
    let source = Source { file: "t.toml".into(), text: text.into(), overridden: vec![], folder: None };
    let document = toml_edit::Document::parse(text.to_string()).unwrap();
    parse(Section::root(document.as_table(), &source), part).unwrap().profile
}
