//! Results as JSON, fields in a fixed order, one line a mode or a matrix row.
//!
//! The text is written directly: a tree of values of a problem with thousands of coordinates would
//! need several times the memory of its text.

use std::fmt::{Display, Write};

use super::constraints::{constraint_texts, follow_texts, independent_names, multipliers, reduced_texts};
use super::exponents::{exponent_text, imaginary_unit};
use super::frequencies::{exchange, kind, signs};
use super::page::{assumption_texts, condition_text, conserved_because, left_out};
use super::{Written, damping, zero_motions};
use librate_core::derive::{
    CHAPTERS, Conserved, Derivation, Exchange, Frequencies, Linear, Motion, NormalCoordinates, NormalWaves, Role,
    Tangent,
};
use librate_core::expr::ExprId;
use librate_core::linearize::Linearized;
use librate_core::model::Model;
use librate_core::modes::Options;
use librate_core::oscillation::{NormalMode, NormalModes, Normalization};
use librate_core::precision::{Ball, one_digit_up};

/// The modes as a JSON object: `model`, `coordinates`, `equilibrium`, `equilibrium_error_bound`,
/// `stability`, `secular`, `modes`.
///
/// `options` are those that the modes were computed with. Frequencies are in rad/s where the model
/// has units; `error_bound` bounds the errors of `omega` and `growth` as they stand here, their
/// rounding to doubles included. What is not finite is `null`. Where zero modes are known by name,
/// `zero_motions` lists what they are together; their vectors are some basis of these motions. A
/// file with units adds `units`: SI units of the coordinates (`null` where the file doesn't tell),
/// in which the equilibrium is given and the vectors have xᵀMx = 1 kg m². A steady motion adds `rates`, one
/// a coordinate, 0 for those that rest. Components of shapes that do not move in phase are pairs of real and
/// imaginary part; `limit` says why an exponent is known less well, `gyroscopically_stabilised` that the
/// potential has no minimum and the motion is stable all the same. `omega_sigma` and, where growth is not 0, `growth_sigma` are the
/// standard uncertainties that those of parameters give.
#[must_use]
pub fn modes_json(linearized: &Linearized, modes: &NormalModes, options: &Options) -> String {
    modes_with(linearized, modes, options, &|_| String::new())
}

/// The modes as [`modes_json`] writes them, with further fields of their objects (each begins with a comma).
pub(super) fn modes_with(
    linearized: &Linearized,
    modes: &NormalModes,
    options: &Options,
    more: &dyn Fn(usize) -> String,
) -> String {
    let model = linearized.model();
    let equilibrium = linearized.equilibrium();
    let mut object = Object::of_model(model);
    object.field("equilibrium", middles(&equilibrium.values));
    object.field("equilibrium_error_bound", array(equilibrium.values.iter().map(error_bound)));
    object.field("stability", string(modes.stability.as_str()));
    object.field("secular", modes.secular.map_or_else(null, |secular| secular.to_string()));
    object.lines("modes", modes.modes.iter().enumerate().map(|(at, mode)| mode_object(mode, options, &more(at))));
    object.optional("rates", model.rates.any().then(|| middles(&linearized.rates())));
    object.optional("normalization", (modes.normalization == Normalization::Largest).then_some("\"max\""));
    object.optional("gyroscopically_stabilised", modes.gyroscopically_stabilised.then_some(true));
    object.optional("point_group", modes.point_group.as_deref().map(string));
    let motions = zero_motions(modes, linearized.dimension());
    object.optional("zero_motions", (!motions.is_empty()).then(|| strings(motions)));
    let units = || array(model.coordinates.iter().map(|coordinate| coordinate.unit.map_or_else(null, string)));
    let units = || format!("{{\"coordinates\": {}, \"omega\": \"rad/s\", \"growth\": \"1/s\"}}", units());
    object.optional("units", model.has_units.then(units));
    object.end() + "\n"
}

