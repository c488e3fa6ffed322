//! The binary: its JSON, its exit codes, and one clear line for every bad input.
#![cfg(feature = "cli")]

mod common;

use common::{Scratch, complaint, json, keys, printed, text};
use std::io::Read;
use std::process::{Command, Stdio};

const MINE: &[u8] = b"name = \"Mine\"\norder = 2\ncite = \"nowhere\"\n\
    tableau = '''\n0 |\n1/2 | 1/2\n--+--\n| 0 1\n'''\n";

#[test]
fn list_gives_every_method() {
    let list = json(&["list", "--json"]);
    let list = list.as_array().unwrap();
    assert_eq!(list.len(), kutta::methods::all().len());
    for item in list {
        let all = ["dense", "embedded", "family", "name", "order", "stages", "steppable", "title"];
        assert_eq!(keys(item), all, "{item}");
        assert!(item["name"].is_string() && item["title"].is_string() && item["family"].is_string());
        assert!(item["order"].as_u64() > Some(0) && item["stages"].as_u64() > Some(0), "{item}");
        assert!(item["embedded"].as_array().unwrap().iter().all(|order| order.as_u64() > Some(0)));
        assert!(item["dense"].is_null() || item["dense"].as_u64() > Some(0));
        assert!(item["steppable"].is_boolean());
    }
    let item = |name: &str| list.iter().find(|item| item["name"] == name).unwrap();
    assert_eq!(item("dop853")["embedded"], serde_json::json!([5, 3]));
    assert_eq!((&item("dop853")["dense"], &item("dop853")["stages"]), (&7.into(), &13.into()));
    assert_eq!(item("gauss2")["steppable"], true);
    assert_eq!(item("kencarp4-imex")["steppable"], true);
}

/// Every name stands in the table once, and its columns are aligned with their heading.
#[test]
fn list_is_a_table_by_family() {
    let list = printed(&["list"]);
    let lines: Vec<_> = list.lines().collect();
    for entry in kutta::methods::all() {
        let start = format!("  {} ", entry.name);
        assert_eq!(lines.iter().filter(|line| line.starts_with(&start)).count(), 1, "{}", entry.name);
    }
    let heading = lines.iter().find(|line| line.trim_start().starts_with("name")).unwrap();
    let order = heading.find("order").unwrap();
    let dp54 = lines.iter().find(|line| line.starts_with("  dp54 ")).unwrap();
    assert_eq!(&dp54[order..order + 5], "    5");
}

#[test]
fn show_gives_coefficients_as_printed_and_as_numbers() {
    let dp54 = json(&["show", "dp54", "--json"]);
    assert_eq!((dp54["name"].as_str(), dp54["order"].as_u64()), (Some("dp54"), Some(5)));
    assert_eq!(dp54["a"].as_array().unwrap().len(), 7);
    assert_eq!(dp54["a"][6][3], serde_json::json!({ "text": "125/192", "value": 125.0 / 192.0 }));
    assert_eq!(dp54["a"][0][0], serde_json::json!({ "text": "0", "value": 0.0 }));
    assert_eq!(dp54["b"][4]["text"], "-2187/6784");
    assert_eq!(dp54["bhat"][0][6]["value"], 1.0 / 40.0);
    assert_eq!(dp54["c"][4]["value"], 8.0 / 9.0);
    assert_eq!(dp54["dense_weights"].as_array().unwrap().len(), 7);
    let properties = &dp54["properties"];
    assert_eq!((&properties["fsal"], &properties["kind"]), (&true.into(), &"explicit".into()));
    assert!((properties["real_limit"].as_f64().unwrap() - 3.30656789263).abs() < 1e-10);
    assert_eq!(properties["blind"], serde_json::json!([false]));
    // What does not apply is absent; what has no bound is a text, as JSON has no infinity.
    assert_eq!(properties.get("oscillation_limit"), None);
    let bdf3 = &json(&["show", "bdf3", "--json"])["properties"];
    assert_eq!((&bdf3["real_limit"], &bdf3["evidence"]), (&"inf".into(), &"found".into()));
    assert!(bdf3["alpha_within"].as_f64() < Some(1e-6) && bdf3["stiff_order"]["order"] == 3, "{bdf3}");
    let rodas4 = &json(&["show", "rodas4", "--json"])["properties"];
    assert_eq!((&rodas4["l_stable"], &rodas4["evidence"]), (&true.into(), &"proven".into()));
    assert!(rodas4["alpha_within"].is_null(), "{rodas4}");
}

