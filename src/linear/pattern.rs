//! Where a matrix can be other than zero, and how its entries are stored.

use std::fmt;
use std::ops::Range;

/// The entries of df/dy that can be other than zero: all, those of a band, or single ones.
///
/// ```
/// use kutta::Pattern;
///
/// // df_i/dy_j of a chain: each component sees its neighbours.
/// let chain = Pattern::banded(1000, 1, 1);
/// assert!(chain.contains(4, 5) && !chain.contains(4, 6));
/// // An arrow: the first row, the first column, the diagonal.
/// let places = (0..1000).flat_map(|i| [(0, i), (i, 0), (i, i)]);
/// assert_eq!(Pattern::of(1000, places)?.entries(), 2998);
/// # Ok::<(), kutta::Misplaced>(())
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Pattern {
    n: usize,
    shape: Shape,
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Shape {
    Dense,
    /// Column after column from `upper` above the diagonal to `lower` below it, and above those the `lower` more
    /// that exchanges of rows fill.
    Banded {
        lower: usize,
        upper: usize,
    },
    /// Column j holds the ascending `rows[starts[j] .. starts[j + 1]]`.
    Sparse {
        starts: Vec<usize>,
        rows: Vec<usize>,
    },
}

/// An entry outside the matrix.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Misplaced {
    pub row: usize,
    pub column: usize,
    pub n: usize,
}

impl fmt::Display for Misplaced {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { row, column, n } = self;
        write!(f, "the entry ({row}, {column}) is outside a matrix of {n} rows and columns, counted from 0")
    }
}

impl std::error::Error for Misplaced {}

/// Matrices of fewer rows are dense: there is nothing to save.
const SMALL: usize = 12;

impl Pattern {
    /// All n * n entries.
    pub fn dense(n: usize) -> Self {
        Self { n, shape: Shape::Dense }
    }

    /// `lower` diagonals below the main one and `upper` above it.
    pub fn banded(n: usize, lower: usize, upper: usize) -> Self {
        let most = n.saturating_sub(1);
        Self { n, shape: Shape::Banded { lower: lower.min(most), upper: upper.min(most) } }
    }

    /// The entries (row, column), in any order, and the diagonal: stored as a band where it is narrow (with
    /// what pivoting adds, an eighth of the matrix), one by one where at most a quarter can be other than zero,
    /// else all.
    ///
    /// # Errors
    /// The first entry outside the matrix.
    pub fn of(n: usize, places: impl IntoIterator<Item = (usize, usize)>) -> Result<Self, Misplaced> {
        let sparse = Self::sparse(n, places)?;
        let (lower, upper) = sparse.band();
        Ok(if n < SMALL {
            Self::dense(n)
        } else if 8 * (2 * lower + upper + 1) <= n {
            Self::banded(n, lower, upper)
        } else if 4 * sparse.entries() <= n * n {
            sparse
        } else {
            Self::dense(n)
        })
    }

    /// The entries (row, column), in any order, and the diagonal, stored one by one.
    ///
    /// # Errors
    /// The first entry outside the matrix.
    pub fn sparse(n: usize, places: impl IntoIterator<Item = (usize, usize)>) -> Result<Self, Misplaced> {
        let mut all: Vec<(usize, usize)> = (0..n).map(|i| (i, i)).collect();
        for (row, column) in places {
            if row >= n || column >= n {
                return Err(Misplaced { row, column, n });
            }
            all.push((column, row));
        }
        all.sort_unstable();
        all.dedup();
        let mut starts = vec![0; n + 1];
        all.iter().for_each(|&(column, _)| starts[column + 1] += 1);
        (0..n).for_each(|j| starts[j + 1] += starts[j]);
        let rows = all.into_iter().map(|(_, row)| row).collect();
        Ok(Self { n, shape: Shape::Sparse { starts, rows } })
    }

    /// The number of rows, and of columns.
    pub fn n(&self) -> usize {
        self.n
    }

    /// How many entries can be other than zero.
    pub fn entries(&self) -> usize {
        (0..self.n).map(|j| self.column(j).len()).sum()
    }

