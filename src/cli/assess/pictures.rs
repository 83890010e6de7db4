//! Curves over distance with their limits.

use crate::cli::plot::{Ink, Panel, Series, Sheet};
use crate::study::assess::quantity::Quantity;
use crate::study::assess::{Assessment, Trace};

/// Most curves of a panel: those that come nearest to the limit.
const MOST: usize = 4;

/// Keys of quantities that have a panel.
const SHOWN: [&str; 5] = ["y_over_q", "sum_y", "q_max", "acc_y_ride", "acc_z_ride"];

/// One picture per quantity, so that a colour means one wheel.
pub(super) fn sheets(found: &Assessment) -> Vec<Sheet> {
    let sheet = |panel: Panel| Sheet {
        title: panel.title.clone(),
        subtitles: vec![],
        columns: 1,
        panels: vec![Panel { title: String::new(), ..panel }],
    };
    SHOWN.iter().filter_map(|key| panel(key, found)).map(sheet).collect()
}

fn panel(key: &str, found: &Assessment) -> Option<Panel> {
    let reach = |trace: &&Trace| trace.points.iter().map(|point| point.1.abs()).fold(0.0, f64::max);
    let mut traces: Vec<&Trace> = found.traces.iter().filter(|trace| trace.quantity.key == key && !trace.points.is_empty()).collect();
    traces.sort_by(|a, b| reach(b).total_cmp(&reach(a)));
    traces.truncate(MOST);
    let quantity: &Quantity = traces.first()?.quantity;
    let limit = found.rows.iter().filter(|row| row.key == key).filter_map(|row| row.limit).reduce(f64::min);
    let (lowest, highest) =
        traces.iter().flat_map(|trace| &trace.points).fold((0.0_f64, 0.0_f64), |range, point| (range.0.min(point.1), range.1.max(point.1)));
    // A limit far away would leave a flat line.
    let near = |level: &f64| *level > 3.0 * lowest.min(-0.1 * highest) && *level < 3.0 * highest.max(-0.1 * lowest);
    let levels: Vec<f64> = limit.map(|limit| limit * quantity.factor).into_iter().flat_map(|limit| [limit, -limit]).filter(near).collect();
    let series = traces.iter().enumerate().map(|(style, trace)| {
        let ink = Ink { radius: 0.0, alpha: 0.9, ..Ink::marks(style) };
        Series::line(&trace.place, ink, trace.points.clone())
    });
    let mut panel = Panel::new(quantity.name, ["distance [m]", &format!("{} [{}]", short(key), quantity.unit)], series.collect());
    panel.aside = match limit {
        Some(limit) if levels.is_empty() => {
            format!("limit {:.*} {}", quantity.digits, limit * quantity.factor, quantity.unit.trim_matches('-'))
        }
        _ => String::new(),
    };
    (panel.levels, panel.height) = (levels, 290.0);
    Some(panel)
}

/// On the axis.
fn short(key: &str) -> &'static str {
    match key {
        "y_over_q" => "Y/Q",
        "sum_y" => "sum of Y",
        "q_max" => "Q",
        "acc_y_ride" => "lateral",
        _ => "vertical",
    }
}
