//! Factors by faer, of the numbers it knows: dense, and sparse with its symbolic analysis done once.

use super::pattern::{Pattern, Shape};
use super::{Pair, large::Factorize};
use crate::step::scalar::Scalar;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::traits::ComplexField;
use faer::{Conj, Mat, MatMut, Par};
use num_complex::Complex;
use std::any::{Any, TypeId};
use std::sync::Arc;

/// A number that faer knows under this or another name.
trait Known: Scalar {
    type Faer: ComplexField + Copy;
    fn to_faer(self) -> Self::Faer;
    fn from_faer(x: Self::Faer) -> Self;
    /// Not generic, so that faer is compiled here and not in every crate that solves.
    fn room(pattern: &Arc<Pattern>) -> Option<Box<dyn Factorize<Self>>>;
}

macro_rules! known {
    ($t:ty, $faer:ty, $x:ident => $to:expr, $from:expr) => {
        impl Known for $t {
            type Faer = $faer;
            #[inline(always)]
            fn to_faer(self) -> $faer {
                let $x = self;
                $to
            }
            #[inline(always)]
            fn from_faer($x: $faer) -> Self {
                $from
            }
            fn room(pattern: &Arc<Pattern>) -> Option<Box<dyn Factorize<Self>>> {
                room_of::<Self>(pattern)
            }
        }
    };
}
known!(f64, f64, x => x, x);
known!(f32, f32, x => x, x);
known!(Complex<f64>, Complex<f64>, x => x, x);
known!(Complex<f32>, Complex<f32>, x => x, x);
known!(Pair<f64>, Complex<f64>, x => Complex::new(x.re, x.im), Pair { re: x.re, im: x.im });
known!(Pair<f32>, Complex<f32>, x => Complex::new(x.re, x.im), Pair { re: x.re, im: x.im });

/// faer knows these numbers.
pub fn knows<T: Scalar>() -> bool {
    [
        TypeId::of::<f64>(),
        TypeId::of::<f32>(),
        TypeId::of::<Complex<f64>>(),
        TypeId::of::<Complex<f32>>(),
        TypeId::of::<Pair<f64>>(),
        TypeId::of::<Pair<f32>>(),
    ]
    .contains(&TypeId::of::<T>())
}

/// Room for the factors of a dense or sparse matrix; `None` where faer does not know the numbers, or has no memory.
pub fn room<T: Scalar>(pattern: &Arc<Pattern>) -> Option<Box<dyn Factorize<T>>> {
    fn of<T: Scalar, K: Known>(pattern: &Arc<Pattern>) -> Option<Box<dyn Factorize<T>>> {
        if TypeId::of::<T>() != TypeId::of::<K>() {
            return None;
        }
        // T is K: the same box under the other name.
        let room: Box<dyn Any> = Box::new(K::room(pattern)?);
        room.downcast::<Box<dyn Factorize<T>>>().ok().map(|room| *room)
    }
    of::<T, f64>(pattern)
        .or_else(|| of::<T, f32>(pattern))
        .or_else(|| of::<T, Complex<f64>>(pattern))
        .or_else(|| of::<T, Complex<f32>>(pattern))
        .or_else(|| of::<T, Pair<f64>>(pattern))
        .or_else(|| of::<T, Pair<f32>>(pattern))
}

fn room_of<K: Known>(pattern: &Arc<Pattern>) -> Option<Box<dyn Factorize<K>>> {
    match pattern.shape() {
        Shape::Sparse { .. } => Some(Box::new(Sparse::<K>::new(pattern)?)),
        _ => Some(Box::new(Dense::<K>::new(pattern.n()))),
    }
}

/// A column of numbers as faer's, and faer's workspace, taken once.
struct Room<K: Known> {
    x: Vec<K::Faer>,
    scratch: MemBuffer,
}

impl<K: Known> Room<K> {
    fn new(n: usize, scratch: StackReq) -> Self {
        Self { x: vec![K::zero().to_faer(); n], scratch: MemBuffer::new(scratch) }
    }

    /// Hands `x` to faer as a column, and takes it back.
    fn solve(&mut self, x: &mut [K], by: impl FnOnce(MatMut<K::Faer>, &mut MemStack)) {
        for (to, &from) in self.x.iter_mut().zip(&*x) {
            *to = from.to_faer();
        }
        let n = self.x.len();
        by(MatMut::from_column_major_slice_mut(&mut self.x, n, 1), MemStack::new(&mut self.scratch));
        for (to, &from) in x.iter_mut().zip(&self.x) {
            *to = K::from_faer(from);
        }
    }
}

struct Dense<K: Known> {
    factors: Mat<K::Faer>,
    rows: Vec<usize>,
    places: Vec<usize>,
    room: Room<K>,
}

impl<K: Known> Dense<K> {
    fn new(n: usize) -> Self {
        let scratch = StackReq::any_of(&[
            factor::lu_in_place_scratch::<usize, K::Faer>(n, n, Par::Seq, Default::default()),
            solve::solve_in_place_scratch::<usize, K::Faer>(n, 1, Par::Seq),
        ]);
        let factors = Mat::zeros(n, n);
        Self { factors, rows: vec![0; n], places: vec![0; n], room: Room::new(n, scratch) }
    }
}

