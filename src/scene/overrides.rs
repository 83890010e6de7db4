//! `--set key=value`: changes of a scene's text before it is read.

use super::error::SceneError;
use super::vehicle::templates;
use crate::settings::{SettingsError, did_you_mean};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike};

/// A change that was made.
pub(super) struct Override {
    /// Dotted, as on the command line.
    pub key: String,
    /// The scene's new text.
    pub text: String,
    pub made: Option<Made>,
}

/// An entry of a name that neither the scene nor its templates had: perhaps a slip of the pen.
pub(super) struct Made {
    /// Dotted key of the list, such as `vehicle.body`.
    list: String,
    name: String,
    /// Names that the list had.
    known: Vec<String>,
}

/// Tells a reader whose new entry is not complete what else the name may have meant.
pub(super) fn explain(mut error: SettingsError, made: &[Made]) -> SettingsError {
    let within = |made: &&Made| error.key.strip_prefix(made.list.as_str()).is_some_and(|rest| rest.starts_with('['));
    if let Some(Made { list, name, known }) = made.iter().find(within) {
        let names: Vec<&str> = known.iter().map(String::as_str).collect();
        let had = if names.is_empty() { "no names".into() } else { names.join(", ") };
        let meant = did_you_mean(name, &names);
        error.problem.push_str(&format!(" (\"{name}\" is a new entry that --set made{meant}; {list} had {had})"));
    }
    error
}

/// The first entry of the key that is named and not there yet.
fn find_made(document: &DocumentMut, key: &str) -> Option<Made> {
    let steps: Vec<&str> = key.split('.').collect();
    for (depth, step) in steps.iter().enumerate() {
        let Some((list, name)) = step.split_once('[').and_then(|(list, rest)| Some((list, rest.strip_suffix(']')?))) else { continue };
        if name.parse::<usize>().is_ok() {
            continue;
        }
        let known = known_names(document, &steps[..depth], list);
        if !known.iter().any(|known| known == name) {
            let path: Vec<&str> = steps[..depth].iter().copied().chain([list]).collect();
            return Some(Made { list: path.join("."), name: name.into(), known });
        }
    }
    None
}

/// Names in the list `list` of the table at `path`, in the scene and in the templates that it names.
fn known_names(document: &DocumentMut, path: &[&str], list: &str) -> Vec<String> {
    let mut names = names_at(document.as_table(), path, list);
    let below = |place: &[&str]| table_at(document.as_table(), place).and_then(|table| table.get("template")).and_then(Item::as_str);
    let modules = table_at(document.as_table(), &["vehicle", "module"]).into_iter().flat_map(|modules| modules.iter());
    let over = modules.filter_map(|module| module.1.as_table_like()?.get("template")?.as_str());
    let mut templates: Vec<(&str, &[&str])> = Vec::new();
    if let ["vehicle", rest @ ..] = path {
        // Modules of a template come along with a module that lies over it.
        let along = over.filter(|_| rest.first() == Some(&"module"));
        templates.extend(below(&["vehicle"]).into_iter().chain(along).map(|name| (name, rest)));
        if let ["module", module, rest @ ..] = rest {
            templates.extend(below(&["vehicle", "module", module]).map(|name| (name, rest)));
        }
    }
    for (name, path) in templates {
        let Ok(template) = templates::text(name).parse::<DocumentMut>() else { continue };
        names.extend(names_at(template.as_table(), path, list));
    }
    names.sort();
    names.dedup();
    names
}

fn table_at<'t>(table: &'t dyn TableLike, path: &[&str]) -> Option<&'t dyn TableLike> {
    path.iter().try_fold(table, |table, step| table.get(step)?.as_table_like())
}

fn names_at(table: &dyn TableLike, path: &[&str], list: &str) -> Vec<String> {
    let entries = table_at(table, path).and_then(|table| table.get(list)).and_then(Item::as_array_of_tables);
    entries.into_iter().flatten().filter_map(|entry| Some(entry.get("name")?.as_str()?.to_string())).collect()
}