fn mode_object(mode: &NormalMode, options: &Options, more: &str) -> String {
    let [omega, growth] = Written::of_mode(mode, options.digits);
    let error = mode.omega.mid_f64_error().max(mode.growth.mid_f64_error());
    let mut object = Object::new(", ");
    object.field("omega", number(mode.omega.mid_f64()));
    object.field("omega_digits", omega.json());
    let square = mode.omega_squared.as_ref();
    object.field("omega_squared", square.map_or_else(null, |square| number(square.mid_f64())));
    object.field("growth", number(mode.growth.mid_f64()));
    object.field("growth_digits", growth.json());
    object.field("error_bound", bound(error));
    object.field("digits_error_bound", number(omega.bound.max(growth.bound)));
    object.field("kind", string(mode.kind.as_str()));
    if let Some([ratio, quality]) = damping(mode, options.digits) {
        let bare = |written: Written| written.digits.unwrap_or_else(null);
        object.field("damping_ratio", bare(ratio));
        object.field("quality_factor", bare(quality));
    }
    object.optional("limit", mode.limit.as_ref().map(|limit| string(&super::limit_words(limit, mode.kind))));
    object.optional("symmetry", mode.symmetry.as_deref().map(string));
    if options.vectors {
        let components = mode.vector.iter().enumerate().map(|(at, component)| {
            let real = number(*component);
            match mode.imaginary.get(at) {
                Some(imaginary) => format!("[{real}, {}]", number(*imaginary)),
                None => real,
            }
        });
        object.field("vector", array(components));
        object.field("vector_error_bound", bound(mode.vector_error_bound));
        let bounds = &mode.component_error_bounds;
        let all = || array(bounds.iter().copied().map(bound));
        object.optional("component_error_bounds", (!bounds.is_empty()).then(all));
    }
    if let Some(own) = &mode.uncertainty {
        let sigma = |own: Option<Ball>| own.map_or_else(null, |own| number(own.mid_f64()));
        object.field("omega_sigma", sigma(own.omega));
        object.optional("growth_sigma", (!mode.growth.is_zero()).then(|| sigma(own.growth)));
    }
    object.out.push_str(more);
    object.end()
}

/// Names and what is written behind them.
type Fields<'a> = Vec<(&'a str, String)>;

/// The derivation as a JSON object: `model`, `coordinates`, then what there is of `equilibrium`, `mass`,
/// `stiffness` (arrays of rows), `equations` and the other parts, as expressions in the model language.
///
/// A model without M and K has `not_linearized` in their place, the reason in words. Momenta are
/// called `p_` and the coordinate's name; displacements as the coordinates where the equilibrium
/// is 0, else `delta_` and the coordinate's name.
#[must_use]
pub fn derive_json(derivation: &Derivation) -> String {
    let texts = |texts: Vec<String>| lines(texts.iter().map(|text| string(text)));
    let names = &derivation.names.coordinates;
    let mut fields: Fields<'_> =
        vec![("model", model_and_version(derivation.model.as_deref())), ("coordinates", strings(names))];
    match &derivation.linear {
        Ok(linear) => linear_fields(derivation, linear, &mut fields),
        Err(error) => fields.push(("not_linearized", string(&error.to_string()))),
    }
    fields.extend(derivation.equations.is_some().then(|| ("equations", texts(derivation.equation_texts()))));
    if derivation.constraints.is_some() {
        let constraints = constraint_texts(derivation).into_iter().map(|(text, _)| string(&text));
        fields.push(("constraints", lines(constraints)));
        let names = derivation.constraints.iter().flat_map(|own| &own.names);
        fields.push(("constraint_multipliers", strings(names)));
    }
    if let Some(own) = &derivation.independent {
        fields.push(("independent_velocities", strings(independent_names(derivation, own))));
        let follows = follow_texts(derivation, own).into_iter().map(|(name, speed)| (name, string(&speed)));
        fields.push(("dependent_velocities", record(follows)));
        fields.push(("reduced_equations", texts(reduced_texts(derivation, own))));
    }
    let page = derivation.reduced();
    let linear = page.linear.as_ref().ok();
    if let Some(part) = linear.and_then(|own| own.second_order.as_ref()) {
        let form = |sum| string(&page.displaced_text(sum));
        fields.push(("linearized_equations", texts(page.linearized_texts())));
        if !part.kinetic.terms.is_empty() {
            fields.push(("kinetic_second_order", form(&part.kinetic)));
            fields.push(("potential_second_order", form(&part.potential)));
        }
    }
    if let Some(energy) = &derivation.energy {
        let text = |sum| string(&derivation.text(sum));
        let hamiltonian = energy.hamiltonian.as_ref();
        fields.push(("momenta", lines(energy.momenta.iter().map(text))));
        fields.push(("energy_function", text(&energy.function)));
        fields.push(("hamiltonian", hamiltonian.map_or_else(null, text)));
        let conserved = energy.conserved.iter().map(|quantity| {
            let (name, value) = match quantity {
                Conserved::Energy { .. } => ("h".to_owned(), text(&energy.function)),
                Conserved::Momentum(i) => {
                    (derivation.names.of(Motion::Momentum(*i)), energy.momenta.get(*i).map_or_else(null, text))
                }
                Conserved::Motion { momenta, value, .. } => (derivation.text(momenta), text(value)),
                Conserved::Integral { value, .. } => (derivation.text(value), text(value)),
            };
            let reason = string(&conserved_because(quantity, &derivation.names).replace('`', ""));
            record([("name", string(&name)), ("value", value), ("because", reason)])
        });
        fields.push(("conserved", lines(conserved)));
    }
    if let Some(found) = linear.and_then(|own| own.frequencies.as_ref()) {
        frequency_fields(page, found, &mut fields);
    }
    match linear.filter(|own| own.exponents.is_some()) {
        Some(linear) => exponent_fields((page, derivation), linear, &mut fields),
        None => fields.extend([("characteristic", null()), ("exponents", "[]".to_owned()), ("stability", null())]),
    }
    if let Some(roots) = &derivation.equilibria {
        let roots = roots.iter().map(|root| {
            let condition = root.condition.as_ref();
            let taken = condition.map_or_else(Vec::new, |own| signs(derivation, &own.signs));
            record([
                ("coordinate", names.get(root.coordinate).map_or_else(null, |name| string(name))),
                ("left", expression(derivation, root.left)),
                ("value", expression(derivation, root.value)),
                ("if", condition.map_or_else(null, |own| string(&condition_text(derivation, own)))),
                ("if_signs", strings(taken)),
            ])
        });
        fields.push(("force_vanishes", lines(roots)));
    }
    fields.extend(derivation.left_out.as_ref().map(|own| ("left_out", string(&left_out(own).message))));
    let shown = fields.iter().filter(|(name, _)| chapter(name).is_none_or(|own| derivation.shows(own)));
    let fields = shown.map(|(name, value)| format!("\"{name}\": {value}"));
    format!("{{{}}}\n", fields.collect::<Vec<_>>().join(",\n "))
}

