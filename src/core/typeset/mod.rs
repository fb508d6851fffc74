//! Formulas as they stand in a book: expressions of the model language as LaTeX and as Unicode text
//! in several lines.
//!
//! A [`Formula`] is made from a syntax tree (`lower`) and says how things stand to one another: above
//! and below a fraction bar, as an index, under a root. Two writers turn it into text, `latex` and
//! `block`. Symbols follow the field's notation: dots for time derivatives, Greek letters by their
//! names, members of families with indices, `m_eff` and `k12` with subscripts.
//!
//! Nothing is computed and nothing rearranged here, but that a leading number gets a fraction bar of its
//! own, and the minus signs of factors and terms are multiplied out.
//!
//! ```
//! use librate::typeset::Notation;
//!
//! let notation = Notation::default();
//! let formula = notation.read("1/2*m*l^2*theta[1]'^2").ok_or("not an expression")?;
//! assert_eq!(formula.latex(), r"\frac{1}{2} m l^{2} \dot{\theta}_{1}^{2}");
//! let root = notation.read("sqrt(g/l)").ok_or("not an expression")?;
//! assert_eq!(root.latex(), r"\sqrt{\frac{g}{l}}");
//! # Ok::<(), &str>(())
//! ```

mod block;
mod dialect;
mod latex;
mod lower;
mod mathml;
mod pieces;
mod points;
mod symbol;
mod typst;

pub use block::{Block, superscript, unit};
pub use lower::Notation;
pub use symbol::{Subscript, Symbol};

use crate::syntax::Comparison;

/// How the parts of an expression stand to one another.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Formula {
    /// Digits, with a point where there is one.
    Number(String),
    /// `6.02e23` as 6.02 times a power of ten.
    Scientific {
        /// Before the `e`.
        digits: String,
        /// Behind it.
        exponent: String,
    },
    /// A letter with all that is attached to it.
    Symbol(Symbol),
    /// Something in brackets, or between bars, with an index.
    Indexed(Box<Formula>, Vec<Subscript>),
    /// Factors side by side.
    Product(Vec<Formula>),
    /// Terms, each with whether it is subtracted.
    Sum(Vec<(bool, Formula)>),
    /// Numerator and denominator.
    Fraction(Box<Formula>, Box<Formula>),
    /// Base and exponent.
    Power(Box<Formula>, Box<Formula>),
    /// Square root.
    Root(Box<Formula>),
    /// A function with its argument, `sin^2 x` with its power.
    Function {
        /// As it is called in print: `sin`, `arcsin`, `ln`.
        name: &'static str,
        /// The power, where one stands at the name.
        power: Option<Box<Formula>>,
        /// One or more arguments.
        arguments: Vec<Formula>,
    },
    /// An absolute value, or with two bars the length of a vector.
    Bars {
        /// Whether the bars are double.
        double: bool,
        /// What stands between.
        inner: Box<Formula>,
    },
    /// In round brackets.
    Parentheses(Box<Formula>),
    /// A column vector or, with more rows, a matrix; all rows of the same length.
    Matrix(Vec<Vec<Formula>>),
    /// Two vectors with a dot (scalar product) or a cross between.
    Between {
        /// Whether it is the vector product.
        cross: bool,
        /// The two.
        sides: Box<(Formula, Formula)>,
    },
    /// d/dt of something that is no symbol.
    Rate(Box<Formula>),
    /// A sum over indices, or an integral.
    Total {
        /// Whether it is an integral, whose body ends with the differential of its variable.
        integral: bool,
        /// What stands below the sign, line by line.
        below: Vec<Formula>,
        /// What stands above it, if anything.
        above: Option<Box<Formula>>,
        /// What is summed or integrated.
        body: Box<Formula>,
    },
    /// dx
    Differential(Symbol),
    /// Words and signs of conditions, one after another.
    Relation(Vec<Formula>),
    /// A sign or a word of a condition.
    Sign(Sign),
    /// Text that is no formula, as it is written.
    Verbatim(String),
}

