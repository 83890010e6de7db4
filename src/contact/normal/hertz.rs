//! Hertz's theory of elliptic contact.

use super::curvature::{self, Across, AcrossUnder, Conformal, Rule};
use super::hertz_integrals::EllipseFunctions;
use super::hertz_table::{EllipseTable, SharedTable};
use super::{Build, ConformalContact, ContactShape, ElasticContact, NormalLaw};
use crate::contact::{Material, Patch};
use crate::settings::{Entry, Section, SettingsError};
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "hertz",
    summary: "elliptic contact of elastic bodies, K_h from the curvatures at the contact or over the patch",
    reference: "Hertz 1882; Johnson, Contact Mechanics (1985), chapter 4; paper, Eq. 28",
    parse,
};

/// `N = K_h delta^1.5` with `K_h = 2 E / (3 (1 - nu^2)) xi^-1.5 (A + B)^-0.5`, wheel and rail of the same material.
///
/// The patch is that of the elastic force: `a = m_a c0`, `b = m_b c0`, `c0^2 = delta / (xi (A + B))`, so it depends
/// on the penetration alone. (With damping, N differs from the elastic force while the penetration changes.) What B is, see
/// `curvature.rs`.
///
/// At a given penetration K_h falls with B like `d ln K_h / d ln B = -B b^2 / (2 delta)`: the elastic energy 2/5 N delta changes by
/// -N b^2 / 5, the work of the pressures on the gap y^2 dB, because they make that energy stationary. So
/// `dN/d delta = N / delta (3/2 - B b^2 / (2 delta) d ln B / d ln delta)`.
#[derive(Debug)]
pub struct Hertz {
    /// 2 E / (3 (1 - nu^2)), Pa.
    modulus: f64,
    table: SharedTable,
    rule: Rule,
}

impl Hertz {
    /// With the curvatures at the contact point; where surfaces are conformal there the law says so.
    pub fn at_the_point(material: Material) -> Self {
        Self::with(material, Rule { across: Across::Point, conformal: Conformal::Error })
    }

    /// With the curvature across taken over the patch, bounded where surfaces are conformal: the default of scenes.
    pub fn over_the_patch(material: Material) -> Self {
        Self::with(material, Rule { across: Across::Patch, conformal: Conformal::Bounded })
    }

    pub(super) fn with(material: Material, rule: Rule) -> Self {
        let modulus = 2.0 * material.youngs_modulus / (3.0 * (1.0 - material.poisson_ratio * material.poisson_ratio));
        Hertz { modulus, table: EllipseTable::shared(), rule }
    }
}

/// Relative accuracy of a penetration whose curvature depends on it, and evaluations for it.
const SETTLED: f64 = 1e-10;
const EVALUATIONS: usize = 30;

impl Hertz {
    /// The ellipse's functions, A + B and K_h.
    #[inline]
    fn ellipse(&self, rolling: f64, AcrossUnder { across, .. }: AcrossUnder) -> Result<(EllipseFunctions, f64, f64), ConformalContact> {
        if !(rolling > 0.0 && across > 0.0) {
            return Err(ConformalContact { rolling, across });
        }
        let functions = self.table.at((across / rolling).ln());
        let sum = rolling + across;
        Ok((functions, sum, self.modulus / (functions.approach * (functions.approach * sum).sqrt())))
    }

    /// The curvature over the patch that belongs to `force`: `delta = (N / K_h(B(delta)))^(2/3)` by secants between bounds. N
    /// grows with delta, so the right side exceeds delta below the root and falls short of it above.
    fn across_under(&self, shape: &ContactShape, force: f64) -> Result<AcrossUnder, ConformalContact> {
        let image = |across: AcrossUnder| {
            let (.., stiffness) = self.ellipse(shape.rolling, across)?;
            let root = (force / stiffness).cbrt();
            Ok(root * root)
        };
        let mut penetration = image(AcrossUnder { across: self.rule.guess(shape), exponent: 0.0 })?;
        let mut across = self.rule.across(shape, penetration)?;
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut last: Option<(f64, f64)> = None;
        for _ in 1..EVALUATIONS {
            let found = image(across)?;
            let difference = found - penetration;
            if difference.abs() <= SETTLED * found {
                break;
            }
            if difference > 0.0 {
                low = penetration
            } else {
                high = penetration
            }
            let mut next = last.map_or(found, |(image_before, difference_before)| {
                found - difference / (difference - difference_before) * (found - image_before)
            });
            if !(next > low && next < high) {
                next = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low };
            }
            last = Some((found, difference));
            penetration = next;
            across = self.rule.across(shape, penetration)?;
        }
        Ok(across)
    }
}

