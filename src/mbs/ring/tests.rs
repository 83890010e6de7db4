//! The ring against Floquet's solution of the infinite track, closed formulas, and a second integration.

use super::*;
use nalgebra::{Complex, Matrix4, Matrix4x2, Vector4};
use std::f64::consts::{PI, TAU};

type C = Complex<f64>;

/// A 60E1 rail on concrete sleepers (formulation::rail_beam has the sources).
pub(super) fn bay() -> Bay {
    Bay {
        bending: 210e9 * 3038.3e-8,
        shear: 0.4 * 81e9 * 76.7e-4,
        mass: 60.21,
        rotary: 7850.0 * 3038.3e-8,
        loss: 0.0,
        spacing: 0.6,
        pad_stiffness: 350e6,
        pad_damping: 28e3,
        sleeper_mass: 162.0,
        ballast_stiffness: 50e6,
        ballast_damping: 80e3,
    }
}

/// exp(A h) by its series, A of (w, psi, M, Q) along the rail.
fn along(bay: &Bay, w: f64, h: f64) -> Matrix4<C> {
    let mut a = Matrix4::<C>::zeros();
    (a[(0, 1)], a[(0, 3)]) = (C::from(1.0), C::from(1.0 / bay.shear));
    a[(1, 2)] = C::from(1.0 / bay.bending);
    (a[(2, 1)], a[(2, 3)]) = (C::from(-bay.rotary * w * w), C::from(-1.0));
    a[(3, 0)] = C::from(-bay.mass * w * w);
    // Forces in MN: states of one size.
    let scale = Matrix4::from_diagonal(&Vector4::new(1.0, 1.0, 1e7, 1e7).map(C::from));
    let a = scale.try_inverse().unwrap() * a * scale * C::from(h / 64.0);
    let (mut sum, mut term) = (Matrix4::identity(), Matrix4::identity());
    for n in 1..30 {
        term = term * a / C::from(f64::from(n));
        sum += term;
    }
    (0..6).fold(sum, |power, _| power * power)
}

/// Receptance of the infinite track at `x` from a sleeper: waves that die out to the right and to the left of the force.
fn floquet(bay: &Bay, x: f64, w: f64) -> C {
    let i = C::new(0.0, 1.0);
    let below = i * w * bay.ballast_damping + bay.ballast_stiffness - w * w * bay.sleeper_mass;
    let pad = i * w * bay.pad_damping + bay.pad_stiffness;
    let mut support = Matrix4::<C>::identity();
    support[(3, 0)] = pad * below / (pad + below) / 1e7;
    let bay_ahead = along(bay, w, x) * support * along(bay, w, bay.spacing - x);
    let dominant = |step: Matrix4<C>| {
        let mut space = Matrix4x2::from_fn(|r, c| C::new(1.0 + (r * 3 + c) as f64, (r as f64 - 1.3 * c as f64).sin()));
        for _ in 0..20_000 {
            space = (step * space).qr().q();
        }
        space
    };
    let (left, right) = (dominant(bay_ahead), dominant(bay_ahead.try_inverse().unwrap()));
    let mut both = Matrix4::zeros();
    both.fixed_columns_mut::<2>(0).copy_from(&right);
    both.fixed_columns_mut::<2>(2).copy_from(&(-left));
    let parts = both.lu().solve(&Vector4::new(C::default(), C::default(), C::default(), C::from(-1e-7))).unwrap();
    (right * parts.fixed_rows::<2>(0))[0]
}

