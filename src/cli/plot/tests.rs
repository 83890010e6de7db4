//! Everything that is to be seen is on the sheet, and labels do not cover each other.

use super::*;

fn svg(sheet: &Sheet) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.svg");
    sheet.draw(&file).unwrap();
    std::fs::read_to_string(&file).unwrap()
}

fn sheet(panels: Vec<Panel>) -> Sheet {
    Sheet { title: "Title".into(), subtitles: vec!["one line".into(), "another".into()], columns: 2, panels }
}

#[test]
fn prop_panels_name_every_series_once_and_legends_fit_the_sheet() {
    let mark = |x: f64, y: f64, bound| Mark { x, y, bar: Some((0.9 * x, 1.2 * x)), bound, label: String::new() };
    let series = |style: usize| {
        let marks = vec![mark(1.0 + style as f64, 1e-6, false), mark(3.0, 1e-9, true)];
        Series::marks(&format!("method number {style}"), Ink::marks(style), marks)
    };
    let panel = |title: &str, count: usize| Panel {
        levels: vec![1e-5],
        aside: "a level".into(),
        ..Panel::new(title, ["along", "up"], (0..count).map(series).collect()).log()
    };
    let sheet = sheet(vec![panel("First", 9), panel("Second", 3), panel("Third", 0)]);
    let found = svg(&sheet);
    for word in ["Title", "one line", "another", "First", "Third", "along", "up", "a level", "1e-6", "<polygon"] {
        assert!(found.contains(word), "{word}");
    }
    assert_eq!(found.matches("method number 0\n").count(), 1, "each series stands in the legend once");
    let width = 2.0 * width(2);
    let entries = sheet.legend(width);
    assert!(entries.len() == 9 && entries.iter().all(|entry| entry.1 + 150.0 < width) && entries[8].2 == 1);
    assert!(sheet.scale(&sheet.panels[0].y, |panel| &panel.y, |point| point.1, false).high > 1e-5, "levels are on the sheet");
}

/// Coordinates are finer than pixels, so that a flat curve is no staircase.
#[test]
fn prop_a_flat_curve_is_no_staircase() {
    let points = (0..800).map(|i| (f64::from(i), if i == 0 { 100.0 } else { 1e-3 * f64::from(i) })).collect();
    let found = svg(&sheet(vec![Panel::new("Flat", ["x [m]", "y [m]"], vec![Series::line("", Ink::line(BLUE), points)])]));
    let line = found.split("<polyline").find(|part| part.matches(' ').count() > 300).unwrap();
    let heights: std::collections::BTreeSet<&str> =
        line.split_whitespace().filter_map(|pair| pair.split_once(',')).map(|pair| pair.1).collect();
    assert!(heights.len() > 8, "{} heights within two pixels", heights.len());
}

#[test]
fn prop_axes_of_one_label_share_their_range_and_others_do_not() {
    let line = |high: f64| vec![Series::line("", Ink::line(BLUE), vec![(0.0, 0.0), (high, high)])];
    let sheet = sheet(vec![Panel::new("A", ["x", "a"], line(1.0)), Panel::new("B", ["x", "b"], line(5.0))]);
    let x = |panel: usize| sheet.scale(&sheet.panels[panel].x, |panel| &panel.x, |point| point.0, true);
    let y = |panel: usize| sheet.scale(&sheet.panels[panel].y, |panel| &panel.y, |point| point.1, false);
    assert!(x(0) == x(1) && x(0).high == 5.0 && y(0).high < 1.2 && y(1).high > 5.0);
}

#[test]
fn prop_every_mark_is_named_and_labels_do_not_cover_each_other() {
    let frame = Frame::new((0.0, 0.0), (900.0, 560.0), (Scale::tight([0.0, 1.0].into_iter()), Scale::tight([0.0, 1.0].into_iter())));
    let crowd: Vec<((f64, f64), &str)> =
        (0..9).map(|i| ((400.0 + 3.0 * f64::from(i), 300.0 - 4.0 * f64::from(i)), "a long name")).collect();
    let places: Vec<labels::Label> = labels::place(&crowd, &frame, true).into_iter().flatten().collect();
    assert!(places.len() == 9 && places.iter().any(|label| label.leader().is_some()));
    for (i, first) in places.iter().enumerate() {
        assert!(places[..i].iter().all(|other| !other.area.overlaps(&first.area)), "{:?}", first.area);
    }
    let near: Vec<Option<labels::Label>> = labels::place(&crowd, &frame, false);
    assert!(near.iter().flatten().all(|label| label.leader().is_none()) && near.iter().any(Option::is_none));
    assert!(labels::place(&[((400.0, 300.0), "")], &frame, true)[0].is_none());
}

/// Nothing at all, a single point, no number: a sheet is made of it.
#[test]
fn hard_sheets_without_values_are_drawn() {
    let only = |points| vec![Panel::new("P", ["x", "y"], vec![Series::line("one", Ink::dashed(BLUE), points)])];
    for panels in [vec![], only(vec![]), only(vec![(1.0, 2.0)]), only(vec![(f64::NAN, 1.0), (0.0, f64::INFINITY)])] {
        assert!(svg(&sheet(panels)).contains("Title"));
    }
}

#[test]
fn prop_lines_are_wrapped_between_words() {
    assert_eq!(wrapped("one two  three", 7), ["one two", "three"]);
    assert_eq!(wrapped("", 7), Vec::<String>::new());
}
