//! docs/tutorial.md: its files are written, its commands run, and what they print is what the page shows.
//!
//! `WHEELRAIL_BLESS=1` puts the numbers of this run into the page.

use super::{ROOT, python};
use std::path::Path;
use std::process::Command;

/// A fenced block of a page.
struct Block {
    /// Line of its fence, from 1, and the word behind it.
    line: usize,
    language: String,
    lines: Vec<String>,
}

fn blocks(page: &str) -> Result<Vec<Block>, String> {
    let mut found: Vec<Block> = Vec::new();
    let mut inside = false;
    for (k, line) in page.lines().enumerate() {
        match (line.strip_prefix("```"), inside) {
            (Some(language), false) => {
                inside = true;
                found.push(Block { line: k + 1, language: language.into(), lines: vec![] });
            }
            (Some(_), true) => inside = false,
            (None, true) => found.last_mut().unwrap().lines.push(line.into()),
            (None, false) if line.starts_with("    ") => return Err(format!("line {}: a block without a fence does not run", k + 1)),
            (None, false) => {}
        }
    }
    Ok(found)
}

/// Writes a file that a block begins with the name of, or adds to it.
fn write(block: &Block, folder: &Path) -> Result<(), String> {
    let name = block.lines.first().and_then(|line| line.strip_prefix("# ")).ok_or("a file without a name")?;
    let text = block.lines[1..].join("\n") + "\n";
    let (file, before) = match name.strip_suffix(", at its end") {
        Some(name) => (folder.join(name), std::fs::read_to_string(folder.join(name)).map_err(|error| format!("{name}: {error}"))? + "\n"),
        None => (folder.join(name), String::new()),
    };
    std::fs::write(file, before + &text).map_err(|error| error.to_string())
}

/// What the commands of a block print.
fn commands(block: &Block, folder: &Path) -> Result<String, String> {
    let program = Path::new(env!("CARGO_BIN_EXE_wheelrail")).parent().unwrap();
    let path = std::env::join_paths(
        [python().parent().unwrap(), program]
            .into_iter()
            .map(Path::to_path_buf)
            .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let mut bash = Command::new("bash");
    bash.args(["-euo", "pipefail", "-c", &block.lines.join("\n")]).current_dir(folder).env("PATH", path.unwrap());
    let output = bash.output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() { Ok(text) } else { Err(format!("{text}{}", String::from_utf8_lossy(&output.stderr))) }
}

/// Do two words tell the same: equal, or numbers that differ by what another machine's last bits may do? `{...}` stands for any word.
fn same(shown: &str, printed: &str, shape_only: bool) -> bool {
    let number = |word: &str| word.trim_end_matches([',', ':', ';', ')']).parse::<f64>();
    match (number(shown), number(printed)) {
        (Ok(a), Ok(b)) => {
            let decimals = shown.split('.').nth(1).map_or(0, |digits| digits.trim_end_matches([',', ':', ';', ')']).len());
            shape_only || (a - b).abs() <= 0.01 * a.abs() + 1.5 * 10f64.powi(-(decimals as i32))
        }
        _ => shown == printed || shown.contains("{...}"),
    }
}

/// The printed line for each shown one, in order; of several that have its shape the one that has most of its words.
fn find(block: &Block, printed: &str, shape_only: bool) -> Result<Vec<String>, String> {
    let printed_lines: Vec<&str> = printed.lines().collect();
    let (mut next, mut found) = (0, Vec::new());
    for shown in &block.lines {
        let words: Vec<&str> = shown.split_whitespace().collect();
        let equal = |line: &str| -> Option<usize> {
            let other: Vec<&str> = line.split_whitespace().collect();
            let fits = other.len() == words.len() && words.iter().zip(&other).all(|(a, b)| same(a, b, shape_only));
            fits.then(|| words.iter().zip(&other).filter(|(a, b)| a == b).count())
        };
        let fitting = (next..printed_lines.len()).filter_map(|k| Some((equal(printed_lines[k])?, k)));
        let best = fitting.reduce(|best, other| if other.0 > best.0 { other } else { best });
        let (_, k) = best.ok_or_else(|| format!("shows what is not printed:\n{shown}\nprinted is\n{printed}"))?;
        next = k + 1;
        found.push(if shown.contains("{...}") { shown.clone() } else { printed_lines[k].to_string() });
    }
    Ok(found)
}

/// Does all that a page says; gives the page with the numbers of this run.
fn play(page: &str, shape_only: bool) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let mut lines: Vec<String> = page.lines().map(String::from).collect();
    let mut printed = None;
    for block in blocks(page)? {
        let at = |error: String| format!("line {}: {error}", block.line);
        match block.language.as_str() {
            "toml" | "python" => write(&block, folder.path()).map_err(at)?,
            "sh" => printed = Some(commands(&block, folder.path()).map_err(at)?),
            "text" => {
                let output = printed.as_ref().ok_or_else(|| at("output of no command".into()))?;
                for (k, line) in find(&block, output, shape_only).map_err(at)?.into_iter().enumerate() {
                    lines[block.line + k] = line;
                }
            }
            other => return Err(at(format!("a block of \"{other}\" does not run"))),
        }
    }
    Ok(lines.join("\n") + "\n")
}

