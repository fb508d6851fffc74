//! Formulas as text in a markup: LaTeX, Typst and MathML differ in what stands around and between the parts.

use super::latex::stands_open;
use super::pieces::Token;
use super::symbol::Subscript;
use super::{Formula, Sign, Symbol};

/// How a markup writes formulas: of most forms what stands before, between and behind their parts.
pub(super) struct Dialect {
    pub(super) number: [&'static str; 2],
    /// Digits and a power of ten, whose minus sign is another one.
    pub(super) scientific: [&'static str; 3],
    pub(super) minus: &'static str,
    /// A letter with its dots.
    pub(super) letter: fn(&Symbol) -> String,
    /// Part of a name at a foot.
    pub(super) word: fn(&str) -> String,
    pub(super) subscript: [&'static str; 3],
    pub(super) power: [&'static str; 3],
    /// A subscript and an exponent.
    pub(super) both: [&'static str; 4],
    pub(super) delta: [&'static str; 2],
    pub(super) differential: [&'static str; 2],
    pub(super) fraction: [&'static str; 3],
    pub(super) root: [&'static str; 2],
    /// Simple and double ones.
    pub(super) bars: [[&'static str; 2]; 2],
    /// Those of one size and those that grow.
    pub(super) brackets: [[&'static str; 2]; 2],
    pub(super) matrix: [&'static str; 2],
    /// Between the rows and between the entries of a matrix.
    pub(super) entries: [&'static str; 2],
    pub(super) rate: [&'static str; 2],
    /// Around the limits of a sum, those with one above first, and of an integral.
    pub(super) limits: [([&'static str; 3], [&'static str; 2]); 2],
    /// Around several things side by side.
    pub(super) row: [&'static str; 2],
    /// Between factors, before a digit, and beside names of several letters and behind functions without brackets.
    pub(super) beside: &'static str,
    pub(super) times: &'static str,
    pub(super) apart: &'static str,
    pub(super) cross: &'static str,
    /// The minus sign of the first term, then what stands before others.
    pub(super) signs: [&'static str; 3],
    /// Between parts of a subscript, arguments, and what stands below a sum.
    pub(super) commas: [&'static str; 3],
    /// Between the parts of a relation, and whether before a comma too.
    pub(super) space: &'static str,
    pub(super) before_comma: bool,
    pub(super) e: &'static str,
    pub(super) function: fn(&str) -> String,
    /// Between a function and its argument, and its brackets.
    pub(super) applied: [&'static str; 2],
    pub(super) sign: fn(Sign) -> String,
    pub(super) verbatim: fn(&str) -> String,
}

/// How a markup breaks lines.
pub(super) struct Lines {
    pub(super) around: [&'static str; 2],
    /// Behind the left side of an equation.
    pub(super) behind_left: &'static str,
    /// Before the first line, and between two.
    pub(super) breaks: [&'static str; 2],
    /// Before a factor that begins a line, and another one.
    pub(super) factor: [&'static str; 2],
    pub(super) token: fn(&Token, &mut String),
}

/// Text before, between and behind some parts.
fn framed(frame: &[&str], parts: &[&str]) -> String {
    let parts = parts.iter().copied().chain([""]);
    frame.iter().copied().zip(parts).flat_map(|(before, part)| [before, part]).collect()
}

impl Formula {
    /// The formula in a markup.
    pub(super) fn written(&self, own: &Dialect) -> String {
        let of = |formula: &Self| formula.written(own);
        match self {
            Self::Number(digits) => framed(&own.number, &[digits]),
            Self::Scientific { digits, exponent } => {
                framed(&own.scientific, &[digits, &exponent.replace('-', own.minus)])
            }
            Self::Symbol(symbol) => own.symbol(symbol, None),
            Self::Indexed(inner, feet) => framed(&own.subscript, &[&of(inner), &own.feet(feet)]),
            Self::Product(factors) => own.product(factors),
            Self::Sum(terms) => {
                let mut parts = Vec::new();
                for (at, (negative, term)) in terms.iter().enumerate() {
                    let [first, plus, minus] = own.signs;
                    match (at, negative) {
                        (0, false) => {}
                        (0, true) => parts.push(first.to_owned()),
                        (_, true) => parts.push(minus.to_owned()),
                        (_, false) => parts.push(plus.to_owned()),
                    }
                    parts.push(of(term));
                }
                own.row(&parts)
            }
            Self::Fraction(above, below) => framed(&own.fraction, &[&of(above), &of(below)]),
            Self::Power(base, exponent) => match &**base {
                Self::Symbol(symbol) => own.symbol(symbol, Some(exponent)),
                base => framed(&own.power, &[&of(base), &of(exponent)]),
            },
            Self::Root(inner) => framed(&own.root, &[&of(inner)]),
            Self::Function { name, power, arguments } => own.applied(name, power.as_deref(), arguments),
            Self::Bars { double, inner } => framed(&own.bars[usize::from(*double)], &[&of(inner)]),
            Self::Parentheses(inner) => {
                let [open, close] = own.brackets[usize::from(inner.is_tall())].map(str::to_owned);
                own.row(&[open, of(inner), close])
            }
            Self::Matrix(rows) => {
                let [between, beside] = own.entries;
                let rows = rows.iter().map(|row| row.iter().map(of).collect::<Vec<_>>().join(beside));
                framed(&own.matrix, &[&rows.collect::<Vec<_>>().join(between)])
            }
            Self::Between { cross, sides } => {
                let sign = if *cross { own.cross } else { own.times };
                own.row(&[of(&sides.0), sign.to_owned(), of(&sides.1)])
            }
            Self::Rate(inner) => framed(&own.rate, &[&of(inner)]),
            Self::Total { integral, below, above, body } => {
                let below = own.joined(below.iter().map(of), own.commas[2]);
                let (both, single) = &own.limits[usize::from(*integral)];
                let sign = match above {
                    Some(above) => framed(both, &[&below, &of(above)]),
                    None => framed(single, &[&below]),
                };
                own.spaced(vec![sign, of(body)])
            }
            Self::Differential(symbol) => framed(&own.differential, &[&own.symbol(symbol, None)]),
            Self::Relation(parts) => {
                let tight = |part: &Self| matches!(part, Self::Sign(Sign::Comma)) && !own.before_comma;
                let groups = parts.chunk_by(|_, next| tight(next));
                own.spaced(groups.map(|group| group.iter().map(of).collect()).collect())
            }
            Self::Verbatim(text) => (own.verbatim)(text),
            Self::Sign(sign) => (own.sign)(*sign),
        }
    }

    /// The formula for a line of its own; one that is too long is broken before relations and signs.
    pub(super) fn displayed(&self, own: &Dialect, how: &Lines) -> String {
        let Some((left, lines)) = self.broken() else { return self.written(own) };
        let Lines { around, behind_left, breaks, factor, token } = how;
        let mut out = around[0].to_owned();
        out.extend(left.map(|left| left.written(own) + behind_left));
        for (at, pieces) in lines.iter().enumerate() {
            out.push_str(breaks[usize::from(at > 0)]);
            for (place, piece) in pieces.iter().enumerate() {
                if piece.is_factor {
                    out.push_str(factor[usize::from(place > 0)]);
                }
                piece.tokens.iter().for_each(|own| token(own, &mut out));
            }
        }
        out + around[1]
    }
}

impl Dialect {
    fn row(&self, parts: &[String]) -> String {
        match parts {
            [one] => one.clone(),
            several => framed(&self.row, &[&several.concat()]),
        }
    }

    /// A row with spaces between.
    fn spaced(&self, parts: Vec<String>) -> String {
        if self.space.is_empty() { self.row(&parts) } else { parts.join(self.space) }
    }

    fn joined(&self, parts: impl Iterator<Item = String>, comma: &str) -> String {
        self.row(&parts.flat_map(|part| [comma.to_owned(), part]).skip(1).collect::<Vec<_>>())
    }

    fn product(&self, factors: &[Formula]) -> String {
        let mut parts = Vec::new();
        let mut before: Option<&Formula> = None;
        for factor in factors {
            if let Some(last) = before {
                let joint = match () {
                    () if last.is_open_function() || last.runs_into(factor) => self.apart,
                    // A digit would run on.
                    () if factor.begins_with_digit() => self.times,
                    () => self.beside,
                };
                parts.push(joint.to_owned());
            }
            parts.push(factor.written(self));
            before = Some(factor);
        }
        self.row(&parts)
    }

    fn applied(&self, name: &str, power: Option<&Formula>, arguments: &[Formula]) -> String {
        let is_e = name == "exp" && arguments.is_empty();
        let name = if is_e { self.e.to_owned() } else { (self.function)(name) };
        let name = if let Some(power) = power { framed(&self.power, &[&name, &power.written(self)]) } else { name };
        let inner = || self.joined(arguments.iter().map(|own| own.written(self)), self.commas[1]);
        match arguments {
            [] => name,
            [_] if stands_open(arguments) => self.row(&[name, self.applied[0].to_owned(), inner()]),
            several => {
                let grow = matches!(several, [only] if only.is_tall());
                let [open, close] = self.brackets[usize::from(grow)].map(str::to_owned);
                self.row(&[name, self.applied[1].to_owned(), open, inner(), close])
            }
        }
    }

    /// A symbol with its subscript and an exponent.
    fn symbol(&self, symbol: &Symbol, exponent: Option<&Formula>) -> String {
        let letter = (self.letter)(symbol);
        let foot = (!symbol.subscript.is_empty()).then(|| self.feet(&symbol.subscript));
        let own = match (foot, exponent.map(|exponent| exponent.written(self))) {
            (None, None) => letter,
            (Some(foot), None) => framed(&self.subscript, &[&letter, &foot]),
            (None, Some(exponent)) => framed(&self.power, &[&letter, &exponent]),
            (Some(foot), Some(exponent)) => framed(&self.both, &[&letter, &foot, &exponent]),
        };
        if symbol.delta { framed(&self.delta, &[&own]) } else { own }
    }

    fn feet(&self, feet: &[Subscript]) -> String {
        let feet = feet.iter().map(|foot| match foot {
            Subscript::Word(word) => (self.word)(word),
            Subscript::Index(formula) => formula.written(self),
            Subscript::Coordinate(symbol) => self.symbol(symbol, None),
        });
        self.joined(feet, self.commas[0])
    }
}