/// The chapter of a page that has what a field has; `None` of what all pages have.
fn chapter(field: &str) -> Option<&str> {
    match field.strip_prefix("reduced_").unwrap_or(field) {
        "model" | "coordinates" | "assumptions" | "signs" | "not_linearized" | "left_out" => None,
        "rates" => Some("equilibrium"),
        "multipliers" | "constraint_multipliers" | "constraint_gradients" | "free_coordinates" | "directions" => {
            Some("constraints")
        }
        "independent_velocities" | "dependent_velocities" => Some("equations"),
        "linearized_equations" | "kinetic_second_order" | "potential_second_order" => Some("linearized"),
        "energy_function" => Some("hamiltonian"),
        "force_vanishes" => Some("equilibria"),
        "exponents_complete" | "exponents_equal" => Some("exponents"),
        "stability_sufficient" => Some("stability"),
        own if CHAPTERS.contains(&own) => Some(own),
        _ => Some("frequencies"),
    }
}

/// The equilibrium and the matrices there.
fn linear_fields(derivation: &Derivation, linear: &Linear, fields: &mut Fields<'_>) {
    let assumptions = || ("assumptions", strings(assumption_texts(derivation)));
    fields.extend((!derivation.assumptions.is_empty()).then(assumptions));
    fields.push(("equilibrium", expressions(derivation, &linear.equilibrium)));
    if !derivation.rates.is_empty() {
        let rates = derivation.rates.iter().map(|(name, rate)| (name, expression(derivation, *rate)));
        fields.push(("rates", record(rates)));
    }
    matrix_fields(derivation, linear, &MATRICES, fields);
    if let Some(tangent) = &linear.tangent {
        tangent_fields(derivation, tangent, fields);
    }
}

/// What M, K, G, C, N and what is assumed for them are called, and those of the motions that constraints allow.
const MATRICES: [&str; 6] = ["mass", "stiffness", "gyroscopic", "damping", "circulatory", "signs"];
const REDUCED: [&str; 6] = [
    "reduced_mass",
    "reduced_stiffness",
    "reduced_gyroscopic",
    "reduced_damping",
    "reduced_circulatory",
    "reduced_signs",
];

