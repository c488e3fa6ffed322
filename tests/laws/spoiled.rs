//! The laws have teeth: sound tables with one number changed, and the law that each then breaks.

use super::file::File;
use super::prove;
use super::report::Report;

fn broken(text: &str) -> Vec<String> {
    let file = File::parse("x.toml", text);
    let mut report = Report::new(&file);
    prove(&file, &mut report);
    report.broken
}

/// Each change of the text breaks a law; the first one that is found must be this.
fn spoil(text: &str, changes: &[(&str, &str, &str)]) {
    assert_eq!(broken(text), [""; 0]);
    for (from, to, law) in changes {
        assert_eq!(text.matches(from).count(), 1, "{from} stands once in the text");
        let found = broken(&text.replace(from, to));
        assert_eq!(found.first(), Some(&format!("x.toml: {law}")), "{from} became {to}: {found:?}");
    }
}

#[test]
fn a_wrong_runge_kutta_table_is_found() {
    let bogacki_shampine = "
        order = 3
        embedded = 2
        dense_order = 3
        tableau = '''
        0   |
        1/2 | 1/2
        3/4 | 0    3/4
        1   | 2/9  1/3 4/9
        ----+-----------------
            | 2/9  1/3 4/9 0
            | 7/24 1/4 1/3 1/8
        '''
        dense = '''
        1 -4/3  5/9
        0  1   -2/3
        0  4/3 -8/9
        0 -1    1
        '''";
    spoil(
        bogacki_shampine,
        &[
            ("| 0    3/4", "| 1/4  3/4", "the sum of row 3 of the array is off by 2.5e-1"),
            // b_3 = 4/9 times 1/8 moved from c_2 = 1/2 to c_1 = 0.
            ("| 0    3/4", "| 1/8  5/8", "b: the order 3 condition of the tree [[[]]] is off by 2.8e-2"),
            ("7/24 1/4", "8/24 1/4", "bhat 1: the order 1 condition of the tree [] is off by 4.2e-2"),
            // The same sum at theta = 1, yet theta^2 has 4/3 - 2/3 too little.
            (
                "4/3 -8/9",
                "2/3 -2/9",
                "dense output: the order 1 condition of the tree [] at theta^2 is off by 6.7e-1",
            ),
            (
                "4/3 -8/9",
                "4/3 -7/9",
                "the weight of stage 3 in the dense output at theta = 1 is off by 1.1e-1",
            ),
            (
                "\n        order = 3",
                "\n        order = 2",
                "b claims order 2, yet all conditions of order 3 hold",
            ),
            // Three stages have no path of four nodes: 0, not 1/24.
            (
                "\n        order = 3",
                "\n        order = 4",
                "b: the order 4 condition of the tree [[[[]]]] is off by 4.2e-2",
            ),
            ("embedded = 2", "embedded = 1", "bhat 1 claims order 1, yet all conditions of order 2 hold"),
            (
                "dense_order = 3",
                "dense_order = 2",
                "dense output claims order 2, yet all conditions of order 3 hold",
            ),
        ],
    );
}

#[test]
fn wrong_pairs_of_arrays_are_found() {
    let midpoint = "
        order = 2
        explicit = '''
        0   |
        1/2 | 1/2
        ----+----
            | 0 1
        '''
        implicit = '''
        0   | 0
        1/2 | 0 1/2
        ----+------
            | 0  1
        '''";
    // Both b are of order 2, but not with the other array: b of g meets A of f as 1/2 c_2 = 1/4.
    let coupling = "b: the order 2 condition of the tree {[]} is off by 2.5e-1";
    spoil(midpoint, &[("0  1", "1/2 1/2", coupling)]);
    let verlet = "
        order = 2
        position = '''
        0 |
        1 | 1/2 1/2
        --+--------
          | 1/2 1/2
        '''
        velocity = '''
        1/2 | 1/2
        1/2 | 1/2
        ----+-----------
            |  1/2   1/2
        '''";
    spoil(verlet, &[(" 1/2   1/2", "1 0", "b: the order 2 condition of the tree {[]} is off by 5.0e-1")]);
}

