//! Formulas as Unicode text in as many lines as they take: fractions with bars, brackets that grow.

use std::cell::LazyCell;

use unicode_width::UnicodeWidthStr;

use super::latex::stands_open;
use super::pieces::{Bracket, Breaker, Token};
use super::symbol::{Subscript, unicode_word};
use super::{Formula, Sign, Symbol};

/// Text of several lines, one of which is in line with what stands beside it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[must_use]
pub struct Block {
    /// From the top; all of the same width.
    lines: Vec<String>,
    /// Which of them is in line.
    base: usize,
}

impl Block {
    /// A block of one line.
    pub fn line(text: &str) -> Self {
        Self { lines: vec![text.to_owned()], base: 0 }
    }

    /// How many columns wide it is.
    #[must_use]
    pub fn width(&self) -> usize {
        self.lines.first().map_or(0, |line| line.width())
    }

    /// How many lines high it is.
    #[must_use]
    pub fn height(&self) -> usize {
        self.lines.len()
    }

    /// The lines from the top, without blanks at their ends.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.lines.iter().map(|line| line.trim_end())
    }

    /// Puts blocks side by side, their lines in line.
    pub fn beside(blocks: &[Self]) -> Self {
        let above = blocks.iter().map(|block| block.base).max().unwrap_or(0);
        let below = blocks.iter().map(|block| block.height() - block.base).max();
        let height = above + below.unwrap_or(1);
        let size = blocks.iter().flat_map(|block| block.lines.get(block.base)).map(String::len).sum();
        let mut lines: Vec<String> = (0..height).map(|_| String::with_capacity(size)).collect();
        for block in blocks {
            // Mostly there is one line, and nothing to be measured.
            let blank = LazyCell::new(|| " ".repeat(block.width()));
            for (at, line) in lines.iter_mut().enumerate() {
                let own = (at + block.base).checked_sub(above);
                let text = own.and_then(|own| block.lines.get(own));
                line.push_str(text.unwrap_or_else(|| &blank));
            }
        }
        Self { lines, base: above }
    }

    /// Puts blocks one below the other, each in the middle; the first of them in line.
    fn stacked(blocks: &[Self]) -> Vec<String> {
        let width = blocks.iter().map(Self::width).max().unwrap_or(0);
        blocks.iter().flat_map(|block| &block.lines).map(|line| centred(line, width)).collect()
    }

    fn fraction(above: &Self, below: &Self) -> Self {
        let width = above.width().max(below.width());
        let bar = Self::line(&"─".repeat(width));
        Self { base: above.height(), lines: Self::stacked(&[above.clone(), bar, below.clone()]) }
    }

    /// A matrix in square brackets, columns in the middle.
    pub fn matrix(rows: &[Vec<Self>]) -> Self {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns)
            .map(|column| rows.iter().filter_map(|row| row.get(column)).map(Self::width).max().unwrap_or(0))
            .collect();
        let tall = rows.iter().flatten().any(|cell| cell.height() > 1);
        let mut lines = Vec::new();
        for (at, row) in rows.iter().enumerate() {
            if at > 0 && tall {
                lines.push(String::new());
            }
            let cells = row.iter().zip(&widths).flat_map(|(cell, width)| {
                let lines = cell.lines.iter().map(|line| centred(line, *width)).collect();
                [Self::line("  "), Self { lines, base: cell.base }]
            });
            lines.extend(Self::beside(&cells.skip(1).collect::<Vec<_>>()).lines);
        }
        let width = lines.iter().map(|line| line.width()).max().unwrap_or(0);
        let lines: Vec<String> = lines.iter().map(|line| centred(line, width)).collect();
        let inner = Self { base: lines.len().saturating_sub(1) / 2, lines };
        inner.enclosed(['[', '⎡', '⎢', '⎣'], [']', '⎤', '⎥', '⎦'])
    }

    /// Between brackets given as the short one and the upper, middle and lower part of the tall one.
    fn enclosed(self, left: [char; 4], right: [char; 4]) -> Self {
        let last = self.height().saturating_sub(1);
        let side = |form: [char; 4], at: usize| match at {
            _ if last == 0 => form[0],
            0 => form[1],
            _ if at == last => form[3],
            _ => form[2],
        };
        let line = |(at, line): (usize, &String)| format!("{}{line}{}", side(left, at), side(right, at));
        Self { base: self.base, lines: self.lines.iter().enumerate().map(line).collect() }
    }

    fn in_parentheses(self) -> Self {
        self.enclosed(['(', '⎛', '⎜', '⎝'], [')', '⎞', '⎟', '⎠'])
    }

    /// With another block as exponent.
    fn raised(self, exponent: &Self) -> Self {
        let (width, high) = (self.width(), exponent.height());
        let blank = " ".repeat(exponent.width());
        let mut lines: Vec<String> = exponent.lines.iter().map(|line| format!("{}{line}", " ".repeat(width))).collect();
        // What is tall has its exponent beside its first line.
        let overlap = usize::from(self.height() > 1);
        for (at, line) in self.lines.iter().enumerate() {
            if at < overlap
                && let (Some(last), Some(text)) = (lines.last_mut(), exponent.lines.last())
            {
                *last = format!("{line}{text}");
            } else {
                lines.push(format!("{line}{blank}"));
            }
        }
        Self { lines, base: self.base + high - overlap }
    }
}

