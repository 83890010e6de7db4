//! What effects change over what they cost.

use crate::cli::plot::{Ink, Mark, Panel, Series, Sheet};
use crate::study::digits::rounded;
use crate::study::effects::change::Change;
use crate::study::effects::list::Kind;
use crate::study::effects::observed::Quantity;
use crate::study::effects::{Outcome, Report};
use std::path::Path;

/// Quantities that are drawn.
const DRAWN: [Quantity; 4] = [Quantity::Displacement, Quantity::WheelLoad, Quantity::GuidingForce, Quantity::Wear];

/// Draws a panel for each quantity.
pub(super) fn draw(file: &Path, report: &Report) -> Result<(), String> {
    let panel = |quantity: Quantity| {
        let (unit, size) = quantity.unit();
        let marks = |off: bool| -> Vec<Mark> {
            let rows = report.rows.iter().filter(|row| (row.variant.kind == Kind::Off) == off);
            rows.filter_map(|row| {
                let Outcome::Ran { changes, cost, .. } = &row.outcome else { return None };
                let Change::Told(change) = changes.iter().find(|change| change.quantity == quantity)?.largest else { return None };
                let label = if off { row.variant.effect.clone() } else { format!("{}: {}", row.variant.effect, row.variant.change) };
                let drawn = change.is_finite() && change > 0.0;
                drawn.then(|| Mark { x: cost.cpu / report.cost.cpu.max(1e-9), y: change / size, label, ..Mark::default() })
            })
            .collect()
        };
        let dots = |label: &str, style: usize, marks: Vec<Mark>| Series {
            branches: vec![],
            ..Series::marks(label, Ink { width: 0.0, ..Ink::marks(style) }, marks)
        };
        let series = vec![dots("switched off", 0, marks(true)), dots("something else in its place", 1, marks(false))];
        let axis = format!("largest change of {} [{}]", quantity.words().0, if unit.is_empty() { "-" } else { unit });
        let mut panel = Panel::new(quantity.words().1, ["CPU time over that of the scene", &axis], series);
        panel.y.log = true;
        let error = report.base.iter().find(|base| base.quantity == quantity).map(|base| 2.0 * base.error.largest / size);
        panel.levels = error.filter(|error| *error > 0.0).into_iter().collect();
        Panel { height: 520.0, ..panel }
    };
    let there = |quantity: &Quantity| report.base.iter().any(|base| base.quantity == *quantity);
    Sheet {
        title: format!("What effects change and cost: {}", report.scene),
        subtitles: vec![format!(
            "{}; {} s; dashed: twice the integration's error, below which nothing is resolved",
            report.title,
            rounded(report.stop)
        )],
        columns: 2,
        panels: DRAWN.into_iter().filter(there).map(panel).collect(),
    }
    .draw(file)
}
