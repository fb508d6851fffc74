//! Where a formula that is too long for a line may be broken.
//!
//! Before relation signs and the signs of sums, at any depth: what is under a root or in an argument stands in brackets of
//! one size then, and what is long above a fraction bar comes down behind a fraction. Only what has no sum and no product in
//! it stays as it is.

use super::{Formula, Sign};

/// How many digits of a long number stay together.
const DIGITS: usize = 20;

/// A part of a line.
pub(super) enum Token {
    /// Something that stays on one line.
    Whole(Formula),
    /// The sign of a term: whether it is the first one, and whether it is a minus.
    Term {
        /// Whether nothing precedes it in its sum.
        first: bool,
        /// Whether the term is subtracted.
        negative: bool,
    },
    /// A relation.
    Relation(Sign),
    /// An opening bracket.
    Open(Bracket),
    /// A closing bracket.
    Close(Bracket),
    /// Above and behind a bracket.
    Exponent(Formula),
    /// The exponential function of what follows in brackets.
    Exp,
    /// Between a factor and one in brackets.
    Space,
    /// Between arguments.
    Comma,
    /// Divided by what follows in brackets.
    Over,
}

/// Brackets that don't grow.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Bracket {
    Round,
    Bars,
    DoubleBars,
}

/// What stays on one line.
#[derive(Default)]
pub(super) struct Piece {
    pub(super) tokens: Vec<Token>,
    /// Whether it is multiplied by what precedes it.
    pub(super) is_factor: bool,
}

impl Piece {
    fn of(token: Token) -> Self {
        Self { tokens: vec![token], is_factor: false }
    }
}

/// Breaks formulas for lines of some width.
pub(super) struct Breaker<'a> {
    /// The width of a line.
    pub(super) line: f64,
    /// The width of what stays on one line.
    pub(super) measure: &'a dyn Fn(&Token) -> f64,
    /// Whether a root is broken behind its sign; else it is a power of 1/2.
    pub(super) has_root_signs: bool,
}

