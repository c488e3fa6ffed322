//! The commands `hard` and `stability`: what they print and write, and one clear line for every bad input.
#![cfg(feature = "cli")]

mod common;

use common::{Folder, complaint, json, keys, printed};
use kutta::compare::hard::{PROMISED, TOLERANCES, cases};

/// One component and a method that takes few steps: runs that take no time.
const CHEAP: [&str; 5] = ["hard", "--method", "rodas5p", "--problem", "curtiss-hirschfelder"];

#[test]
fn hard_gives_a_row_for_every_tolerance() {
    let rows = json(&[&CHEAP[..], &["--json"]].concat());
    let rows = rows.as_array().unwrap();
    let tolerances: Vec<_> = rows.iter().map(|row| row["tolerance"].as_f64().unwrap()).collect();
    assert_eq!(tolerances, TOLERANCES);
    for row in rows {
        let all = ["accepted", "allowed", "error", "evaluations", "factorizations", "jacobians", "method"];
        assert_eq!(keys(row), [&all[..], &["problem", "reason", "stopped", "tolerance"]].concat(), "{row}");
        assert_eq!((&row["method"], &row["problem"]), (&"rodas5p".into(), &"curtiss-hirschfelder".into()));
        assert!(row["allowed"].as_f64() >= Some(PROMISED), "{row}");
        // Steps too many for the time end the ladder: then the row says so.
        let Some(error) = row["error"].as_f64() else {
            assert!(row["stopped"].as_str().unwrap().contains("not run") && row["accepted"] == 0, "{row}");
            continue;
        };
        let allowed = row["allowed"].as_f64().unwrap() * row["tolerance"].as_f64().unwrap();
        assert!(row["stopped"].is_null() && error <= allowed, "{row}");
        assert!(row["evaluations"].as_u64() > row["accepted"].as_u64(), "{row}");
        assert!(row["jacobians"].as_u64() > Some(0) && row["factorizations"].as_u64() > Some(0), "{row}");
    }
    // The first three take some hundred steps.
    assert!(rows[..3].iter().all(|row| row["error"].is_number()), "{rows:?}");
}

#[test]
fn hard_prints_a_table() {
    let table = printed(&CHEAP);
    let lines: Vec<_> = table.lines().collect();
    let heading = lines.iter().find(|line| line.contains("1e-11")).expect("tolerances");
    assert!(heading.contains("rodas5p") && heading.contains("1e-3"), "{table}");
    let row = lines.iter().find(|line| line.contains("curtiss-hirschfelder")).expect("a row");
    assert_eq!(row.split_whitespace().filter(|cell| cell.contains('.')).count(), 5, "{table}");
    assert!(table.contains("rodas5p: 5 of 5 runs that ended pass") && table.contains("0 stopped"), "{table}");
    // A comma parts two names.
    assert!(cases().iter().all(|case| !case.name.contains(',')));
}

#[test]
fn hard_and_compare_take_the_choice_of_the_library() {
    let rows =
        json(&["hard", "--method", "auto,bdf", "--problem", "robertson-40-algebraic,heat1d", "--json"]);
    let rows = rows.as_array().unwrap();
    let of = |method: &str, problem: &str| {
        let this = |row: &&serde_json::Value| row["method"] == method && row["problem"] == problem;
        rows.iter().filter(this).collect::<Vec<_>>()
    };
    for (method, problem) in [("auto", "robertson-40-algebraic"), ("auto", "heat1d"), ("bdf", "heat1d")] {
        let first = of(method, problem)[0];
        let error = first["error"].as_f64().unwrap_or_else(|| panic!("{first}"));
        assert!(error < 1e-3 * PROMISED && first["factorizations"].as_u64() > Some(0), "{first}");
    }
    assert_eq!(rows.len(), 4 * TOLERANCES.len());
    // On a problem that is compiled with it, beside one that is not.
    let out = Folder::new("auto");
    let out = out.path("plots");
    for problem in ["robertson-40", "lotka-volterra"] {
        let args = ["compare", "--problem", problem, "--methods", "auto,rodas4", "--tolerances", "1e-3,1e-5"];
        let rows = json(&[&args[..], &["--out", &out, "--json"]].concat());
        let named: Vec<_> = rows.as_array().unwrap().iter().map(|row| row["method"].clone()).collect();
        assert_eq!(named, ["auto", "auto", "rodas4", "rodas4"]);
        for row in rows.as_array().unwrap() {
            assert!(row["error"].as_f64() < Some(0.1) && row["failure"].is_null(), "{row}");
            let stiff = problem == "robertson-40" || row["method"] == "rodas4";
            assert_eq!(row["factorizations"].as_u64() > Some(0), stiff, "{row}");
        }
    }
}

