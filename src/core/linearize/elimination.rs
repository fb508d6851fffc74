//! Sparse linear algebra modulo one prime, and vectors of fractions lifted from there.
//!
//! A rank modulo a prime is at most the rank in true numbers, so that a kernel modulo the prime is never too
//! small. A vector of it becomes one of fractions digit by digit in base p (Dixon, "Exact solution of linear
//! equations using p-adic expansions", Numer. Math. 40 (1982) 137): each digit is one solution modulo p with the
//! rows as they were eliminated. What comes out is multiplied by the matrix in whole numbers, and only where
//! that gives exactly 0 it is a vector of the kernel.

use std::collections::{BTreeMap, BTreeSet};

use dashu_int::ops::{Gcd, UnsignedAbs};
use dashu_int::{IBig, UBig};

use crate::expr::{ExprId, PRIME, Pool, add_mod, inverse_mod, mul_mod, neg_mod, rational_reconstruct, sub_mod};
use crate::number::Number;
use crate::order::Gather;

/// Beyond this many elementary steps an elimination is given up.
pub(super) const MOST_WORK: usize = 100_000_000;

/// Fractions are searched for in so many digits of base p at most: numerators and denominators of 2000 bits.
const MOST_DIGITS: u32 = 64;

/// A sparse row modulo the prime: places in ascending order, with entries that are not 0.
pub(super) type Row = Vec<(u32, u64)>;

/// row + factor · other.
fn combined(row: &[(u32, u64)], factor: u64, other: &[(u32, u64)]) -> Row {
    let mut sum = Row::with_capacity(row.len() + other.len());
    let (mut row, mut other) = (row.iter().peekable(), other.iter().peekable());
    loop {
        let place = match (row.peek(), other.peek()) {
            (None, None) => return sum,
            (Some((i, _)), None) | (None, Some((i, _))) => *i,
            (Some((i, _)), Some((j, _))) => *i.min(j),
        };
        let mut value = row.next_if(|(i, _)| *i == place).map_or(0, |(_, x)| *x);
        if let Some((_, y)) = other.next_if(|(j, _)| *j == place) {
            value = add_mod(value, mul_mod(factor, *y));
        }
        if value != 0 {
            sum.push((place, value));
        }
    }
}

/// Gaussian elimination modulo the prime, row by row, sparse.
#[derive(Default)]
pub(super) struct Elimination {
    /// By pivot column.
    rows: BTreeMap<u32, Eliminated>,
    /// The pivot columns in the order in which they were found.
    order: Vec<u32>,
    added: usize,
    work: usize,
}

/// What is left of a row.
struct Eliminated {
    /// The entries behind the pivot, which is 1.
    rest: Row,
    /// The number of the row that it was.
    source: usize,
    /// The pivots that were taken away, how often, and what the rest was multiplied with then.
    steps: Row,
    inverse: u64,
}

impl Elimination {
    /// Adds a row: whether it is independent of those before it; `None` where all together are too much work.
    pub(super) fn add(&mut self, mut row: Row) -> Option<bool> {
        let source = self.added;
        self.added += 1;
        let mut steps = Row::new();
        while let Some((&(column, value), rest)) = row.split_first() {
            let Some(pivot) = self.rows.get(&column) else {
                let inverse = inverse_mod(value)?;
                let rest = rest.iter().map(|(j, x)| (*j, mul_mod(*x, inverse))).collect();
                self.order.push(column);
                self.rows.insert(column, Eliminated { rest, source, steps, inverse });
                return Some(true);
            };
            self.work += pivot.rest.len() + rest.len();
            if self.work > MOST_WORK {
                return None;
            }
            steps.push((column, value));
            row = combined(rest, neg_mod(value), &pivot.rest);
        }
        Some(false)
    }

    fn free(&self, columns: usize) -> Vec<u32> {
        let all = 0..u32::try_from(columns).unwrap_or(0);
        all.filter(|column| !self.rows.contains_key(column)).collect()
    }

    /// A basis of the vectors that all rows annihilate; one per column without a pivot.
    pub(super) fn kernel(&self, columns: usize) -> Vec<Vec<u64>> {
        let vector = |free: u32| {
            let mut vector = vec![0; columns];
            vector[free as usize] = 1;
            self.substitute_back(&mut vector);
            vector
        };
        self.free(columns).into_iter().map(vector).collect()
    }

    /// From the last pivot upwards: what the columns behind a pivot leave for it.
    fn substitute_back(&self, x: &mut [u64]) {
        for (column, own) in self.rows.iter().rev() {
            let taken = own.rest.iter().fold(0, |sum, (j, factor)| add_mod(sum, mul_mod(*factor, x[*j as usize])));
            x[*column as usize] = sub_mod(x[*column as usize], taken);
        }
    }

