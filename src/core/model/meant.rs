//! What a person probably means who writes what is not declared: as the blackboard, a paper or another language has it.
//!
//! Only mistakes are looked at here; a right model never comes this way.

use super::ModelError;
use super::compile::{Compiler, Scope};
use super::names::{Entity, Family, key};
use crate::diagnostic::Meant;
use crate::order::Order;
use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, GREEK, Name, function_meant, print_expr};

/// What is written before or behind the name of a coordinate for its time derivative.
const DOTS: [(&str, &str); 8] =
    [("", "_dot"), ("", "dot"), ("", "_prime"), ("", "_d"), ("dot_", ""), ("d_", ""), ("d", ""), ("D", "")];

/// Functions and fields of other languages that are the time derivative.
const DERIVATIVES: [&str; 10] = ["dot", "diff", "D", "d", "dt", "Dt", "ddt", "der", "deriv", "derivative"];

/// Longer names are not taken for products.
const LONGEST_PRODUCT: usize = 6;

/// How a name reads aloud: Greek letters by name, underscores left out.
fn spelling(name: &str) -> String {
    let mut out = String::new();
    for letter in name.chars().filter(|c| *c != '_') {
        let letter = match letter {
            'ϕ' => 'φ',
            'ϑ' => 'θ',
            'ϵ' => 'ε',
            'ϱ' => 'ρ',
            '\u{b5}' => 'μ',
            other => other,
        };
        let mut buffer = [0; 4];
        let text: &str = letter.encode_utf8(&mut buffer);
        out.push_str(GREEK.iter().find(|(_, _, own)| *own == text).map_or(text, |(own, _, _)| own));
    }
    out
}