impl Breaker<'_> {
    /// The pieces of a formula in lines; all lines but the first are shorter by `indent`.
    pub(super) fn lines(&self, formula: &Formula, indent: f64) -> Vec<Vec<Piece>> {
        let mut pieces = Vec::new();
        self.pieces(formula, &mut pieces);
        let mut lines: Vec<Vec<Piece>> = Vec::new();
        let mut used = 0.0;
        for piece in pieces {
            let joint = if piece.is_factor { 2.0 * (self.measure)(&Token::Comma) } else { 0.0 };
            let width = self.width(&piece.tokens) + joint;
            match lines.last_mut() {
                Some(line) if used + width <= self.line => line.push(piece),
                last => {
                    used = if last.is_some() { indent } else { 0.0 };
                    lines.push(vec![piece]);
                }
            }
            used += width;
        }
        lines
    }

    fn width(&self, tokens: &[Token]) -> f64 {
        tokens.iter().map(|token| (self.measure)(token)).sum()
    }

    /// Whether a formula is too long to stay on one line: what has brackets at once, what has a bar only where it fills a line.
    fn is_long(&self, formula: &Formula) -> bool {
        let share = match formula {
            Formula::Fraction(..) | Formula::Root(_) | Formula::Power(..) | Formula::Function { .. } => 0.8,
            _ => 0.4,
        };
        // Measuring is not free.
        formula.weight() > 8 && (self.measure)(&Token::Whole(formula.clone())) > share * self.line
    }

    /// What a line may be broken between.
    fn pieces(&self, formula: &Formula, out: &mut Vec<Piece>) {
        let first = out.len();
        match formula {
            Formula::Relation(parts) => {
                let mut before = Vec::new();
                for part in parts {
                    match part {
                        Formula::Sign(sign) => before.push(Token::Relation(*sign)),
                        part => {
                            let own = out.len();
                            self.pieces(part, out);
                            self.attach(std::mem::take(&mut before), own, out);
                        }
                    }
                }
            }
            Formula::Sum(terms) => {
                for (at, (negative, term)) in terms.iter().enumerate() {
                    let own = out.len();
                    self.pieces(term, out);
                    self.attach(vec![Token::Term { first: at == 0, negative: *negative }], own, out);
                }
            }
            short if !self.is_long(short) => out.push(Piece::of(Token::Whole(short.clone()))),
            Formula::Product(factors) => self.product(factors, out),
            Formula::Fraction(above, below) => self.fraction(above, below, out),
            Formula::Parentheses(inner) => self.between(Vec::new(), Bracket::Round, inner, out),
            Formula::Bars { double, inner } => {
                let bars = if *double { Bracket::DoubleBars } else { Bracket::Bars };
                self.between(Vec::new(), bars, inner, out);
            }
            Formula::Root(inner) if self.has_root_signs => {
                let sign = Token::Whole(Formula::Verbatim("√".to_owned()));
                self.between(vec![sign], Bracket::Round, inner, out);
            }
            Formula::Root(inner) => {
                self.between(Vec::new(), Bracket::Round, inner, out);
                let [one, two] = ["1", "2"].map(|digit| Box::new(Formula::Number(digit.to_owned())));
                close(out, Token::Exponent(Formula::Fraction(one, two)));
            }
            Formula::Power(base, exponent) if self.is_long(base) => {
                self.pieces(base, out);
                close(out, Token::Exponent((**exponent).clone()));
            }
            Formula::Power(base, exponent) if matches!(**base, Formula::Function { name: "exp", .. }) => {
                self.between(vec![Token::Exp], Bracket::Round, exponent, out);
            }
            Formula::Function { name, power, arguments } => {
                let name = Formula::Function { name, power: power.clone(), arguments: Vec::new() };
                for (at, argument) in arguments.iter().enumerate() {
                    let own = out.len();
                    self.pieces(argument, out);
                    if at == 0 {
                        self.attach(vec![Token::Whole(name.clone()), Token::Open(Bracket::Round)], own, out);
                    }
                    let last = at + 1 == arguments.len();
                    close(out, if last { Token::Close(Bracket::Round) } else { Token::Comma });
                }
            }
            Formula::Total { integral, below, above, body } => {
                self.pieces(body, out);
                let nothing = Box::new(Formula::Relation(Vec::new()));
                let sign =
                    Formula::Total { integral: *integral, below: below.clone(), above: above.clone(), body: nothing };
                self.attach(vec![Token::Whole(sign)], first, out);
            }
            // Hundreds of digits.
            Formula::Number(digits) => {
                let digits: Vec<char> = digits.chars().collect();
                let parts = digits.chunks(DIGITS).map(|part| Formula::Number(part.iter().collect()));
                out.extend(parts.map(|part| Piece::of(Token::Whole(part))));
            }
            whole => out.push(Piece::of(Token::Whole(whole.clone()))),
        }
    }

    /// Short factors side by side, long ones in pieces.
    fn product(&self, factors: &[Formula], out: &mut Vec<Piece>) {
        let first = out.len();
        let mut run: Vec<Formula> = Vec::new();
        let whole = |run: &mut Vec<Formula>| Token::Whole(Formula::Product(std::mem::take(run)));
        for factor in factors {
            let own = out.len();
            if self.is_long(factor) {
                self.pieces(factor, out);
                if !run.is_empty() {
                    self.attach(vec![whole(&mut run), Token::Space], own, out);
                }
            } else {
                run.push(factor.clone());
                if !self.is_long(&Formula::Product(run.clone())) {
                    continue;
                }
                run.pop();
                out.push(Piece::of(whole(&mut run)));
                run.push(factor.clone());
            }
            if let Some(piece) = out.get_mut(own) {
                piece.is_factor = own > first;
            }
        }
        if !run.is_empty() {
            let is_factor = out.len() > first;
            out.push(Piece { tokens: vec![whole(&mut run)], is_factor });
        }
    }

    /// What is long above the bar behind a fraction; what is long below it behind a stroke.
    fn fraction(&self, above: &Formula, below: &Formula, out: &mut Vec<Piece>) {
        if self.is_long(below) {
            self.pieces(&bracketed(above), out);
            return self.between(vec![Token::Over], Bracket::Round, below, out);
        }
        let factors = match above {
            Formula::Product(factors) => factors.as_slice(),
            other => std::slice::from_ref(other),
        };
        let (long, mut short): (Vec<Formula>, Vec<Formula>) =
            factors.iter().cloned().partition(|own| self.is_long(own));
        let over = |above| Formula::Fraction(Box::new(Formula::product(above)), Box::new(below.clone()));
        let mut all = Vec::new();
        if self.is_long(&Formula::Product(short.clone())) {
            // Many short factors.
            all.push(over(Vec::new()));
            all.append(&mut short);
        } else {
            all.push(over(short));
        }
        all.extend(long.iter().map(bracketed));
        match all.as_slice() {
            [only] => out.push(Piece::of(Token::Whole(only.clone()))),
            several => self.product(several, out),
        }
    }

    /// In brackets, behind something.
    fn between(&self, mut before: Vec<Token>, bracket: Bracket, inner: &Formula, out: &mut Vec<Piece>) {
        let own = out.len();
        self.pieces(inner, out);
        before.push(Token::Open(bracket));
        self.attach(before, own, out);
        close(out, Token::Close(bracket));
    }

    /// Puts something before a piece, or on a line of its own where both are long.
    fn attach(&self, mut before: Vec<Token>, at: usize, out: &mut Vec<Piece>) {
        let Some(piece) = out.get_mut(at) else { return };
        if self.width(&before) + self.width(&piece.tokens) > 0.7 * self.line && before.len() > 1 {
            out.insert(at, Piece { tokens: before, is_factor: false });
        } else {
            before.append(&mut piece.tokens);
            piece.tokens = before;
        }
    }
}

/// Puts something behind the last piece.
fn close(out: &mut [Piece], token: Token) {
    if let Some(piece) = out.last_mut() {
        piece.tokens.push(token);
    }
}

/// A sum as a factor.
fn bracketed(formula: &Formula) -> Formula {
    formula.clone().bracketed_if(|own| matches!(own, Formula::Sum(_)))
}