    /// The x that the rows with pivots take to what stands on the right, one number a row, with 0 at the columns
    /// without.
    fn solve(&self, right: &[u64], columns: usize) -> Vec<u64> {
        let mut x = vec![0; columns];
        for column in &self.order {
            let own = &self.rows[column];
            let taken =
                own.steps.iter().fold(0, |sum, (pivot, factor)| add_mod(sum, mul_mod(*factor, x[*pivot as usize])));
            x[*column as usize] = mul_mod(sub_mod(right[own.source], taken), own.inverse);
        }
        self.substitute_back(&mut x);
        x
    }

    fn entries(&self) -> usize {
        let entries = |own: &Eliminated| own.rest.len() + own.steps.len() + 1;
        self.rows.values().map(entries).sum()
    }
}

/// Whether motions exp(s t) of a square matrix of polynomials in s, the constants first, row by row, grow as t² or faster at s = 0: a Jordan
/// block over 2, as the kernels of (A), (B, A; A), (C, B, A; B, A; A) tell, A + sB + s²C, whose dimensions count blocks of size 1, 2
/// and 3 at least. Modulo a prime, with values that are drawn for symbols; `None` where entries have none, and where it depends on
/// signs of roots.
pub(crate) fn grows_from_zero(pool: &Pool, entries: &[Vec<ExprId>]) -> Option<bool> {
    let (n, degrees) = (entries.len().isqrt(), entries.first()?.len());
    let all = entries.concat();
    let mut found = pool.points_at_random(&all, 1).map(|values| {
        let blocks = |size: usize| {
            let entry = |row: usize, column: usize| match (row / n).checked_sub(column / n) {
                Some(power) if power < degrees => values[(row % n * n + column % n) * degrees + power],
                Some(_) | None => 0,
            };
            let rows = (0..size * n).map(|row| (0..size * n).map(|column| entry(row, column)).collect());
            nullspace_mod(&rows.collect::<Vec<_>>(), size * n).len()
        };
        blocks(3) > blocks(2)
    });
    let first = found.next()?;
    found.all(|other| other == first).then_some(first)
}

/// A basis of the vectors of length `columns` whose product with every row is 0 modulo the prime, each with 1 at a column
/// of its own; none where it is too much work.
pub fn nullspace_mod(rows: &[Vec<u64>], columns: usize) -> Vec<Vec<u64>> {
    let mut elimination = Elimination::default();
    let added = rows.iter().try_for_each(|row| {
        let entries = (0..).zip(row.iter().copied()).filter(|(_, x)| *x != 0);
        elimination.add(entries.collect()).map(|_| ())
    });
    added.map_or_else(Vec::new, |()| elimination.kernel(columns))
}

/// The least number that makes whole numbers of these.
pub(super) fn common_denominator<'a>(numbers: impl Iterator<Item = &'a Number>) -> IBig {
    let common = numbers.fold(UBig::ONE, |common, own| {
        let denominator = own.denominator();
        let shared = (&common).gcd(&denominator);
        common * (denominator / shared)
    });
    IBig::from(common)
}

/// A sparse symmetric matrix of fractions by rows; places in ascending order, with entries that are not 0.
pub(super) type Rows = Vec<Vec<(u32, Number)>>;

/// Vectors of the kernel of a symmetric matrix, independent of each other, all of them but where numbers get too
/// long; none where the kernel has no more dimensions than the `known` ones, `None` where it is too much work.
pub(super) fn kernel(matrix: &Rows, known: usize) -> Option<Vec<Vec<Number>>> {
    let n = matrix.len();
    let neighbours = matrix.iter().zip(0..).map(|(row, i)| {
        let places = row.iter().map(|(j, _)| *j);
        places.filter(|j| *j != i).collect()
    });
    let order = minimum_degree(neighbours.collect())?;
    let mut place = vec![0_u32; n];
    for (new, old) in (0..).zip(&order) {
        place[*old as usize] = new;
    }
    // Rows times their denominators, in the new order.
    let mut whole: Vec<Vec<(u32, IBig)>> = Vec::with_capacity(n);
    let mut elimination = Elimination::default();
    for old in &order {
        let row = &matrix[*old as usize];
        let common = common_denominator(row.iter().map(|(_, entry)| entry));
        let times_common = |entry: &Number| entry.numerator() * (&common / IBig::from(entry.denominator()));
        let own = row.iter().map(|(j, entry)| (place[*j as usize], times_common(entry)));
        let mut own: Vec<(u32, IBig)> = own.collect();
        own.sort_unstable_by_key(|(j, _)| *j);
        let residues = own.iter().map(|(j, entry)| (*j, residue(entry)));
        elimination.add(residues.filter(|(_, x)| *x != 0).collect())?;
        whole.push(own);
    }
    let free = elimination.free(n);
    if free.len() <= known {
        return Some(Vec::new());
    }
    let mut left = MOST_WORK;
    let vectors = free.into_iter().filter_map(|column| lifted(&elimination, &whole, column, &mut left));
    let in_old_places = |vector: Vec<Number>| place.iter().map(|new| vector[*new as usize].clone()).collect();
    Some(vectors.map(in_old_places).collect())
}