impl Compiler<'_> {
    /// What `name` with these indices behind it was probably meant to be, as text for the whole.
    pub(super) fn meant(&self, name: &str, indices: &[ExprRef], scope: &Scope) -> Option<Meant> {
        let fits = |entity: Entity| match self.rank(entity) {
            Some(rank) if matches!(entity, Entity::Let(_)) => rank <= indices.len(),
            rank => rank == Some(indices.len()),
        };
        let declared = self.world.names.iter().filter(|(_, (entity, _))| fits(*entity));
        let mut known: Vec<&str> = declared.map(|(name, _)| name.as_str()).collect();
        if indices.is_empty() {
            known.extend(scope.variables.iter().map(|(name, _)| name.as_str()));
            known.extend(scope.integrated.iter().map(|(name, _)| name.as_str()));
        }
        known.put_in_order();
        let written: Vec<String> = indices.iter().map(|index| print_expr(self.file, *index)).collect();
        let behind = if written.is_empty() { String::new() } else { format!("[{}]", written.join(", ")) };
        let same = |name: &str| {
            let spelt = spelling(name);
            let own = known.iter().find(|own| !own.is_empty() && spelling(own) == spelt);
            own.map(|own| format!("{own}{behind}")).or_else(|| self.member(name, indices))
        };
        let dotted = match name {
            "ẋ" => "x_dot",
            "ẏ" => "y_dot",
            "ż" => "z_dot",
            other => other,
        };
        let velocity = || {
            DOTS.iter().find_map(|(before, behind)| {
                let moving = same(dotted.strip_prefix(before)?.strip_suffix(behind)?)?;
                let stem = moving.split('[').next().unwrap_or(&moving);
                // `dx`, `x_d` and `x_prime` may be a distance, what is desired, or in another frame.
                let is_certain = before.contains("dot") || behind.contains("dot");
                let is_moving = matches!(self.entity(stem), Some(Entity::Coordinate(_)));
                is_moving.then(|| Meant { text: format!("{moving}'"), is_certain })
            })
        };
        let single = || {
            let digits = indices.iter().all(|index| matches!(self.file.expr(*index).kind, ExprKind::Number(_)));
            let spelt = spelling(&format!("{name}{}", written.concat()));
            let mut names = self.world.names.iter().filter(|(_, (own, _))| self.rank(*own) == Some(0));
            names.find(|(own, _)| digits && !indices.is_empty() && spelling(own) == spelt).map(|(own, _)| own.clone())
        };
        let near = || {
            let near = Meant::near(name, known.iter().copied())?;
            Some(Meant { text: format!("{}{behind}", near.text), ..near })
        };
        same(name)
            .or_else(|| self.member_by_index(name, indices, scope))
            .or_else(|| matches!(name, "π" | "Pi" | "PI").then(|| "pi".to_owned()))
            .map(Meant::certain)
            .or_else(velocity)
            .or_else(|| single().map(Meant::certain))
            .or_else(|| self.product(name).filter(|_| indices.is_empty()).map(Meant::guess))
            .or_else(near)
    }

    /// `x_i` for `x[i]` where `i` is an index.
    fn member_by_index(&self, name: &str, indices: &[ExprRef], scope: &Scope) -> Option<String> {
        let (head, index) = name.rsplit_once('_').filter(|_| indices.is_empty())?;
        let is_family = self.entity(head).and_then(|own| self.rank(own)) == Some(1);
        (is_family && scope.find(index).is_some()).then(|| format!("{head}[{index}]"))
    }

    fn rank(&self, entity: Entity) -> Option<usize> {
        self.world.family(entity).map(|family| family.grid.rank)
    }

    /// `m_1` and `m1` for `m[1]`, `k12` for `k[1, 2]`.
    fn member(&self, name: &str, indices: &[ExprRef]) -> Option<String> {
        let head = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let digits = name.strip_prefix(head).filter(|digits| !digits.is_empty() && indices.is_empty())?;
        let spelt = spelling(head);
        let holds = |family: &&Family, at: &[i64]| family.grid.rank == at.len() && family.grid.find(&key(at)).is_some();
        let families = || {
            let named = self.world.names.iter().filter(|(own, _)| spelling(own) == spelt);
            named.filter_map(|(_, (entity, _))| self.world.family(*entity))
        };
        let whole = digits.parse().ok().map(|number| vec![number]);
        let apart: Vec<i64> = digits.bytes().map(|digit| i64::from(digit - b'0')).collect();
        whole.into_iter().chain([apart]).find_map(|at| {
            let family = families().find(|family| holds(family, &at))?;
            let at: Vec<String> = at.iter().map(ToString::to_string).collect();
            Some(format!("{}[{}]", family.name, at.join(", ")))
        })
    }

    /// `mgl` for `(m*g*l)`: all of it different names of single numbers.
    fn product(&self, name: &str) -> Option<String> {
        let mut factors: Vec<&str> = Vec::new();
        let mut rest = name;
        while !rest.is_empty() && name.len() <= LONGEST_PRODUCT {
            let ends = rest.char_indices().map(|(at, c)| at + c.len_utf8()).rev();
            let mut pieces = ends.filter_map(|end| rest.get(..end));
            let factor = pieces.find(|own| self.entity(own).is_some_and(|own| self.rank(own) == Some(0)))?;
            if factors.contains(&factor) {
                return None;
            }
            factors.push(factor);
            rest = rest.get(factor.len()..)?;
        }
        (factors.len() > 1).then(|| format!("({})", factors.join("*")))
    }

    /// An operand that a prime may follow.
    fn primed(&self, at: ExprRef) -> String {
        let text = print_expr(self.file, at);
        match self.file.expr(at).kind {
            ExprKind::Name(_) | ExprKind::Index { .. } | ExprKind::Prime(_) => format!("{text}'"),
            _ => format!("({text})'"),
        }
    }

    fn is_time(&self, at: ExprRef) -> bool {
        matches!(&self.file.expr(at).kind, ExprKind::Name(name) if *name == "t")
    }

    /// Whether a coordinate or one of its members stands there.
    fn is_coordinate(&self, at: ExprRef) -> bool {
        let head = self.flatten_index(at).0;
        matches!(&self.file.expr(head).kind, ExprKind::Name(name)
            if matches!(self.entity(name), Some(Entity::Coordinate(_))))
    }

    /// `phi[t]`, and `Cos[phi]`.
    pub(super) fn foreign_index(&self, at: ExprRef, scope: &Scope) -> Option<ModelError> {
        let expr = self.file.expr(at);
        let ExprKind::Index { base, indices } = &expr.kind else { return None };
        let head = self.file.expr(*base);
        if let [only] = **indices
            && self.is_time(only)
        {
            return Some(ModelError::TimeArgument { span: Span::new(head.span.end, expr.span.end) });
        }
        let ExprKind::Name(name) = &head.kind else { return None };
        if self.entity(name).is_some() || scope.find(name).is_some() {
            return None;
        }
        let function = function_meant(&name.to_lowercase())?;
        let arguments: Vec<String> = indices.iter().map(|own| print_expr(self.file, *own)).collect();
        let fix = format!("{function}({})", arguments.join(", "));
        Some(ModelError::BracketedFunction { function, fix, span: expr.span })
    }

    /// `e^x`, where `e` is not declared.
    pub(super) fn foreign_power(&self, at: ExprRef, scope: &Scope) -> Option<ModelError> {
        let expr = self.file.expr(at);
        let ExprKind::Power { base, exponent } = expr.kind else { return None };
        let ExprKind::Name(name) = &self.file.expr(base).kind else { return None };
        let free = self.entity(name).is_none() && scope.find(name).is_none() && scope.integrated(name).is_none();
        (matches!(&**name, "e" | "E") && free && !self.later.contains_key(&**name)).then(|| {
            ModelError::undeclared(
                name,
                Some(Meant::certain(format!("exp({})", print_expr(self.file, exponent)))),
                expr.span,
            )
        })
    }

    /// `dot(phi)`, `diff(phi, t)`, `phi(t)`.
    pub(super) fn foreign_call(&self, function: &Name, arguments: &[ExprRef], span: Span) -> Option<ModelError> {
        let name = function.text.as_str();
        match arguments {
            [time] if self.is_time(*time) && self.entity(name).is_some() => {
                Some(ModelError::TimeArgument { span: Span::new(function.span.end, span.end) })
            }
            [of, rest @ ..]
                if DERIVATIVES.contains(&name)
                    && self.is_coordinate(*of)
                    && self.entity(name).is_none()
                    && (rest.is_empty() || matches!(rest, [time] if self.is_time(*time))) =>
            {
                Some(ModelError::ForeignDerivative { fix: self.primed(*of), span })
            }
            _ => None,
        }
    }

    /// `phi.dot`, `np.pi`.
    pub(super) fn foreign_field(&self, base: ExprRef, field: &Name, scope: &Scope) -> Option<ModelError> {
        let span = self.file.expr(base).span.to(field.span);
        if DERIVATIVES.contains(&field.text.as_str()) && self.is_coordinate(base) {
            return Some(ModelError::ForeignDerivative { fix: self.primed(base), span });
        }
        let ExprKind::Name(name) = &self.file.expr(base).kind else { return None };
        let free = self.entity(name).is_none() && scope.find(name).is_none();
        (free && field.text.as_str() == "pi")
            .then(|| ModelError::undeclared(name, Some(Meant::certain("pi".to_owned())), span))
    }

    /// Where a coordinate that is missing has to be declared: before the statement at a place that uses it, if its time
    /// derivative is used somewhere in the file.
    pub(super) fn missing_coordinate(&self, name: &str, span: Span) -> Option<u32> {
        // `x_j` and `x4` may be members that `x` does not have.
        let stem = name.split('_').next().unwrap_or(name).trim_end_matches(|c: char| c.is_ascii_digit());
        if stem != name && self.entity(stem).is_some() {
            return None;
        }
        // Nor is a slip of the pen declared: `h'` beside `th`.
        let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
        let is_slip = |own: &str| {
            own.len().max(name.len()) > 1 && digits(own) == digits(name) && strsim::osa_distance(own, name) == 1
        };
        if self.world.names.keys().any(|own| is_slip(own)) {
            return None;
        }
        let moves = self.file.expressions.iter().any(|expr| {
            matches!(expr.kind, ExprKind::Prime(inner)
                if matches!(&self.file.expr(inner).kind, ExprKind::Name(own) if *own == name))
        });
        let mut statements = self.file.statements.iter().filter(|_| moves);
        statements.find(|own| own.span.start <= span.start && span.end <= own.span.end).map(|own| own.span.start)
    }
}
