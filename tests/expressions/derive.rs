//! Derivatives and substitution against closed forms.
#![cfg(feature = "engine")]

use crate::expr_support;

use expr_support::read;
use librate::expr::{Pool, ZeroVerdict};
use librate::number::Number;
use librate_core::expr::{Seeds, Substitution};

fn pool() -> Pool {
    let mut pool = Pool::default();
    for name in ["x", "y", "z", "a", "b", "n"] {
        pool.symbol(name);
    }
    pool
}

#[test]
fn derivatives_by_one_symbol() {
    let cases = [
        ("3", "0"),
        ("x", "1"),
        ("y", "0"),
        ("x^2", "2*x"),
        ("x^n", "n*x^n/x"),
        ("n^x", "n^x*ln(n)"),
        ("1/x", "-1/x^2"),
        ("sqrt(x)", "1/(2*sqrt(x))"),
        ("(x - y)^2", "2*(x - y)"),
        ("x*y*z", "y*z"),
        ("sin(a*x)", "a*cos(a*x)"),
        ("cos(x)", "-sin(x)"),
        ("tan(x)", "1/cos(x)^2"),
        ("asin(x)", "1/sqrt(1 - x^2)"),
        ("acos(x)", "-1/sqrt(1 - x^2)"),
        ("atan(x)", "1/(1 + x^2)"),
        ("sinh(x)", "cosh(x)"),
        ("cosh(x)", "sinh(x)"),
        ("tanh(x)", "1/cosh(x)^2"),
        ("exp(2*x)", "2*exp(2*x)"),
        ("ln(x)", "1/x"),
        ("abs(x)", "x/abs(x)"),
        ("atan2(x, y)", "y/(x^2 + y^2)"),
        ("atan2(y, x)", "-y/(x^2 + y^2)"),
        ("1/2*a*(sqrt(x^2 + y^2) - b)^2", "a*x*(sqrt(x^2 + y^2) - b)/sqrt(x^2 + y^2)"),
        ("1/0", "1/0"),
    ];
    for (text, derivative) in cases {
        let mut pool = pool();
        let x = pool.symbol("x");
        let e = read(&mut pool, text);
        let expected = read(&mut pool, derivative);
        let forward = pool.diff(e, x);
        assert_eq!(pool.display(forward), pool.display(expected), "d/dx of {text}");
        assert_eq!(forward, expected, "d/dx of {text}");
        assert_eq!(pool.gradient(e, &[x]), [expected], "gradient of {text}");
    }
}

#[test]
fn total_derivative() {
    let mut pool = pool();
    let (x, y) = (pool.symbol("x"), pool.symbol("y"));
    let (vx, vy) = (pool.variable("x'"), pool.variable("y'"));
    let e = read(&mut pool, "a*sin(x)*y");
    let seeds = Seeds::from([(x, vx), (y, vy)]);
    let d = pool.derivation(&[e], &seeds)[0];
    assert_eq!(pool.display(d), "a*y'*sin(x) + y*a*x'*cos(x)");
}

#[test]
fn gradient_of_many() {
    let mut pool = Pool::default();
    let symbols: Vec<_> = (0..50).map(|i| pool.symbol(&format!("q{i}"))).collect();
    let mut terms = Vec::new();
    for pair in symbols.windows(2) {
        let (a, b) = (pool.symbol_expr(pair[0]), pool.symbol_expr(pair[1]));
        let difference = pool.sub(b, a);
        terms.push(pool.square(difference));
    }
    let e = pool.sum(&terms);
    let gradient = pool.gradient(e, &symbols);
    assert_eq!(pool.display(gradient[0]), "2*q0 - 2*q1");
    for (symbol, by_reverse) in symbols.iter().zip(gradient) {
        assert_eq!(pool.diff(e, *symbol), by_reverse);
    }
}