/// Replaces one value in a scene's text, keeping comments.
///
/// # Errors
/// [`SceneError::Override`] for a key or value that can't be one.
pub(super) fn apply(text: &str, argument: &str) -> Result<Override, SceneError> {
    let refuse = |problem: String| SceneError::Override { argument: argument.into(), problem };
    let (key, value) = argument.split_once('=').ok_or_else(|| refuse("expected key=value, for example vehicle.speed=30".into()))?;
    let (key, value) = (key.trim(), value.trim());
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| refuse(format!("the scene can't be read: {error}")))?;
    let item: Item = match value.parse::<toml_edit::Value>() {
        Ok(value) => value.into(),
        // Words and quantities need no quotes on the command line.
        Err(_) => toml_edit::Value::from(value).into(),
    };
    let made = find_made(&document, key);
    let mut path: Vec<&str> = key.split('.').collect();
    let last = path.pop().filter(|last| !last.is_empty()).ok_or_else(|| refuse("the key is empty".into()))?;
    let mut table: &mut dyn TableLike = document.as_table_mut();
    for step in path {
        let (step, index) = match step.split_once('[') {
            Some((step, index)) => {
                let inner = index.strip_suffix(']').filter(|inner| !inner.is_empty());
                (step, Some(inner.ok_or_else(|| refuse(format!("\"[{index}\" is not a number or name in brackets")))?))
            }
            None => (step, None),
        };
        let number = index.and_then(|index| index.parse::<usize>().ok());
        let named = index.is_some() && number.is_none();
        let entry = table.entry(step).or_insert_with(|| match named {
            true => Item::ArrayOfTables(ArrayOfTables::new()),
            false => Item::Table(Table::new()),
        });
        table = match (index, entry) {
            (Some(index), Item::ArrayOfTables(tables)) => {
                let count = tables.len();
                entry_at(tables, index).ok_or_else(|| refuse(format!("{step} has {count} entries, counted from 1")))?
            }
            (Some(_), Item::Value(toml_edit::Value::Array(values))) => {
                let count = values.len();
                let place = number.and_then(|index| index.checked_sub(1));
                let value = place.and_then(|i| values.get_mut(i)).and_then(|value| value.as_inline_table_mut());
                value.ok_or_else(|| refuse(format!("{step} has {count} entries, counted from 1")))?
            }
            (None, entry) if entry.is_table_like() => entry.as_table_like_mut().ok_or_else(|| refuse(format!("{step} is not a table")))?,
            _ => return Err(refuse(format!("{step} is not a table of that kind"))),
        };
    }
    match (table.get_mut(last), item) {
        // A word stays one, whatever it looks like (60e1 is a rail, not 600); quantities may be numbers in quotes.
        (Some(Item::Value(toml_edit::Value::String(old))), Item::Value(toml_edit::Value::Integer(_) | toml_edit::Value::Float(_))) => {
            let mut new = toml_edit::Formatted::new(value.to_string());
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        // Keep the old value's surroundings (spaces, comments).
        (Some(Item::Value(old)), Item::Value(mut new)) => {
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        (_, item) => {
            table.insert(last, item);
        }
    }
    Ok(Override { key: key.to_string(), text: document.to_string(), made })
}

/// The table of that number, counted from 1, or of that `name`; one of an unknown name is made, to change what a template says.
fn entry_at<'t>(tables: &'t mut ArrayOfTables, index: &str) -> Option<&'t mut dyn TableLike> {
    let place = match index.parse::<usize>() {
        Ok(number) => number.checked_sub(1)?,
        Err(_) => tables.iter().position(|table| table.get("name").and_then(Item::as_str) == Some(index)).unwrap_or(tables.len()),
    };
    if place == tables.len() && index.parse::<usize>().is_err() {
        let mut table = Table::new();
        table.insert("name", toml_edit::value(index));
        tables.push(table);
    }
    tables.get_mut(place).map(|table| table as &mut dyn TableLike)
}
