//! Modes in words.

use crate::cli::table;
use crate::scene::spec::Scene;
use crate::scene::start::{self, Start};
use crate::study::modes::locus::{Critical, Locus};
use crate::study::modes::{Mode, Modes, STEADY};

/// Parts that are told of a mode, and modes of a speed.
const PARTS: usize = 4;
const LEAST_DAMPED: usize = 3;
/// Contact modes beyond this are not told over speed unless they grow, Hz.
const HIGHEST: f64 = 40.0;

pub(super) fn speed(speed: f64) -> String {
    format!("{speed:.1} m/s ({:.0} km/h)", 3.6 * speed)
}

fn parts(mode: &Mode) -> String {
    let told = mode.parts.iter().take(PARTS);
    told.map(|part| format!("{} {} {:.0} %", part.body, part.coordinate, 100.0 * part.share)).collect::<Vec<_>>().join(", ")
}

pub(super) fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| name.to_string()).collect()
}

/// That slopes are equivalent ones, where they are.
fn swinging(amplitude: f64) -> String {
    if amplitude == 0.0 { String::new() } else { format!("  equivalent slopes: wheelsets swing across by {:.3} mm\n", 1e3 * amplitude) }
}

/// Everything about one speed.
pub(super) fn modes(scene: &Scene, found: &Modes) -> String {
    let mut text = format!(
        "{}: {}\n  {}, {}{}: {} states, {} of free motion\n",
        scene.name,
        scene.title,
        speed(found.speed),
        scene.contact.formulation_name,
        place(scene).map_or(String::new(), |place| format!(", {place}")),
        found.states,
        found.free
    );
    text.push_str(&swinging(found.amplitude));
    text += &unsteady([found]);
    if let Some(track) = &found.track {
        text += &format!("  track: {track}\n");
    }
    if let Some(most) = found.kinked {
        text += &format!(
            "  the creep law has no derivative where creepage vanishes: growths are those of small swings by harmonic balance, up to {most:.3} 1/s from what single slopes give\n"
        );
    }
    if let Some(first) = found.at_ends.first() {
        let more = found.at_ends.len() - 1;
        let others = if more > 0 { format!(" (and {more} more)") } else { String::new() };
        text += &format!("  {first}{others} stands at the end of its free travel: modes are a mean of those on both sides of it\n");
    }
    let row = |mode: &Mode| {
        vec![
            mode.name.clone(),
            format!("{:.4}", mode.frequency),
            format!("{:.2}", 100.0 * mode.damping),
            format!("{:+.4}", mode.growth),
            format!("{:.0e}", mode.uncertainty),
        ]
    };
    let (swinging, aperiodic): (Vec<&Mode>, Vec<&Mode>) = found.modes.iter().partition(|mode| mode.frequency > 0.0);
    text += "\nModes by frequency\n";
    text += &table(
        &head(&["what moves most", "Hz", "damping %", "growth 1/s", "+-"]),
        &swinging.iter().map(|mode| row(mode)).collect::<Vec<_>>(),
    );
    text += "\nShares of the kinetic energy\n";
    for mode in &swinging {
        text += &format!("  {:9.4} Hz  {}\n", mode.frequency, parts(mode));
    }
    if !aperiodic.is_empty() {
        text += "\nAperiodic motions\n";
        let row = |mode: &&Mode| vec![mode.name.clone(), format!("{:+.4}", mode.growth), format!("{:.0e}", mode.uncertainty)];
        text += &table(&head(&["what moves most", "growth 1/s", "+-"]), &aperiodic.iter().map(row).collect::<Vec<_>>());
    }
    if !found.left_out.is_empty() {
        text += &format!("\nLeft out: {}\n", found.left_out.join("; "));
    }
    text + &verdict(found)
}

/// So many times its uncertainty an eigenvalue may be off.
const UNCERTAIN: f64 = 2.0;

/// What grows.
fn verdict(found: &Modes) -> String {
    let growing: Vec<&Mode> = found.growing().collect();
    if growing.is_empty() {
        let uncertain = |mode: &&Mode| !mode.neutral && mode.growth + UNCERTAIN * mode.uncertainty > 0.0;
        // The one that may grow most.
        let most = |a: &&Mode, b: &&Mode| a.growth.total_cmp(&b.growth);
        let Some(first) = found.modes.iter().filter(uncertain).max_by(most) else {
            return "\nStable: every motion dies away or is neutral\n".into();
        };
        return format!(
            "\nNo motion grows for certain: {} at {:.3} Hz has {:+.3} 1/s, +- {:.0e} (slopes change within micrometres), and larger motions may be others; see a run\n",
            first.name, first.frequency, first.growth, first.uncertainty
        );
    }
    let words = growing.iter().map(|mode| format!("{} at {:.3} Hz by {:.3} 1/s", mode.name, mode.frequency, mode.growth));
    format!("\nUnstable: {}\n", words.collect::<Vec<_>>().join("; "))
}

