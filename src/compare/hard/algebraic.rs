//! Hard problems with algebraic equations: M y' = f(t, y) with a singular M.

use super::{Case, Erased};
use crate::linear::Jacobian;
use crate::problems::{Problem, RobertsonUntil1e11, RobertsonUntil40};
use std::f64::consts::PI;
use std::rc::Rc;

/// Robertson's problems, found among `cases`, and the amplifier.
pub(super) fn cases(cases: &[Case]) -> Vec<Case> {
    let of = |name: &str| cases.iter().find(|case| case.name == name);
    let near = of(RobertsonUntil40::NAME).map(|case| with_the_sum(case, RobertsonUntil40));
    let far = of(RobertsonUntil1e11::NAME).map(|case| with_the_sum(case, RobertsonUntil1e11));
    near.into_iter().chain(far).chain([amplifier()]).collect()
}

/// Robertson's problem with y1 + y2 + y3 = 1 in place of its third equation: M = diag(1, 1, 0).
fn with_the_sum<P: Problem<Y = [f64; 3]> + Copy>(case: &Case, p: P) -> Case {
    let state = |y: &[f64]| [y[0], y[1], y[2]];
    let rhs = move |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        let mut slope = [0.0; 3];
        p.rhs(t, &state(y), &mut slope);
        slope[2] = y[0] + y[1] + y[2] - 1.0;
        dy.copy_from_slice(&slope);
    };
    let jacobian = move |t: f64, y: &Vec<f64>, j: &mut Jacobian<f64>| {
        p.jacobian(t, &state(y), |row, column, value| {
            if row < 2 {
                j[(row, column)] += value;
            }
        });
        (0..3).for_each(|column| j[(2, column)] = 1.0);
    };
    Case {
        name: format!("{}-algebraic", P::NAME),
        mass: Some(|m| (m[(0, 0)], m[(1, 1)]) = (1.0, 1.0)),
        // The sum is 1 to rounding, and knows nothing of amounts below that.
        scale: 1e-3,
        system: Erased { rhs: Rc::new(rhs), jacobian: Rc::new(jacobian), pattern: None },
        ..case.clone()
    }
}

const SUPPLY: f64 = 6.0;
const RESISTANCES: [f64; 2] = [1000.0, 9000.0];
/// The part of a transistor's current that does not leave through its base.
const ALPHA: f64 = 0.99;
/// Of a diode's current 1e-6 (exp(u / this) - 1).
const THERMAL: f64 = 0.026;

/// The transistor amplifier: the voltages at eight nodes, two transistors, five capacitors and a signal of 100 Hz
/// (Hairer, Lubich, Roche 1989, LNM 1409; Hairer, Wanner 1996, VI.1).
fn amplifier() -> Case {
    let current = |u: f64| 1e-6 * ((u / THERMAL).exp() - 1.0);
    let conductance = |u: f64| 1e-6 / THERMAL * (u / THERMAL).exp();
    let [r0, r] = RESISTANCES;
    let rhs = move |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        let signal = 0.1 * (200.0 * PI * t).sin();
        let (first, second) = (current(y[1] - y[2]), current(y[4] - y[5]));
        dy.copy_from_slice(&[
            (y[0] - signal) / r0,
            (2.0 * y[1] - SUPPLY) / r + (1.0 - ALPHA) * first,
            y[2] / r - first,
            (y[3] - SUPPLY) / r + ALPHA * first,
            (2.0 * y[4] - SUPPLY) / r + (1.0 - ALPHA) * second,
            y[5] / r - second,
            (y[6] - SUPPLY) / r + ALPHA * second,
            y[7] / r,
        ]);
    };
    let jacobian = move |_t: f64, y: &Vec<f64>, j: &mut Jacobian<f64>| {
        let resistances = [1.0 / r0, 2.0 / r, 1.0 / r, 1.0 / r, 2.0 / r, 1.0 / r, 1.0 / r, 1.0 / r];
        (0..8).for_each(|i| j[(i, i)] += resistances[i]);
        for base in [1, 4] {
            let g = conductance(y[base] - y[base + 1]);
            for (row, part) in [(base, 1.0 - ALPHA), (base + 1, -1.0), (base + 2, ALPHA)] {
                j[(row, base)] += part * g;
                j[(row, base + 1)] -= part * g;
            }
        }
    };
    Case {
        name: "transistor-amplifier".to_string(),
        about: "eight voltages, five of whose combinations are charges and three follow from the others",
        n: 8,
        y0: vec![0.0, 3.0, 3.0, 6.0, 3.0, 3.0, 6.0, 0.0],
        span: (0.0, 0.2),
        breaks: &[],
        // Capacitors of one to five microfarads between the nodes; no row is zero, and the rank is 5.
        mass: Some(|m| {
            for (i, j, c) in [(0, 1, 1e-6), (3, 4, 3e-6), (6, 7, 5e-6)] {
                (m[(i, i)], m[(i, j)]) = (-c, c);
                (m[(j, i)], m[(j, j)]) = (c, -c);
            }
            (m[(2, 2)], m[(5, 5)]) = (-2e-6, -4e-6);
        }),
        scale: 1.0,
        // By extrapolation of the midpoint rule to order 18 on the five charges, the algebraic equations solved inside,
        // in 34 digits; runs of 4000 and 6000 steps agree in these.
        reference: vec![
            -5.562145012262275e-3,
            3.006522471903043,
            2.8499587886081286,
            2.9264225362062417,
            2.7046178650105546,
            2.761837778393144,
            4.770927631616773,
            1.2369958680915476,
        ],
        system: Erased { rhs: Rc::new(rhs), jacobian: Rc::new(jacobian), pattern: None },
    }
}
