//! Parameters without a value may have any sign: what formulas, conditions, limits and times say then.
#![cfg(feature = "cli")]

use crate::common::model;

use librate::derive::{Derivation, Parts, derive};
use librate::expr::{ExprId, Tape};
use librate::linearize::linearize;
use librate::modes::{Options, Stability};
use librate::number::Number;
use librate::oscillation::normal_modes;
use librate::precision::Ball;
use librate::report::{Style, derive_text};

fn page(text: &str) -> Derivation {
    derive(&model(text), &Parts::default().frequencies(true)).unwrap()
}

/// An expression at values of parameters.
fn at(page: &Derivation, e: ExprId, values: &[(&str, f64)]) -> f64 {
    let pool = &page.pool;
    let symbols = pool.symbols_of(&[e]);
    let value = |name: &str| values.iter().find(|(own, _)| *own == name).unwrap().1;
    let numbers: Vec<Ball> = symbols.iter().map(|own| Ball::from(value(&pool.symbol_name(*own)))).collect();
    let tape = Tape::compile(pool, &[e], &symbols).unwrap();
    tape.evaluate(&numbers, &mut Vec::new())[0].mid_f64()
}

fn squares(page: &Derivation, values: &[(&str, f64)]) -> Vec<f64> {
    let case = &page.linear.as_ref().unwrap().frequencies.as_ref().unwrap().general;
    let repeated = case.frequencies.iter().flat_map(|own| vec![own.omega_squared; own.multiplicity]);
    let mut all: Vec<f64> = repeated.map(|own| at(page, own, values)).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Friction with a strength in bars takes energy whatever its sign, and s = -|a|/2m ± …
#[test]
fn bars_stay_where_no_sign_is_known() {
    let own = page("param m, k, a  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*abs(a)*x'^2");
    let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap();
    assert!(found.complete);
    let values = [("m", 1.37), ("k", 0.72), ("a", -0.35)];
    for exponent in &found.exponents {
        let exact = -0.35 / (2.0 * 1.37);
        assert!((at(&own, exponent.real, &values) - exact).abs() < 1e-15);
        let ratio = exponent.damping_ratio.map(|own_ratio| at(&own, own_ratio, &values));
        assert!(ratio.is_none_or(|ratio| (ratio - 0.35 / (2.0 * (1.37_f64 * 0.72).sqrt())).abs() < 1e-15));
    }
    // c/(2 m w) for a rate w of either sign.
    let own = page("param m, w, c  coord x  T = 1/2*m*x'^2  V = 1/2*m*w^2*x^2  dissipation = 1/2*c*x'^2");
    let exponents = &own.linear.as_ref().unwrap().exponents.as_ref().unwrap().exponents;
    for ratio in exponents.iter().filter_map(|own| own.damping_ratio) {
        assert!((at(&own, ratio, &[("m", 2.0), ("w", -3.0), ("c", 0.5)]) - 0.5 / 12.0).abs() < 1e-15);
    }
    // ω₁ω₂ = |k|/m, and ω₁² + ω₂² = 2|k|/m + c²/m².
    let own = page(
        "param m, c, k  coord x, y
         lagrangian = 1/2*m*(x'^2 + y'^2) + 1/2*c*(x*y' - y*x') - 1/2*abs(k)*(x^2 + y^2)",
    );
    let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap();
    let values = [("m", 1.5), ("c", 0.7), ("k", -2.0)];
    let sum: f64 = found.exponents.iter().map(|one| at(&own, one.imaginary, &values).powi(2)).sum();
    assert!((sum - 2.0 * (4.0 / 1.5 + 0.49 / 2.25)).abs() < 1e-14, "{sum}");
}

/// The amplitudes of modes with xᵀMx = 1 of a mass in bars.
#[test]
fn norms_keep_bars_below_roots() {
    let own = page("param m, k, c  coord x, y  T = 1/2*abs(m)*(x'^2 + y'^2)  V = 1/2*k*(x^2 + y^2) + 1/2*c*(x - y)^2");
    let case = &own.linear.as_ref().unwrap().frequencies.as_ref().unwrap().general;
    for mode in &case.normal.as_ref().unwrap().modes {
        for amplitude in &mode.amplitudes {
            let value = at(&own, *amplitude, &[("m", -2.0), ("k", 1.0), ("c", 0.3)]);
            assert!((value.abs() - 0.5).abs() < 1e-15, "{value}");
        }
    }
}

/// Each root is drawn with both signs for itself, and what is repeated stays apart from what is not.
#[test]
fn limits_draw_no_root_with_a_wrong_sign() {
    let mut own = page(
        "param m, k, a, d  coord x, y  T = 1/2*m*(x'^2 + y'^2)
         V = 1/2*(k + abs(a))*x^2 + 1/2*(k + a)*y^2 + d*x*y",
    );
    own.limit("d", &Number::ZERO);
    let found = squares(&own, &[("m", 1.0), ("k", 2.0), ("a", -1.0)]);
    assert!(found.len() == 2 && (found[0] - 1.0).abs() < 1e-14 && (found[1] - 3.0).abs() < 1e-14, "{found:?}");
    for potential in ["1/2*abs(a*b)*x^2 + 1/2*c*x^2", "1/2*sqrt(a^2 + c)*sqrt(b^2 + c)*x^2"] {
        let mut own = page(&format!("param a, b, c  coord x  T = 1/2*x'^2  V = {potential}"));
        own.limit("c", &Number::ZERO);
        assert_eq!(squares(&own, &[("a", -2.0), ("b", 3.0)]), [6.0], "{potential}");
    }
}

/// ζ = -Re s/|s| is negative where motions grow, whatever the sign of what damps them.
#[test]
fn damping_ratios_have_the_sign_of_the_friction() {
    for (text, values, want) in [
        (
            "param m, k, c  coord x, u  T = m/2*x'^2  V = k/2*u^2  dissipation = c/2*(x' - u')^2",
            [("m", 2.0), ("k", 3.0), ("c", 4.0)],
            6f64.sqrt() / 8.0,
        ),
        (
            "param m, k, c  coord x  T = m/2*x'^2  V = k/2*x^2  dissipation = c/2*x'^2",
            [("m", 2.0), ("k", 3.0), ("c", 1.0)],
            0.5 / 6f64.sqrt(),
        ),
    ] {
        let own = page(text);
        let found = &own.linear.as_ref().unwrap().exponents.as_ref().unwrap().exponents;
        let ratio = found.iter().find_map(|own| own.damping_ratio).unwrap();
        let [m, k, c] = values;
        for (c, want) in [(c, want), ((c.0, -c.1), -want)] {
            assert!((at(&own, ratio, &[m, k, c]) - want).abs() < 1e-15, "{text}");
        }
    }
}

/// Exponents in a limit are those of the polynomial there, where they are shorter or more: no root of minus a square.
#[test]
fn limits_of_exponents_are_zeros_of_the_polynomial_there() {
    let top = "param A, C, n, h  coord x, y
        lagrangian = A/2*(x'^2 + y'^2) + C*n/2*(x*y' - y*x') + h/2*(x^2 + y^2)";
    let chain = "param m, k, c  coord x[1..3]  T = sum(i in 1..3, m/2*x[i]'^2)
        V = sum(i in 1..2, k/2*(x[i+1] - x[i])^2) + k/2*x[1]^2 + k/2*x[3]^2  dissipation = c/2*x[1]'^2";
    let [z, t] = [2f64.sqrt(), 1.5f64.sqrt()];
    for (text, name, want) in [
        (top, "h", vec![-1.05, 0.0, 0.0, 1.05]),
        (chain, "c", [-t, t].iter().flat_map(|t| [(2.0 - z).sqrt(), z, (2.0 + z).sqrt()].map(|z| z * t)).collect()),
    ] {
        let mut own = page(text);
        own.limit(name, &Number::ZERO);
        let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap();
        assert!(found.complete && found.exponents.iter().all(|one| own.pool.display(one.real) == "0"), "{text}");
        let values = [("A", 2.0), ("C", 3.0), ("n", 0.7), ("m", 2.0), ("k", 3.0)];
        let repeated = found.exponents.iter().flat_map(|own| vec![own.imaginary; own.multiplicity]);
        let mut all: Vec<f64> = repeated.map(|one| at(&own, one, &values)).collect();
        let mut want: Vec<f64> = want;
        [&mut all, &mut want].into_iter().for_each(|all| all.sort_by(f64::total_cmp));
        assert!(all.len() == want.len() && all.iter().zip(&want).all(|(a, b)| (a - b).abs() < 1e-14), "{all:?}");
    }
}

/// Values are drawn for parameters that roots exist for: no frequency is lost, nor one that is no vibration anywhere.
#[test]
fn what_stands_below_roots_is_drawn_positive() {
    for text in [
        "param m, a, s  coord x  T = m/2*x'^2  V = sqrt(a - s)*x^2/2",
        "param m, a, b, s  coord x  T = m/2*x'^2  V = s*x^3/3 - b*x^2/2 + a*x/4
         equilibrium x = (b + sqrt(b^2 - a*s))/(2*s)",
    ] {
        let found = squares(&page(text), &[("m", 2.0), ("a", 3.0), ("b", 4.0), ("s", 1.0)]);
        let want = if text.contains('b') { 13f64.sqrt() / 2.0 } else { 2f64.sqrt() / 2.0 };
        assert!(found.len() == 1 && (found[0] - want).abs() < 1e-14, "{found:?}");
    }
}

/// With a₁ = -a₂ a limit of a₂ is one of both, and is not what is asked for.
#[test]
fn limits_of_opposites_are_not_told() {
    let mut own = page(
        "param m = 1, k = 1, K = 1, a1 = 0.1, a2 = -0.1, c = 0.05
         coord x1, x2, x3
         T = 1/2*m*(x1'^2 + x2'^2 + x3'^2)
         V = 1/2*k*(x1^2 + x3^2) + 1/2*K*x2^2 + a1*x1*x2 + a2*x2*x3 + c*x1*x3",
    );
    own.limit("a2", &Number::ZERO);
    assert!(own.linear.unwrap().frequencies.unwrap().tied.is_none());
}

/// A free particle seen from a turning frame has equal exponents, and goes away: they have to be different, as K is negative.
#[test]
fn equal_exponents_are_excluded_where_no_energy_keeps_motions() {
    let positive = |own: &Derivation, values: &[(&str, f64)]| {
        let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap().stability.clone().unwrap();
        found.iter().all(|one| at(own, one.positive, values) > 0.0)
    };
    let own = page(
        "param w, s  coord x, y
         lagrangian = 1/2*((x' - w*y)^2 + (y' + w*x)^2) - 1/2*s^2*(x^2 + y^2)",
    );
    assert!(!positive(&own, &[("w", 1.0), ("s", 0.0)]));
    assert!(positive(&own, &[("w", 1.0), ("s", 0.5)]) && positive(&own, &[("w", 1.0), ("s", 2.0)]));
    let own = page(
        "param p, r  coord x, y
         lagrangian = 1/2*(x'^2 + y'^2) + (p + r)/2*(x*y' - y*x') + p*r/2*(x^2 + y^2)",
    );
    assert!(!positive(&own, &[("p", 1.0), ("r", 1.0)]) && positive(&own, &[("p", 1.0), ("r", 2.0)]));
    // Foucault's pendulum has a minimum of the energy: nothing more is asked for.
    let own = page(
        "param m, k, W  assume m > 0, k > 0  coord x, y
         lagrangian = 1/2*m*(x'^2 + y'^2) + m*W*(x*y' - y*x') - 1/2*k*(x^2 + y^2)",
    );
    assert!(positive(&own, &[("m", 1.0), ("k", 1.0), ("W", 0.0)]));
}

/// Dry friction has no value at rest, and an equation.
#[test]
fn dry_friction_stands_in_the_equation() {
    let text = "param m, k, mu  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = mu*abs(x')";
    let own = derive(&model(text), &Parts::all()).unwrap();
    let shown = derive_text(&own, &Style::default());
    assert!(shown.contains("k x + ─── = 0"), "{shown}");
    assert!(!shown.contains("1/0"));
}

/// Derivatives of what jumps vanish; kicks are no constant forces.
#[test]
fn kicks_do_not_drop_out() {
    for of_time in ["atan(tan(t))", "atan2(sin(t), cos(t))", "sqrt(1 - sin(t)^2)/cos(t)"] {
        let text = format!("param m = 1, k = 1  coord x  lagrangian = 1/2*m*x'^2 - 1/2*k*x^2 + x'*{of_time}");
        assert!(linearize(model(&text)).is_err(), "{of_time}");
    }
    // What does drop out: the total time derivative of x sqrt(1 + t²).
    let text = "coord x  lagrangian = 1/2*x'^2 - 1/2*x^2 + x'*sqrt(1 + t^2) + x*t/sqrt(1 + t^2)";
    assert!(linearize(model(text)).is_ok());
}

/// The conditions of stability of a page.
fn conditions(own: &Derivation) -> Option<Vec<String>> {
    let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap().stability.clone()?;
    Some(found.iter().map(|one| own.reduced().pool.display(one.positive)).collect())
}

/// sqrt(a + b) and sqrt(k) are no independent symbols: s² + k + sqrt(a + b) divides the determinant, K is singular.
#[test]
fn roots_of_one_symbol_are_not_independent() {
    let own = page(
        "param a = 2, b = 3, k = 1, c = 1  coord x, y  T = 1/2*(x'^2 + y'^2)
         V = 1/2*(k + sqrt(a + b))*(x^2 + y^2) + 1/2*k*(sqrt(a + b)*x - y)^2
         dissipation = 1/2*c*(sqrt(a + b)*x' - y')^2",
    );
    assert_eq!(conditions(&own), None);
    // A block of Jordan of four at 0, with one of both signs of the root.
    let own = page(
        "param a = 1, b = 1  coord x, y  T = 1/2*(x'^2 + y'^2)  V = 0
         force x = -sqrt(a + 3*b)*x - y
         force y = (a + 3*b)*x + sqrt(a + 3*b)*y",
    );
    assert_eq!(conditions(&own), None);
}

/// What is positive or 0 is 0 for some values, as squares are; and what equal parameters need says nothing of others.
#[test]
fn stability_at_zero_is_excluded() {
    let of = |text: &str| conditions(&page(&format!("coord x, y  {text}"))).unwrap();
    let free = "T = 1/2*(x'^2 + y'^2)  V = 1/2*a*(x^2 + y^2)  dissipation = 1/2*(x'^2 + y'^2)";
    assert_eq!(of(&format!("param a = 0  assume a >= 0  {free}")), ["a"]);
    assert_eq!(of(&format!("param a = 1  assume a > 0  {free}")), [""; 0]);
    let turned = "param k, g  T = 1/2*(x'^2 + y'^2) + g*(x*y' - y*x')  V = 1/2*k*(x^2 + y^2)";
    assert_eq!(of(turned), ["k + g^2", "k^2"]);
    let own = page("param a, b  coord x  T = 1/2*x'^2  V = 1/2*(a - b)^2*x^2");
    assert_eq!(conditions(&own).unwrap(), ["(b - a)^2"]);
    let own = page(
        "param n = 7, k[1..8] = 1, D = 100  coord x[1..n]  T = sum(i in 1..n, 1/2*x[i]'^2)
         V = sum(i in 1..n-1, 1/2*k[i+1]*(x[i+1] - x[i])^2) + 1/2*k[1]*x[1]^2 + 1/2*k[8]*x[n]^2
           + D*(k[1] - k[2])*x[1]*x[7]",
    );
    assert_eq!(conditions(&own), None);
}

/// Friction of each of three dampers is more than is needed.
#[test]
fn conditions_that_are_too_strong_are_told() {
    let text = |[a, b, c]: [&str; 3]| {
        format!(
            "param k = 1, c1 = 1, c2 = 1, c3 = 1/100  coord x[1..3]  T = 1/2*dot(x', x')
             V = 1/2*k*(x[1]^2 + (x[2] - x[1])^2 + (x[3] - x[2])^2 + x[3]^2)
             dissipation = 1/2*({a}*x[1]'^2 + {b}*x[2]'^2 + {c}*x[3]'^2)"
        )
    };
    let of = |dampers: [&str; 3]| {
        let found = page(&text(dampers)).linear.unwrap().exponents.unwrap().stability.unwrap();
        found.iter().filter(|one| format!("{:?}", one.role) == "Sufficient").count()
    };
    // Long ones beside them are necessary, too.
    let own = page(&text(["c1", "c2", "c3"]));
    let exact = own.linear.as_ref().unwrap().exponents.as_ref().unwrap().stability_exact.as_ref().unwrap();
    let mut seen = [0, 0];
    for (c1, c2) in (-3..6).flat_map(|a| (-3..6).map(move |b| (a, b))) {
        let (c1, c2, c3) = (f64::from(c1) / 8.0, f64::from(c2) / 16.0, 0.01);
        let values = [("k", 1.0), ("c1", c1), ("c2", c2), ("c3", c3)];
        let holds = exact.iter().all(|one| at(&own, *one, &values) > 0.0);
        let numbers = text([&c1.to_string(), &c2.to_string(), "c3"]);
        let modes = normal_modes(&linearize(model(&numbers)).unwrap(), &Options::default()).unwrap();
        assert_eq!(holds, modes.stability == Stability::Stable, "{c1} {c2}");
        seen[usize::from(holds && (c1 < 0.0 || c2 < 0.0))] += 1;
    }
    assert!(seen.iter().all(|count| *count > 3), "{seen:?}");
    assert_eq!((of(["c1", "c2", "c3"]), of(["c1", "c1", "2*c1"])), (3, 0));
    // Two dampers of three may do, which short conditions tell.
    assert_eq!(of(["c1*c2", "c1^2*c2", "c1*c2"]), 0);
}

/// ω = √(k/m) ± W for k -> 0: the same frequency twice, and positive.
#[test]
fn limits_of_pairs_are_positive() {
    let mut own =
        page("param W = 1/2, k = 2, m = 2  coord x, y  T = 1/2*m*((x' - W*y)^2 + (y' + W*x)^2)  V = 1/2*k*(x^2 + y^2)");
    own.limit("k", &Number::ZERO);
    let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap();
    let all: Vec<(f64, usize)> =
        found.exponents.iter().map(|one| (at(&own, one.imaginary, &[("W", 0.5)]), one.multiplicity)).collect();
    assert_eq!(all, [(0.5, 2), (-0.5, 2)]);
}

/// Series and limits of exponents where a root becomes that of a square: whatever its sign, none is divided by zero, and none is called imaginary that is
/// real. The first of a pair is the positive one at the values.
#[test]
fn series_and_limits_of_exponents_have_their_values() {
    let exponents = |own: &Derivation, values: &[(&str, f64)]| -> Vec<(f64, f64)> {
        let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap();
        assert!(found.complete);
        let all = found.exponents.iter().flat_map(|one| vec![one; one.multiplicity]);
        all.map(|one| (at(own, one.real, values), at(own, one.imaginary, values))).collect()
    };
    let is_near = |found: &[(f64, f64)], want: &[(f64, f64)], tolerance: f64| {
        assert_eq!(found.len(), want.len(), "{found:?}");
        for own in want {
            let off = |other: &&(f64, f64)| (own.0 - other.0).abs().max((own.1 - other.1).abs()) < tolerance;
            assert!(found.iter().any(|other| off(&other)), "{found:?} {want:?}");
        }
    };
    // s⁴ + (k1 + k2 + h²) s² + k1 k2: the slow pair is √(k1 k2/(k2 + h²)) for small k1, and no series in k1 itself.
    for assumed in ["", "  assume k1 > 0, k2 > 0, h > 0"] {
        let mut own = page(&format!(
            "param k1 = 3, k2 = 4, h = 5  coord a, b
             lagrangian = 1/2*a'^2 + 1/2*b'^2 + h*a*b' - 1/2*k1*a^2 - 1/2*k2*b^2{assumed}"
        ));
        own.expand("k1", 1);
        let (slow, fast) = ((3e-6 * 4.0 / 29.0_f64).sqrt(), 29.0_f64.sqrt() * (1.0 + 25.0 / 2.0 * 3e-6 / 29.0 / 29.0));
        let found = exponents(&own, &[("k1", 3e-6), ("k2", 4.0), ("h", 5.0)]);
        is_near(&found, &[(0.0, slow), (0.0, -slow), (0.0, fast), (0.0, -fast)], 1e-9);
    }
    let damped = "param m = 1, k = 3, c = 0.4  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2";
    let values = [("m", 1.0), ("c", 0.4), ("k", 1e-4)];
    let [mut limit, mut series] = [page(damped), page(damped)];
    limit.limit("k", &Number::ZERO);
    is_near(&exponents(&limit, &values), &[(0.0, 0.0), (-0.4, 0.0)], 1e-15);
    series.expand("k", 1);
    is_near(&exponents(&series, &values), &[(-1e-4 / 0.4, 0.0), (1e-4 / 0.4 - 0.4, 0.0)], 1e-15);
    // The slow motion about a strong field, ω = e √(ab)/B + …: m² ω⁴ - (m e (a + b) + B²) ω² + e² ab = 0.
    let slow = "param m = 2, B = 3, a = 1, b = 2, e = 0.1  assume m > 0, B > 0, a > 0, b > 0  coord x, y
        lagrangian = 1/2*m*(x'^2 + y'^2) + 1/2*B*(x*y' - y*x') - 1/2*e*(a*x^2 + b*y^2)";
    let e = 1e-3_f64;
    let half = (2.0 * e * 3.0 + 9.0) / 8.0;
    let squares = [half - (half * half - e * e / 2.0).sqrt(), half + (half * half - e * e / 2.0).sqrt()];
    for order in 1..5 {
        let mut own = page(slow);
        own.expand("e", order);
        let found = exponents(&own, &[("m", 2.0), ("B", 3.0), ("a", 1.0), ("b", 2.0), ("e", e)]);
        let want = squares.map(f64::sqrt).map(|omega| [(0.0, omega), (0.0, -omega)]).concat();
        is_near(&found, &want, e.powi(order as i32 + 1).max(1e-12));
    }
    // ω = e √(k (k + h)/(9 + 2 k + 2 h)) + …, where a factor 0 hides what is divided by 0.
    let mut own = page(
        "param k = 1/2, h = 5, e = 2  coord x, y
         lagrangian = x'^2 + 1/2*y'^2 + 3/2*(x*y' - y*x') - 1/2*k*e^2*x^2 - 1/2*(k + h)*y^2",
    );
    own.expand("e", 1);
    let (slow, fast) = (1e-6 * (0.5 * 5.5 / 20.0_f64).sqrt(), 10.0_f64.sqrt());
    let found = exponents(&own, &[("k", 0.5), ("h", 5.0), ("e", 1e-6)]);
    is_near(&found, &[(0.0, slow), (0.0, -slow), (0.0, fast), (0.0, -fast)], 1e-11);
    // (k + h)/m < 0: √f and √(1/f) in one sum would be one of them times -1; in front of the sum there is a single one.
    let mut own = page(
        "param m = 3/2, k = 3/2, h = -2, e = 2  coord x, y
         lagrangian = 1/2*m*(x'^2 + y'^2) + 1/2*e*(x*y' - y*x') - 1/2*(k + e)*(x^2 + y^2) - h*x*y",
    );
    own.expand("e", 1);
    let page_text = derive_text(&own, &Style::default().ascii(true));
    // What oscillates at e = 2 grows for small e.
    assert!(page_text.contains("sqrt(-(k + h)/m)*(1 + 1/2*e/(k + h))"), "{page_text}");
    // m² z² + m (k1 + k2 + 2 m W²) z + k1 k2 - m W² (k1 + k2) + m² W⁴ with z = s² near k1 and near k2.
    let saddle = "param m = 1, k1 = 1, k2 = -0.5, W = 3  coord x, y
        lagrangian = 1/2*m*(x'^2 + y'^2) + m*W*(x*y' - y*x') + 1/2*m*W^2*(x^2 + y^2) - 1/2*k1*x^2 - 1/2*k2*y^2";
    let mut own = page(saddle);
    own.expand("W", 2);
    let turns = 1e-3_f64;
    let middle = -0.25 - turns * turns;
    let root = (middle * middle + 0.5 + turns * turns * 0.5 - turns.powi(4)).sqrt();
    let [growth, omega] = [(middle + root).sqrt(), (root - middle).sqrt()];
    let found = exponents(&own, &[("m", 1.0), ("k1", 1.0), ("k2", -0.5), ("W", turns)]);
    is_near(&found, &[(growth, 0.0), (-growth, 0.0), (0.0, omega), (0.0, -omega)], 1e-11);
    let mut own = page(saddle);
    own.limit("W", &Number::ZERO);
    let (growth, values) = (0.5_f64.sqrt(), [("m", 1.0), ("k1", 1.0), ("k2", -0.5)]);
    is_near(&exponents(&own, &values), &[(growth, 0.0), (-growth, 0.0), (0.0, 1.0), (0.0, -1.0)], 1e-15);
    // Without inertia one exponent is left, -k/c; the other one grows without bound.
    let [mut limit, mut series] = [page(damped), page(damped)];
    limit.limit("m", &Number::ZERO);
    series.expand("m", 2);
    let texts = [limit, series].map(|own| derive_text(&own, &Style::default().ascii(true)));
    let wanted = ["for m -> 0\n  s = -k/c\n", "order 2 in m\n  s = -k/c - m*k^2/c^3 - 2*m^2*k^3/c^5\n"];
    // Weak friction, where there are no closed forms with any, or others at the values: two meshes with a common resistance; an overdamped oscillator.
    let mut meshes = page(
        "param L = 1, M = 2, C = 1, D = 3, R = 0.1  coord p, q  T = 1/2*L*p'^2 + 1/2*M*q'^2
         V = p^2/(2*C) + q^2/(2*D)  dissipation = 1/2*R*(p' - q')^2",
    );
    meshes.expand("R", 1);
    let values = [("L", 1.0), ("M", 2.0), ("C", 1.0), ("D", 3.0), ("R", 1e-4)];
    let slow = (1.0_f64 / 6.0).sqrt();
    is_near(&exponents(&meshes, &values), &[(-5e-5, 1.0), (-5e-5, -1.0), (-2.5e-5, slow), (-2.5e-5, -slow)], 1e-15);
    let mut own = page("param m = 1, k = 3, c = 30  coord x  T = 1/2*m*x'^2  V = 1/2*k*x^2  dissipation = 1/2*c*x'^2");
    own.expand("c", 2);
    let omega = 3.0_f64.sqrt() * (1.0 - 1e-6 / 24.0);
    let values = [("m", 1.0), ("k", 3.0), ("c", 1e-3)];
    is_near(&exponents(&own, &values), &[(-5e-4, omega), (-5e-4, -omega)], 1e-13);
    // ω² = a ∓ k where a = b, which no series in k of the forms for a ≠ b has.
    let coupled = "coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = 1/2*a*x^2 + 1/2*b*y^2 + k*x*y";
    for (values, is_found) in [("param a = 2, b = 2, k = 1 ", false), ("param a = 2, b = 3, k = 1 ", true)] {
        let mut own = page(&format!("{values}{coupled}"));
        own.expand("k", 1);
        let text = derive_text(&own, &Style::default().ascii(true));
        assert_eq!(text.contains("no closed form was found, to order 1 in k"), !is_found, "{text}");
    }
    // No closed form with friction and rotation, but without friction, or without rotation.
    for (parameter, count) in [("c", 4), ("h", 4)] {
        let mut own = page(
            "param m = 1, a = 3, b = 2, h = -1, c = 0.1  coord x, y  dissipation = 1/2*c*(x'^2 + y'^2)
             lagrangian = 1/2*m*(x'^2 + y'^2) + 2*m*h*x*y' - 1/2*a*x^2 - 1/2*b*y^2",
        );
        assert!(!own.linear.as_ref().unwrap().exponents.as_ref().unwrap().complete);
        own.limit(parameter, &Number::ZERO);
        let found = exponents(&own, &[("m", 1.0), ("a", 3.0), ("b", 2.0), ("h", -1.0), ("c", 0.1)]);
        assert_eq!(found.len(), count);
        for (re, im) in found {
            let [h, c] = if parameter == "c" { [-1.0, 0.0] } else { [0.0, 0.1] };
            let s = nalgebra::Complex::new(re, im);
            let [first, second] = [3.0, 2.0].map(|k| s * s + s * c + k);
            let value = first * second + s * s * 4.0 * h * h;
            assert!(value.norm() < 1e-12, "{parameter} {s} {value}");
        }
    }
    texts.iter().zip(wanted).for_each(|(own, wanted)| assert!(own.contains(wanted), "{own}"));
    let mut own = page(
        "param m = 5, e = 2  coord x, y
         lagrangian = 1/2*m*x'^2 + 1/2*m*y'^2 + 1/2*e*(x*y' - y*x') - 1/2*x^2 - 1/2*y^2 - e*x*y",
    );
    own.limit("e", &Number::ZERO);
    let omega = 0.2_f64.sqrt();
    is_near(&exponents(&own, &[("m", 5.0)]), &[(0.0, omega), (0.0, omega), (0.0, -omega), (0.0, -omega)], 1e-15);
    let positive = |own: &Derivation, values: &[(&str, f64)]| {
        exponents(own, values).chunks(2).for_each(|pair| assert!(pair[0].1 >= 0.0, "{pair:?}"));
    };
    let larmor = "param q = -1, B = 2, m = 1, k = 3  coord x, y
        lagrangian = 1/2*m*(x'^2 + y'^2) + q*B/2*(x*y' - y*x') - 1/2*k*(x^2 + y^2)";
    let values = [("q", -1.0), ("B", 2.0), ("m", 1.0), ("k", 3.0)];
    let [mut limit, mut series] = [page(larmor), page(larmor)];
    limit.limit("k", &Number::ZERO);
    positive(&limit, &values);
    series.expand("k", 1);
    positive(&series, &values);
    let mut own =
        page("param A = 1, k = 3, h = 0.4  coord a, b  lagrangian = 1/2*A*(a'^2 + b'^2) + h*a*b' - 1/2*k*(a^2 + b^2)");
    own.expand("h", 3);
    positive(&own, &[("A", 1.0), ("k", 3.0), ("h", 0.1)]);
}

/// A parameter that is tiny makes no two values one, and no bars are dropped from friction.
#[test]
fn what_is_small_or_in_bars_is_not_lost() {
    let own =
        page("param k = 1, e = 1e-36, m = 1  coord x, y  T = 1/2*m*(x'^2 + y'^2)  V = 1/2*k*x^2 + 1/2*(k + e)*y^2");
    let found = squares(&own, &[("k", 1.0), ("e", 3.0), ("m", 1.0)]);
    assert_eq!(found, [1.0, 4.0]);
    let own = page(
        "param k = 1, c1 = 1, c2 = 1.5  coord x  T = 1/2*x'^2  V = 1/2*k*x^2  dissipation = 1/2*abs(c1 - c2)*x'^2",
    );
    let found = own.linear.as_ref().unwrap().exponents.as_ref().unwrap();
    let values = [("k", 1.0), ("c1", 1.5), ("c2", 1.0)];
    assert!(found.exponents.iter().all(|one| at(&own, one.real, &values) == -0.25));
    assert!(found.exponents.iter().all(|one| at(&own, one.damping_ratio.unwrap(), &values) == 0.25));
}