/// Signs and words between formulas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sign {
    /// =, ≠, <, ≤, > or ≥
    Comparison(Comparison),
    /// ∈
    In,
    /// ,
    Comma,
    /// not
    Not,
    /// and
    And,
    /// or
    Or,
    /// if
    If,
}

impl Sign {
    /// In LaTeX, in Typst, in MathML and as text.
    fn forms(self) -> [&'static str; 4] {
        match self {
            Self::Comparison(Comparison::Equal) => ["="; 4],
            Self::Comparison(Comparison::NotEqual) => [r"\neq", "!=", "≠", "≠"],
            Self::Comparison(Comparison::Less) => ["<", "<", "&lt;", "<"],
            Self::Comparison(Comparison::LessEqual) => [r"\leq", "<=", "≤", "≤"],
            Self::Comparison(Comparison::Greater) => [">", ">", "&gt;", ">"],
            Self::Comparison(Comparison::GreaterEqual) => [r"\geq", ">=", "≥", "≥"],
            Self::In => [r"\in", "in", "∈", "∈"],
            Self::Comma => [r",\;", ",", ",", ","],
            Self::Not => [r"\neg", "not", "¬", "not"],
            Self::And => [r"\land", "and", "∧", "and"],
            Self::Or => [r"\lor", "or", "∨", "or"],
            Self::If => [r"\quad \text{if }", "quad \"if\"", "\u{2003}if\u{2002}", "  if"],
        }
    }
}

impl Formula {
    /// A formula that is equal to another: `left = right`.
    #[must_use]
    pub fn equation(left: Self, right: Self) -> Self {
        Self::Relation(vec![left, Self::Sign(Sign::Comparison(Comparison::Equal)), right])
    }

    /// The factors of a term with a sum in brackets as the last one, within which lines can be broken; what is long above a
    /// fraction bar comes down for it.
    fn with_sum_last(&self) -> Option<Vec<Self>> {
        match self {
            Self::Product(factors) => match factors.as_slice() {
                [.., Self::Parentheses(inner)] if matches!(**inner, Self::Sum(_)) => Some(factors.clone()),
                [before @ .., last @ Self::Fraction(..)] => {
                    let own = last.with_sum_last()?;
                    Some(before.iter().cloned().chain(own).collect())
                }
                _ => None,
            },
            Self::Fraction(above, below) => {
                let (rest, sum) = match &**above {
                    Self::Sum(_) => (Self::Number("1".to_owned()), above.clone()),
                    Self::Product(factors) => match factors.as_slice() {
                        [before @ .., Self::Parentheses(inner)] if matches!(**inner, Self::Sum(_)) => {
                            (Self::product(before.to_vec()), inner.clone())
                        }
                        _ => return None,
                    },
                    _ => return None,
                };
                let factor = Self::Fraction(Box::new(rest), below.clone());
                Some(vec![factor, Self::Parentheses(sum)])
            }
            _ => None,
        }
    }

    /// Factors side by side; 1 where there are none.
    fn product(mut factors: Vec<Self>) -> Self {
        match factors.len() {
            0 => Self::Number("1".to_owned()),
            1 => factors.swap_remove(0),
            _ => Self::Product(factors),
        }
    }

    /// Whether the formula stands without brackets as a factor or as the base of a power.
    fn is_atom(&self) -> bool {
        match self {
            Self::Number(_)
            | Self::Symbol(_)
            | Self::Differential(_)
            | Self::Bars { .. }
            | Self::Parentheses(_)
            | Self::Indexed(..)
            | Self::Matrix(_)
            | Self::Root(_) => true,
            Self::Function { name, power, .. } => *name == "exp" && power.is_none(),
            _ => false,
        }
    }

    /// In brackets, where these are needed.
    fn bracketed_if(self, needed: impl FnOnce(&Self) -> bool) -> Self {
        if needed(&self) { self.bracketed() } else { self }
    }

    /// In brackets.
    fn bracketed(self) -> Self {
        match self {
            Self::Parentheses(_) => self,
            other => Self::Parentheses(Box::new(other)),
        }
    }
}
