use super::*;
use nalgebra::{DMatrix, DVector, Matrix6};

/// Reproducible numbers in (-1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn index(&mut self, below: usize) -> usize {
        (((self.next() + 1.0) / 2.0 * below as f64) as usize).min(below - 1)
    }

    fn coefficients(&mut self) -> Coefficients {
        Coefficients::from_fn(|_, _| self.next())
    }

    /// A well-conditioned symmetric positive definite matrix.
    fn mobility(&mut self) -> Mobility {
        let root = Matrix6::from_fn(|_, _| self.next());
        root * root.transpose() + Matrix6::identity() * 0.5
    }
}

fn filled(bodies: usize, rows: &[RowBodies], limit: usize, random: &mut Random) -> Kkt {
    let mut kkt = Kkt::with_dense_limit(bodies, rows, limit);
    for body in 0..bodies {
        kkt.set_mobility(body, &random.mobility());
    }
    for row in 0..rows.len() {
        kkt.set_row(row, &random.coefficients(), &random.coefficients());
    }
    kkt
}

/// Accelerations and multipliers from the full matrix `[M J^T; J 0]`, with inactive rows replaced by `lambda = 0`.
fn full_solution(kkt: &Kkt, free: &[f64], gamma: &[f64]) -> DVector<f64> {
    let (n, m) = (SIX * kkt.bodies(), kkt.rows());
    let mut matrix = DMatrix::zeros(n + m, n + m);
    let mut right = DVector::zeros(n + m);
    for body in 0..kkt.bodies() {
        let mass = kkt.mobility(body).try_inverse().unwrap();
        matrix.view_mut((SIX * body, SIX * body), (SIX, SIX)).copy_from(&mass);
        let force = mass * Coefficients::from_column_slice(block(free, body));
        right.rows_mut(SIX * body, SIX).copy_from(&force);
    }
    for row in 0..m {
        if !kkt.is_active(row) {
            matrix[(n + row, n + row)] = 1.0;
            continue;
        }
        let (bodies, first, second) = kkt.row(row);
        let parts = [Some((bodies.first, first)), bodies.second.map(|body| (body, second))];
        for (body, coefficients) in parts.into_iter().flatten() {
            for (i, c) in coefficients.iter().enumerate() {
                matrix[(n + row, SIX * body + i)] += c;
                matrix[(SIX * body + i, n + row)] += c;
            }
        }
        right[n + row] = gamma[row];
    }
    matrix.lu().solve(&right).unwrap()
}

