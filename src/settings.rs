//! Typed access to the tables of a scene file, with messages that name file, line, key, what was found and
//! what is allowed; and the shape of a registry entry, from which the scene reader, `wheelrail list` and the
//! docs all take the names that a scene may use.

mod constant;
mod csv_text;
mod defaults;
mod faults;
mod nearest;

use crate::units::Dimension;
pub(crate) use constant::constant;
pub use constant::{Constant, Number, Numbered};
pub(crate) use csv_text::{CsvText, length_title, line_of, title};
use faults::Faults;
pub use nearest::did_you_mean;
use nearest::{nearest, slip};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::LazyLock;
use toml_edit::{Item, Table, TableLike, Value};

/// A setting that cannot be used: where it stands, what was found and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}: {key}: {problem}", self.place())]
pub struct SettingsError {
    pub file: String,
    /// 1-based line in `file`; 0 when the key is absent and so has no line.
    pub line: usize,
    /// Dotted path of the key.
    pub key: String,
    pub problem: String,
}

impl SettingsError {
    fn place(&self) -> String {
        if self.line == 0 { self.file.clone() } else { format!("{}:{}", self.file, self.line) }
    }
}

/// The text that settings come from.
#[derive(Debug, Clone)]
pub struct Source {
    /// File name for messages.
    pub file: String,
    pub text: String,
    /// Keys that `--set` has replaced, for messages.
    pub overridden: Vec<String>,
    /// Folder that relative file names in the scene refer to; `None` for embedded scenes.
    pub folder: Option<PathBuf>,
}

impl Source {
    fn line(&self, span: Option<Range<usize>>) -> usize {
        span.map_or(0, |span| self.text.as_bytes()[..span.start.min(self.text.len())].iter().filter(|&&b| b == b'\n').count() + 1)
    }
}

/// One table of settings. Remembers which keys were asked for, so that [`Section::finish`] can refuse others.
#[derive(Clone)]
pub struct Section<'a> {
    table: &'a dyn TableLike,
    path: String,
    source: &'a Source,
    known: RefCell<BTreeSet<&'static str>>,
    span: Option<Range<usize>>,
    /// What stands for the keys that this table leaves out: the same table of a template.
    base: Option<Box<Section<'a>>>,
    /// Where faults are collected; `None`: the first one is returned.
    faults: Option<Rc<RefCell<Faults>>>,
    /// What is said where a key is missing: which entry of the template this one may have been meant to change.
    meant: Option<Rc<str>>,
}

/// What stands for a table that may be left out.
static EMPTY: LazyLock<Table> = LazyLock::new(Table::new);

impl<'a> Section<'a> {
    /// The whole document.
    pub fn root(table: &'a dyn TableLike, source: &'a Source) -> Self {
        Section { table, path: String::new(), source, known: RefCell::default(), span: None, base: None, faults: None, meant: None }
    }

    /// This table on top of another one, whose keys hold where this one is silent. Tables below are laid on each other in the
    /// same way, and entries of `[[key]]` on those with the same `name`; a table that says its own `kind` stands alone.
    pub fn over(self, base: Section<'a>) -> Self {
        let base = if self.table.contains_key("kind") { None } else { Some(Box::new(base)) };
        Section { base, ..self }
    }

    /// Dotted path of a key of this section.
    pub fn full_key(&self, key: &str) -> String {
        if self.path.is_empty() || key.is_empty() { format!("{}{key}", self.path) } else { format!("{}.{key}", self.path) }
    }

