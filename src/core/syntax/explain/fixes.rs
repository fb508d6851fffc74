//! Fixes written out with what the text says: short ones only, for the others a pattern does.

use super::super::error::SyntaxError;
use super::super::lexer::{Lexer, Token, TokenKind};
use super::super::words;
use super::context::{Context, Part};
use crate::diagnostic::factors_in;
use crate::order::Gather;
use crate::span::Span;

/// A longer fix would not be read.
const MOST_CHARACTERS: usize = 60;

/// As far back a declaration is searched for: every mistake has one searched for, and files may be long.
const LOOKED_BACK: u32 = 1 << 16;

/// Tokens as they are printed in a fix: without blanks, what stands in brackets left out.
fn compact(source: &str, span: Span) -> Option<String> {
    let mut out = String::new();
    let mut depth = 0_usize;
    for token in Lexer::new(source, span) {
        match token.kind {
            TokenKind::Comment => continue,
            TokenKind::Close => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            out.push_str(token.text(source));
        }
        if token.kind == TokenKind::Open {
            depth += 1;
            if depth == 1 {
                out.push('…');
            }
        }
        if out.len() > 4 * MOST_CHARACTERS {
            return None;
        }
    }
    short(out)
}

/// A piece of the text on one line, its gaps closed to single spaces.
pub(super) fn verbatim(source: &str, start: u32, end: u32) -> Option<String> {
    let text = source.get(Span::new(start, end).range())?;
    let plain = !text.trim().is_empty() && !text.trim().contains(['\n', '#']);
    let words: Vec<&str> = text.split_whitespace().take(MOST_CHARACTERS).collect();
    short(words.join(" ")).filter(|_| plain)
}

pub(super) fn short(text: String) -> Option<String> {
    (text.chars().count() <= MOST_CHARACTERS).then_some(text)
}

/// Whether the name at `token` is given a value or a unit: `k = …`, `k[1..3] : N/m`.
pub(super) fn binds(source: &str, token: Token, end: u32) -> bool {
    let mut depth = 0_usize;
    for next in Lexer::new(source, Span::new(token.end, end)).code() {
        match next.kind {
            TokenKind::Open if next.text(source) == "[" || depth > 0 => depth += 1,
            TokenKind::Close if depth > 0 => depth -= 1,
            TokenKind::Equals | TokenKind::Colon if depth == 0 => return true,
            TokenKind::Comparison if depth == 0 => return next.text(source) == "==",
            _ if depth == 0 => return false,
            _ => {}
        }
    }
    false
}

/// Whether a statement has an index of that name.
fn is_index(source: &str, statement: Span, name: &str) -> bool {
    let words: Vec<&str> = Lexer::new(source, statement).map(|own| own.text(source)).collect();
    words.windows(2).any(|two| two == [name, "in"])
}

/// Whether all that stands at a place in a statement are factors: names that are declared, indices of the statement, or the
/// language's own words as it has them. What may be called with the time, `x (t)`, belong below a bar, `x/2 l`, or
/// be an uncertainty, `9.81(2)`, is not sure.
pub(in super::super) fn are_factors(source: &str, statement: Span, place: Span) -> bool {
    let words: Vec<&str> = Lexer::new(source, statement).map(|own| own.text(source)).collect();
    let is_index = |name: &str| is_index(source, statement, name);
    let is_digit = |c: char| c.is_ascii_digit();
    let is_called = |four: &[&str]| match four {
        [name, "(", "t", ")"] => !words::is_function(name),
        [number, "(", digits, ")"] => number.starts_with(is_digit) && digits.chars().all(is_digit),
        _ => false,
    };
    let is_known = |own: Token| {
        let name = own.text(source);
        let own_word = words::is_function(name) || words::is_connective(name) || matches!(name, "t" | "pi");
        own.kind != TokenKind::Word || own_word || is_index(name) || is_declared(source, statement.start, name)
    };
    Lexer::new(source, place).all(is_known)
        && !words.windows(4).any(is_called)
        && !is_below_a_bar(source, Span::new(statement.start, place.end))
}

/// Whether commas separate what stands in a bracket: all of it, and the entry that is read.
struct Separated {
    all: bool,
    entry: bool,
}

