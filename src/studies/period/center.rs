//! The equilibrium that a motion is about: that of the linearized model, or a corner of U.

use super::energies::Energies;
use super::panel::{Field, Kink};
use librate_core::expr::{ExprId, Pool};
use librate_core::linearize::{Linearized, Origin, Units, evaluate_closed};
use librate_core::model::{Givens, Model};
use librate_core::order::Order;
use librate_core::precision::{Ball, Big, Enclosure};

/// Slopes on the two sides of a corner are computed with so many bits.
const BITS_OF_CORNERS: usize = 256;

/// An equilibrium.
#[derive(Clone, Debug)]
pub(super) enum Center {
    /// Of small oscillations, or at least where these are searched for.
    Linearized(Linearized),
    /// Where the slope of U jumps from a negative to a positive value: a minimum without a stiffness.
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
        let kinks = own.kinks;
        let tape = own.tape?;
        let value = |from: &Givens| from.get(0)?.value;
        let (given, start) = (value(&model.equilibria), value(&model.guesses));
        let pool = &mut energies.pool;
        let from = given.or(start).unwrap_or_else(|| pool.zero());
        let mut places: Vec<(f64, ExprId)> = Vec::new();
        for Kink { place, .. } in &kinks {
            let way = pool.sub(*place, from);
            let there = pool.vanishes(way);
            let way = evaluate_closed::<Ball>(pool, way, ())?;
            if there || given.is_none() {
                places.push((way.mid_f64().abs(), *place));
            }
        }
        places.order_by(|a, b| a.0.total_cmp(&b.0));
        let numbers = |place: ExprId| evaluate_closed::<Big>(pool, place, BITS_OF_CORNERS);
        let mut field = Field::new(
            &tape,
            &super::shape().ok()?,
            kinks.iter().map(|kink| kink.evaluated(pool, BITS_OF_CORNERS)).collect::<Option<Vec<_>>>()?,
            BITS_OF_CORNERS,
        );
        let (_, place) =
            places.into_iter().find(|(_, place)| numbers(*place).is_some_and(|at| is_minimum(&mut field, &at)))?;
        Some(Self { model: model.clone(), place, pool: pool.clone() })
    }
}

/// Whether U certainly falls before a position and rises behind it.
fn is_minimum(field: &mut Field<Big>, at: &Big) -> bool {
    let slopes = [-1.0, 1.0].map(|side| {
        let span = field.free_way(at, side)?;
        field.hold(at, &span);
        let (potential, _) = field.expand(at, &field.number(1.0), 2);
        field.release();
        potential.get(1).cloned()
    });
    let [Some(before), Some(behind)] = slopes else { return false };
    Enclosure::is_negative(&before) && Enclosure::is_positive(&behind)
}