    fn find(&self, key: &'static str) -> Option<&'a Item> {
        let below = self.base.as_ref().and_then(|base| base.find(key));
        self.find_here(key).or(below)
    }

    /// Without the base.
    fn find_here(&self, key: &'static str) -> Option<&'a Item> {
        self.known.borrow_mut().insert(key);
        self.table.get(key).filter(|item| !item.is_none())
    }

    /// The text file that this section stands in, for opening files beside it.
    pub fn source(&self) -> &'a Source {
        self.source
    }

    /// An error at `key` of this section.
    pub fn error(&self, key: &str, problem: impl Into<String>) -> SettingsError {
        if let Some(base) = self.base.as_ref().filter(|base| !self.table.contains_key(key) && base.has_key(key)) {
            return base.error(key, problem);
        }
        let full = self.full_key(key);
        let span = self.table.get_key_value(key).and_then(|(name, item)| item.span().or(name.span())).or(self.span.clone());
        let mut problem = problem.into();
        let within = |set: &String| full.strip_prefix(set.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']));
        if self.source.overridden.iter().any(within) {
            problem.push_str(" (set on the command line)");
        }
        SettingsError { file: self.source.file.clone(), line: self.source.line(span), key: full, problem }
    }

    fn has_key(&self, key: &str) -> bool {
        self.table.contains_key(key) || self.base.as_ref().is_some_and(|base| base.has_key(key))
    }

    fn missing(&self, key: &str, expected: &str) -> SettingsError {
        let meant = self.meant.as_deref().unwrap_or_default();
        self.error(key, format!("is missing; expected {expected}{meant}"))
    }

    fn wrong(&self, key: &str, item: &Item, expected: &str) -> SettingsError {
        self.error(key, format!("found {}, expected {expected}", item.to_string().trim()))
    }

    /// The same of a key that decides how its table is read on: a key of a like name that nobody asked for yet may be a slip of the pen.
    fn missing_word(&self, key: &str, expected: &str) -> SettingsError {
        let others: Vec<&str> = self.table.iter().map(|(other, _)| other).filter(|other| !self.known.borrow().contains(other)).collect();
        let slip = slip(key, &others, &[]).map(|other| format!(" (there is \"{other}\")")).unwrap_or_default();
        self.error(key, format!("is missing{slip}; expected {expected}{}", self.meant.as_deref().unwrap_or_default()))
    }

    /// The same of a number: a unit may be written otherwise.
    fn wrong_number(&self, key: &str, item: &Item, dimension: Dimension, expected: &str) -> SettingsError {
        let texts = item.as_array().into_iter().flatten().chain(item.as_value()).filter_map(Value::as_str);
        let meant = texts.filter_map(|text| dimension.meant(text)).map(|meant| format!(" (did you mean \"{meant}\"?)")).next();
        self.error(key, format!("found {}{}, expected {expected}", item.to_string().trim(), meant.unwrap_or_default()))
    }

    /// Is `key` given?
    pub fn has(&self, key: &'static str) -> bool {
        self.find(key).is_some()
    }

    /// Is `key` given here, and not by a template alone?
    pub fn has_own(&self, key: &'static str) -> bool {
        self.has(key) && self.table.contains_key(key)
    }

    /// Is `key` given as a table?
    pub fn has_table(&self, key: &'static str) -> bool {
        self.find(key).is_some_and(|item| item.as_table_like().is_some())
    }

    /// A finite number in SI, `None` when absent.
    pub fn optional(&self, key: &'static str, dimension: Dimension) -> Result<Option<f64>, SettingsError> {
        let Some(item) = self.find(key) else { return Ok(None) };
        match item.as_value().and_then(|value| number(value, dimension)) {
            Some(value) => Ok(Some(value)),
            None => self.or_stand_in(self.wrong_number(key, item, dimension, &expected(item.as_value(), dimension)), None),
        }
    }

    /// A finite number in SI that must be given.
    pub fn number(&self, key: &'static str, dimension: Dimension) -> Result<f64, SettingsError> {
        match self.optional(key, dimension)? {
            Some(value) => Ok(value),
            // Where it is given but wrong that is told already.
            None => self.or_stand_in(self.missing(key, &dimension.expectation()), STAND_IN),
        }
    }

    /// A number in SI that must be given; `inf` and `"inf"` are allowed.
    pub fn number_or_infinity(&self, key: &'static str, dimension: Dimension) -> Result<f64, SettingsError> {
        let endless = match self.find(key).and_then(Item::as_value) {
            Some(Value::Float(value)) => value.value().is_infinite(),
            Some(Value::String(value)) => value.value() == "inf",
            _ => false,
        };
        if endless { Ok(f64::INFINITY) } else { self.number(key, dimension) }
    }

    /// A finite number in SI, or `default`.
    pub fn number_or(&self, key: &'static str, dimension: Dimension, default: f64) -> Result<f64, SettingsError> {
        Ok(self.optional(key, dimension)?.unwrap_or(default))
    }

    /// Refuses a number of any size beyond `largest` (SI) either way, and says why.
    pub fn refuse_beyond(&self, key: &'static str, dimension: Dimension, largest: f64, why: &str) -> Result<(), SettingsError> {
        match self.find(key).and_then(Item::as_value).and_then(|value| any_number(value, dimension)) {
            Some(value) if value.is_finite() && value.abs() > largest => {
                let unit = dimension.unit();
                self.told(self.error(key, format!("found {value:?}{unit}, expected at most {largest:?}{unit} either way: {why}")))
            }
            _ => Ok(()),
        }
    }

    /// Is `key` a number with a unit of its own?
    pub fn has_unit(&self, key: &'static str, dimension: Dimension) -> bool {
        self.find(key).and_then(Item::as_str).is_some_and(|text| dimension.has_unit(text))
    }

    /// A number greater than zero.
    pub fn positive(&self, key: &'static str, dimension: Dimension) -> Result<f64, SettingsError> {
        let value = self.number(key, dimension)?;
        if value > 0.0 {
            return Ok(value);
        }
        self.or_stand_in(self.error(key, format!("found {value:?}, expected a number greater than 0")), STAND_IN)
    }

    /// A number of at least `smallest`.
    pub fn at_least(&self, key: &'static str, dimension: Dimension, smallest: f64) -> Result<f64, SettingsError> {
        let value = self.number(key, dimension)?;
        if value >= smallest {
            return Ok(value);
        }
        self.or_stand_in(self.error(key, format!("found {value:?}, expected {smallest:?} or more")), smallest.max(STAND_IN))
    }

    /// A number between two bounds, or at one of them.
    pub fn within(&self, key: &'static str, dimension: Dimension, (least, greatest): (f64, f64)) -> Result<f64, SettingsError> {
        let value = self.number(key, dimension)?;
        if (least..=greatest).contains(&value) {
            return Ok(value);
        }
        let unit = dimension.unit();
        self.or_stand_in(
            self.error(key, format!("found {value:?}{unit}, expected {least:?}{unit} to {greatest:?}{unit}")),
            STAND_IN.clamp(least, greatest),
        )
    }

    /// A number of zero or more.
    pub fn not_negative(&self, key: &'static str, dimension: Dimension) -> Result<f64, SettingsError> {
        let value = self.number(key, dimension)?;
        if value >= 0.0 {
            return Ok(value);
        }
        self.or_stand_in(self.error(key, format!("found {value:?}, expected 0 or more")), STAND_IN)
    }

    /// Three finite numbers `[x, y, z]` in SI, `None` when absent.
    pub fn optional_triple(&self, key: &'static str, dimension: Dimension) -> Result<Option<[f64; 3]>, SettingsError> {
        if self.has(key) { self.triple_or(key, dimension, [0.0; 3]).map(Some) } else { Ok(None) }
    }

    /// Three finite numbers `[x, y, z]` in SI that must be given.
    pub fn triple(&self, key: &'static str, dimension: Dimension) -> Result<[f64; 3], SettingsError> {
        match self.optional_triple(key, dimension)? {
            Some(triple) => Ok(triple),
            None => self.or_stand_in(self.missing(key, &format!("a list of three, each {}", dimension.expectation())), [STAND_IN; 3]),
        }
    }

    /// Three finite numbers `[x, y, z]` in SI, or `default`.
    pub fn triple_or(&self, key: &'static str, dimension: Dimension, default: [f64; 3]) -> Result<[f64; 3], SettingsError> {
        let Some(item) = self.find(key) else { return Ok(default) };
        let numbers = item.as_array().and_then(|array| array.iter().map(|value| number(value, dimension)).collect::<Option<Vec<f64>>>());
        if let Some(triple) = numbers.and_then(|numbers| numbers.try_into().ok()) {
            return Ok(triple);
        }
        let values = item.as_array().into_iter().flatten();
        let expected = values.map(|value| expected(Some(value), dimension)).max_by_key(String::len);
        let expected = format!("a list of three, each {}", expected.unwrap_or_else(|| dimension.expectation()));
        self.or_stand_in(self.wrong_number(key, item, dimension, &expected), default)
    }

    /// Pairs of finite numbers `[[x, y], ...]` in SI.
    pub fn pairs(&self, key: &'static str, x: Dimension, y: Dimension) -> Result<Vec<[f64; 2]>, SettingsError> {
        let size = |of: Dimension| format!("{} (at most {:e})", of.expectation(), of.largest());
        let expected = || format!("a list of pairs [[x, y], ...], x {}, y {}", size(x), size(y));
        let item = self.find(key).ok_or_else(|| self.fatal(self.missing(key, &expected())))?;
        let pair = |value: &Value| {
            let pair = value.as_array().filter(|pair| pair.len() == 2)?;
            Some([number(pair.get(0)?, x)?, number(pair.get(1)?, y)?])
        };
        let pairs = item.as_array().and_then(|array| array.iter().map(pair).collect());
        pairs.ok_or_else(|| self.fatal(self.wrong(key, item, &expected())))
    }

    /// A string that must be given.
    pub fn text(&self, key: &'static str) -> Result<String, SettingsError> {
        let item = self.find(key).ok_or_else(|| self.missing_word(key, "a string"))?;
        item.as_str().map(str::to_owned).ok_or_else(|| self.wrong(key, item, "a string"))
    }

    /// A string, or `default`.
    pub fn text_or(&self, key: &'static str, default: &str) -> Result<String, SettingsError> {
        if self.has(key) { self.text(key) } else { Ok(default.into()) }
    }

    /// One word out of `allowed`.
    pub fn word(&self, key: &'static str, allowed: &[&'static str]) -> Result<&'static str, SettingsError> {
        let read = || {
            let item = self.find(key).ok_or_else(|| self.missing_word(key, &one_of(allowed)))?;
            let word = item.as_str().ok_or_else(|| self.wrong(key, item, &one_of(allowed)))?;
            self.match_word(key, word, allowed)
        };
        read().map_err(|error| self.fatal(error))
    }

