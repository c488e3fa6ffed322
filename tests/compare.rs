//! Speed against error: the rows are complete and true, failures stay, and the fastest is read off right.

use kutta::compare::{Comparison, Outcome, Reference, Row, Unfit, cost_at, fastest_at, ranking_at};
use kutta::methods::{self, Ab4, Bs54, Dop853, Dp54, Rk4, Tsit54, VelocityVerlet, Yoshida6};
use kutta::{Auto, Loaded, OutOfDomain, System};
use std::cell::RefCell;
use std::time::Duration;

const BRIEF: Duration = Duration::from_millis(20);

/// x'' = -x as a system; it starts at (1, 0) and is at (cos t, -sin t).
fn swing(_t: f64, y: &[f64; 2], dy: &mut [f64; 2]) {
    *dy = [y[1], -y[0]];
}

fn swings<'w>() -> Comparison<'w, [f64; 2], impl System<[f64; 2]> + Clone> {
    Comparison::new("swing", swing, [1.0, 0.0], 0.0..5.0).exact(|t: f64| [t.cos(), -t.sin()]).budget(BRIEF)
}

fn of<'o>(outcome: &'o Outcome, method: &str) -> Vec<&'o Row> {
    outcome.rows.iter().filter(|row| row.method == method).collect()
}

#[test]
fn every_run_is_a_whole_row() {
    let outcome =
        swings().method(Dp54).fixed(Rk4).tolerances(&[1e-8, 1e-4]).steps(&[0.5, 0.125]).run().unwrap();
    assert_eq!(outcome.reference, Reference::Exact);
    let settings: Vec<_> = outcome.rows.iter().map(|row| (row.method.as_str(), row.tolerance)).collect();
    assert_eq!(settings, [("dp54", 1e-4), ("dp54", 1e-8), ("rk4", 0.5), ("rk4", 0.125)], "loose to tight");
    for row in &outcome.rows {
        assert_eq!((row.problem.as_str(), &row.failure), ("swing", &None));
        let (error, max) = (row.error.unwrap(), row.max_error.unwrap());
        assert!(0.0 < error && error <= max && max < 1e-2, "{row:?}");
        let (min, median) = (row.seconds_min.unwrap(), row.seconds_median.unwrap());
        assert!(0.0 < min && min <= median && median < 0.1, "{row:?}");
        assert!(row.accepted > 0 && row.evaluations >= 4 * row.accepted, "{row:?}");
    }
    assert_eq!(outcome.rows[2].accepted, 10);
    assert_eq!(outcome.rows[2].evaluations, 40);
    // What a plain run leaves: 5/0.5 steps of RK4 on y' = i y, whose factor is known.
    let (re, im) = (1.0 - 0.125 + 0.0625 / 24.0, 0.5 - 0.125 / 6.0);
    let (size, angle) = (f64::hypot(re, im).powi(10), 10.0 * f64::atan2(im, re));
    let parts = [(size * angle.cos(), 5f64.cos()), (-size * angle.sin(), -5f64.sin())];
    let by_hand = parts.iter().map(|(y, exact)| (y - exact).abs() / (exact.abs() + 1.0)).fold(0.0, f64::max);
    assert!((outcome.rows[2].error.unwrap() / by_hand - 1.0).abs() < 1e-9);
}

/// The choice begins with tsit54, which may stand beside it.
#[test]
fn the_choice_of_the_library_has_its_own_name() {
    let outcome = swings().method(Auto::new()).method(Tsit54).tolerances(&[1e-4]).run().unwrap();
    let names: Vec<_> = outcome.rows.iter().map(|row| row.method.as_str()).collect();
    assert_eq!(names, ["auto", "tsit54"]);
    // Nothing is stiff here.
    assert_eq!(outcome.rows[0].error, outcome.rows[1].error);
}

#[test]
fn errors_fall_with_tolerances_and_steps() {
    let tolerances = [1e-3, 1e-5, 1e-7, 1e-9];
    let all = swings().method(Dp54).method(Bs54).method(Dop853).fixed(Rk4).fixed(Ab4);
    let outcome = all.tolerances(&tolerances).steps(&[0.1, 0.05, 0.025, 0.0125]).run().unwrap();
    for method in ["dp54", "bs54", "dop853", "rk4", "ab4"] {
        for pair in of(&outcome, method).windows(2) {
            assert!(pair[1].error.unwrap() < 0.5 * pair[0].error.unwrap(), "{method}: {pair:?}");
            assert!(pair[1].evaluations > pair[0].evaluations, "{method}: {pair:?}");
        }
        for row in of(&outcome, method) {
            // Between its steps a method is about as good as at them.
            assert!(row.max_error.unwrap() < 30.0 * row.error.unwrap().max(row.tolerance), "{row:?}");
        }
    }
}

