//! `Stencil::parse` answers every text with a stencil or a typed error; none panics it.

use kutta::normals::{Stencil, stencils};
use kutta::tableau::Broken;
use proptest::prelude::*;

/// What is always true of an answer.
fn check(text: &str) -> Result<(), TestCaseError> {
    match Stencil::parse(text) {
        Ok(stencil) => {
            let p = stencil.properties();
            prop_assert!(stencil.order >= 1 && p.order >= stencil.order, "{}", stencil.order);
            prop_assert!(p.noise_gain > 0.0 && p.taps > 1);
            prop_assert!(stencil.shortest_wave(0.01) >= 2.0);
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
            "|",
            " | ",
            "-",
            "---\n",
            "\"",
            "=",
            "0",
            "1",
            "-1 | 1\n",
            "1/2",
            "-1/0",
            "(",
            "sqrt(2)",
            "1e999",
            "1e-999",
            "1e300",
            "order",
            "order = 20\n",
            "isotropic = 20\n",
            "at = \"1/2\"\n",
            "digits = 3\n",
            "smooth = '''\n",
            "left = '''\n",
            "stencil",
            "tableau",
            "9999999999999999999999 | 1\n",
            "-9223372036854775808 | 1\n",
            "ß",
            "\u{0}",
        ])
        .prop_map(String::from),
        "[0-9]{1,400}",
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

/// Grids of the right shape with numbers that prove nothing: the proof must not panic either.
fn shaped() -> impl Strategy<Value = String> {
    let weight = proptest::sample::select(vec![
        "1", "-1", "1/2", "-7/3", "1e300", "-1e308", "1e-320", "sqrt(2)", "0.1",
    ]);
    let row = move |most: usize| {
        (-17i64..17, prop::collection::vec((1i64..4, weight.clone()), 1..most)).prop_map(|(first, taps)| {
            let (mut rows, mut offset) = (String::new(), first);
            for (step, weight) in taps {
                rows += &format!("{offset} | {weight}\n");
                offset += step;
            }
            rows
        })
    };
    let at = proptest::sample::select(vec!["", "at = \"1/2\"\n", "at = \"-1/2\"\n", "digits = 1\n"]);
    (row(18), row(8), prop_oneof![row(4), Just("-1 | 1/3\n0 | 1\n1 | 1/3\n".into())], 0..8, 1..21, at)
        .prop_map(|(stencil, smooth, left, which, order, at)| {
            let mut text =
                format!("name = \"a\"\norder = {order}\ncite = \"b\"\n{at}stencil = '''\n{stencil}'''\n");
            if which & 1 > 0 {
                text += &format!("smooth = '''\n{smooth}'''\n");
            }
            if which & 2 > 0 {
                text += &format!("left = '''\n{left}'''\n");
            }
            if which & 4 > 0 {
                text += &format!("isotropic = {order}\n");
            }
            text
        })
}

/// A row that is right: any weights at distances 1, 2, .., the first one chosen so that a ramp has the slope 1.
fn antisymmetric() -> impl Strategy<Value = String> {
    prop::collection::vec((-9i64..=9).prop_filter("no tap of weight 0", |w| *w != 0), 1..7).prop_map(
        |weights| {
            let rest: i64 = (2..).zip(&weights).map(|(j, w)| 2 * j * w).sum();
            let first = format!("(1-({rest}))/2");
            let taps: Vec<_> = std::iter::once(first).chain(weights.iter().map(i64::to_string)).collect();
            let before = taps.iter().enumerate().rev().map(|(j, w)| format!("-{} | -({w})\n", j + 1));
            let after = taps.iter().enumerate().map(|(j, w)| format!("{} | {w}\n", j + 1));
            let rows: String = before.chain(after).collect();
            format!("name = \"a\"\norder = 2\ncite = \"b\"\nstencil = '''\n{rows}'''\n")
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check(&String::from_utf8_lossy(&bytes))?;
    }

    #[test]
    fn any_pieces(pieces in prop::collection::vec(piece(), 0..60)) {
        check(&pieces.concat())?;
    }

    #[test]
    fn spoiled_files(
        entry in proptest::sample::select(stencils::all().to_vec()),
        edits in prop::collection::vec((0.0..1.0, 0.0..0.6, piece()), 1..5),
    ) {
        check(&edited(entry.text.to_string(), &edits))?;
    }

    #[test]
    fn any_numbers(text in shaped()) {
        check(&text)?;
    }

    #[test]
    fn a_right_row_is_accepted(text in antisymmetric()) {
        prop_assert!(Stencil::parse(&text).is_ok(), "{:?}\n{text}", Stencil::parse(&text).err());
        check(&text)?;
    }
}

#[test]
fn errors_are_typed() {
    let refusal = |from: &str, to: &str| {
        let text = stencils::find("iso3").unwrap().text;
        assert!(text.contains(from), "{from}");
        let error = Stencil::parse(&text.replacen(from, to, 1).leak()).err().expect("a refusal");
        (error.broken, error.line, error.off_by)
    };
    assert_eq!(refusal("order", "ordre"), (Broken::Syntax, 2, 0.0));
    assert_eq!(refusal("1/2", "1/2x").0, Broken::Number);
    assert_eq!(refusal("-1 |", "-16 |"), (Broken::Shape, 6, 0.0));
    assert_eq!(refusal("-1 |", "-9223372036854775808 |").0, Broken::Shape);
    let (broken, _, off) = refusal("-1/2", "-1/4");
    assert_eq!((broken, off), (Broken::Moment, 0.25));
    let lopsided = " 0 | 2/3\n 1 | 1/6\n 2 | 0.01";
    assert_eq!(refusal("0 | 2/3\n 1 | 1/6", lopsided.trim_start()).0, Broken::Moment);
}
