//! Systems with a dense Jacobian, and what the tests of implicit methods measure on them.

use super::*;
use nalgebra::{DMatrix, DVector, Dyn, LU};

type Rate = fn(f64, &[f64], &mut [f64]);
type Jacobian = fn(f64, &[f64]) -> DMatrix<f64>;
type Motion = fn(f64, &[f64], f64) -> [Vec<f64>; 3];

/// A system that watches that a Jacobian is asked for directly after an evaluation at the same place.
#[derive(Clone)]
pub(super) struct Watched {
    pub rate: Rate,
    pub jacobian: Jacobian,
    pub coordinates: usize,
    /// What part of df/dy the system gives as its Jacobian.
    pub share: f64,
    pub last: (f64, Vec<f64>),
    pub matrix: DMatrix<f64>,
    pub factors: Option<LU<f64, Dyn, Dyn>>,
    /// Of an event function that never falls below zero.
    pub event_value: Option<f64>,
    /// Where f is not smooth.
    pub breaks: f64,
    /// c, c' and c'' of a moving frame at a time after its begin (t, y), which is noted below.
    pub motion: Option<Motion>,
    pub begin: (f64, Vec<f64>),
    /// Of the step that was accepted last.
    pub kept: (f64, Vec<f64>),
}

impl Watched {
    pub fn new(rate: Rate, jacobian: Jacobian, coordinates: usize) -> Self {
        let matrix = DMatrix::zeros(0, 0);
        let (breaks, nowhere) = (f64::INFINITY, (0.0, vec![]));
        let (last, begin, kept) = (nowhere.clone(), nowhere.clone(), nowhere);
        Watched {
            rate,
            jacobian,
            coordinates,
            share: 1.0,
            last,
            matrix,
            factors: None,
            event_value: None,
            breaks,
            motion: None,
            begin,
            kept,
        }
    }
}

impl Dynamics for Watched {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.last = (t, y.to_vec());
        (self.rate)(t, y, dy);
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, t: f64, _: &[f64]) -> f64 {
        if t < self.breaks { self.breaks } else { f64::INFINITY }
    }
    fn coordinates(&self) -> usize {
        self.coordinates
    }
    fn event_functions(&self) -> usize {
        usize::from(self.event_value.is_some())
    }
    fn event_values(&self, values: &mut [f64]) {
        self.event_value.iter().zip(values).for_each(|(own, value)| *value = *own);
    }
}

impl Implicit for Watched {
    /// Contact stands for the last equation alone.
    fn linearise(&mut self, t: f64, y: &[f64], part: StiffPart) -> Result<(), Undefined> {
        assert_eq!((t, y), (self.last.0, &self.last.1[..]), "an evaluation at the same place must come right before");
        self.matrix = self.share * (self.jacobian)(t, y);
        if part == StiffPart::Contact {
            let last = self.matrix.nrows() - 1;
            self.matrix.rows_mut(0, last).fill(0.0);
        }
        self.begin = self.last.clone();
        Ok(())
    }
    fn linearise_again(&mut self, t: f64, y: &[f64], part: StiffPart) -> Result<(), Undefined> {
        self.last = (t, y.to_vec());
        self.linearise(t, y, part)
    }
    fn note_frame(&mut self) -> bool {
        self.begin = self.last.clone();
        self.motion.is_some()
    }
    fn frame_at(&mut self, ahead: f64, shift: &mut [f64], rate: &mut [f64]) -> bool {
        let Some(motion) = self.motion else { return false };
        let [c, c1, _] = motion(self.begin.0, &self.begin.1, ahead);
        shift.copy_from_slice(&c);
        rate.copy_from_slice(&c1);
        true
    }
    fn keep_frame(&mut self) {
        self.kept.clone_from(&self.begin);
    }
    fn add_frame_motion(&self, ahead: f64, y: &mut [f64]) {
        let Some(motion) = self.motion else { return };
        let [c, ..] = motion(self.kept.0, &self.kept.1, ahead);
        y.iter_mut().zip(c).for_each(|(y, c)| *y += c);
    }
    fn frame_change(&mut self, change: &mut [f64]) {
        let Some(motion) = self.motion else { return };
        let [_, c1, c2] = motion(self.begin.0, &self.begin.1, 0.0);
        change.copy_from_slice((&self.matrix * DVector::from(c1) - DVector::from(c2)).as_slice());
    }
    fn factorise(&mut self, a: f64) -> Result<(), Undefined> {
        let n = self.matrix.nrows();
        self.factors = Some((DMatrix::identity(n, n) - a * &self.matrix).lu());
        Ok(())
    }
    fn solve_linear(&mut self, x: &mut [f64]) {
        let mut vector = DVector::from_column_slice(x);
        assert!(self.factors.as_ref().is_some_and(|factors| factors.solve_mut(&mut vector)));
        x.copy_from_slice(vector.as_slice());
    }
}

