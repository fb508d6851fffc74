//! What is legal in a model, but suspicious.

use std::collections::BTreeSet;

use hashbrown::{HashMap, HashSet};

use super::survey::{mentions, structural_names};
use super::{Local, Model, TermFamily, units};
use crate::diagnostic::{Diagnostic, at};
use crate::expr::{Pool, Symbol};
use crate::mistakes;
use crate::number::Number;
use crate::order::{Gather, Order};
use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, File, Indices, Name, StatementKind, UnitRef, print_unit};

mistakes! {
/// Something suspicious that is no mistake.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
Warning Warning {
    /// A parameter that nothing uses.
    #[error("the parameter `{name}` is never used")]
    "W0001" UnusedParameter(span) {
        /// The parameter.
        name: String,
    } => at(*span, "declared here")
        .with_help(format!("is a term missing? If not, remove the line or call it `_{name}`"))
        .proposing(*span, format!("_{name}")),

    /// A named expression that nothing uses.
    #[error("`{name}` is never used")]
    "W0002" UnusedExpression(span) {
        /// Its name.
        name: String,
    } => at(*span, "given here").with_help(format!("is a term missing? If not, remove the line or call it `_{name}`")),

    /// A table that nothing uses.
    #[error("the table `{name}` is never used")]
    "W0003" UnusedTable(span) {
        /// The table.
        name: String,
    } => at(*span, "read here"),

    /// A coordinate in no energy.
    #[error("the coordinate `{name}` is never used")]
    "W0004" UnusedCoordinate(span) {
        /// The coordinate or family.
        name: String,
    } => at(*span, "declared here").with_help("a coordinate needs a kinetic energy"),

    /// A coordinate that the energies depend on through its velocity only.
    #[error("no restoring force acts on `{name}`")]
    "W0005" NoRestoringForce(span) {
        /// The coordinate or family.
        name: String,
    } => at(*span, "it occurs at most with its velocity").with_help(
        "it moves freely and has a mode of frequency zero; is a term of V missing?",
    ),

    /// A whole number written with a decimal point where only whole numbers will do.
    #[error("`{text}` is the end of a range, but is written like a measured value")]
    "W0006" DecimalRange(span) {
        /// As written.
        text: String,
    } => at(*span, "a count").with_help(format!("write `{}`", text.split('.').next().unwrap_or(text))),

    /// A period of a model in which nothing depends on the time.
    #[error("a period is given, but nothing depends on the time")]
    "W0008" PeriodWithoutTime(span) => at(*span, "has no effect here").with_help(
        "remove it, or let an energy depend on the time `t`: `cos(W*t)`; a natural period is computed, not given",
    ),

    /// A rate without a unit of its own, beside names with another unit for such a rate.
    #[error("the number for `{name}'` is read in {unit}, but `{other}` is in {other_unit}")]
    "W0010" RateUnit(span) {
        /// The coordinate.
        name: String,
        /// The statement word.
        word: &'static str,
        /// The unit of the coordinate per second.
        unit: String,
        /// What is declared with the other unit.
        other: String,
        /// The other unit.
        other_unit: String,
        /// Where that stands.
        other_span: Span,
    } => at(*span, "without a unit it is in the unit of the coordinate per second")
        .with_secondary(*other_span, "another unit for the same kind of quantity")
        .with_help(format!("write the intended unit: `{word} {name}' : {unit} = …` or `{word} {name}' : {other_unit} = …`")),

    /// A kinetic energy that depends on a coordinate, but not on its velocity, or on no velocity at all.
    #[error("T depends on {}", match .name {
        Some(name) => format!("`{name}`, but not on `{name}'`"),
        None => "no velocity".to_owned(),
    })]
    "W0012" WithoutVelocity(span) {
        /// The coordinate or family.
        name: Option<String>,
    } => at(*span, "no inertia").with_help(match name {
        Some(name) => format!("is a prime missing: `{name}'`?"),
        None => "a kinetic energy depends on velocities, such as `1/2*m*x'^2`".to_owned(),
    }),

    /// `coord x, y : mm`, where x is in m.
    #[error("the unit `{unit}` is that of `{other}` alone")]
    "W0013" UnitOfOther(span) {
        /// The coordinate or family without a unit.
        name: String,
        /// The one with the unit.
        other: String,
        /// The unit.
        unit: String,
    } => at(*span, "without a unit it is in SI").with_help(format!("write `{name} : {unit}, {other} : {unit}`")),
}
}

