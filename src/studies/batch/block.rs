//! One block of parameter sets from their values to their results.

use pulp::{Arch, Simd, WithSimd};

use super::bound::{Bounder, Entry};
use super::discs::{Discs, Matrices};
use super::exponents::Exponents;
use super::listed::{Listed, list};
use super::search::Search;
use super::solutions::{NO_NUMBER, Outcome, Solutions};
use super::solve::Solver;
use super::tape::{Registers, run};
use super::{Bounds, Options};
use crate::program::Program;
use librate_core::modes::orient;
use librate_core::order::Order;
use librate_core::precision::{LANES, Lane};

/// What a study compiles: one program for the equilibrium, M, K and the forces.
#[derive(Clone, Debug)]
pub(super) struct Compiled {
    pub(super) dimension: usize,
    /// Values a set.
    pub(super) width: usize,
    /// Of the parameters, then of the coordinates that are searched for.
    pub(super) program: Program,
    /// The registers of the equilibrium, one a coordinate.
    pub(super) equilibrium: Vec<usize>,
    pub(super) mass: Vec<Entry>,
    /// Of the upper triangle where the model is conservative, else all.
    pub(super) stiffness: Vec<Entry>,
    /// What multiplies velocities, all entries; `None` where the model is conservative.
    pub(super) velocity: Option<Vec<Entry>>,
    /// The registers of the forces with the sign of a gradient of the potential, one a coordinate; empty where they
    /// are proved to vanish.
    pub(super) gradient: Vec<usize>,
    /// What the search needs, where there is one.
    pub(super) search: Option<Start>,
}

/// Where a search starts and what it moves.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// The coordinates that are searched for.
    pub(super) free: Vec<usize>,
    /// Whether the point 0 is taken where no force acts there.
    pub(super) zero_first: bool,
    /// Of the parameters: the starting values of all coordinates.
    pub(super) guess: Program,
    /// Start here instead.
    pub(super) nominal: Option<Vec<f64>>,
}

/// Memory for one block; made once a request.
pub(super) struct Workspace {
    arch: Arch,
    pub(super) registers: Registers,
    pub(super) solver: Solver,
    pub(super) bounder: Bounder,
    /// Memory for the search.
    pub(super) search: Option<Search>,
    order: Vec<usize>,
    /// Memory for exponents, where there are some.
    general: Option<Box<General>>,
}

/// Memory for exponents.
struct General {
    exponents: Exponents,
    discs: Discs,
    listed: Vec<Listed>,
}

/// What is done with the vector instructions that the machine has. (A closure would have them only where the compiler chooses to
/// inline it.)
enum Work<'a> {
    Run {
        program: &'a Program,
        registers: &'a mut Registers,
        bounds: bool,
    },
    Solve(&'a mut Solver),
    Bound {
        bounder: &'a mut Bounder,
        solver: &'a Solver,
        compiled: &'a Compiled,
        registers: &'a Registers,
    },
    /// With vectors or without.
    SolveGeneral {
        exponents: &'a mut Exponents,
        solver: &'a mut Solver,
        vectors: bool,
    },
    BoundGeneral {
        general: &'a mut General,
        matrices: Matrices<'a>,
    },
}

impl WithSimd for Work<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        match self {
            Self::Run { program, registers, bounds: true } => run::<true>(program, registers),
            Self::Run { program, registers, bounds: false } => run::<false>(program, registers),
            Self::Solve(solver) => solver.solve(),
            Self::Bound { bounder, solver, compiled, registers } => {
                let numbers = (&registers.value[..], &registers.error[..]);
                bounder.bound(solver, (&compiled.mass, &compiled.stiffness), numbers);
            }
            Self::SolveGeneral { exponents, solver, vectors } => exponents.solve(solver, vectors),
            Self::BoundGeneral { general, matrices } => general.discs.bound(&general.exponents, matrices),
        }
    }
}

impl Registers {
    /// Puts M and K where a solver reads them, of the coordinates that have a place there; gives 1 where their entries
    /// are numbers.
    pub(super) fn fill(
        &self,
        compiled: &Compiled,
        solver: &mut Solver,
        place: impl Fn(usize) -> Option<usize>,
    ) -> Lane {
        let n = solver.n;
        let mut numbers = Lane::ONE;
        let is_symmetric = compiled.velocity.is_none();
        let stiffness = (&compiled.stiffness, &mut solver.stiffness, is_symmetric);
        for (entries, matrix, is_symmetric) in [(&compiled.mass, &mut solver.mass, true), stiffness] {
            for entry in entries {
                if let (Some(i), Some(j)) = (place(entry.row), place(entry.column)) {
                    let value = self.value[entry.register];
                    numbers = numbers * finite(value);
                    matrix[i * n + j] = value;
                    if is_symmetric {
                        matrix[j * n + i] = value;
                    }
                }
            }
        }
        numbers
    }
}

