//! Equilibria that have to be searched for, eight sets at once.
//!
//! Newton's method on the generalised forces in modal coordinates, damped so that the forces fall
//! at every step, from the equilibrium at the model's own values (or from its guess). Where the forces have no
//! potential, K is their derivative, and in place of modes there are vectors v_i that take the forces apart: t_iᵀ K
//! v_j is 0 for i ≠ j ([`Solver::split`]). Directions
//! that nothing holds are not moved along, as for a single model. What is found is then verified
//! with bounds: the forces may vanish there, and, where it can be shown, an equilibrium *does* lie
//! within the radius that the stiffness is evaluated for (see
//! [`Workspace::equilibrium_proved`]).

use super::block::{Compiled, Start, Workspace, finite};
use super::bound::{TINY, growth};
use super::solve::Solver;
use super::tape::{Registers, U};
use librate_core::precision::Lane;

/// Steps before a search is given up.
const MOST_STEPS: usize = 100;
/// A stiffness below this fraction of the largest one holds nothing.
const NEUTRAL: f64 = 1e-10;
/// A step that small beside the coordinates is at rounding level.
const ARRIVED: f64 = 8.0 * U;
/// Damping below: no way on.
const LEAST_DAMPING: f64 = 1e-5;

/// Memory of a search.
pub(super) struct Search {
    /// The problem of the coordinates that are searched for.
    solver: Solver,
    guess: Registers,
    /// Forces on them, and in modal coordinates.
    force: Vec<Lane>,
    modal: Vec<Lane>,
    /// The Newton step in these coordinates.
    step: Vec<Lane>,
    /// The coordinates before a trial step.
    before: Vec<Lane>,
    /// t_i, row by row, where forces have no potential; there t_iᵀ K v_i and a bound of its error and of |t_iᵀ K v_j|
    /// over all other j.
    tests: Vec<Lane>,
    rows: Vec<(Lane, Lane)>,
    /// What the forces are at the point found, with their bounds; one a coordinate.
    rest: Vec<(Lane, Lane)>,
    /// No modal coordinate is off by more, if the estimate holds.
    radius: Lane,
    /// 1 where the point 0 is taken, because no force acts there; nothing is searched for then.
    stays: Lane,
}

impl Search {
    pub(super) fn new(start: &Start, n: usize, is_conservative: bool) -> Self {
        let m = start.free.len();
        let tests = if is_conservative { 0 } else { m };
        let row = vec![Lane::ZERO; m];
        Self {
            solver: Solver::new(m),
            guess: Registers::new(&start.guess),
            force: row.clone(),
            modal: row.clone(),
            step: row.clone(),
            before: row.clone(),
            tests: vec![Lane::ZERO; tests * m],
            rows: vec![(Lane::ZERO, Lane::ZERO); tests],
            rest: vec![(Lane::ZERO, Lane::ZERO); n],
            radius: Lane::ZERO,
            stays: Lane::ZERO,
        }
    }

    /// What the forces are multiplied by: v_i itself, or t_i.
    fn tests(&self) -> &[Lane] {
        if self.tests.is_empty() { &self.solver.vectors } else { &self.tests }
    }

    /// The forces in modal coordinates, Xᵀ F; gives the sum of their squares.
    fn project(&mut self) -> Lane {
        let m = self.force.len();
        let mut norm = Lane::ZERO;
        for i in 0..m {
            let mut sum = Lane::ZERO;
            for a in 0..m {
                sum += self.tests()[i * m + a] * self.force[a];
            }
            self.modal[i] = sum;
            norm += sum * sum;
        }
        norm
    }

    /// 1 for the modes that are held, else 0.
    fn held(&self, mode: usize) -> Lane {
        let stiffest = self.solver.values.iter().fold(Lane::ZERO, |most, value| value.abs().max(most));
        // Those are squares of stiffnesses.
        let neutral = if self.tests.is_empty() { NEUTRAL } else { NEUTRAL * NEUTRAL };
        self.solver.values[mode].abs().above(stiffest * Lane::splat(neutral))
    }

    /// The Newton step; gives its largest component and the largest coordinate.
    fn newton(&mut self) -> Lane {
        let m = self.force.len();
        self.step.fill(Lane::ZERO);
        for i in 0..m {
            let along = (-self.modal[i] / self.solver.values[i]).choose(self.held(i), Lane::ZERO);
            for a in 0..m {
                self.step[a] += along * self.solver.vectors[i * m + a];
            }
        }
        self.step.iter().fold(Lane::ZERO, |most, step| step.abs().max(most))
    }
}

impl Workspace {
    /// Searches for the equilibria of a block, and leaves M, K and the forces with their bounds in
    /// the registers; gives 1 where one was found.
    pub(super) fn search(&mut self, compiled: &Compiled) -> Lane {
        let (Some(start), Some(mut search)) = (&compiled.search, self.search.take()) else { return Lane::ZERO };
        self.starting_point(compiled, start, &mut search);
        self.walk(compiled, start, &mut search);
        self.settle(compiled, start, &mut search);
        self.search = Some(search);
        self.at_rest(compiled)
    }

