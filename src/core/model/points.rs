//! Where the masses of a model are: what may be drawn of it.
//!
//! A point is a vector of two or three components that moves: a named expression whose velocity is used (`let r = […]`, `dot(r', r')`),
//! a family of coordinates that is read as vectors (`coord r[1..N, 1..3]`, `norm(r[i] - r[j])`), or what is named x, y and maybe z.
//! Nothing is computed but the named expressions themselves.

use hashbrown::HashSet;

use super::elaborate::Elaborator;
use super::error::ModelError;
use super::names::{Entity, Key, SymbolKind, member_name};
use super::survey::named;
use crate::expr::ExprId;
use crate::order::Order;
use crate::span::Span;
use crate::syntax::{Drawn, ExprKind, ExprRef, Indices, Name};

/// A point in a plane or in space.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Point {
    /// `r`, `r[2]`, `(x, y)`.
    pub name: String,
    /// Its two or three Cartesian components, in the symbols of coordinates, parameters and the time.
    pub position: Vec<ExprId>,
}

/// What is to be drawn, in the symbols of coordinates, parameters and the time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Drawing {
    /// Dots, two or three components each.
    pub points: Vec<Vec<ExprId>>,
    /// From one point to another, and whether it is a spring.
    pub lines: Vec<([Vec<ExprId>; 2], bool)>,
}

/// Families of more members are not drawn, and of what `draw` says no more.
pub(super) const MOST_MEMBERS: usize = 5000;

/// How names are used.
#[derive(Default)]
struct Uses<'f> {
    /// Their velocities.
    primed: HashSet<&'f str>,
    /// As vectors, with so many indices.
    vectors: HashSet<(&'f str, usize)>,
}

