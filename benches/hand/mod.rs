//! Steps written by hand, stage by stage, as one writes them when speed matters: h a once per
//! coefficient, zeros left out, y added last.

/// Lorenz (1963).
pub fn lorenz(_t: f64, y: &[f64; 3], dy: &mut [f64; 3]) {
    dy[0] = 10.0 * (y[1] - y[0]);
    dy[1] = y[0] * (28.0 - y[2]) - y[1];
    dy[2] = y[0] * y[1] - 8.0 / 3.0 * y[2];
}

/// Two coupled oscillators with a cubic spring.
pub fn oscillators(_t: f64, y: &[f64; 4], dy: &mut [f64; 4]) {
    let pull = 0.1 * (y[0] - y[2]);
    dy[0] = y[1];
    dy[1] = -y[0] - 0.2 * y[0] * y[0] * y[0] - pull;
    dy[2] = y[3];
    dy[3] = -2.0 * y[2] - 0.3 * y[2] * y[2] * y[2] + pull;
}

/// `n` steps of a method that keeps nothing but y.
#[inline(always)]
pub fn run<const N: usize, F: Fn(f64, &[f64; N], &mut [f64; N])>(
    step: impl Fn(&F, f64, f64, &[f64; N]) -> [f64; N],
    f: F,
    mut y: [f64; N],
    h: f64,
    n: u64,
) -> [f64; N] {
    for i in 0..n {
        y = step(&f, i as f64 * h, h, &y);
    }
    y
}

/// `n` steps of a method whose last slope is the next one's first.
#[inline(always)]
pub fn run_fsal<const N: usize, F: Fn(f64, &[f64; N], &mut [f64; N])>(
    step: impl Fn(&F, f64, f64, &[f64; N], &[f64; N]) -> ([f64; N], [f64; N]),
    f: F,
    mut y: [f64; N],
    h: f64,
    n: u64,
) -> [f64; N] {
    let mut k = [0.0; N];
    f(0.0, &y, &mut k);
    for i in 0..n {
        (y, k) = step(&f, i as f64 * h, h, &y, &k);
    }
    y
}

#[inline(always)]
fn at<const N: usize>(f: &impl Fn(f64, &[f64; N], &mut [f64; N]), t: f64, y: &[f64; N]) -> [f64; N] {
    let mut k = [0.0; N];
    f(t, y, &mut k);
    k
}

/// Kutta (1901).
#[inline(always)]
pub fn rk4<const N: usize, F: Fn(f64, &[f64; N], &mut [f64; N])>(
    f: &F,
    t: f64,
    h: f64,
    y: &[f64; N],
) -> [f64; N] {
    let half = 0.5 * h;
    let k1 = at(f, t, y);
    let k2 = at(f, t + half, &std::array::from_fn(|i| y[i] + half * k1[i]));
    let k3 = at(f, t + half, &std::array::from_fn(|i| y[i] + half * k2[i]));
    let k4 = at(f, t + h, &std::array::from_fn(|i| y[i] + h * k3[i]));
    let (a, b) = (h / 6.0, h / 3.0);
    std::array::from_fn(|i| y[i] + (a * k1[i] + b * k2[i] + b * k3[i] + a * k4[i]))
}

/// Dormand, Prince (1980), first same as last.
#[inline(always)]
pub fn dp54<const N: usize, F: Fn(f64, &[f64; N], &mut [f64; N])>(
    f: &F,
    t: f64,
    h: f64,
    y: &[f64; N],
    k1: &[f64; N],
) -> ([f64; N], [f64; N]) {
    let k2 = at(f, t + h * 0.2, &std::array::from_fn(|i| y[i] + (h * 0.2 * k1[i])));
    let k3 = at(f, t + h * 0.3, &std::array::from_fn(|i| y[i] + (h * 0.075 * k1[i] + h * 0.225 * k2[i])));
    let k4 = at(
        f,
        t + h * 0.8,
        &std::array::from_fn(|i| {
            y[i] + (h * 0.9777777777777777 * k1[i]
                + h * -3.7333333333333334 * k2[i]
                + h * 3.5555555555555554 * k3[i])
        }),
    );
    let k5 = at(
        f,
        t + h * 0.8888888888888888,
        &std::array::from_fn(|i| {
            y[i] + (h * 2.9525986892242035 * k1[i]
                + h * -11.595793324188385 * k2[i]
                + h * 9.822892851699436 * k3[i]
                + h * -0.2908093278463649 * k4[i])
        }),
    );
    let k6 = at(
        f,
        t + h,
        &std::array::from_fn(|i| {
            y[i] + (h * 2.8462752525252526 * k1[i]
                + h * -10.757575757575758 * k2[i]
                + h * 8.906422717743473 * k3[i]
                + h * 0.2784090909090909 * k4[i]
                + h * -0.2735313036020583 * k5[i])
        }),
    );
    let next: [f64; N] = std::array::from_fn(|i| {
        y[i] + (h * 0.09114583333333333 * k1[i]
            + h * 0.44923629829290207 * k3[i]
            + h * 0.6510416666666666 * k4[i]
            + h * -0.322376179245283 * k5[i]
            + h * 0.13095238095238096 * k6[i])
    });
    let last = at(f, t + h, &next);
    (next, last)
}

