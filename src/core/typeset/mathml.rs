//! Formulas as MathML, with the elements of MathML Core.

use super::latex::stands_open;
use super::symbol::{Subscript, unicode_word};
use super::{Formula, Sign, Symbol};

impl Formula {
    /// The formula as an element `math`, displayed on a line of its own or within a line.
    #[must_use]
    pub fn mathml(&self, display: bool) -> String {
        let display = if display { " display=\"block\"" } else { "" };
        format!("<math{display}>{}</math>", self.element())
    }

    /// One element.
    fn element(&self) -> String {
        match self {
            Self::Number(digits) => tag("mn", digits),
            Self::Scientific { digits, exponent } => {
                let power = tag("msup", &(tag("mn", "10") + &tag("mn", &exponent.replace('-', "−"))));
                row(&[tag("mn", digits), operator("·"), power])
            }
            Self::Symbol(symbol) => symbol_element(symbol, None),
            Self::Indexed(inner, feet) => tag("msub", &(inner.element() + &feet_element(feet))),
            Self::Product(factors) => {
                let mut parts = Vec::new();
                for (at, factor) in factors.iter().enumerate() {
                    if at > 0 {
                        let digit = factor.begins_with_digit();
                        parts.push(operator(if digit { "·" } else { "&#x2062;" }));
                    }
                    parts.push(factor.element());
                }
                row(&parts)
            }
            Self::Sum(terms) => {
                let mut parts = Vec::new();
                for (at, (negative, term)) in terms.iter().enumerate() {
                    match (at, negative) {
                        (_, true) => parts.push(operator("−")),
                        (0, false) => {}
                        (_, false) => parts.push(operator("+")),
                    }
                    parts.push(term.element());
                }
                row(&parts)
            }
            Self::Fraction(above, below) => tag("mfrac", &(above.element() + &below.element())),
            Self::Power(base, exponent) => match &**base {
                Self::Symbol(symbol) => symbol_element(symbol, Some(exponent)),
                base => tag("msup", &(base.element() + &exponent.element())),
            },
            Self::Root(inner) => tag("msqrt", &inner.element()),
            Self::Function { name, power, arguments } => function_element(name, power.as_deref(), arguments),
            Self::Bars { double, inner } => {
                let bar = operator(if *double { "‖" } else { "|" });
                row(&[bar.clone(), inner.element(), bar])
            }
            Self::Parentheses(inner) => row(&[operator("("), inner.element(), operator(")")]),
            Self::Matrix(rows) => {
                let rows = rows.iter().map(|row| {
                    let cells: String = row.iter().map(|cell| tag("mtd", &cell.element())).collect();
                    tag("mtr", &cells)
                });
                row(&[operator("("), tag("mtable", &rows.collect::<String>()), operator(")")])
            }
            Self::Between { cross, sides } => {
                row(&[sides.0.element(), operator(if *cross { "×" } else { "·" }), sides.1.element()])
            }
            Self::Rate(inner) => {
                let upright = |text| tag("mtext", text);
                row(&[tag("mfrac", &(upright("d") + &upright("dt"))), inner.element()])
            }
            Self::Total { integral, below, above, body } => {
                let below = joined(below.iter().map(Self::element));
                let above = above.as_ref().map(|above| above.element());
                let sign = operator(if *integral { "∫" } else { "∑" });
                let sign = match (integral, above) {
                    (true, Some(above)) => tag("msubsup", &(sign + &below + &above)),
                    (true, None) => tag("msub", &(sign + &below)),
                    (false, Some(above)) => tag("munderover", &(sign + &below + &above)),
                    (false, None) => tag("munder", &(sign + &below)),
                };
                row(&[sign, body.element()])
            }
            Self::Differential(symbol) => row(&[tag("mtext", "d"), symbol_element(symbol, None)]),
            Self::Relation(parts) => row(&parts.iter().map(Self::element).collect::<Vec<_>>()),
            Self::Sign(Sign::If) => tag("mtext", "\u{2003}if\u{2002}"),
            Self::Sign(sign) => operator(match sign {
                Sign::Equal => "=",
                Sign::NotEqual => "≠",
                Sign::Less => "&lt;",
                Sign::LessEqual => "≤",
                Sign::Greater => "&gt;",
                Sign::GreaterEqual => "≥",
                Sign::In => "∈",
                Sign::Comma => ",",
                Sign::Not => "¬",
                Sign::And => "∧",
                Sign::Or | Sign::If => "∨",
            }),
            Self::Verbatim(text) => tag("mtext", &text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")),
        }
    }
}

fn function_element(name: &str, power: Option<&Formula>, arguments: &[Formula]) -> String {
    let name = tag("mi", if name == "exp" && arguments.is_empty() { "e" } else { name });
    let name = match power {
        Some(power) => tag("msup", &(name + &power.element())),
        None => name,
    };
    match arguments {
        [] => name,
        [one] if stands_open(arguments) => row(&[name, operator("&#x2061;"), one.element()]),
        several => {
            let inner = joined(several.iter().map(Formula::element));
            row(&[name, operator("&#x2061;"), operator("("), inner, operator(")")])
        }
    }
}

fn tag(name: &str, inner: &str) -> String {
    format!("<{name}>{inner}</{name}>")
}

fn operator(sign: &str) -> String {
    tag("mo", sign)
}

fn row(parts: &[String]) -> String {
    match parts {
        [one] => one.clone(),
        several => tag("mrow", &several.concat()),
    }
}

/// With commas between.
fn joined(parts: impl Iterator<Item = String>) -> String {
    let mut all = Vec::new();
    for part in parts {
        if !all.is_empty() {
            all.push(operator(","));
        }
        all.push(part);
    }
    row(&all)
}

/// A symbol with its subscript and an exponent.
fn symbol_element(symbol: &Symbol, exponent: Option<&Formula>) -> String {
    let letter = if symbol.plain { &symbol.letter } else { unicode_word(&symbol.letter) };
    let dot = match symbol.dots {
        0 => "",
        1 => "˙",
        2 => "¨",
        _ => "⃛",
    };
    let mut own = tag("mi", letter);
    if !dot.is_empty() {
        own = format!("<mover accent=\"true\">{own}{}</mover>", operator(dot));
    }
    let foot = (!symbol.subscript.is_empty()).then(|| feet_element(&symbol.subscript));
    let own = match (foot, exponent.map(Formula::element)) {
        (None, None) => own,
        (Some(foot), None) => tag("msub", &(own + &foot)),
        (None, Some(exponent)) => tag("msup", &(own + &exponent)),
        (Some(foot), Some(exponent)) => tag("msubsup", &(own + &foot + &exponent)),
    };
    if symbol.delta { row(&[tag("mi", "δ"), own]) } else { own }
}

fn feet_element(feet: &[Subscript]) -> String {
    joined(feet.iter().map(|foot| match foot {
        Subscript::Word(word) if word.bytes().all(|b| b.is_ascii_digit()) => tag("mn", word),
        Subscript::Word(word) => tag("mi", unicode_word(word)),
        Subscript::Index(formula) => formula.element(),
        Subscript::Coordinate(symbol) => symbol_element(symbol, None),
    }))
}
