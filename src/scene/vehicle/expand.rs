//! From modules that place each other to one flat list of entries with full names.

use super::SUSPENSION;
use crate::geometry::Side;
use crate::geometry::profile::{Part, ProfileChoice};
use crate::scene::profiles::read_profiles;
use crate::settings::{Section, SettingsError, did_you_mean};
use crate::units::Dimension;
use nalgebra::Vector3;
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// Where a module stands: names and positions in it are relative to this.
#[derive(Debug)]
pub(super) struct Scope {
    /// `truck[1].`, or nothing for the vehicle itself.
    pub prefix: String,
    /// Of the module's design frame in the vehicle's, m.
    pub offset: Vector3<f64>,
    pub parent: Option<usize>,
    /// Of wheels without profiles of their own: `wheel_profile`.
    wheel_profiles: Option<[ProfileChoice; 2]>,
}

/// One entry, or one side of a mirrored one.
pub(super) struct Entry<'a> {
    /// With prefix and side.
    pub name: String,
    pub scope: usize,
    /// Of an element between two copies of a module: where its `to` is.
    pub next: Option<usize>,
    /// The side of a mirrored entry; the right one has y turned.
    pub side: Option<Side>,
    pub section: Section<'a>,
}

/// Kinds of entries, in the order of [`Flat::entries`].
pub(super) const KINDS: [&str; 5] = ["body", "wheelset", "joint", "force", "sensor"];
pub(super) const BODY: usize = 0;
pub(super) const WHEELSET: usize = 1;
pub(super) const JOINT: usize = 2;
pub(super) const FORCE: usize = 3;
pub(super) const SENSOR: usize = 4;

/// Everything that a vehicle consists of.
pub(super) struct Flat<'a> {
    pub scopes: Vec<Scope>,
    pub entries: [Vec<Entry<'a>>; 5],
}

impl Flat<'_> {
    /// Profiles of wheels that stand in a module without profiles of their own: its own ones, or those of what surrounds it.
    pub fn wheel_profiles(&self, scope: usize) -> Option<&[ProfileChoice; 2]> {
        let scope = &self.scopes[scope];
        scope.wheel_profiles.as_ref().or_else(|| scope.parent.and_then(|parent| self.wheel_profiles(parent)))
    }
}

/// Modules within modules.
const DEEPEST: usize = 8;

/// Collects the entries of `vehicle` and of all modules that it places; `library` holds the templates that a module may lie over.
pub(super) fn expand<'a>(vehicle: &Section<'a>, library: &[(&'static str, Section<'a>)]) -> Result<Flat<'a>, SettingsError> {
    let mut modules = Vec::new();
    let known: Vec<&'static str> = library.iter().map(|template| template.0).collect();
    for (name, section) in vehicle.named_sections("module")? {
        if !section.has("template") {
            modules.push((name, section));
            continue;
        }
        let wanted = section.word("template", &known)?;
        let Some((_, base)) = library.iter().find(|template| template.0 == wanted) else { continue };
        // The template's own modules come along; what the scene calls by the same name goes before them.
        let inner = base.named_sections("module")?;
        modules.push((name, section.over(base.clone())));
        modules.extend(inner);
    }
    let mut seen = BTreeSet::new();
    modules.retain(|module| seen.insert(module.0.clone()));
    let mut expansion = Expansion {
        modules: &modules,
        placed: vec![false; modules.len()],
        names: BTreeSet::new(),
        flat: Flat { scopes: Vec::new(), entries: Default::default() },
    };
    expansion.collect(vehicle, (String::new(), Vector3::zeros(), None), 0)?;
    if let Some(idle) = expansion.placed.iter().position(|placed| !placed) {
        let problem = "is placed nowhere; expected a [[vehicle.place]] that names it, or no such module";
        return Err(modules[idle].1.error("", problem));
    }
    let mut flat = expansion.flat;
    for entries in &mut flat.entries {
        entries.sort_by(|a, b| natural(&a.name, &b.name));
    }
    Ok(flat)
}

