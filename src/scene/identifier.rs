//! A file's name as a model identifier, which C and XML must accept.
//!
//! Letters a to z and digits stay. Latin letters with marks become what they are written as where marks can't be had: the German ones \u{e4}, \u{f6}, \u{fc},
//! \u{df} (and the Nordic \u{e6}, \u{f8}, \u{e5}) become ae, oe, ue, ss (ae, oe, aa), all others lose their marks. What is left becomes `_`, several in a row one, and
//! none at the ends of the name but those that stand there. A name that does not begin with a letter gets `scene_` before it.

use std::path::Path;

/// Letters that become two.
const PAIRS: &[(char, &str)] = &[
    ('\u{e4}', "ae"),
    ('\u{f6}', "oe"),
    ('\u{fc}', "ue"),
    ('\u{c4}', "Ae"),
    ('\u{d6}', "Oe"),
    ('\u{dc}', "Ue"),
    ('\u{df}', "ss"),
    ('\u{1e9e}', "SS"),
    ('\u{e6}', "ae"),
    ('\u{c6}', "Ae"),
    ('\u{153}', "oe"),
    ('\u{152}', "Oe"),
    ('\u{f8}', "oe"),
    ('\u{d8}', "Oe"),
    ('\u{e5}', "aa"),
    ('\u{c5}', "Aa"),
    ('\u{fe}', "th"),
    ('\u{de}', "Th"),
];

/// Letters of Latin-1 and Latin Extended-A that lose their marks, small ones; capitals follow from them.
const PLAIN: &[(char, &str)] = &[
    ('a', "\u{e0}\u{e1}\u{e2}\u{e3}\u{101}\u{103}\u{105}"),
    ('c', "\u{e7}\u{107}\u{109}\u{10b}\u{10d}"),
    ('d', "\u{f0}\u{10f}\u{111}"),
    ('e', "\u{e8}\u{e9}\u{ea}\u{eb}\u{113}\u{115}\u{117}\u{119}\u{11b}"),
    ('g', "\u{11d}\u{11f}\u{121}\u{123}"),
    ('h', "\u{125}\u{127}"),
    ('i', "\u{ec}\u{ed}\u{ee}\u{ef}\u{129}\u{12b}\u{12d}\u{12f}\u{131}"),
    ('j', "\u{135}"),
    ('k', "\u{137}"),
    ('l', "\u{13a}\u{13c}\u{13e}\u{142}"),
    ('n', "\u{f1}\u{144}\u{146}\u{148}"),
    ('o', "\u{f2}\u{f3}\u{f4}\u{f5}\u{14d}\u{14f}\u{151}"),
    ('r', "\u{155}\u{157}\u{159}"),
    ('s', "\u{15b}\u{15d}\u{15f}\u{161}\u{219}"),
    ('t', "\u{163}\u{165}\u{167}\u{21b}"),
    ('u', "\u{f9}\u{fa}\u{fb}\u{169}\u{16b}\u{16d}\u{16f}\u{171}\u{173}"),
    ('w', "\u{175}"),
    ('y', "\u{fd}\u{ff}\u{177}"),
    ('z', "\u{17a}\u{17c}\u{17e}"),
];

/// Two dots above, and all marks that follow their letter (as some systems write file names).
const DIAERESIS: char = '\u{308}';
const MARKS: std::ops::RangeInclusive<char> = '\u{300}'..='\u{36f}';

/// The identifier of a scene file.
pub(super) fn identifier(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut name = String::new();
    // Is the last sign a _ that stands for something else?
    let mut filled = false;
    for c in stem.chars() {
        if MARKS.contains(&c) {
            if c == DIAERESIS && name.ends_with(['a', 'o', 'u', 'A', 'O', 'U']) {
                name.push('e');
            }
            continue;
        }
        match letter(c) {
            Some(text) => {
                name.push_str(&text);
                filled = false;
            }
            None if !name.is_empty() && !name.ends_with('_') => {
                name.push('_');
                filled = true;
            }
            None => {}
        }
    }
    if filled {
        name.pop();
    }
    match name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        true => name,
        false if name.is_empty() => "scene".into(),
        false => format!("scene_{name}"),
    }
}

fn letter(c: char) -> Option<String> {
    if c.is_ascii_alphanumeric() || c == '_' {
        return Some(c.into());
    }
    if let Some((_, pair)) = PAIRS.iter().find(|pair| pair.0 == c) {
        return Some((*pair).into());
    }
    let small = c.to_lowercase().next().filter(|small| *small != c);
    let of = |c: char| PLAIN.iter().find(|line| line.1.contains(c)).map(|line| line.0);
    match small {
        Some(small) => of(small).map(|plain| plain.to_ascii_uppercase().into()),
        None => of(c).map(String::from),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_names_of_files_stay_legible() {
        let cases = [
            ("my_scene.toml", "my_scene"),
            ("\u{dc}bung.toml", "Uebung"),
            ("U\u{308}bung.toml", "Uebung"),
            ("Stra\u{df}e \u{d6}BB.toml", "Strasse_OeBB"),
            ("\u{e9}t\u{e9} \u{e0} Orl\u{e9}ans.toml", "ete_a_Orleans"),
            ("e\u{301}te\u{301}.toml", "ete"),
            ("\u{141}\u{f3}d\u{17a}.toml", "Lodz"),
            ("\u{10c}esk\u{e9} dr\u{e1}hy.toml", "Ceske_drahy"),
            ("K\u{f8}benhavn.toml", "Koebenhavn"),
            ("a-b (2).toml", "a_b_2"),
            ("3 coaches.toml", "scene_3_coaches"),
            ("\u{8eca}\u{8f2a}.toml", "scene"),
            ("\u{8eca}2.toml", "scene_2"),
        ];
        for (file, name) in cases {
            assert_eq!(identifier(Path::new(file)), name, "{file}");
        }
    }
}
