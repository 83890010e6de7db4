//! A root between two places at which a function has unlike signs.

/// Two places with their values, which are of unlike sign; the second is the newer one.
#[derive(Clone, Copy, Debug)]
pub struct Bracket {
    pub a: (f64, f64),
    pub b: (f64, f64),
}

impl Bracket {
    /// Where false position looks next.
    pub fn place(&self) -> f64 {
        let Bracket { a, b } = self;
        (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1)
    }

    /// Takes a place between both with its value. An end that stays counts half (Illinois).
    pub fn take(&mut self, next: (f64, f64)) {
        if next.1 * self.b.1 < 0.0 {
            self.a = self.b;
        } else {
            self.a.1 *= 0.5;
        }
        self.b = next;
    }
}

/// The root between two places and values of unlike sign, to `accuracy`: false position with the Illinois halving.
pub fn root(a: (f64, f64), b: (f64, f64), accuracy: f64, f: impl Fn(f64) -> f64) -> f64 {
    let mut ends = Bracket { a, b };
    for _ in 0..100 {
        let Bracket { a, b } = ends;
        if b.1 == 0.0 || (b.0 - a.0).abs() < accuracy {
            break;
        }
        let place = ends.place();
        ends.take((place, f(place)));
        if (place - b.0).abs() < accuracy {
            break;
        }
    }
    ends.b.0
}