#[test]
fn steps_are_halved_until_nothing_is_gained() {
    let outcome = swings().fixed(Rk4).run().unwrap();
    let rows = of(&outcome, "rk4");
    for (k, row) in rows.iter().enumerate() {
        assert_eq!(row.tolerance, 5.0 / 2f64.powi(4 + k as i32));
    }
    let best = rows.iter().filter_map(|row| row.error).fold(1.0, f64::min);
    assert!(best < 1e-13 && rows.len() < 16, "{} runs to {best:e}", rows.len());
}

#[test]
fn failures_are_rows() {
    // 1/(1 - t) ends at t = 1.
    let blows_up = |_t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = y[0] * y[0];
    let comparison = Comparison::new("pole", blows_up, [1.0], 0.0..2.0).reference(&[-1.0]).budget(BRIEF);
    let outcome = comparison.method(Tsit54).fixed(Rk4).tolerances(&[1e-4, 1e-6]).steps(&[0.1]).run().unwrap();
    assert_eq!(outcome.rows.len(), 3);
    for (row, what) in outcome.rows.iter().zip(["stopped at t = 1", "stopped at t = 1", "unstable"]) {
        assert!(row.failure.as_ref().unwrap().contains(what), "{row:?}");
        assert_eq!((row.error, row.max_error, row.seconds_min, row.seconds_median), (None, None, None, None));
        assert!(row.evaluations > 0, "{row:?}");
    }
    assert_eq!(fastest_at(&outcome.rows, "pole", 1.0), None);

    // A method that does not fit the problem fails as well, and the others go on.
    let verlet = Loaded::parse("verlet", methods::find("verlet").unwrap().text).unwrap();
    let outcome = swings().fixed(verlet).fixed(Rk4).steps(&[0.5]).run().unwrap();
    assert!(outcome.rows[0].failure.as_ref().unwrap().contains("solve_second"), "{:?}", outcome.rows[0]);
    assert_eq!(outcome.rows[1].failure, None);
}

#[test]
fn slow_runs_are_given_up() {
    let slow = |_t: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
        std::thread::sleep(Duration::from_micros(50));
        dy[0] = -y[0];
    };
    let comparison = Comparison::new("slow", slow, [1.0], 0.0..10.0).exact(|t: f64| [(-t).exp()]);
    let comparison = comparison.budget(BRIEF).longest(Duration::from_millis(60));
    let outcome = comparison.method(Dp54).fixed(Rk4).tolerances(&[1e-1, 1e-13, 1e-14]).run().unwrap();
    let dp54 = of(&outcome, "dp54");
    assert_eq!(dp54[0].failure, None, "{:?}", dp54[0]);
    assert!(dp54[1].failure.as_ref().unwrap().contains("longer than 0.06 s"), "{:?}", dp54[1]);
    assert!(dp54[2].failure.as_ref().unwrap().contains("not run"), "{:?}", dp54[2]);
    let rk4 = of(&outcome, "rk4");
    assert!(rk4.last().unwrap().failure.is_some() && rk4.len() < 8, "a sweep ends where it gets slow");
}

#[test]
fn a_read_method_is_the_compiled_one() {
    let read = |name| Loaded::parse("read", methods::find(name).unwrap().text).unwrap();
    let steps = [0.5, 0.1, 0.01];
    for (name, compiled) in [
        ("rk4", swings().fixed(Rk4).fixed(read("rk4"))),
        ("ab4", swings().fixed(Ab4).fixed(read("ab4"))),
        ("dop853", swings().fixed(Dop853).fixed(read("dop853"))),
    ] {
        let outcome = compiled.steps(&steps).run().unwrap();
        let (compiled, read) = (of(&outcome, name), of(&outcome, "read"));
        assert_eq!(compiled.len(), 3);
        for (a, b) in compiled.iter().zip(read) {
            assert_eq!((a.error, a.evaluations, a.accepted), (b.error, b.evaluations, b.accepted), "{name}");
        }
    }
}

