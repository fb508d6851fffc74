//! Problems with known exponents: M = PᵀP, D = PᵀBP, S = PᵀAP for an integer matrix P and matrices A and B of blocks
//! whose exponents are closed forms, equal ones among them.
#![cfg(feature = "engine")]

use dashu_int::IBig;
use librate::modes::{Kind, Options};
use librate::precision::Ball;
use librate_core::modes::exponents::{Exponents, QuadraticProblem, QuadraticSource, Structure, exponents};
use librate_core::precision::Integers;
use proptest::prelude::*;

type Square = Vec<Vec<i64>>;

/// A block and what it contributes.
#[derive(Clone, Debug)]
enum Block {
    /// q'' + 2c q' + k q = 0
    Oscillator { c: i64, k: i64 },
    /// q'' + 2g J q' + k q = 0 in the plane: λ = ±i (g ± √(g² + k)).
    Plane { g: i64, k: i64 },
    /// q'' + c q' = 0
    Free { c: i64 },
}

struct Planted {
    problem: QuadraticProblem,
    whole: Integers,
    /// Growth and omega of all entries.
    truth: Vec<(Ball, Ball)>,
}

impl QuadraticSource for Planted {
    fn integers(&self) -> Option<Integers> {
        Some(self.whole.clone())
    }
}

fn root(x: i64) -> Ball {
    Ball::exact(x as f64).sqrt()
}

fn number(x: i64) -> Ball {
    Ball::exact(x as f64)
}

