use super::*;
use crate::math::rotation::AxleFrame;
use crate::mbs::body::Body;
use crate::mbs::inertia::Inertia;
use nalgebra::DMatrix;

fn bodies() -> [Body; 2] {
    let body = |name: &str, inertia| Body { name: name.into(), mass: 2.0, inertia };
    [
        body("brick", Inertia::General { principal: Vector3::new(3.0, 1.2, 2.1) }),
        body("gyroscope", Inertia::Revolution { transverse: 3.0, axial: 1.2 }),
    ]
}

const LAW: fn(f64) -> [f64; 3] = |t| [(3.0 * t).sin(), 3.0 * (3.0 * t).cos(), -9.0 * (3.0 * t).sin()];

/// Every kind of joint between the two bodies in both orders and to the ground, with the free motions it leaves.
fn joints() -> Vec<(Joint, usize)> {
    let a = Place::along(Vector3::new(0.3, -0.2, 0.5), &Vector3::new(0.2, 1.0, -0.4));
    let b = Place::along(Vector3::new(-0.1, 0.4, 0.2), &Vector3::new(-0.7, 0.3, 0.6)).turned(0.3);
    let free = [("revolute", 1), ("spherical", 3), ("universal", 2), ("cylindrical", 2), ("prismatic", 1), ("rigid", 0)];
    assert_eq!(free.map(|kind| kind.0)[..], REGISTRY.iter().map(|entry| entry.name).collect::<Vec<_>>());
    let pairs = [RowBodies { first: 0, second: Some(1) }, RowBodies { first: 1, second: Some(0) }, RowBodies { first: 0, second: None }];
    let mut joints = Vec::new();
    for bodies in pairs {
        joints.extend(REGISTRY.iter().zip(free).map(|(entry, (name, free))| (entry.parse.1(name, bodies, &a, &b), free)));
        for coordinate in 0..6 {
            joints.push((driven("drive", bodies, coordinate, Level::Position, Prescribed::new(LAW)), 5));
            joints.push((driven("drive", bodies, coordinate, Level::Speed, Prescribed::new(LAW)), 5));
        }
    }
    joints
}

const Q: [[f64; 6]; 2] = [[0.1, 0.2, -0.3, 0.4, -0.3, 1.0], [-0.2, 0.5, 0.1, -0.6, 0.2, 2.0]];
const V: [[f64; 6]; 2] = [[1.0, 0.3, 2.0, 0.7, 0.5, 1.5], [-0.4, 0.9, 0.2, 0.8, -1.1, 0.6]];
const A: [[f64; 6]; 2] = [[0.5, -0.3, 1.0, 0.2, 2.5, 0.5], [1.4, 0.1, 0.7, -0.8, 0.1, 3.6]];

/// Motions on the path `q + v t + a t^2 / 2`.
fn motions(t: f64) -> [BodyMotion; 2] {
    let bodies = bodies();
    [0, 1].map(|b| {
        let q: Vec<f64> = (0..6).map(|i| Q[b][i] + t * V[b][i] + 0.5 * t * t * A[b][i]).collect();
        let v: Vec<f64> = (0..6).map(|i| V[b][i] + t * A[b][i]).collect();
        bodies[b].motion(&q, &v)
    })
}

fn row_times(joint: &Joint, row: &RowValues, motion: &[[f64; 6]; 2]) -> f64 {
    let first = row.first.dot(&Coefficients::from(motion[joint.bodies.first]));
    first + joint.bodies.second.map_or(0.0, |second| row.second.dot(&Coefficients::from(motion[second])))
}

