use super::super::tests::published;
use super::*;
use crate::contact::creep::kalker::{Coefficients, KalkerTable};
use crate::contact::creepage::Creepage;

const PATCH: Patch = Patch { a: 6e-3, b: 4e-3 };

fn material(shear_modulus: f64, nu: f64) -> Material {
    Material { youngs_modulus: 2.0 * (1.0 + nu) * shear_modulus, poisson_ratio: nu }
}

fn law(grid: usize) -> Exact {
    Exact::new(material(8.2e10, 0.28), Settings { grid, ..Settings::default() })
}

/// Mu N = 20 kN; creepages in units of mu p0 / G.
fn contact(patch: Patch, [xi, eta, phi]: [f64; 3]) -> RollingContact {
    let unit = 1.5 * 2e4 / (PI * patch.a * patch.b) / 8.2e10;
    let creepage = Creepage { longitudinal: xi * unit, lateral: eta * unit, spin: phi * unit / (patch.a * patch.b).sqrt() };
    RollingContact { patch, normal_force: 8e4, friction: 0.25, creepage, speed: 20.0 }
}

/// Force in mu N.
fn share(force: CreepForce) -> [f64; 2] {
    [force.longitudinal / 2e4, force.lateral / 2e4]
}

/// c11, c22, c23, c33 and c32 on one grid, from the slopes at zero creepage.
fn slopes(a_over_b: f64, nu: f64, n: usize) -> [f64; 5] {
    let patch = SteadyPatch::new(a_over_b, nu, &Convolver::new(n));
    let (small, limits) = (1e-6, Limits { tolerance: 1e-8, most_steps: MOST_STEPS });
    let mut workspace = Workspace::new(&patch.convolver);
    let [x, y, spin] = [[small, 0.0, 0.0], [0.0, small, 0.0], [0.0, 0.0, small]].map(|creepage| {
        let (force, outcome) = patch.solve(creepage, &mut Vec::new(), limits, &mut workspace);
        assert!(outcome.residual < 1e-8, "{creepage:?} {outcome:?}");
        force
    });
    [x[0], y[1], spin[1], spin[2], y[2]].map(|slope| -slope / small * normal::LOAD)
}

/// From two grids, for an error proportional to the cell size.
fn extrapolated(a_over_b: f64, nu: f64) -> [f64; 5] {
    let (coarse, fine) = (slopes(a_over_b, nu, 24), slopes(a_over_b, nu, 48));
    std::array::from_fn(|k| 2.0 * fine[k] - coarse[k])
}

#[test]
fn validate_creep_coefficients() {
    // nu, a/b, then c11, c22, c23, c33 by CONTACT (commit d431cdbd), 66 x 66 and 33 x 33 cells, extrapolated likewise.
    const PROGRAM: [(f64, f64, [f64; 4]); 6] = [
        (0.28, 0.1, [3.4285, 2.5140, 0.4871, 8.6089]),
        (0.28, 0.5, [3.7158, 3.0042, 0.9286, 1.9615]),
        (0.28, 1.0, [4.1624, 3.6493, 1.4484, 1.1564]),
        (0.28, 2.0, [5.1833, 4.9571, 2.6410, 0.7918]),
        (0.28, 5.0, [7.8770, 8.2804, 6.6586, 0.5677]),
        (0.28, 10.0, [11.7962, 13.0600, 14.5242, 0.4695]),
    ];
    for (nu, a_over_b, program) in PROGRAM {
        let found = extrapolated(a_over_b, nu);
        let Coefficients { c11, c22, c23, c33 } = KalkerTable::new(nu).at(a_over_b);
        let published = [c11, c22, c23, c33];
        let to = |other: [f64; 4]| -> [f64; 4] { std::array::from_fn(|k| 100.0 * (found[k] / other[k] - 1.0)) };
        let (to_program, to_table) = (to(program), to(published));
        println!("a/b {a_over_b}: {found:.4?}, % off program {to_program:.2?}, % off table {to_table:.2?}");
        // The program's grid has stairs of its own at the edge: it is 1.5 % (c11), 2.7 % (c23) off the published table.
        assert!(to_program[..2].iter().all(|d| d.abs() < 1.8) && to_program[2].abs() < 3.2, "{to_program:?}");
        assert!(to_table[0].abs() < 1.0 && to_table[1].abs() < 1.5 && to_table[2].abs() < 1.0, "{to_table:?}");
        assert!(to_table[3].abs() < if a_over_b > 5.0 { 5.0 } else { 2.0 }, "{to_table:?}");
        assert!((found[4] / found[2] + 1.0).abs() < 0.005, "c32 = -c23: {found:?}");
    }
}

