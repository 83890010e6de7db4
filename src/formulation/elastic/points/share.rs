//! Contacts that share a patch: ridges between neighbouring places, and the share of its force that each place carries.
//!
//! A ridge is a stationary distance like a place, found by the same four equations, but a greatest one. With penetrations
//! d1, d2 of the places, `r = max(0, penetration at the ridge)` and heights above it p = d - r
//!
//! ```text
//! s1 = 1 - (r / d1) p2 / (p1 + p2),   s2 = 1 - (r / d2) p1 / (p1 + p2)
//! ```
//!
//! Such places stay two contacts, each with its own rolling radius, and creep against each other. So do the strips of one patch:
//! where two places h apart differ in rolling radius by dR, the mean spin of the patch is `dR / (R h)`, and the two opposite creep
//! forces have the moment that spin gives one patch. (S1002 on 60E1 near the centre: 0.43 mm, 9.8 mm, so 0.095 1/m; 0.9 kN
//! times 9.8 mm is 9 N m, and the spin moments of the two ellipses add about as much; Kalker's c33 for one ellipse under the same
//! load gives 12 to 18 N m, by its shape.) A place covers the share s of its
//! ellipse's area, so that where both melt together areas, and with them c11 G a b, add up to those of one patch.

use super::Places;
use super::stand::Stand;
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::global::is_least;
use crate::formulation::prediction::{Prediction, prediction};
use crate::formulation::wheel_search::MOST_POINTS;

/// The ridge between two contacts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Saddle {
    /// Numbers of the contacts on both sides, the one of smaller u first.
    pub between: [usize; 2],
    pub parameters: SurfaceParameters,
    /// m, negative where the surfaces are apart.
    pub penetration: f64,
    pub prediction: Prediction,
}

/// Ridges of one wheel, in no order.
pub(super) type Saddles = [Option<Saddle>; MOST_POINTS - 1];

impl Saddle {
    /// The ridge from a place near it; `None` where it is not found between its contacts.
    #[inline]
    pub(super) fn locate(stand: &Stand, start: &SurfaceParameters, between: [usize; 2], places: &Places) -> Option<Saddle> {
        let [below, above] = between.map(|slot| places[slot].as_ref().map(|place| place.location.parameters.wheel));
        let found = stand.pair.locate(start).ok()?;
        let u = found.parameters.wheel;
        (u > below? && u < above? && !is_least(&stand.pair, &found)).then_some(Saddle {
            between,
            parameters: found.parameters,
            penetration: found.penetration,
            prediction: prediction(&stand.pair, &stand.pose, stand.radius, &found),
        })
    }
}

/// Gives each place its share.
#[inline]
pub(super) fn share_out(places: &mut Places, saddles: &Saddles) {
    for Saddle { between: [below, above], penetration, .. } in saddles.iter().flatten() {
        let [one, two] = [below, above].map(|slot| places[*slot].as_ref().map(|place| place.location.penetration));
        if let (Some(one), Some(two)) = (one, two)
            && *penetration > 0.0
        {
            for (slot, own, other) in [(below, one, two), (above, two, one)] {
                if let Some(place) = &mut places[*slot] {
                    place.share *= beside(own, *penetration, other);
                }
            }
        }
    }
}

/// Share of a place of penetration `own` beside a `neighbour` over a pressed `ridge`, m.
#[inline]
fn beside(own: f64, ridge: f64, neighbour: f64) -> f64 {
    let (p, other) = ((own - ridge).max(0.0), (neighbour - ridge).max(0.0));
    let sum = p + other;
    // Rounding may put a ridge below the contact.
    if own > 0.0 { (1.0 - ridge / own * if sum > 0.0 { other / sum } else { 0.5 }).max(0.0) } else { 1.0 }
}