#[test]
fn substitution_simplifies_and_is_simultaneous() {
    let mut pool = pool();
    let (x, y) = (pool.symbol("x"), pool.symbol("y"));
    let (ex, ey) = (pool.symbol_expr(x), pool.symbol_expr(y));
    let e = read(&mut pool, "x - 2*y + sin(x)");
    let swapped = pool.substitute_one(e, &Substitution::from([(x, ey), (y, ex)]));
    assert_eq!(pool.display(swapped), "y + sin(y) - 2*x");
    let e = read(&mut pool, "a*(1 - cos(x)) + y*sin(x)");
    let zero = pool.zero();
    let at_zero = pool.substitute_one(e, &Substitution::from([(x, zero)]));
    assert_eq!(at_zero, zero);
    let e = read(&mut pool, "1/x");
    let at_zero = pool.substitute_one(e, &Substitution::from([(x, zero)]));
    assert!(pool.is_undefined(at_zero));
}

#[test]
fn symbols_and_dependence() {
    let mut pool = pool();
    let (x, y, z) = (pool.symbol("x"), pool.symbol("y"), pool.symbol("z"));
    let e = read(&mut pool, "sin(z*x) + x");
    assert_eq!(pool.symbols(e), [x, z]);
    assert!(pool.depends_on(e, &|s| s == z));
    assert!(!pool.depends_on(e, &|s| s == y));
    let fresh = pool.fresh_symbol("x");
    assert_ne!(fresh, x);
    assert_eq!(pool.symbol("x"), x);
    assert_eq!(pool.symbol_name(fresh), "x");
    let reachable = pool.reachable(&[e]);
    assert!(reachable.is_sorted());
    for id in reachable {
        pool.node(id).for_each_child(|child| assert!(child < id));
    }
}

