//! The guard's own reader: the `toml` crate, then grids split at bars and blanks.

use super::exact::{Rational, evaluate, integer};

pub type Row = Vec<Rational>;
pub type Matrix = Vec<Row>;

pub struct File {
    /// As the registry writes it: `tableaus/explicit/rk4.toml`.
    pub path: String,
    pub text: String,
    pub order: usize,
    pub embedded: Vec<usize>,
    pub dense_order: usize,
    /// Correct decimals of the entries; 0 where they are exact values.
    pub digits: usize,
    /// Some entry is a square or cube root, cut at 120 digits.
    pub surds: bool,
    pub scheme: Scheme,
}

pub enum Scheme {
    RungeKutta(Array),
    /// Explicit and implicit array of y' = f + g.
    Imex([Array; 2]),
    /// Arrays of position and velocity.
    Partitioned([Array; 2]),
    Rosenbrock {
        alpha: Array,
        gamma: Matrix,
        /// The file prints transformed variables.
        converted: bool,
    },
    Multistep(Steps),
    /// Formulas of order 1, 2, ..
    Nordsieck(Vec<Steps>),
    Stormer(Steps),
    PredictorCorrector {
        predictor: Steps,
        corrector: Steps,
        evaluates: bool,
    },
    Nystrom {
        array: Array,
        bbar: Row,
    },
    /// Whether a part is a kick, and its weight.
    Splitting(Vec<(bool, Rational)>),
}

/// `a` and `c` hold the extra stages of the dense output after the `stages` of the step.
pub struct Array {
    pub stages: usize,
    pub c: Row,
    pub a: Matrix,
    pub b: Row,
    pub bhat: Matrix,
    /// Weights of each stage at theta, theta^2, ..; empty where there is no dense output.
    pub dense: Matrix,
}

pub struct Steps {
    pub alpha: Row,
    pub beta: Row,
}

impl File {
    pub fn parse(path: &str, text: &str) -> Self {
        let table: toml::Table = text.parse().unwrap_or_else(|e| panic!("{path}: {e}"));
        let keys = Keys { path, table: &table };
        let embedded = match table.get("embedded") {
            None => Vec::new(),
            Some(toml::Value::Array(orders)) => {
                orders.iter().map(|n| n.as_integer().unwrap() as usize).collect()
            }
            Some(_) => vec![keys.integer("embedded")],
        };
        let surd = |text: &str| text.contains("sqrt(") || text.contains("cbrt(");
        Self {
            path: path.to_string(),
            text: text.to_string(),
            order: keys.integer("order"),
            embedded,
            dense_order: keys.integer("dense_order"),
            digits: keys.integer("digits"),
            surds: table.values().filter_map(|v| v.as_str()).any(surd),
            scheme: keys.scheme(),
        }
    }

    /// Every law can and must hold without any residual.
    pub fn exact(&self) -> bool {
        self.digits == 0 && !self.surds
    }

    pub fn tolerance(&self) -> f64 {
        match self.digits {
            0 if self.surds => 1e-60,
            0 => 0.0,
            n => 10f64.powi(-(n as i32)),
        }
    }
}

struct Keys<'a> {
    path: &'a str,
    table: &'a toml::Table,
}

/// What stands before the bar, and the entries after it.
type Line<'a> = (&'a str, Row);

impl<'a> Keys<'a> {
    fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// 0 where the key is missing.
    fn integer(&self, key: &str) -> usize {
        self.table.get(key).map_or(0, |n| n.as_integer().unwrap() as usize)
    }

