use super::generate::Shape;
use super::*;
use crate::contact::Patch;
use crate::contact::creepage::Creepage;
use proptest::prelude::*;
use std::sync::LazyLock;

static LAW: LazyLock<UseTab> = LazyLock::new(|| law(0.28));

fn law(nu: f64) -> UseTab {
    UseTab::new(Material { youngs_modulus: 2.1e11, poisson_ratio: nu }).unwrap()
}

/// Numbers in [0, 1) that are the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// (X, Y, Z) of a size from linear (0.05) to full slip (20).
    fn creepage(&mut self) -> Triple {
        let size = 0.05 * 400f64.powf(self.next());
        loop {
            let v: Triple = std::array::from_fn(|_| 2.0 * self.next() - 1.0);
            let length = coordinates::size(v);
            if length > 0.1 && length < 1.0 {
                return v.map(|v| v * size / length);
            }
        }
    }
}

/// Random cases: all of them in release builds, fewer where they take long.
fn cases(all: usize) -> usize {
    if cfg!(debug_assertions) { all / 4 } else { all }
}

fn off(a: Triple, b: Triple) -> (f64, f64) {
    ((a[0] - b[0]).hypot(a[1] - b[1]), (a[2] - b[2]).abs())
}

#[test]
fn validate_against_the_exact_theory_at_random() {
    let mut random = Random(88_172_645_463_325_252);
    let (mut all, mut moments) = (Vec::new(), Vec::new());
    for _ in 0..cases(500) {
        let a_over_b = 0.1 * 100f64.powf(random.next());
        let v = random.creepage();
        let exact = Shape::new(a_over_b, 0.28, LAW.table.layout().cells).solver().force(v);
        let (force, moment) = off(exact, LAW.share(a_over_b, v));
        all.push(force);
        moments.push(moment);
    }
    all.sort_by(f64::total_cmp);
    moments.sort_by(f64::total_cmp);
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    println!("{:?}, {} bytes", LAW.table.layout(), EMBEDDED.len());
    let (most, last) = (all.len() * 95 / 100, all.len() - 1);
    println!("|dF| / mu N: mean {:.5}, 95 % below {:.5}, worst {:.5}", mean(&all), all[most], all[last]);
    println!("|dM| / (mu N c): mean {:.5}, 95 % below {:.5}, worst {:.5}", mean(&moments), moments[most], moments[last]);
    assert!(mean(&all) < 0.003 && all[last] < 0.03 && mean(&moments) < 0.002 && moments[last] < 0.03);
}

#[test]
fn regress_entries_are_what_the_generator_makes() {
    let layout = LAW.table.layout();
    let mut random = Random(1);
    let mut checked = 0;
    while checked < 25 {
        let shape = (random.next() * layout.shapes as f64) as usize;
        let u = layout.place((random.next() * layout.points() as f64) as usize);
        if coordinates::size(u) > 0.95 {
            continue;
        }
        let a_over_b = layout.ratio(shape).clamp(RATIOS.0, RATIOS.1);
        let exact = Shape::new(a_over_b, layout.nu, layout.cells).solver().force(coordinates::unbounded(u));
        let found = LAW.table.force(a_over_b, u);
        let (force, moment) = off(exact, found);
        assert!(force < 3e-4 && moment < 3e-4, "a/b {a_over_b} u {u:?}: {exact:?} {found:?}");
        checked += 1;
    }
}

#[test]
fn validate_slopes_at_zero_are_kalkers() {
    for (a_over_b, nu) in [(0.1, 0.28), (0.3, 0.28), (1.0, 0.28), (3.0, 0.28), (10.0, 0.28), (1.0, 0.0), (1.0, 0.3), (1.0, 0.5)] {
        let (law, patch) = (law(nu), Patch { a: 5e-3 * f64::sqrt(a_over_b), b: 5e-3 / f64::sqrt(a_over_b) });
        let linear = super::super::kalker::LinearTheory::new(Material { youngs_modulus: 2.1e11, poisson_ratio: nu });
        let small = [(1e-9, 0.0, 0.0), (0.0, 1e-9, 0.0), (0.0, 0.0, 1e-7)];
        let off = small.map(|(longitudinal, lateral, spin)| {
            let creepage = Creepage { longitudinal, lateral, spin };
            let force = law.force(&RollingContact { patch, normal_force: 1e5, friction: 0.3, creepage, speed: 1.0 });
            let kalker = linear.force(patch, creepage);
            let percent = |a: f64, b: f64| if b == 0.0 { 0.0 } else { 100.0 * (a / b - 1.0) };
            [
                percent(force.longitudinal, kalker.longitudinal),
                percent(force.lateral, kalker.lateral),
                percent(force.spin_moment, kalker.spin_moment),
            ]
        });
        let [c11, c22, c23, c32, c33] = [off[0][0], off[1][1], off[2][1], off[1][2], off[2][2]];
        println!("nu {nu} a/b {a_over_b}: % off Kalker's c11 {c11:.2} c22 {c22:.2} c23 {c23:.2} c32 {c32:.2} c33 {c33:.2}");
        assert!(c11.abs() < 2.0 && c22.abs() < 2.0 && c23.abs() < 2.0);
        // Equal at the tabulated a/b; between them each has its own spline.
        assert!((c32 - c23).abs() < 1.0 || nu != 0.28);
        assert!(c33.abs() < if a_over_b > 5.0 { 6.0 } else { 2.0 } || nu != 0.28);
    }
}

