//! Derived properties against numbers from elsewhere: data/properties.toml, books and papers.

use kutta::methods;
use kutta::tableau::{Evidence, Properties, Stages, Tableau};
use std::sync::LazyLock;
use toml::{Table, Value};

/// Every method's, derived once.
static ALL: LazyLock<Vec<(&str, Properties)>> =
    LazyLock::new(|| methods::all().iter().map(|entry| (entry.name, entry.tableau().properties())).collect());

fn of(name: &str) -> &'static Properties {
    &ALL.iter().find(|(of, _)| *of == name).unwrap_or_else(|| panic!("{name} is a method")).1
}

fn close(got: Option<f64>, want: f64, tolerance: f64) -> bool {
    got.is_some_and(|got| got == want || (got - want).abs() <= tolerance * (1.0 + want.abs()))
}

/// A property by its name in the data, and how close it must be: to the digits that the data have.
fn agrees(name: &str, p: &Properties, key: &str, want: &Value) -> bool {
    let number = || want.as_float().unwrap_or_else(|| panic!("{name}: {key} is no decimal"));
    let flag = || want.as_bool();
    let multistep = p.family.contains("multistep");
    match key {
        "kind" => {
            let kinds =
                [("explicit", Stages::Explicit), ("diagonal", Stages::Diagonal), ("full", Stages::Full)];
            kinds.iter().any(|&(text, kind)| want.as_str() == Some(text) && p.kind == kind)
        }
        "stage_order" => want.as_integer() == p.stage_order.map(|q| q as i64),
        "fsal" => flag() == Some(p.fsal),
        "stiffly_accurate" => flag() == p.stiffly_accurate,
        "symplectic" => flag() == p.symplectic,
        "symmetric" => flag() == p.symmetric,
        "zero_stable" => flag() == p.zero_stable,
        "a_stable" => flag() == p.a_stable,
        "l_stable" => flag() == p.l_stable,
        "real_limit" => close(p.real_limit, number(), if multistep { 1e-6 } else { 1e-11 }),
        "imaginary_limit" => close(p.imaginary_limit, number(), 1e-11),
        "at_infinity" => close(p.at_infinity, number(), 1e-10),
        "alpha" => close(p.alpha, number(), 4e-6),
        "error_constant" => close(p.error_constant, number(), 1e-15),
        _ => panic!("{name}: {key} is not compared"),
    }
}

#[test]
fn an_independent_program_finds_the_same() {
    let data: Table = include_str!("data/properties.toml").parse().unwrap();
    let mut compared = 0;
    for (name, wants) in &data {
        let p = of(name);
        for (key, want) in wants.as_table().unwrap() {
            assert!(agrees(name, p, key, want), "{name}: {key} is {want:?} there, and not in {p:?}");
            compared += 1;
        }
    }
    assert!(data.len() > 130 && compared > 700, "{} methods, {compared} values", data.len());
}

#[test]
fn every_method_has_what_its_family_has() {
    for (name, p) in ALL.iter() {
        let explicit = p.kind == Stages::Explicit;
        let partitioned = p.family == "partitioned pair";
        assert_eq!(p.oscillation_limit.is_some(), p.second_order || partitioned, "{name}");
        assert_eq!(
            p.real_limit.is_some(),
            !p.second_order && !partitioned && p.family != "Rosenbrock",
            "{name}"
        );
        assert_eq!(p.a_stable.is_some(), !p.second_order && !partitioned && !explicit, "{name}");
        assert!(p.steppable, "{name}");
        assert_eq!((p.blind.len(), p.embedded_errors.len()), (p.embedded.len(), p.embedded.len()), "{name}");
        if p.family != "Rosenbrock" {
            assert_eq!(p.evaluations + p.fsal as usize, p.stages, "{name}");
        }
        // No order is claimed too low, and rounding costs digits, not orders.
        // The trees of order 13 weigh a formula's error constant with up to 13!.
        let steps_back = if p.members.is_empty() { 1e4 } else { 1e5 };
        let largest = if p.zero_stable.is_some() { steps_back } else { 10.0 };
        assert!((1e-9..largest).contains(&p.principal_error), "{name}: {}", p.principal_error);
        assert!(p.embedded_errors.iter().all(|error| (1e-9..largest).contains(error)), "{name}");
        assert!(p.residual_f64 < 1e-10 && p.residual_f32 < 0.04, "{name}");
        assert!(p.residual_f64 <= p.residual_f32, "{name}");
        assert!(p.zero_stable != Some(false), "{name}");
    }
}