fn planted(blocks: &[Block], mixing: &[i64], structure: Structure) -> Planted {
    let n: usize = blocks.iter().map(|block| if matches!(block, Block::Plane { .. }) { 2 } else { 1 }).sum();
    let (mut b, mut a) = (vec![vec![0; n]; n], vec![vec![0; n]; n]);
    let mut truth = Vec::new();
    let mut kernel = Vec::new();
    let mut at = 0;
    for block in blocks {
        match *block {
            Block::Oscillator { c, k } => {
                (b[at][at], a[at][at]) = (2 * c, k);
                let square = c * c - k;
                if square < 0 {
                    truth.push((number(-c), root(-square)));
                } else if structure == Structure::Gyroscopic {
                    truth.push((root(square), Ball::ZERO));
                } else {
                    truth.push((number(-c) - root(square), Ball::ZERO));
                    truth.push((number(-c) + root(square), Ball::ZERO));
                }
                at += 1;
            }
            Block::Plane { g, k } => {
                (b[at][at + 1], b[at + 1][at]) = (-2 * g, 2 * g);
                (a[at][at], a[at + 1][at + 1]) = (k, k);
                let (square, g) = (g * g + k, number(g));
                if square < 0 {
                    truth.push((root(-square), g));
                    truth.push((-root(-square), g));
                } else {
                    let lower = g - root(square);
                    truth.push((Ball::ZERO, if lower.is_negative() { -lower } else { lower }));
                    truth.push((Ball::ZERO, g + root(square)));
                }
                at += 2;
            }
            Block::Free { c } => {
                b[at][at] = c;
                truth.push((Ball::ZERO, Ball::ZERO));
                if c != 0 {
                    truth.push((number(-c), Ball::ZERO));
                }
                kernel.push(at);
                at += 1;
            }
        }
    }
    // P = 1 + a strictly upper triangle: its inverse is whole too.
    let mut p: Square = (0..n).map(|i| (0..n).map(|j| i64::from(i == j)).collect()).collect();
    let mut entries = mixing.iter().cycle();
    for (i, row) in p.iter_mut().enumerate() {
        for x in row.iter_mut().skip(i + 1) {
            *x = *entries.next().unwrap();
        }
    }
    let congruent = |m: &Square| -> Square {
        let entry = |i: usize, j: usize| {
            let all = (0..n).flat_map(|k| (0..n).map(move |l| (k, l)));
            all.map(|(k, l)| p[k][i] * m[k][l] * p[l][j]).sum()
        };
        (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    };
    let one: Square = (0..n).map(|i| (0..n).map(|j| i64::from(i == j)).collect()).collect();
    let (m, d, s) = (congruent(&one), congruent(&b), congruent(&a));
    let balls = |m: &Square| (0..n * n).map(|at| number(m[at % n][at / n])).collect();
    let whole = |m: &Square| (0..n * n).map(|at| IBig::from(m[at % n][at / n])).collect();
    // P x = e_k from below.
    let zero_vectors = kernel
        .iter()
        .map(|&k| {
            let mut x = vec![0; n];
            for i in (0..n).rev() {
                let rest: i64 = (i + 1..n).map(|j| p[i][j] * x[j]).sum();
                x[i] = i64::from(i == k) - rest;
            }
            x.into_iter().map(number).collect()
        })
        .collect();
    Planted {
        problem: QuadraticProblem {
            dimension: n,
            mass: balls(&m),
            velocity: balls(&d),
            stiffness: balls(&s),
            structure,
            zero_vectors,
            unmoved: Vec::new(),
        },
        whole: Integers { matrices: [whole(&m), whole(&d), whole(&s)], ..Integers::default() },
        truth,
    }
}

/// Every exponent found once, within its bounds; `exact`: nothing open, and 0 where it is 0.
fn check(found: &Exponents, truth: &[(Ball, Ball)], exact: bool) -> Result<(), TestCaseError> {
    prop_assert!(found.entries.len() == truth.len() || !exact, "{:?} {:?}", found.entries, truth);
    let mut left = truth.to_vec();
    for entry in &found.entries {
        let fits = |(growth, omega): &(Ball, Ball)| {
            (entry.growth - *growth).contains_zero() && (entry.omega - *omega).contains_zero()
        };
        let place = left.iter().position(fits);
        if !exact {
            // Of a real pair ±s that is not resolved from another one, the decaying side may be listed too.
            let mirrored = |(growth, omega): &(Ball, Ball)| entry.kind == Kind::Undecided && fits(&(-*growth, *omega));
            prop_assert!(truth.iter().any(|value| fits(value) || mirrored(value)), "{:?} {:?}", entry, truth);
            continue;
        }
        prop_assert!(place.is_some(), "{:?} {:?}", entry, left);
        let (growth, omega) = left.swap_remove(place.unwrap());
        prop_assert_eq!(entry.growth.is_zero(), growth.is_zero());
        prop_assert_eq!(entry.omega.is_zero(), omega.is_zero());
        prop_assert_ne!(entry.kind, Kind::Undecided);
        prop_assert!(entry.growth.radius <= 1e-13 * growth.mid_f64().abs());
        prop_assert!(entry.omega.radius <= 1e-13 * omega.mid_f64().abs());
    }
    Ok(())
}

fn conservative() -> impl Strategy<Value = Block> {
    prop_oneof![
        (1..5i64).prop_map(|k| Block::Oscillator { c: 0, k }),
        (-3..0i64).prop_map(|k| Block::Oscillator { c: 0, k }),
        (1..4i64, -12..6i64)
            .prop_filter("no exponent 0, none defective", |(g, k)| *k != 0 && g * g + k != 0)
            .prop_map(|(g, k)| Block::Plane { g, k }),
        Just(Block::Free { c: 0 }),
    ]
}

fn damped() -> impl Strategy<Value = Block> {
    prop_oneof![
        (-2..5i64, 1..12i64)
            .prop_filter("not critical, growth is not 0", |(c, k)| *c != 0 && c * c != *k)
            .prop_map(|(c, k)| Block::Oscillator { c, k }),
        (1..4i64).prop_map(|c| Block::Free { c }),
        (1..5i64).prop_map(|k| Block::Oscillator { c: 0, k }),
    ]
}

fn some(block: impl Strategy<Value = Block>) -> impl Strategy<Value = (Vec<Block>, Vec<i64>)> {
    (prop::collection::vec(block, 1..5), prop::collection::vec(-2..3i64, 7))
}

/// A critical motion beside a growing one: 6 x'' - x = 0 and y'' - 2 y' + y = 0.
#[test]
fn equal_vectors_do_not_end_the_decomposition() {
    let balls = |entries: [i64; 4]| entries.map(number).to_vec();
    let problem = QuadraticProblem {
        dimension: 2,
        mass: balls([6, 0, 0, 1]),
        velocity: balls([0, 0, 0, -2]),
        stiffness: balls([-1, 0, 0, 1]),
        structure: Structure::Damped,
        zero_vectors: Vec::new(),
        unmoved: Vec::new(),
    };
    let whole = |entries: [i64; 4]| entries.map(IBig::from).to_vec();
    let planted = Planted {
        problem,
        whole: Integers {
            matrices: [whole([6, 0, 0, 1]), whole([0, 0, 0, -2]), whole([-1, 0, 0, 1])],
            ..Integers::default()
        },
        truth: Vec::new(),
    };
    let found = exponents(&planted.problem, &planted, &Options::default()).unwrap();
    let sixth = (number(1) / number(6)).sqrt();
    for truth in [sixth, -sixth, number(1)] {
        let near = |entry: &&librate_core::modes::exponents::Exponent| {
            (entry.growth - truth).contains_zero() && entry.omega.is_zero()
        };
        assert!(found.entries.iter().any(|entry| near(&entry)), "{truth:?} {found:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn without_dissipation((blocks, mixing) in some(conservative())) {
        let planted = planted(&blocks, &mixing, Structure::Gyroscopic);
        let options = Options::default();
        let found = exponents(&planted.problem, &planted, &options).unwrap();
        check(&found, &planted.truth, true)?;
        // What is not told the exact matrices may leave something open, but says nothing wrong.
        check(&exponents(&planted.problem, &(), &options).unwrap(), &planted.truth, false)?;
    }

    /// Small whole numbers at random hit every degenerate case there is; what bounds alone say has to agree with what
    /// is decided exactly.
    #[test]
    fn anything(
        n in 1..4usize,
        gyroscopic in any::<bool>(),
        entries in prop::collection::vec(-2..3i64, 27),
        far in prop::sample::select(vec![0i32, 0, 0, 40, -60]),
    ) {
        let square = |from: usize| -> Square {
            (0..n).map(|i| (0..n).map(|j| entries[from + 3 * i + j]).collect()).collect()
        };
        let (a, b, c) = (square(0), square(9), square(18));
        let make = |entry: &dyn Fn(usize, usize) -> i64| -> Square {
            (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
        };
        let m = make(&|i, j| (0..n).map(|k| a[k][i] * a[k][j]).sum::<i64>() + i64::from(i == j));
        let (d, s, structure) = if gyroscopic {
            (
                make(&|i, j| b[i][j] - b[j][i]),
                make(&|i, j| c[i][j] + c[j][i]),
                Structure::Gyroscopic,
            )
        } else {
            (b, c, Structure::Damped)
        };
        // λ in units of 2^far.
        let balls = |m: &Square, times: i32| -> Vec<Ball> {
            (0..n * n).map(|at| number(m[at % n][at / n]).scale(times * far)).collect()
        };
        let whole = |m: &Square, times: i32| -> Vec<IBig> {
            let shift = if far < 0 { (times - 2) * far } else { times * far };
            (0..n * n).map(|at| IBig::from(m[at % n][at / n]) << shift as usize).collect()
        };
        let planted = Planted {
            problem: QuadraticProblem {
                dimension: n,
                mass: balls(&m, 0),
                velocity: balls(&d, 1),
                stiffness: balls(&s, 2),
                structure,
                zero_vectors: Vec::new(),
                unmoved: Vec::new(),
            },
            whole: Integers { matrices: [whole(&m, 0), whole(&d, 1), whole(&s, 2)], ..Integers::default() },
            truth: Vec::new(),
        };
        let options = Options::default();
        let exact = exponents(&planted.problem, &planted, &options).unwrap();
        let open = exponents(&planted.problem, &(), &options).unwrap();
        for entry in &exact.entries {
            prop_assert!(
                entry.kind != Kind::Undecided,
                "{:?}", entry
            );
        }
        for entry in &open.entries {
            let fits = |other: &librate_core::modes::exponents::Exponent| {
                let mirrored = structure == Structure::Gyroscopic
                    && (entry.growth + other.growth).contains_zero();
                (mirrored || (entry.growth - other.growth).contains_zero())
                    && (entry.omega - other.omega).contains_zero()
            };
            let infinite = !entry.growth.is_finite() || !entry.omega.is_finite();
            prop_assert!(infinite || exact.entries.iter().any(fits), "{:?} {:?}", entry, exact);
        }
    }

    #[test]
    fn with_dissipation((blocks, mixing) in some(damped())) {
        let planted = planted(&blocks, &mixing, Structure::Damped);
        let options = Options::default();
        let found = exponents(&planted.problem, &planted, &options).unwrap();
        check(&found, &planted.truth, true)?;
        check(&exponents(&planted.problem, &(), &options).unwrap(), &planted.truth, false)?;
    }
}