struct Expansion<'m, 'a> {
    modules: &'m [(String, Section<'a>)],
    placed: Vec<bool>,
    /// Every name so far.
    names: BTreeSet<String>,
    flat: Flat<'a>,
}

impl<'a> Expansion<'_, 'a> {
    fn collect(
        &mut self,
        table: &Section<'a>,
        (prefix, offset, parent): (String, Vector3<f64>, Option<usize>),
        depth: usize,
    ) -> Result<(), SettingsError> {
        let keys = ["wheel_profile", "left_wheel_profile", "right_wheel_profile"];
        let wheel_profiles =
            if keys.iter().any(|key| table.has_table(key)) { Some(read_profiles(table, keys, Part::Wheel)?) } else { None };
        let number = self.flat.scopes.len();
        self.flat.scopes.push(Scope { prefix: prefix.clone(), offset, parent, wheel_profiles });
        let single = table.has_table(KINDS[WHEELSET]);
        if single {
            // One wheelset as a table of its own, with its springs.
            let section = table.section(KINDS[WHEELSET])?;
            let name = format!("{prefix}{}", if section.has("name") { read_name(&section)? } else { KINDS[WHEELSET].into() });
            self.add(WHEELSET, &name, (number, None), &section)?;
            if let Some(springs) = table.optional_section("suspension")? {
                self.add(FORCE, &format!("{name}{SUSPENSION}"), (number, None), &springs)?;
            }
        }
        for (kind, key) in KINDS.into_iter().enumerate().filter(|(kind, _)| !(single && *kind == WHEELSET)) {
            for section in table.sections(key)? {
                let name = read_name(&section)?;
                self.add(kind, &format!("{prefix}{name}"), (number, None), &section)?;
            }
        }
        for section in table.sections("place")? {
            let name = read_name(&section)?;
            let wanted = section.text("module")?;
            let Some(index) = self.modules.iter().position(|module| module.0 == wanted) else {
                let known: Vec<&str> = self.modules.iter().map(|module| module.0.as_str()).collect();
                let names = if known.is_empty() { "there is no [vehicle.module.NAME]".into() } else { known.join(", ") };
                let inside = if !prefix.is_empty() && table.has("module") {
                    format!("; modules stand beside each other, also where one places the other: [vehicle.module.{wanted}]")
                } else {
                    String::new()
                };
                let problem =
                    format!("found \"{wanted}\"{}, expected the name of a module: {names}{inside}", did_you_mean(&wanted, &known));
                return Err(section.error("module", problem));
            };
            if depth == DEEPEST {
                return Err(
                    section.error("module", format!("more than {DEEPEST} modules inside each other: does \"{wanted}\" place itself?"))
                );
            }
            let position: Vector3<f64> = section.triple("position", Dimension::Length)?.into();
            let copies = read_copies(&section, &name)?;
            let between = section.sections("between")?;
            section.finish()?;
            self.placed[index] = true;
            let mut before: Option<usize> = None;
            for (copy, (name, shift)) in copies.into_iter().enumerate() {
                let own = format!("{prefix}{name}");
                self.take(&own, table)?;
                let module = self.modules[index].1.clone();
                let scope = self.flat.scopes.len();
                self.collect(&module, (format!("{own}."), offset + position + shift, Some(number)), depth + 1)?;
                module.finish()?;
                if let Some(front) = before.replace(scope) {
                    for element in &between {
                        let name = read_name(element)?;
                        self.add(FORCE, &format!("{prefix}{name}[{copy}]"), (front, Some(scope)), element)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Notes an entry, or both of a mirrored one.
    fn add(&mut self, kind: usize, name: &str, (scope, next): (usize, Option<usize>), section: &Section<'a>) -> Result<(), SettingsError> {
        let mirrored = kind != WHEELSET && section.flag_or("mirrored", false)?;
        let sides: &[Option<Side>] = if mirrored { &[Some(Side::Left), Some(Side::Right)] } else { &[None] };
        for side in sides {
            let ending = side.map(|side| format!(".{}", side.name())).unwrap_or_default();
            let name = format!("{name}{ending}");
            self.take(&name, section)?;
            self.flat.entries[kind].push(Entry { name, scope, next, side: *side, section: section.clone() });
        }
        Ok(())
    }

    fn take(&mut self, name: &str, section: &Section) -> Result<(), SettingsError> {
        if self.names.insert(name.into()) {
            return Ok(());
        }
        Err(section.error("name", format!("\"{name}\" names something else already; expected a new name")))
    }
}

/// Most copies of a module.
const MOST_COPIES: f64 = 1000.0;

/// Name and shift [m] of each copy that an entry of `[[place]]` stands for: with `count` they are called `NAME[1]`, `NAME[2]` ...
/// and stand `spacing` apart.
fn read_copies(section: &Section, name: &str) -> Result<Vec<(String, Vector3<f64>)>, SettingsError> {
    if !section.has("count") {
        return match ["spacing", "between"].into_iter().find(|key| section.has(key)) {
            Some(key) => Err(section.error(key, "serves nothing without count, the number of copies")),
            None => Ok(vec![(name.into(), Vector3::zeros())]),
        };
    }
    let count = section.number("count", Dimension::None)?;
    if !(count.fract() == 0.0 && (1.0..=MOST_COPIES).contains(&count)) {
        return Err(section.error("count", format!("found {count:?}, expected a whole number from 1 to {MOST_COPIES}")));
    }
    if name.contains('[') {
        return Err(section.error("name", format!("found \"{name}\", expected no number: count makes the numbers from 1 on")));
    }
    let spacing: Vector3<f64> = section.triple("spacing", Dimension::Length)?.into();
    Ok((0..count as usize).map(|copy| (format!("{name}[{}]", copy + 1), spacing * copy as f64)).collect())
}

/// `frame`, `wheelset[2]`: letters, digits and _, a letter first, perhaps a number in brackets.
fn read_name(section: &Section) -> Result<String, SettingsError> {
    let name = section.text("name")?;
    let (word, number) = name.split_once('[').map_or((name.as_str(), None), |(word, rest)| (word, Some(rest)));
    let good = word.starts_with(|c: char| c.is_ascii_alphabetic())
        && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && number.is_none_or(|rest| rest.strip_suffix(']').is_some_and(|n| !n.is_empty() && n.chars().all(|c| c.is_ascii_digit())));
    if good {
        return Ok(name);
    }
    Err(section.error("name", format!("found \"{name}\", expected letters, digits and _, a letter first; a number in brackets may follow")))
}

/// Names in the order in which people count: `axle[2]` before `axle[10]`.
pub(super) fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.chars().peekable(), b.chars().peekable());
    loop {
        match (a.peek().copied(), b.peek().copied()) {
            (None, None) => return Ordering::Equal,
            (None, _) => return Ordering::Less,
            (_, None) => return Ordering::Greater,
            (Some(x), Some(y)) if x.is_ascii_digit() && y.is_ascii_digit() => {
                let order = number(&mut a).cmp(&number(&mut b));
                if order != Ordering::Equal {
                    return order;
                }
            }
            (Some(x), Some(y)) => {
                if x != y {
                    return x.cmp(&y);
                }
                a.next();
                b.next();
            }
        }
    }
}

/// Value and length of the digits that come next.
fn number(chars: &mut std::iter::Peekable<std::str::Chars>) -> (u128, usize) {
    let (mut value, mut length) = (0u128, 0);
    while let Some(digit) = chars.peek().and_then(|c| c.to_digit(10)) {
        value = value.saturating_mul(10).saturating_add(u128::from(digit));
        length += 1;
        chars.next();
    }
    (value, length)
}