#[test]
fn second_order_methods_join_those_of_the_system() {
    let pull = |_t: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -x[0];
    let second = || Comparison::second_order("swing", pull, [1.0], [0.0], 0.0..5.0).budget(BRIEF);
    let joined = swings().method(Dp54).and(second().fixed(Yoshida6).fixed(VelocityVerlet));
    let outcome = joined.tolerances(&[1e-8]).steps(&[0.05]).run().unwrap();
    let errors: Vec<_> = outcome.rows.iter().map(|row| row.error.unwrap()).collect();
    assert!(errors[0] < 1e-6 && errors[1] < 1e-6 && errors[2] < 1e-2, "{errors:?}");
    assert!(errors[2] > 1e-5, "a method of order two: {errors:?}");

    // Alone, it finds its own reference.
    let outcome = second().fixed(Yoshida6).steps(&[0.05]).run().unwrap();
    assert!((outcome.rows[0].error.unwrap() - errors[1]).abs() < 1e-13);
    assert!(matches!(outcome.reference, Reference::Run { .. }));
}

#[test]
fn a_tight_run_stands_in_for_a_reference() {
    let comparison = || Comparison::new("swing", swing, [1.0, 0.0], 0.0..5.0).method(Tsit54).budget(BRIEF);
    let found = comparison().tolerances(&[1e-6]).run().unwrap();
    let known = comparison().reference(&[5f64.cos(), -5f64.sin()]).tolerances(&[1e-6]).run().unwrap();
    assert_eq!(known.reference, Reference::Given);
    let Reference::Run { rtol, spread, .. } = found.reference else { panic!("{:?}", found.reference) };
    assert!(rtol < 1e-12 && spread < 1e-11);
    let (found, known) = (&found.rows[0], &known.rows[0]);
    assert!((found.error.unwrap() - known.error.unwrap()).abs() < 1e-12);
    assert_eq!(found.max_error, known.max_error, "both along the same tight run");
}

#[test]
fn a_system_with_scratch_and_a_domain_is_compared() {
    let scratch = RefCell::new(vec![0.0; 2]);
    let f = |_t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        let mut root = scratch.borrow_mut();
        root[0] = if y[0] >= 0.0 { y[0].sqrt() } else { return Err(OutOfDomain) };
        dy[0] = -root[0];
        Ok(())
    };
    // sqrt(y) falls by t/2.
    let exact = |t: f64| [(1.0 - 0.5 * t).powi(2)];
    let comparison = Comparison::new("drain", f, vec![1.0], 0.0..1.5).exact(exact).budget(BRIEF);
    let outcome = comparison.method(Dp54).tolerances(&[1e-7]).run().unwrap();
    assert!(outcome.rows[0].error.unwrap() < 1e-6, "{:?}", outcome.rows[0]);
}

#[test]
fn what_makes_no_sense_is_refused() {
    assert!(matches!(swings().run(), Err(Unfit::NoMethod)));
    for x in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        for comparison in [swings().tolerances(&[1e-3, x]), swings().steps(&[x]), swings().scale(x)] {
            let Err(Unfit::NotPositive(found)) = comparison.method(Dp54).run() else { panic!("{x} passes") };
            assert_eq!(found.to_bits(), x.to_bits());
        }
    }
    let unfit = swings().reference(&[1.0]).method(Dp54).run().unwrap_err();
    assert_eq!(unfit.to_string(), "the reference has 1 components: the state has 2");
    let unfit = swings().exact(|_| [1.0; 3]).method(Dp54).run().unwrap_err();
    assert_eq!(unfit, Unfit::Length { given: 3, needed: 2 });
    let nowhere = |_t: f64, _y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = f64::NAN;
    let unfit = Comparison::new("nowhere", nowhere, [1.0], 0.0..1.0).method(Dp54).run().unwrap_err();
    assert!(unfit.to_string().contains("give a reference"), "{unfit}");
}

fn row(method: &str, error: f64, seconds: f64, evaluations: u64) -> Row {
    Row {
        problem: "p".to_string(),
        method: method.to_string(),
        tolerance: error,
        error: Some(error),
        max_error: None,
        seconds_min: Some(seconds),
        seconds_median: Some(2.0 * seconds),
        evaluations,
        jacobians: 0,
        factorizations: 0,
        accepted: 1,
        rejected: 0,
        failure: None,
    }
}