/// Dormand and Prince in Hairer, Nørsett, Wanner (1993), the twelve stages of a step.
#[inline(always)]
pub fn dop853<const N: usize, F: Fn(f64, &[f64; N], &mut [f64; N])>(
    f: &F,
    t: f64,
    h: f64,
    y: &[f64; N],
) -> [f64; N] {
    let k1 = at(f, t, y);
    let k2 = at(
        f,
        t + h * 0.05260015195876773,
        &std::array::from_fn(|i| y[i] + (h * 0.05260015195876773 * k1[i])),
    );
    let k3 = at(
        f,
        t + h * 0.0789002279381516,
        &std::array::from_fn(|i| y[i] + (h * 0.0197250569845379 * k1[i] + h * 0.0591751709536137 * k2[i])),
    );
    let k4 = at(
        f,
        t + h * 0.1183503419072274,
        &std::array::from_fn(|i| y[i] + (h * 0.02958758547680685 * k1[i] + h * 0.08876275643042054 * k3[i])),
    );
    let k5 = at(
        f,
        t + h * 0.2816496580927726,
        &std::array::from_fn(|i| {
            y[i] + (h * 0.2413651341592667 * k1[i]
                + h * -0.8845494793282861 * k3[i]
                + h * 0.924834003261792 * k4[i])
        }),
    );
    let k6 = at(
        f,
        t + h * 0.3333333333333333,
        &std::array::from_fn(|i| {
            y[i] + (h * 0.037037037037037035 * k1[i]
                + h * 0.17082860872947386 * k4[i]
                + h * 0.12546768756682242 * k5[i])
        }),
    );
    let k7 = at(
        f,
        t + h * 0.25,
        &std::array::from_fn(|i| {
            y[i] + (h * 0.037109375 * k1[i]
                + h * 0.17025221101954405 * k4[i]
                + h * 0.06021653898045596 * k5[i]
                + h * -0.017578125 * k6[i])
        }),
    );
    let k8 = at(
        f,
        t + h * 0.3076923076923077,
        &std::array::from_fn(|i| {
            y[i] + (h * 0.03709200011850479 * k1[i]
                + h * 0.17038392571223998 * k4[i]
                + h * 0.10726203044637328 * k5[i]
                + h * -0.015319437748624402 * k6[i]
                + h * 0.008273789163814023 * k7[i])
        }),
    );
    let k9 = at(
        f,
        t + h * 0.6512820512820513,
        &std::array::from_fn(|i| {
            y[i] + (h * 0.6241109587160757 * k1[i]
                + h * -3.3608926294469414 * k4[i]
                + h * -0.868219346841726 * k5[i]
                + h * 27.59209969944671 * k6[i]
                + h * 20.154067550477894 * k7[i]
                + h * -43.48988418106996 * k8[i])
        }),
    );
    let k10 = at(
        f,
        t + h * 0.6,
        &std::array::from_fn(|i| {
            y[i] + (h * 0.47766253643826434 * k1[i]
                + h * -2.4881146199716677 * k4[i]
                + h * -0.590290826836843 * k5[i]
                + h * 21.230051448181193 * k6[i]
                + h * 15.279233632882423 * k7[i]
                + h * -33.28821096898486 * k8[i]
                + h * -0.020331201708508627 * k9[i])
        }),
    );
    let k11 = at(
        f,
        t + h * 0.8571428571428571,
        &std::array::from_fn(|i| {
            y[i] + (h * -0.9371424300859873 * k1[i]
                + h * 5.186372428844064 * k4[i]
                + h * 1.0914373489967295 * k5[i]
                + h * -8.149787010746927 * k6[i]
                + h * -18.52006565999696 * k7[i]
                + h * 22.739487099350505 * k8[i]
                + h * 2.4936055526796523 * k9[i]
                + h * -3.0467644718982196 * k10[i])
        }),
    );
    let k12 = at(
        f,
        t + h,
        &std::array::from_fn(|i| {
            y[i] + (h * 2.273310147516538 * k1[i]
                + h * -10.53449546673725 * k4[i]
                + h * -2.0008720582248625 * k5[i]
                + h * -17.9589318631188 * k6[i]
                + h * 27.94888452941996 * k7[i]
                + h * -2.8589982771350235 * k8[i]
                + h * -8.87285693353063 * k9[i]
                + h * 12.360567175794303 * k10[i]
                + h * 0.6433927460157636 * k11[i])
        }),
    );
    std::array::from_fn(|i| {
        y[i] + (h * 0.054293734116568765 * k1[i]
            + h * 4.450312892752409 * k6[i]
            + h * 1.8915178993145003 * k7[i]
            + h * -5.801203960010585 * k8[i]
            + h * 0.3111643669578199 * k9[i]
            + h * -0.1521609496625161 * k10[i]
            + h * 0.20136540080403034 * k11[i]
            + h * 0.04471061572777259 * k12[i])
    })
}
