//! What a person probably means who writes what is not declared: as the blackboard, a paper or another language has it.
//!
//! Only mistakes are examined here; a right model never comes this way.

use super::compile::{Compiler, Scope};
use super::names::{Entity, Family, key};
use super::{MissingCoordinate, ModelError};
use crate::diagnostic::{Meant, factors_in};
use crate::order::Order;
use crate::span::Span;
use crate::syntax::{
    ExprKind, ExprRef, FUNCTIONS, GREEK, IndexKind, Member, Name, function_meant, is_derivative, latin, print_expr,
};

/// What stands for the time derivative of a coordinate, whose name is the `*`.
const DOTS: [&str; 13] =
    ["*_dot", "*dot", "*Dot", "d*_dt", "*_prime", "*_d", "*_t", "*_p", "*p", "dot_*", "d_*", "d*", "D*"];

/// Longer products are not written out.
const LONGEST_SHOWN: usize = 60;

/// The first functions, which take a number.
const OF_A_NUMBER: usize = 14;

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

/// Whether two names differ by case and by how letters are spelt alone.
fn is_same(one: &str, other: &str) -> bool {
    spelling(one).to_lowercase() == spelling(other).to_lowercase()
}

/// Whether two names are Greek letters, maybe with numbers behind them: `psi1` is no slip of the pen for `phi1`.
fn are_greek(one: &str, other: &str) -> bool {
    [one, other].iter().all(|name| {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_');
        GREEK.iter().any(|(letter, _, _)| *letter == stem)
    })
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
        known.retain(|own| !own.is_empty());
        known.put_in_order();
        let written: Vec<String> = indices.iter().map(|index| print_expr(self.file, *index)).collect();
        let behind = if written.is_empty() { String::new() } else { format!("[{}]", written.join(", ")) };
        let same = |name: &str| {
            let spelt = spelling(name);
            let own = known.iter().find(|own| spelling(own) == spelt);
            own.map(|own| format!("{own}{behind}")).or_else(|| self.member(name, indices))
        };
        let dotted = match name {
            "ẋ" => "x_dot",
            "ẏ" => "y_dot",
            "ż" => "z_dot",
            other => other,
        };
        let velocity = || {
            DOTS.iter().find_map(|dots| {
                let (before, behind) = dots.split_once('*')?;
                let moving = same(dotted.strip_prefix(before)?.strip_suffix(behind)?)?;
                let stem = moving.split('[').next().unwrap_or(&moving);
                // `dx`, `x_d` and `x_prime` may be a distance, what is desired, or in another frame.
                let is_certain = ["dot", "Dot", "_dt"].iter().any(|own| dots.contains(own));
                self.is_moving(stem).then(|| Meant { text: format!("{moving}'"), is_certain })
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
            let is_certain = near.is_certain && !are_greek(name, &near.text);
            Some(Meant { text: format!("{}{behind}", near.text), is_certain })
        };
        let alike = || known.iter().find(|own| is_same(own, name)).map(|own| Meant::guess(format!("{own}{behind}")));
        same(name)
            .or_else(|| self.member_by_index(name, indices, scope))
            .or_else(|| matches!(name, "π" | "Pi" | "PI").then(|| "pi".to_owned()))
            .map(Meant::certain)
            .or_else(velocity)
            .or_else(|| single().map(Meant::certain))
            .or_else(alike)
            .or_else(|| self.called(name).filter(|_| indices.is_empty()).map(Meant::guess))
            .or_else(|| self.index_of_none(name, scope).filter(|_| indices.is_empty()).map(Meant::guess))
            .or_else(|| self.product(name).filter(|_| indices.is_empty()).map(Meant::guess))
            .or_else(near)
    }

    /// What to do where a name is declared that looks like this one and has a letter of another script.
    pub(super) fn twin(&self, name: &str) -> Option<Box<(&'static str, String)>> {
        let looks = |text: &str| text.chars().map(|own| latin(own).unwrap_or(own)).collect::<String>();
        let own = self.world.names.keys().filter(|own| *own != name && looks(own) == looks(name)).min()?;
        let (there, here) = own.chars().zip(name.chars()).find(|(there, here)| there != here)?;
        let [there, here] = [there, here].map(|letter| format!("`{letter}` (U+{:04X})", u32::from(letter)));
        let help = format!(
            "`{own}` is declared, which looks the same but has {there} for {here}: write one letter in both places"
        );
        Some(Box::new(("unknown name", help)))
    }

    /// `x_i` for `x[i]` where `i` is an index.
    fn member_by_index(&self, name: &str, indices: &[ExprRef], scope: &Scope) -> Option<String> {
        let (head, index) = name.rsplit_once('_').filter(|_| indices.is_empty())?;
        let is_family = self.entity(head).and_then(|own| self.rank(own)) == Some(1);
        (is_family && scope.find(index).is_some()).then(|| format!("{head}[{index}]"))
    }

    /// `x[i]` for `x_i` where `i` is an index and nothing is called `x`.
    fn index_of_none(&self, name: &str, scope: &Scope) -> Option<String> {
        let (head, index) = name.rsplit_once('_')?;
        let is_free = !head.is_empty() && self.entity(head).is_none() && scope.find(head).is_none();
        (is_free && scope.find(index).is_some()).then(|| format!("{head}[{index}]"))
    }

    /// `cos(phi)` for `cosphi`.
    fn called(&self, name: &str) -> Option<String> {
        FUNCTIONS.into_iter().take(OF_A_NUMBER).find_map(|function| {
            let argument = name.strip_prefix(function)?;
            self.entity(argument).and_then(|own| self.rank(own)).filter(|rank| *rank == 0)?;
            Some(format!("{function}({argument})"))
        })
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
        let is_number = |own: &str| self.entity(own).is_some_and(|own| self.rank(own) == Some(0));
        Some(format!("({})", factors_in(name, &is_number)?.join("*")))
    }

    /// `m*g*l*(1 - cos(phi))` for `mgl(1 - cos(phi))`.
    pub(super) fn product_called(&self, name: &str, arguments: &[ExprRef]) -> Option<String> {
        let [only] = arguments else { return None };
        let product = self.product(name)?;
        Some(format!("{}*({})", product.trim_matches(['(', ')']), print_expr(self.file, *only)))
    }

    /// `x[1]` for `x(1)`, where `x` is a family and numbers and indices alone are in the parentheses.
    pub(super) fn member_called(&self, name: &str, arguments: &[ExprRef], scope: &Scope) -> Option<String> {
        let rank = self.rank(self.entity(name)?)?;
        let mut parts = arguments.to_vec();
        while let Some(at) = parts.pop() {
            match self.file.expr(at).kind {
                ExprKind::Number(_) => {}
                ExprKind::Name(own) if scope.find(own).is_some() => {}
                ExprKind::Sum(_) | ExprKind::Negate(_) => self.file.children(at, &mut parts),
                _ => return None,
            }
        }
        let written: Vec<String> = arguments.iter().map(|own| print_expr(self.file, *own)).collect();
        (rank > 0 && rank == arguments.len()).then(|| format!("{name}[{}]", written.join(", ")))
    }

    /// `k*(x - l)` for `k(x - l)`, where `k` is a parameter; `k(x)` may be meant to depend on `x`, and `1/k(x - l)` to divide by all of it.
    pub(super) fn multiplied(&self, name: &str, arguments: &[ExprRef], call: Span) -> Option<String> {
        let [only] = arguments else { return None };
        let Some(Entity::Parameter(family)) = self.entity(name) else { return None };
        let is_single = self.world.parameter_families.get(family).is_some_and(|own| own.grid.rank == 0);
        let is_sum =
            matches!(self.file.expr(*only).kind, ExprKind::Sum(_) | ExprKind::Product(_) | ExprKind::Power { .. });
        let begins = |own: ExprRef| self.file.expr(own).span.start == call.start;
        let is_bound = self.file.expressions.iter().any(|own| match own.kind {
            ExprKind::Product(factors) => factors.iter().any(|own| own.inverted() && begins(own.value())),
            ExprKind::Power { exponent, .. } => begins(exponent),
            _ => false,
        });
        let text = format!("{name}*({})", print_expr(self.file, *only));
        (is_single && is_sum && !is_bound && text.len() <= LONGEST_SHOWN).then_some(text)
    }

    /// An operand that a prime may follow.
    fn primed(&self, at: ExprRef) -> String {
        let text = print_expr(self.file, at);
        match self.file.expr(at).kind {
            ExprKind::Name(_) | ExprKind::Index { .. } | ExprKind::Prime(_) => format!("{text}'"),
            _ => format!("({text})'"),
        }
    }

    fn is_moving(&self, name: &str) -> bool {
        matches!(self.entity(name), Some(Entity::Coordinate(_)))
    }

    fn is_time(&self, at: ExprRef) -> bool {
        matches!(&self.file.expr(at).kind, ExprKind::Name(name) if *name == "t")
    }

    /// Whether a coordinate or one of its members stands there.
    fn is_coordinate(&self, at: ExprRef) -> bool {
        let head = self.flatten_index(at).0;
        matches!(&self.file.expr(head).kind, ExprKind::Name(name) if self.is_moving(name))
    }

    /// `phi'` for `dot(phi)`, `diff(phi, t)` and `D[phi, t]`.
    fn derivative_meant(&self, name: &str, arguments: &[ExprRef]) -> Option<String> {
        let (of, rest) = arguments.split_first()?;
        let by_time = rest.is_empty() || matches!(rest, [time] if self.is_time(*time));
        let is_meant = is_derivative(name) && self.entity(name).is_none() && self.is_coordinate(*of) && by_time;
        is_meant.then(|| self.primed(*of))
    }

    /// `dphi/dt`, `d(phi)/dt`, `d/dt(phi)`: two factors of a product, and what is meant by them.
    pub(super) fn foreign_quotient(&self, factors: &[Member]) -> Option<(usize, ModelError)> {
        let free = |name: &str| self.entity(name).is_none();
        factors.windows(2).enumerate().find_map(|(at, two)| {
            let [above, below] = two else { return None };
            if above.inverted() || !below.inverted() {
                return None;
            }
            let [over, under] = [above, below].map(|own| self.file.expr(own.value()));
            let span = over.span.to(under.span);
            if let ExprKind::Name(name) = over.kind
                && free(name)
                && matches!(print_expr(self.file, below.value()).as_str(), "dt^2" | "dt2" if free("dt") && free("dt2"))
            {
                let acceleration = name.strip_prefix("d2").filter(|own| self.is_moving(own));
                let of = acceleration.or_else(|| name.strip_prefix('d').filter(|own| self.is_moving(own)))?;
                let square = if acceleration.is_none() {
                    format!("the square of the velocity is `{of}'^2`, ")
                } else {
                    String::new()
                };
                let mut error = ModelError::undeclared(name, None, span);
                if let ModelError::UndeclaredName { by_place, .. } = &mut error {
                    *by_place = Some(Box::new(("a time derivative", format!("{square}the acceleration is `{of}''`"))));
                }
                return Some((at, error));
            }
            let fix = match (&over.kind, &under.kind) {
                (ExprKind::Name(name), ExprKind::Name("dt")) if free("dt") && free(name) => {
                    name.strip_prefix('d').filter(|own| self.is_moving(own)).map(|of| format!("{of}'"))
                }
                (ExprKind::Call { function, arguments }, ExprKind::Name("dt")) if free("dt") => {
                    self.derivative_meant(&function.text, arguments).filter(|_| function.text.as_str() == "d")
                }
                (ExprKind::Name("d"), ExprKind::Call { function, arguments }) if free("d") => {
                    self.derivative_meant(&function.text, arguments).filter(|_| function.text.as_str() == "dt")
                }
                _ => None,
            }?;
            Some((at, ModelError::ForeignDerivative { fix, span }))
        })
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
        if let Some(fix) = self.derivative_meant(name, indices) {
            return Some(ModelError::ForeignDerivative { fix, span: expr.span });
        }
        let mut function = function_meant(&name.to_lowercase())?;
        let mut arguments: Vec<String> = indices.iter().map(|own| print_expr(self.file, *own)).collect();
        // Who has brackets for functions has x before y.
        if function == "atan" && arguments.len() == 2 {
            function = "atan2";
            arguments.reverse();
        }
        let fix = format!("{function}({})", arguments.join(", "));
        Some(ModelError::BracketedFunction { function, fix, span: expr.span })
    }

    /// `e^x`, where `e` is not declared, and `exp^(x)`.
    pub(super) fn foreign_power(&self, at: ExprRef, scope: &Scope) -> Option<ModelError> {
        let expr = self.file.expr(at);
        let ExprKind::Power { base, exponent } = expr.kind else { return None };
        let (named, prime) = match self.file.expr(base).kind {
            ExprKind::Prime(inner) => (inner, "'"),
            _ => (base, ""),
        };
        let ExprKind::Name(name) = &self.file.expr(named).kind else { return None };
        let free = self.entity(name).is_none() && scope.find(name).is_none() && scope.integrated(name).is_none();
        // `kx^2` for `k*x^2`
        if let Some(product) = self.product(name).filter(|_| free && self.declared_later(name).is_none()) {
            let written = print_expr(self.file, exponent);
            let power = match self.file.expr(exponent).kind {
                ExprKind::Number(_) | ExprKind::Name(_) => written,
                _ => format!("({written})"),
            };
            let text = format!("{}{prime}^{power}", product.trim_matches(['(', ')']));
            let is_below = |own: &Member| own.inverted() && own.value() == at;
            let below = self.file.expressions.iter().any(|own| match own.kind {
                ExprKind::Product(factors) => factors.iter().any(is_below),
                _ => false,
            });
            let text = if below { format!("({text})") } else { text };
            return Some(ModelError::undeclared(name, Some(Meant::guess(text)), expr.span));
        }
        if !prime.is_empty() {
            return None;
        }
        (matches!(&**name, "e" | "E" | "exp") && free && self.declared_later(name).is_none()).then(|| {
            let meant = Meant::certain(format!("exp({})", print_expr(self.file, exponent)));
            ModelError::undeclared(name, Some(meant), expr.span)
        })
    }

    /// `dot(phi)`, `diff(phi, t)`, `phi(t)`.
    pub(super) fn foreign_call(&self, function: &Name, arguments: &[ExprRef], span: Span) -> Option<ModelError> {
        let name = function.text.as_str();
        match arguments {
            [time] if self.is_time(*time) && self.entity(name).is_some() => {
                Some(ModelError::TimeArgument { span: Span::new(function.span.end, span.end) })
            }
            _ => {
                let fix = self.derivative_meant(name, arguments)?;
                Some(ModelError::ForeignDerivative { fix, span })
            }
        }
    }

    /// `phi.dot`, `np.pi`.
    pub(super) fn foreign_field(&self, base: ExprRef, field: &Name, scope: &Scope) -> Option<ModelError> {
        let span = self.file.expr(base).span.to(field.span);
        if is_derivative(&field.text) && self.is_coordinate(base) {
            return Some(ModelError::ForeignDerivative { fix: self.primed(base), span });
        }
        let ExprKind::Name(name) = &self.file.expr(base).kind else { return None };
        let free = self.entity(name).is_none() && scope.find(name).is_none();
        (free && field.text.as_str() == "pi")
            .then(|| ModelError::undeclared(name, Some(Meant::certain("pi".to_owned())), span))
    }

    /// The place of an integral over a variable of that name.
    pub(super) fn integral_over(&self, name: &str) -> Option<Span> {
        self.file.expressions.iter().find_map(|own| {
            let ExprKind::IntegralOver { indices, .. } = own.kind else { return None };
            let binds =
                |kind: &IndexKind| matches!(kind, IndexKind::Range { variable: Some(own), .. } if *own.text == *name);
            indices.entries.iter().any(|entry| binds(&entry.kind)).then_some(own.span)
        })
    }

    /// The declaration of a coordinate that is missing, and where it belongs: before the statement at a place that uses it, if
    /// its time derivative is used somewhere in the file.
    pub(super) fn missing_coordinate(&self, name: &str, span: Span, scope: &Scope) -> Option<Box<MissingCoordinate>> {
        // `x_j` and `x4` may be members that `x` does not have.
        let stem = name.split('_').next().unwrap_or(name).trim_end_matches(|c: char| c.is_ascii_digit());
        let is_member = name.rsplit_once('_').is_some_and(|(_, index)| scope.find(index).is_some());
        if is_member || stem != name && self.entity(stem).is_some() {
            return None;
        }
        // `ltheta'` for `l*theta'`, `cosphi'`
        let moves = |own: &str| self.is_moving(own) || matches!(self.entity(own), Some(Entity::Let(_)));
        let factors = factors_in(name, &|own| self.entity(own).is_some()).unwrap_or_default();
        if factors.into_iter().any(moves) || self.called(name).is_some() {
            return None;
        }
        // Nor is a slip of the pen declared: `h'` beside `th`; but `psi` is none for `phi`, nor `y1` for `x1`.
        let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
        let letters = |text: &str| text.chars().count() - digits(text).len();
        let is_slip = |own: &str| {
            let are_alike = digits(own) == digits(name) && strsim::osa_distance(own, name) == 1;
            are_alike && letters(own).max(letters(name)) > 1 && !are_greek(own, name)
        };
        if self.world.names.keys().any(|own| is_slip(own)) {
            return None;
        }
        let mut moving = self.file.expressions.iter().filter_map(|expr| {
            let ExprKind::Prime(inner) = expr.kind else { return None };
            let (head, indices) = self.flatten_index(inner);
            matches!(&self.file.expr(head).kind, ExprKind::Name(own) if *own == name).then_some((expr.span, indices))
        });
        let ranges = moving.find_map(|(place, indices)| {
            indices.iter().map(|own| self.range_over(*own, place)).collect::<Option<Vec<String>>>()
        })?;
        // `Theta'` beside `theta`, `x'` beside `x1`
        let stem = |own: &str| own.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_').len();
        let is_one = |own: &str| stem(own) < own.len() && is_same(&own[..stem(own)], name) && self.is_moving(own);
        let has_rank = |own: &str| self.entity(own).and_then(|own| self.rank(own)) == Some(ranges.len());
        let is_other = |own: &str| moves(own) && has_rank(own) && (is_same(own, name) || is_one(own));
        if self.world.names.keys().any(|own| is_other(own)) {
            return None;
        }
        let indices = if ranges.is_empty() { String::new() } else { format!("[{}]", ranges.join(", ")) };
        let mut statements = self.file.statements.iter();
        let statement = statements.find(|own| own.span.start <= span.start && span.end <= own.span.end)?;
        // `x_1, x_2, x_3` for the members of `x`
        let mut members: Vec<String> = self.world.names.keys().filter(|own| is_one(own)).cloned().collect();
        members.put_in_order();
        let declaration = format!("coord {name}{indices}");
        Some(Box::new(MissingCoordinate { declaration, place: statement.span.start, members }))
    }

    /// The range of the sum around a place that an index runs over, if names of the model alone are in it.
    fn range_over(&self, index: ExprRef, place: Span) -> Option<String> {
        let ExprKind::Name(index) = &self.file.expr(index).kind else { return None };
        let sums =
            self.file.expressions.iter().filter(|own| own.span.start <= place.start && place.end <= own.span.end);
        let mut ranges = sums.filter_map(|own| match &own.kind {
            ExprKind::SumOver { indices, .. } => Some(indices.entries.iter()),
            _ => None,
        });
        ranges.find_map(|entries| {
            entries.clone().find_map(|entry| match &entry.kind {
                IndexKind::Range { variable: Some(own), from, to } if *own.text == **index => {
                    let [from, to] = [from, to].map(|end| print_expr(self.file, *end));
                    let text = format!("{from}..{to}");
                    let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
                    let mut names = words.filter(|own| own.starts_with(char::is_alphabetic));
                    names.all(|own| self.entity(own).is_some()).then_some(text)
                }
                _ => None,
            })
        })
    }
}