/// Shares of places in a row, from their penetrations and those of the saddles between neighbours, m, 0 where they are apart. The row is divided at
/// its deepest saddle, over which the deeper of each side's places stand as two would, and so on on each side.
pub(in crate::formulation) fn share_row(penetrations: &[f64], saddles: &[f64], shares: &mut [f64]) {
    let deepest = (0..saddles.len()).min_by(|a, b| saddles[*a].total_cmp(&saddles[*b]));
    let Some(k) = deepest else { return };
    let highest = |side: &[f64]| side.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (before, behind) = penetrations.split_at(k + 1);
    let (left, right) = shares.split_at_mut(k + 1);
    let (one, other) = (highest(before), highest(behind));
    left.iter_mut().for_each(|share| *share *= beside(one, saddles[k], other));
    right.iter_mut().for_each(|share| *share *= beside(other, saddles[k], one));
    share_row(before, &saddles[..k], left);
    share_row(behind, &saddles[k + 1..], right);
}

/// Two places that melt together are taken for apart by this part of their penetration: slopes grow without bound there.
const LEAST_HEIGHT: f64 = 0.02;

/// Derivatives of a place's share by its own penetration, by that of the ridge and by the neighbour's, 1/m; and the share.
pub(in crate::formulation) fn share_slopes(own: f64, ridge: f64, neighbour: f64) -> ([f64; 3], f64) {
    if !(ridge > 0.0 && own > 0.0) {
        return ([0.0; 3], 1.0);
    }
    let (p, other) = ((own - ridge).max(0.0), (neighbour - ridge).max(0.0));
    let sum = (p + other).max(LEAST_HEIGHT * own);
    let (part, steep) = (ridge / own, 1.0 / (sum * sum));
    let slopes = [part * other / sum / own + part * other * steep, -other / sum / own - part * (other - p) * steep, -part * p * steep];
    (slopes, 1.0 - part * other / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_slopes_match_differences() {
        for at in [[7e-5, 4e-5, 6e-5], [5e-5, 3e-5, 7e-5], [7e-5, -1e-6, 3e-5]] {
            for j in 0..3 {
                let moved = |sign: f64| {
                    let mut x = at;
                    x[j] += sign * 1e-10;
                    if x[1] > 0.0 { beside(x[0], x[1], x[2]) } else { 1.0 }
                };
                let (found, exact) = ((moved(1.0) - moved(-1.0)) / 2e-10, share_slopes(at[0], at[1], at[2]).0[j]);
                assert!((found - exact).abs() < 1e-4 * (1.0 + exact.abs()), "{at:?} {j}: {found} {exact}");
            }
        }
    }

    #[test]
    fn analytic_shares_of_a_row() {
        let of = |penetrations: &[f64], saddles: &[f64]| {
            let mut shares = vec![1.0; penetrations.len()];
            share_row(penetrations, saddles, &mut shares);
            shares
        };
        let (one, other, ridge) = (7e-5, 4e-5, 2e-5);
        let two = [beside(one, ridge, other), beside(other, ridge, one)];
        assert_eq!(of(&[one], &[]), [1.0]);
        assert_eq!(of(&[one, other], &[ridge]), two);
        // A third that is apart changes nothing, and neither does one that melts into its neighbour.
        assert_eq!(of(&[one, other, 3e-5], &[ridge, 0.0]), [two[0], two[1], 1.0]);
        assert_eq!(of(&[one, 3e-5, other], &[3e-5, ridge]), [two[0], 0.0, two[1]]);
    }

    #[test]
    fn analytic_limits_of_the_shares() {
        // The ridge only just free; one place melts into it; both melt together.
        assert_eq!(beside(7e-5, 0.0, 3e-5), 1.0);
        assert_eq!((beside(7e-5, 3e-5, 3e-5), beside(3e-5, 3e-5, 7e-5)), (1.0, 0.0));
        let (one, two) = (beside(7e-5 + 2e-12, 7e-5, 7e-5 + 1e-12), beside(7e-5 + 1e-12, 7e-5, 7e-5 + 2e-12));
        assert!((one + two - 1.0).abs() < 1e-6 && (one - 2.0 / 3.0).abs() < 1e-3, "{one} {two}");
    }
}