#[test]
fn the_fastest_is_read_off_the_rows() {
    let failed =
        Row { error: None, seconds_min: None, failure: Some("unstable".into()), ..row("a", 1.0, 1.0, 1) };
    let rows = [
        failed,
        row("a", 1e-2, 1e-5, 100),
        row("a", 1e-4, 1e-4, 1000),
        // Slower and worse than the next: of no use, so it must not bend the curve.
        row("a", 2e-5, 5e-3, 9999),
        row("a", 1e-6, 1e-3, 10_000),
        row("b", 1e-8, 1e-4, 500),
        Row { problem: "q".to_string(), ..row("c", 1e-9, 1e-9, 1) },
        // Chosen in its course: the loose run is explicit to its end but for four Jacobians.
        Row { problem: "s".to_string(), jacobians: 4, ..row("d", 1e-2, 1e-5, 100) },
        Row { problem: "s".to_string(), jacobians: 16, factorizations: 9, ..row("d", 1e-4, 1e-4, 1000) },
    ];
    let near = |x: f64, y: f64| (x / y - 1.0).abs() < 1e-12;

    let cost = cost_at(&rows, "p", "a", 1e-4).unwrap();
    assert!(near(cost.seconds, 1e-4) && near(cost.evaluations, 1000.0), "a run itself: {cost:?}");
    let cost = cost_at(&rows, "p", "a", 1e-3).unwrap();
    assert!(near(cost.seconds, 1e-4 / 10f64.sqrt()), "half way in logarithms: {cost:?}");
    let cost = cost_at(&rows, "p", "a", 1e-5).unwrap();
    assert!(near(cost.seconds, 1e-3 / 10f64.sqrt()), "{cost:?}");
    let cost = cost_at(&rows, "p", "a", 0.5).unwrap();
    assert!(near(cost.seconds, 1e-5), "the loosest run is better already: {cost:?}");
    assert_eq!(cost_at(&rows, "p", "a", 1e-7), None);
    let cost = cost_at(&rows, "s", "d", 1e-3).unwrap();
    assert!(near(cost.jacobians, 8.0) && cost.factorizations == 9.0, "{cost:?}");

    let names = |error| ranking_at(&rows, "p", error).iter().map(|cost| cost.method).collect::<Vec<_>>();
    assert_eq!(names(1e-3), ["a", "b"]);
    assert_eq!(names(1e-5), ["b", "a"]);
    assert_eq!(names(1e-7), ["b"]);
    assert_eq!(fastest_at(&rows, "p", 1e-3).unwrap().method, "a");
    assert_eq!(fastest_at(&rows, "p", 1e-9), None);
    assert_eq!(fastest_at(&rows, "nothing", 1e-3), None);
}

#[cfg(feature = "cli")]
mod command {
    use serde_json::Value;
    use std::path::{Path, PathBuf};
    use std::process::{Command, Output};