/// What steady states leave unbalanced, or leave out.
fn unsteady<'m>(all: impl IntoIterator<Item = &'m Modes> + Clone) -> String {
    let mut text = String::new();
    if all.clone().into_iter().any(|found| found.coasts) {
        text += "  the torques and forces that elements begin with have no steady state: modes are those of a vehicle that coasts\n";
    }
    let worst = all.into_iter().max_by(|a, b| a.unbalanced.total_cmp(&b.unbalanced)).filter(|worst| worst.unbalanced > STEADY);
    if let Some(found) = worst {
        text += &format!("  not quite steady: accelerations up to {:.1e} m/s2 or rad/s2 remain\n", found.unbalanced);
    }
    text
}

/// The track of a scene's start, where it is not straight.
fn place(scene: &Scene) -> Option<String> {
    match start::start(scene) {
        Start::Curve(node) if node.curvature != 0.0 => Some(format!("a curve of {:.0} m radius", 1.0 / node.curvature.abs())),
        Start::Curve(_) => Some("superelevated track".into()),
        _ => None,
    }
}

/// The least damped modes by speed, and the critical speed.
pub(super) fn locus(scene: &Scene, found: &Locus) -> String {
    let mut text = format!(
        "{}: {}\n  {}, {}\n{}{}\nHunting and the least damped modes below {HIGHEST} Hz by speed\n",
        scene.name,
        scene.title,
        scene.contact.formulation_name,
        place(scene).unwrap_or("straight track".into()),
        found.points.first().map_or(String::new(), |point| swinging(point.amplitude)),
        unsteady(&found.points)
    );
    let mut rows = Vec::new();
    for point in &found.points {
        let row = |speed: String, mode: &Mode| {
            vec![
                format!("{speed:>6}  {}", mode.name),
                format!("{:.3}", mode.frequency),
                format!("{:.2}", 100.0 * mode.damping),
                format!("{:+.4}", mode.growth),
            ]
        };
        let least = point.by_damping().into_iter().filter(|mode| mode.frequency < HIGHEST || mode.growth > 0.0).take(LEAST_DAMPED);
        let hunting = point.hunting().into_iter();
        let mut shown: Vec<&Mode> = hunting.collect();
        shown.extend(least.filter(|mode| shown.first().is_none_or(|first| !std::ptr::eq(*first, *mode))).collect::<Vec<_>>());
        for (index, mode) in shown.into_iter().enumerate() {
            rows.push(row(if index == 0 { format!("{:.1}", point.speed) } else { String::new() }, mode));
        }
    }
    text += &table(&head(&["   m/s  what moves most", "Hz", "damping %", "growth 1/s"]), &rows);
    text + &onsets(found)
}

/// Onsets that are named beside the first.
const ONSETS: usize = 4;

/// The critical speed, and what begins to grow beside it.
pub(super) fn onsets(found: &Locus) -> String {
    let growing: Vec<&Mode> = found.growing_at_lowest().collect();
    let (mut text, others) = match &found.critical {
        Some(Critical { speed, frequency, mode }) => (
            format!("\nLinear critical speed: {speed:.2} m/s ({:.1} km/h): {mode} at {frequency:.3} Hz\n", 3.6 * speed),
            &found.onsets[1..],
        ),
        None if growing.is_empty() => {
            ("\nNo critical speed within the sweep: nothing grows at any of its speeds\n".into(), &found.onsets[..])
        }
        None => {
            let words = growing.iter().map(|mode| format!("{} at {:.3} Hz by {:+.4} 1/s", mode.name, mode.frequency, mode.growth));
            let words = words.collect::<Vec<_>>().join("; ");
            (format!("\nUnstable at the lowest speed already, the critical one lies below it; begin lower: {words}\n"), &found.onsets[..])
        }
    };
    if !others.is_empty() {
        let words = others.iter().take(ONSETS).map(|onset| format!("{} at {:.2} m/s ({:.3} Hz)", onset.mode, onset.speed, onset.frequency));
        let more = others.len().saturating_sub(ONSETS);
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        text += &format!("Beyond also begin to grow: {}{more}\n", words.collect::<Vec<_>>().join("; "));
    }
    text + &calmed(found)
}

/// Where growth ends again.
pub(super) fn calmed(found: &Locus) -> String {
    let words = |[last, first]: [f64; 2]| {
        format!("Between {last:.2} and {first:.2} m/s all growth ends again: small motions fade at {first:.2} m/s\n")
    };
    found.calmed().map(words).collect()
}