    /// The register of a coordinate that is searched for.
    fn place(compiled: &Compiled, k: usize) -> usize {
        compiled.program.constants.len() + compiled.width + k
    }

    fn starting_point(&mut self, compiled: &Compiled, start: &Start, search: &mut Search) {
        let count = start.free.len();
        if let Some(nominal) = &start.nominal {
            for (k, coordinate) in start.free.iter().enumerate() {
                search.before[k] = Lane::splat(nominal[*coordinate]);
            }
        } else {
            let (from, to) = (compiled.program.constants.len(), start.guess.constants.len());
            for k in 0..compiled.width {
                search.guess.value[to + k] = self.registers.value[from + k];
            }
            self.run_guess(&start.guess, &mut search.guess);
            for (k, coordinate) in start.free.iter().enumerate() {
                let register = start.guess.outputs[*coordinate] as usize;
                search.before[k] = search.guess.value[register];
            }
        }
        for k in 0..count {
            let at = Self::place(compiled, k);
            self.registers.value[at] = Lane::ZERO;
            self.registers.error[at] = Lane::ZERO;
        }
        search.stays = Lane::ZERO;
        if start.zero_first {
            self.run(&compiled.program, true);
            search.stays = self.at_rest(compiled);
        }
        for k in 0..count {
            self.registers.value[Self::place(compiled, k)] = Lane::ZERO.choose(search.stays, search.before[k]);
        }
    }

    /// The forces on the free coordinates from the registers; gives 1 where the forces are numbers.
    fn read(&self, compiled: &Compiled, start: &Start, search: &mut Search) -> Lane {
        let mut numbers = Lane::ONE;
        for (force, coordinate) in search.force.iter_mut().zip(&start.free) {
            *force = self.registers.value[compiled.gradient[*coordinate]];
            numbers = numbers * finite(*force);
        }
        numbers
    }

    fn modes(&self, compiled: &Compiled, start: &Start, search: &mut Search) {
        let place = |coordinate: usize| start.free.binary_search(&coordinate).ok();
        self.registers.fill(compiled, &mut search.solver, place);
        if compiled.velocity.is_none() {
            self.solve(&mut search.solver);
        } else {
            search.solver.split(&mut search.tests);
        }
    }

    /// Newton steps until no set gets any further.
    fn walk(&mut self, compiled: &Compiled, start: &Start, search: &mut Search) {
        let mut damping = Lane::ONE;
        self.run(&compiled.program, false);
        let mut active = self.read(compiled, start, search) * (Lane::ONE - search.stays);
        for _ in 0..MOST_STEPS {
            self.modes(compiled, start, search);
            let norm = search.project();
            let length = search.newton();
            active = active * norm.above(Lane::ZERO);
            let mut size = Lane::ZERO;
            for k in 0..start.free.len() {
                let at = Self::place(compiled, k);
                search.before[k] = self.registers.value[at];
                size = size.max(search.before[k].abs());
                let step = (damping * search.step[k]).choose(active, Lane::ZERO);
                self.registers.value[at] = search.before[k] + step;
            }
            self.run(&compiled.program, false);
            let numbers = self.read(compiled, start, search);
            let after = search.project();
            let better = numbers * norm.above(after);
            // Down at rounding level the forces need not fall any more.
            let arrived = Lane::ONE - length.above(size * Lane::splat(ARRIVED));
            let accepted = active * better;
            for k in 0..start.free.len() {
                let at = Self::place(compiled, k);
                let new = self.registers.value[at];
                self.registers.value[at] = new.choose(accepted, search.before[k]);
            }
            let larger = (damping + damping).zip(Lane::ONE, f64::min);
            let smaller = damping * Lane::splat(0.25);
            damping = larger.choose(accepted, smaller);
            active = active * (Lane::ONE - arrived) * damping.above(Lane::splat(LEAST_DAMPING));
            if !active.any() {
                break;
            }
            if (Lane::ONE - accepted).any() {
                self.run(&compiled.program, false);
            }
            self.read(compiled, start, search);
        }
    }

    /// Estimates what the point found is off by, in modal coordinates: twice the largest Newton
    /// step that the forces and their bounds allow. The registers end with M, K and the forces
    /// for all points that near, with their bounds.
    fn settle(&mut self, compiled: &Compiled, start: &Start, search: &mut Search) {
        self.run(&compiled.program, true);
        self.read(compiled, start, search);
        self.modes(compiled, start, search);
        for (rest, register) in search.rest.iter_mut().zip(&compiled.gradient) {
            *rest = (self.registers.value[*register], self.registers.error[*register]);
        }
        let m = start.free.len();
        let mut radius = Lane::splat(f64::MIN_POSITIVE);
        search.step.fill(Lane::ZERO);
        for i in 0..m {
            let vector = &search.solver.vectors[i * m..(i + 1) * m];
            let left = modal_force(&search.tests()[i * m..(i + 1) * m], &start.free, &search.rest);
            let held = search.held(i);
            let step = left / search.solver.values[i].abs();
            radius = step.choose(held, Lane::ZERO).max(radius);
            // The step is not needed any more: its memory holds z of these modes.
            for (reach, x) in search.step.iter_mut().zip(vector) {
                *reach += x.abs().choose(held, Lane::ZERO);
            }
        }
        search.radius = Lane::ZERO.choose(search.stays, radius + radius);
        for (k, reach) in search.step.iter().enumerate() {
            // Somewhat more, because X is not the same at the end.
            self.registers.error[Self::place(compiled, k)] = *reach * search.radius * Lane::splat(1.001);
        }
        self.run(&compiled.program, true);
        if compiled.velocity.is_some() {
            self.couple(compiled, start, search);
        }
    }

