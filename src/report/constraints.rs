//! Constraints, their multipliers and the displacements that they allow, as text.

use librate_core::derive::{Derivation, Independent, Motion, Reduced, Tangent};

/// `constraints`, and how many say nothing new.
pub(super) fn constraints_title(derivation: &Derivation) -> String {
    let constraints = derivation.constraints.as_ref();
    match constraints.map_or(0, |own| own.dependent) {
        0 => "constraints".to_owned(),
        1 => "constraints, not counting one that follows from them".to_owned(),
        count => format!("constraints, not counting {count} that follow from them"),
    }
}

/// What the displacements are that follow others.
pub(super) fn displacements_title(tangent: &Tangent, reduced: &Reduced) -> &'static str {
    match tangent.massless.is_empty() {
        true if reduced.velocities => "velocities that the constraints allow, beside the steady ones",
        true => "displacements that the constraints allow",
        false => "displacements without inertia, which follow the others",
    }
}

/// `delta_x = r*delta_theta`, for the displacements that follow others, or their velocities.
pub(super) fn direction_texts(derivation: &Derivation, reduced: &Reduced) -> Vec<String> {
    let names = &derivation.names.displacements;
    let follows = reduced.follows.iter();
    follows
        .map(|(i, sum)| {
            let (name, prime) = (names.get(*i).map_or("", String::as_str), if reduced.velocities { "'" } else { "" });
            format!("{name}{prime} = {}", derivation.displaced_text(sum))
        })
        .collect()
}

/// `x^2 + y^2 - l^2 = 0 (lambda)`: the constraints, and what their multipliers are called.
pub(super) fn constraint_texts(derivation: &Derivation) -> Vec<(String, String)> {
    let constraints = derivation.constraints.iter();
    constraints
        .flat_map(|own| own.expressions.iter().zip(&own.names))
        .map(|(expression, name)| {
            let text = format!("{} = 0", derivation.pool.display(*expression));
            (text, name.clone())
        })
        .collect()
}

/// Said above equations without multipliers.
pub(super) const REDUCED_TITLE: &str = "reduced equations, without multipliers";
/// Said above the velocities that conditions determine.
pub(super) const FOLLOWS_TITLE: &str = "velocities that the conditions determine";

/// `phi'`, for each of the independent velocities.
pub(super) fn independent_names(derivation: &Derivation, own: &Independent) -> Vec<String> {
    own.free.iter().map(|i| derivation.names.of(Motion::Velocity(*i))).collect()
}

/// `x'` and what it is in terms of the independent ones, for the other velocities.
pub(super) fn follow_texts(derivation: &Derivation, own: &Independent) -> Vec<(String, String)> {
    let follows = own.follows.iter();
    follows.map(|(i, speed)| (derivation.names.of(Motion::Velocity(*i)), derivation.text(speed))).collect()
}

/// The equations in independent velocities.
pub(super) fn reduced_texts(derivation: &Derivation, own: &Independent) -> Vec<String> {
    own.equations.iter().map(|equation| format!("{} = 0", derivation.text(equation))).collect()
}

/// The names of the multipliers and what they are.
pub(super) fn multipliers<'a>(
    derivation: &'a Derivation,
    tangent: &'a Tangent,
) -> impl Iterator<Item = (&'a String, String)> {
    let names = derivation.constraints.iter().flat_map(|own| &own.names);
    names.zip(&tangent.multipliers).map(|(name, value)| (name, derivation.pool.display(*value)))
}

/// `lambda = -g*m/(2*l)`, for the multipliers that are known in symbols.
pub(super) fn multiplier_texts(derivation: &Derivation, tangent: &Tangent) -> Vec<String> {
    let known = multipliers(derivation, tangent).filter(|(name, value)| *name != value);
    known.map(|(name, value)| format!("{name} = {value}")).collect()
}

/// The multipliers that are found numerically.
pub(super) fn unsolved(derivation: &Derivation, tangent: &Tangent) -> Vec<String> {
    let open = multipliers(derivation, tangent).filter(|(name, value)| *name == value);
    open.map(|(name, _)| name.clone()).collect()
}
