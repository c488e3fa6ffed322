//! Twenty species and twenty-five reactions of an air pollution model.

use super::Problem;

/// The chemistry of an air pollution model, y' = N r(y), 0 <= t <= 60.
///
/// Each rate r_i is k_i times the amounts of one or two species that react; N counts what a reaction takes
/// and gives. y(0) is 0 but for y2 = 0.2, y4 = 0.04, y7 = 0.1, y8 = 0.3, y9 = 0.01, y17 = 0.007.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pollution;

/// r: what each reaction turns over. No species reacts with itself, so each rate is linear in each species.
#[inline]
#[rustfmt::skip]
fn rates(y: &[f64; 20]) -> [f64; 25] {
    let [y1, y2, y3, y4, y5, y6, y7, _, y9, y10, y11, _, y13, y14, _, y16, y17, _, y19, y20] = y;
    [
        0.35 * y1,         26.6 * y2 * y4,     12300.0 * y5 * y2,  8.6e-4 * y7,       8.2e-4 * y7,
        15000.0 * y7 * y6, 1.3e-4 * y9,        24000.0 * y9 * y6,  16500.0 * y11 * y2, 9000.0 * y11 * y1,
        0.022 * y13,       12000.0 * y10 * y2, 1.88 * y14,         16300.0 * y1 * y6, 4.8e6 * y3,
        3.5e-4 * y4,       0.0175 * y4,        1e8 * y16,          4.44e11 * y16,     1240.0 * y17 * y6,
        2.1 * y19,         5.78 * y19,         0.0474 * y1 * y4,   1780.0 * y19 * y1, 3.12 * y20,
    ]
}

/// N r: what each species gains.
#[inline]
#[rustfmt::skip]
fn gains(r: &[f64; 25]) -> [f64; 20] {
    let [r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11, r12, r13, ..] = r;
    let [.., r14, r15, r16, r17, r18, r19, r20, r21, r22, r23, r24, r25] = r;
    [
        -r1 - r10 - r14 - r23 - r24 + r2 + r3 + r9 + r11 + r12 + r22 + r25,
        -r2 - r3 - r9 - r12 + r1 + r21,
        -r15 + r1 + r17 + r19 + r22,
        -r2 - r16 - r17 - r23 + r15,
        -r3 + 2.0 * r4 + r6 + r7 + r13 + r20,
        -r6 - r8 - r14 - r20 + r3 + 2.0 * r18,
        -r4 - r5 - r6 + r13,
        r4 + r5 + r6 + r7,
        -r7 - r8,
        -r12 + r7 + r9,
        -r9 - r10 + r8 + r11,
        *r9,
        -r11 + r10,
        -r13 + r12,
        *r14,
        -r18 - r19 + r16,
        -r20,
        *r20,
        -r21 - r22 - r24 + r23 + r25,
        -r25 + r24,
    ]
}

impl Problem for Pollution {
    type Y = [f64; 20];
    const NAME: &'static str = "pollution";
    const ABOUT: &'static str = "the air over a city: 20 species, 25 reactions, rates from 1e-4 to 1e11";
    const SOURCE: &'static str = "Verwer 1994, SIAM J. Sci. Comput. 15, 1243";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        let mut y = [0.0; 20];
        (y[1], y[3], y[6], y[7], y[8], y[16]) = (0.2, 0.04, 0.1, 0.3, 0.01, 0.007);
        y
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 60.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        *dy = gains(&rates(y));
    }
    /// Each rate being linear in y_j, its derivative is exactly its value at y_j = 1 less that at y_j = 0.
    fn jacobian(&self, _t: f64, y: &Self::Y, mut add: impl FnMut(usize, usize, f64)) {
        for j in 0..20 {
            let (mut with, mut without) = (*y, *y);
            (with[j], without[j]) = (1.0, 0.0);
            let (mut r, r0) = (rates(&with), rates(&without));
            for (r, r0) in r.iter_mut().zip(r0) {
                *r -= r0;
            }
            for (i, gain) in gains(&r).into_iter().enumerate() {
                add(i, j, gain);
            }
        }
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &REFERENCE
    }
    fn scale(&self) -> f64 {
        1e-6
    }
}

/// [`Pollution`] at t = 60.
const REFERENCE: [&str; 20] = [
    "0.056462554800227695252",
    "0.13424841304223386055",
    "4.139734331099426888e-9",
    "0.0055231402074843591906",
    "2.0189772623021959901e-7",
    "1.464541863493965775e-7",
    "0.077842491189979645994",
    "0.32450753533960181176",
    "0.007494013383880405733",
    "1.6222931573015602575e-8",
    "1.1358638332570747604e-8",
    "0.0022305059757213598885",
    "0.00020871628827986300866",
    "1.3969210168401578032e-5",
    "0.0089648848568982944553",
    "4.3528463693301030416e-18",
    "0.0068992196962634055492",
    "0.00010078030373659459649",
    "1.7721465139699842146e-6",
    "5.6829432923163924635e-5",
];
