//! Derivatives by dual numbers.
#![cfg(feature = "engine")]

use librate::precision::{Ball, Scalar};
use librate_core::precision::{Dual, Function};

/// Derivatives against differences of 1e-8 beside 0.7.
#[test]
fn slopes_are_those_of_the_functions() {
    let x = Dual { value: Ball::exact(0.7), slope: Ball::ONE };
    type Case = (&'static str, fn(&Dual<Ball>) -> Dual<Ball>);
    let functions: [Case; 20] = [
        ("sin", |x| x.apply(Function::Sin)),
        ("cos", |x| x.apply(Function::Cos)),
        ("tan", |x| x.apply(Function::Tan)),
        ("asin", |x| x.apply(Function::Asin)),
        ("acos", |x| x.apply(Function::Acos)),
        ("atan", |x| x.apply(Function::Atan)),
        ("sinh", |x| x.apply(Function::Sinh)),
        ("cosh", |x| x.apply(Function::Cosh)),
        ("tanh", |x| x.apply(Function::Tanh)),
        ("exp", |x| x.apply(Function::Exp)),
        ("ln", |x| x.apply(Function::Ln)),
        ("abs", |x| x.neg().apply(Function::Abs)),
        ("sqrt", Scalar::sqrt),
        ("powi", |x| x.powi(5)),
        ("inverse", |x| x.powi(-3)),
        ("pow", |x| x.pow(x)),
        ("div", |x| x.sqrt().div(&x.powi(2))),
        ("sub", |x| x.sqrt().sub(&x.mul(x))),
        ("atan2", |x| x.powi(2).atan2(&x.sqrt())),
        ("zeroth", |x| x.powi(0)),
    ];
    let step = Ball::exact(1e-8);
    for (name, function) in functions {
        let at = |shift: Ball| {
            let moved = Dual { value: x.value + shift, slope: Ball::ZERO };
            function(&moved).value
        };
        let difference = (at(step) - at(-step)) / (step + step);
        let own = function(&x).slope;
        let off = (own - difference).mid_f64().abs();
        assert!(off < 1e-13 * (1.0 + own.mid_f64().abs()), "{name}: {off:e}");
        assert!(own.radius < 1e-28, "{name}");
    }
}
