//! The equilibrium that a motion is about: that of the linearized model, or a corner of U.

use super::energies::{Energies, Kinked};
use super::panel::Kink;
use librate_core::expr::{ExprId, Pool, Substitution, Symbol};
use librate_core::linearize::{Linearized, Origin, Units, evaluate_closed};
use librate_core::model::{Givens, Model};
use librate_core::number::Number;
use librate_core::order::Order;
use librate_core::precision::{Ball, Big, Enclosure};

/// Slopes on the two sides of a corner are computed with so many bits.
const BITS_OF_CORNERS: usize = 256;
/// On one side of a corner so many derivatives of U are computed.
const MOST_DERIVATIVES: usize = 8;

/// An equilibrium.
#[derive(Clone, Debug)]
pub(super) enum Center {
    /// Of small oscillations, or at least where these are searched for.
    Linearized(Linearized),
    /// Where the slope of U jumps from a negative to a positive value, or one of them is 0: a minimum without a stiffness.
    Corner(Corner),
}

/// A corner of U.
#[derive(Clone, Debug)]
pub(super) struct Corner {
    model: Model,
    /// The position, a constant of `pool`.
    place: ExprId,
    pool: Pool,
}

impl Center {
    /// The model as written.
    pub(super) fn model(&self) -> &Model {
        match self {
            Self::Linearized(own) => own.model(),
            Self::Corner(own) => &own.model,
        }
    }

    pub(super) fn units(&self) -> Option<&Units> {
        match self {
            Self::Linearized(own) => own.units(),
            Self::Corner(_) => None,
        }
    }

    pub(super) fn is_corner(&self) -> bool {
        matches!(self, Self::Corner(_))
    }

    /// Whether the equilibrium is known to be there.
    pub(super) fn is_proved(&self) -> bool {
        match self {
            Self::Linearized(own) => own.equilibrium().proved,
            Self::Corner(_) => true,
        }
    }

    /// The position in the units of the energies; what is not proved as it stands.
    pub(super) fn position(&self) -> Ball {
        match self {
            Self::Linearized(own) => {
                let value = own.measured_equilibrium().first().copied().unwrap_or(Ball::ZERO);
                if own.equilibrium().proved { value } else { Ball::new(value.mid, 0.0) }
            }
            Self::Corner(own) => evaluate_closed(&own.pool, own.place, ()).unwrap_or(Ball::ZERO),
        }
    }

    /// The same with so many bits, in SI; `None` where there is nothing finer.
    pub(super) fn precisely(&self, bits: usize) -> Option<Big> {
        match self {
            Self::Linearized(own) => own.precisely(bits).filter(|_| self.is_proved())?.equilibrium.first().cloned(),
            Self::Corner(own) => evaluate_closed(&own.pool, own.place, bits),
        }
    }

    /// The position as an expression in the pool of the energies, where it is given or 0.
    pub(super) fn exactly(&self, pool: &Pool) -> Option<ExprId> {
        match self {
            Self::Linearized(own) => match own.equilibrium().origins.first()? {
                Origin::Zero => Some(pool.zero()),
                Origin::Given => own.measured_model().equilibria.get(0)?.value,
                Origin::Found => None,
            },
            Self::Corner(own) => Some(own.place),
        }
    }
}

impl Corner {
    /// The corner of U that is given as the equilibrium, or else the minimum of this kind next to the guess or to 0; `None`
    /// where there is none, or where values of parameters are missing.
    pub(super) fn find(model: &Model, energies: &mut Energies) -> Option<Self> {
        let own = energies.kinked(None);
        let q = energies.coordinate;
        let value = |from: &Givens| from.get(0)?.value;
        let (given, start) = (value(&model.equilibria), value(&model.guesses));
        let pool = &mut energies.pool;
        let from = given.or(start).unwrap_or_else(|| pool.zero());
        let mut places: Vec<(f64, ExprId)> = Vec::new();
        for Kink { place, .. } in &own.kinks {
            let way = pool.sub(*place, from);
            let there = pool.vanishes(way);
            let way = evaluate_closed::<Ball>(pool, way, ())?;
            if there || given.is_none() {
                places.push((way.mid_f64().abs(), *place));
            }
        }
        places.order_by(|a, b| a.0.total_cmp(&b.0));
        let (_, place) = places.into_iter().find(|(_, place)| is_minimum(pool, &own, q, *place))?;
        Some(Self { model: model.clone(), place, pool: pool.clone() })
    }
}

/// Whether U certainly falls before a position and rises behind it, with a slope that jumps there; on one side a later derivative may be
/// the first that is not 0.
fn is_minimum(pool: &mut Pool, own: &Kinked, q: Symbol, place: ExprId) -> bool {
    let orders = [-1, 1].map(|side: i64| {
        let mut here = Substitution::new();
        for (kink, sign) in own.kinks.iter().zip(&own.signs) {
            let way = pool.sub(place, kink.place);
            let way = if pool.vanishes(way) { pool.number(Number::from(side)) } else { way };
            let inside = pool.mul(way, kink.slope);
            let is_negative = is_negative(pool, inside)?;
            here.insert(*sign, pool.number(Number::from(if is_negative { -1 } else { 1 })));
        }
        let mut slope = pool.substitute_one(own.potential, &here);
        let here = Substitution::from([(q, place)]);
        (1..=MOST_DERIVATIVES).find_map(|order| {
            slope = pool.diff(slope, q);
            let value = pool.substitute_one(slope, &here);
            let falls = (!pool.vanishes(value)).then(|| is_negative(pool, value))?;
            Some((falls == Some(side < 0 && order % 2 == 1)).then_some(order))
        })?
    });
    matches!(orders, [Some(1), Some(_)] | [Some(_), Some(1)])
}

/// The sign of a constant, where that is decided.
fn is_negative(pool: &Pool, value: ExprId) -> Option<bool> {
    let value = evaluate_closed::<Big>(pool, value, BITS_OF_CORNERS)?;
    (Enclosure::is_negative(&value) || Enclosure::is_positive(&value)).then(|| Enclosure::is_negative(&value))
}