#[test]
fn show_has_rows_for_every_family() {
    for (name, rows) in [
        ("rk4", &["a", "b", "bhat", "c"][..]),
        ("kencarp3-imex", &["explicit", "implicit"]),
        ("lobatto-iiia-iiib2", &["position", "velocity"]),
        ("ros2", &["alpha", "b", "bhat", "gamma"]),
        ("rodas4", &["a", "c", "dense_weights", "gamma", "m", "mhat"]),
        ("bdf2", &["alpha", "beta"]),
        ("bdf", &["formulas"]),
        ("verlet", &["alpha", "beta"]),
        ("abm2-pece", &["corrector", "mode", "predictor"]),
        ("velocity-verlet", &["a", "c", "v", "y"]),
        ("forest-ruth4", &["steps"]),
    ] {
        let shown = json(&["show", name, "--json"]);
        let all = ["cite", "dense", "digits", "embedded", "family", "name", "note", "order", "properties"];
        let common = [&all[..], &["stages", "steppable", "title"]].concat();
        let own: Vec<_> = keys(&shown).into_iter().filter(|key| !common.contains(key)).collect();
        assert_eq!(own, rows, "{name}");
        assert!(rows.iter().all(|key| !shown[key].is_null()), "{name}");
    }
    let steps = json(&["show", "verlet-kdk", "--json"]);
    assert_eq!(steps["steps"][0], serde_json::json!({ "step": "kick", "text": "1/2", "value": 0.5 }));
    assert_eq!(json(&["show", "ab2", "--json"])["beta"][0]["value"], -0.5);
}

/// Rang, Angermann 2005 give ROS34PW2 as a W-method of order 3, Verwer et al. 1999 ROS2 as one of order 2.
#[test]
fn show_tells_w_methods_from_others() {
    let shown = printed(&["show", "ros34pw2"]);
    assert!(shown.contains("order 3, embedded 2, with any matrix in place of the Jacobian"), "{shown}");
    let shown = printed(&["show", "rodas4"]);
    assert!(shown.contains("no, it needs the Jacobian: order 1"), "{shown}");
    assert_eq!(json(&["show", "ros2", "--json"])["properties"]["w_order"], 2);
    assert_eq!(json(&["show", "rk4", "--json"])["properties"].get("w_order"), None);
}

#[test]
fn show_prints_every_method() {
    for entry in kutta::methods::all() {
        let shown = printed(&["show", entry.name]);
        let tableau = entry.tableau();
        assert!(shown.starts_with(&format!("{}: {}\n", entry.name, tableau.title)), "{}", entry.name);
        assert!(shown.contains(tableau.cite) && shown.contains("local error"), "{}", entry.name);
    }
    for (name, says) in [
        ("rodas4", "A-stable and L-stable (proven)\n"),
        ("gauss3", "A-stable (proven); |R| = 1 at infinity\n"),
        (
            "bdf3",
            "A(alpha)-stable for alpha up to 86.03 degrees (found to 1e-9 degrees); |R| = 0 at infinity\n",
        ),
        ("am3", "in no sector about the negative real axis (proven)\n"),
        ("bdf4", "the error goes like h^4 / |lambda| (Prothero, Robinson)\n"),
        ("bdf", "h^2 / |lambda| on stiff problems\n"),
    ] {
        let shown = printed(&["show", name]);
        assert!(shown.contains(says), "{name}: {shown}");
    }
    let rk4 = printed(&["show", "rk4"]);
    assert!(rk4.contains("1/2 │ 0    1/2\n"), "{rk4}");
    assert!(printed(&["show", "verner76"]).lines().all(|line| line.chars().count() < 200));
}

#[test]
fn files_are_shown_checked_and_solved_with() {
    let mine = Scratch::new("mine.toml", MINE);
    let shown = json(&["show", mine.path(), "--json"]);
    assert_eq!((&shown["title"], &shown["order"]), (&"Mine".into(), &2.into()));
    let checked = printed(&["check", mine.path()]);
    assert!(checked.contains("Mine") && checked.contains("stage order"), "{checked}");
    let solved =
        json(&["solve", "--problem", "exponential-decay", "--method", mine.path(), "--h", "0.01", "--json"]);
    assert!(solved["error"].as_f64().unwrap() < 1e-3);
}

#[test]
fn check_says_what_the_compiler_says() {
    let wrong = text(MINE).replace("| 0 1", "| 0 1.001");
    let file = Scratch::new("wrong.toml", wrong.as_bytes());
    let line = complaint(&["check", file.path()], 1);
    assert_eq!(line, format!("{}: the order 1 condition of the tree [] is off by 1e-3", file.path()));
    let file = Scratch::new("letter.toml", text(MINE).replace("| 0 1", "| 0 l").as_bytes());
    assert_eq!(complaint(&["check", file.path()], 1), format!("{}:8: \"l\" is not a number", file.path()));
    // Beyond order 8, where the compiler stops.
    let ten = include_str!("../tableaus/implicit/gauss5.toml");
    let file = Scratch::new("ten.toml", ten.replace("order   = 10", "order   = 11").as_bytes());
    assert!(complaint(&["check", file.path()], 1).contains("the order 11 condition of the tree"));
    assert!(complaint(&["check", "no-such-file.toml"], 2).contains("no-such-file.toml"));
}