impl Elaborator<'_> {
    /// The points of the model, each once.
    pub(super) fn points(&mut self) -> Vec<Point> {
        let file = self.file;
        let mut uses = Uses::default();
        let named = |at: ExprRef| named(file, at).map(|(name, indices)| (name, indices.len()));
        for expr in file.expressions.iter() {
            match expr.kind {
                ExprKind::Prime(inner) => uses.primed.extend(named(inner).map(|(name, _)| name)),
                ExprKind::Call { function, arguments } if matches!(&*function.text, "dot" | "norm" | "cross") => {
                    // Differences of vectors and velocities as well.
                    let mut todo = arguments.to_vec();
                    while let Some(at) = todo.pop() {
                        match file.expr(at).kind {
                            ExprKind::Prime(inner) | ExprKind::Negate(inner) => todo.push(inner),
                            ExprKind::Sum(terms) => todo.extend(terms.iter().map(|term| term.value())),
                            _ => uses.vectors.extend(named(at)),
                        }
                    }
                }
                _ => {}
            }
        }
        let mut found = self.vector_families(&uses);
        found.extend(self.named_axes(&uses));
        found.extend(self.vector_lets(&uses));
        let mut seen = HashSet::new();
        found.retain(|point| seen.insert(point.position.clone()) && self.is_place(&point.position));
        found
    }

    /// Adds what a `draw` statement says of its first members.
    pub(super) fn draw(
        &mut self,
        (drawing, most): (&mut Drawing, usize),
        drawn: Drawn,
        (indices, points): (Option<&Indices>, &[ExprRef]),
        span: Span,
    ) -> Option<()> {
        let members = self.members(indices, &Name { text: "draw".into(), span })?;
        let before = self.errors.len();
        let Some(programs) = self.compiled(points, &members.scope) else {
            if indices.is_none() {
                self.tell_ranges(drawn, points, before);
            }
            return None;
        };
        if drawn != Drawn::Point && points.len() < 2 {
            let what = format!("a {0} has two ends: `draw {0} a, b`", drawn.as_str());
            return self.refuse(ModelError::shape((what, None), span));
        }
        for at in members.keys().into_iter().take(most) {
            let mut positions: Vec<Vec<ExprId>> = Vec::new();
            for program in &programs {
                let value = self.value_of(program, &at[..members.rank])?;
                let position = value.components("").ok().filter(|own| matches!(own.len(), 2 | 3));
                let Some(position) = position else {
                    let shape = value.describe();
                    let what = format!("what is drawn is a vector of two or three components, but this is {shape}");
                    return self.refuse(ModelError::shape((what, None), program.span));
                };
                if !self.rests(&position) {
                    let what = "what is drawn has a place, but this has a velocity in it".to_owned();
                    return self.refuse(ModelError::shape((what, None), program.span));
                }
                positions.push(position);
            }
            if drawn == Drawn::Point {
                drawing.points.append(&mut positions);
            } else {
                let pairs = positions.windows(2).map(|pair| [pair[0].clone(), pair[1].clone()]);
                drawing.lines.extend(pairs.map(|pair| (pair, drawn == Drawn::Spring)));
            }
        }
        Some(())
    }

    /// Says of names that are indices of points, and not declared, where their ranges are written.
    fn tell_ranges(&mut self, drawn: Drawn, points: &[ExprRef], before: usize) {
        let file = self.file;
        for (family, indices) in points.iter().filter_map(|at| named(file, *at)) {
            for (axis, at) in indices.iter().enumerate() {
                let ExprKind::Name(own) = file.expr(*at).kind else { continue };
                let families = self.world.coordinate_families.iter().filter(|own| own.name == family);
                let block = families.flat_map(|own| &own.grid.blocks).next().filter(|_| axis < 3);
                let range = block.map_or("a..b".to_owned(), |own| format!("{}..{}", own.lower[axis], own.upper[axis]));
                let help = format!("name its range first: `draw {} [{own} in {range}] {family}[…]`", drawn.as_str());
                for error in &mut self.errors[before..] {
                    if let ModelError::UndeclaredName { name, by_place, .. } = error
                        && name.as_str() == own
                    {
                        *by_place = Some(Box::new(("an index without a range", help.clone())));
                    }
                }
            }
        }
    }

    /// Whether components depend on no velocity.
    fn rests(&self, position: &[ExprId]) -> bool {
        let rests = |kind| matches!(kind, SymbolKind::Coordinate(_) | SymbolKind::Parameter(_) | SymbolKind::Time);
        self.world.pool.symbols_of(position).into_iter().all(|symbol| self.world.kinds.get(symbol).is_none_or(rests))
    }

    /// Whether components depend on coordinates and on no velocity.
    fn is_place(&self, position: &[ExprId]) -> bool {
        let moves = |symbol| self.world.kinds.coordinate(symbol).is_some();
        self.rests(position) && self.world.pool.symbols_of(position).into_iter().any(moves)
    }

    fn coordinate_expression(&mut self, number: usize) -> ExprId {
        let symbol = self.world.coordinates.at(number).symbol;
        self.world.pool.symbol_expr(symbol)
    }

    /// Families of coordinates whose last index is that of a component.
    fn vector_families(&mut self, uses: &Uses<'_>) -> Vec<Point> {
        let mut found = Vec::new();
        for at in 0..self.world.coordinate_families.len() {
            let (name, grid) =
                (self.world.coordinate_families[at].name.clone(), &self.world.coordinate_families[at].grid);
            let [block] = grid.blocks.as_slice() else { continue };
            let Some(last) = grid.rank.checked_sub(1).filter(|last| uses.vectors.contains(&(name.as_str(), *last)))
            else {
                continue;
            };
            let (size, base) = (block.extent(last), block.base);
            if !matches!(size, 2 | 3) || block.len() > 3 * MOST_MEMBERS {
                continue;
            }
            let keys: Vec<Key> = block.keys().step_by(size).collect();
            for (place, key) in keys.into_iter().enumerate() {
                let first = base + place * size;
                let position = (first..first + size).map(|number| self.coordinate_expression(number)).collect();
                found.push(Point { name: member_name(&name, last, &key), position });
            }
        }
        found
    }

    /// Members of a named expression, or of coordinates, each with its indices.
    fn scalars(&mut self, name: &str) -> Option<Vec<(Key, ExprId)>> {
        match self.world.names.get(name)?.0 {
            Entity::Coordinate(family) => {
                let grid = self.world.coordinate_families[family].grid.clone();
                let all = grid.keys().into_iter().take(MOST_MEMBERS);
                all.map(|key| Some((key, self.coordinate_expression(grid.find(&key)?)))).collect()
            }
            Entity::Let(number) => {
                let members = self.members_of_let(number)?;
                members.into_iter().map(|(key, value)| Some((key, value.scalar("").ok()?))).collect()
            }
            Entity::Parameter(_) | Entity::Table(_) => None,
        }
    }

    fn members_of_let(&mut self, number: usize) -> Option<Vec<(Key, super::values::Value)>> {
        let (keys, span) = (self.world.lets[number].keys(), self.world.lets[number].family.span);
        if keys.len() > MOST_MEMBERS {
            return None;
        }
        keys.into_iter().map(|key| Some((key, self.world.let_member(number, key, span).ok()?))).collect()
    }

    /// What is named like x, y and z, one of which moves.
    fn named_axes(&mut self, uses: &Uses<'_>) -> Vec<Point> {
        let mut names: Vec<(String, usize)> =
            self.world.names.iter().map(|(name, (_, span))| (name.clone(), span.start as usize)).collect();
        names.order_by_key(|(_, start)| *start);
        let mut found = Vec::new();
        for (x, _) in names {
            let places = [Some(0), x.char_indices().last().map(|(at, _)| at).filter(|at| *at > 0)];
            for at in places.into_iter().flatten() {
                let letters = match x.get(at..=at) {
                    Some("x") => ["y", "z"],
                    Some("X") => ["Y", "Z"],
                    _ => continue,
                };
                let [y, z] = letters.map(|letter| format!("{}{letter}{}", &x[..at], &x[at + 1..]));
                let known = |name: &String| self.world.names.contains_key(name.as_str());
                if !known(&y) || ![&x, &y, &z].into_iter().any(|name| uses.primed.contains(name.as_str())) {
                    continue;
                }
                let all: Vec<String> = [x.clone(), y, z].into_iter().filter(known).collect();
                let axes: Option<Vec<Vec<(Key, ExprId)>>> = all.iter().map(|name| self.scalars(name)).collect();
                let Some(axes) = axes else { continue };
                let Some((first, others)) = axes.split_first() else { continue };
                for (key, own) in first {
                    let rest = others.iter().map(|axis| Some(axis.iter().find(|(other, _)| other == key)?.1));
                    let Some(rest) = rest.collect::<Option<Vec<ExprId>>>() else { break };
                    let position = std::iter::once(*own).chain(rest).collect();
                    let rank =
                        if *key == [0; 3] { 0 } else { key.iter().rposition(|at| *at != 0).map_or(0, |last| last + 1) };
                    found.push(Point { name: member_name(&format!("({})", all.join(", ")), rank, key), position });
                }
                break;
            }
        }
        found
    }

    /// Named vectors whose velocities are used.
    fn vector_lets(&mut self, uses: &Uses<'_>) -> Vec<Point> {
        let mut found = Vec::new();
        for number in 0..self.world.lets.len() {
            let (name, rank) = (self.world.lets[number].family.name.clone(), self.world.lets[number].family.grid.rank);
            if !uses.primed.contains(name.as_str()) {
                continue;
            }
            for (key, value) in self.members_of_let(number).unwrap_or_default() {
                let position = value.components("").ok().filter(|own| matches!(own.len(), 2 | 3));
                let Some(position) = position else { continue };
                found.push(Point { name: member_name(&name, rank, &key), position });
            }
        }
        found
    }
}