/// In the middle of so many columns.
fn centred(line: &str, width: usize) -> String {
    let free = width.saturating_sub(line.width());
    let left = free / 2;
    format!("{}{line}{}", " ".repeat(left), " ".repeat(free - left))
}

impl Formula {
    /// The formula as Unicode text.
    pub fn block(&self) -> Block {
        match self {
            Self::Number(digits) => Block::line(digits),
            Self::Scientific { digits, exponent } => {
                let raised = superscript(exponent).unwrap_or_else(|| format!("^{exponent}"));
                Block::line(&format!("{digits}·10{raised}"))
            }
            Self::Symbol(symbol) => Block::line(&symbol_text(symbol)),
            Self::Indexed(inner, feet) => Block::beside(&[inner.block(), Block::line(&feet_text(feet))]),
            Self::Product(factors) => product(factors),
            Self::Sum(terms) => {
                let parts = terms.iter().enumerate();
                let parts = parts.flat_map(|(at, (minus, own))| [Block::line(sign(at == 0, *minus)), own.block()]);
                Block::beside(&parts.collect::<Vec<_>>())
            }
            Self::Fraction(above, below) => match vulgar(above, below) {
                Some(text) => Block::line(&text),
                None => Block::fraction(&above.block(), &below.block()),
            },
            Self::Power(base, exponent) => power(&base.block(), exponent),
            Self::Root(inner) => {
                let simple = matches!(**inner, Self::Symbol(_) | Self::Number(_));
                let inner = inner.block();
                let under = if simple { inner } else { inner.in_parentheses() };
                Block::beside(&[Block::line("√"), under])
            }
            Self::Function { name, power, arguments } => function(name, power.as_deref(), arguments),
            Self::Bars { double, inner } => {
                let bar = if *double { '‖' } else { '│' };
                inner.block().enclosed([bar; 4], [bar; 4])
            }
            Self::Parentheses(inner) => inner.block().in_parentheses(),
            Self::Matrix(rows) => {
                let rows: Vec<Vec<Block>> = rows.iter().map(|row| row.iter().map(Self::block).collect()).collect();
                Block::matrix(&rows)
            }
            Self::Between { cross, sides } => {
                let between = if *cross { " × " } else { " · " };
                Block::beside(&[sides.0.block(), Block::line(between), sides.1.block()])
            }
            Self::Rate(inner) => Block::beside(&[
                Block::fraction(&Block::line("d"), &Block::line("dt")),
                Block::line(" "),
                inner.block(),
            ]),
            Self::Total { integral, below, above, body } => {
                let mut parts: Vec<Block> = above.iter().map(|above| above.block()).collect();
                let base = parts.iter().map(Block::height).sum();
                parts.push(Block::line(if *integral { "∫" } else { "Σ" }));
                parts.push(with_commas(below));
                let total = Block { lines: Block::stacked(&parts), base };
                Block::beside(&[total, Block::line(" "), body.block()])
            }
            Self::Differential(symbol) => Block::line(&format!("d{}", symbol_text(symbol))),
            Self::Relation(parts) => {
                let mut blocks = Vec::new();
                for (at, part) in parts.iter().enumerate() {
                    if at > 0 && !matches!(part, Self::Sign(Sign::Comma)) {
                        blocks.push(Block::line(" "));
                    }
                    blocks.push(part.block());
                }
                Block::beside(&blocks)
            }
            Self::Verbatim(text) => Block::line(text),
            Self::Sign(sign) => Block::line(sign.forms()[3]),
        }
    }