#[test]
fn solve_reports_state_error_and_counts() {
    let solved = json(&["solve", "--problem", "lorenz63", "--method", "dop853", "--rtol", "1e-10", "--json"]);
    assert_eq!(keys(&solved), ["error", "method", "problem", "stats", "t", "y"]);
    assert_eq!(keys(&solved["stats"]), ["accepted", "evaluations", "rejected"]);
    assert_eq!((&solved["problem"], &solved["method"]), (&"lorenz63".into(), &"dop853".into()));
    assert_eq!((solved["t"].as_f64(), solved["y"].as_array().unwrap().len()), (Some(10.0), 3));
    assert!(solved["error"].as_f64().unwrap() < 1e-7 && solved["stats"]["evaluations"].as_u64() > Some(1000));
    // Of a second-order method: position, then velocity.
    let args = ["solve", "--problem", "harmonic-oscillator", "--method", "velocity-verlet", "--h", "0.001"];
    let solved = json(&[&args[..], &["--json"]].concat());
    assert_eq!(solved["y"].as_array().unwrap().len(), 2);
    assert!(solved["error"].as_f64().unwrap() < 1e-5);
    let words = printed(&args);
    let y = solved["y"][0].as_f64().unwrap();
    assert!(words.contains(&format!("{y:.16e}")), "17 digits: {words}");
    // The tolerances are obeyed.
    let error = |rtol: &str, atol: &str| {
        let args = ["--problem", "lotka-volterra", "--method", "tsit54", "--rtol", rtol, "--atol", atol];
        json(&[&["solve"], &args[..], &["--json"]].concat())["error"].as_f64().unwrap()
    };
    assert!(error("1e-9", "1e-9") < 0.01 * error("1e-4", "1e-4"));
    assert!(error("1e-9", "1e-2") > 10.0 * error("1e-9", "1e-9"));
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let solve = |problem: &str, method: &str, more: &[&str]| {
        complaint(&[&["solve", "--problem", problem, "--method", method], more].concat(), 2)
    };
    for (line, says) in [
        (complaint(&["show", "dp45"], 2), "did you mean dp54?"),
        (complaint(&["show", "verner"], 2), "verner76"),
        (complaint(&["show", "xyzzy"], 2), "kutta list"),
        (complaint(&["show", "no-such-folder/x.toml"], 2), "no-such-folder/x.toml cannot be read"),
        (complaint(&["show"], 2), "<NAME>"),
        (complaint(&["lits"], 2), "'list'"),
        (complaint(&["list", "--jsn"], 2), "--json"),
        (solve("lorenz", "rk4", &["--h", "0.1"]), "did you mean lorenz63?"),
        (solve("xyzzy", "rk4", &["--h", "0.1"]), "kepler-e06"),
        (solve("lorenz63", "rk4", &[]), "--h"),
        (solve("lorenz63", "verlet", &["--h", "0.1"]), "kepler-e06"),
        (solve("kepler-e06", "verlet", &[]), "--h"),
        (solve("lorenz63", "rk4", &["--h", "0"]), "--h is 0.0"),
        (solve("lorenz63", "rk4", &["--h", "-1e-3"]), "--h is -0.001"),
        (solve("lorenz63", "rk4", &["--h", "inf"]), "--h is inf"),
        (solve("lorenz63", "rk4", &["--h", "1e-300"]), "too small"),
        (solve("lorenz63", "dp54", &["--rtol", "0"]), "--rtol is 0.0"),
        (solve("lorenz63", "dp54", &["--rtol", "-1e-6"]), "--rtol is -1e-6"),
        (solve("lorenz63", "dp54", &["--rtol", "NaN"]), "--rtol is NaN"),
        (solve("lorenz63", "dp54", &["--rtol", "small"]), "'small'"),
        (solve("lorenz63", "dp54", &["--atol", "0"]), "--atol is 0.0"),
        (solve("lorenz63", "dp54", &["--atol", "nan"]), "--atol is NaN"),
    ] {
        assert!(line.contains(says), "{line:?} does not say {says:?}");
    }
    let binary = Scratch::new("binary.toml", &[0xff, 0xfe, 0]);
    assert!(complaint(&["check", binary.path()], 2).contains("UTF-8"));
    let wrong = Scratch::new("other.toml", b"tableu = 1\n");
    assert!(complaint(&["show", wrong.path()], 2).contains(":1: unknown key"));
}

/// A run that the problem stops is no bad input.
#[test]
fn a_run_that_fails_says_where() {
    let line = complaint(&["solve", "--problem", "vdp-mu1", "--method", "rk4", "--h", "2.5"], 1);
    assert!(line.contains("t = "), "{line}");
}

#[test]
fn help_and_version_are_no_errors() {
    assert!(printed(&["--version"]).starts_with("kutta "));
    for command in ["list", "show", "check", "stability", "solve", "compare", "hard"] {
        assert!(printed(&["--help"]).contains(command));
        assert!(printed(&[command, "--help"]).contains("Usage"));
    }
}

/// A reader that leaves early, like `head`, makes no noise.
#[test]
fn a_broken_pipe_is_silent() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_kutta"))
        .args(["show", "verner98-robust", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0];
    let mut out = child.stdout.take().unwrap();
    out.read_exact(&mut first).unwrap();
    drop(out);
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert_eq!(text(&output.stderr), "");
}