    /// A folder of this test alone, gone when it ends.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("kutta-compare-{}-{name}", std::process::id()));
            std::fs::create_dir_all(&path).unwrap();
            Self(path)
        }
        fn file(&self, name: &str, text: &str) -> String {
            let path = self.0.join(name);
            std::fs::write(&path, text).unwrap();
            path.to_str().unwrap().to_string()
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    fn compare(out: &Path, args: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_kutta"));
        command.arg("compare").arg("--out").arg(out).args(args.split_whitespace()).output().unwrap()
    }

    fn text(bytes: &[u8]) -> &str {
        std::str::from_utf8(bytes).unwrap()
    }

    const KEYS: [&str; 13] = [
        "problem",
        "method",
        "tolerance",
        "error",
        "max_error",
        "seconds_min",
        "seconds_median",
        "evaluations",
        "jacobians",
        "factorizations",
        "accepted",
        "rejected",
        "failure",
    ];

    #[test]
    fn it_writes_plots_and_rows_and_names_the_fastest() {
        let scratch = Scratch::new("writes");
        let out = scratch.0.join("new").join("folder");
        let ran = compare(&out, "--problem rigid-body --methods dp54,rk4 --tolerances 1e-2,1e-4,1e-6");
        assert!(ran.status.success() && ran.stderr.is_empty(), "{}", text(&ran.stderr));
        let table = text(&ran.stdout);
        assert!(table.contains("rigid-body") && table.contains("1e-12") && table.contains("dp54"), "{table}");
        assert!(!table.contains("interpreted"), "both are compiled: {table}");
        let mut files: Vec<_> = std::fs::read_dir(&out).unwrap().map(|f| f.unwrap().file_name()).collect();
        files.sort();
        assert_eq!(files, ["compare.json", "rigid-body.png", "rigid-body.svg"], "nothing else is left");
        assert!(std::fs::read(out.join("rigid-body.png")).unwrap().starts_with(b"\x89PNG"));
        let svg = std::fs::read_to_string(out.join("rigid-body.svg")).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && svg.contains("dp54"));
        let rows: Value = serde_json::from_slice(&std::fs::read(out.join("compare.json")).unwrap()).unwrap();
        for row in rows.as_array().unwrap() {
            let mut keys: Vec<_> = row.as_object().unwrap().keys().map(String::as_str).collect();
            let mut wanted = KEYS.to_vec();
            keys.sort_unstable();
            wanted.sort_unstable();
            assert_eq!(keys, wanted);
        }
    }

    #[test]
    fn a_table_of_ones_own_joins() {
        let scratch = Scratch::new("joins");
        let mine = scratch.file("mine.toml", include_str!("../tableaus/explicit/rk4.toml"));
        let args = format!("--problem rigid-body,kepler-e06 --methods rk4,verlet --table {mine}");
        let ran = compare(&scratch.0, &args);
        assert!(ran.status.success(), "{}", text(&ran.stderr));
        let table = text(&ran.stdout);
        assert!(table.contains("interpreted") && table.contains("mine"), "{table}");
        assert!(table.contains("f(t, y) only: verlet"), "{table}");
        let rows: Value =
            serde_json::from_slice(&std::fs::read(scratch.0.join("compare.json")).unwrap()).unwrap();
        let errors = |problem: &str, method: &str| -> Vec<f64> {
            let rows = rows.as_array().unwrap().iter();
            let of = rows.filter(|row| row["problem"] == problem && row["method"] == method);
            of.filter_map(|row| row["error"].as_f64()).take(8).collect()
        };
        assert_eq!(errors("rigid-body", "mine"), errors("rigid-body", "rk4"));
        assert!(errors("rigid-body", "mine").len() == 8 && errors("rigid-body", "verlet").is_empty());
        assert!(!errors("kepler-e06", "verlet").is_empty());
    }

    #[test]
    fn bad_input_gets_one_line_and_writes_nothing() {
        let scratch = Scratch::new("refuses");
        let wrong = scratch.file("wrong.toml", "order = 1\n");
        let same = scratch.file("dp54.toml", include_str!("../tableaus/explicit/dp54.toml"));
        let file = scratch.file("file", "");
        let out = scratch.0.join("out");
        let refused = [
            ("--problem lorenz".to_string(), "there is no problem"),
            ("--methods rk5".to_string(), "there is no method"),
            ("--problem lorenz63 --methods verlet".to_string(), "choose a problem of that kind"),
            ("--tolerances 0".to_string(), "must be a positive number"),
            ("--tolerances 1e-3,-1e-6".to_string(), "must be a positive number"),
            ("--tolerances NaN".to_string(), "must be a positive number"),
            ("--tolerances tight".to_string(), "not a number"),
            (format!("--table {wrong}"), "wrong.toml"),
            (format!("--table {same}"), "rename the file"),
            ("--table nowhere.toml".to_string(), "nowhere.toml"),
        ];
        let check = |out: &Path, args: &str, what: &str| {
            let ran = compare(out, args);
            assert_eq!(ran.status.code(), Some(2), "{args}: {}", text(&ran.stderr));
            let line = text(&ran.stderr).strip_suffix('\n').unwrap();
            assert!(line.contains(what) && !line.contains('\n') && ran.stdout.is_empty(), "{args}: {line}");
        };
        for (args, what) in refused {
            check(&out, &args, what);
            assert!(!out.exists(), "{args} made the folder");
        }
        check(&Path::new(&file).join("out"), "", "choose a folder with --out");
    }
}
