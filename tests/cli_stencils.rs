//! The binary on stencils: lists, pictures, files given at run time, and one clear line for bad input.

mod common;

use common::{Scratch, complaint, json as json_of, printed};
use serde_json::{Value, json};

const LANCZOS: &str = "name = \"Lanczos 5\"\norder = 2\ncite = \"Lanczos 1956\"\n\
    stencil = '''\n-2 | -1/5\n-1 | -1/10\n1 | 1/10\n2 | 1/5\n'''\n";

#[test]
fn every_stencil_is_listed() {
    let list = json_of(&["stencils", "--json"]);
    let list = list.as_array().unwrap();
    assert_eq!(list.len(), kutta::normals::stencils::all().len());
    let item = |name: &str| list.iter().find(|item| item["name"] == name).unwrap();
    assert_eq!((&item("forward2")["order"], &item("forward2")["order_at_texel"]), (&json!(2), &json!(1)));
    assert_eq!((&item("forward2")["at"], &item("farid7")["taps"]), (&json!(0.5), &json!(42)));
    assert_eq!((&item("compact6")["compact"], &item("compact6")["order"]), (&json!(true), &json!(6)));
    assert_eq!(item("prewitt3")["leading"][1], json!([1.0 / 3.0, 1, 2]));
    assert_eq!(
        (&item("onesided2")["symmetric"], &item("sobel3")["symmetric"]),
        (&json!(false), &json!(true))
    );
    let table = printed(&["stencils"]);
    for entry in kutta::normals::stencils::all() {
        let start = format!("{} ", entry.name);
        assert_eq!(table.lines().filter(|line| line.starts_with(&start)).count(), 1, "{}", entry.name);
    }
    assert!(table.contains("+1/2 (order 1 at the texel)"), "{table}");
}

#[test]
fn show_draws_a_stencil() {
    let sobel = printed(&["show", "sobel3"]);
    let picture = "     │  -1   0   1\n─────┼────────────\n   1 │  -1   0   1\n   0 │  -2   0   2\n  -1 │  -1   0   1\n";
    assert!(
        sobel.contains(picture) && sobel.contains("all over 8") && sobel.contains("Hart 1973"),
        "{sobel}"
    );
    let compact = printed(&["show", "compact6"]);
    assert!(compact.contains("   0 │   1   3   1\n") && compact.contains("tridiagonal"), "{compact}");
    let iso3 = json_of(&["show", "iso3", "--json"]);
    assert_eq!(iso3["smooth"][1], json!({ "offset": 0, "text": "2/3", "value": 2.0 / 3.0 }));
    assert_eq!((&iso3["left"], &iso3["digits"]), (&Value::Null, &Value::Null));
    assert!(complaint(&["show", "sobel4"], 2).contains("did you mean sobel3 or sobel5?"));
}

#[test]
fn files_are_added_shown_and_checked() {
    let mine = Scratch::new("lanczos5.toml", LANCZOS.as_bytes());
    let list = json_of(&["stencils", "--stencil", mine.path(), "--json"]);
    let item = list.as_array().unwrap().last().unwrap();
    assert_eq!((&item["title"], &item["taps"]), (&json!("Lanczos 5"), &json!(4)));
    // The least squares of two points on either side: sum j^4 / (6 sum j^2).
    assert!((item["e_xx"].as_f64().unwrap() - 34.0 / 60.0).abs() < 1e-15);
    assert!(printed(&["show", mine.path()]).contains("all over 10"));
    assert!(printed(&["check", mine.path()]).contains("is right: Lanczos 5"));
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let wrong = Scratch::new("wrong.toml", LANCZOS.replace("2 | 1/5\n'''", "2 | 1/4\n'''").as_bytes());
    let says = format!("{}: the moment M_00 is off by 5e-2: the weights must sum to 0", wrong.path());
    assert_eq!(complaint(&["check", wrong.path()], 1), says);
    for args in [vec!["stencils", "--stencil", wrong.path()], vec!["show", wrong.path()]] {
        assert_eq!(complaint(&args, 2), says);
    }
    let method = complaint(&["stencils", "--stencil", "tableaus/explicit/rk4.toml"], 2);
    assert!(
        method.ends_with("the grid \"tableau\" makes this a Runge-Kutta method, not a stencil"),
        "{method}"
    );
    let stencil = complaint(
        &["solve", "--problem", "lorenz63", "--method", "tableaus/stencils/sobel3.toml", "--h", "0.1"],
        2,
    );
    assert!(stencil.contains("this is a stencil, not a method"), "{stencil}");
    assert!(complaint(&["stencils", "--stencil", "no-such-file.toml"], 2).contains("no-such-file.toml"));
    assert!(complaint(&["stencils", "sobel"], 2).contains("did you mean sobel3 or sobel5?"));
    assert!(complaint(&["stencils", "--acuracy"], 2).contains("--accuracy"));
}

/// The figures themselves are tested in the library.
#[test]
fn accuracy_is_measured_on_every_surface() {
    let measured = json_of(&["stencils", "central4", "sobel3", "--accuracy", "--json"]);
    let measured = measured.as_array().unwrap();
    // Eight surfaces in float, two of them stored in six other ways.
    assert_eq!(measured.len(), 2 * (8 + 2 * 6));
    let of = |stencil: &str, surface: &str, stored: &str| {
        let is = |m: &&Value| m["stencil"] == stencil && m["surface"] == surface && m["stored"] == stored;
        measured.iter().find(is).unwrap()["rms"].as_f64().unwrap()
    };
    // On smooth heights order pays, in eight bits smoothing does.
    assert!(of("central4", "sine 16", "float>float") < 0.1 * of("sobel3", "sine 16", "float>float"));
    assert!(of("sobel3", "dome", "8>float") < of("central4", "dome", "8>float"));
}
