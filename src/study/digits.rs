//! Numbers as they are written in words.

/// Rounded to six significant digits: what sums of steps and changes of units leave behind them tells nothing.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Decimal prefix that brings a value between 1 and 1000, and its size.
pub fn prefix(value: f64) -> (&'static str, f64) {
    const PREFIXES: [(&str, f64); 7] = [("k", 1e3), ("", 1.0), ("m", 1e-3), ("u", 1e-6), ("n", 1e-9), ("p", 1e-12), ("f", 1e-15)];
    // What is written as 1000 of the smaller one.
    const NEARLY: f64 = 1.0 - 5e-7;
    PREFIXES.into_iter().find(|prefix| value >= NEARLY * prefix.1).unwrap_or(("", 1.0))
}

/// "0.1 mm", "10 um", "250 N": a size with at most so many significant digits and a prefix before its unit.
pub fn sized(value: f64, unit: &str, digits: usize) -> String {
    // Rounded first: 999.9 mN is 1 N.
    let value: f64 = format!("{:.*e}", digits - 1, value).parse().unwrap_or(value);
    let (letter, size) = match prefix(value) {
        _ if unit.is_empty() => ("", 1.0),
        _ if value < 1e-15 => return format!("0 {unit}"),
        // 0.1 mm is what people say, not 100 um; and no kilometres.
        ("u", _) if unit == "m" && value >= 0.999e-4 => ("m", 1e-3),
        ("k", _) if unit == "m" => ("", 1.0),
        found => found,
    };
    let number = rounded(value / size);
    let number = if number < 1e-3 { format!("{number:e}") } else { format!("{number}") };
    format!("{number} {letter}{unit}").trim_end().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_sizes_are_written_as_people_say_them() {
        let length = |value| sized(value, "m", 2);
        assert_eq!([1e-3, 1e-4, 1e-5, 1e-6, 1e-7].map(length), ["1 mm", "0.1 mm", "10 um", "1 um", "100 nm"]);
        assert_eq!([2.34, 4.57e-13, 0.0, 1234.0].map(length), ["2.3 m", "460 fm", "0 m", "1200 m"]);
        assert_eq!([1e3, 250.0, 1.0, 3.21e-4].map(|value| sized(value, "N", 2)), ["1 kN", "250 N", "1 N", "320 uN"]);
        assert_eq!([0.01, 1e-3, 1e-4].map(|value| sized(value, "", 2)), ["0.01", "0.001", "1e-4"]);
        assert_eq!(sized(0.9996, "N", 2), "1 N");
        assert_eq!([6.304e-7, 55.81].map(|value| sized(value, "m", 3)), ["630 nm", "55.8 m"]);
    }

    #[test]
    fn prop_prefixes_bring_values_between_1_and_1000() {
        for exponent in -15..6 {
            for digit in [1.0, 3.7, 9.99] {
                let value = digit * 10f64.powi(exponent) * (1.0 + 1e-9);
                assert!((1.0..1000.0).contains(&(value / prefix(value).1)), "{value}");
            }
        }
        assert_eq!(prefix(0.0), ("", 1.0));
    }

    #[test]
    fn prop_words_show_no_rounding_errors() {
        let written =
            [1e3 * 1e-5_f64.next_down(), 0.0015 * 2145.0, 2.1427947358262913, 200.0, 0.0, -1e-7].map(|value| format!("{}", rounded(value)));
        assert_eq!(written, ["0.01", "3.2175", "2.14279", "200", "0", "-0.0000001"]);
    }
}
