//! Random gyroscopic and damped problems against exponents to 40 digits by Arb
//! (tests/reference/exponents/generate.py, which draws the same matrices).
#![cfg(feature = "engine")]

use librate::modes::{Kind, Options};
use librate::number::Number;
use librate::precision::{Ball, Big, Rounding, decimal};
use librate_core::modes::exponents::{Exponent, QuadraticProblem, Structure, exponents};

struct Draw(u64);

type Square = Vec<Vec<f64>>;

impl Draw {
    fn new(seed: u64) -> Self {
        let mut draw = Self(seed.wrapping_mul(2).wrapping_add(1));
        (0..4).for_each(|_| {
            draw.entry();
        });
        draw
    }

    /// A multiple of 2^-13 in [-4, 4).
    fn entry(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 48) as f64 - 32768.0) / 8192.0
    }

    fn matrix(&mut self, n: usize) -> Square {
        let columns: Square = (0..n).map(|_| (0..n).map(|_| self.entry()).collect()).collect();
        make(n, |i, j| columns[j][i])
    }
}

fn make(n: usize, entry: impl Fn(usize, usize) -> f64) -> Square {
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

/// All sums are exact in doubles: multiples of 2^-32 below 2^12.
fn gram(a: &Square, shift: f64, weight: f64) -> Square {
    let n = a.len();
    make(n, |i, j| {
        let sum: f64 = (0..n).map(|k| a[k][i] * a[k][j]).sum();
        sum * weight + if i == j { shift } else { 0.0 }
    })
}

fn problem(kind: u32, n: usize, seed: u64) -> QuadraticProblem {
    let mut draw = Draw::new(seed * 1000 + n as u64 * 10 + u64::from(kind));
    let mut m = gram(&draw.matrix(n), 1.0, 1.0 / 16.0);
    let (a, b) = (draw.matrix(n), draw.matrix(n));
    let skew = make(n, |i, j| a[i][j] - a[j][i]);
    let symmetric = make(n, |i, j| b[i][j] + b[j][i]);
    let (d, s) = match kind {
        0 => (skew, gram(&b, 1.0, 1.0)),
        1 => (make(n, |i, j| 4.0 * skew[i][j]), symmetric),
        2 => (gram(&a, 0.0, 1.0 / 64.0), gram(&b, 1.0, 1.0)),
        3 => (a, b),
        _ => {
            let (d, s) = (gram(&a, 0.0, 1.0 / 64.0), gram(&b, 1.0, 1.0));
            let e = |i: usize| (27 * i / (n - 1).max(1)) as i32;
            let two = |k: i32| f64::from(k).exp2();
            let apart = |i, j| two(-(e(i) - e(j)).abs());
            m = make(n, |i, j| if i == j { m[i][j] } else { m[i][j] * apart(i, j) / 64.0 });
            (
                make(n, |i, j| d[i][j] * two(e(i).min(e(j))) * apart(i, j)),
                make(n, |i, j| s[i][j] * two(2 * e(i).min(e(j))) * apart(i, j)),
            )
        }
    };
    let balls = |a: &Square| (0..n * n).map(|at| Ball::exact(a[at % n][at / n])).collect();
    QuadraticProblem {
        dimension: n,
        mass: balls(&m),
        velocity: balls(&d),
        stiffness: balls(&s),
        structure: if kind < 2 { Structure::Gyroscopic } else { Structure::Damped },
        zero_vectors: Vec::new(),
        unmoved: Vec::new(),
    }
}

/// A number of 40 digits and what it may be off by.
fn parse(text: &str) -> Ball {
    let number = Number::parse(text.strip_prefix('-').unwrap_or(text)).unwrap();
    let value = Big::from_number(&number, 200).to_ball();
    let value = if text.starts_with('-') { -value } else { value };
    value.with_added_radius(value.mid_f64().abs() * 1e-38)
}

/// Growth and omega >= 0 of one of each pair, as they are listed.
fn references(kind: u32, lines: &[&str]) -> Vec<(Ball, Ball)> {
    let all: Vec<(Ball, Ball)> = lines
        .iter()
        .map(|line| {
            let (re, im) = line.split_once(' ').unwrap();
            (parse(re), parse(im))
        })
        .collect();
    // Arb's midpoints of what is 0 are far below everything else.
    let size = |x: &Ball| x.mid_f64().abs();
    let tiny = |x: &Ball, beside: &Ball| size(x) < 1e-60 * size(beside);
    all.into_iter()
        .map(|(re, im)| {
            let (a, b) = (tiny(&re, &im), tiny(&im, &re));
            (if a { Ball::ZERO } else { re }, if b { Ball::ZERO } else { im })
        })
        .filter(|(re, im)| {
            let above = im.is_positive();
            above || im.is_zero() && (kind >= 2 || re.is_positive())
        })
        .collect()
}

fn fits(found: &Exponent, (growth, omega): &(Ball, Ball)) -> bool {
    (found.growth - *growth).contains_zero() && (found.omega - *omega).contains_zero()
}

fn check(text: &str) -> (usize, usize) {
    let lines: Vec<&str> = text.lines().collect();
    let (mut at, mut cases, mut count) = (0, 0, 0);
    while at < lines.len() {
        let head: Vec<u64> = lines[at].split(' ').map(|x| x.parse().unwrap()).collect();
        let (kind, n, seed) = (head[0] as u32, head[1] as usize, head[2]);
        let truth = references(kind, &lines[at + 1..at + 1 + 2 * n]);
        at += 1 + 2 * n;
        cases += 1;
        let found = exponents(&problem(kind, n, seed), &(), &Options::default()).unwrap();
        let name = format!("kind {kind} n {n} seed {seed}");
        assert_eq!(found.entries.len(), truth.len(), "{name}");
        let mut left = truth;
        for entry in &found.entries {
            count += 1;
            let place = left.iter().position(|value| fits(entry, value));
            let value = left
                .swap_remove(place.unwrap_or_else(|| panic!("{name}: {:?} {:?} {left:?}", entry.growth, entry.omega)));
            // Exactly 0 where it is.
            assert_eq!(entry.growth.is_zero(), value.0.is_zero(), "{name}");
            assert_eq!(entry.omega.is_zero(), value.1.is_zero(), "{name}");
            assert_ne!(entry.kind, Kind::Undecided, "{name}");
            assert_eq!(entry.limit, None, "{name}");
            for (found, truth) in [(entry.growth, value.0), (entry.omega, value.1)] {
                let digits = decimal(&found, 10);
                assert_eq!(digits.rounding, Rounding::Correct, "{name} {found:?}");
                assert_eq!(digits.text, decimal(&truth, 10).text, "{name}");
            }
            assert!(entry.vector_error_bound < 1e-8, "{name} {}", entry.vector_error_bound);
        }
    }
    (cases, count)
}

#[test]
fn digits_of_random_problems() {
    let text = std::fs::read_to_string(format!("{}/tests/reference/exponents/random.txt", env!("CARGO_MANIFEST_DIR")))
        .unwrap();
    let (cases, _) = check(&text);
    assert!(cases >= 200);
}

#[test]
fn thirty_digits_of_random_problems() {
    let path = format!("{}/tests/reference/exponents/random.txt", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let (mut at, mut cases) = (0, 0);
    while cases < 50 {
        let head: Vec<u64> = lines[at].split(' ').map(|x| x.parse().unwrap()).collect();
        let (kind, n, seed) = (head[0] as u32, head[1] as usize, head[2]);
        let own = &lines[at + 1..at + 1 + 2 * n];
        at += 1 + 2 * n;
        cases += 1;
        // All printed parts, without signs, to 30 digits.
        let digits = |x: &str| {
            let number = Number::parse(x.strip_prefix('-').unwrap_or(x)).unwrap();
            Big::from_number(&number, 200).decimal(30).text
        };
        let parts: Vec<String> = own.iter().flat_map(|line| line.split(' ')).map(digits).collect();
        let options = Options::default().digits(30);
        let found = exponents(&problem(kind, n, seed), &(), &options).unwrap();
        for entry in &found.entries {
            assert_eq!(entry.limit, None, "kind {kind} n {n} seed {seed}");
            let precise = entry.precise.as_ref().unwrap();
            for part in [&precise.growth, &precise.omega] {
                let part = if part.is_negative() { -part } else { part.clone() };
                let text = part.decimal(30).text;
                assert!(part.is_zero() || parts.contains(&text), "kind {kind} n {n} seed {seed} {text}");
            }
        }
    }
}

/// A larger file, by hand: LIBRATE_EXPONENTS=file cargo test --test modes exponents_random -- --ignored
#[test]
#[ignore = "reads a file named by LIBRATE_EXPONENTS"]
fn digits_of_many_random_problems() {
    let path = std::env::var("LIBRATE_EXPONENTS").unwrap();
    let (cases, count) = check(&std::fs::read_to_string(path).unwrap());
    assert!(cases > 0 && count > 0);
}
