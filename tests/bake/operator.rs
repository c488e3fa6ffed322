//! The operator is the linear map the stencil says, with its transpose and its symbol.

use crate::stencils::{self as of, ALL};
use crate::{BORDERS, noise};
use faer::{Mat, MatRef};
use kutta::normals::{Axis, BakeError, Border, Operator, Stencil, Taps};
use num_complex::Complex;

const SIZES: [[usize; 2]; 9] = [[1, 1], [1, 7], [7, 1], [2, 2], [3, 2], [4, 5], [9, 4], [17, 12], [21, 33]];

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn apply(operator: &Operator<f64>, axis: Axis, x: &[f64]) -> Vec<f64> {
    let mut y = vec![f64::NAN; x.len()];
    operator.apply(axis, x, &mut y).unwrap();
    y
}

#[test]
fn the_adjoint_is_the_transpose() {
    for stencil in &ALL {
        for size in SIZES {
            for (s, t) in BORDERS.into_iter().zip([1, 2, 3, 0].map(|i| BORDERS[i])) {
                for border in [[s, t], [s, s]] {
                    let operator = Operator::new(stencil, size, border).unwrap();
                    let n = size[0] * size[1];
                    let both = noise(2 * n);
                    let (x, y) = both.split_at(n);
                    for axis in [Axis::S, Axis::T] {
                        let mut back = vec![f64::NAN; n];
                        operator.adjoint(axis, y, &mut back).unwrap();
                        let (left, right) = (dot(&apply(&operator, axis, x), y), dot(x, &back));
                        // Sums of n products of numbers below 1 and weights of extrapolation up to 1e3.
                        assert!(
                            (left - right).abs() < 1e-11 * n as f64,
                            "{} {size:?} {border:?} {axis:?}: {left} {right}",
                            stencil.title
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn on_small_lines_it_is_the_sum_over_folded_texels() {
    // By the definition of each border, on lines shorter than the stencil too.
    let find = |border: Border, i: isize, n: isize| match border {
        Border::Wrap => ((i % n) + n) % n,
        Border::Clamp => i.max(0).min(n - 1),
        // ... b1 b0 | b0 b1 .. bn-1 | bn-1 ...: walk there one step at a time.
        _ => {
            let (mut at, mut step, mut left) = (0, 1, i);
            if i < 0 {
                (left, step) = (-i - 1, 1);
            }
            while left > 0 {
                if (step == 1 && at == n - 1) || (step == -1 && at == 0) {
                    step = -step;
                } else {
                    at += step;
                }
                left -= 1;
            }
            at
        }
    };
    let explicit = ALL.iter().filter(|stencil| stencil.left.len == 1);
    for stencil in explicit {
        for border in [Border::Wrap, Border::Clamp, Border::Mirror] {
            for (w, h) in [(1, 1), (1, 5), (6, 1), (2, 3), (5, 4), (13, 11)] {
                let b = noise(w * h);
                let operator = Operator::new(stencil, [w, h], [border; 2]).unwrap();
                let taps = |taps: &Taps| -> Vec<(isize, f64)> {
                    (0..taps.len).map(|j| (taps.first + j as isize, taps.weight[j].hi())).collect()
                };
                let at = |x: isize, y: isize| {
                    b[(find(border, y, h as isize) * w as isize + find(border, x, w as isize)) as usize]
                };
                let (ds, dt) = (apply(&operator, Axis::S, &b), apply(&operator, Axis::T, &b));
                for y in 0..h as isize {
                    for x in 0..w as isize {
                        let (mut s, mut t) = (0.0, 0.0);
                        for (i, a) in taps(&stencil.along) {
                            for (j, c) in taps(&stencil.across) {
                                s += a * c * at(x + i, y - j);
                                t += a * c * at(x + j, y - i);
                            }
                        }
                        let i = y as usize * w + x as usize;
                        assert!((ds[i] - s).abs() < 1e-14 && (dt[i] - t).abs() < 1e-14);
                    }
                }
            }
        }
    }
}

#[test]
fn one_sided_borders_are_exact_on_polynomials_of_the_order() {
    for stencil in &ALL {
        for n in 1..24 {
            let degree = stencil.order.min(n - 1);
            let operator = Operator::new(stencil, [n, n], [Border::OneSided; 2]).unwrap();
            // Shifted and scaled to stay near 1 on the grid.
            let p =
                |x: f64| (0..=degree).map(|k| ((x - 3.3) / 8.0).powi(k as i32) * (k + 1) as f64).sum::<f64>();
            let slope = |x: f64| {
                (1..=degree)
                    .map(|k| ((x - 3.3) / 8.0).powi(k as i32 - 1) * (k * (k + 1)) as f64 / 8.0)
                    .sum::<f64>()
            };
            let s: Vec<f64> = (0..n * n).map(|i| p((i % n) as f64)).collect();
            let t: Vec<f64> = (0..n * n).map(|i| p(n as f64 - (i / n) as f64)).collect();
            let (ds, dt) = (apply(&operator, Axis::S, &s), apply(&operator, Axis::T, &t));
            for i in 0..n * n {
                let at = stencil.at.hi();
                let (x, y) = ((i % n) as f64 + at, n as f64 - (i / n) as f64 + at);
                // Values to 1e4 at the far end of degree 8, weights of extrapolation to 1e3, rounding 1e-16;
                // farid5's entries are rounded to six digits, which is in its moments.
                let tolerance = 1e-9 + if stencil.title == "farid5" { 1e-6 } else { 0.0 };
                let (es, et) = ((ds[i] - slope(x)).abs(), (dt[i] - slope(y)).abs());
                let size = 1.0 + slope(x).abs() + slope(y).abs();
                assert!(es < tolerance * size, "{} n {n} s at {i}: {} {}", stencil.title, ds[i], slope(x));
                assert!(et < tolerance * size, "{} n {n} t at {i}: {} {}", stencil.title, dt[i], slope(y));
            }
        }
    }
}

#[test]
fn the_table_of_central4_at_the_first_texel_is_the_textbook_one() {
    // Abramowitz and Stegun, table 25.2, five points.
    let operator = Operator::<f64>::new(&of::CENTRAL4, [9, 1], [Border::OneSided; 2]).unwrap();
    let mut first = [0.0; 9];
    first[0] = 1.0;
    let mut row = [0.0; 9];
    operator.adjoint(Axis::S, &first, &mut row).unwrap();
    let expected = [-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(row, expected);
}

#[test]
fn waves_are_multiplied_by_the_symbol() {
    for stencil in &ALL {
        let (w, h) = (24, 15);
        let operator = Operator::new(stencil, [w, h], [Border::Wrap; 2]).unwrap();
        for (p, q) in [(1, 0), (0, 2), (3, 4), (11, 7)] {
            let k = [p as f64 / w as f64, q as f64 / h as f64].map(|k| k * std::f64::consts::TAU);
            // t = -row. Whole turns are left out before anything is rounded.
            let turns = |p: usize, n: usize, i: usize| (p * i % n) as f64 / n as f64;
            let phase = |i: usize| std::f64::consts::TAU * (turns(p, w, i % w) - turns(q, h, i / w));
            let wave: Vec<Complex<f64>> = (0..w * h).map(|i| Complex::cis(phase(i))).collect();
            // What rounding is multiplied by: the weights, over what is left of a compact left-hand side's middle.
            let size = |taps: &Taps| (0..taps.len).map(|j| taps.weight[j].hi().abs()).sum::<f64>();
            let left =
                2.0 * stencil.left.weight[usize::from(stencil.left.len > 1)].hi() - size(&stencil.left);
            let gain = size(&stencil.along) * size(&stencil.across) / left;
            let part = |f: fn(&Complex<f64>) -> f64| wave.iter().map(f).collect::<Vec<_>>();
            for axis in [Axis::S, Axis::T] {
                let re = apply(&operator, axis, &part(|z| z.re));
                let im = apply(&operator, axis, &part(|z| z.im));
                let symbol = operator.symbol(axis, k);
                for i in 0..w * h {
                    // Phases of the symbol to 24 radians, of the wave to 6, sums of up to 9 terms: 32 epsilons.
                    let off = (Complex::new(re[i], im[i]) - symbol * wave[i]).norm();
                    assert!(off < 32.0 * f64::EPSILON * gain, "{}: {off:e}, {gain}", stencil.title);
                }
            }
        }
    }
    // Lele (1992), eq. 3.1.4: the modified wavenumber of the compact stencil of order 6.
    let operator = Operator::<f64>::new(&of::COMPACT6, [8, 8], [Border::Wrap; 2]).unwrap();
    let k = 1.0f64;
    let exact = (14.0 / 9.0 * k.sin() + 1.0 / 18.0 * (2.0 * k).sin()) / (1.0 + 2.0 / 3.0 * k.cos());
    assert!((operator.symbol(Axis::S, [k, 0.3]) - Complex::new(0.0, exact)).norm() < 1e-15);
}

#[test]
fn slices_matrices_and_scalars_agree() {
    let (w, h) = (7, 5);
    let b = noise(w * h);
    let operator = Operator::<f64>::new(&of::FARID5, [w, h], [Border::Mirror, Border::OneSided]).unwrap();
    let single = Operator::<f32>::new(&of::FARID5, [w, h], [Border::Mirror, Border::OneSided]).unwrap();
    let b32: Vec<f32> = b.iter().map(|b| *b as f32).collect();
    // Columns are contiguous here, rows are in the slice.
    let matrix = Mat::from_fn(h, w, |y, x| b[y * w + x]);
    for axis in [Axis::S, Axis::T] {
        let slopes = apply(&operator, axis, &b);
        let mut out = Mat::from_fn(h, w, |_, _| f64::NAN);
        operator.apply_mat(axis, matrix.as_ref(), out.as_mut()).unwrap();
        assert_eq!(out, MatRef::from_row_major_slice(&slopes, h, w).to_owned());
        let mut back = Mat::from_fn(h, w, |_, _| f64::NAN);
        operator.adjoint_mat(axis, out.as_ref(), back.as_mut()).unwrap();
        let mut expected = vec![0.0; w * h];
        operator.adjoint(axis, &slopes, &mut expected).unwrap();
        assert_eq!(back, MatRef::from_row_major_slice(&expected, h, w).to_owned());
        let mut slopes32 = vec![0.0; w * h];
        single.apply(axis, &b32, &mut slopes32).unwrap();
        // Ten or so sums of numbers below 2.
        assert!(slopes.iter().zip(&slopes32).all(|(a, b)| (a - f64::from(*b)).abs() < 2e-6));
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let new = |stencil: &Stencil, size| Operator::<f64>::new(stencil, size, [Border::Wrap; 2]);
    assert_eq!(new(&of::CENTRAL2, [0, 4]).err(), Some(BakeError::Size { width: 0, height: 4 }));
    let operator = new(&of::CENTRAL2, [3, 2]).unwrap();
    let error = operator.apply(Axis::S, &[0.0; 6], &mut [0.0; 5]);
    assert_eq!(error, Err(BakeError::Length { len: 5, need: 6 }));
    let (matrix, mut out) = (Mat::<f64>::zeros(3, 2), Mat::<f64>::zeros(2, 3));
    assert!(operator.apply_mat(Axis::S, matrix.as_ref(), out.as_mut()).is_err());
    // (1, 1, 1) on the left is singular on lines whose size three divides.
    let mut left = of::COMPACT6.left;
    (left.weight[0], left.weight[2]) = (left.weight[1], left.weight[1]);
    let singular = Stencil { left, ..of::COMPACT6 };
    assert_eq!(new(&singular, [6, 6]).err(), Some(BakeError::LeftSide { taps: 3 }));
}
