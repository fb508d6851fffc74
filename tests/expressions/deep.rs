//! Expressions nested a hundred thousand deep: no pass may use the call stack for depth.

#![cfg(feature = "engine")]

use crate::expr_support;

use expr_support::{Plain, value};
use librate::expr::{ExprId, Function, Pool, Tape};
use librate::number::Number;
use librate_core::expr::{Seeds, Substitution};

const DEPTH: usize = 100_000;

/// Runs on a small stack, where recursion to this depth could not pass.
fn on_small_stack(test: impl FnOnce() + Send + 'static) {
    std::thread::Builder::new().stack_size(256 * 1024).spawn(test).unwrap().join().unwrap();
}

fn chain(pool: &mut Pool) -> ExprId {
    let mut e = pool.variable("x");
    let one = pool.one();
    for _ in 0..DEPTH {
        let sine = pool.apply(Function::Sin, e);
        e = pool.add(sine, one);
    }
    e
}

#[test]
fn chain_of_sines() {
    on_small_stack(|| {
        let mut pool = Pool::default();
        let x = pool.symbol("x");
        let e = chain(&mut pool);
        let ex = pool.symbol_expr(x);
        let mut expected = 0.3f64;
        for _ in 0..DEPTH {
            expected = expected.sin() + 1.0;
        }
        assert!((value(&pool, e, &[x], &[0.3]) - expected).abs() < 1e-12);
        let y = pool.variable("y");
        let moved = pool.substitute_one(e, &Substitution::from([(x, y)]));
        assert_ne!(moved, e);
        let text = pool.display(e);
        assert!(text.starts_with("1 + sin(1 + sin("));
        assert!(text.len() > 8 * DEPTH);
        let _ = pool.is_zero(e);
        assert!(pool.evaluate_mod(&[e], |_| 5, 1).is_some());
        assert!(pool.depends_on(e, &|s| s == x));
        let copy = pool.clone();
        drop(pool);
        assert_eq!(copy.display(ex), "x");
    });
}

#[test]
fn derivatives_of_a_chain() {
    on_small_stack(|| {
        let mut pool = Pool::default();
        let x = pool.symbol("x");
        let mut e = pool.symbol_expr(x);
        for k in 0..300 {
            let sine = pool.apply(Function::Sin, e);
            let k = pool.integer(k);
            e = pool.add(sine, k);
        }
        let d = pool.diff(e, x);
        let g = pool.gradient(e, &[x])[0];
        let step = 1e-6;
        let slope = (value(&pool, e, &[x], &[0.3 + step]) - value(&pool, e, &[x], &[0.3 - step])) / (2.0 * step);
        assert!((value(&pool, d, &[x], &[0.3]) - slope).abs() < 1e-6);
        assert!((value(&pool, g, &[x], &[0.3]) - slope).abs() < 1e-6);
    });
}

#[test]
fn derivative_of_a_deep_chain() {
    on_small_stack(|| {
        let mut pool = Pool::default();
        let x = pool.symbol("x");
        let e = chain(&mut pool);
        let ones = Seeds::from([(x, pool.one())]);
        let d = pool.derivation(&[e], &ones)[0];
        let tape = Tape::compile(&pool, &[d], &[x]).unwrap();
        assert!(tape.evaluate(&[Plain(0.3)], &mut Vec::new())[0].0.abs() < 1.0);
    });
}

#[test]
fn deep_sums_of_powers() {
    on_small_stack(|| {
        let mut pool = Pool::default();
        let x = pool.symbol("x");
        let mut e = pool.symbol_expr(x);
        let one = pool.one();
        for _ in 0..DEPTH {
            let inverse = pool.div(one, e);
            e = pool.add(inverse, one);
        }
        let d = pool.diff(e, x);
        let golden = (1.0 + 5f64.sqrt()) / 2.0;
        assert!((value(&pool, e, &[x], &[0.3]) - golden).abs() < 1e-12);
        assert!(value(&pool, d, &[x], &[0.3]).abs() < 1e-12);
        assert!(pool.display(e).len() > DEPTH);
    });
}

#[test]
fn long_sums_and_products() {
    on_small_stack(|| {
        let mut pool = Pool::default();
        let symbols: Vec<_> = (0..DEPTH).map(|i| pool.symbol(&format!("x{i}"))).collect();
        let terms: Vec<_> = symbols.iter().map(|s| pool.symbol_expr(*s)).collect();
        let squares: Vec<_> = terms.iter().map(|t| pool.square(*t)).collect();
        let sum = pool.sum(&squares);
        let gradient = pool.gradient(sum, &symbols);
        assert_eq!(pool.display(gradient[7]), "2*x7");
        let product = pool.product(&terms);
        let doubled = pool.scale(product, &Number::from(2));
        assert!(pool.display(doubled).starts_with("2*x0*x1*"));
    });
}