/// What is off is what modes left out give way, and, where waves go far (1 kHz), those that come round: in parts of the sag at rest, and of the receptance itself with many modes.
#[test]
fn analytic_receptance_of_the_infinite_track() {
    let bay = bay();
    let sag = floquet(&bay, 0.0, TAU).norm();
    let mut wrong = Vec::new();
    for (highest, bays, of_sag) in
        [(1500.0, 40, 0.06), (1500.0, 160, 0.055), (3000.0, 40, 0.04), (3000.0, 160, 0.015), (20_000.0, 160, 0.005)]
    {
        let ring = Ring::new(&bay, bays, TAU * highest);
        let (mut worst, mut relative): (f64, f64) = (0.0, 0.0);
        for f in [1.0, 30.0, 80.0, 150.0, 250.0, 400.0, 600.0, 800.0, 900.0, 1000.0, 1100.0, 1200.0, 1400.0] {
            for x in [0.0, 0.15, 0.3] {
                let (own, exact) = (at(&ring, x, TAU * f), floquet(&bay, x, TAU * f));
                let off = (own - exact).norm();
                println!(
                    "{highest} Hz, {bays} bays ({} modes): {f} Hz at {x} m: {:.3e} m/N, off by {:.4} of itself, {:.4} of the sag",
                    ring.modes(),
                    exact.norm(),
                    off / exact.norm(),
                    off / sag
                );
                (worst, relative) = (worst.max(off / sag), relative.max(off / exact.norm()));
            }
        }
        println!("{highest} Hz, {bays} bays: worst {worst:.4} of the sag, {relative:.4} of itself");
        if worst > of_sag {
            wrong.push(format!("{highest} Hz, {bays} bays: {worst}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Over the sleepers the pinned-pinned wave does not move them: a simply supported Timoshenko beam of one bay.
#[test]
fn analytic_pinned_pinned_frequency() {
    let bay = bay();
    let ring = Ring::new(&bay, 40, TAU * 1500.0);
    let k = PI / bay.spacing;
    // rho A rho I w^4 - (rho A (EI k^2 + S) + rho I S k^2) w^2 + EI S k^4 = 0
    let (a, c) = (bay.mass * bay.rotary, bay.bending * bay.shear * k.powi(4));
    let b = bay.mass * (bay.bending * k * k + bay.shear) + bay.rotary * bay.shear * k * k;
    let square = 2.0 * c / (b + (b * b - 4.0 * a * c).sqrt());
    let found = ring.squares().iter().copied().min_by(|x, y| (x - square).abs().total_cmp(&(y - square).abs())).unwrap();
    println!("pinned-pinned: {} Hz (Euler beam: {} Hz)", square.sqrt() / TAU, (bay.bending / bay.mass).sqrt() * k * k / TAU);
    assert!((found / square - 1.0).abs() < 1e-12, "{found} {square}");
    // Midspan answers most where a sleeper answers least.
    let at = |x: f64| ring.receptance(x, x, square.sqrt()).norm();
    assert!(at(0.3) > 10.0 * at(0.0), "{} {}", at(0.3), at(0.0));
}

/// A beam on Winkler's foundation with shear: `k / (8 EI) ..` at rest, as long as bays are short beside the wave of the rail.
#[test]
fn analytic_sag_is_that_of_a_beam_on_an_elastic_foundation() {
    // Soft supports, close together.
    let bay = Bay { spacing: 0.2, pad_stiffness: 20e6, ballast_stiffness: 20e6, ..bay() };
    let ring = Ring::new(&bay, 120, TAU * 20_000.0);
    let foundation = 10e6 / bay.spacing;
    // w = F int dk / (2 pi (u + EI k^4 S / (S + EI k^2)))
    let of = |k: f64| 1.0 / (foundation + bay.bending * k.powi(4) * bay.shear / (bay.shear + bay.bending * k * k));
    let (count, top): (usize, f64) = (400_000, 400.0);
    let h = top / count as f64;
    let sum: f64 = (0..count).map(|n| of((n as f64 + 0.5) * h) * h).sum::<f64>() + 1.0 / (bay.shear * top);
    let winkler = sum / PI;
    let euler = 1.0 / (8.0 * bay.bending * (foundation / (4.0 * bay.bending)).powf(0.75));
    let found = ring.receptance(0.1, 0.1, 0.0).re;
    println!("sag {found:.4e} m/N; Winkler with shear {winkler:.4e}, without {euler:.4e}");
    assert!((found / winkler - 1.0).abs() < 2e-3);
    assert!((ring.mean_compliance(0.0, 0.0) / winkler - 1.0).abs() < 2e-3);
}

/// A constant force that travels: the closed form solves the equations of the modes, and their integration from it stays on it.
#[test]
fn analytic_a_travelling_force_leaves_the_rail_as_the_closed_form_says() {
    let ring = Ring::new(&Bay { loss: 0.02, ..bay() }, 40, TAU * 1500.0);
    let n = ring.modes();
    for speed in [0.0, 20.0, 60.0] {
        let at = |x: f64| {
            let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
            ring.carried(x, speed, &mut q, &mut v);
            [q, v].concat()
        };
        let rates = |x: f64, y: &[f64]| {
            let [mut dq, mut dv, mut shape, mut slope] = [0; 4].map(|_| vec![0.0; n]);
            ring.rates(&y[..n], &y[n..], &mut dq, &mut dv);
            ring.shapes(x, &mut shape, &mut slope);
            dv.iter_mut().zip(&shape).for_each(|(dv, phi)| *dv += phi);
            [dq, dv].concat()
        };
        // Classical Runge-Kutta over two bays.
        let (h, steps) = (1e-5, if speed > 0.0 { (1.2 / speed / 1e-5) as usize } else { 1000 });
        let (mut x, mut y) = (0.37, at(0.37));
        let plus = |y: &[f64], k: &[f64], h: f64| y.iter().zip(k).map(|(y, k)| y + h * k).collect::<Vec<f64>>();
        for _ in 0..steps {
            let k1 = rates(x, &y);
            let k2 = rates(x + 0.5 * h * speed, &plus(&y, &k1, 0.5 * h));
            let k3 = rates(x + 0.5 * h * speed, &plus(&y, &k2, 0.5 * h));
            let k4 = rates(x + h * speed, &plus(&y, &k3, h));
            for i in 0..2 * n {
                y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
            x += h * speed;
        }
        let expected = at(x);
        let size = expected[..n].iter().fold(0.0, |most: f64, q| most.max(q.abs()));
        let off = y[..n].iter().zip(&expected).fold(0.0, |most: f64, (own, expected)| most.max((own - expected).abs()));
        println!("{speed} m/s: off by {:.1e} of the largest coordinate", off / size);
        assert!(off < 1e-5 * size, "{speed}: {off} of {size}");
    }
}

/// Force and displacement by the same shape: what a force does on the moving rail is its energy and heat.
#[test]
fn prop_energy_is_kept_under_a_travelling_force() {
    let ring = Ring::new(&Bay { loss: 0.02, ..bay() }, 12, TAU * 1500.0);
    let n = ring.modes();
    let (mut shape, mut slope) = (vec![0.0; n], vec![0.0; n]);
    let (q, v): (Vec<f64>, Vec<f64>) = (0..n).map(|i| (1e-3 * (i as f64).sin(), 0.1 * (3.0 * i as f64).cos())).unzip();
    let (mut dq, mut dv) = (vec![0.0; n], vec![0.0; n]);
    ring.rates(&q, &v, &mut dq, &mut dv);
    ring.shapes(1.234, &mut shape, &mut slope);
    let force = 1e4;
    let mut power = -ring.energy(&q, &v).1;
    power += force * shape.iter().zip(&v).map(|(phi, v)| phi * v).sum::<f64>();
    let change: f64 = (0..n).map(|i| ring.squares[i] * q[i] * dq[i] + v[i] * (dv[i] + shape[i] * force)).sum();
    assert!((change / power - 1.0).abs() < 1e-12, "{change} {power}");
    assert!(ring.energy(&q, &v).1 > 0.0);
}

/// Slopes are those of the shapes, over nodes of the table, sleepers and the place where the ring closes.
#[test]
fn prop_shapes_are_smooth() {
    let ring = Ring::new(&bay(), 14, TAU * 3000.0);
    let n = ring.modes();
    let at = |x: f64| {
        let (mut shape, mut slope) = (vec![0.0; n], vec![0.0; n]);
        ring.shapes(x, &mut shape, &mut slope);
        (shape, slope)
    };
    let h = 1e-5;
    for x in [0.0, 0.6, 1.234, 3.0125, 8.4, 8.39, -0.01] {
        let ((ahead, _), (behind, _), (_, slope)) = (at(x + h), at(x - h), at(x));
        for i in 0..n {
            let found = (ahead[i] - behind[i]) / (2.0 * h);
            assert!((found - slope[i]).abs() < 1e-5 * ring.largest(i) * 10.0, "{x} {i}: {found} {}", slope[i]);
        }
    }
    let (a, b) = (at(0.7).0, at(0.7 + ring.length()).0);
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12));
}

/// Factors solve what they are of.
#[test]
fn prop_factors_of_the_modes_solve() {
    let ring = Ring::new(&Bay { loss: 0.02, ..bay() }, 12, TAU * 2500.0);
    let (n, a) = (ring.modes(), 3e-4);
    let mut factors = Vec::new();
    ring.factorise(a, &mut factors);
    let x: Vec<f64> = (0..n).map(|i| (1.7 * i as f64).sin()).collect();
    let mut found = x.clone();
    ring.solve(&factors, &mut found);
    let (mut dq, mut dv) = (vec![0.0; n], vec![0.0; n]);
    let scaled: Vec<f64> = found.iter().map(|x| a * x).collect();
    ring.rates(&scaled, &found, &mut dq, &mut dv);
    for i in 0..n {
        assert!((found[i] - a * dv[i] - x[i]).abs() < 1e-12);
    }
}

/// Displacement at a place for a force there, with what modes leave out.
fn at(ring: &Ring, x: f64, w: f64) -> C {
    let LeftOut { compliance, square, .. } = ring.left_out();
    ring.receptance(x, x, w) + compliance * ring.left_out().shape(x)[0].powi(2) / (1.0 - w * w / square)
}

/// What is left out stands for itself: the sag at rest over the bay is that of all modes. With the frequency grows what the damping of pads, which works between modes, has of those
/// that are left out.
#[test]
fn analytic_what_modes_leave_out_is_given_back() {
    let damped = Bay { loss: 0.02, ..bay() };
    let full = Ring::new(&damped, 400, TAU * 36_000.0);
    let rest = at(&full, 0.0, 0.0).norm();
    for (highest, bays, bound) in
        [(1500.0, 40, 0.03), (3000.0, 40, 0.011), (3000.0, 160, 0.011), (6000.0, 160, 0.006), (20_000.0, 160, 0.004)]
    {
        let ring = Ring::new(&damped, bays, TAU * highest);
        let mut found = [0.0f64; 3];
        let mut bare = [0.0f64; 3];
        for f in [0.0, 30.0, 80.0, 150.0, 250.0, 400.0, 550.0, 700.0, 850.0, 1000.0, 1100.0, 1200.0, 1400.0] {
            for x in [0.0, 0.15, 0.3] {
                let exact = at(&full, x, TAU * f);
                let within = [f == 0.0, f <= 700.0, true];
                for (k, _) in within.iter().enumerate().filter(|(_, within)| **within) {
                    found[k] = found[k].max((at(&ring, x, TAU * f) - exact).norm() / rest);
                    bare[k] = bare[k].max((ring.receptance(x, x, TAU * f) - exact).norm() / rest);
                }
            }
        }
        println!(
            "{highest} Hz, {bays} bays, {} modes: at rest, up to 700 and 1400 Hz {found:.5?} of the sag; {bare:.5?} without",
            ring.modes()
        );
        assert!(found[0] < 6e-4 && found[2] < bound, "{found:?}");
        assert!(bare[0] > 30.0 * found[0] || highest > 6000.0);
    }
}
