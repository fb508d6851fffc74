//! What a motion is called: by what moves, and along what.

use crate::model::{CoordinateFamily, Model};
use crate::number::Number;

/// More names than this are counted instead.
const MOST_NAMED: usize = 4;

/// A motion the same everywhere: `translation of r along x`, `phi is free`.
pub(crate) fn constant(model: &Model, vector: &[Number]) -> String {
    let moved: Vec<usize> = (0..vector.len()).filter(|i| !vector[*i].is_zero()).collect();
    if let [only] = moved.as_slice() {
        return format!("{} is free", model.coordinates.at(*only).name());
    }
    if !moved.iter().all(|i| vector[*i].is_one()) {
        return ratio(model, vector, &moved).unwrap_or_else(|| "combined translation".to_owned());
    }
    let angle = |i: &usize| model.coordinates.at(*i).unit == Some("rad");
    let word = if moved.iter().all(angle) { "common rotation" } else { "translation" };
    let families: Vec<&CoordinateFamily> = families(model, &moved).collect();
    let axis = common_axis(&families, &moved);
    if axis.is_none() && moved.len() == vector.len() && families.len() > 1 {
        return word.to_owned();
    }
    let along = axis.map_or_else(String::new, |axis| format!(" along {}", axis_name(axis)));
    format!("{word} of {}{along}", parts(model, &moved, axis.is_some()))
}

/// A rotation of some coordinates: `rotation of r[1..3] about z`. `whole`: nothing else turns so.
pub(super) fn rotation(model: &Model, turned: &[u32], about: Option<usize>, whole: bool) -> String {
    let about = about.map_or_else(String::new, |axis| format!(" about {}", axis_name(axis)));
    if whole {
        return format!("rotation{about}");
    }
    let turned: Vec<usize> = turned.iter().map(|i| *i as usize).collect();
    let points = families(model, &turned).all(|family| family.extents.len() > 1);
    format!("rotation of {}{about}", parts(model, &turned, points))
}

pub(super) fn axis_name(axis: usize) -> String {
    ["x", "y", "z"].get(axis).map_or_else(|| format!("axis {}", axis + 1), |name| (*name).to_owned())
}

/// The families of these coordinates, which ascend.
fn families<'a>(model: &'a Model, moved: &'a [usize]) -> impl Iterator<Item = &'a CoordinateFamily> {
    model.families.iter().filter(|family| moved.iter().any(|i| family.range().contains(i)))
}

/// The axis, from 0, that all coordinates stand for, where all are components of vectors.
fn common_axis(families: &[&CoordinateFamily], moved: &[usize]) -> Option<usize> {
    let mut axes = moved.iter().map(|i| {
        let inside = |family: &&&CoordinateFamily| family.range().contains(i);
        let family = families.iter().find(inside)?;
        let width = family.extents.last().filter(|_| family.extents.len() > 1)?;
        Some((i - family.first) % width)
    });
    let first = axes.next()??;
    axes.all(|axis| axis == Some(first)).then_some(first)
}

/// `x : y = 1 : 2`, where that is short.
fn ratio(model: &Model, vector: &[Number], moved: &[usize]) -> Option<String> {
    if moved.len() > MOST_NAMED {
        return None;
    }
    let names: Vec<String> = moved.iter().map(|i| model.coordinates.at(*i).name()).collect();
    let numbers: Vec<String> = moved.iter().map(|i| vector[*i].to_string()).collect();
    let text = format!("{} = {}", names.join(" : "), numbers.join(" : "));
    (text.chars().count() <= 60).then_some(text)
}

/// The names of what these coordinates belong to: of whole families, `r`, or members, `r[1..3]`; of the
/// vectors that they are components of where `vectors`.
fn parts(model: &Model, moved: &[usize], vectors: bool) -> String {
    let mut names: Vec<String> = Vec::new();
    let mut members = 0;
    for family in families(model, moved) {
        let inside = family.range();
        let own = moved.iter().filter(|i| inside.contains(i));
        // r[1,2] is a component of r[1].
        let member = |i: &usize| {
            let name = model.coordinates.at(*i).name();
            match name.rfind(',') {
                Some(comma) if vectors => format!("{}]", &name[..comma]),
                Some(_) | None => name,
            }
        };
        let mut own: Vec<String> = own.map(member).collect();
        own.dedup();
        let width = family.extents.last().filter(|_| vectors).unwrap_or(&1);
        members += own.len();
        if own.len() * width == family.len() {
            names.push(family.name.clone());
        } else {
            names.extend(runs(&family.name, own));
        }
    }
    match names.len() {
        0..=MOST_NAMED => names.join(", "),
        _ => format!("{members} of the coordinates"),
    }
}

/// `x[1], x[2], x[3]` as `x[1..3]`.
fn runs(family: &str, members: Vec<String>) -> Vec<String> {
    let index = |member: &str| -> Option<i64> {
        let inside = member.strip_prefix(family)?.strip_prefix('[')?;
        inside.strip_suffix(']')?.parse().ok()
    };
    let indices: Option<Vec<i64>> = members.iter().map(|member| index(member)).collect();
    let Some(indices) = indices else { return members };
    indices
        .chunk_by(|a, b| a.checked_add(1) == Some(*b))
        .filter_map(|run| Some((*run.first()?, *run.last()?)))
        .map(|(first, last)| match last - first {
            0 => format!("{family}[{first}]"),
            _ => format!("{family}[{first}..{last}]"),
        })
        .collect()
}