#[test]
#[cfg(unix)]
fn fmu_tutorial_runs_as_it_is_written() {
    let file = Path::new(ROOT).join("docs/tutorial.md");
    let page = std::fs::read_to_string(&file).unwrap();
    let bless = std::env::var_os("WHEELRAIL_BLESS").is_some();
    let made = play(&page, bless).unwrap_or_else(|error| panic!("docs/tutorial.md, {error}"));
    if bless {
        std::fs::write(&file, made).unwrap();
    }
    let count = |language: &str| blocks(&page).unwrap().iter().filter(|block| block.language == language).count();
    assert!(count("sh") >= 10 && count("toml") >= 5 && count("python") == 1 && count("text") >= 10, "the test no longer sees the page");
}

/// The README's lines of Python, on what its first command makes.
#[test]
fn fmu_readme_lines_run_as_they_are_written() {
    let page = std::fs::read_to_string(Path::new(ROOT).join("README.md")).unwrap();
    let lines = blocks(&page).unwrap().into_iter().find(|block| block.language == "python").unwrap().lines;
    assert_eq!(lines.len(), 5);
    let folder = tempfile::tempdir().unwrap();
    let exported =
        Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(["export", "suspended_wheelset"]).current_dir(folder.path()).output().unwrap();
    assert!(exported.status.success(), "{exported:?}");
    let ran = Command::new(python()).args(["-c", &lines.join("\n")]).current_dir(folder.path()).output().unwrap();
    let text = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{text}{}", String::from_utf8_lossy(&ran.stderr));
    let last = text.lines().last().unwrap();
    let numbers: Vec<f64> = last.split(['(', ')', ',']).filter_map(|word| word.trim().parse().ok()).collect();
    println!("{last}");
    // y in m over a gauge reduction of 10 mm, and Q about 55 kN.
    assert!(numbers.len() == 4 && numbers[0] < 0.0 && (3e-3..7e-3).contains(&numbers[1].max(-numbers[0])), "{last}");
    assert!((45e3..56e3).contains(&numbers[2]) && (54e3..65e3).contains(&numbers[3]), "{last}");
}

/// A page with a fault is refused where the fault is.
#[test]
#[cfg(unix)]
fn fmu_tutorial_with_a_fault_is_refused() {
    let page = std::fs::read_to_string(Path::new(ROOT).join("docs/tutorial.md")).unwrap();
    // To the first output: the rest runs above.
    let end = page.find("```text").unwrap() + page[page.find("```text").unwrap()..].find("\n```\n").unwrap() + 5;
    let page = &page[..end];
    play(page, false).unwrap();
    for (right, wrong, expected) in [
        ("wheelrail contact wheelset.toml", "wheelrail contakt wheelset.toml", "unrecognized subcommand 'contakt'"),
        ("wheelrail contact wheelset.toml", "wheelrail contact wheelset.toml --amplitudes 3", "unexpected argument"),
        ("wheelrail contact wheelset.toml", "wheelrail contact wheel.toml; true", "wheel.toml"),
        ("friction = 0.35", "frictoin = 0.35", "contact.frictoin"),
        ("# wheelset.toml\n", "# other.toml\n", "wheelset.toml"),
        ("# wheelset.toml\n", "# wheelset.toml, at its end\n", "wheelset.toml"),
        ("3.000 mm: 0.1", "3.000 mm: 0.2", "shows what is not printed"),
        ("Equivalent conicity at", "Conicity at", "shows what is not printed"),
        ("```sh", "```console", "a block of \"console\" does not run"),
        ("```toml", "    indented = 1\n\n```toml", "a block without a fence"),
    ] {
        assert!(page.contains(right), "{right}");
        let error = play(&page.replacen(right, wrong, 1), false).err().unwrap_or_default();
        assert!(error.contains(expected), "{wrong}: {error}");
    }
}
