//! Named matrices of 3 x 3 that depend on parameters alone: tensors of inertia, as like as not.
//!
//! Nothing is computed: whether such a matrix is symmetric, and which moments it has, is asked elsewhere.

use hashbrown::HashMap;

use super::compile::Scope;
use super::dimension::Dimensions;
use super::elaborate::Elaborator;
use super::names::{Entity, Family, member_name};
use super::survey::named;
use super::values::Value;
use crate::expr::ExprId;
use crate::span::Span;
use crate::syntax::{ExprKind, ExprRef, File, StatementKind};

/// A named matrix of 3 x 3.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Tensor {
    /// `I`, `I[2]`.
    pub name: String,
    /// Where its name stands in the `let`.
    pub span: Span,
    /// The entries by row, in the symbols of parameters; of one that is not constant in other symbols, too.
    pub entries: [[ExprId; 3]; 3],
    /// The coordinate, velocity or time that it depends on, if it is not a constant.
    pub varies_with: Option<String>,
    /// The SI unit of its entries, where the file has units and they tell.
    pub unit: Option<String>,
    /// Where it is meant as one: in `dot(w, I*w)` with an angular velocity `w`, in `about(I, n)` or in `steiner(I, m, d)`.
    pub rotational: Option<Span>,
}

/// Larger families of named expressions are no families of tensors.
const MOST_MEMBERS: usize = 10_000;

fn three_by_three(value: &Value) -> Option<[[ExprId; 3]; 3]> {
    let rows = value.matrix("").ok()?;
    let rows: Option<Vec<[ExprId; 3]>> = rows.into_iter().map(|row| <[ExprId; 3]>::try_from(row).ok()).collect();
    <[[ExprId; 3]; 3]>::try_from(rows?).ok()
}

impl Elaborator<'_> {
    /// The matrices among the named expressions without indices and, where `families` are wanted, the members of
    /// those with: these are written out for it, which the energies may not have needed.
    pub(super) fn tensors(&mut self, families: bool, dimensions: &Dimensions) -> Vec<Tensor> {
        let mut found = Vec::new();
        let mut rotations = None;
        for number in 0..self.world.lets.len() {
            let Family { name, span, grid } = self.world.lets[number].family.clone();
            if grid.rank > 0 && (!families || grid.numbers().count() > MOST_MEMBERS) {
                continue;
            }
            for (place, at) in self.world.lets[number].keys().into_iter().enumerate() {
                // A member that can't be worked out and that no energy uses is not asked for here either.
                let value = self.world.let_member(number, at, span);
                let Some(entries) = value.ok().as_ref().and_then(three_by_three) else { break };
                let rotations = rotations.get_or_insert_with(|| meant(self.file).0);
                found.push(Tensor {
                    varies_with: self.varying_entry(&entries),
                    rotational: rotations.get(name.as_str()).copied(),
                    unit: dimensions.unit(&name, place),
                    name: member_name(&name, grid.rank, &at),
                    span,
                    entries,
                });
            }
        }
        found
    }

    /// What is written in full where a tensor is meant, and can be worked out where it stands.
    pub(super) fn unnamed_tensors(&mut self) -> Vec<Tensor> {
        if !self.world.rigid {
            return Vec::new();
        }
        let mut found = Vec::new();
        for (at, used) in meant(self.file).1 {
            if !self.is_constant(at) {
                continue;
            }
            let told = self.errors.len();
            let program = self.compiler().value(at, &mut Scope::default());
            let value = self.world.run_written_out(&program, &mut Vec::new());
            self.errors.truncate(told);
            let Some(entries) = value.ok().as_ref().and_then(three_by_three) else { continue };
            let (span, varies_with) = (self.file.expr(at).span, self.varying_entry(&entries));
            found.push(Tensor { name: String::new(), span, varies_with, unit: None, rotational: Some(used), entries });
        }
        found
    }

    /// Whether an expression is of numbers, parameters and named expressions alone, without an index.
    fn is_constant(&self, at: ExprRef) -> bool {
        let mut todo = vec![at];
        while let Some(at) = todo.pop() {
            match self.file.expr(at).kind {
                ExprKind::Name("pi") => {}
                ExprKind::Name(name) => match self.world.names.get(name) {
                    Some((Entity::Parameter(_) | Entity::Let(_), _)) => {}
                    _ => return false,
                },
                ExprKind::SumOver { .. } | ExprKind::IntegralOver { .. } | ExprKind::Field { .. } => return false,
                _ => self.file.children(at, &mut todo),
            }
        }
        true
    }

    fn varying_entry(&self, entries: &[[ExprId; 3]; 3]) -> Option<String> {
        let entries = entries.as_flattened().iter();
        entries.copied().find_map(|entry| self.world.varying_symbol(entry))
    }
}

/// What is meant for a tensor of inertia, and where: by name, and what is no name. That is `I` in `about(I, n)`, in
/// `steiner(I, m, d)`, and in `dot(w, I*w)` where `w` is an `angular_velocity(…)` by name: only that is certain to be an
/// energy of rotation; any other form says nothing.
fn meant(file: &File) -> (HashMap<&str, Span>, Vec<(ExprRef, Span)>) {
    let mut velocities: Vec<&str> = Vec::new();
    for statement in &file.statements {
        if let StatementKind::Let(binding) = &statement.kind
            && let Some(root) = binding.value
            && let ExprKind::Call { function, .. } = file.expr(root).kind
            && &*function.text == "angular_velocity"
        {
            velocities.push(&binding.name.text);
        }
    }
    let mut by_name = HashMap::new();
    let mut written = Vec::new();
    let mut add = |tensor: ExprRef, used: Span| match named(file, tensor) {
        Some((name, _)) => _ = by_name.entry(name).or_insert(used),
        None => written.push((tensor, used)),
    };
    for expr in file.expressions.iter() {
        let ExprKind::Call { function, arguments } = expr.kind else { continue };
        match (&*function.text, arguments) {
            ("about", [tensor, _]) | ("steiner", [tensor, _, _]) => add(*tensor, expr.span),
            ("dot", [left, right]) if !velocities.is_empty() => {
                for (omega, image) in [(left, right), (right, left)] {
                    let ExprKind::Product(factors) = file.expr(*image).kind else { continue };
                    let [tensor, again] = factors else { continue };
                    let turns = named(file, *omega).filter(|(name, _)| velocities.contains(name));
                    if turns.is_some() && same(file, *omega, again.value()) && !again.inverted() {
                        add(tensor.value(), expr.span);
                    }
                }
            }
            _ => {}
        }
    }
    (by_name, written)
}

/// Whether two names, with their indices if they have any, are written alike.
fn same(file: &File, a: ExprRef, b: ExprRef) -> bool {
    let bare = |at: &ExprRef| match file.expr(*at).kind {
        ExprKind::Name(text) | ExprKind::Number(text) => Some(text),
        _ => None,
    };
    let alike = |(i, j): (&ExprRef, &ExprRef)| bare(i).is_some() && bare(i) == bare(j);
    let (Some((a, i)), Some((b, j))) = (named(file, a), named(file, b)) else { return false };
    a == b && i.len() == j.len() && i.iter().zip(j).all(alike)
}