fn matrix_fields(derivation: &Derivation, linear: &Linear, names: &[&'static str; 6], fields: &mut Fields<'_>) {
    let others = [&linear.gyroscopic, &linear.damping, &linear.circulatory].map(Option::as_ref);
    let all = [Some(&linear.mass), Some(&linear.stiffness)].into_iter().chain(others);
    let all = names.iter().zip(all).filter_map(|(name, rows)| Some((*name, matrix(derivation, rows?))));
    fields.extend(all);
    let taken = signs(derivation, &linear.signs);
    fields.extend((!taken.is_empty()).then(|| (names[5], strings(taken))));
}

fn matrix(derivation: &Derivation, rows: &[Vec<ExprId>]) -> String {
    lines(rows.iter().map(|row| expressions(derivation, row)))
}

/// Multipliers, gradients of the constraints, and the matrices of the motions that these allow, or that massless coordinates follow.
fn tangent_fields(derivation: &Derivation, tangent: &Tangent, fields: &mut Fields<'_>) {
    if tangent.massless.is_empty() {
        let multipliers = multipliers(derivation, tangent).map(|(name, value)| (name, string(&value)));
        fields.push(("multipliers", record(multipliers)));
        fields.push(("constraint_gradients", matrix(derivation, &tangent.gradients)));
    }
    let Some(reduced) = &tangent.reduced else { return };
    let page = &*reduced.derivation;
    fields.push(("free_coordinates", strings(&page.names.coordinates)));
    fields.push(("directions", matrix(derivation, &reduced.directions)));
    if let Ok(linear) = &page.linear {
        matrix_fields(page, linear, &REDUCED, fields);
    }
}

/// `characteristic`, `exponents`, `stability`, and `frequencies` where velocities or forces matter but nothing is damped.
fn exponent_fields((page, whole): (&Derivation, &Derivation), linear: &Linear, fields: &mut Fields<'_>) {
    let Some(found) = &linear.exponents else { return };
    let characteristic = found.characteristic.as_ref();
    fields.push(("characteristic", characteristic.map_or_else(null, |all| expressions(page, all))));
    let own_pool = &mut page.pool.clone();
    let exponents = found.exponents.iter().map(|own| {
        let mut entry = Object::new(", ");
        entry.field("exponent", string(&exponent_text(own_pool, own, &imaginary_unit(whole))));
        entry.field("multiplicity", own.multiplicity);
        entry.optional("damping_ratio", own.damping_ratio.map(|own| expression(page, own)));
        entry.end()
    });
    fields.push(("exponents", lines(exponents)));
    fields.push(("exponents_complete", found.complete.to_string()));
    // They are those of the frequencies, where these have closed forms.
    let case = linear.frequencies.as_ref().map(Frequencies::best).filter(|case| !case.frequencies.is_empty());
    let is_open = case.is_none();
    let tied = case.filter(|case| !case.ties.is_empty());
    fields.extend(tied.map(|case| ("exponents_equal", array(case.ties.iter().map(strings)))));
    let conditions = || found.stability.as_ref().map(|all| all.iter().map(|own| own.positive).collect::<Vec<_>>());
    let conditions = found.stability_exact.clone().or_else(conditions);
    fields.push(("stability", conditions.map_or_else(null, |all| expressions(page, &all))));
    let is_sufficient = found.stability.iter().flatten().any(|own| own.role == Role::Sufficient);
    let is_sufficient = is_sufficient && found.stability_exact.is_none();
    fields.extend(is_sufficient.then(|| ("stability_sufficient", true.to_string())));
    // With rotation and forces together exponents are no pairs ±s.
    let paired = linear.gyroscopic.is_none() || linear.circulatory.is_none();
    let is_open = is_open && linear.damping.is_none() && paired;
    let squares = if is_open { found.squares_of_frequencies(&mut page.pool.clone()) } else { Vec::new() };
    if is_open && (linear.frequencies.is_none() || !squares.is_empty()) {
        let count: usize = squares.iter().map(|(_, multiplicity)| multiplicity).sum();
        // There are fewer than coordinates where some have no inertia.
        let all = characteristic.map_or(2 * linear.mass.len(), |all| all.len() - 1);
        fields.push(("frequencies_complete", (found.complete && 2 * count == all).to_string()));
        let squares = squares.iter().map(|(text, multiplicity)| {
            format!("{{\"omega_squared\": {}, \"multiplicity\": {multiplicity}}}", string(text))
        });
        fields.push(("frequencies", lines(squares)));
    }
}

/// `symmetry`, `frequencies` and what they need.
fn frequency_fields(derivation: &Derivation, found: &Frequencies, fields: &mut Fields<'_>) {
    let sets = |sets: &[Vec<String>]| array(sets.iter().map(strings));
    let case = found.best();
    let names = &derivation.names.displacements;
    let symmetry = |found: &Exchange| {
        let exchanges = found.generators.iter().map(|g| string(&exchange(g, names)));
        record([("kind", string(&kind(&found.kind))), ("exchanges", array(exchanges)), ("equal", sets(&found.ties))])
    };
    fields.extend(found.point_group.as_ref().map(|group| ("point_group", string(group))));
    fields.extend(case.symmetry.as_ref().map(|found| ("symmetry", symmetry(found))));
    fields.extend(found.would_be.as_ref().map(|found| ("symmetry_if_equal", symmetry(found))));
    if !case.blocks.is_empty() {
        let matrix = |rows: &[Vec<ExprId>]| array(rows.iter().map(|row| expressions(derivation, row)));
        let blocks = case.blocks.iter().map(|block| {
            let vectors = block.basis.iter().map(|vector| {
                let component = |i: usize| vector.iter().find(|(at, _)| *at == i).map_or(0, |(_, value)| *value);
                array((0..names.len()).map(|i| component(i).to_string()))
            });
            record([
                ("symmetry", string(&block.class)),
                ("vectors", array(vectors)),
                ("mass", matrix(&block.mass)),
                ("stiffness", matrix(&block.stiffness)),
            ])
        });
        fields.push(("blocks", lines(blocks)));
    }
    if case.frequencies.is_empty() {
        return;
    }
    let entries = case.frequencies.iter().map(|frequency| {
        let mut entry = Object::new(", ");
        entry.field("omega_squared", expression(derivation, frequency.omega_squared));
        entry.field("multiplicity", frequency.multiplicity);
        let class = frequency.symmetry.as_ref().or(frequency.symmetry_at_values.as_ref());
        entry.optional("symmetry", class.map(|own| string(own)));
        entry.end()
    });
    fields.push(("frequencies", lines(entries)));
    fields.push(("frequencies_complete", case.complete.to_string()));
    fields.push(("frequencies_equal", sets(&case.ties)));
    let taken = signs(derivation, &found.signs);
    fields.extend((!taken.is_empty()).then(|| ("frequencies_signs", strings(taken))));
    fields.extend(case.normal.as_ref().map(|own| ("normal_coordinates", normal_modes(derivation, own))));
    if !case.waves.is_empty() {
        let waves = case.waves.iter().map(|waves| normal_waves(derivation, waves));
        fields.push(("normal_waves", lines(waves)));
    }
}

/// One entry a mode, everything written out.
fn normal_modes(derivation: &Derivation, normal: &NormalCoordinates) -> String {
    let modes = normal.modes.iter().enumerate().map(|(r, mode)| {
        let mut entry = Object::new(", ");
        entry.field("name", string(&derivation.names.of(Motion::Normal(r))));
        entry.field("omega_squared", expression(derivation, mode.omega_squared));
        entry.field("amplitudes", expressions(derivation, &mode.amplitudes));
        entry.optional("omega", mode.omega.as_ref().map(|omega| expression(derivation, *omega)));
        entry.optional("symmetry", mode.symmetry.as_deref().map(string));
        entry.end()
    });
    lines(modes)
}

/// The normal coordinates of a chain, ring or net.
fn normal_waves(derivation: &Derivation, waves: &NormalWaves) -> String {
    let names = &derivation.names.displacements;
    let order = waves.order.iter().filter_map(|i| names.get(*i));
    let places = waves.places.iter().map(|(name, last)| (name, format!("[1, {last}]")));
    let sums = waves.sums.iter().map(|sum| {
        let numbers = sum.numbers.iter().map(|own| (&own.name, format!("[{}, {}]", own.first, own.last)));
        let [factor, shape] = [sum.factor, sum.shape].map(|at| expression(derivation, at));
        record([("numbers", record(numbers)), ("factor", factor), ("shape", shape)])
    });
    record([
        ("name", string(&waves.normal)),
        ("order", strings(order)),
        ("places", record(places)),
        ("sums", array(sums)),
    ])
}

fn expression(derivation: &Derivation, at: ExprId) -> String {
    string(&derivation.pool.display(at))
}

fn expressions(derivation: &Derivation, all: &[ExprId]) -> String {
    array(all.iter().map(|at| expression(derivation, *at)))
}

/// An object on its way, with some text between its fields.
pub(super) struct Object {
    out: String,
    between: &'static str,
}

impl Object {
    pub(super) fn new(between: &'static str) -> Self {
        Self { out: "{".to_owned(), between }
    }

    /// With the name of a model, which librate has answered, and the names of the coordinates.
    pub(super) fn of_model(model: &Model) -> Self {
        let mut object = Self::new(",\n ");
        object.field("model", model_and_version(model.name.as_deref()));
        object.field("coordinates", strings(model.coordinates.names()));
        object
    }

    /// The text behind the name of a field, to which its value is to be added.
    fn begin(&mut self, name: &str) -> &mut String {
        if self.out.len() > 1 {
            self.out.push_str(self.between);
        }
        let _ = write!(self.out, "\"{name}\": ");
        &mut self.out
    }

    pub(super) fn field(&mut self, name: &str, value: impl Display) {
        let _ = write!(self.begin(name), "{value}");
    }

    /// A number with its digits and the bounds of both.
    pub(super) fn certified(&mut self, name: &str, value: &Ball, written: &Written) {
        self.field(name, number(value.mid_f64()));
        self.field(&format!("{name}_digits"), written.json());
        self.field("error_bound", error_bound(value));
        self.field("digits_error_bound", number(written.bound));
    }

    /// A field that is left out where there is no value.
    pub(super) fn optional(&mut self, name: &str, value: Option<impl Display>) {
        if let Some(value) = value {
            self.field(name, value);
        }
    }

    /// An array, one item a line, each written before the next is made.
    pub(super) fn lines(&mut self, name: &str, items: impl Iterator<Item = String>) {
        let out = self.begin(name);
        out.push('[');
        for (at, item) in items.enumerate() {
            out.push_str(if at == 0 { "\n  " } else { ",\n  " });
            out.push_str(&item);
        }
        out.push(']');
    }

    pub(super) fn end(self) -> String {
        self.out + "}"
    }
}

/// An object on one line, of names and values.
pub(super) fn record(fields: impl IntoIterator<Item = (impl AsRef<str>, String)>) -> String {
    let fields = fields.into_iter().map(|(name, value)| format!("{}: {value}", string(name.as_ref())));
    format!("{{{}}}", fields.collect::<Vec<_>>().join(", "))
}

/// An array, one item a line.
pub(super) fn lines(items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.map(|item| format!("\n  {item}")).collect();
    format!("[{}]", items.join(","))
}

pub(super) fn null() -> String {
    "null".to_owned()
}

/// The shortest digits that give the same double; JSON has no infinities.
pub(super) fn number(value: f64) -> String {
    if value.is_finite() {
        // Adding zero turns -0 into 0.
        format!("{:?}", value + 0.0)
    } else {
        null()
    }
}

/// The name of a model as the value of `model`, and behind it which librate has answered.
pub(super) fn model_and_version(name: Option<&str>) -> String {
    format!("{},\n \"librate\": \"{}\"", name.map_or_else(null, string), env!("CARGO_PKG_VERSION"))
}

pub(super) fn string(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// An array of strings.
pub(super) fn strings(texts: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    array(texts.into_iter().map(|text| string(text.as_ref())))
}

/// Numbers known to some digits, as doubles.
pub(super) fn middles<'a>(values: impl IntoIterator<Item = &'a Ball>) -> String {
    array(values.into_iter().map(|value| number(value.mid_f64())))
}

/// A bound of an error.
pub(super) fn bound(size: f64) -> String {
    number(one_digit_up(size))
}

/// That of the double for a number.
pub(super) fn error_bound(value: &Ball) -> String {
    bound(value.mid_f64_error())
}

pub(super) fn array(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}
