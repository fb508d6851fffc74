//! Stability and frequencies at an equilibrium that is known: what `modes` says there.

use super::Equilibrium;
use librate_core::linearize::{self, LinearizeError, Linearized};
use librate_core::model::{Given, Givens, Model};
use librate_core::modes::Options;
use librate_core::number::Number;
use librate_core::oscillation;
use librate_core::precision::Ball;
use librate_core::span::Span;

/// The model about what is found from a point; `None` where nothing is.
fn linearized(model: &Model, point: &[Ball]) -> Result<Option<Linearized>, LinearizeError> {
    let mut model = model.clone();
    // In place of what the file says of where to look.
    model.equilibria = Givens::none(point.len());
    model.guesses = Givens::none(point.len());
    for (at, x) in point.iter().enumerate() {
        let value = model.pool.number(Number::from_f64_exact(x.mid_f64()).unwrap_or(Number::ZERO));
        model.guesses.set(at, Some(Given { symbolic: value, value: Some(value), span: Span::default() }));
    }
    match linearize::linearize(model) {
        Ok(linearized) => Ok(Some(linearized)),
        Err(error @ LinearizeError::Budget(_)) => Err(error),
        Err(_) => Ok(None),
    }
}

/// Puts the modes of a linearized model into an equilibrium; gives its zero motions in words.
fn put(linearized: &Linearized, own: &mut Equilibrium) -> Result<Vec<String>, LinearizeError> {
    match oscillation::normal_modes(linearized, &Options::default().without_vectors()) {
        Ok(modes) => {
            own.stability = modes.stability;
            own.omega = modes.modes.iter().map(|mode| mode.omega).collect();
            own.growth = modes.modes.iter().map(|mode| mode.growth).collect();
            Ok(modes.zero_motions)
        }
        Err(error @ LinearizeError::Budget(_)) => Err(error),
        Err(_) => Ok(Vec::new()),
    }
}

/// Puts the modes of a model at an equilibrium into it; it stays undecided where there are none, or they are those of another.
pub(super) fn put_modes(model: &Model, own: &mut Equilibrium) -> Result<(), LinearizeError> {
    let Some(linearized) = linearized(model, &own.point)? else { return Ok(()) };
    let size = own.point.iter().fold(0.0_f64, |size, x| size.max(x.mid_f64().abs())).max(f64::MIN_POSITIVE);
    let near = |(found, x): (&Ball, &Ball)| {
        let off = (*found - *x).abs_upper();
        off <= 1e-9 * size + 2.0 * (found.radius + x.radius)
    };
    if linearized.equilibrium().values.iter().zip(&own.point).all(near) {
        put(&linearized, own)?;
    }
    Ok(())
}

/// The equilibrium that is found from a point, if it is proved, and its zero motions.
pub(super) fn nearby(model: &Model, start: &[Ball]) -> Result<Option<(Equilibrium, Vec<String>)>, LinearizeError> {
    let Some(linearized) = linearized(model, start)? else { return Ok(None) };
    let found = linearized.equilibrium();
    if !found.proved {
        return Ok(None);
    }
    let mut own = Equilibrium::new(found.values.clone(), None);
    let motions = put(&linearized, &mut own)?;
    Ok(Some((own, motions)))
}
