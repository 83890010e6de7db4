//! The house's rules: a module uses only modules on lower floors (or its own), no modules in a circle, files and functions that can be read in
//! one sitting, no panics and no unsafe code outside their places, and no test that can't fail.

mod claims;
mod source;
mod uses;

use source::{Source, functions, lines, sources};
use std::collections::BTreeSet;
use uses::House;

/// Floor of each top-level module; modules of equal floor may not use each other unless listed in `SAME_FLOOR`.
const FLOORS: &[(&str, u32)] = &[
    ("math", 0),
    ("units", 0),
    ("settings", 0),
    ("geometry", 1),
    ("contact", 2),
    ("mbs", 3),
    ("formulation", 4),
    ("solve", 5),
    ("scene", 6),
    ("sim", 7),
    ("fmi", 8),
    ("study", 8),
    ("cli", 9),
];

/// Uses on one floor that are meant.
const SAME_FLOOR: &[(&str, &str)] = &[("settings", "units")];

/// Most lines of code of a file, its tests aside.
const MOST_IN_FILE: usize = 420;

/// Most lines of code of a function.
const MOST_IN_FUNCTION: usize = 80;

fn floor(module: &str) -> u32 {
    FLOORS.iter().find(|floor| floor.0 == module).unwrap_or_else(|| panic!("module {module} has no floor; add it to tests/architecture")).1
}

#[test]
fn prop_modules_use_only_lower_floors() {
    let mut uses = 0;
    for source in sources() {
        let Some(own) = source.module().and_then(|module| module.first().cloned()) else { continue };
        for path in uses::from_root(&source) {
            let Some(used) = path.first().filter(|used| **used != own) else { continue };
            uses += 1;
            let lower = floor(used) < floor(&own);
            let meant = SAME_FLOOR.contains(&(own.as_str(), used.as_str()));
            let file = source.path.display();
            assert!(lower || meant, "{file}: {own} (floor {}) uses {used} (floor {})", floor(&own), floor(used));
            // Integration knows only mathematics and settings.
            assert!(own != "solve" || floor(used) == 0, "{file}: solve uses {used}");
        }
    }
    assert!(uses > 50, "the test no longer sees the use lines");
}

#[test]
fn prop_no_modules_use_each_other_in_a_circle() {
    let found = House::new(&sources()).circles();
    assert!(found.is_empty(), "these modules use each other in a circle: {found:#?}");
}

#[test]
fn prop_files_stay_small_and_unsafe_stays_in_ffi() {
    for source in sources() {
        let (file, length) = (source.path.display(), source.lines());
        assert!(length <= MOST_IN_FILE, "{file} has {length} lines of code: which two ideas does it hold?");
        let in_ffi = source.path.components().any(|part| part.as_os_str() == "ffi");
        assert!(in_ffi || !source.production.contains("unsafe "), "{file}: unsafe outside fmi/ffi");
    }
}

#[test]
fn prop_functions_stay_short() {
    let sources = sources();
    let of = |source: &Source| {
        let long = functions(&source.production).into_iter().map(|function| (function.name.to_string(), lines(function.text)));
        long.filter(|(_, length)| *length > MOST_IN_FUNCTION)
            .map(|(name, length)| (source.path.display().to_string(), name, length))
            .collect::<Vec<_>>()
    };
    let long: Vec<(String, String, usize)> = sources.iter().flat_map(of).collect();
    assert!(long.is_empty(), "more than {MOST_IN_FUNCTION} lines of code: {long:?}");
    assert!(sources.iter().map(|source| functions(&source.production).len()).sum::<usize>() > 1000, "the test no longer sees functions");
}

#[test]
fn prop_no_unwrap_or_expect_outside_tests() {
    for source in sources() {
        for (number, line) in source.production.lines().enumerate() {
            let bare = [".unwrap()", ".expect(", "panic!(", "todo!("].iter().find(|word| line.contains(**word));
            assert!(bare.is_none(), "{}:{}: {line}", source.path.display(), number + 1);
        }
    }
}

#[test]
fn prop_no_test_goes_without_a_claim() {
    let empty = claims::tests_without_claim();
    assert!(empty.is_empty(), "these tests can't fail: {empty:#?}");
}

/// The rules see what stands behind a test, and nothing of tests, comments and strings.
#[test]
fn prop_rules_see_all_of_production_and_nothing_else() {
    let text = r##"
use crate::a::{b, c};
#[cfg(test)]
use crate::x::{y, z};
const BRACES: &str = "{ // \" }";
#[cfg(test)]
mod tests {
    const OPEN: char = '{'; /* } /* nested } */ */
    const LIFE: &'static str = r#"}"}"#;
    fn long() {}
}
fn behind<'a>(x: &'a str) -> char { '\'' }
struct S { #[cfg(test)] seen: usize, kept: usize }
fn last() { #[cfg(test)] { count(1); } done(); }
"##;
    let production = source::without_tests(&source::mask(text));
    let names: Vec<&str> = functions(&production).into_iter().map(|function| function.name).collect();
    assert_eq!(names, ["behind", "last"]);
    for (word, stays) in
        [("a::{b, c}", true), ("kept", true), ("done()", true), ("x::", false), ("nested", false), ("seen", false), ("count", false)]
    {
        assert_eq!(production.contains(word), stays, "{word} in {production}");
    }
    assert_eq!(production.lines().count(), text.lines().count());
    let paths: BTreeSet<String> = uses::paths(&production).iter().map(|path| path.join("::")).collect();
    assert_eq!(paths, BTreeSet::from(["crate::a::b".to_string(), "crate::a::c".to_string()]));
}

/// A circle is seen through re-exports, globs and other names; a module and its entries are none.
#[test]
fn prop_circles_are_seen() {
    let circles = |files: &[(&str, &str)]| {
        let source = |(path, text): &(&str, &str)| Source { path: path.into(), code: (*text).into(), production: (*text).into() };
        House::new(&files.iter().map(source).collect::<Vec<_>>()).circles()
    };
    let registry = (
        "room/mod.rs",
        "mod law; mod spring; pub use law::Law; pub use spring::*; pub trait Element {} const ALL: &[u8] = &[spring::ENTRY];",
    );
    let spring = ("room/spring.rs", "use super::{Element, Law}; pub const ENTRY: u8 = 0; pub struct Spring;");
    assert!(circles(&[registry, spring, ("room/law.rs", "pub struct Law;")]).is_empty());
    for law in [
        "use super::Spring; pub struct Law(Spring);",
        "pub struct Law(crate::room::spring::Spring);",
        "use super::spring as s; pub struct Law(s::Spring);",
    ] {
        let found = circles(&[registry, spring, ("room/law.rs", law)]);
        assert_eq!(found, BTreeSet::from([vec!["room::law".to_string(), "room::spring".to_string()]]), "{law}");
    }
}
