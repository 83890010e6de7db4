//! A root between two places at which a function has unlike signs.

/// The root between two places and values of unlike sign, to `accuracy`: false position with the Illinois halving.
pub fn root(mut a: (f64, f64), mut b: (f64, f64), accuracy: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..100 {
        if b.1 == 0.0 || (b.0 - a.0).abs() < accuracy {
            break;
        }
        let place = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
        let next = (place, f(place));
        let moved = (next.0 - b.0).abs();
        if next.1 * b.1 < 0.0 {
            a = b;
        } else {
            a.1 *= 0.5;
        }
        b = next;
        if moved < accuracy {
            break;
        }
    }
    b.0
}
