//! What is reached of an aim "so many times real time at such an error", in words.

/// One measured setting of an integrator.
#[derive(Clone, Debug)]
pub struct Measured {
    pub integrator: String,
    /// Tolerance or step as the scene's file says it.
    pub setting: String,
    /// m.
    pub error: f64,
    /// Times real time, of the fastest run.
    pub factor: f64,
    /// Time of the slowest of the repeated runs over that of the fastest.
    pub spread: f64,
}

/// Times real time at an error [m].
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    pub what: &'static str,
    pub factor: f64,
    pub error: f64,
}

impl Aim {
    /// The fastest setting that is at least as exact as the aim asks for.
    pub fn nearest<'a>(&self, points: &'a [Measured]) -> Option<&'a Measured> {
        points.iter().filter(|point| point.error <= self.error).max_by(|a, b| a.factor.total_cmp(&b.factor))
    }

    /// The largest factor at exactly the aim's error, on straight lines through neighbouring settings of an integrator over logarithmic
    /// axes; with the integrator's name. `points` hold each integrator's settings in order.
    pub fn between<'a>(&self, points: &'a [Measured]) -> Option<(f64, &'a str)> {
        let lines = points.windows(2).filter(|pair| pair[0].integrator == pair[1].integrator);
        let at = lines.filter_map(|pair| {
            let [from, to] = [pair[0].error.ln(), pair[1].error.ln()];
            let place = (self.error.ln() - from) / (to - from);
            (0.0..=1.0).contains(&place).then(|| {
                let factor = (pair[0].factor.ln() * (1.0 - place) + pair[1].factor.ln() * place).exp();
                (factor, pair[0].integrator.as_str())
            })
        });
        at.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// One line.
    pub fn words(&self, points: &[Measured]) -> String {
        let Aim { what, factor, error } = self;
        let mut text = format!("aim: {what}, {factor} times real time at {error:.0e} m: ");
        let (nearest, between) = (self.nearest(points), self.between(points));
        let measured = nearest.map_or(0.0, |point| point.factor);
        let interpolated = between.map_or(0.0, |found| found.0);
        text += match (measured >= *factor, interpolated >= *factor) {
            (true, _) => "reached",
            (false, true) => "reached between two settings",
            (false, false) => "missed",
        };
        if let Some(Measured { integrator, setting, error, factor, spread }) = nearest {
            let slower = 100.0 * (spread - 1.0);
            text += &format!(
                "; measured {factor:.1} times at {error:.1e} m ({integrator} {setting}; the slowest run took {slower:.0} % longer)"
            );
        } else {
            text += "; no setting is that exact";
        }
        if let Some((factor, integrator)) = between {
            text += &format!("; interpolated to {error:.0e} m: {factor:.1} times ({integrator})");
        }
        text
    }
}
