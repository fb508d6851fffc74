//! What is to be said of a response beside its numbers.

use super::{PeakKind, Peaks, Response, Value};
use librate_core::diagnostic::Diagnostic;

impl Response {
    /// Warnings: that an equilibrium is unstable or not proved, and where values are no numbers.
    #[must_use]
    pub fn remarks(&self) -> Vec<Diagnostic> {
        const MOST: usize = 3;
        let mut all: Vec<Diagnostic> = self.unstable.iter().map(Diagnostic::from).collect();
        let wanted = [
            (
                Value::Infinite,
                false,
                "the response is infinite: an undamped resonance",
                "there is no steady motion at this frequency: the force feeds the mode without end",
            ),
            (
                Value::Infinite,
                true,
                "the response is infinite: nothing holds the model",
                "there is no equilibrium under a constant force: it drives the model away",
            ),
            (
                Value::Undecided,
                false,
                "the response is not decided",
                "bounds do not tell it from a resonance or from 0: its cells are empty",
            ),
        ];
        for (value, is_constant, what, help) in wanted {
            // Those of the model's own drive are values of a parameter.
            let is_of = |at: usize| (self.input.is_some() && self.places[at] == 0.0) == is_constant;
            let is_meant = |at: usize| value == Value::Undecided || is_of(at);
            let hit = |at: &usize| is_meant(*at) && self.outputs.iter().any(|output| output.values[*at] == value);
            let places: Vec<usize> = (0..self.places.len()).filter(hit).collect();
            if places.is_empty() {
                continue;
            }
            let named: Vec<String> = places.iter().take(MOST).map(|at| self.places[*at].to_string()).collect();
            let more = if places.len() > MOST { format!(" and {} more", places.len() - MOST) } else { String::new() };
            let message = format!("at {} = {}{more} {what}", self.name, named.join(", "));
            all.push(Diagnostic::remark(message).with_help(help));
        }
        if !self.proved {
            let remark = Diagnostic::remark("the existence of the equilibrium is not proved");
            all.push(
                remark.with_help("its place is an estimate, and the digits of the response do not cover its error"),
            );
        }
        all
    }
}

impl Peaks {
    /// Where bounds do not decide on maxima and minima of this output.
    #[must_use]
    pub fn remark(&self, parameter: &str) -> Option<Diagnostic> {
        const MOST: usize = 3;
        // Seven digits tell the place.
        let short = |place: f64| format!("{place:.6e}").parse::<f64>().unwrap_or(place);
        let shown = |piece: &[f64; 2]| match piece.map(short) {
            [from, to] if from == to => format!("near {from}"),
            [from, to] => format!("from {from} to {to}"),
        };
        let named: Vec<String> = self.undecided.iter().take(MOST).map(shown).collect();
        let more = self.undecided.len().saturating_sub(MOST);
        let more = if more > 0 { format!(" and at {more} more places") } else { String::new() };
        let cut: Vec<String> = self.cut().map(|place| short(place).to_string()).collect();
        let cut = if cut.is_empty() {
            String::new()
        } else {
            format!(", nor all half-power points of the maximum at {}", cut.join(", "))
        };
        let message =
            format!("peaks of {} are not decided at {parameter} {}{more}{cut}", self.coordinate, named.join(", "));
        let help = "this happens at modes without friction that the force does not excite or that do not move this coordinate, and where friction leaves a coordinate at rest; with many modes, a shorter range helps; elsewhere no peak is missed";
        (!named.is_empty()).then(|| Diagnostic::remark(message).with_help(help))
    }

    /// Maxima without a half-power point up to where nothing is decided.
    fn cut(&self) -> impl Iterator<Item = f64> {
        let is_open = |from: f64, to: f64| self.undecided.iter().any(|[a, b]| a.min(*b) <= to && from <= a.max(*b));
        let places = || self.found.iter().map(|peak| peak.place.mid_f64());
        let maxima = self.found.iter().filter(|peak| peak.kind == PeakKind::Maximum);
        maxima
            .map(|peak| (peak.place.mid_f64(), &peak.half_power))
            .filter(move |(at, [below, above])| {
                let last = places().filter(|own| own < at).fold(f64::NEG_INFINITY, f64::max);
                let next = places().filter(|own| own > at).fold(f64::INFINITY, f64::min);
                below.is_none() && is_open(last, *at) || above.is_none() && is_open(*at, next)
            })
            .map(|(at, _)| at)
    }
}