impl Workspace {
    pub(super) fn new(compiled: &Compiled) -> Self {
        let n = compiled.dimension;
        Self {
            arch: Arch::new(),
            registers: Registers::new(&compiled.program),
            solver: Solver::new(n),
            bounder: Bounder::new(n),
            search: compiled.search.as_ref().map(|start| Search::new(start, n, compiled.velocity.is_none())),
            order: Vec::with_capacity(n),
            general: compiled.velocity.as_ref().map(|_| {
                let listed = Vec::with_capacity(2 * n);
                Box::new(General { exponents: Exponents::new(n), discs: Discs::new(n), listed })
            }),
        }
    }

    /// Runs a program, with bounds or without.
    pub(super) fn run(&mut self, program: &Program, bounds: bool) {
        self.arch.dispatch(Work::Run { program, registers: &mut self.registers, bounds });
    }

    pub(super) fn run_guess(&self, program: &Program, registers: &mut Registers) {
        self.arch.dispatch(Work::Run { program, registers, bounds: false });
    }

    pub(super) fn solve(&self, solver: &mut Solver) {
        self.arch.dispatch(Work::Solve(solver));
    }

    /// Solves sets (at most [`LANES`] of them, one after the other), whose values are off by so much where that is
    /// there, and writes the results from set `first` on.
    pub(super) fn block(
        &mut self,
        compiled: &Compiled,
        options: &Options,
        (sets, errors): (&[f64], &[f64]),
        first: usize,
        into: &mut Solutions,
    ) {
        let width = compiled.width;
        let count = sets.len() / width;
        let base = compiled.program.constants.len();
        // Lanes without a set repeat the last one.
        for lane in 0..LANES {
            let at = lane.min(count - 1) * width;
            for (k, value) in sets[at..at + width].iter().enumerate() {
                self.registers.value[base + k].0[lane] = *value;
                self.registers.error[base + k].0[lane] = errors.get(at + k).copied().unwrap_or(0.0);
            }
        }
        let inputs = &self.registers.value[base..base + width];
        let given = inputs.iter().fold(Lane::ONE, |given, value| given * finite(*value));
        let rigorous = options.bounds == Bounds::Rigorous;
        let found = if compiled.search.is_some() {
            self.search(compiled)
        } else {
            self.run(&compiled.program, rigorous || !compiled.gradient.is_empty());
            self.at_rest(compiled)
        };
        // Where the expression of a given equilibrium has no value, there is none, even if M and K
        // have lost it in simplification.
        let found = compiled.equilibrium.iter().fold(found, |found, at| found * finite(self.registers.value[*at]));
        let mut numbers = self.registers.fill(compiled, &mut self.solver, Some);
        if let Some(velocity) = &compiled.velocity {
            numbers = numbers * self.solve_general(compiled, velocity, options);
        } else {
            self.arch.dispatch(Work::Solve(&mut self.solver));
            if rigorous {
                let (bounder, solver, registers) = (&mut self.bounder, &self.solver, &self.registers);
                self.arch.dispatch(Work::Bound { bounder, solver, compiled, registers });
            }
        }
        let proved = if compiled.search.is_some() {
            if rigorous { self.equilibrium_proved(compiled) } else { Lane::ZERO }
        } else {
            Lane::ONE
        };
        for lane in 0..count {
            let outcome = if given.0[lane] == 0.0 {
                Outcome::NotFinite
            } else if found.0[lane] == 0.0 {
                Outcome::NoEquilibrium
            } else if numbers.0[lane] == 0.0 {
                Outcome::NotFinite
            } else if self.solver.positive.0[lane] == 0.0 || (rigorous && self.bounder.positive.0[lane] == 0.0) {
                Outcome::MassNotPositive
            } else if self.solver.converged.0[lane] == 0.0 {
                Outcome::NotConverged
            } else if proved.0[lane] == 0.0 {
                Outcome::Estimated
            } else {
                Outcome::Solved
            };
            self.write(compiled, options, outcome, (lane, first + lane), into);
        }
    }

    /// Solves for the exponents, and bounds them; gives 1 where what multiplies velocities is numbers.
    fn solve_general(&mut self, compiled: &Compiled, velocity: &[Entry], options: &Options) -> Lane {
        let Some(general) = &mut self.general else { return Lane::ZERO };
        let mut numbers = Lane::ONE;
        for entry in velocity {
            let value = self.registers.value[entry.register];
            numbers = numbers * finite(value);
            general.exponents.velocity[entry.row * compiled.dimension + entry.column] = value;
        }
        let rigorous = options.bounds == Bounds::Rigorous;
        let (exponents, solver) = (&mut general.exponents, &mut self.solver);
        self.arch.dispatch(Work::SolveGeneral { exponents, solver, vectors: rigorous || options.vectors });
        self.solver.converged = general.exponents.converged;
        if rigorous {
            let (values, errors) = (&self.registers.value[..], &self.registers.error[..]);
            self.bounder.weigh(&self.solver, &compiled.mass, (values, errors));
            let entries = [&compiled.mass[..], &compiled.stiffness, velocity];
            self.arch.dispatch(Work::BoundGeneral { general, matrices: Matrices { entries, values, errors } });
        }
        numbers
    }

