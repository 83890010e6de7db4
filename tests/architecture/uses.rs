//! Which module uses which: the paths in a file, followed through re-exports to the file that defines what they name.

use crate::source::Source;
use std::collections::{BTreeMap, BTreeSet};

/// A module's path from the crate's root.
pub type Module = Vec<String>;

/// Names that a module brings in: (name, or `*`, and what it stands for).
type Bindings = Vec<(String, Module)>;

/// Modules, what they bring in and what they define.
pub struct House {
    modules: BTreeMap<Module, (Bindings, String)>,
}

impl House {
    pub fn new(sources: &[Source]) -> Self {
        let own = |source: &Source| source.module().filter(|_| !source.production.is_empty());
        let with_code: Vec<(Module, &Source)> = sources.iter().filter_map(|source| Some((own(source)?, source))).collect();
        let names: BTreeSet<&Module> = with_code.iter().map(|(module, _)| module).collect();
        let bindings = |module: &Module, code: &str| {
            let paths = uses(code).into_iter().filter_map(|(path, name)| Some((name, absolute(module, &path, &names)?)));
            paths.collect::<Bindings>()
        };
        let entry =
            |(module, source): &(Module, &Source)| (module.clone(), (bindings(module, &source.production), source.production.clone()));
        House { modules: with_code.iter().map(entry).collect() }
    }

    /// Modules that a module uses, itself and those that hold it excepted.
    pub fn used_by(&self, module: &Module) -> BTreeSet<Module> {
        let Some((bindings, code)) = self.modules.get(module) else { return BTreeSet::new() };
        let spelled = paths(code).into_iter().filter_map(|path| absolute(module, &path, &BTreeSet::new()));
        let named = bindings.iter().map(|(_, path)| path.clone());
        let owners = spelled.chain(named).filter_map(|path| self.owner(&path, 0));
        owners.filter(|owner| !module.starts_with(owner)).collect()
    }

    /// The module that defines what a path from the root names.
    fn owner(&self, path: &[String], depth: usize) -> Option<Module> {
        let mut at: Module = Vec::new();
        for (index, name) in path.iter().enumerate() {
            let mut below = at.clone();
            below.push(name.clone());
            if self.modules.contains_key(&below) {
                at = below;
                continue;
            }
            let (bindings, code) = self.modules.get(&at)?;
            if depth > 8 || defines(code, name) {
                return Some(at);
            }
            let rest = |target: &Module| target.iter().chain(&path[index + 1..]).cloned().collect::<Module>();
            if let Some((_, target)) = bindings.iter().find(|(bound, _)| bound == name) {
                return self.owner(&rest(target), depth + 1);
            }
            let globs = bindings.iter().filter(|(bound, _)| bound == "*").filter_map(|(_, target)| self.owner(target, depth + 1));
            let from_glob = globs.into_iter().find(|target| self.modules.get(target).is_some_and(|(_, code)| defines(code, name)));
            return Some(from_glob.unwrap_or(at));
        }
        Some(at)
    }

    /// Circles among the modules that stand side by side in one module, each with all that is below it: sets of them of which each uses, by
    /// way of the others, itself. A module and those below it may use each other, as a registry and its entries do.
    pub fn circles(&self) -> BTreeSet<Vec<String>> {
        let mut graphs: BTreeMap<Module, BTreeMap<Module, BTreeSet<Module>>> = BTreeMap::new();
        for module in self.modules.keys() {
            for used in self.used_by(module) {
                let common = module.iter().zip(&used).take_while(|(a, b)| a == b).count();
                // One that holds the other.
                if common == module.len() || common == used.len() {
                    continue;
                }
                let edges = graphs.entry(module[..common].to_vec()).or_default();
                edges.entry(module[..=common].to_vec()).or_default().insert(used[..=common].to_vec());
            }
        }
        graphs.values().flat_map(rings).map(|ring| ring.iter().map(|module| module.join("::")).collect()).collect()
    }
}