#[test]
fn validate_forces_of_the_exact_program() {
    let mut worst = [0f64; 3];
    let mut cases = 0;
    for (contact, row) in published() {
        let (patch, creepage) = (contact.patch, contact.creepage);
        // Pure spin close to its largest force is the hard case: 0.905 has 64 and 32 cells, 0.929 has 32 and 16.
        let pure_spin = creepage.longitudinal == 0.0 && creepage.lateral == 0.0;
        let grid = if pure_spin && patch.a > patch.b { 64 } else { 32 };
        let law = Exact::new(material(row["G"] * 1e6, row["nu"]), Settings { grid, ..Settings::default() });
        let solution = law.solve(&contact);
        assert!(solution.residual < 1e-6, "{contact:?}");
        let found = [solution.force.longitudinal, solution.force.lateral, solution.force.spin_moment / (patch.a * patch.b).sqrt()]
            .map(|force| force / contact.bound());
        let off: [f64; 3] = std::array::from_fn(|k| (found[k] - row[["fx_contact", "fy_contact", "mz_contact"][k]]).abs());
        let (err_x, err_y) = (row["err_fx"], row["err_fy"]);
        assert!(off[0] < err_x + 0.005 && off[1] < err_y + 0.005 && off[2] < 0.01, "{contact:?}: {found:?}");
        worst = std::array::from_fn(|k| worst[k].max(off[k]));
        cases += 1;
    }
    println!("{cases} cases, extrapolated against 60 cells: largest difference in Fx, Fy, Mz {worst:.4?}");
    assert_eq!(cases, 45);
}

#[test]
fn analytic_carter_in_each_strip_of_a_short_patch() {
    // Plane theory: with k = xi G / (2 (1 - nu) mu p0), a strip of half width a s, s = sqrt(1 - t^2), pressed by p0 s,
    // carries (1 - (1 - k/s)^2) of its bound; the bounds weigh 3/4 (1 - t^2) dt. a/b = 0.05 leaves 1 % to the ends.
    let (law, patch) = (law(32), Patch { a: 1e-3, b: 2e-2 });
    for xi in [0.05, 0.2, 0.5, 0.9, 1.3] {
        let n = 2000;
        let carter: f64 = (0..n)
            .map(|i| {
                let t = (2 * i + 1) as f64 / n as f64 - 1.0;
                let k = f64::min(1.0, xi / (2.0 * (1.0 - 0.28)) / (1.0 - t * t).sqrt());
                0.75 * (1.0 - t * t) * (1.0 - (1.0 - k) * (1.0 - k)) * 2.0 / n as f64
            })
            .sum();
        let [found, lateral] = share(law.force(&contact(patch, [xi, 0.0, 0.0])));
        println!("xi {xi}: Carter {carter:.4}, found {:.4}", -found);
        assert!((found + carter).abs() < 0.01 && lateral.abs() < 1e-6, "{found} {carter}");
    }
}

#[test]
fn analytic_cattaneo_shift() {
    // Circle of radius a, same material: shift = 3 mu N (2 - nu) / (8 a G) [1 - (1 - q)^(2/3)], stick radius
    // a (1 - q)^(1/3), q = Q / (mu N). It leaves out slip across the force (a few thousandths).
    let (law, radius) = (law(48), 5e-3);
    let contact = contact(Patch { a: radius, b: radius }, [0.0; 3]);
    for q in [0.1, 0.5, 0.9] {
        let shift = 3.0 * 2e4 * (2.0 - 0.28) / (8.0 * radius * 8.2e10) * (1.0 - (1.0f64 - q).powf(2.0 / 3.0));
        let solution = law.advance(&contact, None, Increment { rolled: 0.0, shift: [shift, 0.0], turn: 0.0 });
        let [found, _] = share(solution.force);
        let (stick, stick_found) = ((1.0 - q).cbrt(), solution.sticking_share().sqrt());
        println!("q {q}: found {:.4}; stick radius {stick:.3}, found {stick_found:.3}", -found);
        assert!(solution.residual < 1e-6 && (found + q).abs() < 0.01 * q, "{found}");
        assert!((stick_found - stick).abs() < 0.02, "{stick} {stick_found}");
    }
}