/// Signs of polynomials decide A-stability; the angle of a sector is found, but that there is none takes one point.
#[test]
fn what_is_proven_of_the_sector() {
    let of_alpha = |p: &Properties| (p.alpha.map(|alpha| alpha > 0.0 && alpha < 90.0), p.evidence);
    let mut proven = 0;
    for (name, p) in ALL.iter() {
        match of_alpha(p) {
            (None, None) => assert!(p.a_stable.is_none(), "{name}"),
            (Some(true), Some(Evidence::Found { degrees })) => assert!(degrees > 0.0, "{name}"),
            (Some(false), Some(Evidence::Proven)) => proven += (p.a_stable == Some(true)) as usize,
            // A table may touch the axis, where a double root is not told from two.
            (Some(false), Some(Evidence::Found { .. })) => assert_eq!(p.a_stable, Some(true), "{name}"),
            other => panic!("{name}: {other:?}"),
        }
    }
    assert!(proven > 55, "{proven}");
    for name in ["rodas5", "kvaerno5", "gauss5", "kencarp4-7-imex", "lobatto-iiia4", "am1", "bdf2"] {
        assert_eq!((of(name).a_stable, of(name).evidence), (Some(true), Some(Evidence::Proven)), "{name}");
    }
    let members = of("bdf").members.iter().map(|m| m.evidence == Evidence::Proven);
    assert_eq!(members.collect::<Vec<_>>(), [true, true, false, false, false]);
}

#[test]
fn error_norms_are_those_of_the_papers() {
    // Dormand, Prince 1980, table 3: A6 and the fifth-order norm of the embedded solution.
    let dp54 = of("dp54");
    assert!((dp54.principal_error - 3.99e-4).abs() < 5e-7);
    assert!((dp54.embedded_errors[0] - 1.18e-3).abs() < 5e-6);
    // Tsitouras 2011 states 1.3e-4 for his own pair.
    assert!((of("tsit54").principal_error - 1.3e-4).abs() < 1e-5);
    // Velocity Verlet by hand. In y the tree [v] weighs 0, not 1/6; in y' the tree [vv], which has two
    // symmetries, weighs 1/2, not 1/3, and [[]] weighs 1/4, not 1/6.
    let verlet = (1f64 / 36.0 + 1.0 / 144.0 + 1.0 / 144.0).sqrt();
    assert!((of("velocity-verlet").principal_error - verlet).abs() < 1e-15);
}

#[test]
fn stability_limits_of_other_families() {
    // The third and fourth Adams-Bashforth method hold an oscillation, the first two and the next two do not
    // (Durran 1991, Mon. Wea. Rev. 119, 702, for the first four).
    for (name, y) in [("ab1", 0.0), ("ab2", 0.0), ("ab3", 0.72), ("ab4", 0.43), ("ab5", 0.0), ("ab6", 0.0)] {
        assert!(close(of(name).imaginary_limit, y, 5e-3), "{name}: {:?}", of(name).imaginary_limit);
    }
    // Leapfrog: |Im| <= 1, nothing else.
    let leapfrog = of("nystrom2");
    assert_eq!(leapfrog.real_limit, Some(0.0));
    assert!(close(leapfrog.imaginary_limit, 1.0, 1e-14));
    // Euler and the trapezoid in PECE are Heun's method.
    let (pece, heun) = (of("heun-pece"), of("heun2"));
    assert!(close(pece.real_limit, heun.real_limit.unwrap(), 1e-14));
    assert_eq!(pece.imaginary_limit, heun.imaginary_limit);
    // The roots of rho - z sigma with the corrector's f at the prediction, found by another program.
    for (name, x) in [
        ("abm2-pece", 2.0),
        ("abm3-pece", 1.728784),
        ("abm4-pece", 1.284816),
        ("abm5-pece", 0.946917),
        ("abm2-pec", 0.5),
        ("abm3-pec", 0.285714),
        ("abm4-pec", 0.157895),
        ("abm5-pec", 0.085470),
    ] {
        assert!(close(of(name).real_limit, x, 1e-6), "{name}: {:?}", of(name).real_limit);
    }
    // h omega < 2 for every guise of Verlet. Forest-Ruth is three of its steps; the trace of their product
    // leaves [-2, 2] at 1.573401947.
    for name in
        ["verlet", "velocity-verlet", "verlet-kdk", "verlet-dkd", "symplectic-euler", "lobatto-iiia-iiib2"]
    {
        assert!(close(of(name).oscillation_limit, 2.0, 1e-14), "{name}");
    }
    assert!(close(of("forest-ruth4").oscillation_limit, 1.573401947, 1e-9));
}

