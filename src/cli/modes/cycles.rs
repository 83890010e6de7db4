//! Limit cycles in words.

use super::report::{calmed, head, onsets, speed};
use crate::cli::table;
use crate::scene::spec::Scene;
use crate::study::hunting::settle::Outcome;
use crate::study::hunting::{Diagram, Motion, Run, Value};

/// Speeds closer than this are told as one, m/s.
const SAME: f64 = 0.02;

/// The diagram as tables and sentences.
pub(super) fn cycles(scene: &Scene, found: &Diagram) -> String {
    let leading = found.wheelsets.get(found.leading).map_or("", String::as_str);
    let mut text =
        format!("{}: {}\n  {}, straight track; turns by {}\n", scene.name, scene.title, scene.contact.formulation_name, found.integration);
    text += &format!("\nPeriodic motions at the speeds of the sweep: half the lateral swing of {leading}\n");
    if found.motions.is_empty() {
        text += "  none was found on the branch\n";
    } else {
        text += &table(&head(&["   m/s  motion", "mm", "+-", "Hz", "+-", "largest multiplier"]), &rows(found));
    }
    for unmet in &found.missed {
        let [one, other] = unmet.swings.map(|swing| 1e3 * swing);
        text += &format!(
            "  {:.2} m/s: the branch has one more, between {:.3} and {:.3} mm, which was not met\n",
            unmet.speed,
            one.min(other),
            one.max(other)
        );
    }
    text += &format!("\nRuns of up to {} turns, from the largest motion that was found\n", crate::study::hunting::settle::MOST);
    let row = |run: &Run| vec![format!("{:>6.2}  {}", run.speed, outcome(found, run)), run.turns.to_string()];
    text += &table(&head(&["   m/s  comes to", "turns"]), &found.runs.iter().map(row).collect::<Vec<_>>());
    text += &format!("\nThe branch from the linear critical speed: {} motions; {}\n", found.branch.len(), found.end);
    text + &verdict(found)
}

fn rows(found: &Diagram) -> Vec<Vec<String>> {
    let row = |motion: &Motion| {
        let kind = if motion.stable { "stable".into() } else { format!("unstable ({})", motion.unstable) };
        vec![
            format!("{:>6.2}  {kind}", motion.speed),
            format!("{:.4}", 1e3 * found.swing(motion)),
            motion.bound.map_or("-".into(), |bound| format!("{:.0e}", 1e3 * bound)),
            format!("{:.4}", motion.frequency.value),
            format!("{:.0e}", motion.frequency.bound),
            multiplier(motion),
        ]
    };
    found.motions.iter().map(row).collect()
}

fn multiplier(motion: &Motion) -> String {
    let [re, im] = motion.multiplier;
    if im == 0.0 { format!("{re:.3}") } else { format!("{re:.3} +- {:.3} i", im.abs()) }
}

fn outcome(found: &Diagram, run: &Run) -> String {
    match &run.outcome {
        Outcome::Dies => "dies".into(),
        Outcome::Repeats { swings, bound, frequency } => {
            let swing = swings[found.leading];
            let mut words = format!("{:.4} mm +- {:.0e}, {frequency:.4} Hz", 1e3 * swing, 1e3 * bound);
            if !on_branch(found, run.speed, swing, *bound) {
                words += " (not on the branch)";
            }
            words
        }
        Outcome::Changes { from, to } => format!("not settled: {:.3} to {:.3} mm", 1e3 * from, 1e3 * to),
        Outcome::Irregular { least, most } => format!("does not repeat itself: {:.3} to {:.3} mm", 1e3 * least, 1e3 * most),
        Outcome::Fails { reason } => format!("fails: {reason}"),
    }
}

/// Is there a stable motion of the branch with that swing?
fn on_branch(found: &Diagram, speed: f64, swing: f64, bound: f64) -> bool {
    let near = |motion: &&Motion| (motion.speed - speed).abs() < 1e-9 && (found.swing(motion) - swing).abs() < 2.0 * bound + 5e-3 * swing;
    found.motions.iter().any(|motion| near(&motion))
}

fn bounded(value: &Value) -> String {
    format!("{:.2} m/s +- {:.2} ({:.1} km/h)", value.value, value.bound.max(0.005), 3.6 * value.value)
}

/// The critical speeds.
fn verdict(found: &Diagram) -> String {
    let mut text = String::new();
    let Some(linear) = found.linear() else {
        return onsets(&found.locus);
    };
    let bound = crate::study::modes::locus::ACCURACY;
    text += &format!("\nLinear critical speed: {} at {:.3} Hz\n", bounded(&Value { value: linear.speed, bound }), linear.frequency);
    if let Some(begin) = &found.begin {
        text += &format!("  small motions of the branch tend to {}\n", bounded(begin));
    }
    if let [first, second, ..] = found.branch.as_slice() {
        let kind = if second.speed < first.speed {
            "subcritical: small unstable motions live below it"
        } else {
            "supercritical: small motions live above it"
        };
        text += &format!("  the bifurcation is {kind}\n");
    }
    for turning in &found.turnings {
        let kind = if turning.lowest { "Lowest" } else { "Highest" };
        text += &format!(
            "{kind} speed of motions nearby: {}, {:.3} mm at {:.3} Hz{}\n",
            bounded(&turning.speed),
            1e3 * found.swing(&turning.motion),
            turning.motion.frequency.value,
            if turning.stable { "" } else { "; none of those that meet is stable" }
        );
    }
    match found.fold() {
        Some(fold) if fold.speed.value < linear.speed - SAME => {
            text += &format!("Nonlinear critical speed: {}\n", bounded(&fold.speed));
            text += &format!(
                "Between {:.2} and {:.2} m/s the vehicle has two ways to run: centred, and hunting\n",
                fold.speed.value, linear.speed
            );
        }
        _ => text += "No stable motion was found below the linear critical speed on this branch\n",
    }
    // Beyond the linear critical speed it may be stable again, beside motions that live on.
    let beyond = |motion: &&Motion| motion.stable && motion.speed > linear.speed && found.locus.is_calm(motion.speed);
    for motion in found.motions.iter().filter(beyond) {
        text += &format!(
            "At {} too the vehicle has two ways to run: small motions fade, and {:.3} mm live on\n",
            speed(motion.speed),
            1e3 * found.swing(motion)
        );
    }
    text += &calmed(&found.locus);
    let below = found.fold().map_or(linear.speed, |fold| fold.speed.value - fold.speed.bound);
    let others = found.runs.iter().filter(|run| run.speed < below && !matches!(run.outcome, Outcome::Dies));
    for run in others {
        text += &format!("  but the run at {} {}\n", speed(run.speed), outcome(found, run));
    }
    text
}
