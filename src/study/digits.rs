//! Numbers as they are written in words.

/// Rounded to six significant digits: what sums of steps and changes of units leave behind them tells nothing.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_words_show_no_rounding_errors() {
        let written =
            [1e3 * 1e-5_f64.next_down(), 0.0015 * 2145.0, 2.1427947358262913, 200.0, 0.0, -1e-7].map(|value| format!("{}", rounded(value)));
        assert_eq!(written, ["0.01", "3.2175", "2.14279", "200", "0", "-0.0000001"]);
    }
}