impl<K: Known> Factorize<K> for Dense<K> {
    fn factor(&mut self, entries: &[K]) -> Result<(), usize> {
        let n = self.rows.len();
        for (j, column) in entries.chunks_exact(n.max(1)).enumerate() {
            for (i, &entry) in column.iter().enumerate() {
                self.factors[(i, j)] = entry.to_faer();
            }
        }
        factor::lu_in_place(
            self.factors.as_mut(),
            &mut self.rows,
            &mut self.places,
            Par::Seq,
            MemStack::new(&mut self.room.scratch),
            Default::default(),
        );
        // A pivot of zero, or what came of one.
        let bad = |&k: &usize| {
            let pivot = K::from_faer(self.factors[(k, k)]);
            pivot.is_zero() || !pivot.finite()
        };
        (0..n).find(bad).map_or(Ok(()), Err)
    }

    fn solve(&mut self, x: &mut [K]) {
        let n = self.rows.len();
        let rows = PermRef::new_checked(&self.rows, &self.places, n);
        let factors = self.factors.as_ref();
        self.room.solve(x, |x, stack| {
            solve::solve_in_place_with_conj(factors, factors, rows, Conj::No, x, Par::Seq, stack);
        });
    }

    fn again(&self) -> Box<dyn Factorize<K>> {
        let room = Self::new(self.rows.len());
        Box::new(Self {
            factors: self.factors.clone(),
            rows: self.rows.clone(),
            places: self.places.clone(),
            ..room
        })
    }
}

struct Sparse<K: Known> {
    pattern: Arc<Pattern>,
    symbolic: Arc<SymbolicLu<usize>>,
    numeric: NumericLu<usize, K::Faer>,
    values: Vec<K::Faer>,
    probe: Vec<K>,
    room: Room<K>,
}

impl<K: Known> Sparse<K> {
    fn new(pattern: &Arc<Pattern>) -> Option<Self> {
        let symbolic = factorize_symbolic_lu(columns(pattern)?, Default::default()).ok()?;
        Some(Self::analysed(pattern, &Arc::new(symbolic)))
    }

    fn analysed(pattern: &Arc<Pattern>, symbolic: &Arc<SymbolicLu<usize>>) -> Self {
        let n = pattern.n();
        let scratch = StackReq::any_of(&[
            symbolic.factorize_numeric_lu_scratch::<K::Faer>(Par::Seq, Default::default()),
            symbolic.solve_in_place_scratch::<K::Faer>(1, Par::Seq),
        ]);
        Self {
            pattern: pattern.clone(),
            symbolic: symbolic.clone(),
            numeric: NumericLu::new(),
            values: vec![K::zero().to_faer(); pattern.stored()],
            probe: vec![K::one(); n],
            room: Room::new(n, scratch),
        }
    }
}

/// The places of a sparse matrix in faer's words.
fn columns(pattern: &Pattern) -> Option<SymbolicSparseColMatRef<'_, usize>> {
    let Shape::Sparse { starts, rows } = pattern.shape() else { return None };
    Some(SymbolicSparseColMatRef::new_checked(pattern.n(), pattern.n(), starts, None, rows))
}

impl<K: Known> Factorize<K> for Sparse<K> {
    fn factor(&mut self, entries: &[K]) -> Result<(), usize> {
        if let Some(at) = entries.iter().position(|x| !x.finite()) {
            return Err(self.pattern.row_at(at));
        }
        for (to, &from) in self.values.iter_mut().zip(entries) {
            *to = from.to_faer();
        }
        let Some(columns) = columns(&self.pattern) else { return Err(0) };
        let done = self.symbolic.factorize_numeric_lu(
            &mut self.numeric,
            SparseColMatRef::new(columns, &self.values),
            Par::Seq,
            MemStack::new(&mut self.room.scratch),
            Default::default(),
        );
        if let Err(faer::sparse::linalg::LuError::SymbolicSingular { index }) = done {
            return Err(index);
        }
        // faer divides by a pivot of zero: a solution then has no numbers.
        let mut probe = std::mem::take(&mut self.probe);
        probe.fill(K::one());
        self.solve(&mut probe);
        let bad = probe.iter().position(|x| !x.finite());
        self.probe = probe;
        bad.map_or(Ok(()), Err)
    }

    fn solve(&mut self, x: &mut [K]) {
        let factors = LuRef::new_unchecked(&*self.symbolic, &self.numeric);
        self.room.solve(x, |x, stack| {
            factors.solve_in_place_with_conj(Conj::No, x, Par::Seq, stack);
        });
    }

    fn again(&self) -> Box<dyn Factorize<K>> {
        let room = Self::analysed(&self.pattern, &self.symbolic);
        Box::new(Self { numeric: self.numeric.clone(), ..room })
    }
}
