//! A creep law in one word with settings, `fastsim{strips=10, cells=10}`: what `[contact.creep]` would hold, for the command
//! line, tests and benchmarks. The settings are read by the scene's own reader.

use super::{Build, parse};
use crate::settings::{Section, SettingsError, Source};

/// Reads one law. `place` stands for the file name in messages.
///
/// # Errors
/// [`SettingsError`] for text that is no TOML, unknown laws and wrong settings.
pub fn law(text: &str, place: &str) -> Result<Build, SettingsError> {
    let unreadable = |why: &str| SettingsError {
        file: place.into(),
        line: 0,
        key: text.trim().into(),
        problem: format!("can't be read ({why}); expected NAME or NAME{{key=value, ...}}"),
    };
    let (name, settings) = match text.trim().split_once('{') {
        Some((name, rest)) => (name.trim(), rest.strip_suffix('}').ok_or_else(|| unreadable("the brace is not closed"))?),
        None => (text.trim(), ""),
    };
    let scene = format!("creep = {{ law = \"{name}\", {settings} }}\n");
    let source = Source { file: place.into(), text: scene, overridden: vec![], folder: None };
    let document = toml_edit::Document::parse(source.text.clone()).map_err(|error| unreadable(error.message()))?;
    let root = Section::root(document.as_table(), &source);
    let section = root.section("creep")?;
    let build = parse(&section)?;
    section.finish()?;
    Ok(build)
}

/// Splits a list at the commas that stand outside braces.
pub fn split(list: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, letter) in list.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(list[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(list[start..].trim());
    parts.retain(|part| !part.is_empty());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_laws_with_settings_and_clear_messages() {
        assert_eq!(split("polach{surface=\"wet\",friction_ratio=0.4}, fastsim"), ["polach{surface=\"wet\",friction_ratio=0.4}", "fastsim"]);
        assert!(law("fastsim{strips=10, cells=12}", "--law").is_ok() && law("kalker_linear", "--law").is_ok());
        let message = |text: &str| law(text, "--law").err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message("fastsm").contains("did you mean \"fastsim\""), "{}", message("fastsm"));
        assert!(message("fastsim{strip=3}").contains("did you mean \"strips\""), "{}", message("fastsim{strip=3}"));
        assert!(message("fastsim{strips=2.5}").contains("whole number"), "{}", message("fastsim{strips=2.5}"));
        assert!(message("fastsim{strips=}").contains("can't be read"), "{}", message("fastsim{strips=}"));
    }
}
