//! The laws of stencils in exact rationals, by their definition: polynomials have their exact slope. Nothing is
//! taken apart into rows as the library does it.

use super::exact::{Number, Rational, evaluate, integer, nearest};
use super::{files_under, text};
use kutta::normals::{Stencil, Taps, stencils};

/// Offsets and weights.
type Row = Vec<(i64, Rational)>;

struct File {
    path: String,
    order: usize,
    isotropic: usize,
    at: Rational,
    along: Row,
    across: Row,
    left: Row,
}

impl File {
    fn parse(path: &str, text: &str) -> Self {
        let table: toml::Table = text.parse().unwrap_or_else(|e| panic!("{path}: {e}"));
        let whole = |key: &str| table.get(key).map_or(0, |n| n.as_integer().unwrap() as usize);
        assert_eq!(whole("digits"), 0, "{path}: the stencils are exact");
        let row = |key: &str| -> Row {
            let Some(grid) = table.get(key) else { return vec![(0, integer(1))] };
            let tap = |line: &str| {
                let (offset, weight) = line.split_once('|').unwrap();
                (offset.trim().parse().unwrap(), evaluate(weight.trim()).unwrap())
            };
            grid.as_str().unwrap().lines().map(tap).collect()
        };
        Self {
            path: path.to_string(),
            order: whole("order"),
            isotropic: whole("isotropic"),
            at: table.get("at").map_or(integer(0), |at| {
                let text = at.as_str().unwrap();
                let (sign, text) = text.strip_prefix('-').map_or((1, text), |rest| (-1, rest));
                evaluate(text).unwrap() * integer(sign)
            }),
            along: row("stencil"),
            across: row("smooth"),
            left: row("left"),
        }
    }

    /// What the stencil makes of x^p y^q about the place where it lives, less what it should: the sum of the left
    /// side's weights times the slope at their own places.
    fn miss(&self, p: usize, q: usize) -> Rational {
        let power = |x: &Rational, n: usize| (0..n).fold(integer(1), |power, _| power * x);
        let mut miss = integer(0);
        for (i, along) in &self.along {
            for (j, across) in &self.across {
                let x = integer(*i) - &self.at;
                miss += along * across * power(&x, p) * power(&integer(*j), q);
            }
        }
        if p > 0 && q == 0 {
            for (i, weight) in &self.left {
                miss -= weight * integer(p as i64) * power(&integer(*i), p - 1);
            }
        }
        miss
    }

    /// All polynomials of this degree have their exact slope.
    fn exact_to_degree(&self, degree: usize) -> bool {
        (0..=degree).all(|q| self.miss(degree - q, q).vanishes())
    }

    /// The terms of this degree in the error of an explicit stencil, sum c_q f_(degree - q, q), are those of
    /// d/dx (d2/dx2 + d2/dy2)^m: c_q = c_0 C(m, q/2).
    fn isotropic_to_degree(&self, degree: usize) -> bool {
        let factorial = |n: usize| (1..=n as i64).fold(integer(1), |f, k| f * integer(k));
        let c = |q: usize| self.miss(degree - q, q) / factorial(degree - q) / factorial(q);
        let m = degree / 2;
        (0..=degree).all(|q| {
            let even = degree % 2 == 1 && q % 2 == 0;
            let share = match even {
                true => c(0) * factorial(m) / factorial(q / 2) / factorial(m - q / 2),
                false => integer(0),
            };
            c(q) == share
        })
    }