impl Model {
    /// Everything suspicious in the file that the model came of and in the model, in the order of the file.
    ///
    /// Names that begin with `_` are unused on purpose.
    ///
    /// ```
    /// use librate::{model, syntax};
    /// let file = syntax::parse("param k = 2  coord x  T = 1/2*x'^2  V = x^2")?;
    /// let checked = model::elaborate(&file, &Default::default(), &Default::default()).unwrap();
    /// assert_eq!(checked.warnings(&file)[0].message, "the parameter `k` is never used");
    /// # Ok::<(), Vec<librate::syntax::SyntaxError>>(())
    /// ```
    #[must_use]
    pub fn warnings(&self, file: &File) -> Vec<Diagnostic> {
        let mut found = unused_names(file);
        found.extend(decimal_ranges(file));
        let period = self.period.filter(|_| self.time_dependent.is_none());
        found.extend(period.map(|period| Warning::PeriodWithoutTime { span: period.span }));
        found.extend(inertia_without_velocity(file, self));
        found.extend(rates_beside_other_units(file, self));
        found.extend(units_of_others(file, self));
        let unused = found.iter().filter_map(|warning| match warning {
            Warning::UnusedCoordinate { name, .. } => Some(name.clone()),
            _ => None,
        });
        let unused: HashSet<String> = unused.collect();
        let is_told = |own: &Warning| matches!(own, Warning::NoRestoringForce { name, .. } if unused.contains(name));
        found.extend(free_coordinates(self).into_iter().filter(|warning| !is_told(warning)));
        let mut found: Vec<Diagnostic> = found.iter().map(Diagnostic::from).collect();
        found.order_by_key(|warning| warning.primary.as_ref().map(|label| label.span));
        found
    }
}

/// Coordinates without a unit before one of the same kind whose unit is not the one in SI.
fn units_of_others(file: &File, model: &Model) -> Vec<Warning> {
    let first = |name: &str| {
        let family = model.families.iter().find(|family| family.name == name && !family.is_empty());
        family.map(|family| model.coordinates.at(family.first))
    };
    let mut found = Vec::new();
    for statement in &file.statements {
        let declarations = statement.kind.coordinates();
        for (at, own) in declarations.iter().enumerate().filter(|(_, own)| own.unit.is_none()) {
            let Some((other, unit)) = declarations[at..].iter().find_map(|other| Some((other, other.unit?))) else {
                continue;
            };
            let (name, next) = (own.name.text.as_str(), other.name.text.as_str());
            let (Some(here), Some(there)) = (first(name), first(next)) else { continue };
            if here.unit == there.unit && there.factor.is_some() {
                let (name, other, unit) = (name.to_owned(), next.to_owned(), print_unit(file, unit));
                found.push(Warning::UnitOfOther { name, other, unit, span: own.name.span });
            }
        }
    }
    found
}

/// Names that nothing reads; those with `_` in front are so on purpose.
fn unused_names(file: &File) -> Vec<Warning> {
    let named =
        file.expressions.iter().filter_map(|expr| if let ExprKind::Name(name) = expr.kind { Some(name) } else { None });
    let tables = file.indices().flat_map(Indices::tables);
    let used: HashSet<&str> = named.chain(tables.map(|table| table.text.as_str())).collect();
    let mut found = Vec::new();
    let mut seen: HashSet<&str> = HashSet::new();
    for statement in &file.statements {
        for name in statement.kind.declared() {
            // The members of a family may be given one by one.
            let first = seen.insert(name.text.as_str());
            if first && !name.text.starts_with('_') && !used.contains(name.text.as_str()) {
                let (name, span) = (name.text.to_string(), name.span);
                found.push(match statement.kind {
                    StatementKind::Param(_) => Warning::UnusedParameter { name, span },
                    StatementKind::Let(_) => Warning::UnusedExpression { name, span },
                    StatementKind::Table { .. } => Warning::UnusedTable { name, span },
                    _ => Warning::UnusedCoordinate { name, span },
                });
            }
        }
    }
    found
}

/// `1..3.0`, and `param N = 10.0` where N sets a range.
fn decimal_ranges(file: &File) -> Vec<Warning> {
    let decimal = |at: ExprRef| match file.expr(at).kind {
        ExprKind::Number(text) if text.contains('.') => {
            Some(Warning::DecimalRange { text: text.to_owned(), span: file.expr(at).span })
        }
        _ => None,
    };
    let mut found: Vec<Warning> = file.indices().flat_map(Indices::expressions).filter_map(decimal).collect();
    let structural = structural_names(file);
    for statement in &file.statements {
        let parameters = statement.kind.parameters().iter();
        let structural = parameters.filter(|one| structural.contains(one.name.text.as_str()));
        let values: BTreeSet<ExprRef> = structural.filter_map(|one| one.value).gather();
        found.extend(values.into_iter().filter_map(decimal));
    }
    found
}

/// The first coordinate or family that T depends on at rest, but not on its velocity, or T itself if there are no velocities in it.
fn inertia_without_velocity(file: &File, model: &Model) -> Option<Warning> {
    let kinetic = |kind: &StatementKind| if let StatementKind::Kinetic(root) = kind { Some(*root) } else { None };
    let root = file.statements.iter().find_map(|statement| kinetic(&statement.kind))?;
    let [mut placed, mut moving] = [0, 1].map(|_| vec![false; model.coordinates.len()]);
    for family in &model.kinetic {
        let all = model.pool.symbols_of(&[family.body]);
        mark(&all, family, |local| local.coordinate, &mut placed);
        mark(&all, family, |local| local.velocity, &mut moving);
    }
    if placed.iter().zip(&moving).any(|(placed, moving)| *placed && !moving) {
        // What stands beside velocities alone, as in B x y', has a meaning.
        let mut pool = model.pool.clone();
        placed.fill(false);
        for family in &model.kinetic {
            let rest = pool.substitute_one(family.body, &family.at_rest(&pool));
            mark(&pool.symbols_of(&[rest]), family, |local| local.coordinate, &mut placed);
        }
    }
    let is_still = |at: &usize| placed[*at] && !moving[*at];
    let is_zero = matches!(file.expr(root).kind, ExprKind::Number("0"));
    let name = model.families.iter().find_map(|family| {
        let still = family.range().find(is_still)?;
        let alone = family.range().any(|at| moving[at]);
        Some(if alone { model.coordinates.at(still).name() } else { family.name.clone() })
    });
    let span = file.expr(root).span;
    (name.is_some() || !is_zero && !moving.contains(&true)).then_some(Warning::WithoutVelocity { name, span })
}