#[test]
fn equiv_rolling_from_rest_ends_in_the_steady_state() {
    let law = law(20);
    let contact = contact(PATCH, [0.5, -0.2, 0.6]);
    let steady = law.solve(&contact);
    let increment = Increment::rolling(&contact, law.cell_length(PATCH));
    let mut now = law.advance(&contact, None, increment);
    let size = |solution: &Solution| share(solution.force_on_grid)[0].hypot(share(solution.force_on_grid)[1]);
    assert!(size(&now) < 0.2 * size(&steady), "the first step only begins to load");
    for _ in 0..120 {
        now = law.advance(&contact, Some(&now), increment);
        assert!(now.residual < 1e-6);
    }
    let ([x, y], [steady_x, steady_y]) = (share(now.force), share(steady.force_on_grid));
    let distance = 121.0 * increment.rolled / PATCH.a;
    println!("after {distance:.1} a: Fx, Fy {x:.5} {y:.5}, steady {steady_x:.5} {steady_y:.5}");
    assert!((x - steady_x).abs() < 1e-4 && (y - steady_y).abs() < 1e-4);
}

#[test]
fn analytic_full_slip_points_against_the_slip() {
    let law = law(24);
    let [x, y] = share(law.force(&contact(PATCH, [60.0, -80.0, 0.0])));
    assert!((x + 0.6).abs() < 5e-3 && (y - 0.8).abs() < 5e-3 && (x.hypot(y) - 1.0).abs() < 1e-4, "{x} {y}");
    assert_eq!(law.force(&RollingContact { friction: 0.0, ..contact(PATCH, [1.0, 0.0, 0.0]) }), CreepForce::default());
}

#[test]
fn hard_every_kind_of_creepage_on_every_shape_converges() {
    let law = law(16);
    let mut most = 0;
    for a_over_b in [0.05, 0.2, 1.0, 5.0, 20.0f64] {
        let patch = Patch { a: 5e-3 * a_over_b.sqrt(), b: 5e-3 / a_over_b.sqrt() };
        for size in [1e-3, 0.1, 0.6, 3.0, 100.0] {
            for direction in [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.5, -1.0, 2.0], [0.0, -1.0, 1.0], [1.0, 0.2, 0.1]] {
                let contact = contact(patch, direction.map(|d| d * size));
                let solution = law.solve(&contact);
                let (on_grid, best) = (share(solution.force_on_grid), share(solution.force));
                assert!(solution.residual < 1e-6, "a/b {a_over_b} {direction:?} {size}: {}", solution.residual);
                assert!(on_grid[0].hypot(on_grid[1]) <= 1.0 + 1e-12 && best[0].hypot(best[1]) <= 1.0 + 1e-12);
                for cell in &solution.cells {
                    let traction = cell.traction[0].hypot(cell.traction[1]);
                    assert!(traction <= cell.bound * (1.0 + 1e-9));
                    let power = cell.traction[0] * cell.slip[0] + cell.traction[1] * cell.slip[1];
                    assert!(power <= traction * 1e-7, "friction takes power: {cell:?}");
                }
                most = most.max(solution.iterations);
            }
        }
    }
    println!("most Newton steps {most}");
}

#[test]
fn hard_an_iteration_cut_short_still_gives_a_bounded_force() {
    let patch = SteadyPatch::new(0.2, 0.28, &Convolver::new(16));
    let limits = Limits { tolerance: 1e-6, most_steps: 1 };
    let ([x, y, spin], outcome) = patch.solve([0.5, -1.0, 2.0], &mut Vec::new(), limits, &mut Workspace::new(&patch.convolver));
    assert!(outcome.residual > 1e-6 && x.hypot(y) <= 1.0 && spin.is_finite(), "{x} {y} {spin} {outcome:?}");
}
