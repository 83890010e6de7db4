//! The licenses that go into every FMU are those of the crates that are locked.

use std::collections::BTreeSet;

/// Every crate of Cargo.lock, with its version, stands among those whose code the FMU's library holds, each with a license and its text, or among those that it does not hold.
#[test]
fn prop_the_licenses_are_those_of_the_locked_crates() {
    let lock = include_str!("../../Cargo.lock");
    let text = include_str!("../../fmu/licenses/third_party.txt");
    let mut locked = BTreeSet::new();
    let mut lines = lock.lines();
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("name = \"").and_then(|rest| rest.strip_suffix('"')) {
            let version = lines.next().and_then(|line| line.strip_prefix("version = \"")?.strip_suffix('"')).unwrap();
            if name != "wheelrail" {
                locked.insert(format!("{name} {version}"));
            }
        }
    }
    let (held, rest) = text.split_once("\n\n====").unwrap();
    let held: Vec<(&str, &str)> = held.lines().skip(3).map(|line| line.split_once(": ").unwrap_or_else(|| panic!("{line}"))).collect();
    assert!(held.len() > 50 && held.iter().all(|(_, license)| !license.is_empty()));
    let (texts, others) = rest.rsplit_once("--------\n").unwrap();
    for (name, _) in &held {
        assert!(texts.contains(name), "{name} has no license text");
    }
    let told: BTreeSet<String> = held.iter().map(|(name, _)| (*name).to_string()).chain(others.lines().map(String::from)).collect();
    let apart: Vec<&String> = told.symmetric_difference(&locked).collect();
    assert!(apart.is_empty(), "Cargo.lock and fmu/licenses/third_party.txt differ in {apart:?}: run docs/licenses.py");
    // What is linked is among what is held: the direct dependencies that are not optional.
    let manifest = include_str!("../../Cargo.toml");
    let direct = manifest.split("[dependencies]\n").nth(1).unwrap().split("\n[").next().unwrap();
    for line in direct.lines().filter(|line| !line.is_empty() && !line.contains("optional = true")) {
        let name = line.split(" =").next().unwrap();
        assert!(
            held.iter().any(|(held, _)| held.split(' ').next() == Some(name)),
            "{name} is not among the licenses: run docs/licenses.py"
        );
    }
}