/// What may be missing between operands that stand side by side in a part of a statement, if it may be no sign: a comma in a
/// list, between arguments, behind a range or a relation; the word of a second constraint.
pub(in super::super) fn separator_in(source: &str, statement: Span, part: Span) -> Option<&'static str> {
    let mut tokens = Lexer::new(source, statement).code();
    let mut before = tokens.next()?;
    let is_drawn = before.text(source) == "draw";
    let between_relations = [("assume", ","), ("constraint", "constraint")];
    let between_relations = between_relations.into_iter().find(|(word, _)| *word == before.text(source));
    let mut levels = vec![Separated { all: is_drawn, entry: is_drawn }];
    // Whether a sign of relation stands before the place, and operands side by side behind it.
    let [mut is_related, mut is_open] = [false; 2];
    for token in tokens {
        let text = token.text(source);
        let at_top = levels.len() == 1;
        let own = levels.last_mut()?;
        let is_within = before.end >= part.start && token.end <= part.end;
        if is_within && side_by_side_at(source, before, token) == Some(true) {
            if own.entry {
                return Some(",");
            }
            is_open |= at_top && is_related;
        }
        match token.kind {
            TokenKind::Open => {
                let call = words::signature(before.text(source)).map_or("", |(call, _)| call);
                let all = text == "[" || call.contains(',') && !call.contains(" in ");
                levels.push(Separated { all, entry: all });
            }
            TokenKind::Close if !at_top => drop(levels.pop()),
            TokenKind::Comma => {
                own.entry = own.all;
                is_related &= !at_top;
                is_open &= !at_top;
            }
            TokenKind::Equals | TokenKind::Comparison if at_top => {
                if let Some((_, separator)) = between_relations.filter(|_| is_open) {
                    return Some(separator);
                }
                is_related = true;
            }
            _ => own.entry |= text == "in" && !at_top,
        }
        before = token;
    }
    None
}

/// What a product divides by.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Bar {
    None,
    /// A number that divides a number: `1/2`.
    Fraction,
    Some,
}

/// Whether a factor without a sign before it may belong below a bar: `x/2 l` and `1/2k`, but not `1/2 k`.
fn is_below_a_bar(source: &str, place: Span) -> bool {
    let mut levels = vec![Bar::None];
    let [mut before, mut last] = [None::<Token>; 2];
    for token in Lexer::new(source, place).code() {
        let is_number = |own: Option<Token>| own.is_some_and(|own| own.kind == TokenKind::Number);
        let is_gap = before.is_some_and(|before| side_by_side_at(source, before, token) == Some(true));
        let bar = levels.last().copied().unwrap_or(Bar::None);
        if is_gap && (bar == Bar::Some || bar == Bar::Fraction && token.glued && is_number(before)) {
            return true;
        }
        let is_behind = |kind: TokenKind| before.is_some_and(|before| before.kind == kind);
        let bar = match token.kind {
            // The exponent of `x^2/2` is no numerator.
            TokenKind::Slash if is_number(before) && last.is_none_or(|last| last.kind != TokenKind::Caret) => {
                Bar::Fraction
            }
            TokenKind::Slash => Bar::Some,
            TokenKind::Plus | TokenKind::Comma | TokenKind::Equals => Bar::None,
            TokenKind::Minus if !is_behind(TokenKind::Caret) => Bar::None,
            kind if is_behind(TokenKind::Slash) && kind != TokenKind::Number => Bar::Some,
            _ => bar,
        };
        match token.kind {
            TokenKind::Close => levels.truncate(levels.len().saturating_sub(1).max(1)),
            kind => {
                levels.pop();
                levels.push(bar);
                levels.extend((kind == TokenKind::Open).then_some(Bar::None));
            }
        }
        (last, before) = (before, Some(token));
    }
    false
}

/// Whether a sign is missing between two tokens; `None` where something else is.
fn side_by_side_at(source: &str, before: Token, token: Token) -> Option<bool> {
    let (left, right) = (before.text(source), token.text(source));
    let ends = match before.kind {
        TokenKind::Word => !words::is_connective(left),
        TokenKind::Number | TokenKind::Close | TokenKind::Prime => true,
        _ => false,
    };
    let begins = match token.kind {
        TokenKind::Word => !words::is_connective(right),
        TokenKind::Number => true,
        TokenKind::Open => right == "(",
        _ => false,
    };
    let call = before.kind == TokenKind::Word && right == "(" && (token.glued || words::is_function(left));
    if !ends || !begins || call {
        return Some(false);
    }
    let wrong = before.kind == TokenKind::Word && words::is_function(left)
        || before.kind == TokenKind::Number && token.kind == TokenKind::Number;
    (!wrong).then_some(true)
}