/// The vector of the kernel with 1 at one column without a pivot and 0 at the others, if it is one in true numbers;
/// `work` is what may still be done.
fn lifted(
    elimination: &Elimination,
    matrix: &[Vec<(u32, IBig)>],
    column: u32,
    work: &mut usize,
) -> Option<Vec<Number>> {
    let n = matrix.len();
    let prime = UBig::from(PRIME);
    let once = elimination.entries() + matrix.iter().map(Vec::len).sum::<usize>();
    let mut vector = vec![IBig::ZERO; n];
    vector[column as usize] = IBig::ONE;
    // -A x over the power of p that was reached.
    let mut left: Vec<IBig> = vec![IBig::ZERO; n];
    for (left, row) in left.iter_mut().zip(matrix) {
        if let Ok(at) = row.binary_search_by_key(&column, |(j, _)| *j) {
            *left = -&row[at].1;
        }
    }
    let mut power = UBig::ONE;
    for digit in 1..=MOST_DIGITS {
        *work = work.checked_sub(once)?;
        let right: Vec<u64> = left.iter().map(residue).collect();
        let digits = elimination.solve(&right, n);
        for (left, row) in left.iter_mut().zip(matrix) {
            for (j, entry) in row {
                *left -= entry * IBig::from(digits[*j as usize]);
            }
            // What is left over here is a row that depends on others modulo p alone.
            if residue(left) != 0 {
                return None;
            }
            *left /= IBig::from(PRIME);
        }
        for (x, digit) in vector.iter_mut().zip(digits) {
            *x += IBig::from(&power * digit);
        }
        power *= &prime;
        if !digit.is_power_of_two() {
            continue;
        }
        let fractions = vector.iter().map(|x| rational_reconstruct(x, &power));
        if let Some(found) = fractions.collect::<Option<Vec<Number>>>()
            && matrix.iter().all(|row| annihilates(row, &found))
        {
            return Some(found);
        }
    }
    None
}

/// Whether a row takes a vector to exactly 0.
fn annihilates(row: &[(u32, IBig)], vector: &[Number]) -> bool {
    let terms = row.iter().map(|(j, entry)| Number::from_integer(entry.clone()).mul(&vector[*j as usize]));
    terms.fold(Number::ZERO, |sum, term| sum.add(&term)).is_zero()
}

fn residue(value: &IBig) -> u64 {
    let magnitude = value.unsigned_abs() % PRIME;
    if *value < IBig::ZERO { neg_mod(magnitude) } else { magnitude }
}

/// An order in which elimination leaves rows short: always the vertex with the fewest neighbours next, which are
/// neighbours of each other from then on (Tinney, Walker, Proc. IEEE 55 (1967) 1801). `None` where it is too
/// much work.
fn minimum_degree(mut neighbours: Vec<Vec<u32>>) -> Option<Vec<u32>> {
    let all = neighbours.iter().zip(0..);
    let mut queue: BTreeSet<(usize, u32)> = all.map(|(own, i)| (own.len(), i)).gather();
    let mut order = Vec::with_capacity(neighbours.len());
    let mut work = 0;
    while let Some((degree, least)) = queue.pop_first() {
        order.push(least);
        let own = std::mem::take(&mut neighbours[least as usize]);
        if degree == queue.len() {
            // All that are left are neighbours of each other.
            order.extend(queue.iter().map(|(_, i)| *i));
            break;
        }
        for i in &own {
            let theirs = &mut neighbours[*i as usize];
            work += theirs.len() + own.len();
            queue.remove(&(theirs.len(), *i));
            theirs.extend(&own);
            // Two runs in order are merged.
            theirs.sort();
            theirs.dedup();
            theirs.retain(|j| j != i && *j != least);
            queue.insert((theirs.len(), *i));
        }
        if work > MOST_WORK {
            return None;
        }
    }
    Some(order)
}