    /// Diagonals below and above the main one that can be other than zero.
    pub fn band(&self) -> (usize, usize) {
        match &self.shape {
            Shape::Dense => (self.n.saturating_sub(1), self.n.saturating_sub(1)),
            Shape::Banded { lower, upper } => (*lower, *upper),
            Shape::Sparse { starts, rows } => {
                let (mut lower, mut upper) = (0, 0);
                for (j, range) in starts.windows(2).enumerate() {
                    for &i in &rows[range[0]..range[1]] {
                        lower = lower.max(i.saturating_sub(j));
                        upper = upper.max(j.saturating_sub(i));
                    }
                }
                (lower, upper)
            }
        }
    }

    pub fn contains(&self, row: usize, column: usize) -> bool {
        self.place(row, column).is_some()
    }

    /// The rows of column j, ascending.
    pub fn column(&self, j: usize) -> impl ExactSizeIterator<Item = usize> + '_ {
        let (first, rows, len) = match &self.shape {
            Shape::Dense => (0, None, self.n),
            Shape::Banded { lower, upper } => {
                let first = j.saturating_sub(*upper);
                (first, None, (j + lower + 1).min(self.n) - first)
            }
            Shape::Sparse { starts, rows } => {
                let rows = &rows[starts[j]..starts[j + 1]];
                (0, Some(rows), rows.len())
            }
        };
        (0..len).map(move |k| rows.map_or(first + k, |rows| rows[k]))
    }

    /// The same entries and these, which lie inside.
    pub(crate) fn with(&self, places: impl Iterator<Item = (usize, usize)> + Clone) -> Self {
        if places.clone().all(|(i, j)| self.contains(i, j)) {
            return self.clone();
        }
        match &self.shape {
            Shape::Dense => self.clone(),
            Shape::Banded { lower, upper } => {
                let wider = |(l, u): (usize, usize), (i, j): (usize, usize)| {
                    (l.max(i.saturating_sub(j)), u.max(j.saturating_sub(i)))
                };
                let (lower, upper) = places.fold((*lower, *upper), wider);
                Self::banded(self.n, lower, upper)
            }
            Shape::Sparse { .. } => {
                let own = (0..self.n).flat_map(|j| self.column(j).map(move |i| (i, j)));
                Self::sparse(self.n, own.chain(places)).unwrap_or_else(|_| Self::dense(self.n))
            }
        }
    }

    /// The band around all entries.
    pub(crate) fn as_band(&self) -> Self {
        let (lower, upper) = self.band();
        Self::banded(self.n, lower, upper)
    }

    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// How many numbers are stored.
    pub(crate) fn stored(&self) -> usize {
        match &self.shape {
            Shape::Dense => self.n * self.n,
            Shape::Banded { lower, upper } => (2 * lower + upper + 1) * self.n,
            Shape::Sparse { rows, .. } => rows.len(),
        }
    }

    /// Where the entry is stored, if it can be other than zero.
    #[inline(always)]
    pub(crate) fn place(&self, row: usize, column: usize) -> Option<usize> {
        if row >= self.n || column >= self.n {
            return None;
        }
        match &self.shape {
            Shape::Dense => Some(row + column * self.n),
            Shape::Banded { lower, upper } => {
                // Beyond the band it wraps round, or is too large.
                let down = (row + upper).wrapping_sub(column);
                (down <= lower + upper).then(|| (2 * lower + upper + 1) * column + lower + down)
            }
            Shape::Sparse { starts, rows } => {
                let found = rows[starts[column]..starts[column + 1]].binary_search(&row);
                found.ok().map(|k| starts[column] + k)
            }
        }
    }

    /// The stored entries of a column that stand below each other: the row of the first, and their places.
    pub(crate) fn runs(&self, j: usize) -> impl Iterator<Item = (usize, Range<usize>)> {
        let n = self.n;
        let (one, many) = match &self.shape {
            Shape::Dense => (Some((0, j * n..(j + 1) * n)), None),
            Shape::Banded { lower, upper } => {
                let (first, end) = (j.saturating_sub(*upper), (j + lower + 1).min(n));
                let from = (2 * lower + upper + 1) * j + lower + upper + first - j;
                (Some((first, from..from + end - first)), None)
            }
            Shape::Sparse { starts, rows } => {
                let places = starts[j]..starts[j + 1];
                (None, Some(places.clone().zip(&rows[places]).map(|(at, &row)| (row, at..at + 1))))
            }
        };
        one.into_iter().chain(many.into_iter().flatten())
    }

    /// The row of a stored entry.
    pub(crate) fn row_at(&self, place: usize) -> usize {
        match &self.shape {
            Shape::Dense => place % self.n,
            Shape::Banded { lower, upper } => {
                let stride = 2 * lower + upper + 1;
                (place / stride + place % stride).saturating_sub(lower + upper)
            }
            Shape::Sparse { rows, .. } => rows[place],
        }
    }

    /// Columns of which no two share a row, group by group: one difference of f serves a group (Curtis, Powell,
    /// Reid 1974, J. Inst. Math. Appl. 13, 117). Each column goes to the first group that has room.
    pub(crate) fn groups(&self) -> Vec<Vec<usize>> {
        match &self.shape {
            Shape::Dense => (0..self.n).map(|j| vec![j]).collect(),
            Shape::Banded { lower, upper } => {
                let width = (lower + upper + 1).min(self.n);
                (0..width).map(|first| (first..self.n).step_by(width).collect()).collect()
            }
            Shape::Sparse { starts, rows } => {
                let mut by_row: Vec<Vec<usize>> = vec![vec![]; self.n];
                let (mut group_of, mut groups) = (vec![usize::MAX; self.n], Vec::<Vec<usize>>::new());
                // The columns that last excluded a group.
                let mut excluded: Vec<usize> = vec![];
                for j in 0..self.n {
                    let own = &rows[starts[j]..starts[j + 1]];
                    for &other in own.iter().flat_map(|&i| &by_row[i]) {
                        excluded[group_of[other]] = j;
                    }
                    let free = excluded.iter().position(|&by| by != j).unwrap_or(groups.len());
                    if free == groups.len() {
                        groups.push(vec![]);
                        excluded.push(usize::MAX);
                    }
                    groups[free].push(j);
                    group_of[j] = free;
                    own.iter().for_each(|&i| by_row[i].push(j));
                }
                groups
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_columns_of_a_group_share_a_row() {
        let arrow = Pattern::sparse(20, (0..20).flat_map(|i| [(0, i), (i, 0)])).unwrap();
        let star =
            Pattern::sparse(30, (0..30).flat_map(|i| [(i, (7 * i) % 30), (i, (i + 11) % 30)])).unwrap();
        for pattern in [Pattern::banded(17, 2, 1), Pattern::dense(4), arrow, star] {
            let groups = pattern.groups();
            let mut columns: Vec<usize> = groups.concat();
            columns.sort_unstable();
            assert_eq!(columns, (0..pattern.n()).collect::<Vec<_>>());
            for group in groups {
                let mut rows: Vec<usize> = group.iter().flat_map(|&j| pattern.column(j)).collect();
                let count = rows.len();
                rows.sort_unstable();
                rows.dedup();
                assert_eq!(rows.len(), count);
            }
        }
    }

    #[test]
    fn a_place_knows_its_row() {
        let patterns = [
            Pattern::dense(5),
            Pattern::banded(9, 2, 1),
            Pattern::sparse(6, [(0, 5), (5, 0), (2, 4)]).unwrap(),
        ];
        for pattern in patterns {
            let mut seen = 0;
            for j in 0..pattern.n() {
                for i in 0..pattern.n() {
                    if let Some(place) = pattern.place(i, j) {
                        assert!(pattern.row_at(place) == i && place < pattern.stored());
                        seen += 1;
                    }
                }
            }
            assert_eq!(seen, pattern.entries());
        }
    }
}