    fn lines(&self, key: &str) -> impl Iterator<Item = &'a str> {
        let value = self.table.get(key).unwrap_or_else(|| panic!("{}: no {key}", self.path));
        value.as_str().unwrap().lines().filter(|line| !line.trim().is_empty())
    }

    fn value(&self, entry: &str) -> Rational {
        evaluate(entry).unwrap_or_else(|| panic!("{}: {entry:?} is not a number", self.path))
    }

    /// Lines above and below the rule.
    fn grid(&self, key: &str) -> [Vec<Line<'a>>; 2] {
        let mut halves = [Vec::new(), Vec::new()];
        let mut half = 0;
        for line in self.lines(key) {
            if line.trim().chars().all(|c| c == '-' || c == '+') {
                half += 1;
                continue;
            }
            let (label, entries) = line.split_once('|').unwrap_or(("", line));
            halves[half].push((label.trim(), entries.split_whitespace().map(|e| self.value(e)).collect()));
        }
        halves
    }

    /// A grid without a rule, every row continued by zeros; no row at all where the key is missing.
    fn rows(&self, key: &str, columns: usize) -> Matrix {
        if !self.has(key) {
            return Vec::new();
        }
        let [above, below] = self.grid(key);
        assert!(below.is_empty(), "{}: {key} takes no rule", self.path);
        above.into_iter().map(|(_, row)| self.padded(row, columns)).collect()
    }

    fn padded(&self, mut row: Row, columns: usize) -> Row {
        assert!(row.len() <= columns, "{}: {} entries where {columns} fit", self.path, row.len());
        row.resize(columns, integer(0));
        row
    }

    fn array(&self, key: &str) -> Array {
        let [mut above, below] = self.grid(key);
        let stages = above.len();
        if self.has("dense_stages") {
            above.append(&mut self.grid("dense_stages")[0]);
        }
        let total = above.len();
        let mut weights = below.into_iter().map(|(_, row)| self.padded(row, total));
        let b = weights.next().unwrap_or_else(|| panic!("{}: {key} has no weights", self.path));
        let bhat = weights.collect();
        // A Rosenbrock array prints no c: it is the sum of the row of alpha.
        let sum = |row: &Row| row.iter().sum::<Rational>();
        let c = above.iter().map(|(c, row)| if c.is_empty() { sum(row) } else { self.value(c) }).collect();
        let a = above.into_iter().map(|(_, row)| self.padded(row, total)).collect();
        Array { stages, c, a, b, bhat, dense: Vec::new() }
    }

    fn steps(&self, key: &str) -> Steps {
        let [rows, _] = self.grid(key);
        let Ok([("alpha", alpha), ("beta", beta)]) = <[Line; 2]>::try_from(rows) else {
            panic!("{}: {key} has the rows alpha and beta", self.path)
        };
        assert_eq!(alpha.len(), beta.len(), "{}: {key}", self.path);
        Steps { alpha, beta }
    }

    fn scheme(&self) -> Scheme {
        if self.has("tableau") {
            let mut array = self.array("tableau");
            if self.has("dense") {
                let powers = self.grid("dense")[0].iter().map(|(_, row)| row.len()).max();
                array.dense = self.rows("dense", powers.unwrap());
                assert_eq!(array.dense.len(), array.a.len(), "{}: a row of dense for each stage", self.path);
            }
            Scheme::RungeKutta(array)
        } else if self.has("explicit") {
            Scheme::Imex(["explicit", "implicit"].map(|key| self.array(key)))
        } else if self.has("position") {
            Scheme::Partitioned(["position", "velocity"].map(|key| self.array(key)))
        } else if self.has("alpha") {
            let alpha = self.array("alpha");
            let gamma = self.rows("gamma", alpha.stages);
            assert_eq!(gamma.len(), alpha.stages, "{}: rows of gamma", self.path);
            Scheme::Rosenbrock { alpha, gamma, converted: false }
        } else if self.has("gamma") {
            self.transformed()
        } else if self.has("multistep") {
            Scheme::Multistep(self.steps("multistep"))
        } else if self.has("nordsieck") {
            let [rows, _] = self.grid("nordsieck");
            let member = |rows: &[Line]| match rows {
                [("alpha", alpha), ("beta", beta)] => Steps { alpha: alpha.clone(), beta: beta.clone() },
                _ => panic!("{}: members have the rows alpha and beta", self.path),
            };
            Scheme::Nordsieck(rows.chunks(2).map(member).collect())
        } else if self.has("stormer") {
            Scheme::Stormer(self.steps("stormer"))
        } else if self.has("predictor") {
            let mode = self.table["mode"].as_str();
            assert!(mode == Some("PECE") || mode == Some("PEC"), "{}: mode", self.path);
            let [predictor, corrector] = ["predictor", "corrector"].map(|key| self.steps(key));
            Scheme::PredictorCorrector { predictor, corrector, evaluates: mode == Some("PECE") }
        } else if self.has("nystrom") {
            let labels: Vec<_> = self.grid("nystrom")[1].iter().map(|(label, _)| *label).collect();
            assert_eq!(labels, ["y", "v"], "{}: rows of weights", self.path);
            let mut array = self.array("nystrom");
            let bbar = std::mem::replace(&mut array.b, array.bhat.remove(0));
            Scheme::Nystrom { array, bbar }
        } else {
            let part = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
                ["drift", w] => (false, self.value(w)),
                ["kick", w] => (true, self.value(w)),
                _ => panic!("{}: {line:?} is neither a drift nor a kick", self.path),
            };
            Scheme::Splitting(self.lines("splitting").map(part).collect())
        }
    }

    /// The published variables are U = Gamma k (Hairer, Wanner II, (IV.7.25)), so
    /// Gamma = (diag(1/g) - C)^-1, alpha = A Gamma, b = m Gamma.
    fn transformed(&self) -> Scheme {
        let mut array = self.array("a");
        let s = array.stages;
        let g = &self.rows("gamma", 1)[0][0];
        let c = self.rows("c", s);
        // Row i of (1 - g C) Gamma = g reads Gamma_i = g (e_i + sum_j c_ij Gamma_j).
        let mut gamma: Matrix = Vec::new();
        for i in 0..s {
            let mut row = product(&c[i][..i], &gamma, s);
            row[i] += integer(1);
            gamma.push(row.iter().map(|x| x * g).collect());
        }
        // y(theta) = y + theta (m U + (1 - theta) (H_1 U + theta H_2 U + ..)).
        let h = self.rows("dense", s);
        if !h.is_empty() {
            // theta^1 has m + H_1, theta^2 has H_2 - H_1, .., the last one - H_k.
            let zero = vec![integer(0); s];
            let minus: Matrix = h.iter().map(|row| row.iter().map(|x| -x).collect()).collect();
            let sum = |(x, y): (&Row, &Row)| {
                product(&x.iter().zip(y).map(|(x, y)| x + y).collect::<Row>(), &gamma, s)
            };
            let powers: Matrix =
                [&array.b].into_iter().chain(&minus).zip(h.iter().chain([&zero])).map(sum).collect();
            array.dense = (0..s).map(|i| powers.iter().map(|row| row[i].clone()).collect()).collect();
        }
        for row in array.a.iter_mut().chain([&mut array.b]).chain(&mut array.bhat) {
            *row = product(row, &gamma, s);
        }
        array.c = array.a.iter().map(|row| row.iter().sum()).collect();
        Scheme::Rosenbrock { alpha: array, gamma, converted: true }
    }
}

fn product(row: &[Rational], matrix: &[Row], columns: usize) -> Row {
    (0..columns).map(|j| row.iter().zip(matrix).map(|(x, m)| x * &m[j]).sum()).collect()
}
