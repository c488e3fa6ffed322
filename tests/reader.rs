//! `Tableau::parse` answers every text with a tableau or a typed error; none panics it.

use std::path::Path;

use kutta::tableau::{Broken, Tableau};
use proptest::prelude::*;

/// One file of every family, small enough to be proven a thousand times.
const FILES: [&str; 14] = [
    "explicit/rk4.toml",
    "explicit/bs32.toml",
    "explicit/dp54.toml",
    "implicit/gauss2.toml",
    "imex/ark2-imex.toml",
    "partitioned/lobatto-iiia-iiib2.toml",
    "rosenbrock/ros2.toml",
    "rosenbrock/rodas3.toml",
    "rosenbrock/rodas4.toml",
    "multistep/ab3.toml",
    "multistep/heun-pece.toml",
    "nystrom/verlet.toml",
    "nystrom/velocity-verlet.toml",
    "nystrom/ruth3.toml",
];

fn file(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tableaus").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What is always true of an answer.
fn check(text: &str) -> Result<(), TestCaseError> {
    match Tableau::parse(text) {
        Ok(tableau) => {
            prop_assert!((1..=20).contains(&tableau.order));
            tableau.form();
        }
        Err(error) => {
            prop_assert!(error.line <= text.split('\n').count(), "{error}");
            prop_assert!(error.text.as_str().len() > 8, "{error}");
            prop_assert!(!error.to_string().contains(|c: char| c.is_ascii_control()), "{error:?}");
        }
    }
    Ok(())
}

/// Pieces that mean something to the reader.
fn piece() -> impl Strategy<Value = String> {
    prop_oneof![
        proptest::sample::select(vec![
            "'''",
            "'''\n",
            "\n",
            "\r\n",
            "\r",
            "|",
            " | ",
            "-",
            "---\n",
            "\"",
            "\\",
            "#",
            "=",
            "[5, 3]",
            "[",
            ",",
            "0",
            "1",
            "-1",
            "1/2",
            "3/0",
            "1/3+",
            "(",
            ")",
            "sqrt(",
            "cbrt(-8)",
            "sqrt(-1)",
            "1e999",
            "1e-999",
            ".",
            "1e300",
            "order",
            "embedded = 1\n",
            "dense",
            "tableau",
            "splitting = '''\n",
            "gamma",
            "drift 1\n",
            "kick -1/3\n",
            "alpha | 1\n",
            "ß",
            "\u{feff}",
            "\u{0}",
            "99999999999999999999",
        ])
        .prop_map(String::from),
        "[0-9]{1,400}",
        "[(]{1,40}",
        ".{0,8}",
    ]
}

/// Replaces some of the text between two places, each given as a part of the whole, by a piece.
fn edited(mut text: String, edits: &[(f64, f64, String)]) -> String {
    for (place, length, piece) in edits {
        let border = |at: f64| text.floor_char_boundary((at.min(1.0) * text.len() as f64) as usize);
        let (from, to) = (border(*place), border(place + length * length * length));
        text.replace_range(from..to, piece);
    }
    text
}

fn edits() -> impl Strategy<Value = Vec<(f64, f64, String)>> {
    prop::collection::vec((0.0..1.0, 0.0..0.6, piece()), 1..6)
}

/// A file with the right keys and rows of any lengths.
fn grids() -> impl Strategy<Value = String> {
    let keys = vec![
        vec!["tableau"],
        vec!["tableau", "dense_stages", "dense"],
        vec!["explicit", "implicit"],
        vec!["position", "velocity"],
        vec!["alpha", "gamma"],
        vec!["gamma", "a", "c"],
        vec!["gamma", "a", "c", "dense"],
        vec!["multistep"],
        vec!["stormer"],
        vec!["predictor", "corrector"],
        vec!["nystrom"],
        vec!["splitting"],
    ];
    let entry = proptest::sample::select(vec![
        "0", "0", "0", "1", "-1", "1/2", "-1/3", "2", "1e300", "-1e308", "1e-300", "sqrt(2)", "1/0", "x",
    ]);
    let label = proptest::sample::select(vec![
        "|", "|", "1 |", "0 |", "1/2 |", "alpha |", "beta |", "y |", "v |", "drift", "kick", "---", "", "\n",
    ]);
    let row = (label, prop::collection::vec(entry, 0..25)).prop_map(|(label, row)| {
        let row = if label == "---" { String::new() } else { row.join(" ") };
        format!("{label} {row}\n")
    });
    let rows = prop::collection::vec(row, 0..48).prop_map(|rows| rows.concat());
    (proptest::sample::select(keys), prop::collection::vec(rows, 4), 1..24usize, 0..12usize).prop_map(
        |(keys, rows, order, other)| {
            let mut text = format!("name = \"a\"\norder = {order}\ncite = \"b\"\n");
            match other {
                1 | 2 => text += &format!("embedded = {other}\n"),
                3 => text += "embedded = [2, 1]\n",
                4..8 => text += &format!("dense_order = {other}\n"),
                _ => {}
            }
            if keys[0] == "predictor" {
                text += "mode = \"PEC\"\n";
            }
            for (key, rows) in keys.iter().zip(&rows) {
                text += &format!("{key} = '''\n{rows}'''\n");
            }
            text
        },
    )
}

/// Grids of the right shape with numbers that prove nothing: the proof itself must not panic either.
fn shaped() -> impl Strategy<Value = String> {
    let entries = ["0", "1", "-1", "1/2", "-7/3", "1e300", "-1e308", "1e-320", "1e-30", "sqrt(2)"];
    let entry = move || proptest::sample::select(entries.to_vec());
    let row = move |n: usize| prop::collection::vec(entry(), n).prop_map(|row| row.join(" "));
    let head = |order: usize| format!("name = \"a\"\norder = {order}\ncite = \"b\"\n");
    let butcher = (1..21usize, 1..21usize)
        .prop_flat_map(move |(s, order)| (prop::collection::vec(row(s), s + 1), Just(order)))
        .prop_map(move |(rows, order)| {
            let (b, a) = rows.split_last().expect("one row at least");
            let a: String = a.iter().map(|row| format!("1 | {row}\n")).collect();
            format!("{}tableau = '''\n{a}---\n| {b}\n'''\n", head(order))
        });
    let multistep = (2..15usize, 1..21usize, any::<bool>())
        .prop_flat_map(move |(n, order, second)| (row(n), row(n), Just(order), Just(second)))
        .prop_map(move |(alpha, beta, order, second)| {
            let key = if second { "stormer" } else { "multistep" };
            format!("{}{key} = '''\nalpha | {alpha}\nbeta | {beta}\n'''\n", head(order))
        });
    let pair = (2..15usize, 2..15usize, 1..21usize, any::<bool>())
        .prop_flat_map(move |(m, n, order, again)| {
            (row(m), row(m - 1), row(n), row(n), Just(order), Just(again))
        })
        .prop_map(move |(alpha, beta, alphas, betas, order, again)| {
            let mode = if again { "PECE" } else { "PEC" };
            let predictor = format!("predictor = '''\nalpha | {alpha}\nbeta | {beta} 0\n'''\n");
            let corrector = format!("corrector = '''\nalpha | {alphas}\nbeta | {betas}\n'''\n");
            format!("{}mode = \"{mode}\"\n{predictor}{corrector}", head(order))
        });
    let splitting = (prop::collection::vec((any::<bool>(), entry()), 1..41), 1..21usize).prop_map(
        move |(rows, order)| {
            let rows: String = rows
                .iter()
                .map(|(kick, weight)| format!("{} {weight}\n", if *kick { "kick" } else { "drift" }))
                .collect();
            format!("{}splitting = '''\n{rows}'''\n", head(order))
        },
    );
    prop_oneof![butcher, multistep, pair, splitting]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check(&String::from_utf8_lossy(&bytes))?;
    }

    #[test]
    fn any_pieces(pieces in prop::collection::vec(piece(), 0..60)) {
        check(&pieces.concat())?;
    }

    #[test]
    fn spoiled_files(name in proptest::sample::select(FILES.to_vec()), edits in edits()) {
        check(&edited(file(name), &edits))?;
    }

    #[test]
    fn any_grids(text in grids()) {
        check(&text)?;
    }

    #[test]
    fn any_numbers(text in shaped()) {
        check(&text)?;
    }
}

