//! Table and pictures as one page that needs nothing beside it.

use super::{pictures, report};
use crate::study::assess::{Assessment, Verdict};

const STYLE: &str = "body{font:16px/1.45 sans-serif;max-width:76rem;margin:2rem auto;padding:0 1rem;color:#222}\
h1{font-size:1.5rem}h2{font-size:1.15rem;margin:1.6rem 0 .4rem}\
table{border-collapse:collapse;width:100%}th,td{padding:.25rem .6rem;text-align:left;border-bottom:1px solid #ddd;vertical-align:top}\
th{font-weight:600;border-bottom:2px solid #888}td.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}\
.pass{color:#00664b}.fail{color:#fff;background:#b33c00;font-weight:600}.open{color:#777}.note{color:#555;font-size:.9em}\
svg{width:100%;height:auto}";

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The page.
///
/// # Errors
/// In words, where a picture can't be drawn.
pub(super) fn page(title: &str, input: &str, found: &Assessment) -> Result<String, String> {
    let [run, sections] = report::head(found).map(|line| escaped(&line));
    let title = escaped(title);
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}</style></head>\n<body>\n\
         <h1>{title}</h1>\n<p>{}: {run}<br>{sections}</p>\n<p><strong>{}</strong></p>\n",
        escaped(input),
        escaped(&report::verdict(found))
    );
    for (group, rows) in report::groups(found) {
        text += &format!(
            "<h2>{group}</h2>\n<table>\n<tr><th>quantity</th><th>track</th><th>where</th><th>value</th><th>limit</th><th>verdict</th>\
             <th>note</th><th>source</th></tr>\n"
        );
        for row in rows {
            let class = match row.verdict {
                Verdict::Pass => "pass",
                Verdict::Fail => "fail",
                Verdict::Value | Verdict::NotAssessable => "open",
            };
            let [name, zone, place, value, limit, verdict] = report::cells(row).map(|cell| escaped(&cell));
            text += &format!(
                "<tr><td>{name}</td><td>{zone}</td><td>{place}</td><td class=\"n\">{value}</td><td class=\"n\">{limit}</td>\
                 <td class=\"{class}\">{verdict}</td><td class=\"note\">{}</td><td class=\"note\">{}</td></tr>\n",
                escaped(&row.note),
                escaped(row.quantity.source)
            );
        }
        text += "</table>\n";
    }
    text += "<h2>Over distance</h2>\n<p>Filtered as assessed; the four curves that come furthest; dashed: limit</p>\n";
    for sheet in pictures::sheets(found) {
        let svg = sheet.svg().map_err(|error| format!("the pictures can't be drawn: {error}"))?;
        // Inside a page the drawing needs no declaration of its own.
        text += &format!("{}\n", svg.find("<svg").map_or(svg.as_str(), |at| &svg[at..]));
    }
    Ok(text + "</body>\n</html>\n")
}