#[test]
fn analytic_rows_and_gamma_are_derivatives_of_the_residual() {
    let (t, h) = (0.0, 1e-6);
    let mut worst: f64 = 0.0;
    for (joint, _) in joints() {
        let at = |t: f64| joint.evaluate(t, &motions(t)).collect::<Vec<_>>();
        let (behind, now, ahead) = (at(t - h), at(t), at(t + h));
        assert_eq!(now.len(), joint.rows());
        for row in 0..joint.rows() {
            let driven = matches!(joint.rows[row].1, Primitive::Coordinate { .. });
            let speed_only = matches!(joint.rows[row].1, Primitive::Coordinate { level: Level::Speed, .. });
            let residual_rate = (ahead[row].residual - behind[row].residual) / (2.0 * h);
            let second = (ahead[row].rate - behind[row].rate) / (2.0 * h);
            let prescribed = if driven { LAW(t)[1] } else { 0.0 };
            let errors = [
                if speed_only { 0.0 } else { residual_rate - now[row].rate },
                row_times(&joint, &now[row], &V) - prescribed - now[row].rate,
                row_times(&joint, &now[row], &A) - now[row].gamma - second,
            ];
            for error in errors {
                assert!(error.abs() < 1e-8, "{} {:?}: {errors:?}", joint.row_name(row), joint.bodies);
                worst = worst.max(error.abs());
            }
        }
    }
    println!("largest difference from central differences: {worst:.1e}");
}

/// Rank of a joint's rows on its first body.
fn relative_rank(joint: &Joint) -> usize {
    let rows: Vec<RowValues> = joint.evaluate(0.0, &motions(0.0)).collect();
    DMatrix::from_fn(rows.len(), 6, |r, c| rows[r].first[c]).rank(1e-9)
}

#[test]
fn analytic_free_motions_are_six_less_the_rank() {
    // The first body alone moves; a gyroscope's spin moves no attachment, so only the brick comes first.
    for (joint, free) in joints() {
        if joint.bodies.first == 0 {
            assert_eq!(6 - relative_rank(&joint), free, "{}", joint.name);
            assert_eq!(6 - joint.rows(), free, "{}", joint.name);
        }
    }
}

#[test]
fn analytic_free_motion_is_the_one_of_the_name() {
    // One general body against the ground, places that coincide.
    let [brick, _] = bodies();
    let motion = brick.motion(&Q[0], &[0.0; 6]);
    let ground = Place::along(Vector3::new(0.5, 0.1, 0.7), &Vector3::new(0.3, -0.5, 0.8));
    let place = ground.seen_from(Some(&motion));
    let z = ground.axes.column(2).into_owned();
    let across = ground.axes.column(0).into_owned();
    let bodies = RowBodies { first: 0, second: None };
    // The universal joint's pin on the ground lies across the one on the body.
    let crossed = Place { axes: Matrix3::from_columns(&[ground.axes.column(1), ground.axes.column(2), ground.axes.column(0)]), ..ground };
    let cases: [(Joint, [bool; 4]); 6] = [
        // Rotation about Z, about X; displacement along Z, along X: free?
        (revolute("j", bodies, &place, &ground), [true, false, false, false]),
        (spherical("j", bodies, &place, &ground), [true, true, false, false]),
        (universal("j", bodies, &place, &crossed), [true, true, false, false]),
        (cylindrical("j", bodies, &place, &ground), [true, false, true, false]),
        (prismatic("j", bodies, &place, &ground), [false, false, true, false]),
        (rigid("j", bodies, &place, &ground), [false, false, false, false]),
    ];
    for (joint, free) in cases {
        let rows: Vec<RowValues> = joint.evaluate(0.0, &[motion]).collect();
        assert!(rows.iter().all(|row| row.residual.abs() < 1e-15 && row.rate == 0.0), "{rows:?}");
        let rotation = |axis: &Vector3<f64>| (axis.cross(&(motion.position - ground.point)), *axis);
        let twists = [rotation(&z), rotation(&across), (z, Vector3::zeros()), (across, Vector3::zeros())];
        for ((velocity, omega), free) in twists.into_iter().zip(free) {
            // Coordinate rates of the twist: yaw', roll', pitch' from the angular velocity in the axle frame.
            let local = AxleFrame::new(motion.yaw, motion.roll).axes.tr_mul(&omega);
            let yaw = local.z / motion.frame.cos_roll;
            let rates = Coefficients::new(velocity.x, velocity.y, velocity.z, yaw, local.x, local.y - yaw * motion.frame.sin_roll);
            let largest = rows.iter().map(|row| row.first.dot(&rates).abs()).fold(0.0, f64::max);
            assert_eq!(largest < 1e-14, free, "{joint:?}: {largest}");
            assert!(free || largest > 0.1);
        }
    }
}
