//! The box: a closed range for each coordinate.

use super::error::EquilibriaError;
use crate::source;
use librate_core::diagnostic::nearest;
use librate_core::linearize;
use librate_core::model::{Constant, Model, entries};
use librate_core::precision::{Ball, Scalar};

/// Closed ranges of coordinates.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Region {
    /// Per coordinate: both ends in SI; `None` for one that is left out.
    pub sides: Vec<Option<[Ball; 2]>>,
}

impl Region {
    /// Reads `x=-2..2, phi[1]=-pi..pi`: a coordinate, or a family for all its members, and both ends in the coordinate's unit.
    ///
    /// # Errors
    /// What can't be read, is no coordinate, is given twice, reversed, empty or infinite.
    pub fn parse(text: &str, model: &Model) -> Result<Self, EquilibriaError> {
        let mut sides = vec![None; model.coordinates.len()];
        for entry in entries(text) {
            let bad = |reason: &str| EquilibriaError::BadSide { text: entry.to_owned(), reason: reason.to_owned() };
            let (name, range) = entry.split_once('=').ok_or_else(|| bad("there is no `=`"))?;
            let (from, to) = range.split_once("..").ok_or_else(|| bad("there is no `..` between two ends"))?;
            for at in members(name, model)? {
                let side = side(at, [from.trim(), to.trim()], model, &bad)?;
                let place: &mut Option<[Ball; 2]> = &mut sides[at];
                if place.replace(side).is_some() {
                    return Err(bad("it is given twice"));
                }
            }
        }
        Ok(Self { sides })
    }
}

/// The coordinates of a name.
fn members(name: &str, model: &Model) -> Result<Vec<usize>, EquilibriaError> {
    let name: String = name.split_whitespace().collect();
    if let Ok(at) = source::coordinate(model, &name) {
        return Ok(vec![at]);
    }
    if let Some(family) = model.families.iter().find(|family| family.name == name) {
        return Ok(family.range().collect());
    }
    let families: Vec<String> = model.families.iter().map(|family| family.name.clone()).collect();
    let mut known: Vec<String> = families.iter().cloned().chain(model.coordinates.names()).collect();
    known.dedup();
    let help = match nearest(&name, known.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("the model has {}", source::quoted(&families)),
    };
    Err(EquilibriaError::NotACoordinate { name, help })
}

fn side(
    at: usize,
    [from, to]: [&str; 2],
    model: &Model,
    bad: &impl Fn(&str) -> EquilibriaError,
) -> Result<[Ball; 2], EquilibriaError> {
    let coordinate = model.coordinates.at(at);
    let wrong = |what| EquilibriaError::BadRange {
        coordinate: coordinate.name(),
        what,
        from: from.to_owned(),
        to: to.to_owned(),
    };
    let end = |text: &str| -> Result<Ball, EquilibriaError> {
        let plain = text.trim_start_matches(['-', '+']).trim();
        if ["inf", "infinity", "oo", "∞"].contains(&plain.to_lowercase().as_str()) {
            return Err(wrong("infinite"));
        }
        let value = Constant::read(text).map_err(|reason| bad(&reason))?;
        let value = linearize::constant(value.pool(), value.value()).filter(Ball::is_finite);
        let value = value.ok_or_else(|| wrong("too large"))?;
        let factor = coordinate.factor.and_then(|factor| linearize::constant(&model.pool, factor));
        Ok(factor.map_or(value, |factor| value.mul(&factor)))
    };
    let [from, to] = [end(from)?, end(to)?];
    if to.sub(&from).is_negative() { Err(wrong("reversed")) } else { Ok([from, to]) }
}