/// q'' = -q^3 - 0.3 q'^2 + .., z' = -z^2 e^t + .. with the solution q = sin t, z = e^-t: nonlinear, coupled, explicit in time; one
/// coordinate, its velocity and a first-order state.
pub(super) fn nonlinear(share: f64) -> Watched {
    let rate: Rate = |t, y, dy| {
        let (s, c) = t.sin_cos();
        dy[0] = y[1];
        dy[1] = -y[0].powi(3) + s.powi(3) - s - 0.3 * (y[1] * y[1] - c * c);
        dy[2] = -y[2] * y[2] * t.exp() + 0.5 * (y[0] - s) * y[2];
    };
    let jacobian: Jacobian = |t, y| {
        let decay = -2.0 * y[2] * t.exp() + 0.5 * (y[0] - t.sin());
        DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, -3.0 * y[0] * y[0], -0.6 * y[1], 0.0, 0.5 * y[2], 0.0, decay])
    };
    Watched { share, ..Watched::new(rate, jacobian, 1) }
}

pub(super) fn nonlinear_solution(t: f64) -> [f64; 3] {
    [t.sin(), t.cos(), (-t).exp()]
}

/// Kaps' problem: y1' = -(k + 2) y1 + k y2^2, y2' = y1 - y2 - y2^2 with the solution (e^-2t, e^-t) for any k.
pub(super) const KAPS: f64 = 1e8;

pub(super) fn kaps() -> Watched {
    let rate: Rate = |_, y, dy| {
        dy[0] = -(KAPS + 2.0) * y[0] + KAPS * y[1] * y[1];
        dy[1] = y[0] - y[1] - y[1] * y[1];
    };
    let jacobian: Jacobian = |_, y| DMatrix::from_row_slice(2, 2, &[-(KAPS + 2.0), 2.0 * KAPS * y[1], 1.0, -1.0 - 2.0 * y[1]]);
    Watched::new(rate, jacobian, 0)
}

pub(super) fn kaps_solution(t: f64) -> [f64; 2] {
    [(-2.0 * t).exp(), (-t).exp()]
}

/// Relaxation to a slow motion (Prothero, Robinson): y' = -1e6 (y - cos t) - sin t.
pub(super) fn relaxation() -> Watched {
    Watched::new(|t, y, dy| dy[0] = -1e6 * (y[0] - t.cos()) - t.sin(), |_, _| DMatrix::from_element(1, 1, -1e6), 0)
}

/// A wheel on its rail: y' = -100 (y - w(x)) + w'(x), x' = 1, w = sin 2x, with the solution y = w(x).
pub(super) fn rail() -> Watched {
    let rate: Rate = |_, y, dy| (dy[0], dy[1]) = (1.0, -100.0 * (y[1] - (2.0 * y[0]).sin()) + 2.0 * (2.0 * y[0]).cos());
    let jacobian: Jacobian = |_, y| {
        let (sin, cos) = (2.0 * y[0]).sin_cos();
        DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 200.0 * cos - 4.0 * sin, -100.0])
    };
    Watched::new(rate, jacobian, 0)
}

pub(super) fn rail_solution(t: f64) -> [f64; 2] {
    [t, (2.0 * t).sin()]
}

