//! Random numbers that know how they are written: what the model's text says and what the reference
//! works with is drawn once.

use dashu_ratio::RBig;

pub(crate) type Exact = Vec<Vec<RBig>>;

/// SplitMix64: a few lines, the same everywhere.
pub(crate) struct Draw(u64);

/// A number as text and in full.
#[derive(Clone)]
pub(crate) struct Number {
    pub(crate) text: String,
    pub(crate) value: RBig,
}

pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self(mix(seed))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// From `low` to `high`, both included.
    pub(crate) fn int(&mut self, low: i64, high: i64) -> i64 {
        low + (self.next() % (high - low + 1) as u64) as i64
    }

    pub(crate) fn size(&mut self, low: usize, high: usize) -> usize {
        self.int(low as i64, high as i64) as usize
    }

    /// True once in `of`.
    pub(crate) fn once_in(&mut self, of: i64) -> bool {
        self.int(1, of) == 1
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.size(0, from.len() - 1)]
    }

    /// The number of coordinates: half of them at most 6.
    pub(crate) fn dimension(&mut self) -> usize {
        match self.int(1, 100) {
            1..=50 => self.size(1, 6),
            51..=82 => self.size(7, 12),
            83..=96 => self.size(13, 24),
            _ => self.size(25, 40),
        }
    }

    /// A positive number of one to three digits times 10^exponent.
    pub(crate) fn decimal(&mut self, exponent: i64) -> Number {
        let places = self.int(0, 2);
        let digits = match places {
            0 => self.int(1, 9),
            1 => self.int(10, 99),
            _ => self.int(100, 999),
        };
        Number::scaled(digits, exponent - places)
    }

    /// Between 0.1 and 99, or so.
    pub(crate) fn plain(&mut self) -> Number {
        let exponent = self.int(-1, 1);
        self.decimal(exponent)
    }

    /// The same, negative once in `of`.
    pub(crate) fn signed(&mut self, of: i64) -> Number {
        let size = self.plain();
        if self.once_in(of) { size.negated() } else { size }
    }

    pub(crate) fn plains(&mut self, count: usize) -> Vec<Number> {
        if self.once_in(5) {
            return vec![self.plain(); count];
        }
        (0..count).map(|_| self.plain()).collect()
    }

    /// Numbers over `decades` each way: at random, rising, or a few stiff ones among soft ones.
    pub(crate) fn spread(&mut self, count: usize, decades: i64) -> Vec<Number> {
        let way = self.int(0, 3);
        let reach = self.int(1, decades);
        (0..count)
            .map(|i| {
                let exponent = match way {
                    0 => self.int(-reach, reach),
                    1 => -reach + 2 * reach * i as i64 / (count.max(2) as i64 - 1),
                    2 => self.pick(&[-reach, reach]),
                    _ => 0,
                };
                self.decimal(exponent)
            })
            .collect()
    }

    /// A small rational of either sign, perhaps zero.
    pub(crate) fn fraction(&mut self) -> Number {
        let numerator = self.int(-9, 9);
        match self.int(0, 3) {
            0 => Number::fraction(numerator, self.int(2, 9)),
            _ => Number::integer(numerator),
        }
    }

    /// A square matrix of small integers with a determinant.
    pub(crate) fn regular(&mut self, n: usize) -> Vec<Vec<i64>> {
        loop {
            let sparse = n > 6;
            let mut entry = |i: usize, j: usize| {
                let keep = !sparse || i == j || self.once_in(3);
                if keep { self.int(-4, 4) } else { 0 }
            };
            let a: Vec<Vec<i64>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
            if regular(&a) {
                return a;
            }
        }
    }
}

/// Whether the determinant does not vanish, by elimination modulo a prime.
fn regular(a: &[Vec<i64>]) -> bool {
    const P: i128 = (1 << 61) - 1;
    let n = a.len();
    let mut a: Vec<Vec<i128>> =
        a.iter().map(|row| row.iter().map(|x| i128::from(*x).rem_euclid(P)).collect()).collect();
    for k in 0..n {
        let Some(at) = (k..n).find(|i| a[*i][k] != 0) else {
            return false;
        };
        a.swap(k, at);
        let pivot = a[k].clone();
        for row in a.iter_mut().skip(k + 1) {
            // Cross-multiplied: no inverse is needed to see zeros.
            let factor = row[k];
            for (x, y) in row.iter_mut().zip(&pivot) {
                *x = (*x * pivot[k] - y * factor).rem_euclid(P);
            }
        }
    }
    true
}

