//! The hard cases as text and as a page.

use crate::study::hard::{Case, Judged, Outcome};

/// Names, what makes hard, what must hold.
pub(super) fn list(cases: &[Case]) -> String {
    cases.iter().map(|case| format!("{}\n  hard: {}\n  must: {}\n", case.name, case.hard, case.claim)).collect()
}

fn mark(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Held { .. } => "held",
        Outcome::Refused { .. } => "refused",
        Outcome::Broken { .. } => "BROKEN",
    }
}

/// Counts of held, refused and broken.
fn counts(rows: &[Judged]) -> [usize; 3] {
    let count = |wanted: &str| rows.iter().filter(|row| mark(&row.outcome) == wanted).count();
    [count("held"), count("refused"), count("BROKEN")]
}

fn shortened(text: &str, most: usize) -> String {
    let line = text.replace('\n', " ");
    if line.chars().count() <= most { line } else { format!("{} ...", line.chars().take(most).collect::<String>()) }
}

/// For people at a terminal.
pub(super) fn text(cases: &[Case], rows: &[Judged], all: bool, seconds: f64) -> String {
    let mut text = String::new();
    for case in cases {
        let own: Vec<&Judged> = rows.iter().filter(|row| row.case == case.name).collect();
        if own.is_empty() {
            continue;
        }
        text += &format!("\n{}: {}\n  must: {}\n", case.name, case.hard, case.claim);
        for row in &own {
            let words = shortened(&row.outcome.words(), if all { usize::MAX } else { 140 });
            let Judged { formulation, method, steps, cpu, .. } = row;
            text += &format!("  {formulation:5}  {method:22}  {:7}  {steps:7} steps  {cpu:6.2} s  {words}\n", mark(&row.outcome));
        }
        if all {
            for row in own.iter().filter(|row| row.outcome.is_broken()) {
                text += &format!("    {}\n", row.command);
            }
        }
    }
    let [held, refused, broken] = counts(rows);
    text + &format!("\n{} rows in {seconds:.0} s: {held} held, {refused} refused, {broken} broken\n", rows.len())
}

/// docs/hard_cases.md.
pub(super) fn page(cases: &[Case], rows: &[Judged]) -> String {
    let [held, refused, broken] = counts(rows);
    let mut text = format!(
        "# Hard cases\n\nMade by `wheelrail hard --markdown docs/hard_cases.md`. Each case runs with every formulation and integrator that applies; all numbers are read \
         on a dense grid of times that no step knows of, between the ends of steps.\n\n\
         Every run is audited too, whatever the case: energy (what goes in = stored + dissipated, to 1 % of what was exchanged unless the case says otherwise), \
         mean of all Q against the weight (0.2 %), rigid contacts closed to 1e-10 m, no contact pulls, creep forces within friction, a start within 2 s, \
         and a state saved in the middle, serialised and restored that leads to the same bits.\n\n\
         {} rows: {held} held, {refused} refused with reason and cure, {broken} broken. The number shown is that nearest to its bound.\n",
        rows.len()
    );
    text += "\n| case | held | refused | broken |\n|---|---|---|---|\n";
    for case in cases {
        let own: Vec<Judged> = rows.iter().filter(|row| row.case == case.name).cloned().collect();
        let [held, refused, broken] = counts(&own);
        text += &format!("| [{}](#{}) | {held} | {refused} | {broken} |\n", case.name, case.name);
    }
    for case in cases {
        text += &format!("\n## {}\n\nHard: {}.\n\nMust hold: {}.\n\n", case.name, case.hard, case.claim);
        text += "| formulation | method | outcome | steps | CPU, s | nearest to its bound, or why |\n|---|---|---|---|---|---|\n";
        for row in rows.iter().filter(|row| row.case == case.name) {
            let words = shortened(&row.outcome.words(), 300).replace('|', "\\|");
            let outcome = mark(&row.outcome).to_lowercase();
            let outcome = if row.outcome.is_broken() { format!("**{outcome}**") } else { outcome };
            text += &format!("| {} | {} | {outcome} | {} | {:.2} | {words} |\n", row.formulation, row.method, row.steps, row.cpu);
        }
    }
    text
}
