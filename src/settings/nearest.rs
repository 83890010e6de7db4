//! "Did you mean": the known word that is nearest to what was written.

/// Likeness (Jaro and Winkler) from which on a word is offered.
const LIKE: f64 = 0.75;

/// ` (did you mean "x"?)` when some allowed word is close. Capitals and signs between letters don't count: "FRA4" is near to "fra_4".
pub fn did_you_mean(word: &str, allowed: &[&str]) -> String {
    nearest(word, allowed).map(|best| format!(" (did you mean \"{best}\"?)")).unwrap_or_default()
}

/// The allowed word that is closest, if one is close; the first of equals.
pub(super) fn nearest<'a>(word: &str, allowed: &[&'a str]) -> Option<&'a str> {
    closest(word, allowed, LIKE, &[])
}

/// The word that is `word` but for a slip of the pen, if there is one; the `likely` ones among them are preferred where nearly as close.
pub(super) fn slip<'a>(word: &str, others: &[&'a str], likely: &[&str]) -> Option<&'a str> {
    const SLIP: f64 = 0.87;
    closest(word, others, SLIP, likely)
}

/// So much nearer is a word that is likely.
const LIKELY: f64 = 0.02;

fn closest<'a>(word: &str, allowed: &[&'a str], least: f64, likely: &[&str]) -> Option<&'a str> {
    let (whole, bare) = (word.to_lowercase(), bare(word));
    let likeness = |known: &str| {
        let same = strsim::jaro_winkler(&whole, &known.to_lowercase());
        // The same letters are nearer than any other word.
        if !bare.is_empty() && bare == self::bare(known) { 2.0 } else { same }
    };
    let mut best: Option<(&str, f64)> = None;
    for known in allowed {
        let found = likeness(known) + if likely.contains(known) { LIKELY } else { 0.0 };
        if found > least && best.is_none_or(|best| found > best.1) {
            best = Some((known, found));
        }
    }
    best.map(|best| best.0)
}

/// Letters and digits alone, all small.
fn bare(word: &str) -> String {
    word.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_capitals_and_signs_do_not_hide_a_word() {
        let cases: [(&str, &[&str], &str); 6] = [
            ("FRA4", &["fra_4", "fra_5", "orre"], "fra_4"),
            ("ecf-a", &["ACCF", "ECCF", "ECF-A", "ECF-N"], "ECF-A"),
            ("Hertz", &["assumed", "hertz"], "hertz"),
            ("S1002", &["cone", "s1002"], "s1002"),
            ("FRICTON", &["friction", "points"], "friction"),
            ("dormand-prince", &["dormand_prince", "rk4"], "dormand_prince"),
        ];
        for (word, allowed, meant) in cases {
            assert_eq!(nearest(word, allowed), Some(meant), "{word}");
        }
        assert_eq!(slip("frction", &["friction", "friction_along"], &["friction_along"]), Some("friction"));
        assert_eq!(slip("guage", &["gauge", "gauge_depth"], &["gauge_depth"]), Some("gauge"));
        assert_eq!(nearest("xyz", &["friction"]), None);
        assert_eq!(did_you_mean("hertzz", &["hertz"]), " (did you mean \"hertz\"?)");
    }
}