/// Rates given by a number, which is in the unit of the coordinate per second, in files with another unit for such a rate.
fn rates_beside_other_units(file: &File, model: &Model) -> Vec<Warning> {
    let mut units: HashMap<&str, UnitRef> = HashMap::new();
    let mut others: Vec<(&Name, UnitRef)> = Vec::new();
    for statement in &file.statements {
        let coordinates = statement.kind.coordinates().iter();
        units.extend(coordinates.filter_map(|one| Some((one.name.text.as_str(), one.unit?))));
        others.extend(statement.kind.bindings().iter().filter_map(|one| Some((&one.name, one.unit?))));
    }
    let mut pool = Pool::default();
    let mut found = Vec::new();
    for statement in &file.statements {
        let (word, binding) = match &statement.kind {
            StatementKind::Guess { binding, rate: true } => ("guess", binding),
            StatementKind::Equilibrium { binding, rate: true } => ("equilibrium", binding),
            _ => continue,
        };
        let number = binding.value.filter(|_| binding.unit.is_none()).filter(|root| {
            let zero = matches!(file.expr(*root).kind, ExprKind::Number("0"));
            !zero && !mentions(file, *root, |name| !matches!(name, "pi"))
        });
        let name = binding.name.text.as_str();
        let family = model.families.iter().find(|family| family.name == name && !family.is_empty());
        let (Some(root), Some(family)) = (number, family) else { continue };
        let si = model.coordinates.at(family.first).unit;
        let exponents = |unit| if unit == "1" { Some([0; 7]) } else { units::exponents(unit) };
        let Some(mut wanted) = si.and_then(exponents) else { continue };
        wanted[2] -= 1;
        let wanted = wanted.map(|own| Number::from(i64::from(own)));
        let own = units.get(name).copied();
        let factor = |pool: &mut Pool, unit| units::factor(pool, file, unit, &mut Vec::new());
        let size = own.map_or(pool.one(), |unit| factor(&mut pool, unit));
        let other = others.iter().find(|(_, unit)| {
            units::dimension(file, *unit).as_ref() == Some(&wanted) && factor(&mut pool, *unit) != size
        });
        found.extend(other.map(|(other, unit)| Warning::RateUnit {
            name: name.to_owned(),
            word,
            unit: format!("{}/s", own.map_or(si.unwrap_or_default().to_owned(), |own| print_unit(file, own))),
            other: other.text.to_string(),
            other_unit: print_unit(file, *unit),
            other_span: file.unit(*unit).span,
            span: file.expr(root).span,
        }));
    }
    found
}

/// Coordinates whose position no energy depends on; a family as one where all of it is free.
fn free_coordinates(model: &Model) -> Vec<Warning> {
    let mut bound = vec![false; model.coordinates.len()];
    let energies = model.kinetic.iter().chain(&model.potential);
    for family in energies.chain(&model.forces) {
        mark(&model.pool.symbols_of(&[family.body]), family, |local| local.coordinate, &mut bound);
    }
    if !model.constraints.is_empty() || !model.rolling.is_empty() {
        // A constraint is a force as well.
        return Vec::new();
    }
    for (bound, rate) in bound.iter_mut().zip(model.rates.iter()) {
        *bound |= rate.is_some();
    }
    let mut found = Vec::new();
    for family in &model.families {
        let members = family.range();
        let free: Vec<usize> = members.filter(|at| !bound[*at]).collect();
        let is_whole = free.len() == family.len();
        found.extend(free.into_iter().take(if is_whole { 1 } else { usize::MAX }).map(|at| {
            let own = model.coordinates.at(at);
            let name = if is_whole { family.name.clone() } else { own.name() };
            Warning::NoRestoringForce { name, span: own.span }
        }));
    }
    found
}

/// Marks the coordinates that a family of terms depends on by position, or whose velocities it depends on.
fn mark(symbols: &[Symbol], family: &TermFamily, of: impl Fn(&Local) -> Symbol, marked: &mut [bool]) {
    let width = family.locals.len();
    for (slot, local) in family.locals.iter().enumerate() {
        if symbols.binary_search(&of(local)).is_ok() {
            for number in family.coordinates.iter().skip(slot).step_by(width) {
                marked.get_mut(*number as usize).into_iter().for_each(|marked| *marked = true);
            }
        }
    }
}