#[test]
fn a_pair_is_as_stable_as_its_tables() {
    let (pair, explicit, implicit) = (of("kencarp5-imex"), of("ark548-erk"), of("kencarp5-esdirk"));
    assert!(close(pair.real_limit, explicit.real_limit.unwrap(), 1e-12));
    assert!(close(pair.imaginary_limit, explicit.imaginary_limit.unwrap(), 1e-12));
    assert_eq!((pair.a_stable, pair.l_stable), (implicit.a_stable, implicit.l_stable));
    assert_eq!(pair.stiffly_accurate, implicit.stiffly_accurate);
}

/// Hairer, Norsett, Wanner I, II.4: the estimate of Fehlberg's 7(8) is zero for y' = f(t).
#[test]
fn blind_estimates_are_found() {
    let blind = |name: &str| of(name).blind.clone();
    assert_eq!(blind("rkf87"), [true]);
    assert_eq!(blind("rkf45"), [false]);
    assert_eq!(blind("dop853"), [false, false]);
    let all: Vec<_> = ALL.iter().filter(|(_, p)| p.blind.contains(&true)).map(|(name, _)| *name).collect();
    assert_eq!(all, ["rkf87", "rodas5"]);
}

#[test]
fn a_correct_table_can_lose_digits_in_f64() {
    let verner = of("verner65-efficient");
    assert!((3e-11..4e-11).contains(&verner.residual_f64) && verner.sum_b > 350.0);
    let robust = of("verner65-robust");
    assert!(robust.residual_f64 < 1e-15 && robust.sum_b < 3.0);
}

#[test]
fn conditions_of_symplectic_nystrom_methods() {
    let text = |y: &str| {
        format!(
            "name = \"n\"\norder = 2\ncite = \"c\"\nnystrom = '''\n0 |\n1 | 1/2\n--+--\ny | {y}\nv | 1/2 1/2\n'''\n"
        )
    };
    let symplectic = |y: &str| Tableau::parse(&text(y)).unwrap().properties().symplectic;
    assert_eq!(symplectic("1/2 0"), Some(true));
    assert_eq!(symplectic("1/3 1/6"), Some(false));
}

/// One digit says next to nothing of a table, but nothing may hang or panic on it.
#[test]
fn coarse_decimals_have_properties() {
    let text =
        "name = \"n\"\norder = 1\ndigits = 1\ncite = \"c\"\ntableau = '''\n0.5 | 0.5\n--+--\n | 1.01\n'''\n";
    let p = Tableau::parse(text).unwrap().properties();
    assert_eq!((p.kind, p.order), (Stages::Diagonal, 1));
}

#[test]
fn sizes_of_weights_and_counts_of_evaluations() {
    let dp54 = of("dp54");
    assert!(close(Some(dp54.max_a), 25360.0 / 2187.0, 1e-15));
    let b = [35.0 / 384.0, 500.0 / 1113.0, 125.0 / 192.0, 2187.0 / 6784.0, 11.0 / 84.0];
    assert!(close(Some(dp54.sum_b), b.iter().sum(), 1e-15));
    // Adams-Bashforth 2: 3/2 and -1/2. Velocity Verlet: the weights of y'.
    assert_eq!((of("ab2").sum_b, of("ab2").max_a, of("velocity-verlet").sum_b), (2.0, 0.0, 1.0));
    // The second stage of Rodas 3 is evaluated where the first one is.
    assert_eq!((of("rodas3").stages, of("rodas3").evaluations), (4, 3));
    assert_eq!((dp54.stages, dp54.evaluations, dp54.fsal), (7, 6, true));
}

/// Kennedy and Carpenter's kencarp5 and esdirk437l2sa say next to nothing of y' = -y: R - Rhat is 1.8e-8 z^5 -
/// 1.2e-5 z^6 for the one, 2.1e-6 z^4 + 3.8e-5 z^5 for the other, R - exp being 1.1e-4 z^6 and 1.8e-4 z^5. With the
/// force t^3 the implicit table of kencarp4-7 errs 1.5e-3 at z = -1 and 6.2e-3 at -3, of which its estimate sees
/// 5.6e-5 and 4.0e-5 (from A, b and bhat by an independent program).
#[test]
fn an_estimate_that_says_too_little_is_found() {
    let all: Vec<_> =
        ALL.iter().filter(|(_, p)| p.estimate_misses > Some(2.0)).map(|(name, _)| *name).collect();
    let kencarp3 = ["kencarp3-esdirk", "kencarp3-imex"];
    let others = ["esdirk437l2sa", "kencarp4-7-imex", "kencarp5-esdirk", "kencarp5-imex"];
    assert_eq!(all.len(), 6, "{all:?}");
    assert!(kencarp3.iter().chain(&others).all(|name| all.contains(name)), "{all:?}");
    assert!(close(of("kencarp5-esdirk").estimate_misses, 9.3, 0.1));
    assert!(of("kencarp4-7-imex").estimate_misses > Some(50.0));
}