    /// The formula in lines of at most `width` columns where it can be broken: before the signs of its
    /// outermost sum, and where that is not enough within brackets and products too. Rows of more than one line are set apart by
    /// none.
    #[must_use]
    pub fn text(&self, width: usize) -> Vec<String> {
        let lines = self.text_of_sums(width);
        if lines.iter().all(|line| line.width() <= width) {
            return lines;
        }
        let measure = &|token: &Token| token_block(token).width() as f64;
        let breaker = Breaker { line: width as f64, measure, has_root_signs: true };
        let mut lines = Vec::new();
        for (at, pieces) in breaker.lines(self, 4.0).iter().enumerate() {
            let mut row = vec![Block::line(if at == 0 { "" } else { "    " })];
            for (place, piece) in pieces.iter().enumerate() {
                if piece.is_factor {
                    row.push(Block::line(if place == 0 { "· " } else { " " }));
                }
                for token in &piece.tokens {
                    match (token, row.pop()) {
                        (Token::Exponent(own), Some(last)) => row.push(power(&last, own)),
                        (_, last) => row.extend(last.into_iter().chain([token_block(token)])),
                    }
                }
            }
            lines.extend(Block::beside(&row).lines().map(str::to_owned));
        }
        lines
    }

    /// The same for sums alone.
    fn text_of_sums(&self, width: usize) -> Vec<String> {
        let mut pieces = Vec::new();
        self.blocks(None, &mut pieces);
        let widths: Vec<usize> = pieces.iter().map(Block::width).collect();
        if widths.iter().sum::<usize>() > width && widths.iter().any(|own| *own > width / 2) {
            pieces.clear();
            self.blocks(Some(width), &mut pieces);
        }
        let mut lines = Vec::new();
        let mut row: Vec<Block> = Vec::new();
        let mut used = 0;
        for piece in pieces {
            if used + piece.width() > width && used > 4 {
                lines.extend(Block::beside(&row).lines().map(str::to_owned));
                row = vec![Block::line("    ")];
                used = 4;
            }
            used += piece.width();
            row.push(piece);
        }
        lines.extend(Block::beside(&row).lines().map(str::to_owned));
        lines
    }

    /// What a line may be broken between; for lines of some width, also within brackets that are longer than half of it.
    fn blocks(&self, width: Option<usize>, out: &mut Vec<Block>) {
        match self {
            Self::Relation(parts) => {
                for (at, part) in parts.iter().enumerate() {
                    if at > 0
                        && let Some(last) = out.last_mut()
                    {
                        *last = Block::beside(&[last.clone(), Block::line(" ")]);
                    }
                    part.blocks(width, out);
                }
            }
            Self::Sum(terms) => {
                for (at, (negative, term)) in terms.iter().enumerate() {
                    let first = out.len();
                    term.blocks(width, out);
                    if let Some(piece) = out.get_mut(first) {
                        let sign = Block::line(sign(at == 0, *negative));
                        *piece = Block::beside(&[sign, piece.clone()]);
                    }
                }
            }
            Self::Product(_) | Self::Fraction(..) => {
                let whole = self.block();
                // What is above a bar comes down only where the fraction fits no line at all.
                let brackets_last = matches!(self, Self::Product(f) if matches!(f.last(), Some(Self::Parentheses(_))));
                let wide = width
                    .is_some_and(|width| whole.width() > if brackets_last { width / 2 } else { width - width.min(8) });
                match self.with_sum_last().filter(|_| wide).as_deref() {
                    Some([before @ .., Self::Parentheses(inner)]) => {
                        let first = out.len();
                        inner.blocks(width, out);
                        if let Some(piece) = out.get_mut(first) {
                            let before = product(before);
                            *piece = Block::beside(&[before, Block::line(" ("), piece.clone()]);
                        }
                        if let Some(piece) = out.last_mut() {
                            *piece = Block::beside(&[piece.clone(), Block::line(")")]);
                        }
                    }
                    _ => out.push(whole),
                }
            }
            other => out.push(other.block()),
        }
    }
}

