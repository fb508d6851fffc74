//! Units behind values, and numbers as other languages have them.

use super::super::error::SyntaxError;
use super::super::lexer::{Lexer, Token, TokenKind};
use super::super::{units, words};
use super::context::{Context, Part};
use super::fixes::{binds, declared_in, short, verbatim};
use crate::span::Span;

/// As far behind a statement a declaration is searched for.
const LOOKED_AHEAD: u32 = 1 << 14;

/// What is written as a unit: `kg m^2`.
pub(super) struct Written<'s> {
    names: Vec<&'s str>,
    /// As the language has it, where it is complete: `kg*m^2`.
    text: Option<String>,
    pub(super) end: u32,
    /// Whether it has one reading.
    is_certain: bool,
    /// Whether no word in it is none of a unit.
    is_known: bool,
}

impl<'s> Context<'s> {
    /// The unit that begins at a token.
    pub(super) fn unit_at(&self, first: Token) -> Written<'s> {
        let mut unit = Written { names: Vec::new(), text: None, end: first.end, is_certain: true, is_known: true };
        let mut joined = String::new();
        let (mut complete, mut caret, mut ends) = (false, false, true);
        // Each of an exponent or not.
        let mut brackets: Vec<bool> = Vec::new();
        for token in Lexer::new(self.source, Span::new(first.start, self.end)).code() {
            let text = self.text(token);
            let outside = brackets.is_empty();
            let in_power = caret || brackets.contains(&true);
            let is_operand = matches!(token.kind, TokenKind::Word | TokenKind::Number | TokenKind::Open);
            if complete && is_operand {
                let is_word = token.kind == TokenKind::Word;
                if outside && (token.first_on_line || is_word && self.begins_another(token)) {
                    // It may go on in the next line.
                    unit.is_certain = !units::is_like_unit(text) || self.begins_another(token);
                    break;
                }
                if !is_word || in_power || !units::is_like_unit(text) {
                    unit.is_known &= !is_word || text == "per";
                    ends = false;
                    break;
                }
                if joined.contains('/') {
                    // It may belong below the bar, or beside it.
                    (ends, unit.is_certain) = (false, false);
                    break;
                }
                joined.push('*');
            }
            match token.kind {
                TokenKind::Comma if complete && outside => break,
                TokenKind::Word if !in_power => {
                    unit.names.push(text);
                    unit.is_known &= units::is_like_unit(text) && words::reserved_meaning(text).is_none();
                    (complete, caret) = (true, false);
                    joined.push_str(text);
                }
                TokenKind::Number if in_power || text == "1" && joined.is_empty() => {
                    (complete, caret) = (true, false);
                    joined.push_str(text);
                }
                TokenKind::Minus if in_power && !complete => joined.push('-'),
                TokenKind::Star | TokenKind::Slash | TokenKind::Caret if complete => {
                    (complete, caret) = (false, token.kind == TokenKind::Caret);
                    joined.push_str(text);
                }
                TokenKind::Open => {
                    brackets.push(caret);
                    (complete, caret) = (false, false);
                    joined.push_str(text);
                }
                TokenKind::Close if complete && brackets.pop().is_some() => joined.push_str(text),
                _ => {
                    ends = false;
                    break;
                }
            }
            unit.end = token.end;
        }
        unit.text = Some(without_brackets(joined)).filter(|text| complete && ends && text != "1");
        unit
    }

    /// Whether another statement may begin at a word: `k = 2`, `parm k`.
    fn begins_another(&self, word: Token) -> bool {
        let next = Lexer::new(self.source, Span::new(word.end, self.end)).code().next();
        let before_name = next.is_some_and(|next| next.kind == TokenKind::Word && !next.first_on_line);
        let text = self.text(word);
        binds(self.source, word, self.end) || before_name && !units::is_like_unit(text)
    }

    /// The unit behind a value of numbers alone that may begin at `found`.
    pub(super) fn unit_behind_number(&self, found: Token) -> Option<Written<'s>> {
        let behind = matches!(self.before.kind, TokenKind::Number | TokenKind::Close) || self.text(self.before) == "pi";
        let with_value = matches!(self.statement, "param" | "let" | "guess" | "equilibrium");
        let start = self.value_start.filter(|_| behind && with_value && self.enclosures.is_empty())?;
        let of_numbers = Lexer::new(self.source, Span::new(start, self.before.end)).all(|token| {
            let text = self.text(token);
            token.kind != TokenKind::Word || text == "pi" || words::is_function(text)
        });
        let unit = self.unit_at(found);
        let may_be = unit.text.is_some() || found.kind == TokenKind::Word;
        (of_numbers && may_be && unit.is_known && !unit.names.is_empty()).then_some(unit)
    }

    /// A unit behind a value: `param l = 30 cm`. `2(m)` and names that are all declared are rather factors.
    pub(super) fn misplaced_unit(&self, found: Token) -> Option<SyntaxError> {
        let unit = self.unit_behind_number(found)?;
        if found.kind == TokenKind::Open && found.glued || unit.names.iter().all(|name| self.is_declared(name)) {
            return None;
        }
        let product = || {
            let whole = self.product_with_signs().filter(|(span, text)| span.end > found.start && !text.contains('['));
            let Some(text) = &unit.text else { return whole.map(|(_, text)| text) };
            let (open, close) = match self.text(found) {
                "[" => return None,
                "(" if unit.names != [text.as_str()] => ("(", ")"),
                _ => ("", ""),
            };
            Some(format!("{}*{open}{text}{close}", self.product_before()?))
        };
        Some(SyntaxError::UnitBehindValue {
            fix: self.with_unit_behind_name(&unit),
            product: product().and_then(short),
            given: self.given_unit(),
            change: if self.is_decided(&unit) { self.unit_moved(found, &unit) } else { None },
            span: Span::new(found.start, unit.end),
        })
    }

    /// `param g = 9.81 : m/s^2`, with the colon at the place.
    pub(super) fn unit_behind_colon(&self, colon: Token) -> SyntaxError {
        let first = self.after;
        let unit = first.map(|first| self.unit_at(first));
        SyntaxError::UnitBehindValue {
            fix: unit.as_ref().and_then(|unit| self.with_unit_behind_name(unit)),
            product: None,
            given: self.given_unit(),
            change: first.zip(unit.as_ref()).and_then(|(first, unit)| self.unit_moved(first, unit)),
            span: colon.span(),
        }
    }

    /// What to write if a unit is meant, where a product is more likely: `param l : m = 30`, `30*pi/180` for `30 deg`.
    pub(super) fn with_unit(&self, found: Token) -> Option<String> {
        let Some(unit) = self.unit_behind_number(found) else { return self.in_si(found) };
        let is_short = |name: &&str| words::SHORT_UNITS.contains(name) || found.kind == TokenKind::Open;
        unit.text.as_ref().filter(|_| unit.names.iter().any(is_short))?;
        self.with_unit_behind_name(&unit).map(|text| format!("`{text}`"))
    }

    /// What to write for `9.81(2)` in the value of a parameter, where the digits in parentheses may be the
    /// uncertainty of the last ones.
    pub(super) fn uncertainty(&self, found: Token) -> Option<String> {
        let (number, close) = (self.text(self.before), self.closing(found).filter(|_| found.glued)?);
        let uncertain = self.argument(found).filter(|own| digits(own))?;
        let is_value = self.statement == "param" && self.part == Part::Value && self.enclosures.is_empty();
        if !is_value || self.before.kind != TokenKind::Number || number.contains(['e', 'E']) {
            return None;
        }
        let places = number.split_once('.').map_or(0, |(_, behind)| behind.len());
        let padded = format!("{uncertain:0>width$}", width = places + 1);
        let (whole, behind) = padded.split_at(padded.len() - places);
        // `1.66(5)e-27`
        let rest = self.source.get(close.end as usize..self.end as usize)?;
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && !matches!(c, '+' | '-')).unwrap_or(rest.len());
        let power = rest.get(..end).filter(|own| own.starts_with('e') && own.ends_with(|c: char| c.is_ascii_digit()));
        let [point, power] = [if places > 0 { "." } else { "" }, power.unwrap_or("")];
        Some(format!("{number}{power} ± {whole}{point}{behind}{power}"))
    }

    /// The number before a unit in SI, in an expression, where units have no place.
    fn in_si(&self, found: Token) -> Option<String> {
        // `30 cm*x`
        let is_single = self.after.is_none_or(|after| {
            let is_factor = |text: &str| units::is_like_unit(text) || text == "(";
            !matches!(after.kind, TokenKind::Slash | TokenKind::Caret) && !is_factor(self.text(after))
        });
        let mut unit = self.unit_at(found);
        if is_single && found.kind == TokenKind::Word && units::is_like_unit(self.text(found)) {
            unit = Written { names: vec![self.text(found)], text: None, is_known: true, ..unit };
        }
        let is_usual = unit.names.iter().all(|name| words::UNITS_BEHIND_NUMBERS.contains(name));
        let is_own = |name: &&str| !self.is_declared(name);
        let number = self.before.kind == TokenKind::Number && self.part != Part::Unit;
        if !number || !is_usual || !unit.is_known || !unit.names.iter().any(is_own) {
            return None;
        }
        let is_plain = |name: &&str| units::in_si(name).as_deref() == Some("");
        let factor = match unit.names.as_slice() {
            [only] if unit.text.as_deref().is_none_or(|text| text == *only) => units::in_si(only)?,
            names => names.iter().all(is_plain).then(String::new)?,
        };
        Some(format!("`{}{factor}`, since an expression is in SI and has no units", self.text(self.before)))
    }

    /// The unit that the statement has behind its name.
    fn given_unit(&self) -> Option<String> {
        let between = verbatim(self.source, self.name_end?, self.value_start?)?;
        let unit = between.strip_prefix(':')?.strip_suffix('=')?.trim();
        (!unit.is_empty()).then(|| unit.to_owned())
    }

    /// Whether nothing but a unit can be meant: its names are those of usual units, and none is declared, or not all as in
    /// `m/s`.
    fn is_decided(&self, unit: &Written<'_>) -> bool {
        let file_end = u32::try_from(self.source.len()).unwrap_or(u32::MAX);
        let mut behind = self.end.saturating_add(LOOKED_AHEAD).min(file_end);
        while !self.source.is_char_boundary(behind as usize) {
            behind -= 1;
        }
        let behind = Span::new(self.end, behind);
        let indices = self.name_end.and_then(|end| verbatim(self.source, self.name_start, end)).unwrap_or_default();
        let is_index = |name: &str| indices.contains(&format!("{name} in"));
        let is_declared =
            |name: &&&str| is_index(name) || self.is_declared(name) || declared_in(self.source, behind, name).is_some();
        let declared: Vec<&&str> = unit.names.iter().filter(is_declared).collect();
        let is_own = |name: &&str| !declared.contains(&name) && (name.len() > 1 || *name == "s");
        unit.names.iter().all(|name| words::UNITS_BEHIND_NUMBERS.contains(name))
            && (declared.is_empty() || unit.names.iter().any(is_own))
    }

    /// `param l = 30 cm`, `param g = 9.81 : m/s^2`: the statement with the unit behind the name.
    fn with_unit_behind_name(&self, unit: &Written<'_>) -> Option<String> {
        let name = verbatim(self.source, self.name_start, self.name_end?)?;
        let value = verbatim(self.source, self.value_start?, self.before.end)?;
        let (unit, value) = unit.text.as_deref().map_or(("UNIT", "VALUE"), |unit| (unit, value.as_str()));
        short(format!("{} {name} : {unit} = {value}", self.statement))
    }

    /// The unit that begins at a token put behind the name, or left out where it is there already: what is replaced, and by
    /// what.
    fn unit_moved(&self, first: Token, unit: &Written<'_>) -> Option<(Span, String)> {
        let value = verbatim(self.source, self.value_start?, self.before.end)?;
        verbatim(self.source, first.start, unit.end)?;
        let text = unit.text.as_ref().filter(|_| unit.is_certain)?;
        if let Some(given) = self.given_unit() {
            let is_same = given.replace(' ', "") == *text;
            return is_same.then(|| (Span::new(self.before.end, unit.end), String::new()));
        }
        // What is given several times, or has brackets around its unit, is left to the author.
        // So is what may be below a bar, or belong to one term.
        let in_terms = value.contains(['/', '+']) || value.get(1..).is_some_and(|rest| rest.contains('-'));
        let plain = self.part == Part::Value && self.text(first).starts_with(char::is_alphabetic) && !in_terms;
        let name = self.source.get(self.name_start as usize..self.name_end.filter(|_| plain)? as usize)?.trim_end();
        let place = Span::new(self.name_start + name.len() as u32, unit.end);
        Some((place, format!(" : {text} = {value}")))
    }

    /// `0x10`, `1_000`, `6.02x10^23`, `1e`: a number that is glued to letters, as it is written elsewhere.
    pub(super) fn foreign_number(&self, found: Token) -> Option<SyntaxError> {
        let (number, word) = (self.text(self.before), self.text(found));
        if self.before.kind != TokenKind::Number || found.kind != TokenKind::Word || self.is_declared(word) {
            return None;
        }
        let whole = |radix: u32| u64::from_str_radix(word.get(1..)?, radix).ok().map(|value| value.to_string());
        let mut end = found.end;
        let fix = match (word.get(..1)?, word.get(1..)?) {
            ("x" | "X", _) if found.glued && number == "0" => Some(whole(16)?),
            ("b" | "B", _) if found.glued && number == "0" => Some(whole(2)?),
            ("x", "10" | "") if !self.is_declared("x") => {
                let (exponent, behind) = self.power_of_ten(found)?;
                end = behind;
                (!number.contains(['e', 'E'])).then_some(())?;
                Some(format!("{number}e{exponent}"))
            }
            _ if !found.glued => return None,
            ("_", _) if digits(&word.replace('_', "")) => Some(format!("{number}{}", word.replace('_', ""))),
            ("d" | "D", exponent) if digits(exponent) => Some(format!("{number}e{exponent}")),
            ("e" | "E", "") => None,
            _ => return None,
        };
        Some(SyntaxError::ForeignNumber { fix, span: Span::new(self.before.start, end) })
    }

    /// The exponent of `x10^23` and `x 10^-3`, and where it ends.
    fn power_of_ten(&self, x: Token) -> Option<(String, u32)> {
        let mut rest = Lexer::new(self.source, Span::new(x.end, self.end));
        if self.text(x) == "x" && self.text(rest.next()?) != "10" || rest.next()?.kind != TokenKind::Caret {
            return None;
        }
        let first = rest.next()?;
        let last = if first.kind == TokenKind::Minus { rest.next()? } else { first };
        let sign = if first == last { "" } else { "-" };
        digits(self.text(last)).then(|| (format!("{sign}{}", self.text(last)), last.end))
    }
}

fn digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

/// `m/s^2` for `(m/s^2)` and `[m/s^2]`.
fn without_brackets(text: String) -> String {
    let inside = text.strip_prefix(['(', '[']).and_then(|rest| rest.strip_suffix([')', ']']));
    match inside.filter(|rest| !rest.contains([')', ']'])) {
        Some(inside) => inside.to_owned(),
        None => text,
    }
}