    fn broken(&self) -> Vec<String> {
        let mut broken = vec![];
        for degree in 0..=self.order {
            if !self.exact_to_degree(degree) {
                broken.push(format!("{}: a polynomial of degree {degree} has a wrong slope", self.path));
            }
        }
        if self.exact_to_degree(self.order + 1) {
            broken.push(format!("{}: the order is higher than {}", self.path, self.order));
        }
        let sum: Rational = self.across.iter().map(|(_, weight)| weight).sum();
        if sum != integer(1) {
            broken.push(format!("{}: the smoothing row sums to {sum}", self.path));
        }
        for degree in 2..=self.isotropic + 1 {
            if !self.isotropic_to_degree(degree) {
                broken.push(format!("{}: the error of degree {degree} is not isotropic", self.path));
            }
        }
        let explicit = self.left.len() == 1;
        // Where the leading error is one in h^2 and isotropic, the file should say so; in one variable nothing
        // else could be.
        if self.order == 2 && self.isotropic == 0 && explicit && self.isotropic_to_degree(3) {
            broken.push(format!("{}: its error is isotropic, and it does not claim it", self.path));
        }
        let mirrored = |row: &Row, middle: &Rational, sign: i64| {
            row.iter().all(|(i, weight)| {
                let mirror = middle * integer(2) - integer(*i);
                row.iter().any(|(k, other)| integer(*k) == mirror && *other == weight * integer(sign))
            })
        };
        if !mirrored(&self.across, &integer(0), 1) || !mirrored(&self.left, &integer(0), 1) {
            broken.push(format!("{}: the smoothing row or the left side is not symmetric", self.path));
        }
        let one_sided = self.along[0].0 == 0 && self.along.len() > 2;
        if !one_sided && !mirrored(&self.along, &self.at, -1) {
            broken.push(format!("{}: the weights are not antisymmetric", self.path));
        }
        broken
    }
}

fn paths() -> Vec<String> {
    files_under("tableaus/stencils")
}

#[test]
fn every_stencil_fulfils_its_laws_exactly() {
    let broken: Vec<_> = paths().iter().flat_map(|path| File::parse(path, &text(path)).broken()).collect();
    assert!(broken.is_empty(), "\n{}\n", broken.join("\n"));
}

/// 32 digits are read: the rest rounds to the nearest f64 and f32.
#[test]
fn kutta_reads_every_weight() {
    for path in paths() {
        let text = text(&path);
        let (file, read) = (File::parse(&path, &text), Stencil::parse(&text).unwrap());
        assert_eq!(read.order, file.order, "{path}");
        assert_eq!(nearest(&file.at, false).0, read.at.hi(), "{path}");
        let same = |row: &Row, taps: &Taps| {
            let read: Vec<_> = taps.iter().filter(|(_, weight)| weight.hi() != 0.0).collect();
            assert_eq!(row.len(), read.len(), "{path}");
            for ((offset, weight), (at, tap)) in row.iter().zip(read) {
                assert_eq!(*offset as isize, at, "{path}");
                assert_eq!(nearest(weight, false), (tap.hi(), tap.to_f32()), "{path} at {offset}");
            }
        };
        same(&file.along, &read.along);
        same(&file.across, &read.across);
        same(&file.left, &read.left);
    }
}

#[test]
fn every_file_is_a_stencil_and_every_stencil_a_file() {
    let on_disk = paths();
    let known: Vec<_> = stencils::all().iter().map(|entry| entry.path).collect();
    assert_eq!(known, on_disk);
    for entry in stencils::all() {
        assert_eq!(std::path::Path::new(entry.path).file_stem().unwrap(), entry.name);
        assert_eq!(text(entry.path), entry.text, "{}", entry.path);
        assert_eq!(stencils::find(entry.name).unwrap().path, entry.path);
    }
    assert_eq!(stencils::CENTRAL2.along.weight[2].hi(), 0.5);
}

/// The laws have teeth.
#[test]
fn a_wrong_stencil_is_found() {
    let broken = |text: &str| File::parse("x.toml", text).broken();
    let iso3 = text("tableaus/stencils/iso3.toml");
    for (from, to, law) in [
        (" 1 |  1/2", " 1 |  1/3", "x.toml: a polynomial of degree 0 has a wrong slope"),
        ("order     = 2", "order     = 3", "x.toml: a polynomial of degree 3 has a wrong slope"),
        ("order     = 2", "order     = 1", "x.toml: the order is higher than 1"),
        (" 0 | 2/3\n 1 | 1/6", " 0 | 1/2\n 1 | 1/3", "x.toml: a polynomial of degree 2 has a wrong slope"),
        (
            "1/6\n 0 | 2/3\n 1 | 1/6",
            "1/4\n 0 | 1/2\n 1 | 1/4",
            "x.toml: the error of degree 3 is not isotropic",
        ),
        ("isotropic = 2", "", "x.toml: its error is isotropic, and it does not claim it"),
    ] {
        assert_eq!(iso3.matches(from).count(), 1, "{from}");
        assert_eq!(broken(&iso3.replace(from, to)).first().map(String::as_str), Some(law), "{to}");
    }
}