#[test]
fn hard_refuses_in_one_line() {
    let wrong = Folder::new("hard");
    let file = wrong.file("wrong.toml", b"order = 1\n");
    for (args, says) in [
        (&["--problem", "robertson"][..], "robertson-40"),
        (&["--problem", "lorenz63"], "the hard problems are"),
        (&["--method", "rodas5q"], "did you mean rodas"),
        (&["--method", "dp54"], "its stages are explicit or it has no error estimate"),
        (&["--method", "adams"], "or it solves them without a matrix"),
        (&["--method", "gauss2", "--problem", "xyzzy"], "the hard problems are"),
        (&["--method", "backward-euler"], "backward-euler is not for stiff problems with adaptive steps"),
        (&["--method", "velocity-verlet"], "is not for stiff problems"),
        (&["--method", &file], "wrong.toml"),
        (&["--method", "nowhere.toml"], "nowhere.toml cannot be read"),
        (&["--all", "--method", "rodas4"], "cannot be used with"),
        (&["--tolerance", "1e-3"], "--tolerance"),
    ] {
        let line = complaint(&[&["hard"], args].concat(), 2);
        assert!(line.contains(says), "{args:?}: {line:?} does not say {says:?}");
    }
}

#[test]
fn stability_writes_pictures_and_prints_limits() {
    let folder = Folder::new("stability");
    let mine = folder.file("mine.toml", include_bytes!("../tableaus/explicit/bs32.toml"));
    let out = folder.path("new");
    for (method, name, says) in [
        // By hand: the real zero of 2 + z + z^2/2 + z^3/6.
        (&mine[..], "mine", &["-2.5127", "step control"][..]),
        // x'' = -x in steps of 2 at most.
        ("velocity-verlet", "velocity-verlet", &["h omega", "up to 2,"]),
    ] {
        let shown = printed(&["stability", method, "--out", &out]);
        assert!(says.iter().all(|says| shown.contains(says)), "{name}: {shown}");
        let last = format!("{name}-stability.svg and {name}-stability.png are in {out}\n");
        assert!(shown.ends_with(&last), "{shown}");
        let (svg, png) = (format!("{out}/{name}-stability.svg"), format!("{out}/{name}-stability.png"));
        let svg = std::fs::read_to_string(svg).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{name}");
        assert!(svg.contains(name) && std::fs::read(png).unwrap().starts_with(b"\x89PNG"), "{name}");
    }
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 4, "nothing else is left");
}

#[test]
fn stability_refuses_in_one_line() {
    let folder = Folder::new("regions");
    let wrong = folder.file("wrong.toml", b"tableu = 1\n");
    let (before, under) = (folder.names(), format!("{wrong}/out"));
    for (args, says) in [
        (&["dp45"][..], "did you mean dp54?"),
        (&[], "<NAME>"),
        (&[&wrong], ":1: unknown key"),
        (&["no-such.toml"], "no-such.toml cannot be read"),
        (&["sobel3"], "there is no method"),
        (&["dp54", "--out", &under], "choose a folder with --out"),
        (&["dp54", "--json"], "--json"),
    ] {
        let line = complaint(&[&["stability"], args].concat(), 2);
        assert!(line.contains(says), "{args:?}: {line:?} does not say {says:?}");
    }
    assert_eq!(folder.names(), before, "what is refused writes nothing");
}