/// A file with `from` replaced once, and how it is refused.
fn refusal(name: &str, from: &str, to: &str) -> (Broken, usize, f64) {
    let text = file(name);
    assert!(text.contains(from), "{name} has no {from}");
    let error = Tableau::parse(&text.replacen(from, to, 1)).err().expect("a refusal");
    (error.broken, error.line, error.off_by)
}

#[test]
fn files_of_every_family_are_accepted() {
    for name in FILES {
        let text = file(name);
        let refused = Tableau::parse(&text).err();
        assert!(refused.is_none(), "{name}: {refused:?}");
    }
}

#[test]
fn errors_are_typed() {
    let rk4 = "explicit/rk4.toml";
    assert_eq!(refusal(rk4, "order", "ordre"), (Broken::Syntax, 2, 0.0));
    assert_eq!(refusal(rk4, "1/2", "1/2x").0, Broken::Number);
    assert_eq!(refusal(rk4, "1/2", "1/0").0, Broken::Number);
    assert_eq!(refusal(rk4, "1/6", "").0, Broken::Shape);
    // Both rows of 1/2 keep their sums, b loses a third of its weight.
    let (broken, _, off) = refusal(rk4, "1/3", "0");
    assert_eq!(broken, Broken::Order);
    assert!((off + 1.0 / 3.0).abs() < 1e-15, "{off}");
    let (broken, _, off) = refusal(rk4, "1/2", "1/4");
    assert_eq!(broken, Broken::RowSum);
    assert!((off.abs() - 0.25).abs() < 1e-15, "{off}");
    assert_eq!(refusal("explicit/bs32.toml", "7/24", "8/24").0, Broken::EmbeddedOrder);
    assert_eq!(refusal("explicit/bs32.toml", "5/9", "4/9").0, Broken::DenseOrder);
    // The explicit two-step method of order 3, whose second root is -5.
    let (from, to) = ("alpha | -1 0 1\nbeta  |  0 2 0", "alpha | -5 4 1\nbeta  |  2 4 0");
    assert_eq!(refusal("multistep/nystrom2.toml", from, to).0, Broken::ZeroStability);
}
