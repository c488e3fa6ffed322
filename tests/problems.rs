//! The catalogue against numbers from elsewhere (data/problems.toml), and its closed forms, references and
//! second-order forms against its own equations.

use kutta::problems::*;
use toml::{Table, Value};

fn number(value: &Value) -> f64 {
    value.as_float().unwrap_or_else(|| value.as_integer().expect("a number") as f64)
}

fn numbers(values: &Value) -> Vec<f64> {
    values.as_array().expect("an array").iter().map(number).collect()
}

/// Demands |got - want| <= relative |want| + absolute of every component; a NaN never passes.
fn assert_close(got: &[f64], want: &[f64], relative: f64, absolute: f64, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}: number of components");
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let miss = (got - want).abs();
        assert!(miss <= relative * want.abs() + absolute, "{what}, component {i}: {got:e}, not {want:e}");
    }
}

fn filled<Y: AsMut<[f64]>>(mut y: Y, values: &[f64]) -> Y {
    y.as_mut().copy_from_slice(values);
    y
}

/// The right-hand side at y, which is also the state that the result is written over.
fn rhs<P: Problem>(problem: &P, t: f64, y: &P::Y) -> P::Y {
    let mut dy = y.clone();
    problem.rhs(t, y, &mut dy);
    dy
}

/// Numbers between -1 and 1 that follow no pattern of the equations.
fn scattered(n: usize) -> Vec<f64> {
    (0..n).map(|i| (1.0 + 1.7 * i as f64 + 0.3 * (i * i) as f64).sin()).collect()
}

/// A visit to the whole catalogue, and to those built to size in the sizes of the data.
fn visit_all_and_small(v: &mut impl Visit) {
    visit_all(v);
    v.visit(Heat1d::new(5));
    v.visit(Heat2d::new(3));
    v.visit(Brusselator2d::new(4));
    v.visit_second_order(NBodyRing::new(4));
    v.visit_second_order(SpringChain::new(11));
}

#[test]
fn equations_are_the_printed_ones() {
    struct Printed {
        data: Table,
        seen: Vec<&'static str>,
    }
    impl Visit for Printed {
        fn visit<P: Problem>(&mut self, problem: P) {
            let entry = self.data[P::NAME].as_table().unwrap_or_else(|| panic!("no data for {}", P::NAME));
            let sized = entry.contains_key("n");
            let (y0, n) = (numbers(&entry["y0"]), problem.n());
            if sized && y0.len() != n {
                return;
            }
            self.seen.push(P::NAME);
            // Where the start has sines or roots it may miss the last digit.
            let rounding = if sized || P::NAME == "brusselator1d-n40" { 4e-16 } else { 0.0 };
            assert_close(problem.y0().as_ref(), &y0, rounding, rounding, P::NAME);
            assert_eq!(<[f64; 2]>::from(problem.span()), numbers(&entry["span"])[..], "{}: span", P::NAME);
            if let Some(stiff) = entry.get("stiff") {
                assert_eq!(stiff.as_bool(), Some(P::STIFF), "{}: stiff", P::NAME);
            }
            for at in entry["at"].as_array().expect("an array of points") {
                let (t, y) = (number(&at["t"]), filled(problem.y0(), &numbers(&at["y"])));
                let f = rhs(&problem, t, &y);
                assert_close(f.as_ref(), &numbers(&at["f"]), 1e-13, 0.0, &format!("{}: f", P::NAME));
                let Some(entries) = at.get("jacobian") else { continue };
                let mut want = vec![0.0; n * n];
                for entry in entries.as_array().expect("an array of entries").iter().map(numbers) {
                    want[entry[0] as usize * n + entry[1] as usize] = entry[2];
                }
                let mut j = vec![f64::NAN; n * n];
                problem.dense_jacobian(t, &y, &mut j);
                assert_close(&j, &want, 1e-12, 0.0, &format!("{}: Jacobian", P::NAME));
            }
        }
    }
    let data: Table = include_str!("data/problems.toml").parse().expect("TOML");
    let mut printed = Printed { data, seen: Vec::new() };
    visit_all_and_small(&mut printed);
    assert_eq!(printed.seen.len(), catalogue().len(), "every problem is compared once: {:?}", printed.seen);
    for name in printed.data.keys() {
        assert!(printed.seen.contains(&name.as_str()), "{name} has data but is not in the catalogue");
    }
}

/// So that a solver may find the places once and keep them.
#[test]
fn jacobians_have_the_same_places_everywhere() {
    struct Places;
    impl Visit for Places {
        fn visit<P: Problem>(&mut self, problem: P) {
            let places = |t, y: &P::Y| {
                let mut places = Vec::new();
                problem.jacobian(t, y, |row, column, _| places.push((row, column)));
                places
            };
            let (y0, n) = (problem.y0(), problem.n());
            let at_start = places(problem.span().0, &y0);
            assert!(at_start.iter().all(|&(row, column)| row < n && column < n), "{}", P::NAME);
            assert_eq!(at_start, places(problem.span().1, &filled(y0, &scattered(n))), "{}", P::NAME);
        }
    }
    visit_all_and_small(&mut Places);
}