/// A mass on a very stiff spring: q'' = -w^2 q with w = 1e6 / s.
pub(super) fn stiff_spring() -> Watched {
    let rate: Rate = |_, y, dy| (dy[0], dy[1]) = (y[1], -1e12 * y[0]);
    Watched::new(rate, |_, _| DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -1e12, 0.0]), 1)
}

/// Van der Pol's relaxation oscillation in slow time: y1' = y2, y2' = 1e6 ((1 - y1^2) y2 - y1).
pub(super) fn van_der_pol() -> Watched {
    let rate: Rate = |_, y, dy| (dy[0], dy[1]) = (y[1], 1e6 * ((1.0 - y[0] * y[0]) * y[1] - y[0]));
    let jacobian: Jacobian = |_, y| DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1e6 * (-2.0 * y[0] * y[1] - 1.0), 1e6 * (1.0 - y[0] * y[0])]);
    Watched::new(rate, jacobian, 1)
}

/// Largest errors at the ends of steps of length h and inside of them, until `stop`.
pub(super) fn errors<const N: usize>(
    integrator: &dyn Integrator,
    mut system: Watched,
    solution: fn(f64) -> [f64; N],
    h: f64,
    stop: f64,
) -> (f64, f64) {
    let mut state = integrator.start(0.0, &solution(0.0));
    let mut scratch = Scratch::new(N, 0);
    let distance = |t: f64, y: &[f64]| y.iter().zip(solution(t)).map(|(y, exact)| (y - exact).abs()).fold(0.0, f64::max);
    let (mut ends, mut inside) = (0f64, 0f64);
    let mut y = [0.0; N];
    while state.t < stop - 1e-9 {
        state.next_step = h;
        assert_eq!(integrator.step(&mut system, &mut state, &mut scratch), Ok(()));
        ends = ends.max(distance(state.t, &state.y));
        for k in 1..10 {
            let t = state.t_begin + (state.t - state.t_begin) * f64::from(k) / 10.0;
            state.interpolate(&system, t, &mut y);
            inside = inside.max(distance(t, &y));
        }
    }
    (ends, inside)
}

/// Slopes of both errors over five step sizes, by least squares.
pub(super) fn orders(mut at: impl FnMut(f64) -> (f64, f64), largest: f64) -> (f64, f64) {
    let points: Vec<[f64; 3]> = (0..5)
        .map(|k| {
            let h = largest * 0.5f64.powi(k);
            let (ends, inside) = at(h);
            [h.ln(), ends.ln(), inside.ln()]
        })
        .collect();
    let mean = |column: usize| points.iter().map(|point| point[column]).sum::<f64>() / 5.0;
    let covariance = |column: usize| points.iter().map(|point| (point[0] - mean(0)) * (point[column] - mean(column))).sum::<f64>();
    (covariance(1) / covariance(0), covariance(2) / covariance(0))
}

/// A run that is saved, and put back into another system that was elsewhere, must end in the same bits as one that was not.
pub(super) fn assert_restores_bits(integrator: &dyn Integrator, event_value: Option<f64>) {
    let fresh = || Watched { event_value, breaks: 0.52, ..nonlinear(1.0) };
    let mut scratch = Scratch::new(3, usize::from(event_value.is_some()));
    let (mut through, mut system) = (integrator.start(0.0, &nonlinear_solution(0.0)), fresh());
    let mut saved = Vec::new();
    for i in 1..=20 {
        assert_eq!(integrator.advance(&mut system, &mut through, &mut scratch, 0.05 * f64::from(i)), Ok(()));
        saved.push(through.clone());
    }
    for (i, state) in saved.iter().enumerate() {
        let (mut again, mut other) = (state.clone(), fresh());
        let mut elsewhere = [0.0; 3];
        assert_eq!(other.derivative(7.0, &[1.0, 2.0, 3.0], &mut elsewhere), Ok(()));
        scratch.stages.iter_mut().for_each(|stage| stage.fill(f64::NAN));
        for k in i + 2..=20 {
            assert_eq!(integrator.advance(&mut other, &mut again, &mut scratch, 0.05 * k as f64), Ok(()));
        }
        assert_eq!(again, through, "{integrator:?} from {i}");
    }
}