    /// One word out of `allowed`, or `default`.
    pub fn word_or(&self, key: &'static str, allowed: &[&'static str], default: &'static str) -> Result<&'static str, SettingsError> {
        if self.has(key) { self.word(key, allowed) } else { Ok(default) }
    }

    fn match_word(&self, key: &str, word: &str, allowed: &[&'static str]) -> Result<&'static str, SettingsError> {
        allowed
            .iter()
            .find(|name| **name == word)
            .copied()
            .ok_or_else(|| self.error(key, format!("found \"{word}\"{}, expected {}", did_you_mean(word, allowed), one_of(allowed))))
    }

    /// A list of words out of `allowed`; all of them when the key is absent.
    pub fn words_or_all(&self, key: &'static str, allowed: &[&'static str]) -> Result<Vec<&'static str>, SettingsError> {
        let Some(item) = self.find(key) else { return Ok(allowed.to_vec()) };
        let expected = format!("a list of {}", one_of(allowed));
        let array = item.as_array().ok_or_else(|| self.wrong(key, item, &expected))?;
        let mut words = Vec::new();
        for value in array {
            let word = value.as_str().ok_or_else(|| self.wrong(key, item, &expected))?;
            match self.match_word(key, word, allowed) {
                Ok(word) => words.push(word),
                Err(error) => self.told(error)?,
            }
        }
        Ok(words)
    }