#[test]
fn zero_is_decided() {
    use ZeroVerdict::{NonZero, Unknown, Zero};
    let cases = [
        ("(a + b)^2 - a^2 - 2*a*b - b^2", Zero),
        ("(a + b)^2 - a^2 - 2*a*b - b^2 - 1", NonZero),
        ("(a - b)/(a^2 - b^2) - 1/(a + b)", Zero),
        ("sin(x)^2 + cos(x)^2 - 1", Zero),
        ("sin(x)^2 + cos(x)^2", NonZero),
        ("sin(x + y) - sin(x)*cos(y) - cos(x)*sin(y)", Zero),
        ("sin(x + y) - sin(x)*cos(y) + cos(x)*sin(y)", NonZero),
        ("cos(2*x) - 1 + 2*sin(x)^2", Zero),
        ("cos(x) - 2*cos(x/2)^2 + 1", Zero),
        ("sin(x/3 + y/2) - sin(x/3)*cos(y/2) - cos(x/3)*sin(y/2)", Zero),
        ("tan(x) - sin(x)/cos(x)", Zero),
        ("tan(2*x) - 2*tan(x)/(1 - tan(x)^2)", Zero),
        ("sin(x*(y + 1)) - sin(x*y)*cos(x) - cos(x*y)*sin(x)", Zero),
        ("cos((x + y)^2) - cos(x^2 + 2*x*y + y^2)", Zero),
        ("cos(x)*cos(x + pi/3) - (cos(2*x + pi/3) + 1/2)/2", Zero),
        ("2*cos(pi/7)*cos(2*pi/7) - cos(3*pi/7) - cos(pi/7)", Zero),
        ("cos(pi/7) - cos(2*pi/7) + cos(3*pi/7) - 1/2", Zero),
        ("cos(pi/7) - cos(2*pi/7) + cos(3*pi/7) + 1/2", NonZero),
        ("2*cos(pi/16)^2 - 1 - cos(pi/8)", Unknown), // nested roots: the sign is not decided
        ("(sqrt(2) + 1)*(sqrt(3) + 1) - sqrt(6) - sqrt(2) - sqrt(3) - 1", Zero),
        ("(sqrt(2) + 1)^2 - 3 - 2*sqrt(2)", Zero),
        ("sqrt(2) + sqrt(3) - sqrt(10)", NonZero),
        ("2*cos(pi/5)*cos(pi/7) - cos(12*pi/35) - cos(2*pi/35)", Zero),
        ("sinh(x)^2 - cosh(x)^2 + 1", Zero),
        ("exp(x + y) - exp(x)*exp(y)", Zero),
        ("cosh(x) - (exp(x) + exp(-x))/2", Zero),
        ("tanh(x) - sinh(x)/cosh(x)", Zero),
        ("exp(x) - 1 - x", NonZero),
        ("exp(x + ln(y)) - y*exp(x)", Zero),
        ("ln(x) - ln(x)", Zero),
        ("ln(x*y) - ln(x) - ln(y)", Unknown),
        ("x*ln(y) - ln(y)*x", Zero),
        ("ln(x + y)*(x - y) - x*ln(x + y) + y*ln(x + y)", Zero),
        ("sqrt(x^2 + y^2)*sqrt(x^2 + y^2) - x^2 - y^2", Zero),
        ("(z + sqrt(x + y))*(z - sqrt(x + y)) - z^2 + x + y", Zero),
        ("1/(z + sqrt(x + y)) - (z - sqrt(x + y))/(z^2 - x - y)", Zero),
        ("x/sqrt(x^2 + y^2) - x*sqrt(x^2 + y^2)/(x^2 + y^2)", Zero),
        ("sqrt(x^2 + 2*x*y + y^2) - abs(x + y)", Zero),
        ("sqrt(x^2 + 2*x*y + y^2) - x - y", Unknown),
        ("sqrt(3 + 2*sqrt(2)) - 1 - sqrt(2)", Unknown),
        ("sqrt(3 + 2*sqrt(2)) + 1 + sqrt(2)", Unknown),
        ("(x^2 + y)^(1/3)*(x + 1) - x*(x^2 + y)^(1/3) - (x^2 + y)^(1/3)", Zero),
        ("cos(2*acos(x)) - 2*x^2 + 1", Zero),
        ("sin(2*atan(x)) - 2*x/(1 + x^2)", Zero),
        ("cos(atan2(y, x) + z)*sqrt(x^2 + y^2) - x*cos(z) + y*sin(z)", Zero),
        ("abs(x)*abs(y) - abs(x*y)", Zero),
        ("x^(y + 1) - x*x^y", Zero),
        ("sin(cos(x)^2) - sin(1 - sin(x)^2)", Unknown),
        ("pi - 3", NonZero),
        ("x", NonZero),
        ("1/0", Unknown),
    ];
    let mut failures = String::new();
    for (text, expected) in cases {
        let mut pool = pool();
        let e = read(&mut pool, text);
        let verdict = pool.is_zero(e);
        if verdict != expected {
            failures += &format!("{text} ({}): {verdict:?}, not {expected:?}\n", pool.display(e));
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}

#[test]
fn norms_are_invariant_under_rotation() {
    // A generator of rotation applied to the distance of two points.
    let mut pool = pool();
    let e = read(&mut pool, "sqrt((x - a)^2 + (y - b)^2)");
    let (x, y, a, b) = (pool.symbol("x"), pool.symbol("y"), pool.symbol("a"), pool.symbol("b"));
    let (ex, ey, ea, eb) = (pool.symbol_expr(x), pool.symbol_expr(y), pool.symbol_expr(a), pool.symbol_expr(b));
    let (mx, ma) = (pool.neg(ex), pool.neg(ea));
    let seeds = Seeds::from([(x, ey), (y, mx), (a, eb), (b, ma)]);
    let d = pool.derivation(&[e], &seeds)[0];
    assert_eq!(pool.is_zero(d), ZeroVerdict::Zero);
}

/// Gauss's sum over cos(2πa²/q), or sin for q = 3 modulo 4, is sqrt(q): roots of unity and of primes belong together modulo the
/// prime of the test, which has no roots of unity of order 37.
#[test]
fn roots_of_primes_are_sums_of_roots_of_unity() {
    for q in [3_i64, 5, 7, 11, 13, 17, 19, 23, 29, 31, 41, 797, 37] {
        let mut pool = Pool::default();
        let pi = pool.pi();
        let terms: Vec<_> = (0..q)
            .map(|a| {
                let angle = pool.number(Number::ratio(2 * a * a, q).unwrap());
                let angle = pool.mul(angle, pi);
                if q % 4 == 1 { pool.cos(angle) } else { pool.sin(angle) }
            })
            .collect();
        let sum = pool.sum(&terms);
        let number = pool.number(Number::from(q));
        let root = pool.sqrt(number);
        let difference = pool.sub(sum, root);
        let verdict = pool.is_zero(difference);
        assert_eq!(verdict == ZeroVerdict::Zero, q != 37, "{q}: {verdict:?}");
        let shifted = pool.add(sum, root);
        assert_ne!(pool.is_zero(shifted), ZeroVerdict::Zero, "{q}");
    }
}