fn token_block(token: &Token) -> Block {
    let bracket = |own: &Bracket, round| [round, "│", "‖"][*own as usize];
    Block::line(match token {
        Token::Whole(formula) => return formula.block(),
        Token::Exponent(formula) => return exponent_block(formula),
        Token::Relation(own) => {
            let nothing = || Formula::Verbatim(String::new());
            return Formula::Relation(vec![nothing(), Formula::Sign(*own), nothing()]).block();
        }
        Token::Term { first, negative } => sign(*first, *negative),
        Token::Open(own) => bracket(own, "("),
        Token::Close(own) => bracket(own, ")"),
        Token::Exp => "exp",
        Token::Space => " ",
        Token::Comma => ", ",
        Token::Over => " / ",
    })
}

/// What stands before a term.
pub(super) fn sign(first: bool, negative: bool) -> &'static str {
    match (first, negative) {
        (true, false) => "",
        (true, true) => "-",
        (false, false) => " + ",
        (false, true) => " - ",
    }
}

fn product(factors: &[Formula]) -> Block {
    let mut blocks = Vec::new();
    for (at, factor) in factors.iter().enumerate() {
        if at > 0 {
            blocks.push(Block::line(if factor.begins_with_digit() { " · " } else { " " }));
        }
        blocks.push(factor.block());
    }
    Block::beside(&blocks)
}

/// With an exponent, whole ones in raised digits.
fn power(base: &Block, exponent: &Formula) -> Block {
    match superscript_of(exponent) {
        Some(text) if base.height() == 1 => Block::beside(&[base.clone(), Block::line(&text)]),
        Some(text) => base.clone().raised(&Block::line(&text)),
        None => base.clone().raised(&exponent_block(exponent)),
    }
}

/// Fractions of numbers on one line: 3/2.
fn exponent_block(exponent: &Formula) -> Block {
    match exponent {
        Formula::Fraction(above, below) => match (&**above, &**below) {
            (Formula::Number(over), Formula::Number(under)) if vulgar(above, below).is_none() => {
                Block::line(&format!("{over}/{under}"))
            }
            _ => exponent.block(),
        },
        Formula::Sum(terms) => match terms.as_slice() {
            [(true, own @ Formula::Fraction(..))] => Block::beside(&[Block::line("-"), exponent_block(own)]),
            _ => exponent.block(),
        },
        _ => exponent.block(),
    }
}

fn function(name: &str, exponent: Option<&Formula>, arguments: &[Formula]) -> Block {
    let name = if name == "exp" && arguments.is_empty() { "e" } else { name };
    let mut head = Block::line(name);
    if let Some(exponent) = exponent {
        head = power(&head, exponent);
    }
    if arguments.is_empty() {
        return head;
    }
    if stands_open(arguments) {
        return Block::beside(&[head, Block::line(" "), with_commas(arguments)]);
    }
    Block::beside(&[head, with_commas(arguments).in_parentheses()])
}

fn with_commas(parts: &[Formula]) -> Block {
    let parts = parts.iter().flat_map(|part| [Block::line(", "), part.block()]);
    Block::beside(&parts.skip(1).collect::<Vec<_>>())
}

/// Fractions that have a sign of their own.
fn vulgar(above: &Formula, below: &Formula) -> Option<String> {
    let (Formula::Number(above), Formula::Number(below)) = (above, below) else { return None };
    let own = format!("{above}/{below}");
    let mut all = "1/2 1/3 2/3 1/4 3/4 1/5 2/5 3/5 4/5 1/6 5/6 1/8 1/10".split(' ').zip("½⅓⅔¼¾⅕⅖⅗⅘⅙⅚⅛⅒".chars());
    all.find(|(known, _)| *known == own).map(|(_, sign)| sign.to_string())
}

