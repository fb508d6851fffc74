//! The period over a range of amplitudes or energies.

use super::{Constant, Options, Oscillator, Period, PeriodError, Request};
use crate::model::ModelError;
use crate::number::range::Range;
