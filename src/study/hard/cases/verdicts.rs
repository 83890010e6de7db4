//! Verdicts on stability that a loose tolerance must not turn round.

use super::super::case::{AUDIT, Audited, CASE, Case, Method, Must, RIGID};
use super::super::finding::{Finding, Unit};
use super::super::run::Ran;
use super::super::trace::Quantity;

const METHODS: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-4"),
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-8"),
];

pub(super) const CASES: &[Case] = &[
    Case {
        name: "decay_of_small_swings",
        hard: "a wheelset at 63 m/s, just below its critical speed: swings of 0.1 mm fade slowly",
        claim: "y to 2 um (2 % of the swing) at every 1 ms for 8 s, against dormand_prince 1e-9",
        scene: "suspended_wheelset",
        changes: &["track.deviation=[]", "vehicle.speed=63", "vehicle.initial.vy=0.003"],
        stop: 8.0,
        grid: 1e-3,
        formulations: RIGID,
        methods: METHODS,
        must: &[super::near(&[super::bound(Quantity::Y, 2e-6)])],
        ..CASE
    },
    Case {
        name: "growth_of_small_swings",
        hard: "a wheelset at 68 m/s, just above its critical speed: swings of 0.1 mm grow by 0.06 1/s; the tolerance is absolute, small swings get long steps",
        claim: "growth of y within 0.02 1/s of the eigenvalue's 0.061 1/s",
        scene: "suspended_wheelset",
        changes: &["track.deviation=[]", "vehicle.speed=68", "vehicle.initial.vy=0.003"],
        stop: 8.0,
        grid: 1e-3,
        formulations: RIGID,
        methods: METHODS,
        must: &[Must::Formula(grows)],
        ..CASE
    },
    Case {
        name: "limit_cycle_30_s",
        hard: "a wheelset far above its critical speed runs from flange to flange for 30 s, 450 times: places change thousands of times",
        claim: "amplitude of y 6.41 mm to 2 % and frequency 7.599 Hz (patches of strips), 7.642 Hz (ellipses of rigid contact) to 0.5 % (dormand_prince 1e-8), whatever the method and tolerance",
        scene: "wheelset_s1002",
        changes: &["track.deviation=[]", "vehicle.speed=60", "vehicle.initial.y=3 mm"],
        stop: 30.0,
        grid: 5e-4,
        formulations: &["ECF-A", "ECCF"],
        methods: &[
            Method::new("rosenbrock", "tolerance=1e-4"),
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("rosenbrock", "tolerance=1e-6"),
            Method::new("imex", "tolerance=1e-5"),
            Method::new("dormand_prince", "tolerance=1e-6"),
            Method::new("generalised_alpha", "step=0.5 ms"),
            Method::new("real_time", "step=0.5 ms"),
        ],
        must: &[Must::Formula(limit_cycle)],
        audit: Audited { energy: 0.05, ..AUDIT },
        quick: false,
        ..CASE
    },
    Case {
        name: "swing_without_friction",
        hard: "without friction and dampers a wheelset swings on its springs for ever: nothing takes or gives energy",
        claim: "amplitude of y after 10 s that at the start to 1 %",
        scene: "suspended_wheelset",
        changes: &[
            "track.deviation=[]",
            "contact.friction=0",
            "contact.damping=0",
            "vehicle.suspension.longitudinal_damping=0",
            "vehicle.initial.vy=0.03",
        ],
        stop: 10.0,
        grid: 1e-3,
        formulations: &["ECF-A", "ECCF"],
        methods: METHODS,
        must: &[Must::Formula(swings_on)],
        ..CASE
    },
];

/// Largest |y| of each half wave and when.
fn peaks(ran: &Ran) -> Vec<(f64, f64)> {
    let (time, y) = (&ran.trace.time, ran.trace.first(Quantity::Y));
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut sign = 0.0;
    for (time, y) in time.iter().zip(y) {
        if y.signum() != sign {
            sign = y.signum();
            found.push((*time, 0.0));
        }
        if let Some(last) = found.last_mut()
            && y.abs() > last.1
        {
            *last = (*time, y.abs());
        }
    }
    found
}

/// Slope of ln |y| over time through the peaks behind the first fifth, 1/s.
fn growth(ran: &Ran) -> f64 {
    let all = peaks(ran);
    let used = &all[all.len() / 5..all.len().saturating_sub(1).max(all.len() / 5)];
    let n = used.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| used.iter().map(f).sum::<f64>() / n;
    let (t, l) = (mean(|p| p.0), mean(|p| p.1.ln()));
    let over: f64 = used.iter().map(|p| (p.0 - t) * (p.1.ln() - l)).sum();
    over / used.iter().map(|p| (p.0 - t) * (p.0 - t)).sum::<f64>()
}

fn grows(ran: &Ran) -> Vec<Finding> {
    let found = growth(ran);
    vec![Finding::new(format!("growth {found:.3} 1/s, off by"), (found - 0.061).abs(), 0.02, Unit::One)]
}

fn swings_on(ran: &Ran) -> Vec<Finding> {
    let all = peaks(ran);
    let count = all.len();
    let size = |part: &[(f64, f64)]| part.iter().map(|p| p.1).fold(0.0, f64::max);
    let (begin, end) = (size(&all[..count / 5]), size(&all[count - count / 5..]));
    vec![Finding::relative("amplitude at the end against that at the start", end, begin, 0.01)]
}

/// Peak to peak half and frequency over the last half of the run.
fn limit_cycle(ran: &Ran) -> Vec<Finding> {
    let (time, y) = (&ran.trace.time, ran.trace.first(Quantity::Y));
    let begin = y.len() / 2;
    let late = &y[begin..];
    let amplitude = 0.5 * (late.iter().copied().fold(f64::MIN, f64::max) - late.iter().copied().fold(f64::MAX, f64::min));
    let upward: Vec<f64> = (begin + 1..y.len()).filter(|i| y[i - 1] < 0.0 && y[*i] >= 0.0).map(|i| time[i]).collect();
    let frequency = match upward.as_slice() {
        [first, .., last] => (upward.len() - 1) as f64 / (last - first),
        _ => f64::NAN,
    };
    // Ellipses at the deepest point turn at other places of the flange's throat than the patches that form.
    let wanted = if ran.rigid { 7.642 } else { 7.599 };
    vec![
        Finding::relative("amplitude of y against 6.41 mm", amplitude, 6.41e-3, 0.02),
        Finding::relative(format!("frequency against {wanted} Hz"), frequency, wanted, 0.005),
    ]
}
