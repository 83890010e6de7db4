//! `wheelrail hard --random`: random scenes, their classes, and the text of those that fail.

use super::Arguments;
use crate::cli::{Failure, print};
use crate::study::hard::random::{Class, RandomScene, Verdict, judge_with};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

/// Judges `count` scenes from the seed on.
pub(super) fn scenes(count: u64, arguments: &Arguments) -> Result<(), Failure> {
    if count == 0 || arguments.seed.checked_add(count).is_none() {
        return Err(Failure::Input(format!("--random {count} --seed {}: expected 1 scene or more", arguments.seed)));
    }
    let with = arguments.with.as_deref().map(super::method).transpose()?;
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {eta}").unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(count).with_style(style);
    let begin = std::time::Instant::now();
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| ()));
    let all: Vec<Verdict> = (arguments.seed..arguments.seed + count)
        .into_par_iter()
        .map(|seed| {
            let verdict = judge_with(seed, with);
            bar.inc(1);
            verdict
        })
        .collect();
    std::panic::set_hook(hook);
    bar.finish_and_clear();
    let failures: Vec<&Verdict> = all.iter().filter(|verdict| verdict.class.is_failure()).collect();
    if arguments.json {
        print(&format!("{}\n", serde_json::json!({"scenes": all, "seconds": begin.elapsed().as_secs_f64()})))?;
    } else {
        print(&text(&all, arguments, begin.elapsed().as_secs_f64()))?;
    }
    match failures.len() {
        0 => Ok(()),
        failed => Err(Failure::Run(format!("{failed} of {count} random scenes fail; `wheelrail hard --random-scene SEED` prints one"))),
    }
}

fn text(all: &[Verdict], arguments: &Arguments, seconds: f64) -> String {
    let mut text = format!("{} random scenes from seed {} in {seconds:.0} s\n\n", all.len(), arguments.seed);
    for class in Class::ALL {
        let count = all.iter().filter(|verdict| verdict.class == class).count();
        let share = 100.0 * count as f64 / all.len() as f64;
        text += &format!("  {:20} {count:6}  {share:5.1} %\n", class.words());
    }
    text += "\n";
    for verdict in all.iter().filter(|verdict| arguments.all || !matches!(verdict.class, Class::Right | Class::Derailed | Class::Refused)) {
        text += &format!("  seed {}: {}: {}\n", verdict.seed, verdict.class.words(), verdict.reason);
    }
    if arguments.all {
        for verdict in all.iter().filter(|verdict| verdict.class.is_failure()) {
            text += &format!("\n# seed {}: {}\n{}", verdict.seed, verdict.reason, RandomScene::draw(verdict.seed).text);
        }
    }
    text
}