    /// A list of strings, `None` when absent.
    pub fn optional_texts(&self, key: &'static str) -> Result<Option<Vec<String>>, SettingsError> {
        let Some(item) = self.find(key) else { return Ok(None) };
        let texts = item.as_array().and_then(|array| array.iter().map(|value| value.as_str().map(str::to_owned)).collect());
        texts.map(Some).ok_or_else(|| self.wrong(key, item, "a list of strings"))
    }

    /// A Boolean, or `default`.
    pub fn flag_or(&self, key: &'static str, default: bool) -> Result<bool, SettingsError> {
        let Some(item) = self.find(key) else { return Ok(default) };
        match item.as_bool() {
            Some(flag) => Ok(flag),
            None => self.or_stand_in(self.wrong(key, item, "true or false"), default),
        }
    }

    /// A table below this one, `None` when absent.
    pub fn optional_section(&self, key: &'static str) -> Result<Option<Section<'a>>, SettingsError> {
        let base = self.base.as_ref().map(|base| base.optional_section(key)).transpose()?.flatten();
        let Some(item) = self.find_here(key) else { return Ok(base) };
        let table = item.as_table_like().ok_or_else(|| self.wrong(key, item, "a table"))?;
        let own = self.child(key.to_string(), table, item.span());
        Ok(Some(match base {
            Some(base) => own.over(base),
            None => own,
        }))
    }

    /// A table below this one that must be given.
    pub fn section(&self, key: &'static str) -> Result<Section<'a>, SettingsError> {
        self.optional_section(key)?.ok_or_else(|| self.fatal(self.missing_word(key, &format!("a table [{}]", self.full_key(key)))))
    }

    /// A table below this one; an empty one where it is left out.
    pub fn section_or_empty(&self, key: &'static str) -> Result<Section<'a>, SettingsError> {
        Ok(self.optional_section(key)?.unwrap_or_else(|| self.child(key.to_string(), &*EMPTY, None)))
    }

    /// The tables of `[[key]]`, or of `key = [{...}, ...]`; none when absent.
    pub fn sections(&self, key: &'static str) -> Result<Vec<Section<'a>>, SettingsError> {
        let own = self.sections_here(key)?;
        let Some(base) = &self.base else { return Ok(own) };
        let mut all = base.sections(key)?;
        let named = |section: &Section| section.table.get("name").and_then(Item::as_str).map(String::from);
        // Entries of one list don't change each other: two of one name are told as such by who reads the names.
        let below: Vec<Option<String>> = all.iter().map(named).collect();
        let mut taken = vec![false; below.len()];
        for mut section in own {
            let name = named(&section);
            let same = (0..below.len()).find(|place| name.is_some() && below[*place] == name && !taken[*place]);
            match same {
                Some(place) => {
                    taken[place] = true;
                    let lower = all.remove(place);
                    all.insert(place, section.over(lower));
                }
                None => {
                    let known: Vec<&str> = below.iter().flatten().map(String::as_str).collect();
                    section.meant = name.filter(|_| !known.is_empty()).map(|name| not_of_template(&name, &known).into());
                    all.push(section);
                }
            }
        }
        Ok(all)
    }

    /// The tables `[key.NAME]`, with their names; none when absent.
    pub fn named_sections(&self, key: &'static str) -> Result<Vec<(String, Section<'a>)>, SettingsError> {
        let mut all = self.base.as_ref().map(|base| base.named_sections(key)).transpose()?.unwrap_or_default();
        let Some(item) = self.find_here(key) else { return Ok(all) };
        let tables = item.as_table_like().ok_or_else(|| self.wrong(key, item, "a table of tables"))?;
        for (name, item) in tables.iter() {
            let table = item.as_table_like().ok_or_else(|| self.error(key, format!("{name} is no table")))?;
            let own = self.child(format!("{key}.{name}"), table, item.span());
            match all.iter().position(|other| other.0 == name) {
                Some(place) => {
                    let below = all.remove(place).1;
                    all.insert(place, (name.into(), own.over(below)));
                }
                None => all.push((name.into(), own)),
            }
        }
        Ok(all)
    }

    fn sections_here(&self, key: &'static str) -> Result<Vec<Section<'a>>, SettingsError> {
        match self.find_here(key) {
            None => Ok(Vec::new()),
            Some(Item::ArrayOfTables(tables)) => {
                Ok(tables.iter().enumerate().map(|(i, table)| self.child(format!("{key}[{}]", i + 1), table, table.span())).collect())
            }
            Some(Item::Value(Value::Array(values))) => values
                .iter()
                .enumerate()
                .map(|(i, value)| {
                    let table = value.as_inline_table().ok_or_else(|| self.error(key, "expected a list of tables"))?;
                    Ok(self.child(format!("{key}[{}]", i + 1), table, value.span()))
                })
                .collect(),
            Some(item) => Err(self.wrong(key, item, "a list of tables")),
        }
    }

    fn child(&self, name: String, table: &'a dyn TableLike, span: Option<Range<usize>>) -> Section<'a> {
        let faults = self.faults.clone();
        Section { table, path: self.full_key(&name), source: self.source, known: RefCell::default(), span, base: None, faults, meant: None }
    }

    /// Refuses keys that nobody asked for.
    pub fn finish(self) -> Result<(), SettingsError> {
        let known = self.known.borrow();
        let allowed: Vec<&str> = known.iter().copied().collect();
        // Of a table that was not read to its end not all keys are known: only slips of the pen are sure.
        let unread = self.faults.as_ref().is_some_and(|faults| faults.borrow().gave_up(&self.path));
        // A key that is absent is what was meant rather than one that is there and as near; with `--set` it may be the one that is there.
        let absent: Vec<&str> = allowed.iter().copied().filter(|known| !self.has_key(known)).collect();
        for (key, _) in self.table.iter().filter(|(key, _)| !known.contains(key)) {
            let meant = if unread {
                slip(key, &absent, &[])
            } else {
                slip(key, &allowed, &absent).or(nearest(key, &absent)).or(nearest(key, &allowed))
            };
            if unread && meant.is_none() {
                continue;
            }
            let hint = meant.map(|meant| format!(" (did you mean \"{meant}\"?)")).unwrap_or_default();
            let error = self.error(key, format!("unknown key{hint}; expected {}", one_of(&allowed)));
            match &self.faults {
                None => return Err(error),
                Some(faults) => faults.borrow_mut().tell_unknown(error, meant.map(|meant| self.full_key(meant))),
            }
        }
        drop(known);
        self.base.map_or(Ok(()), |base| base.finish())
    }
}

/// Stands for a number that can't be read.
const STAND_IN: f64 = 1.0;

/// A finite number in SI, with or without unit, of a size that makes sense.
fn number(value: &Value, dimension: Dimension) -> Option<f64> {
    any_number(value, dimension).filter(|number| number.abs() <= dimension.largest())
}

fn any_number(value: &Value, dimension: Dimension) -> Option<f64> {
    match value {
        Value::Float(value) => Some(*value.value()),
        Value::Integer(value) => Some(*value.value() as f64),
        Value::String(value) => dimension.parse(value.value()),
        _ => None,
    }
}

/// What should stand where `value` is no such number.
fn expected(value: Option<&Value>, dimension: Dimension) -> String {
    let limit = match value.and_then(|value| any_number(value, dimension)) {
        Some(number) if number.is_finite() => format!(", of at most {:e}{} either way", dimension.largest(), dimension.unit()),
        _ => String::new(),
    };
    format!("{}{limit}", dimension.expectation())
}

/// What is said of an entry that lacks a key and changes none of the template's.
fn not_of_template(name: &str, known: &[&str]) -> String {
    let some = known.iter().take(8).copied().collect::<Vec<_>>().join(", ");
    let more = if known.len() > 8 { ", ..." } else { "" };
    format!("; no entry of the template is called \"{name}\"{}: it has {some}{more}", did_you_mean(name, known))
}

fn one_of(words: &[&str]) -> String {
    match words {
        [] => "nothing here".into(),
        [only] => format!("\"{only}\""),
        _ => format!("one of \"{}\"", words.join("\", \"")),
    }
}

/// One thing that a scene can name: a law, a profile, an integrator ...
pub struct Entry<P: 'static> {
    pub name: &'static str,
    /// One line for `wheelrail list`.
    pub summary: &'static str,
    /// Where the method comes from.
    pub reference: &'static str,
    /// Reads the entry's own settings.
    pub parse: P,
}

/// The entry that `section.key` names.
pub fn choose<'r, P>(registry: &'r [Entry<P>], section: &Section, key: &'static str) -> Result<&'r Entry<P>, SettingsError> {
    let names: Vec<&'static str> = registry.iter().map(|entry| entry.name).collect();
    let name = section.word(key, &names)?;
    registry.iter().find(|entry| entry.name == name).ok_or_else(|| section.error(key, "is not in the registry"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> Source {
        Source { file: "a.toml".into(), text: text.into(), overridden: vec![], folder: None }
    }

    #[test]
    fn prop_messages_name_file_line_key_and_what_is_allowed() {
        let source = source("a = 1\n[b]\nmass = \"3 deg\"\nlenght = 2\nlaw = \"hertzz\"\nbad = nan\n");
        let document = toml_edit::Document::parse(source.text.clone()).unwrap();
        let root = Section::root(document.as_table(), &source);
        let b = root.section("b").unwrap();
        assert_eq!(
            b.number("mass", Dimension::Mass).unwrap_err().to_string(),
            "a.toml:3: b.mass: found \"3 deg\", expected a number in kg; a string may carry t, lb"
        );
        assert_eq!(
            b.word("law", &["hertz", "assumed"]).unwrap_err().to_string(),
            "a.toml:5: b.law: found \"hertzz\" (did you mean \"hertz\"?), expected one of \"hertz\", \"assumed\""
        );
        assert!(b.number("bad", Dimension::None).unwrap_err().to_string().starts_with("a.toml:6: b.bad: found nan"));
        assert_eq!(b.number("absent", Dimension::Length).unwrap_err().line, 2);
        assert_eq!(b.number("length", Dimension::Length).unwrap_err().key, "b.length");
        assert!(b.finish().unwrap_err().to_string().starts_with("a.toml:4: b.lenght: unknown key (did you mean \"length\"?)"));
        assert_eq!(root.finish().unwrap_err().line, 1);
    }
}