/// Strongly connected sets of more than one.
fn rings(edges: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<BTreeSet<Module>> {
    let reached = |from: &Module| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(next) = open.pop() {
            open.extend(edges.get(&next).into_iter().flatten().filter(|used| seen.insert((*used).clone())).cloned());
        }
        seen
    };
    let reach: BTreeMap<&Module, BTreeSet<Module>> = edges.keys().map(|module| (module, reached(module))).collect();
    let mutual =
        |a: &Module| reach[a].iter().filter(|b| reach.get(b).is_some_and(|back| back.contains(a))).cloned().collect::<BTreeSet<_>>();
    edges.keys().map(mutual).filter(|ring| ring.len() > 1).collect()
}

/// Whether a module's code defines a name at all.
fn defines(code: &str, name: &str) -> bool {
    let kinds = ["fn ", "struct ", "enum ", "trait ", "const ", "static ", "type ", "macro_rules! "];
    kinds.iter().any(|kind| {
        code.match_indices(&format!("{kind}{name}"))
            .any(|(at, found)| !code[at + found.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_'))
    })
}

/// A path as it stands in a module, from the crate's root; `None` for what another crate has.
fn absolute(module: &Module, path: &[String], modules: &BTreeSet<&Module>) -> Option<Module> {
    let supers = path.iter().take_while(|part| *part == "super").count();
    match path.first()?.as_str() {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some(module.iter().chain(&path[1..]).cloned().collect()),
        "super" => Some(module[..module.len().checked_sub(supers)?].iter().chain(&path[supers..]).cloned().collect()),
        below => {
            let mut child = module.clone();
            child.push(below.to_string());
            modules.contains(&child).then(|| module.iter().chain(path).cloned().collect())
        }
    }
}

/// The paths that a file spells from the crate's root, and those of its production that leave a module upward.
pub fn from_root(source: &Source) -> Vec<Module> {
    let module = source.module().unwrap_or_default();
    let all = paths(&source.code).into_iter().filter(|path| path[0] == "crate").chain(paths(&source.production));
    all.filter_map(|path| absolute(&module, &path, &BTreeSet::new())).collect()
}

/// All paths of masked code that begin with `crate`, `self` or `super`.
pub fn paths(code: &str) -> Vec<Vec<String>> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let mut all = Vec::new();
    for root in ["crate::", "super::", "self::"] {
        for (at, _) in code.match_indices(root) {
            if !code[..at].ends_with(|c: char| word(c) || c == ':' || c == '$') {
                all.extend(tree(&code[at..]).into_iter().map(|(path, _)| path));
            }
        }
    }
    all
}

/// What the `use` items of masked code bring in: path and name.
fn uses(code: &str) -> Vec<(Vec<String>, String)> {
    let begins = code.match_indices("use ").filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
    begins.flat_map(|(at, found)| tree(&code[at + found.len()..])).collect()
}

/// The paths of a tree `a::b::{c, d as e, f::*}` that begins here, each with the name it brings in.
fn tree(code: &str) -> Vec<(Vec<String>, String)> {
    let mut path: Vec<String> = Vec::new();
    let mut rest = code;
    loop {
        let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        if length > 0 {
            path.push(rest[..length].to_string());
            rest = &rest[length..];
        } else if rest.starts_with('*') {
            return vec![(path, "*".into())];
        } else if rest.starts_with('{') {
            let inside = &rest[1..crate::source::group(rest) - 1];
            let branches = split(inside).into_iter().flat_map(tree);
            return branches
                .map(|(tail, name)| (path.iter().cloned().chain(tail.into_iter().filter(|part| part != "self")).collect(), name))
                .collect();
        }
        match rest.strip_prefix("::") {
            Some(next) if length > 0 => rest = next,
            _ => break,
        }
    }
    let renamed =
        rest.trim_start().strip_prefix("as ").map(|name| name.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default());
    let name = renamed.map(str::to_string).or_else(|| path.last().cloned());
    name.map(|name| (path, name)).into_iter().collect()
}

/// The parts between commas, inner braces respected.
fn split(list: &str) -> Vec<&str> {
    let (mut parts, mut begin, mut at) = (Vec::new(), 0, 0);
    while at < list.len() {
        match list.as_bytes()[at] {
            b'{' => {
                at += crate::source::group(&list[at..]);
                continue;
            }
            b',' => {
                parts.push(list[begin..at].trim());
                begin = at + 1;
            }
            _ => {}
        }
        at += 1;
    }
    parts.push(list[begin..].trim());
    parts.into_iter().filter(|part| !part.is_empty()).collect()
}