/// Patch whose centre has approached by `penetration`.
#[inline]
fn patch(functions: &EllipseFunctions, sum: f64, penetration: f64) -> Patch {
    let c0 = (penetration / (functions.approach * sum)).sqrt();
    Patch { a: functions.m_a * c0, b: functions.m_b * c0 }
}

/// dN/d delta, N/m.
#[inline]
fn slope(found: AcrossUnder, patch: &Patch, penetration: f64, force: f64) -> f64 {
    // Nothing presses: 0 / 0.
    if !(penetration > 0.0) {
        return 0.0;
    }
    let per_penetration = 1.0 / penetration;
    force * per_penetration * (1.5 - 0.5 * found.across * patch.b * patch.b * per_penetration * found.exponent)
}

impl NormalLaw for Hertz {
    #[inline]
    fn contact(&self, shape: &ContactShape, penetration: f64) -> Result<ElasticContact, ConformalContact> {
        let across = self.rule.across(shape, penetration)?;
        let (functions, sum, stiffness) = self.ellipse(shape.rolling, across)?;
        let (force, patch) = (stiffness * penetration * penetration.sqrt(), patch(&functions, sum, penetration));
        Ok(ElasticContact { stiffness, force, slope: slope(across, &patch, penetration, force), patch })
    }

    #[inline]
    fn contact_under(&self, shape: &ContactShape, force: f64) -> Result<(f64, ElasticContact), ConformalContact> {
        let across = if self.rule.needs_penetration() { self.across_under(shape, force)? } else { self.rule.across(shape, 0.0)? };
        let (functions, sum, stiffness) = self.ellipse(shape.rolling, across)?;
        let root = (force / stiffness).cbrt();
        let penetration = root * root;
        let patch = patch(&functions, sum, penetration);
        Ok((penetration, ElasticContact { stiffness, force, slope: slope(across, &patch, penetration, force), patch }))
    }

    fn describe(&self) -> String {
        self.rule.describe()
    }
}

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let rule = curvature::parse(section)?;
    Ok(Arc::new(move |material| Box::new(Hertz::with(material, rule))))
}

#[cfg(test)]
mod tests {
    use super::super::curvature::{Across, Conformal};
    use super::super::test_surfaces::Stand;
    use super::*;
    use crate::contact::search::algebraic::SurfaceParameters;

    impl Hertz {
        /// Curvatures at the point; conformal contact is an error.
        fn new(material: Material) -> Self {
            Self::with(material, Rule { across: Across::Point, conformal: Conformal::Error })
        }
    }

    #[test]
    fn validate_crossed_cylinders() {
        // Cylinders of 0.46 m and 0.30 m radius, 100 kN, E 210 GPa, nu 0.3: a 7.1617 mm, b 5.3872 mm, approach
        // 0.104119 mm (complete elliptic integrals, another program; see docs/sources.md).
        let law = Hertz::new(Material { youngs_modulus: 2.1e11, poisson_ratio: 0.3 });
        let contact = law.contact(&ContactShape::of_constant_curvature(0.5 / 0.46, 0.5 / 0.30), 0.104119e-3).unwrap();
        assert!((contact.force / 1e5 - 1.0).abs() < 2e-5, "{}", contact.force);
        assert!((contact.patch.a - 7.1617e-3).abs() < 1e-7 && (contact.patch.b - 5.3872e-3).abs() < 1e-7, "{:?}", contact.patch);
    }