#[test]
fn equiv_solution_is_that_of_the_full_matrix() {
    let mut random = Random(7);
    let mut worst: f64 = 0.0;
    for case in 0..40 {
        let bodies = 2 + random.index(9);
        let count = 1 + random.index(3 * bodies);
        let rows: Vec<RowBodies> = (0..count)
            .map(|_| {
                let first = random.index(bodies);
                let second = (first + 1 + random.index(bodies - 1)) % bodies;
                RowBodies { first, second: (random.next() > -0.3).then_some(second) }
            })
            .collect();
        let limit = if case % 2 == 0 { 0 } else { usize::MAX };
        let mut kkt = filled(bodies, &rows, limit, &mut random);
        let inactive = random.index(count);
        kkt.set_active(inactive, case % 3 == 0);
        let free: Vec<f64> = (0..SIX * bodies).map(|_| random.next()).collect();
        let gamma: Vec<f64> = (0..count).map(|_| random.next()).collect();
        let (mut accelerations, mut multipliers) = (vec![f64::NAN; SIX * bodies], vec![f64::NAN; count]);
        if kkt.factorise().is_err() {
            // More random rows on a body than it has coordinates.
            continue;
        }
        kkt.solve(&free, &gamma, &mut accelerations, &mut multipliers);
        let full = full_solution(&kkt, &free, &gamma);
        let scale = full.amax().max(1.0);
        for (own, full) in accelerations.iter().chain(&multipliers).zip(full.iter()) {
            worst = worst.max((own - full).abs() / scale);
        }
        assert!(kkt.is_active(inactive) || multipliers[inactive] == 0.0);

        // The correction satisfies J change = -residual.
        let mut change = vec![f64::NAN; SIX * bodies];
        kkt.correction(&gamma, &mut change);
        for row in (0..count).filter(|row| kkt.is_active(*row)) {
            worst = worst.max((kkt.row_times(row, &change) + gamma[row]).abs() / scale);
        }
        // -J^T lambda is the force that the accelerations need on top of the free ones.
        for body in 0..bodies {
            let mass = kkt.mobility(body).try_inverse().unwrap();
            let difference =
                Coefficients::from_column_slice(block(&accelerations, body)) - Coefficients::from_column_slice(block(&free, body));
            for (i, force) in (mass * difference).iter().enumerate() {
                worst = worst.max((kkt.constraint_force(body, i, &multipliers) - force).abs() / scale);
            }
        }
    }
    println!("largest relative difference from the full matrix: {worst:.1e}");
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn equiv_dense_and_sparse_storage_agree() {
    let mut random = Random(3);
    let rows: Vec<RowBodies> = (0..30).map(|i| RowBodies { first: i / 5, second: (i > 4).then_some((i / 5 + 7) % 8) }).collect();
    let dense = filled(8, &rows, usize::MAX, &mut random);
    let mut sparse = Kkt::with_dense_limit(8, &rows, 0);
    for body in 0..8 {
        sparse.set_mobility(body, dense.mobility(body));
    }
    for row in 0..rows.len() {
        sparse.set_row(row, dense.row(row).1, dense.row(row).2);
    }
    assert!(matches!(dense.storage, Storage::Dense(_)) && matches!(sparse.storage, Storage::Sparse(_)));
    assert!(matches!(Kkt::new(8, &rows).storage, Storage::Sparse(_)) && matches!(Kkt::new(8, &rows[..24]).storage, Storage::Dense(_)));
    let free: Vec<f64> = (0..48).map(|_| random.next()).collect();
    let gamma: Vec<f64> = (0..30).map(|_| random.next()).collect();
    // A clone has its own numbers.
    let results = [dense, sparse.clone(), sparse].map(|mut kkt| {
        let (mut a, mut l) = (vec![0.0; 48], vec![0.0; 30]);
        kkt.factorise().unwrap();
        kkt.solve(&free, &gamma, &mut a, &mut l);
        DVector::from_vec(a)
    });
    assert!((&results[0] - &results[1]).amax() < 1e-9 * results[0].amax());
    assert_eq!(results[1], results[2]);
}

#[test]
fn hard_dependent_rows_are_named() {
    for limit in [0, usize::MAX] {
        let mut random = Random(11);
        let rows = [RowBodies { first: 0, second: Some(1) }; 4];
        let mut kkt = filled(2, &rows, limit, &mut random);
        let (first, second) = (*kkt.row(0).1 * 3e4 + *kkt.row(1).1, *kkt.row(0).2 * 3e4 + *kkt.row(1).2);
        kkt.set_row(3, &first, &second);
        let found = kkt.factorise().unwrap_err().row;
        assert!([0, 1, 3].contains(&found), "{found}");
        kkt.set_active(found, false);
        kkt.factorise().unwrap();
        // A row on an imposed coordinate only.
        kkt.set_active(found, true);
        kkt.set_row(3, &Coefficients::x(), &Coefficients::zeros());
        let mut mobility = *kkt.mobility(0);
        mobility.row_mut(0).fill(0.0);
        mobility.column_mut(0).fill(0.0);
        kkt.set_mobility(0, &mobility);
        assert_eq!(kkt.factorise(), Err(SingularConstraints { row: 3 }));
    }
}

/// A chain: body k hangs on body k - 1 by five rows.
fn chain(bodies: usize) -> Vec<RowBodies> {
    let body = |k: usize| RowBodies { first: k, second: k.checked_sub(1) };
    (0..bodies).flat_map(|k| [body(k); 5]).collect()
}

#[test]
fn equiv_islands_are_those_of_one_matrix() {
    // Two mechanisms of 15 rows each, on bodies of even and of odd number, and a row on a body of its own, in turn.
    let mut rows: Vec<RowBodies> =
        (0..30).map(|i| RowBodies { first: i % 2 + 2 * (i / 10), second: Some(i % 2 + 2 * (i / 10) + 2) }).collect();
    rows.insert(7, RowBodies { first: 9, second: None });
    let mut random = Random(6);
    let islands = filled(10, &rows, DENSE_ROWS, &mut random);
    assert!(matches!(islands.storage, Storage::Dense(_)));
    assert_eq!(islands.stored().0, 2 * 15 * 16 / 2 + 1);
    let mut whole = Kkt::with_dense_limit(10, &rows, 0);
    for body in 0..10 {
        whole.set_mobility(body, islands.mobility(body));
    }
    for row in 0..rows.len() {
        whole.set_row(row, islands.row(row).1, islands.row(row).2);
    }
    assert!(matches!(whole.storage, Storage::Sparse(_)));
    let free: Vec<f64> = (0..60).map(|_| random.next()).collect();
    let gamma: Vec<f64> = (0..31).map(|_| random.next()).collect();
    let [one, other] = [islands, whole].map(|mut kkt| {
        let (mut a, mut l) = (vec![0.0; 60], vec![0.0; 31]);
        kkt.set_active(3, false);
        kkt.factorise().unwrap();
        kkt.solve(&free, &gamma, &mut a, &mut l);
        a.extend(l);
        (a, kkt)
    });
    let worst = one.0.iter().zip(&other.0).map(|(a, b)| (a - b).abs() / (1.0 + b.abs())).fold(0.0, f64::max);
    assert!(worst < 1e-11, "{worst:e}");
    // A row that repeats an earlier one of its island is named by its own number.
    let mut kkt = one.1;
    let (first, second) = (*kkt.row(13).1, *kkt.row(13).2);
    assert_eq!(kkt.row(13).0, kkt.row(15).0);
    kkt.set_row(15, &first, &second);
    assert_eq!(kkt.factorise(), Err(SingularConstraints { row: 15 }));
}

#[test]
fn prop_cost_of_a_chain_grows_with_its_length() {
    let mut random = Random(5);
    let mut per_body = Vec::new();
    for bodies in [10, 100, 1000] {
        let mut kkt = filled(bodies, &chain(bodies), DENSE_ROWS, &mut random);
        kkt.factorise().unwrap();
        let (matrix, factor) = kkt.stored();
        println!("{bodies} bodies: S {matrix}, L {factor} numbers");
        per_body.push(factor as f64 / bodies as f64);
    }
    // Blocks of 5 x 5 on and beside the diagonal: at most 15 + 25 numbers per body without any fill.
    assert!(per_body.iter().all(|count| *count < 1.3 * 40.0), "{per_body:?}");
}

#[test]
fn prop_two_rows_on_a_body_are_quick() {
    let mut random = Random(5);
    let rows = [RowBodies { first: 0, second: None }; 2];
    let mut kkt = filled(1, &rows, DENSE_ROWS, &mut random);
    kkt.factorise().unwrap();
    // Three numbers of S from three products, nothing else.
    assert_eq!((kkt.stored(), kkt.pattern.pairs.len()), ((3, 3), 3));
}
