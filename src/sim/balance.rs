//! Do the books of a run's energy close?
//!
//! ```text
//! open = (stored - stored at the start) - works + heats
//! ```
//!
//! It is 0 but for what the integration has added or taken. Implicit steps take a little from each swing, which mechanics does not: then a work (mostly that of the driving
//! constraint, from which hunting lives) is larger by as much than what comes out of it.

use super::recording::Recording;

/// Columns by the end of their names: what is stored, goes in, comes out.
const STORED: [&str; 3] = ["energy.kinetic", "energy.height", "energy.elements"];
const IN: [&str; 5] = [".drivingWork", ".inputWork", ".work", "energy.guideWork", "energy.contactWork"];
const OUT: [&str; 3] = [".frictionHeat", ".heat", "energy.suspensionHeat"];

/// So much of what went through the books may be missing without a word, and so many joules.
const SHARE: f64 = 0.03;
const LEAST: f64 = 1.0;

/// Does an output of that name belong to the books?
pub fn is_booked(name: &str) -> bool {
    STORED.iter().chain(&IN).chain(&OUT).any(|end| name.ends_with(end))
}

/// What a user should know of a recording that has all outputs of the group `energy`.
pub fn open_books(recording: &Recording) -> Option<String> {
    let has = |name: &str| recording.columns.iter().any(|column| column.0 == name);
    let (first, last) = STORED.iter().all(|name| has(name)).then(|| recording.rows.first().zip(recording.rows.last())).flatten()?;
    let sum = |ends: &[&str], of: &dyn Fn(f64, f64) -> f64| -> f64 {
        let ours = recording.columns.iter().enumerate().filter(|(_, column)| ends.iter().any(|end| column.0.ends_with(end)));
        ours.map(|(index, _)| of(first[index], last[index])).sum()
    };
    let change = |before: f64, now: f64| now - before;
    let size = |before: f64, now: f64| (now - before).abs();
    let (works, heats) = (sum(&IN, &change), sum(&OUT, &change));
    let open = sum(&STORED, &change) - works + heats;
    let through = sum(&IN, &size).max(sum(&OUT, &size));
    (open.abs() > LEAST.max(SHARE * through)).then(|| {
        format!(
            "energy: the books are open by {open:.3e} J at the end, {:.1} % of what went through them: so much the steps have taken (negative) or added, and works (drivingWork) are off by it; \
             a tenth of solver.tolerance closes them further",
            100.0 * open.abs() / through
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_open_books_are_told_and_closed_ones_are_not() {
        let names = ["energy.kinetic", "energy.height", "energy.elements", "w.drivingWork", "w.left.frictionHeat"];
        let recording = |end: [f64; 5]| {
            let mut recording = Recording { columns: vec![("time".into(), "s")], ..Recording::default() };
            recording.columns.extend(names.iter().map(|name| (name.to_string(), "J")));
            recording.rows = vec![[0.0; 6].into(), [1.0].into_iter().chain(end).collect()];
            recording
        };
        assert_eq!(open_books(&recording([100.0, 0.0, 0.0, 300.0, 200.0])), None);
        let open = open_books(&recording([100.0, 0.0, 0.0, 350.0, 200.0])).unwrap();
        assert!(open.contains("-5.000e1 J") && open.contains("14.3 %"), "{open}");
        assert_eq!(open_books(&Recording::default()), None);
    }
}