    /// 1 where no force acts, as far as the bounds can tell.
    pub(super) fn at_rest(&self, compiled: &Compiled) -> Lane {
        let mut rest = Lane::ONE;
        for register in &compiled.gradient {
            let (force, error) = (self.registers.value[*register], self.registers.error[*register]);
            // Where the bound is infinite nothing is known.
            rest = rest * finite(error) * (Lane::ONE - force.abs().above(error)) * finite(force);
        }
        rest
    }

    /// Writes the results of one lane.
    fn write(
        &mut self,
        compiled: &Compiled,
        options: &Options,
        outcome: Outcome,
        (lane, set): (usize, usize),
        into: &mut Solutions,
    ) {
        let n = compiled.dimension;
        let rigorous = options.bounds == Bounds::Rigorous;
        into.outcomes[set] = outcome;
        let row = set * n..(set + 1) * n;
        for (to, register) in into.equilibria[row.clone()].iter_mut().zip(&compiled.equilibrium) {
            *to = self.registers.value[*register].0[lane] + 0.0;
        }
        let square = set * n * n..(set + 1) * n * n;
        if options.matrices {
            let parts = [(&self.solver.mass, &mut into.mass), (&self.solver.stiffness, &mut into.stiffness)];
            for (from, to) in parts {
                for (to, from) in to[square.clone()].iter_mut().zip(from) {
                    *to = from.0[lane] + 0.0;
                }
            }
        }
        if let Some(general) = &mut self.general {
            general.write(options, outcome, (lane, set), into);
            return;
        }
        let omega_squared = &mut into.omega_squared[row.clone()];
        let bounds = &mut into.bounds[row];
        if !outcome.is_solved() {
            omega_squared.fill(f64::NAN);
            bounds.fill(f64::NAN);
            if options.vectors {
                into.vectors[square].fill(f64::NAN);
            }
            return;
        }
        let values = if rigorous { &self.bounder.values } else { &self.solver.values };
        let order = &mut self.order;
        order.clear();
        order.extend(0..n);
        order.order_by(|i, j| {
            let (a, b) = (values[*i].0[lane], values[*j].0[lane]);
            a.total_cmp(&b).then(i.cmp(j))
        });
        for (to, from) in omega_squared.iter_mut().zip(&*order) {
            *to = values[*from].0[lane] + 0.0;
        }
        bounds.fill(f64::INFINITY);
        if rigorous {
            for (to, from) in bounds.iter_mut().zip(&*order) {
                let radius = self.bounder.radii[*from].0[lane];
                *to = if radius.is_nan() { f64::INFINITY } else { radius };
            }
        }
        if options.vectors && n > 0 {
            let vectors = into.vectors[square].chunks_exact_mut(n);
            for (to, from) in vectors.zip(&*order) {
                let row = &self.solver.vectors[from * n..(from + 1) * n];
                for (to, from) in to.iter_mut().zip(row) {
                    *to = from.0[lane];
                }
                orient(to);
            }
        }
    }
}

impl General {
    /// Writes the results of one lane.
    fn write(&mut self, options: &Options, outcome: Outcome, (lane, set): (usize, usize), into: &mut Solutions) {
        let n = into.dimension;
        let row = set * 2 * n..(set + 1) * 2 * n;
        let square = set * n * n..(set + 1) * n * n;
        if options.matrices {
            for (to, from) in into.velocity[square].iter_mut().zip(&self.exponents.velocity) {
                *to = from.0[lane] + 0.0;
            }
        }
        let shapes = if options.vectors { &mut into.shapes[set * 2 * n * n..(set + 1) * 2 * n * n] } else { &mut [] };
        if !outcome.is_solved() {
            into.exponents[row.clone()].fill(NO_NUMBER);
            into.exponent_bounds[row].fill(f64::NAN);
            shapes.fill(NO_NUMBER);
            return;
        }
        let rigorous = options.bounds == Bounds::Rigorous;
        let values = if rigorous { &self.discs.values } else { &self.exponents.values };
        let radii = rigorous.then_some(&self.discs.radii[..]);
        list(values, radii, self.exponents.unit.0[lane], lane, &mut self.listed);
        let numbers = into.exponents[row.clone()].iter_mut().zip(&mut into.exponent_bounds[row]);
        for ((value, bound), own) in numbers.zip(&self.listed) {
            (*value, *bound) = (own.value, own.bound);
        }
        for (shape, own) in shapes.chunks_exact_mut(n.max(1)).zip(&self.listed) {
            own.shape(&self.exponents, lane, shape);
        }
    }
}

/// 1 where the number is finite, else 0.
pub(super) fn finite(x: Lane) -> Lane {
    x.map(|x| if x.is_finite() { 1.0 } else { 0.0 })
}