impl Number {
    pub(crate) fn integer(x: i64) -> Self {
        Self { text: x.to_string(), value: RBig::from(x) }
    }

    pub(crate) fn fraction(numerator: i64, denominator: i64) -> Self {
        Self { text: format!("{numerator}/{denominator}"), value: RBig::from(numerator) / RBig::from(denominator) }
    }

    /// A known rational, written as a fraction where it is none of the integers.
    pub(crate) fn exactly(value: RBig) -> Self {
        let text = value.to_string();
        Self { text, value }
    }

    /// digits 10^exponent
    pub(crate) fn scaled(digits: i64, exponent: i64) -> Self {
        let value = RBig::from(digits) * power_of_ten(exponent);
        let text = if exponent == 0 {
            digits.to_string()
        } else if (-4..0).contains(&exponent) && digits >= 0 {
            let places = -exponent as usize;
            let padded = format!("{digits:0>width$}", width = places + 1);
            let (whole, rest) = padded.split_at(padded.len() - places);
            format!("{whole}.{rest}")
        } else {
            format!("{digits}e{exponent}")
        };
        Self { text, value }
    }

    pub(crate) fn negated(self) -> Self {
        Self { text: format!("-{}", self.text), value: -self.value }
    }
}

pub(crate) fn power_of_ten(exponent: i64) -> RBig {
    RBig::from(10).pow(exponent as isize)
}

/// All pairs, the second fastest.
pub(crate) fn pairs(rows: usize, columns: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..rows).flat_map(move |i| (0..columns).map(move |j| (i, j)))
}

pub(crate) fn zeros(n: usize) -> Exact {
    vec![vec![RBig::ZERO; n]; n]
}

pub(crate) fn diagonal<'a>(values: impl IntoIterator<Item = &'a Number>) -> Exact {
    let values: Vec<&Number> = values.into_iter().collect();
    let mut a = zeros(values.len());
    for (i, x) in values.into_iter().enumerate() {
        a[i][i] = x.value.clone();
    }
    a
}

/// Adds w g gᵀ for a sparse row g: the Hessian of w/2 (g·x)².
pub(crate) fn add_square(a: &mut Exact, w: &RBig, g: &[(usize, RBig)]) {
    for (i, x) in g {
        for (j, y) in g {
            let entry = w * x * y;
            a[*i][*j] += entry;
        }
    }
}

/// A spring between two coordinates, or from one to the ground.
pub(crate) fn add_spring(a: &mut Exact, w: &RBig, i: usize, j: Option<usize>) {
    let mut g = vec![(i, RBig::ONE)];
    g.extend(j.map(|j| (j, -RBig::ONE)));
    add_square(a, w, &g);
}

/// The mass that spring i of a chain of n between walls ends at, and the one before it.
pub(crate) fn ends(i: usize, n: usize) -> (usize, Option<usize>) {
    match i {
        0 => (0, None),
        _ if i == n => (n - 1, None),
        _ => (i, Some(i - 1)),
    }
}

/// `param NAME[1..n] = …`, with one value where all are the same.
pub(crate) fn family(name: &str, values: &[Number]) -> String {
    let n = values.len();
    let same = values.windows(2).all(|w| w[0].text == w[1].text);
    if same && let Some(first) = values.first() {
        return format!("param {name}[1..{n}] = {}\n", first.text);
    }
    format!("param {name}[1..{n}] = {}\n", list(values))
}

pub(crate) fn list(values: &[Number]) -> String {
    let texts: Vec<&str> = values.iter().map(|x| x.text.as_str()).collect();
    format!("[{}]", texts.join(", "))
}

pub(crate) fn matrix(rows: &[Vec<Number>]) -> String {
    let rows: Vec<String> = rows.iter().map(|row| list(row)).collect();
    format!("[{}]", rows.join(", "))
}
