//! `param` statements and the settings that replace their values.

use std::cell::OnceCell;

use hashbrown::HashMap;

use super::ModelError;
use super::compile::{Compiler, Scope};
use super::elaborate::{Elaborator, SetValue};
use super::error::{counted, counted_indices};
use super::members::{Members, reads_names};
use super::names::{Entity, Family, Grid, Key, Parameter, SymbolKind, World, key, member_name};
use super::program::Program;
use super::settings::{Settings, of_value};
use super::values::Value;
use crate::diagnostic::nearest;
use crate::expr::{ExprId, Substitution, evaluate_closed};
use crate::span::Span;
use crate::syntax::{Binding, ExprRef, Name, print_expr, print_indices};

/// Longer right sides are not quoted in help.
const LONGEST_QUOTED: usize = 60;

/// What a parameter takes: a symbol, its name, its values.
const BYTES_EACH: usize = 300;

impl Elaborator<'_> {
    pub(super) fn read_settings(&mut self, settings: &Settings) {
        for setting in &settings.entries {
            let mut errors = Vec::new();
            let later = OnceCell::from(HashMap::new());
            let mut compiler = Compiler::new(&setting.file, &mut self.world, &later, &mut errors);
            let mut at = Vec::new();
            if let Some(indices) = &setting.binding.indices {
                let (binders, _) = compiler.binders(indices, &mut Scope::default());
                for binder in &binders {
                    match compiler.world.binder_range(binder, &[]) {
                        Ok((from, to)) if from == to => at.push(from),
                        Ok(_) | Err(_) => compiler.errors.push(ModelError::BadSetting {
                            text: setting.text.clone(),
                            reason: "one member is set at a time".to_owned(),
                        }),
                    }
                }
            }
            let mut read = |written: ExprRef| {
                let program = compiler.value(written, &mut Scope::default());
                compiler.world.run_written_out(&program, &mut Vec::new())
            };
            let value = setting.binding.value.map(&mut read);
            let sigma = setting.binding.uncertainty.map(read).transpose();
            let reason = match (errors.first(), value, sigma) {
                (Some(ModelError::BadSetting { reason, .. }), _, _) => reason.clone(),
                (Some(error), _, _) => of_value(error),
                (None, Some(Err(error)), _) | (None, _, Err(error)) => of_value(&error),
                (None, Some(Ok(value)), _) if !self.world.pool.symbols_of(&value.clone().scalars()).is_empty() => {
                    "values are numbers, without names such as `t`".to_owned()
                }
                (None, Some(Ok(Value::Vector(_))), _) if setting.binding.indices.is_some() => {
                    "one member is one number".to_owned()
                }
                (None, Some(_), Ok(Some(Value::Vector(_)))) => "an uncertainty is one number".to_owned(),
                (None, Some(Ok(value)), Ok(sigma)) => {
                    let member = setting.binding.indices.as_deref().map(|_| key(&at));
                    let name = setting.binding.name.text.to_string();
                    let set = SetValue { value, sigma, used: false, text: setting.text.clone() };
                    self.set.insert((name, member), set);
                    continue;
                }
                (None, None, Ok(_)) => "there is no value".to_owned(),
            };
            self.errors.push(ModelError::BadSetting { text: setting.text.clone(), reason });
        }
    }

    pub(super) fn check_settings(&mut self, settings: &Settings) {
        for setting in &settings.entries {
            let name = &setting.binding.name.text;
            if !self.set.values().any(|value| value.text == setting.text && !value.used) {
                continue;
            }
            let mut known: Vec<&str> = self.world.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
            known.extend(self.world.parameter_families.iter().map(|f| f.name.as_str()));
            let shown = setting.text.split_once('=').map_or(name.as_str(), |(left, _)| left.trim());
            // The name may be right, the member not; a number has none.
            let family = |own: &str| own.split_once('[').map_or(own, |(name, _)| name).to_owned();
            let own = self.world.parameters.iter().map(|parameter| parameter.name.as_str());
            let members: Vec<&str> = own.filter(|own| family(own) == family(shown)).collect();
            let nearest = nearest(shown, known.iter().copied()).filter(|_| members.is_empty()).map(str::to_owned);
            let instead = match self.world.names.get(&**name).map(|(entity, _)| *entity) {
                Some(Entity::Coordinate(_)) => Some(format!(
                    "it is a coordinate: write `guess {name} = …` or `equilibrium {name} = …` in the file"
                )),
                Some(Entity::Let(_)) => {
                    Some(format!("`{name}` follows from others: set the parameters that it is made of"))
                }
                _ => match members.as_slice() {
                    [] => None,
                    [only] => Some(format!("the model has `{only}`")),
                    [first, .., last] => Some(format!("the model has `{first}` to `{last}`")),
                },
            };
            self.errors.push(ModelError::UnknownSetting { name: shown.to_owned(), nearest, instead });
        }
    }

    pub(super) fn parameter(&mut self, binding: &Binding) {
        let name = &binding.name;
        let is_parameter = |entity| if let Entity::Parameter(family) = entity { Some(family) } else { None };
        let Some(known) = self.known_family(binding, is_parameter) else { return };
        let family = known.unwrap_or_else(|| {
            let grid = Grid { rank: binding.indices.as_ref().map_or(0, |i| i.entries.len().min(3)), ..Grid::default() };
            self.world.parameter_families.push(Family { name: name.text.to_string(), span: name.span, grid });
            self.world.parameter_families.len() - 1
        });
        let members = self.members(binding.indices.as_deref(), name);
        let mut scope = members.as_ref().map_or_else(Scope::default, |members| members.scope.clone());
        // Without indices nothing can be said of what is written in them.
        let [program, uncertainty] = [binding.value, binding.uncertainty].map(|side| {
            let side = side.filter(|_| members.is_some());
            side.map(|value| self.compiler().value(value, &mut scope))
        });
        if known.is_none() {
            self.introduce(name, Entity::Parameter(family));
        }
        let unit = self.factor(binding.unit);
        // What names quantities is in SI already; what is set from outside never is.
        let [factor, sigma_factor] =
            [&program, &uncertainty].map(|side| unit.filter(|_| !side.as_ref().is_some_and(reads_names)));
        let Some(members) = members else { return };
        let base = self.world.parameters.len();
        let room = self.world.pool.budget().room(members.count(), BYTES_EACH).map_err(ModelError::from);
        let added = room.and_then(|()| self.world.parameter_families[family].add(&members, base, false));
        if self.note(added).is_none() {
            return;
        }
        let keys = members.keys();
        self.spread_setting(name, &members, &keys, known.is_some());
        let span = program.as_ref().map_or(name.span, |program| program.span);
        let mut lists = [None, None];
        for (list, program) in lists.iter_mut().zip([&program, &uncertainty]) {
            if let Some(program) = program.as_ref().filter(|_| !members.named) {
                *list = self.given_to_all(program, &members, name, &keys);
                if list.is_none() {
                    self.stand_in(name, members.rank, &keys);
                    return;
                }
            }
        }
        let file = self.file;
        let vector = || {
            let indices = binding.indices.as_ref().map(|indices| print_indices(file, indices));
            let value = binding.value.map(|value| print_expr(file, value));
            let value = value.filter(|text| text.len() <= LONGEST_QUOTED).unwrap_or("…".to_owned());
            format!("a `let` may be a vector: `let {}[{}] = {value}`", name.text, indices.unwrap_or_default())
        };
        for (position, at) in keys.iter().enumerate() {
            let slots = &at[..members.rank];
            let own = match (&program, &lists[0]) {
                (None, _) => None,
                (Some(_), Some(list)) => list.get(position).copied(),
                (Some(program), None) => self.value_of(program, slots).and_then(|value| {
                    let number = value.scalar("a parameter");
                    let number = number.map_err(|(what, _)| ModelError::shape((what, Some(vector())), span));
                    self.note(number)
                }),
            };
            let own = own.map(|own| self.scaled(own, factor));
            let sigma = uncertainty.as_ref().filter(|_| own.is_some() || program.is_none());
            let sigma = sigma.and_then(|program| match &lists[1] {
                Some(list) => list.get(position).copied(),
                None => self.number_of(program, slots, "an uncertainty"),
            });
            if own.is_none() && program.is_some() || sigma.is_none() && uncertainty.is_some() {
                self.stand_in(name, members.rank, &keys[position..]);
                return;
            }
            let sigma = sigma.map(|sigma| self.scaled(sigma, sigma_factor));
            self.add_parameter(&name.text, name.span, members.rank, *at, own, sigma, unit, span);
        }
    }

    /// The family of a kind that a binding adds to, if that is not a new one; `None` where the name is given twice.
    pub(super) fn known_family(
        &mut self,
        binding: &Binding,
        of_kind: impl Fn(Entity) -> Option<usize>,
    ) -> Option<Option<usize>> {
        let name = &binding.name;
        let Some((entity, first)) = self.world.names.get(name.text.as_str()).copied() else { return Some(None) };
        let has_members = self.world.family(entity).is_some_and(|family| family.grid.rank > 0);
        let known = of_kind(entity).filter(|_| binding.indices.is_some() && has_members);
        if known.is_none() {
            let is_coordinate = matches!(entity, Entity::Coordinate(_)) && binding.indices.is_some() && has_members;
            let name = name.text.to_string();
            let other = if name == "y" { "u" } else { "y" };
            let help = is_coordinate.then(|| {
                format!(
                    "coordinates get no members later: declare them all, `coord {name}[0..n]` with \
                     `constraint {name}[0] = 0`, or use a `let` of another name, `let {other}[0] = 0` and \
                     `let {other}[i in 1..n] = {name}[i]`"
                )
            });
            self.errors.push(ModelError::GivenTwice { name, help, span: binding.name.span, first });
        }
        known.map(Some)
    }

    /// A list that was set for a whole family gives each member its own; one that was set for a member goes before.
    fn spread_setting(&mut self, name: &Name, members: &Members, keys: &[Key], is_later_piece: bool) {
        let whole = (name.text.to_string(), None);
        let Some(set) = self.set.get_mut(&whole) else { return };
        let SetValue { value: value @ Value::Vector(_), sigma, text, .. } = &*set else { return };
        let (value, sigma, text) = (value.clone(), sigma.clone(), text.clone());
        set.used = true;
        let scalars = value.scalars();
        let reason = if is_later_piece {
            format!("`{}` is declared in pieces: its members are set one at a time", name.text)
        } else if members.rank == 0 {
            format!("`{}` is one number", name.text)
        } else if scalars.len() != keys.len() || !self.shape_fits(&value, members) {
            format!("`{}` has {}, but {} is given", name.text, counted(keys.len(), "member"), value.describe())
        } else {
            for (at, own) in keys.iter().zip(scalars) {
                let set = SetValue { value: Value::Scalar(own), sigma: sigma.clone(), used: true, text: text.clone() };
                self.set.entry((name.text.to_string(), Some(*at))).or_insert(set);
            }
            return;
        };
        self.errors.push(ModelError::BadSetting { text, reason });
    }

    /// The members' values without an index: one that fills the family, or a list.
    fn given_to_all(&mut self, program: &Program, members: &Members, name: &Name, keys: &[Key]) -> Option<Vec<ExprId>> {
        let value = self.value_of(program, keys.first().map_or(&[], |at| &at[..members.rank]))?;
        match value.scalar("") {
            Ok(one) => Some(vec![one; keys.len()]),
            Err(_) => self.listed(&value, members, name, (keys, program.span)),
        }
    }

    /// The members' values from a list of them.
    fn listed(
        &mut self,
        value: &Value,
        members: &Members,
        name: &Name,
        (keys, span): (&[Key], Span),
    ) -> Option<Vec<ExprId>> {
        let scalars = value.scalars();
        if scalars.len() == keys.len() && self.shape_fits(value, members) {
            return Some(scalars);
        }
        let found = match value {
            Value::Vector(parts) if members.rank == 1 => parts.len(),
            Value::Vector(_) | Value::Scalar(_) | Value::Zero => scalars.len(),
        };
        let ranges = if let Value::Vector(rows) = value
            && let Some(Value::Vector(row)) = rows.first()
        {
            format!("1..{}, 1..{}", rows.len(), row.len())
        } else {
            format!("1..{found}")
        };
        self.errors.push(if members.rank == 0 {
            let help = format!("declare a family: `param {}[{ranges}] = …`", name.text);
            let what = format!("`{}` is one number, but {} is given", name.text, value.describe());
            ModelError::shape((what, Some(help)), span)
        } else if found == keys.len() {
            let help = match members.rank {
                1 => format!("declare an index for the columns: `param {}[{ranges}] = …`", name.text),
                _ => "a list for each of the first index, `[[1, 2], [3, 4]]`".to_owned(),
            };
            let rank = counted_indices(members.rank);
            let what = format!("`{}` has {rank}, but {} is given", name.text, value.describe());
            ModelError::shape((what, Some(help)), span)
        } else {
            ModelError::ListLength { name: name.text.to_string(), expected: keys.len(), found, span }
        });
        None
    }

    /// Gives members that could not be worked out a value, so that what uses them is no mistake of
    /// its own.
    fn stand_in(&mut self, name: &Name, rank: usize, keys: &[Key]) {
        for at in keys {
            self.add_parameter(&name.text, name.span, rank, *at, Some(self.world.pool.one()), None, None, name.span);
        }
    }

    /// Whether a list has a number for each member; along an axis with a single one there need be no list.
    pub(super) fn shape_fits(&self, value: &Value, members: &Members) -> bool {
        fn fits(value: &Value, extents: &[usize]) -> bool {
            match (extents, value) {
                ([], value) => matches!(value, Value::Scalar(_) | Value::Zero),
                ([1, rest @ ..], value) if fits(value, rest) => true,
                ([extent, rest @ ..], Value::Vector(parts)) => {
                    parts.len() == *extent && parts.iter().all(|part| fits(part, rest))
                }
                (_, Value::Scalar(_) | Value::Zero) => false,
            }
        }
        let Some(block) = &members.block else { return members.rank == 1 };
        let extents: Vec<usize> = (0..members.rank).map(|axis| block.extent(axis)).collect();
        fits(value, &extents)
    }

    #[allow(clippy::too_many_arguments)] // all of one parameter
    pub(super) fn add_parameter(
        &mut self,
        family: &str,
        span: Span,
        rank: usize,
        at: Key,
        own: Option<ExprId>,
        sigma: Option<ExprId>,
        factor: Option<ExprId>,
        value_span: Span,
    ) {
        let name = member_name(family, rank, &at);
        let number = self.world.parameters.len();
        let symbol = self.world.pool.fresh_symbol(&name);
        self.world.kinds.insert(symbol, SymbolKind::Parameter(number));
        let plain = self.world.pool.symbol_expr(symbol);
        let (set, set_sigma) = self.setting(family, rank, &at, factor);
        let own = set.or(own);
        let sigma = set_sigma.or(sigma);
        let mut symbolic = plain;
        let mut value = None;
        if let Some(own) = own {
            if let Some(on) = self.world.varying_symbol(own) {
                let what = format!("the parameter `{name}`");
                self.errors.push(ModelError::NotConstant { what, on, span: value_span });
            } else if set.is_none() && sigma.is_none() && !self.world.pool.symbols_of(&[own]).is_empty() {
                // What has an uncertainty of its own is a quantity of its own.
                symbolic = own;
            }
            value = self.world.closed(own);
            if value.is_some_and(|value| self.world.pool.is_undefined(value)) && self.world.pool.take_outgrown() {
                self.errors.push(ModelError::NumberTooLong { what: format!("`{name}`"), span: value_span });
                // What uses it is no mistake of its own.
                symbolic = self.world.pool.one();
                value = Some(symbolic);
            }
            if self.structural.contains(family)
                && let Some(value) = value
                && self.world.pool.as_number(value).is_some()
            {
                symbolic = value;
            }
        }
        let uncertainty = sigma.and_then(|sigma| self.world.closed(sigma));
        let is_negative = |sigma| evaluate_closed::<f64>(&self.world.pool, sigma, ()).is_some_and(|sigma| sigma < 0.0);
        if uncertainty.is_some_and(is_negative) {
            let (what, help) = (format!("the uncertainty of `{name}` is negative"), None);
            self.errors.push(ModelError::Shape { what, span: value_span, help });
        }
        self.world.parameters.push(Parameter { name, span, symbol, symbolic, value, uncertainty, unit: factor });
    }

    /// The value that was set from outside for a member, and its uncertainty.
    pub(super) fn setting(
        &mut self,
        family: &str,
        rank: usize,
        at: &Key,
        factor: Option<ExprId>,
    ) -> (Option<ExprId>, Option<ExprId>) {
        let single = (family.to_owned(), (rank > 0).then_some(*at));
        let whole = (family.to_owned(), None);
        let found = [single, whole].into_iter().find_map(|place| {
            let set = self.set.get_mut(&place)?;
            set.used = true;
            let sigma = set.sigma.as_ref().and_then(|sigma| sigma.scalar("").ok());
            Some((set.value.scalar("").ok()?, sigma))
        });
        let (value, sigma) = found.map_or((None, None), |(value, sigma)| (Some(value), sigma));
        // It is in the unit that the file declares, as in the file itself.
        [value, sigma].map(|own| own.map(|own| self.scaled(own, factor))).into()
    }
}

impl World {
    /// A coordinate or the time, where an expression depends on one.
    pub(super) fn varying_symbol(&self, e: ExprId) -> Option<String> {
        let mut symbols = self.pool.symbols_of(&[e]).into_iter();
        let varying = symbols.find(|own| !matches!(self.kinds.get(*own), Some(SymbolKind::Parameter(_)) | None))?;
        Some(self.pool.symbol_name(varying).into_owned())
    }

    /// The expression with all parameters replaced by their values.
    pub(super) fn closed(&mut self, e: ExprId) -> Option<ExprId> {
        let symbols = self.pool.symbols_of(&[e]);
        if symbols.is_empty() {
            return Some(e);
        }
        let value = |symbol| Some((symbol, self.parameters[self.kinds.parameter(symbol)?].value?));
        let values: Substitution = symbols.into_iter().map(value).collect::<Option<_>>()?;
        self.pool.substitute(&[e], &values).first().copied()
    }
}