#[test]
fn a_wrong_rosenbrock_table_is_found() {
    let ros2 = "
        order = 2
        embedded = 1
        alpha = '''
        |
        | 1
        ----------
        | 1/2 1/2
        | 1   0
        '''
        gamma = '''
        | 3/4
        | -3/2 3/4
        '''";
    spoil(
        ros2,
        &[
            ("-3/2", "-1", "b: the order 2 condition of the tree [[]] is off by 2.5e-1"),
            (
                "embedded = 1",
                "embedded = 2",
                "bhat 1: the order 2 condition of the tree [[]] is off by 2.5e-1",
            ),
        ],
    );
}

#[test]
fn wrong_multistep_rows_are_found() {
    let ab2 = "
        order = 2
        multistep = '''
        alpha |  0   -1  1
        beta  | -1/2 3/2 0
        '''";
    spoil(
        ab2,
        &[
            ("-1/2 3/2", "-1/4 5/4", "the condition of the polynomial t^2 is off by 2.5e-1"),
            ("order = 2", "order = 1", "the step claims order 1, yet all conditions of order 2 hold"),
        ],
    );
    // Of the highest order that two steps have, and useless: rho = (z - 1) (z + 5).
    let unstable = "
        order = 3
        multistep = '''
        alpha | -5 4 1
        beta  |  2 4 0
        '''";
    assert_eq!(broken(unstable), ["x.toml: rho breaks the root condition"]);
}

#[test]
fn wrong_second_order_methods_are_found() {
    let stormer = "
        order = 2
        stormer = '''
        alpha | 1 -2 1
        beta  | 0  1 0
        '''";
    spoil(stormer, &[("0  1 0", "0 1/2 0", "the condition of the polynomial t^2 is off by 5.0e-1")]);
    let verlet = "
        order = 2
        nystrom = '''
        0 |
        1 | 1/2
        --+--------
        y | 1/2 0
        v | 1/2 1/2
        '''";
    let position = "position: the order 2 condition of the tree [[]] is off by 2.5e-1";
    let velocity = "velocity: the order 2 condition of the tree [[[]]] is off by 2.5e-1";
    spoil(verlet, &[("1/2 0", "1/4 0", position), ("v | 1/2 1/2", "v | 1/4 3/4", velocity)]);
    let splitting = "
        order = 2
        splitting = '''
        kick  1/2
        drift 1
        kick  0.5
        '''";
    // The position takes 2/5 where it needs 1/2.
    let kicks = "position: the order 2 condition of the tree [[]] is off by 1.0e-1";
    spoil(
        splitting,
        &[("kick  1/2\n        drift 1\n        kick  0.5", "kick 2/5\ndrift 1\nkick 3/5", kicks)],
    );
}

#[test]
fn a_wrong_member_is_found() {
    let family = "
        order = 2
        nordsieck = '''
        alpha | -1 1
        beta  | 0 1
        alpha | 1/2 -2 3/2
        beta  | 0 0 2/2
        '''";
    spoil(
        family,
        &[
            ("2/2", "1/2", "the condition of the polynomial t^1 is off by 5.0e-1"),
            ("order = 2", "order = 3", "2 members, but order 3"),
        ],
    );
}

#[test]
fn a_wrong_predictor_is_found() {
    let heun = "
        order = 2
        mode = \"PECE\"
        predictor = '''
        alpha | -1 1
        beta  | 1.0 0
        '''
        corrector = '''
        alpha | -1   1
        beta  | 1/2 1/2
        '''";
    // Half of the half step that is missing.
    spoil(heun, &[("1.0 0", "1/2 0", "y: the order 2 condition of the tree [[]] is off by 2.5e-1")]);
}

#[test]
fn a_wrong_count_of_digits_is_found() {
    let heun3 = "
        order = 3
        digits = 10
        tableau = '''
        0            |
        0.3333333333 | 0.3333333333
        0.6666666667 | 0            0.6666666667
        -------------+-------------------------------
                     | 0.25         0            0.75
        '''";
    assert_eq!(broken(heun3), [""; 0]);
    // c_3 is 1e-10/3 too large, b_3 c_3 by 3/4 of that, b_3 c_3^2 by all of it.
    let more = "x.toml: b: the order 2 condition of the tree [[]] is off by 2.5e-11";
    assert_eq!(broken(&heun3.replace("= 10", "= 11")).first().map(String::as_str), Some(more));
    let fewer = "x.toml: claims 6 digits, yet every law holds to 3.3e-11";
    assert_eq!(broken(&heun3.replace("= 10", "= 6")), [fewer]);
}
