//! Exponents and stability in symbols, to read.

use super::frequencies::{approximations, first_free, unused};
use super::page::{Form, Line, Part, section};
use librate_core::derive::{ClosedExponent, Derivation, Exponents, Linear, Role, StabilityCondition, greater_and_less};
use librate_core::expr::{ExprId, Node, Pool};
use librate_core::number::Number;

/// A characteristic polynomial with more characters is no help on a page.
const MOST_CHARACTERS: usize = 2000;
/// The same for a zero of it.
const MOST_IN_FORM: usize = 500;
/// Where one condition has more than these, there are none on the page.
const MOST_IN_CONDITION: usize = 240;
/// Nor where there are more of them: those of a lattice, one for each wave.
const MOST_CONDITIONS: usize = 12;
/// What conditions may leave open.
const SPECIAL: &str = ", but for special values of the parameters";

/// What the page has beside frequencies: of conservative models what stability needs, of others the characteristic equation and its
/// zeros too. `names` are those of the whole model.
pub(super) fn exponent_parts(derivation: &Derivation, linear: &Linear, names: &Derivation) -> Vec<Part> {
    let mut parts = Vec::new();
    let Some(own) = &linear.exponents else { return parts };
    let pool = &mut derivation.pool.clone();
    let s = unused(names, &["s", "lambda", "sigma"]);
    // Of conservative models frequencies say as much, unless one asks.
    let asked = |chapter: &str| !linear.is_conservative() || names.only.is_some() && names.shows(chapter);
    if asked("characteristic") || asked("exponents") {
        let all = own.characteristic.as_ref().filter(|_| names.shows("characteristic"));
        if let Some(equation) = all.map(|all| characteristic_text(derivation, all, &s)) {
            let is_long = equation.len() > MOST_CHARACTERS;
            let title = if is_long {
                "the characteristic equation, too long for a page, is in the JSON"
            } else {
                "characteristic equation"
            };
            parts.push(section(title, Some(equation).filter(|_| !is_long)));
        }
        let only = linear.is_conservative() && asked("exponents");
        let undamped = !only && linear.damping.is_none() && own.exponents.iter().all(|own| own.real == pool.zero());
        form_parts(pool, own, names, Some(names.names.omega.as_str()).filter(|_| undamped), &mut parts);
    }
    stability_parts(pool, own, names, asked("stability"), &mut parts);
    parts
}

/// The closed forms, as frequencies `omega` where nothing is damped.
fn form_parts(pool: &mut Pool, own: &Exponents, names: &Derivation, omega: Option<&str>, parts: &mut Vec<Part>) {
    let (zero, s) = (pool.zero(), unused(names, &["s", "lambda", "sigma"]));
    // Of a conjugate pair the one with the positive imaginary part comes first.
    let shown = names.shows("frequencies") || names.shows("exponents");
    let mut lines = Vec::new();
    let mut is_long = false;
    let mut told: Vec<&ClosedExponent> = Vec::new();
    for exponent in &own.exponents {
        let opposite = pool.neg(exponent.imaginary);
        if told.iter().any(|other| other.real == exponent.real && other.imaginary == opposite) {
            continue;
        }
        told.push(exponent);
        let mut remark = String::new();
        let many = exponent.multiplicity;
        let text = if let Some(omega) = omega {
            let many = if exponent.imaginary == zero { many / 2 } else { many };
            if many > 1 {
                remark = format!(", {many} times");
            }
            format!("{omega} = {}", pool.display(exponent.imaginary))
        } else {
            if exponent.imaginary != zero {
                remark.push_str(", and its conjugate");
            }
            if many > 1 {
                remark.push_str(&format!(", {many} times"));
            }
            format!("{s} = {}", exponent_text(pool, exponent, &imaginary_unit(names)))
        };
        if shown && text.len() <= MOST_IN_FORM {
            lines.push(Line::Formula(text, remark));
        } else {
            is_long |= shown;
        }
    }
    let title = if omega.is_some() { "frequencies" } else { "exponents" };
    if shown && own.exponents.is_empty() && !own.approximations.is_empty() {
        let title = format!("no closed form was found{}", approximations(&own.approximations));
        parts.push(section(&title, []));
    }
    parts.extend(is_long.then(|| section(&format!("{title}, too long for a page, are in the JSON"), [])));
    if !lines.is_empty() {
        let rest = if own.complete { "" } else { " with a closed form" };
        let is_complex = omega.is_none() && own.exponents.iter().any(|own| own.imaginary != zero);
        let note = if is_complex { unit_note(&imaginary_unit(names)) } else { String::new() };
        let title = format!("{title}{rest}{}{note}", approximations(&own.approximations));
        parts.push(Part::Section(title, lines, Form::Apart));
    }
    if names.shows("exponents") {
        parts.extend(damping_part(pool, &own.exponents, names));
    }
}

