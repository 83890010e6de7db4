//! Tests that claim nothing: neither they nor a function that they call asserts more than that a number is one.

use crate::source::{Function, Source, functions, group, lines, mask, rust_files, sources};
use std::collections::BTreeSet;
use std::path::Path;

/// What makes a test fail by what it finds; `unwrap` alone only shows that nothing went wrong on the way.
const CLAIMS: [&str; 4] = ["assert", "panic!(", "unwrap_err()", "expect_err("];

/// File and name of each test without a claim. Calls are followed by name: in `src/` among the functions that only the file's tests have and
/// those of modules of tests, in `tests/` among those of the same folder and of `tests/common`.
pub fn tests_without_claim() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let mut files = Vec::new();
    rust_files(&root, &mut files);
    let outer: Vec<Source> = files
        .into_iter()
        .map(|file| Source {
            path: file.strip_prefix(&root).unwrap().to_path_buf(),
            code: mask(&std::fs::read_to_string(&file).unwrap()),
            production: String::new(),
        })
        .collect();
    let inner = sources();
    let shared = |source: &Source| source.production.is_empty();
    let common = |source: &Source| source.path.starts_with("common");
    let found = idle(&inner, |test, helper| test.path == helper.path || shared(helper))
        .chain(idle(&outer, |test, helper| test.path.parent() == helper.path.parent() || common(helper)));
    found.collect()
}

/// The tests of some files that claim nothing, with the functions of those other files that `near` lets them call.
fn idle<'a>(files: &'a [Source], near: impl Fn(&Source, &Source) -> bool + 'a) -> impl Iterator<Item = String> + 'a {
    let functions: Vec<Vec<Function<'_>>> = files.iter().map(only_for_tests).collect();
    let tests: usize = functions.iter().flatten().filter(|function| function.is_test).count();
    assert!(tests > 200, "the test no longer sees the tests");
    let of_file = move |index: usize| {
        let around = files.iter().zip(&functions).filter(|(file, _)| near(&files[index], file)).flat_map(|(_, functions)| functions);
        let claiming = claiming(&around.collect::<Vec<_>>());
        // What runs in a process of its own for another test is none.
        let idle = functions[index]
            .iter()
            .filter(|test| test.is_test && test.name != "worker" && !test.should_panic && !claims(test.body, &claiming));
        idle.map(|test| format!("{}: {} ({} lines)", files[index].path.display(), test.name, lines(test.text))).collect::<Vec<_>>()
    };
    (0..files.len()).flat_map(of_file)
}

fn only_for_tests(source: &Source) -> Vec<Function<'_>> {
    let in_production = |function: &Function| source.production.get(function.at..).is_some_and(|text| text.starts_with("fn "));
    functions(&source.code).into_iter().filter(|function| !in_production(function)).collect()
}

/// Names of functions that claim something, themselves or by what they call.
fn claiming<'a>(helpers: &[&Function<'a>]) -> BTreeSet<&'a str> {
    let mut claiming = BTreeSet::new();
    loop {
        let more: Vec<&str> = helpers
            .iter()
            // Constructors share a name.
            .filter(|helper| helper.name != "new" && !claiming.contains(helper.name) && claims(helper.body, &claiming))
            .map(|helper| helper.name)
            .collect();
        if more.is_empty() {
            return claiming;
        }
        claiming.extend(more);
    }
}

fn claims(body: &str, claiming: &BTreeSet<&str>) -> bool {
    let calls = body.split('(').filter_map(|before| before.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next());
    let of_a_number = |at: usize| {
        let told = &body[at..];
        let open = told.find('(').unwrap_or_default();
        let inside = &told[open..open + group(&told[open..])];
        inside.contains(".is_finite()") && !inside.contains(['<', '>', '=', '&', ',']) && !inside.contains("||")
    };
    CLAIMS.iter().any(|claim| body.match_indices(claim).any(|(at, _)| !of_a_number(at)))
        || calls.into_iter().any(|word| claiming.contains(word))
}