    /// The rows of t_iᵀ K v_j, for all K near the point found.
    fn couple(&self, compiled: &Compiled, start: &Start, search: &mut Search) {
        let m = start.free.len();
        let (gamma, grow) = (Lane::splat((2 * m + 4) as f64 * U), Lane::splat(growth(m)));
        let place = |coordinate: usize| start.free.binary_search(&coordinate).ok();
        search.rows.fill((Lane::ZERO, Lane::ZERO));
        for (j, vector) in search.solver.vectors.chunks_exact(m).enumerate() {
            let (image, error) = (&mut search.modal, &mut search.force);
            image.fill(Lane::ZERO);
            error.fill(Lane::splat(TINY));
            for entry in &compiled.stiffness {
                if let (Some(a), Some(b)) = (place(entry.row), place(entry.column)) {
                    let value = self.registers.value[entry.register];
                    image[a] += value * vector[b];
                    error[a] += (gamma * value.abs() + self.registers.error[entry.register]) * vector[b].abs();
                }
            }
            for (i, (test, row)) in search.tests.chunks_exact(m).zip(&mut search.rows).enumerate() {
                let (mut sum, mut off) = (Lane::ZERO, Lane::splat(TINY));
                for (a, t) in test.iter().enumerate() {
                    sum += *t * image[a];
                    off += t.abs() * error[a];
                }
                if i == j {
                    *row = (sum, row.1 + off * grow);
                } else {
                    row.1 += (sum.abs() + off) * grow;
                }
            }
        }
    }

    /// Where an equilibrium is proved to lie within the radius: 1, else 0.
    ///
    /// In modal coordinates about the point found, q = q̂ + Xη, the gradient is g(η) = XᵀF with
    /// the derivative H(η) = XᵀK(q)X. For |η_j| <= r all q lie in the box that K was evaluated
    /// for, so that |H(η) - diag ĥ| has row sums of at most ρ_i ([`super::bound`]). By the mean
    /// value theorem the map η - g(η)/ĥ (component by component) sends that box into itself where
    /// |g_i(0)| + ρ_i r <= |ĥ_ii| r for all i, and by Brouwer's theorem it has a fixed point: a zero
    /// of the forces (the idea of R. Krawczyk, Computing 4 (1969) 187). Where they have no potential, the same holds
    /// for g = TᵀF and H = TᵀKX; T is regular because H is.
    pub(super) fn equilibrium_proved(&self, compiled: &Compiled) -> Lane {
        let n = compiled.dimension;
        let (Some(start), Some(search)) = (&compiled.search, &self.search) else { return Lane::ZERO };
        // With coordinates held fixed the modes mix what moves with what does not.
        if start.free.len() < n {
            return search.stays;
        }
        let r = search.radius;
        let grow = Lane::splat(growth(n));
        let mut proved = Lane::ONE;
        let is_conservative = compiled.velocity.is_none();
        let tests = if is_conservative { &self.solver.vectors } else { &search.tests };
        for i in 0..n {
            let left = modal_force(&tests[i * n..(i + 1) * n], &start.free, &search.rest);
            let (diagonal, row) =
                if is_conservative { (self.bounder.diagonal(i), self.bounder.row(i)) } else { search.rows[i] };
            let needed = (left + row * r) * grow;
            proved = proved * (diagonal.abs() * r).above(needed);
        }
        for a in 0..n {
            let sizes = || (0..n).fold(Lane::ZERO, |sum, j| sum + search.solver.vectors[j * n + a].abs());
            let reach = if is_conservative { self.bounder.reach[a] } else { sizes() * grow };
            let room = self.registers.error[Self::place(compiled, a)];
            proved = proved * room.above(reach * r * grow);
        }
        proved.max(search.stays)
    }
}

/// A bound of |xᵀF| from the computed forces and their bounds.
fn modal_force(vector: &[Lane], free: &[usize], rest: &[(Lane, Lane)]) -> Lane {
    let m = vector.len();
    let mut sum = Lane::ZERO;
    let mut off = Lane::ZERO;
    let gamma = Lane::splat((m + 4) as f64 * U);
    for (x, coordinate) in vector.iter().zip(free) {
        let (force, error) = rest[*coordinate];
        sum += *x * force;
        off += x.abs() * (error + gamma * force.abs());
    }
    (sum.abs() + off) * Lane::splat(growth(m)) + Lane::splat(f64::MIN_POSITIVE)
}