/// Where a system is stable.
fn stability_parts(pool: &mut Pool, own: &Exponents, names: &Derivation, asked: bool, parts: &mut Vec<Part>) {
    let Some(all) = own.stability.as_ref().filter(|_| names.shows("stability")) else { return };
    let open: Vec<ExprId> = all.iter().filter_map(|own| own.open).collect();
    let is_told = |own: &StabilityCondition| own.role != Role::Special;
    let by_signs = all.iter().any(|own| is_told(own) && own.open != Some(own.positive));
    let with = if by_signs { ", with the signs that the parameters have" } else { "" };
    // Where odd coefficients vanish exponents that no friction meets are on the axis.
    let assumed = !names.assumptions.is_empty();
    // Squares count as positive. Of a condition that signs have made a number nothing is left open.
    let under = if assumed && !by_signs { ", under the assumptions" } else { "" };
    let has_parameters = own.characteristic.as_ref().is_none_or(|all| !pool.symbols_of(all).is_empty());
    let special = if own.settled { "" } else { SPECIAL };
    let hedge = if has_parameters { format!("{under}{special}") } else { String::new() };
    let is_number = |own: ExprId| pool.as_number(own).is_some();
    let definite = all.iter().any(|own| own.open.is_some_and(is_number) && !is_number(own.positive));
    let [always, mostly] = [by_signs, definite].map(|is_sure| if is_sure { "" } else { hedge.as_str() });
    let only_zeros = own.complete && own.exponents.iter().all(|own| own.real == own.imaginary);
    if open.iter().any(|own| pool.as_number(*own).is_some()) {
        // Numbers that are positive are no conditions.
        parts.push(section(&format!("unstable{with}{mostly}"), []));
    } else if !open.is_empty() {
        let texts: Vec<String> = open.into_iter().map(|own| condition_text(pool, own)).collect();
        if texts.len() <= MOST_CONDITIONS && texts.iter().all(|text| text.len() <= MOST_IN_CONDITION) {
            let is_special = |own: &StabilityCondition| own.role == Role::Special && own.open.is_some();
            let special = if all.iter().any(is_special) { SPECIAL } else { "" };
            parts.push(section(&format!("stable while{with}{special}"), texts));
        } else {
            parts.push(section("conditions of stability, too long for a page, are in the JSON", []));
        }
    } else if asked && !only_zeros {
        parts.push(section(&format!("stable{with}{always}"), []));
    }
}

/// Damping ratios and quality factors in symbols.
fn damping_part(pool: &mut Pool, exponents: &[ClosedExponent], names: &Derivation) -> Option<Part> {
    let mut ratios: Vec<ExprId> = exponents.iter().filter_map(|own| own.damping_ratio).collect();
    ratios.dedup();
    let (zeta, quality) = (unused(names, &["zeta", "D", "xi"]), unused(names, &["Q", "QF", "quality"]));
    let half = Number::half();
    let mut lines = Vec::new();
    for own in ratios {
        let inverse = pool.product_of_powers(&[(own, Number::MINUS_ONE)]);
        let inverse = pool.scale(inverse, &half);
        lines.push(format!("{zeta} = {}", pool.display(own)));
        lines.push(format!("{quality} = {}", pool.display(inverse)));
    }
    let title = format!("damping ratio and quality factor, of an oscillation where `{zeta}` < 1");
    (!lines.is_empty()).then(|| section(&title, lines))
}

