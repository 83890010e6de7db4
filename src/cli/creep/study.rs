//! Laws against a reference law on random contacts: distance of the force and time per call.
//!
//! Contacts: a/b log-uniform from 0.1 to 10, sqrt(a b) from 2 to 8 mm, largest pressure 0.4 to 1.6 GPa, mu 0.1 to 0.6,
//! steel, 20 m/s. Creepages: direction uniform over the sphere of the three linear forces (longitudinal, lateral, lateral of
//! spin), their resultant log-uniform from 0.05 to 10 mu N: from the linear range to full slip. The numbers come from ChaCha8
//! and are the same on every machine.

use super::Named;
use crate::cli::output::write_whole;
use crate::cli::plot::{Ink, Mark, Panel, Series, Sheet};
use crate::cli::{Failure, make_folder};
use crate::contact::creep::kalker::LinearTheory;
use crate::contact::creep::{CreepLaw, RollingContact};
use crate::contact::creepage::{CreepForce, Creepage};
use crate::contact::{Material, Patch};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::f64::consts::PI;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

const STEEL: Material = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };

/// Random contacts, the same for the same seed.
pub(super) fn contacts(count: usize, seed: u64) -> Vec<RollingContact> {
    let mut numbers = ChaCha8Rng::seed_from_u64(seed);
    // 53 bits: every number is exact.
    let mut between = move |low: f64, high: f64| low + (high - low) * ((numbers.next_u64() >> 11) as f64 / (1u64 << 53) as f64);
    let theory = LinearTheory::new(STEEL);
    (0..count)
        .map(|_| {
            let mut log = |low: f64, high: f64| between(low.ln(), high.ln()).exp();
            let (ratio, mean, size) = (log(0.1, 10.0), log(2e-3, 8e-3), log(0.05, 10.0));
            let patch = Patch { a: mean * ratio.sqrt(), b: mean / ratio.sqrt() };
            let (pressure, friction) = (between(0.4e9, 1.6e9), between(0.1, 0.6));
            let normal_force = 2.0 / 3.0 * PI * patch.a * patch.b * pressure;
            let (height, angle) = (between(-1.0, 1.0), between(0.0, 2.0 * PI));
            let around = (1.0 - height * height).sqrt();
            let one = |longitudinal, lateral, spin| theory.force(patch, Creepage { longitudinal, lateral, spin });
            let slopes = [one(1.0, 0.0, 0.0).longitudinal, one(0.0, 1.0, 0.0).lateral, one(0.0, 0.0, 1.0).lateral];
            let force = size * friction * normal_force;
            let creepage = Creepage {
                longitudinal: force * around * angle.cos() / slopes[0],
                lateral: force * around * angle.sin() / slopes[1],
                spin: force * height / slopes[2],
            };
            RollingContact { patch, normal_force, friction, creepage, speed: 20.0 }
        })
        .collect()
}

/// One law's distance from the reference.
pub(super) struct Line {
    law: String,
    /// |dF| / (mu N).
    mean: f64,
    most: f64,
    worst: f64,
    /// |dMz| / (mu N sqrt(a b)), mean.
    moment: f64,
    /// s per call.
    time: f64,
}

/// What a study found.
pub(super) struct Study {
    count: usize,
    seed: u64,
    reference: String,
    reference_time: f64,
    lines: Vec<Line>,
}

/// Forces and the time per call: the best of several passes over all contacts, one pass of a slow law.
fn forces(law: &dyn CreepLaw, contacts: &[RollingContact]) -> (Vec<CreepForce>, f64) {
    const PASSES: usize = 9;
    const SLOW: f64 = 2.0;
    let pass = || {
        let clock = Instant::now();
        let forces: Vec<CreepForce> = contacts.iter().map(|contact| law.force(black_box(contact))).collect();
        (forces, clock.elapsed().as_secs_f64())
    };
    let (forces, first) = pass();
    let passes = if first > SLOW { 0 } else { PASSES };
    let best = (0..passes).map(|_| pass().1).fold(first, f64::min);
    (forces, best / contacts.len() as f64)
}

/// Compares laws with a reference.
pub(super) fn study(count: usize, seed: u64, reference: &Named, laws: &[Named]) -> Result<Study, Failure> {
    if count == 0 {
        return Err(Failure::Input("--study 0: expected at least one contact".into()));
    }
    let contacts = contacts(count, seed);
    let (truth, reference_time) = forces((reference.build)(STEEL).as_ref(), &contacts);
    let lines = laws.iter().map(|law| {
        let (found, time) = forces((law.build)(STEEL).as_ref(), &contacts);
        let pairs = || contacts.iter().zip(found.iter().zip(&truth));
        let mut distances: Vec<f64> =
            pairs().map(|(contact, (a, b))| (a.longitudinal - b.longitudinal).hypot(a.lateral - b.lateral) / contact.bound()).collect();
        let moments = pairs()
            .map(|(contact, (a, b))| (a.spin_moment - b.spin_moment).abs() / contact.bound() / (contact.patch.a * contact.patch.b).sqrt());
        let moment = moments.sum::<f64>() / count as f64;
        let mean = distances.iter().sum::<f64>() / count as f64;
        distances.sort_by(f64::total_cmp);
        let (most, worst) = (distances[(count - 1) * 95 / 100], distances[count - 1]);
        Line { law: law.name.clone(), mean, most, worst, moment, time }
    });
    Ok(Study { count, seed, reference: reference.name.clone(), reference_time, lines: lines.collect() })
}

