use super::*;
use crate::tableau::Broken;

const RK4: &str = r#"
name  = "RK4" # the classic
order = 4
cite  = "Kutta 1901"
tableau = '''
0   |
1/2 | 1/2
1/2 | 0   1/2
1   | 0   0   1
----+----------------
    | 1/6 1/3 1/3 1/6
'''
"#;

fn refusal(text: &str) -> String {
    match read(text) {
        Ok(_) => String::from("read"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn the_compiler_reads_too() {
    const READ: Tableau = match read(RK4) {
        Ok(tableau) => tableau,
        Err(_) => panic!(),
    };
    assert_eq!((READ.title, READ.cite, READ.note, READ.order), ("RK4", "Kutta 1901", "", 4));
    let Scheme::RungeKutta(array) = READ.scheme else { panic!("another family") };
    assert_eq!((array.stages, array.lower, array.powers), (4, 0, 0));
    assert_eq!(array.a[2][..4], [D::ZERO, D::of(0.5), D::ZERO, D::ZERO]);
    assert_eq!(array.b[1], D::ONE / D::of(3.0));
    assert_eq!(array.c[..4], [D::ZERO, D::of(0.5), D::of(0.5), D::ONE]);
}

#[test]
fn line_ends_of_windows_are_read() {
    assert_eq!(refusal(&RK4.replace('\n', "\r\n")), "read");
    assert_eq!(refusal(&RK4.replace('\n', "\r")), "line 1: unknown key \"?name\"");
}

#[test]
fn refusals_name_the_line() {
    for (from, to, message) in [
        ("order = 4", "order = 0", "line 3: \"order\" is a whole number from 1 to 20"),
        ("order = 4", "order = 21", "line 3: \"order\" is a whole number from 1 to 20"),
        ("order = 4", "order = 04", "line 3: \"order\" is a whole number from 1 to 20"),
        ("order = 4", "order =", "line 3: the key \"order\" is empty"),
        ("order = 4", "ordre = 4", "line 3: unknown key \"ordre\""),
        ("order = 4", "name = \"a\"", "line 3: the key \"name\" was given already on line 2"),
        ("order = 4", "", "the key \"order\" is missing; every method needs it"),
        (
            "order = 4",
            "order = 4\nembedded = [3 2]",
            "line 4: \"embedded\" takes two whole numbers from 1 to 20, as in [5, 3]",
        ),
        (
            "order = 4",
            "order = 4\nembedded = [3, 2]",
            "line 4: the tableau has 0 rows of bhat but \"embedded\" gives 2 orders",
        ),
        ("order = 4", "order = 4\ndense_order = 3", "the key \"dense\" is missing; a dense output needs it"),
        (
            "order = 4",
            "order = 4\nmode = \"PEC\"",
            "line 4: the key \"mode\" does not belong to a Runge-Kutta method",
        ),
        ("order = 4", "order = 4\n[table]", "line 4: expected key = value"),
        (
            "\"RK4\"",
            "RK4",
            "line 2: \"name\" is a text in double quotes, with no quotes or backslashes in it",
        ),
        (
            "\"RK4\"",
            "\"RK\\4\"",
            "line 2: \"name\" is a text in double quotes, with no quotes or backslashes in it",
        ),
        ("\"RK4\"", "\"RK4\" x", "line 2: nothing but a comment may follow the value of \"name\""),
        ("\"RK4\"", "\"RK\u{7}4\"", "line 2: remove the control character from this line"),
        (
            "'''\n0 ",
            "''' 0 ",
            "line 5: \"tableau\" is a grid: ''' at the end of this line, rows below, ''' in a line of its own",
        ),
        ("'''\n\"", "", "read"),
        ("1/6\n'''", "1/6", "line 5: the grid \"tableau\" ends with ''' in a line of its own"),
        ("1/6\n'''", "1/6'''", "line 11: the grid \"tableau\" ends with ''' in a line of its own"),
        ("1/3 1/6", "1/6", "line 11: the row has 3 entries but the method has 4 stages"),
        ("0   0   1", "0 0 1 0 0", "line 9: the row has 5 entries but the method has 4 stages"),
        ("0   0   1", "0 0 1,0", "line 9: \"1,0\" is not a number"),
        ("0   0   1", "0 | 0 1", "line 9: there is a bar | too many in this row"),
        ("1   |", "1 1 |", "line 9: put a bar | behind the first entry of this row"),
        ("1   |", "    |", "line 9: c is missing before the bar |"),
        ("1   |", "x   |", "line 9: \"x\" is not a number"),
        ("1   | 0   0   1", "1", "line 9: this row has no bar |"),
        ("    | 1/6", "  1 | 1/6", "line 11: nothing may stand before the bar | of this row"),
        ("----+--", "----|--", "line 10: \"----------------\" is not a number"),
        ("1/2 | 1/2\n", "---\n", "line 10: remove this second rule of dashes"),
    ] {
        let text = RK4.replacen(from, to, 1);
        if message != "read" {
            assert_ne!(text, RK4, "{from}");
        }
        assert_eq!(refusal(&text), message, "{to}");
    }
}

#[test]
fn long_and_wild_entries_are_quoted_safely() {
    let entry = "\u{1b}é".repeat(60);
    let message = refusal(&RK4.replacen("1/2 | 1/2", &format!("1/2 | {entry}"), 1));
    assert_eq!(message, format!("line 7: \"{}..\" is not a number", "?é".repeat(20)));
}

#[test]
fn transformed_variables_become_those_of_the_step() {
    // RODAS3, Hairer, Wanner 1996, section IV.10, and its original form there.
    let rodas3 = r#"
name     = "RODAS3"
order    = 3
embedded = 2
cite     = "Sandu et al. 1997"
gamma    = '''
| 1/2
'''
a = '''
|
| 0
| 2 0
| 2 0 1
---
| 2 0 1 1
| 2 0 1 0
'''
c = '''
|
| 4
| 1 -1
| 1 -1 -8/3
'''
"#;
    let Ok(Tableau { scheme: Scheme::Rosenbrock { alpha, gamma }, .. }) = read(rodas3) else {
        panic!("{}", refusal(rodas3))
    };
    let near = |row: &[D; STAGES], expected: [f64; 4]| {
        for (x, y) in row.iter().zip(expected) {
            assert!((*x * D::of(12.0) - D::of(y)).abs().hi() < 1e-29, "{row:?}");
        }
    };
    near(&gamma.a[1], [12.0, 6.0, 0.0, 0.0]);
    near(&gamma.a[2], [-3.0, -3.0, 6.0, 0.0]);
    near(&gamma.a[3], [1.0, 1.0, -8.0, 6.0]);
    near(&alpha.a[2], [12.0, 0.0, 0.0, 0.0]);
    near(&alpha.a[3], [9.0, -3.0, 6.0, 0.0]);
    near(&alpha.b, [10.0, -2.0, -2.0, 6.0]);
    near(&alpha.bhat[0], [9.0, -3.0, 6.0, 0.0]);
    near(&alpha.c, [0.0, 0.0, 12.0, 12.0]);
    near(&gamma.c, [6.0, 18.0, 0.0, 0.0]);
}

#[test]
fn families_do_not_mix() {
    let two = format!("{RK4}splitting = '''\ndrift 1\nkick 1\n'''\n");
    assert_eq!(refusal(&two), "line 13: the key \"splitting\" does not belong to a Runge-Kutta method");
    let half = RK4.replace("tableau =", "explicit =");
    assert_eq!(refusal(&half), "the key \"implicit\" is missing; an IMEX pair needs it");
    let none = "name = \"a\"\norder = 1\ncite = \"b\"\n";
    assert_eq!(refusal(none), "the file has no numbers: add a grid such as \"tableau\"");
    assert_eq!(read("# nothing\n").err().unwrap().broken, Broken::Syntax);
}

#[test]
fn entries_are_given_as_printed() {
    let rows = entries(RK4, "tableau").unwrap();
    assert_eq!(rows[0], ["0"]);
    assert_eq!(rows[2], ["1/2", "0", "1/2"]);
    assert_eq!(rows[4], [""; 0]);
    assert_eq!(rows[5], ["", "1/6", "1/3", "1/3", "1/6"]);
    assert_eq!(entries(RK4, "dense"), None);
    assert_eq!(entries(RK4, "order"), None);
}