/// On a torus of two by two points every point has each neighbour twice.
#[test]
fn smallest_torus() {
    let torus = Brusselator2d::new(2);
    let y = [1.0, 2.0, 4.0, 8.0, 3.0, 1.0, 0.5, 2.0];
    let spread = |w: &[f64], k: usize| 4e-3 * (2.0 * w[k ^ 1] + 2.0 * w[k ^ 2] - 4.0 * w[k]);
    let (u, v) = y.split_at(4);
    let du = (0..4).map(|k| 1.0 + u[k] * u[k] * v[k] - 4.4 * u[k] + spread(u, k));
    let dv = (0..4).map(|k| 3.4 * u[k] - u[k] * u[k] * v[k] + spread(v, k));
    let f = rhs(&torus, 0.0, &y.to_vec());
    assert_close(&f, &du.chain(dv).collect::<Vec<_>>(), 1e-14, 1e-14, "f");
    let mut j = vec![0.0; 64];
    torus.dense_jacobian(0.0, &y.to_vec(), &mut j);
    assert_close(&j[..5], &[2.0 * 3.0 - 4.4 - 16e-3, 8e-3, 8e-3, 0.0, 1.0], 1e-14, 0.0, "Jacobian");
}

#[test]
fn closed_forms_satisfy_their_equations() {
    struct ClosedForms(Vec<&'static str>);
    impl Visit for ClosedForms {
        fn visit<P: Problem>(&mut self, problem: P) {
            let (t0, t1) = problem.span();
            let Some(start) = problem.exact(t0) else { return };
            self.0.push(P::NAME);
            assert_close(start.as_ref(), problem.y0().as_ref(), 0.0, 1e-13, &format!("{}: start", P::NAME));
            for part in [0.01, 0.1, 0.5, 0.9] {
                let (t, h) = (t0 + part * (t1 - t0), 2e-4 * (t1 - t0));
                let exact = |t| problem.exact(t).expect("a closed form");
                let y = exact(t);
                let f = rhs(&problem, t, &y);
                // Central difference of order 8.
                let mut slope = vec![0.0; problem.n()];
                for (k, weight) in
                    [(1.0, 4.0 / 5.0), (2.0, -1.0 / 5.0), (3.0, 4.0 / 105.0), (4.0, -1.0 / 280.0)]
                {
                    let (after, before) = (exact(t + k * h), exact(t - k * h));
                    for (slope, (a, b)) in slope.iter_mut().zip(after.as_ref().iter().zip(before.as_ref())) {
                        *slope += weight * (a - b) / h;
                    }
                }
                // f is no better known than the rounding of y lets it be.
                let mut known = 0f64;
                problem.jacobian(t, &y, |_, column, value| {
                    known = known.max((value * y.as_ref()[column]).abs())
                });
                let largest = f.as_ref().iter().fold(0f64, |m, f| m.max(f.abs()));
                let tolerance = 1e-9 * largest + 1e-15 * known;
                assert_close(&slope, f.as_ref(), 0.0, tolerance, &format!("{} at {t}", P::NAME));
            }
            let reference = problem.reference().expect("a closed form gives a reference");
            let largest = reference.as_ref().iter().fold(0f64, |m, y| m.max(y.abs()));
            let end = problem.exact(t1).expect("a closed form");
            assert_close(
                end.as_ref(),
                reference.as_ref(),
                0.0,
                2e-13 * largest,
                &format!("{}: end", P::NAME),
            );
        }
    }
    let mut forms = ClosedForms(Vec::new());
    visit_all(&mut forms);
    let expected =
        "exponential-decay harmonic-oscillator kepler-e06 nbody-ring spring-chain prothero-robinson
        curtiss-hirschfelder stiff-spring-overdamped stiff-spring-underdamped stiff-oscillator non-normal jump heat-n100 heat1d heat2d";
    assert_eq!(forms.0, expected.split_whitespace().collect::<Vec<_>>());
    // The smallest sizes, whose points have no neighbours, or one.
    forms.visit(NBodyRing::new(2));
    for n in [1, 2, 3] {
        forms.visit(SpringChain::new(n));
        forms.visit(Heat1d::new(n));
        forms.visit(Heat2d::new(n));
    }
    assert_eq!(forms.0.len(), 15 + 10);
}

#[test]
fn references_have_their_digits_and_agree_with_the_published() {
    struct References {
        data: Table,
        published: usize,
        without: Vec<&'static str>,
    }
    impl Visit for References {
        fn visit<P: Problem>(&mut self, problem: P) {
            let Some(reference) = problem.reference() else {
                self.without.push(P::NAME);
                return;
            };
            let text = problem.reference_text();
            let closed = problem.exact(problem.span().1).is_some();
            assert!(text.len() == problem.n() || text.is_empty() && closed, "{}: one text each", P::NAME);
            for text in text {
                let digits = text.split('e').next().expect("a mantissa").trim_start_matches(['-', '0', '.']);
                assert!(digits.len() - digits.matches('.').count() >= 18, "{}: {text}", P::NAME);
            }
            if let Some(published) = self.data[P::NAME].get("published") {
                self.published += 1;
                assert_close(reference.as_ref(), &numbers(published), 1e-12, 0.0, P::NAME);
            }
        }
    }
    let data: Table = include_str!("data/problems.toml").parse().expect("TOML");
    let mut references = References { data, published: 0, without: Vec::new() };
    visit_all(&mut references);
    assert_eq!(references.published, 7);
    assert_eq!(references.without, ["brusselator2d"]);
    let e5 = E5Until1e13.reference().expect("a reference");
    assert_eq!((e5[0], e5[3]), (0.0, 0.0), "what is below the range of f64 is 0");
}

/// What an equation keeps, its reference must have kept.
#[test]
fn references_keep_what_the_equations_keep() {
    fn keeps<P: Problem, const K: usize>(problem: P, relative: f64, kept: impl Fn(&P::Y) -> [f64; K]) {
        let end = kept(&problem.reference().expect("a reference"));
        assert_close(&end, &kept(&problem.y0()), relative, relative, P::NAME);
    }
    keeps(LotkaVolterra, 1e-15, |[x, y]| [x - 3.0 * x.ln() + y - 1.5 * y.ln()]);
    keeps(RigidBody, 1e-15, |[a, b, c]| {
        [0.5 * a * a + 2.0 * b * b + 3.0 * c * c, a * a + 16.0 * b * b + 36.0 * c * c].map(|kept| kept / 10.0)
    });
    keeps(KeplerE06, 1e-15, |[x, y, u, v]| [0.5 * (u * u + v * v) - 1.0 / x.hypot(*y), x * v - y * u]);
    keeps(Arenstorf4Loop, 1e-12, |[x, y, u, v]| {
        let mu = 0.012277471;
        let potential = (1.0 - mu) / (x + mu).hypot(*y) + mu / (x - 1.0 + mu).hypot(*y);
        [x * x + y * y - u * u - v * v + 2.0 * potential]
    });
    keeps(Pleiades, 1e-14, |y| {
        let mut energy = 0.0;
        let (mut px, mut py, mut spin) = (0.0, 0.0, 0.0);
        for i in 0..7 {
            let m = (i + 1) as f64;
            let (x, y, u, v) = (y[i], y[7 + i], y[14 + i], y[21 + i]);
            (px, py, spin) = (px + m * u, py + m * v, spin + m * (x * v - y * u));
            energy += 0.5 * m * (u * u + v * v);
        }
        for i in 0..7 {
            for j in 0..i {
                energy -= ((i + 1) * (j + 1)) as f64 / (y[i] - y[j]).hypot(y[7 + i] - y[7 + j]);
            }
        }
        [energy, px, py, spin].map(|kept| kept / 100.0)
    });
    keeps(RobertsonUntil40, 1e-15, |y| [y.iter().sum()]);
    keeps(RobertsonUntil1e11, 1e-15, |y| [y.iter().sum()]);
    keeps(Hires, 1e-17, |y| [y[6] + y[7]]);
    // Relative to the smallest, as all is tiny.
    keeps(E5Until1e11, 1e-15, |y| [(y[1] - y[2] - y[3]) / 1e-20]);
    keeps(E5Until1e13, 1e-15, |y| [(y[1] - y[2] - y[3]) / 1e-22]);
}

#[test]
fn second_order_problems_are_their_systems() {
    struct Halves(Vec<&'static str>);
    impl Visit for Halves {
        fn visit<P: Problem>(&mut self, _: P) {}
        fn visit_second_order<P: SecondOrder>(&mut self, problem: P) {
            self.0.push(P::NAME);
            let (y0, half) = (problem.y0(), problem.n() / 2);
            assert_eq!(y0.as_ref(), [problem.x0().as_ref(), problem.v0().as_ref()].concat(), "{}", P::NAME);
            for v in [0.5, -2.0] {
                let mut y = scattered(2 * half);
                y[half..].iter_mut().for_each(|y| *y *= v);
                let x = filled(problem.x0(), &y[..half]);
                let mut a = problem.x0();
                problem.acceleration(0.25, &x, &mut a);
                let f = rhs(&problem, 0.25, &filled(problem.y0(), &y));
                assert_eq!(f.as_ref(), [&y[half..], a.as_ref()].concat(), "{}", P::NAME);
            }
        }
    }
    let mut halves = Halves(Vec::new());
    visit_all(&mut halves);
    assert_eq!(halves.0, ["harmonic-oscillator", "kepler-e06", "pleiades", "nbody-ring", "spring-chain"]);
    let marked = catalogue().into_iter().filter(|entry| entry.second_order).map(|entry| entry.name);
    let (mut marked, mut seen) = (marked.collect::<Vec<_>>(), halves.0);
    marked.sort();
    seen.sort();
    assert_eq!(marked, seen);
}

#[test]
fn names_are_unique_and_plain() {
    let all = catalogue();
    for (i, entry) in all.iter().enumerate() {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(entry.name.chars().all(plain), "{}", entry.name);
        assert!(all[..i].iter().all(|other| other.name != entry.name), "{} twice", entry.name);
        assert!(!entry.about.contains('\n') && entry.about.len() < 100, "{}: one line about it", entry.name);
    }
}