#[test]
fn equiv_other_poisson_ratios_are_scaled() {
    let cells = LAW.table.layout().cells;
    for (nu, mean, most) in [(0.0, 0.04, 0.15), (0.25, 0.006, 0.03), (0.3, 0.005, 0.03), (0.5, 0.04, 0.15)] {
        let (mut random, mut sum, mut worst, cases) = (Random(7), 0.0, 0f64, cases(60));
        for _ in 0..cases {
            let a_over_b = 0.1 * 100f64.powf(random.next());
            let v = random.creepage();
            let exact = Shape::new(a_over_b, nu, cells).solver().force(v);
            let (force, _) = off(exact, LAW.share(a_over_b, v));
            sum += force / cases as f64;
            worst = worst.max(force);
        }
        println!("nu {nu}: |dF| / mu N mean {sum:.4}, worst {worst:.4}");
        assert!(sum < mean && worst < most, "{nu} {sum} {worst}");
    }
}

#[test]
fn prop_first_derivatives_are_continuous() {
    // Across the borders of lattice cells, of a/b intervals and of the bend.
    let step = 1e-4;
    let slope = |v: Triple, d: Triple, side: f64| -> Triple {
        let at = |t: f64| LAW.share(2.0, std::array::from_fn(|k| v[k] + side * t * step * d[k]));
        let (near, far) = (at(0.0), at(1.0));
        std::array::from_fn(|k| side * (far[k] - near[k]) / step)
    };
    let n = LAW.table.layout().steps as f64;
    for i in 1..LAW.table.layout().steps {
        for (axis, others) in [(0, [0.3, 0.2]), (1, [-0.1, 0.4]), (2, [0.2, -0.5])] {
            let mut u = [others[0], others[1], others[0]];
            u[axis] = i as f64 / n;
            if coordinates::size(u) > 0.9 {
                continue;
            }
            let v = coordinates::unbounded(u);
            for d in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                let (left, right) = (slope(v, d, -1.0), slope(v, d, 1.0));
                for k in 0..3 {
                    assert!((left[k] - right[k]).abs() < 0.02, "{u:?} {d:?} {left:?} {right:?}");
                }
            }
        }
    }
}

#[test]
fn hard_foreign_and_damaged_files_are_refused() {
    assert_eq!(Table::read(b"PK").unwrap_err(), TableError::Foreign);
    let mut bytes = EMBEDDED.to_vec();
    bytes[8] += 1;
    assert!(matches!(Table::read(&bytes).unwrap_err(), TableError::Version(_)));
    let mut bytes = EMBEDDED.to_vec();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    assert_eq!(Table::read(&bytes).unwrap_err(), TableError::Damaged);
    assert_eq!(Table::read(&EMBEDDED[..1000]).unwrap_err(), TableError::Damaged);
    assert!(EMBEDDED.len() < 2_000_000);
}

proptest! {
    #[test]
    fn prop_bounded_finite_and_mirror_symmetric(
        ratio in -4.0..4.0f64, size in -4.0..6.0f64, x in -1.0..1.0f64, y in -1.0..1.0f64, spin in -1.0..1.0f64, mu in 0.0..0.8f64
    ) {
        let (r, s) = (ratio.exp(), 1e-3 * 10f64.powf(size));
        let patch = Patch { a: 5e-3 * r.sqrt(), b: 5e-3 / r.sqrt() };
        let at = |x: f64, y: f64, spin: f64| {
            let creepage = Creepage { longitudinal: x * s, lateral: y * s, spin: 200.0 * spin * s };
            LAW.force(&RollingContact { patch, normal_force: 8e4, friction: mu, creepage, speed: 20.0 })
        };
        let f = at(x, y, spin);
        prop_assert!(f.longitudinal.hypot(f.lateral) <= mu * 8e4 * (1.0 + 1e-12) && f.spin_moment.is_finite());
        let g = at(-x, y, spin);
        prop_assert!(g.longitudinal == -f.longitudinal && g.lateral == f.lateral && g.spin_moment == f.spin_moment);
        let h = at(x, -y, -spin);
        prop_assert!(h.longitudinal == f.longitudinal && h.lateral == -f.lateral && h.spin_moment == -f.spin_moment);
    }
}