/// "0.74 us".
fn duration(seconds: f64) -> String {
    let (value, unit) = if seconds < 0.9995e-3 { (seconds * 1e6, "us") } else { (seconds * 1e3, "ms") };
    let decimals = if value < 9.995 { 2 } else { usize::from(value < 99.95) };
    format!("{value:.decimals$} {unit}")
}

/// The table in Markdown.
pub(super) fn text(study: &Study) -> String {
    let mut text = format!(
        "Distance from `{}` ({} per call) on {} random contacts (seed {}), |dF|/(mu N); moment: |dMz|/(mu N sqrt(a b)).\n\n\
         | law | mean | 95 % | worst | moment, mean | time per call |\n|---|---:|---:|---:|---:|---:|\n",
        study.reference,
        duration(study.reference_time),
        study.count,
        study.seed
    );
    for line in &study.lines {
        let Line { law, mean, most, worst, moment, time } = line;
        text += &format!("| `{law}` | {mean:.4} | {most:.4} | {worst:.3} | {moment:.4} | {} |\n", duration(*time));
    }
    text
}

fn csv(study: &Study) -> String {
    let mut text = String::from("law,mean [-],95 percent [-],worst [-],moment mean [-],time per call [s]\n");
    for Line { law, mean, most, worst, moment, time } in &study.lines {
        text += &format!("\"{}\",{mean:?},{most:?},{worst:?},{moment:?},{time:?}\n", law.replace('"', "\"\""));
    }
    text
}

/// Writes creep_laws.csv, .md and .svg into a folder.
pub(super) fn write(folder: &Path, study: &Study) -> Result<Vec<PathBuf>, Failure> {
    if folder.is_file() {
        return Err(Failure::Input(format!("-o {}: is a file; --study writes a folder", folder.display())));
    }
    make_folder(folder)?;
    let files = ["creep_laws.csv", "creep_laws.md", "creep_laws.svg"].map(|name| folder.join(name));
    write_whole(&files[0], csv(study).as_bytes())?;
    write_whole(&files[1], text(study).as_bytes())?;
    let measured = study.lines.iter().filter(|line| line.mean > 0.0 && line.time > 0.0);
    let marks = measured.map(|line| Mark { x: 1e6 * line.time, y: line.mean, label: line.law.clone(), ..Mark::default() });
    let series = vec![Series::marks("", Ink { width: 0.0, ..Ink::marks(0) }, marks.collect())];
    let panel = Panel { height: 480.0, ..Panel::new("", ["time per call [us]", "mean |dF| / (mu N)"], series).log() };
    let subtitles = vec![format!("{} random contacts against {}", study.count, study.reference)];
    Sheet { title: "Creep laws: cost and distance".into(), subtitles, columns: 1, panels: vec![panel] }
        .draw(&files[2])
        .map_err(Failure::Run)?;
    Ok(files.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::creep::inline;

    fn named(name: &str) -> Named {
        Named { name: name.into(), build: inline::law(name, "test").unwrap() }
    }

    #[test]
    fn prop_contacts_are_reproducible_and_cover_the_range() {
        let first = contacts(400, 7);
        assert_eq!(first, contacts(400, 7));
        assert_ne!(first, contacts(400, 8));
        let ratios: Vec<f64> = first.iter().map(|contact| contact.patch.a / contact.patch.b).collect();
        assert!(ratios.iter().any(|r| *r < 0.12) && ratios.iter().any(|r| *r > 8.0) && ratios.iter().all(|r| (0.1..=10.0).contains(r)));
    }

    #[test]
    fn prop_a_study_ranks_laws_and_writes_three_files() {
        let laws = ["fastsim{strips=10,cells=10}", "fastsim", "polach", "kalker_linear"].map(named);
        let study = study(200, 1, &named("fastsim{strips=60,cells=100}"), &laws).unwrap_or_else(|_| unreachable!());
        println!("{}", text(&study));
        let mean: Vec<f64> = study.lines.iter().map(|line| line.mean).collect();
        assert!(mean[1] < mean[0] && mean[0] < mean[2] && mean[2] < mean[3] && mean[1] < 0.006, "{mean:?}");
        let folder = tempfile::tempdir().unwrap();
        let files = write(folder.path(), &study).unwrap_or_else(|_| unreachable!());
        let read = |i: usize| std::fs::read_to_string(&files[i]).unwrap();
        assert!(
            read(0).lines().count() == 5 && read(1).contains("| `polach` |") && read(2).contains(">polach<") | read(2).contains("polach\n")
        );
    }
}