/// `x[i]'^2` for `x'^2`, where there is one name.
fn with_index(text: &str) -> Option<String> {
    let words = Lexer::new(text, Span::new(0, text.len() as u32)).filter(|own| own.kind == TokenKind::Word);
    let name = words.only()?;
    let (before, behind) = text.split_at(name.end as usize);
    (!behind.trim_start().starts_with(['[', '('])).then(|| format!("{before}[i]{behind}"))
}

/// Whether a name is declared before a place, and not too long before.
pub(super) fn is_declared(source: &str, place: u32, name: &str) -> bool {
    declaring_word(source, place, name).is_some()
}

/// The word of the statement that declares a name before a place.
pub(super) fn declaring_word(source: &str, place: u32, name: &str) -> Option<&'static str> {
    let mut from = place.saturating_sub(LOOKED_BACK);
    while !source.is_char_boundary(from as usize) {
        from += 1;
    }
    declared_in(source, Span::new(from, place), name)
}

/// The same for a name that is given again; a family may have several pieces.
pub(super) fn given_by(source: &str, name: Token, next: Option<Token>) -> Option<&'static str> {
    let is_member = next.is_some_and(|next| next.text(source) == "[");
    declaring_word(source, name.start, name.text(source)).filter(|word| *word == "coord" || !is_member)
}

/// The word of the statement that declares a name in a part of the text.
pub(super) fn declared_in(source: &str, part: Span, name: &str) -> Option<&'static str> {
    let mut before: Option<Token> = None;
    let (mut word, mut depth) = ("", 0_usize);
    for token in Lexer::new(source, part).code() {
        let text = token.text(source);
        let declares = before.is_some_and(|before| match before.kind {
            TokenKind::Comma => depth == 0 && words::takes_several(word),
            _ => words::is_naming(before.text(source)),
        });
        if declares && text == name {
            return words::STATEMENT_WORDS.into_iter().find(|own| *own == word);
        }
        depth = token.depth_behind(depth);
        if words::is_statement_word(text) {
            (word, depth) = (text, 0);
        }
        before = Some(token);
    }
    None
}