/// A whole number as an exponent, with its sign.
fn superscript_of(exponent: &Formula) -> Option<String> {
    match exponent {
        Formula::Number(digits) => superscript(digits),
        Formula::Sum(terms) => match terms.as_slice() {
            [(true, Formula::Number(digits))] => superscript(&format!("-{digits}")),
            _ => None,
        },
        _ => None,
    }
}

/// A whole number in raised digits.
#[must_use]
pub fn superscript(text: &str) -> Option<String> {
    replaced(text, "0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
}

/// A unit as books have it: `kg·m²` for `kg*m^2`.
#[must_use]
pub fn unit(text: &str) -> String {
    let is_raised = |c: char| c.is_ascii_digit() || c == '-';
    let mut parts = text.split('^');
    let first = parts.next().unwrap_or_default().to_owned();
    let whole = parts.fold(first, |own, part| {
        let (power, rest) = part.split_at(part.find(|c| !is_raised(c)).unwrap_or(part.len()));
        let raised = superscript(power).filter(|raised| !raised.is_empty());
        own + &raised.unwrap_or_else(|| format!("^{power}")) + rest
    });
    whole.replace('*', "·")
}

fn lowered(text: &str) -> Option<String> {
    replaced(text, "0123456789aehijklmnoprstuvx+-", "₀₁₂₃₄₅₆₇₈₉ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ₊₋")
}

/// Every letter but spaces replaced by the one that stands in its place, or nothing.
fn replaced(text: &str, letters: &str, by: &str) -> Option<String> {
    let image = |c| letters.chars().zip(by.chars()).find(|(own, _)| *own == c).map(|(_, image)| image);
    text.chars().filter(|c| *c != ' ').map(image).collect()
}

pub(super) fn symbol_text(symbol: &Symbol) -> String {
    // No mark covers a whole word.
    let primes = if symbol.is_word() { ["", "′", "″", "‴"][symbol.dots.min(3) as usize] } else { "" };
    format!("{}{}{primes}", symbol.unicode_letter(), feet_text(&symbol.subscript))
}

/// Subscripts where Unicode has them, for digits and indices; words follow after an underscore, other indices in brackets.
fn feet_text(feet: &[Subscript]) -> String {
    let low = |foot: &Subscript| match foot {
        Subscript::Word(word) => lowered(word).filter(|_| word.bytes().all(|b| b.is_ascii_digit())),
        Subscript::Index(formula) => lowered(&one_line(formula)),
        Subscript::Coordinate(_) => None,
    };
    let lows: Vec<Option<String>> = feet.iter().map(low).collect();
    let is_one = |low: &Option<String>| low.as_ref().is_some_and(|low| low.chars().count() == 1);
    // K with the feet i and i + 1, but not with 2 and 11.
    let is_last = |low: &Option<String>| low.as_ref().is_some_and(|low| !low.starts_with(|c| ('₀'..='₉').contains(&c)));
    if let Some((last, others)) = lows.split_last()
        && others.iter().all(is_one)
        && (is_one(last) || is_last(last))
    {
        return lows.into_iter().flatten().collect();
    }
    let mut out = String::new();
    let mut indices = Vec::new();
    // Two indices stand together: K[2, 11].
    let apart = feet.iter().filter(|foot| matches!(foot, Subscript::Index(_))).count() < 2;
    for (at, (foot, low)) in feet.iter().zip(lows).enumerate() {
        match (foot, low) {
            (foot, Some(low)) if at == 0 && (apart || !matches!(foot, Subscript::Index(_))) => out.push_str(&low),
            (Subscript::Word(word), _) => out.push_str(&format!("_{}", unicode_word(word))),
            (Subscript::Coordinate(symbol), _) => out.push_str(&format!("_{}", symbol_text(symbol))),
            (Subscript::Index(formula), _) => indices.push(one_line(formula)),
        }
    }
    if !indices.is_empty() {
        out.push_str(&format!("[{}]", indices.join(", ")));
    }
    out
}

fn one_line(formula: &Formula) -> String {
    formula.block().lines().collect::<Vec<_>>().join(" ")
}
