//! What kutta read, number by number, against the exact values.

use kutta::tableau::{self, DoubleDouble, Tableau};

use super::exact::{Number, Rational, integer, nearest};
use super::file::{Array, File, Row, Scheme, Steps};
use super::report::Report;

pub fn check(file: &File, report: &mut Report) {
    let tableau = match Tableau::parse(&file.text) {
        Ok(tableau) => tableau,
        Err(error) => return report.say(format!("kutta refuses it: {error}")),
    };
    let mut embedded = file.embedded.clone();
    embedded.resize(2, 0);
    let claims = (tableau.order, tableau.embedded.to_vec(), tableau.dense_order, tableau.digits);
    if claims != (file.order, embedded, file.dense_order, file.digits) {
        report.say(format!("kutta reads the claims {claims:?}"));
    }
    let mut bits = Bits { file, report };
    use tableau::Scheme as Read;
    match (&file.scheme, &tableau.scheme) {
        (Scheme::RungeKutta(array), Read::RungeKutta(read)) => bits.array("", array, read),
        (Scheme::Imex([f, g]), Read::Imex { explicit, implicit }) => {
            bits.array("explicit ", f, explicit);
            bits.array("implicit ", g, implicit);
        }
        (Scheme::Partitioned([q, p]), Read::Partitioned { position, velocity }) => {
            bits.array("position ", q, position);
            bits.array("velocity ", p, velocity);
        }
        (Scheme::Rosenbrock { alpha, gamma, .. }, Read::Rosenbrock { alpha: read, gamma: read_gamma }) => {
            bits.array("alpha ", alpha, read);
            bits.rows("gamma", gamma, &read_gamma.a);
        }
        (Scheme::Multistep(steps), Read::Multistep(read)) => bits.steps("", steps, read),
        (Scheme::Nordsieck(members), Read::Nordsieck(read)) => {
            bits.shape("members", members.len(), read.count);
            for (q, (steps, read)) in members.iter().zip(&read.steps).enumerate() {
                bits.steps(&format!("member {}, ", q + 1), steps, read);
            }
        }
        (Scheme::Stormer(steps), Read::Stormer(read)) => bits.steps("", steps, read),
        (
            Scheme::PredictorCorrector { predictor: p, corrector: c, evaluates: e },
            Read::PredictorCorrector { predictor, corrector, evaluates },
        ) => {
            bits.steps("predictor ", p, predictor);
            bits.steps("corrector ", c, corrector);
            bits.shape("mode", *e as usize, *evaluates as usize);
        }
        (Scheme::Nystrom { array, bbar }, Read::Nystrom { array: read, bbar: read_bbar }) => {
            bits.array("", array, read);
            bits.row("weights of y", bbar, read_bbar);
        }
        (Scheme::Splitting(parts), Read::Splitting(read)) => {
            bits.shape("parts", parts.len(), read.len);
            for (i, (kick, _)) in parts.iter().enumerate() {
                bits.shape("kicks", *kick as usize, read.kick[i] as usize);
            }
            let weights: Row = parts.iter().map(|(_, w)| w.clone()).collect();
            bits.row("weights", &weights, &read.weight);
        }
        _ => report.say("kutta reads another family".to_string()),
    }
}

struct Bits<'a, 'f> {
    file: &'a File,
    report: &'a mut Report<'f>,
}

impl Bits<'_, '_> {
    fn shape(&mut self, what: &str, wanted: usize, read: usize) {
        if wanted != read {
            self.report.say(format!("kutta reads {read} {what}, not {wanted}"));
        }
    }

    /// Entries of a row; where the exact one ends, zeros.
    fn row(&mut self, name: &str, exact: &[Rational], read: &[DoubleDouble]) {
        let zero = integer(0);
        for (j, read) in read.iter().enumerate() {
            let x = exact.get(j).unwrap_or(&zero);
            let (f64, f32) = nearest(x, self.file.surds);
            let same = read.hi().to_bits() == f64.to_bits() && read.to_f32().to_bits() == f32.to_bits();
            if !same && !self.noise(x, read) {
                self.report.say(format!(
                    "{name}, entry {}: kutta has {:e} as f64, {:e} as f32; the nearest are {f64:e}, {f32:e}",
                    j + 1,
                    read.hi(),
                    read.to_f32()
                ));
            }
        }
    }

    /// Only a converted Rosenbrock array is computed from its entries. What is left there where they cancel
    /// lies below the digits of the file, and cannot have more of them than the terms have.
    fn noise(&self, exact: &Rational, read: &DoubleDouble) -> bool {
        let converted = matches!(self.file.scheme, Scheme::Rosenbrock { converted: true, .. });
        let off = exact - Rational::from_float(read.hi()).unwrap();
        converted && exact.size() < self.file.tolerance() && off.size() < 1e-28
    }

    fn rows<const N: usize>(&mut self, name: &str, exact: &[Row], read: &[[DoubleDouble; N]]) {
        for (i, read) in read.iter().enumerate() {
            self.row(&format!("{name}, row {}", i + 1), exact.get(i).map_or(&[], |row| row), read);
        }
    }

    fn array(&mut self, name: &str, exact: &Array, read: &tableau::Array) {
        self.shape("stages", exact.stages, read.stages);
        self.shape("extra stages", exact.a.len() - exact.stages, read.extra);
        self.shape("embedded rows", exact.bhat.len(), read.lower);
        self.shape("powers of theta", exact.dense.first().map_or(0, Vec::len), read.powers);
        self.row(&format!("{name}c"), &exact.c, &read.c);
        self.rows(&format!("{name}A"), &exact.a, &read.a);
        self.row(&format!("{name}b"), &exact.b, &read.b);
        self.rows(&format!("{name}bhat"), &exact.bhat, &read.bhat);
        self.rows(&format!("{name}dense"), &exact.dense, &read.dense);
    }

    fn steps(&mut self, name: &str, exact: &Steps, read: &tableau::Steps) {
        self.shape("steps", exact.alpha.len() - 1, read.k);
        self.row(&format!("{name}alpha"), &exact.alpha, &read.alpha);
        self.row(&format!("{name}beta"), &exact.beta, &read.beta);
    }
}