    #[test]
    fn analytic_sphere_on_plane() {
        // Sphere of radius R: N = 4/3 E* sqrt(R) delta^1.5, a^2 = R delta.
        let law = Hertz::new(Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 });
        let (radius, delta) = (0.4, 5e-5);
        let contact = law.contact(&ContactShape::of_constant_curvature(0.5 / radius, 0.5 / radius), delta).unwrap();
        let modulus = 2.07e11 / (2.0 * (1.0 - 0.28f64.powi(2)));
        let force = 4.0 / 3.0 * modulus * f64::sqrt(radius) * delta.powf(1.5);
        assert!((contact.force / force - 1.0).abs() < 1e-10);
        assert!((contact.patch.a / (radius * delta).sqrt() - 1.0).abs() < 1e-10);
        assert!((contact.patch.b - contact.patch.a).abs() < 1e-12);
    }

    #[test]
    fn analytic_patch_carries_the_force_with_the_hertzian_pressure() {
        // p0 = 3 N / (2 pi a b) must equal the pressure that the approach formula implies: the two expressions
        // for c0 (from N and from delta) agree.
        let law = Hertz::new(Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 });
        for across in [0.2, 1.0, 1.7, 40.0] {
            let (rolling, delta) = (1.09, 6e-5);
            let contact = law.contact(&ContactShape::of_constant_curvature(rolling, across), delta).unwrap();
            let exact = super::super::hertz_integrals::ellipse_functions_exact((across / rolling).ln());
            let c0 = (3.0 * contact.force * (1.0 - 0.28f64.powi(2)) / (2.0 * 2.07e11 * (rolling + across))).cbrt();
            assert!((contact.patch.a / (exact.m_a * c0) - 1.0).abs() < 1e-10);
            assert!((contact.patch.b / (exact.m_b * c0) - 1.0).abs() < 1e-10);
            assert!((delta / (exact.approach * (rolling + across) * c0 * c0) - 1.0).abs() < 1e-10);
        }
    }

    #[test]
    fn analytic_force_and_penetration_are_inverse() {
        let law = Hertz::new(Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 });
        for delta in [1e-7, 6e-5, 1e-3] {
            let contact = law.contact(&ContactShape::of_constant_curvature(1.09, 1.7), delta).unwrap();
            let (found, under) = law.contact_under(&ContactShape::of_constant_curvature(1.09, 1.7), contact.force).unwrap();
            assert!((found / delta - 1.0).abs() < 1e-14 && (under.patch.a / contact.patch.a - 1.0).abs() < 1e-14);
        }
        assert_eq!(law.contact_under(&ContactShape::of_constant_curvature(1.09, 1.7), 0.0).unwrap().1.patch, Patch::default());
    }

    #[test]
    fn analytic_slope_is_the_derivative_of_the_force() {
        let stand = Stand::s1002_on_60e1();
        let mut worst = [0.0f64; 4];
        let rules = [
            (Across::Point, Conformal::Error),
            (Across::Patch, Conformal::Error),
            (Across::Patch, Conformal::Bounded),
            (Across::Stated(0.3), Conformal::Error),
        ];
        for (worst, (across, conformal)) in worst.iter_mut().zip(rules) {
            let law = Hertz::with(Material { youngs_modulus: 2.1e11, poisson_ratio: 0.3 }, Rule { across, conformal });
            for i in 0..200 {
                let (y, start) = (-3e-3 + 3.5e-5 * f64::from(i), if i < 110 { 0.0 } else { -0.011 });
                let start = SurfaceParameters { rail: start, wheel: start, ..Default::default() };
                for delta in [2e-5, 7e-5, 1.5e-4] {
                    let Some(found) = stand.pressed(y, delta, &start) else { continue };
                    let shape = found.shape(&stand.wheel, &stand.rail);
                    let at = |delta: f64| law.contact(&shape, delta).unwrap();
                    let (middle, h) = (at(delta), 1e-4 * delta);
                    let difference = (at(delta + h).force - at(delta - h).force) / (2.0 * h);
                    *worst = worst.max((middle.slope / difference - 1.0).abs());
                    let (_, under) = law.contact_under(&shape, middle.force).unwrap();
                    assert!((under.slope / middle.slope - 1.0).abs() < 1e-6, "{y} {delta}: {} {}", under.slope, middle.slope);
                }
            }
        }
        println!("slopes are off by {:?}", worst.map(|worst| format!("{worst:.1e}")));
        // The nodes of the quadrature move with the penetration.
        assert!(worst[0] < 1e-8 && worst[3] < 1e-8 && worst[1] < 2e-3 && worst[2] < 2e-3, "{worst:?}");
    }

    #[test]
    fn hard_hollow_surfaces_are_refused() {
        let law = Hertz::new(Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 });
        assert_eq!(
            law.contact(&ContactShape::of_constant_curvature(1.1, -0.1), 1e-5).unwrap_err(),
            ConformalContact { rolling: 1.1, across: -0.1 }
        );
    }
}