impl Context<'_> {
    /// `np.cos(x)`, `v.norm()`: a call behind a name and a point.
    pub(super) fn prefixed_function(&self, found: Token) -> Option<SyntaxError> {
        let behind_point = self.before_last.is_some_and(|last| last.kind == TokenKind::Dot);
        if !behind_point || self.text(found) != "(" {
            return None;
        }
        let is_sum = self.text(self.before) == "sum";
        let meant = if is_sum { Some("sum") } else { words::function_meant(self.text(self.before)) };
        let span = Span::new(self.prefix_start(), self.before.end);
        let function = short(self.source.get(span.range())?.to_owned());
        let function = function.unwrap_or_else(|| format!("….{}", self.text(self.before)));
        let argument = self.argument(found);
        let prefix = function.split_once('.').map_or("", |(first, _)| first);
        let Some(meant) = meant else {
            // A column of a row is multiplied.
            let is_free =
                !self.is_declared(prefix) && !is_index(self.source, Span::new(self.word.start, self.end), prefix);
            return is_free.then(|| {
                let list = self.list_in(found).filter(|_| words::is_list(self.text(self.before)));
                let fix = list.as_ref().map(|(_, list)| list.clone());
                let change = list.map(|(end, list)| (Span::new(span.start, end), list));
                SyntaxError::PrefixedFunction { function, fix, change, span }
            });
        };
        let inside = match (argument, self.is_declared(prefix)) {
            (argument, is_declared) if is_sum => {
                let summed = if is_declared { Some(prefix.to_owned()) } else { argument };
                format!("i in 1..n, {}", summed.and_then(|own| with_index(&own)).unwrap_or_else(|| "…".to_owned()))
            }
            (Some(argument), true) if argument.is_empty() => prefix.to_owned(),
            (Some(argument), true) => format!("{prefix}, {argument}"),
            (Some(argument), false) if !argument.is_empty() => argument,
            (Some(_) | None, _) => "…".to_owned(),
        };
        let fix = format!("{meant}({inside})");
        let change = match (inside.as_str(), self.is_declared(prefix), self.closing(found)) {
            // How many there are is not seen here.
            _ if is_sum => None,
            ("…", true, _) | (_, true, None) => None,
            (_, true, Some(close)) => Some((Span::new(span.start, close.end), fix.clone())),
            (_, false, _) => Some((span, meant.to_owned())),
        };
        Some(SyntaxError::PrefixedFunction { function, fix: Some(fix), change, span })
    }

    /// The list that is the argument in the parentheses that open at a token, or the first of them, and where these end.
    fn list_in(&self, open: Token) -> Option<(u32, String)> {
        let close = self.closing(open)?;
        let first = self.after.filter(|after| self.text(*after) == "[")?;
        let last = self.closing(first)?;
        let next = Lexer::new(self.source, Span::new(last.end, self.end)).code().next()?;
        let list = self.source.get(first.start as usize..last.end as usize)?.to_owned();
        matches!(next.kind, TokenKind::Close | TokenKind::Comma).then_some((close.end, list))
    }

    /// `x.diff(t)` with parentheses at the place, `d/dt x` with a name at it.
    pub(super) fn foreign_derivative(&self, found: Token) -> Option<SyntaxError> {
        let before: Vec<Token> = Lexer::new(self.source, Span::new(self.chain?, found.start)).code().collect();
        let [.., first, sign, last] = before.as_slice() else { return None };
        let (name, start, end) = match [*first, *sign, *last].map(|own| self.text(own)) {
            [name, ".", own] if words::is_derivative(own) && self.text(found) == "(" => {
                self.argument(found).filter(|own| matches!(own.as_str(), "" | "t"))?;
                (name, found, self.closing(found)?)
            }
            ["d", "/", "dt"] => {
                let members = self.after.filter(|after| self.text(*after) == "[" && after.glued);
                (self.text(found), found, members.and_then(|open| self.closing(open)).unwrap_or(found))
            }
            _ => return None,
        };
        let members =
            if name == self.text(start) { self.source.get(start.end as usize..end.end as usize)? } else { "" };
        let fix = self.is_declared(name).then(|| format!("{name}{members}'"))?;
        Some(SyntaxError::ArgumentOfDerivative { fix: Some(fix), span: Span::new(first.start, end.end) })
    }

    /// Where the names and points begin that stand before the place.
    fn prefix_start(&self) -> u32 {
        let (mut start, mut name) = (self.before.start, false);
        for token in Lexer::new(self.source, Span::new(self.word.end, self.before.end)).code() {
            match token.kind {
                TokenKind::Dot | TokenKind::Word if name => continue,
                TokenKind::Word => start = token.start,
                _ => start = self.before.start,
            }
            name = token.kind == TokenKind::Word;
        }
        start
    }

    /// What stands in the parentheses that open at a token, if it is short and has no points in it.
    pub(super) fn argument(&self, open: Token) -> Option<String> {
        let close = self.closing(open)?;
        let inside = Span::new(open.end, close.start);
        let strange = |token: Token| matches!(token.kind, TokenKind::Dot | TokenKind::Illegal | TokenKind::DoubleStar);
        let text = self.source.get(inside.range())?;
        let plain = !text.contains(['\n', '#']) && !Lexer::new(self.source, inside).any(strange);
        short(text.trim().to_owned()).filter(|_| plain)
    }

    /// The bracket that closes the one at a token.
    pub(super) fn closing(&self, open: Token) -> Option<Token> {
        let mut depth = 0_usize;
        for token in Lexer::new(self.source, Span::new(open.start, self.end)) {
            match token.kind {
                TokenKind::Open => depth += 1,
                TokenKind::Close => depth = depth.checked_sub(1)?,
                _ => {}
            }
            if depth == 0 {
                return Some(token);
            }
        }
        None
    }

    /// The product around the place with all the signs that are missing in it, and its place: `m*g*l*(1 - cos(phi))`.
    pub(super) fn product_with_signs(&self) -> Option<(Span, String)> {
        let start = self.chain?;
        let mut out = String::new();
        let mut depth = 0_usize;
        let mut before: Option<Token> = None;
        for token in Lexer::new(self.source, Span::new(start, self.end)) {
            let text = self.text(token);
            // `sin^2(x)` is no product.
            if before.is_some_and(|before| words::is_function(self.text(before))) && text != "(" {
                return None;
            }
            let inside = matches!(
                token.kind,
                TokenKind::Star | TokenKind::Slash | TokenKind::Caret | TokenKind::Prime | TokenKind::Open
            ) || token.kind == TokenKind::Minus
                && before.is_some_and(|before| before.kind == TokenKind::Caret);
            match token.kind {
                TokenKind::Word | TokenKind::Number if words::reserved_meaning(text) == Some("begins a statement") => {
                    break;
                }
                TokenKind::Word if depth == 0 && words::is_connective(text) => break,
                TokenKind::Word | TokenKind::Number => {}
                TokenKind::Close if depth == 0 => break,
                TokenKind::Close => depth -= 1,
                TokenKind::Comment | TokenKind::Illegal | TokenKind::DoubleStar | TokenKind::HalfNumber => return None,
                _ if depth == 0 && !inside => break,
                _ => {}
            }
            if let Some(before) = before {
                if side_by_side_at(self.source, before, token)? {
                    if token.first_on_line && depth == 0 {
                        break;
                    }
                    out.push('*');
                } else {
                    out.push_str(self.source.get(before.end as usize..token.start as usize)?);
                }
            }
            out.push_str(&self.apart(token, before).unwrap_or_else(|| text.to_owned()));
            depth += usize::from(token.kind == TokenKind::Open);
            before = Some(token);
        }
        Some((Span::new(start, before?.end), without_single(&out)))
    }

    /// `m*g` for `mg`, unless something binds it closer.
    fn apart(&self, token: Token, before: Option<Token>) -> Option<String> {
        let name =
            Some(self.text(token)).filter(|own| words::reserved_meaning(own).is_none() && !self.is_declared(own));
        let name = name.filter(|_| self.part != Part::Unit)?;
        let next = Lexer::new(self.source, Span::new(token.end, self.end)).next();
        let is_bound = before.is_some_and(|own| matches!(own.kind, TokenKind::Slash | TokenKind::Caret))
            || next.is_some_and(|own| match own.kind {
                TokenKind::Caret | TokenKind::Prime | TokenKind::Dot => true,
                kind => kind == TokenKind::Open && own.glued,
            });
        let factors = factors_in(name, &|own| self.is_declared(own)).filter(|_| !is_bound)?;
        Some(factors.join("*"))
    }

    /// What to write for `g/2l`, of which `g/2*l` is one reading, if the number at the place divides and `l` with it.
    pub(super) fn below_the_bar(&self, found: Token, product: &str) -> Option<String> {
        let is_bar = self.before.kind == TokenKind::Number
            && self.before_last.is_some_and(|last| last.kind == TokenKind::Slash)
            && is_below_a_bar(self.source, Span::new(self.chain?, found.end));
        let (number, name) = (self.text(self.before), self.text(found));
        let (left, right) = product.split_once(&format!("/{number}*{name}"))?;
        let is_whole = found.kind == TokenKind::Word && !right.starts_with(['^', '\'', '(', '[', '.']);
        let all = if is_whole {
            format!("`{left}/({number}*{name}){right}`")
        } else {
            "put parentheses around that".to_owned()
        };
        is_bar.then(|| format!("if more is below the bar, {all}"))
    }

    /// The product that ends before the place: `1/2` before the `x` of `1/2 x`.
    pub(super) fn product_before(&self) -> Option<String> {
        compact(self.source, Span::new(self.chain?, self.before.end))
    }

    /// `sin^2(x)` as `sin(x)^2`, with parentheses that open at a token: what is replaced, and by what.
    pub(super) fn power_moved(&self, function: Token, exponent: &str, open: Token) -> Option<(Span, String)> {
        // `sin^-1` is mostly meant as the inverse function.
        let close = self.closing(open).filter(|_| self.text(open) == "(" && !exponent.starts_with('-'))?;
        let next = Lexer::new(self.source, Span::new(close.end, self.end)).next();
        if next.is_some_and(|next| matches!(next.kind, TokenKind::Caret | TokenKind::Prime | TokenKind::Illegal)) {
            return None;
        }
        let argument = self.source.get(open.start as usize..close.end as usize)?;
        let text = format!("{}{argument}^{exponent}", self.text(function));
        Some((Span::new(function.start, close.end), text))
    }

    /// `constraint rod[i in 1..n]: …` and `constraint i in 1..n: …`: the place is at `in`.
    pub(super) fn constraint_indices(&self) -> Option<SyntaxError> {
        let bracket = self.enclosures.len() == 1 && self.before_last.is_some_and(|own| self.text(own) == "[");
        if self.before_is_word() || !bracket && !self.enclosures.is_empty() {
            return None;
        }
        let mut rest = Lexer::new(self.source, Span::new(self.before.start, self.end));
        let last = rest.find(|own| match own.kind {
            TokenKind::Close => bracket,
            TokenKind::Colon | TokenKind::Comma => !bracket,
            _ => false,
        });
        let colon = if bracket { rest.next() } else { last };
        let inside = verbatim(self.source, self.before.start, last.map_or(self.end, |own| own.start))?;
        let place = colon.filter(|own| own.kind == TokenKind::Colon).map(|own| Span::new(self.word.end, own.end));
        let span = self.before.span().to(self.found?.span());
        Some(SyntaxError::ConstraintIndices { fix: format!("[{inside}]"), place, span })
    }

    /// `Σ(i in 1..n, …)`, `Sum(i in 1..n, …)`: the place is at `in`.
    pub(super) fn foreign_sum(&self) -> Option<SyntaxError> {
        let open = self.before_last.filter(|own| self.text(*own) == "(")?;
        let head = Lexer::new(self.source, Span::new(self.word.start, open.start)).last()?;
        let character = self.text(head).to_owned();
        let is_sum = matches!(character.to_lowercase().as_str(), "sum" | "sigma" | "σ");
        (is_sum && !self.is_declared(&character)).then(|| SyntaxError::IllegalCharacter {
            character,
            hint: None,
            fix: Some("sum".to_owned()),
            is_glued: false,
            span: head.span(),
        })
    }

    /// Whether `T - V` begins at a token and is all of a Lagrangian.
    pub(super) fn is_difference_of_energies(&self, first: Token) -> bool {
        let rest = Lexer::new(self.source, Span::new(first.start, self.end));
        let words: Vec<&str> = rest.take(4).map(|own| self.text(own)).collect();
        self.statement == "lagrangian" && self.before.kind == TokenKind::Equals && words == ["T", "-", "V"]
    }

    /// Whether a name is declared before the statement, and not too long before.
    pub(super) fn is_declared(&self, name: &str) -> bool {
        is_declared(self.source, self.word.start, name)
    }

    /// The statement begun by the name at the place, whose word is missing: `param k = 2`.
    pub(super) fn with_statement_word(&self, name: Token) -> Option<String> {
        let word = self.statement;
        if !matches!(word, "param" | "let" | "guess" | "equilibrium") {
            return None;
        }
        let mut tokens = Lexer::new(self.source, Span::new(name.start, self.end)).code();
        let equals = tokens.find(|token| token.kind == TokenKind::Equals || self.text(*token) == "==");
        let Some(equals) = equals else {
            let declared = verbatim(self.source, name.start, self.end)?;
            return short(format!("{word} {declared}"));
        };
        let head = verbatim(self.source, name.start, equals.start)?;
        let value = match (tokens.next(), tokens.next()) {
            (Some(only), None) => self.text(only),
            (Some(number), Some(next)) if number.kind == TokenKind::Number && next.kind == TokenKind::Word => {
                self.text(number)
            }
            _ => "…",
        };
        short(format!("{word} {head} = {value}"))
    }
}

/// `2*m` for `2*(m)`.
fn without_single(product: &str) -> String {
    let mut out = String::new();
    for (number, part) in format!("*{product}").split("*(").enumerate() {
        let is_name =
            |name: &str| name.starts_with(char::is_alphabetic) && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        match part.split_once(')').filter(|(name, _)| number > 0 && is_name(name)) {
            Some((name, rest)) => out.extend(["*", name, rest]),
            None => out.extend([if number > 0 { "*(" } else { "" }, part]),
        }
    }
    out.split_off(1)
}
