//! All that is wrong with a scene, told at once.
//!
//! A reader that collects faults goes on behind a number that can't be read with a stand-in, so that the keys behind it are looked at too. What
//! follows from a fault that is told already is left out: a second one at the same key, anything in a table that is missing, and a
//! remark on how keys go together where one of them is told.

use super::{Section, SettingsError, Source};
use std::rc::Rc;
use toml_edit::TableLike;

/// Faults so far.
#[derive(Debug, Default)]
pub(super) struct Faults {
    told: Vec<SettingsError>,
    /// Tables that could not be read to their end: which keys they know is not known.
    given_up: Vec<String>,
}

/// The table that a key stands in.
fn table(key: &str) -> &str {
    key.rsplit_once('.').map_or("", |(table, _)| table)
}

/// Is `key` that of `table` or of something in it?
fn within(key: &str, table: &str) -> bool {
    table.is_empty() || key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

impl Faults {
    /// A fault of one value.
    pub fn tell(&mut self, error: SettingsError) {
        let told = self.told.iter().any(|other| {
            other.key == error.key && other.file == error.file || error.key.len() > other.key.len() && within(&error.key, &other.key)
        });
        if !told {
            self.told.push(error);
        }
    }

    /// A fault that ended the reading of its table. Where something is told of that table already it may be no more than what follows.
    /// One without words ([`super::Section::stop`]) is no fault.
    pub fn give_up(&mut self, error: SettingsError) {
        if error.problem.is_empty() {
            return;
        }
        let place = table(&error.key).to_string();
        // At the top keys have nothing to do with each other's tables.
        let beside = |other: &SettingsError| if place.is_empty() { table(&other.key).is_empty() } else { within(&other.key, &place) };
        if !self.told.iter().any(beside) {
            self.tell(error);
        }
        self.given_up.push(place);
    }

    /// Could the table not be read to its end?
    pub fn gave_up(&self, table: &str) -> bool {
        self.given_up.iter().any(|place| place == table)
    }

    /// A key that nobody asked for; what it is probably meant for is then not missing.
    pub fn tell_unknown(&mut self, error: SettingsError, meant: Option<String>) {
        self.told.retain(|other| !(meant.as_ref() == Some(&other.key) && is_missing(other)));
        self.tell(error);
    }

    /// In the order of files and lines, what is missing last.
    pub fn sorted(&self) -> Vec<SettingsError> {
        let mut all = self.told.clone();
        let files: Vec<String> = all.iter().map(|error| error.file.clone()).collect();
        let number = |file: &str| files.iter().position(|other| other == file);
        all.sort_by_key(|error| (is_missing(error), number(&error.file), error.line));
        all
    }
}

fn is_missing(error: &SettingsError) -> bool {
    error.problem.starts_with("is missing")
}

impl<'a> Section<'a> {
    /// The whole document, whose faults are collected: ask [`Section::faults`] before a value is used, it may be a stand-in.
    pub fn collecting(table: &'a dyn TableLike, source: &'a Source) -> Self {
        Section { faults: Some(Rc::default()), ..Section::root(table, source) }
    }

    /// Another document, whose faults are collected with those of `other`.
    pub fn beside(table: &'a dyn TableLike, source: &'a Source, other: &Section) -> Self {
        Section { faults: other.faults.clone(), ..Section::root(table, source) }
    }

    /// All faults that were collected so far, in the order of the file.
    pub fn faults(&self) -> Vec<SettingsError> {
        self.faults.as_ref().map(|faults| faults.borrow().sorted()).unwrap_or_default()
    }

    /// What a part of the scene was read to. `None` where it could not be: that is told among the faults.
    ///
    /// # Errors
    /// The part's, where faults are not collected.
    pub fn keep<T>(&self, read: Result<T, SettingsError>) -> Result<Option<T>, SettingsError> {
        match (read, &self.faults) {
            (Ok(value), _) => Ok(Some(value)),
            (Err(error), None) => Err(error),
            (Err(error), Some(faults)) => {
                faults.borrow_mut().give_up(error);
                Ok(None)
            }
        }
    }

    /// What a reader returns whose parts could not all be kept: nothing that is not told already.
    pub fn stop(&self) -> SettingsError {
        SettingsError { file: self.source.file.clone(), line: 0, key: self.path.clone(), problem: String::new() }
    }

    /// Goes on with a stand-in where faults are collected.
    pub(super) fn or_stand_in<T>(&self, error: SettingsError, stand_in: T) -> Result<T, SettingsError> {
        self.told(error).map_or_else(Err, |()| Ok(stand_in))
    }

    /// Tells a fault of one value; returns it where faults are not collected.
    pub(super) fn told(&self, error: SettingsError) -> Result<(), SettingsError> {
        let Some(faults) = &self.faults else { return Err(error) };
        faults.borrow_mut().tell(error);
        Ok(())
    }

    /// A fault of one value behind which its table can't be read on.
    pub(super) fn fatal(&self, error: SettingsError) -> SettingsError {
        if let Some(faults) = &self.faults {
            faults.borrow_mut().tell(error.clone());
        }
        error
    }
}