/// `a > b` for the difference of the two, `a ≠ b` for its square.
fn condition_text(pool: &mut Pool, positive: ExprId) -> String {
    if is_square(pool, positive) {
        let mut factors = pool.factors(positive);
        factors.iter_mut().for_each(|(_, exponent)| *exponent = exponent.mul(&Number::half()));
        let base = pool.product_of_powers(&factors);
        let [left, _, right] = compared(pool, base);
        let is_number = left.parse::<f64>().is_ok();
        return if is_number { format!("{right} != {left}") } else { format!("{left} != {right}") };
    }
    compared(pool, positive).join(" ")
}

/// Whether an expression is that of what is different from 0.
fn is_square(pool: &Pool, positive: ExprId) -> bool {
    let factors = pool.factors(positive);
    pool.as_number(positive).is_none() && factors.iter().all(|(_, exponent)| exponent.mul(&Number::half()).is_integer())
}

/// What is positive as a relation: its left side, the sign, and the right side.
fn compared(pool: &mut Pool, positive: ExprId) -> [String; 3] {
    let relation = |left, sign: &str, right| [left, sign.to_owned(), right];
    if let Some([greater, less]) = greater_and_less(pool, positive) {
        let [more, product] = [greater, less].map(|side| pool.display(side));
        // 27*mu*(1 - mu) < 1
        let turned = !pool.is_sum(greater) && !more.contains('(') && product.contains('(');
        return if turned { relation(product, "<", more) } else { relation(more, ">", product) };
    }
    let text = pool.display(positive);
    if !text.starts_with('-') {
        return relation(text, ">", "0".to_owned());
    }
    let opposite = pool.neg(positive);
    relation(pool.display(opposite), "<", "0".to_owned())
}

/// The letter for the imaginary unit: `i`, unless that is a symbol of the model.
pub(super) fn imaginary_unit(names: &Derivation) -> String {
    // Expressions that the model names are written out where it stands.
    let is_symbol = |name: &str| names.symbols.keys().any(|own| own.split('[').next() == Some(name));
    first_free(&["i", "j", "I"], is_symbol)
}

/// What the imaginary unit is called, where that is not `i`.
pub(super) fn unit_note(unit: &str) -> String {
    if unit == "i" { String::new() } else { format!(", where `{unit}` is the imaginary unit") }
}

/// An exponent in the model language, with a letter for the imaginary unit.
pub(super) fn exponent_text(pool: &mut Pool, own: &ClosedExponent, unit: &str) -> String {
    let real = pool.display(own.real);
    if own.imaginary == pool.zero() {
        return real;
    }
    let unit = pool.variable(unit);
    let imaginary = pool.mul(unit, own.imaginary);
    let imaginary = pool.display(imaginary);
    if real == "0" { imaginary } else { sum_text([real, imaginary]) }
}

/// The sum of some terms, minus signs between them.
pub(super) fn sum_text(terms: impl IntoIterator<Item = String>) -> String {
    let mut out = String::new();
    for term in terms {
        match (out.is_empty(), term.strip_prefix('-')) {
            (true, _) => out.push_str(&term),
            (false, Some(size)) => out.push_str(&format!(" - {size}")),
            (false, None) => out.push_str(&format!(" + {term}")),
        }
    }
    out
}

/// `m*s^2 + c*s + k = 0`
fn characteristic_text(derivation: &Derivation, coefficients: &[ExprId], s: &str) -> String {
    let pool = &derivation.pool;
    let mut terms = Vec::new();
    for (power, own) in coefficients.iter().enumerate().rev().filter(|(_, own)| **own != pool.zero()) {
        let text = pool.display(*own);
        let several =
            matches!(pool.node(*own), Node::Sum { terms, constant } if terms.len() > 1 || !constant.is_zero());
        let (minus, size) = match text.strip_prefix('-') {
            Some(size) if !several || power == 0 => (true, size.to_owned()),
            Some(_) | None => (false, if several && power > 0 { format!("({text})") } else { text }),
        };
        let s = match power {
            0 => String::new(),
            1 => s.to_owned(),
            _ => format!("{s}^{power}"),
        };
        let term = match (size.as_str(), s.is_empty()) {
            (_, true) => size,
            ("1", false) => s,
            _ => format!("{size}*{s}"),
        };
        terms.push(if minus { format!("-{term}") } else { term });
    }
    format!("{} = 0", sum_text(terms))
}
