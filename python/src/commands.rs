//! The commands about one equilibrium, each as the command line has it.

use std::io;

use librate::derive::{self, Parts};
use librate::diagnostic::Diagnostic;
use librate::equilibria::{self, Region};
use librate::grid::Nodes;
use librate::linearize::{self, Linearized};
use librate::model::{self, Constant, Range};
use librate::modes::Options;
use librate::oscillation::{self, NormalModes};
use librate::report::{self, FrequencyUnit, Language, Shown as ShownPage, Style};
use librate::{amplitude, code, figure, inertia, sensitivity};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::answers::{Answer, Derivation, MOST_DIGITS, Modes, Shown, digits, doubles, positive};
use crate::job::{Failure, Job, Model, Size, cores, in_parallel, range};

/// Shapes to fewer digits would cost digits of the change of a frequency with the amplitude.
const SHAPE_DIGITS: usize = 14;

/// Text of two kinds.
pub(crate) struct Written {
    pub(crate) json: String,
    pub(crate) text: String,
}

impl Written {
    /// Without JSON: a picture, or code.
    pub(crate) fn drawn(text: String) -> Self {
        Self { json: String::new(), text }
    }
}

impl Model {
    /// What is written of a model.
    pub(crate) fn answer(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Job) -> Result<Written, Failure> + Send + 'static,
    ) -> PyResult<Answer> {
        let (Written { json, text }, warnings) = self.run(py, work)?;
        Ok(Answer { json, text, warnings })
    }
}

/// What is in a model.
#[derive(IntoPyObject)]
pub(crate) struct Content {
    name: Option<String>,
    coordinates: Vec<String>,
    parameters: Vec<Parameter>,
    driven: bool,
    warnings: Shown,
}

/// A parameter and its value in SI, where it has one.
#[derive(IntoPyObject)]
struct Parameter {
    name: String,
    value: Option<f64>,
}

/// Checks a model. One of which only the tensors can be worked out will do where `tensors` says so.
#[pyfunction]
pub(crate) fn check(py: Python<'_>, model: &Model, tensors: bool) -> PyResult<Content> {
    let (content, warnings) = model.run(py, move |job| {
        let model = job.model(Size::Any).or_else(|error| {
            let source = &job.source;
            let other = model::elaborate(&source.file, &source.tables, &job.settings.clone().only_tensors());
            other.ok().filter(|model| tensors && !model.tensors.is_empty()).ok_or(error)
        })?;
        let parameters = model.parameters.iter().map(|own| Parameter {
            name: own.name.clone(),
            value: own.value.and_then(|value| linearize::constant(&model.pool, value)).map(|ball| ball.mid_f64()),
        });
        let parameters = parameters.collect();
        Ok(Content {
            parameters,
            driven: model.time_dependent.is_some(),
            coordinates: model.coordinates.names().collect(),
            name: model.name,
            warnings: Shown::default(),
        })
    })?;
    Ok(Content { warnings, ..content })
}

/// What is wanted of the modes.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ModesArgs {
    digits: i64,
    lowest: Option<i64>,
    near: Option<f64>,
    count: Option<i64>,
    certify: Option<Vec<u8>>,
    vectors: bool,
    normalize: String,
    unit: Option<String>,
    threads: Option<i64>,
}

impl ModesArgs {
    fn options(&self, job: &Job) -> Result<Options, Failure> {
        let mut options = options(self.digits, self.lowest)?;
        options.near = match (self.near, positive("count", self.count)?) {
            (Some(omega), Some(count)) if (0.0..1e150).contains(&omega) => Some((omega, count)),
            (None, None) => None,
            _ => {
                let help = "a frequency in rad/s, 0 or more, and how many: `near=10.0, count=3`";
                return Err(Failure::request("`near` and `count` can't be read", help));
            }
        };
        options.given = self.certify.as_deref().map(|bytes| doubles(bytes).collect());
        options.vectors = self.vectors;
        options.threads = positive("threads", self.threads)?.unwrap_or_else(cores);
        let ways = usize::from(options.lowest.is_some()) + usize::from(options.near.is_some());
        if ways + usize::from(options.given.is_some()) > 1 {
            let help = "leave out all but one of them";
            return Err(Failure::request("`lowest`, `near` and `certify` exclude each other", help));
        }
        if let Some(given) = &options.given {
            let count = model::coordinate_count(&job.source.file, &job.source.tables, &job.settings);
            if given.is_empty() || given.len() % count.max(1) != 0 {
                let message = format!("vectors to certify need {count} components, one a coordinate");
                return Err(Failure::request(message, "one vector a row, as `modes().vectors` has them"));
            }
        }
        Ok(options)
    }

    fn unit(&self) -> Result<Option<FrequencyUnit>, Failure> {
        let Some(name) = &self.unit else { return Ok(None) };
        let found = FrequencyUnit::ALL.into_iter().find(|unit| unit.as_str() == name);
        let names = FrequencyUnit::ALL.map(FrequencyUnit::as_str).join(", ");
        found.map(Some).ok_or_else(|| Failure::request(format!("frequencies have no unit `{name}`"), &names))
    }
}

/// What is wanted of modes with shapes: so many digits, all of them or the lowest.
pub(crate) fn options(digits_wanted: i64, lowest: Option<i64>) -> Result<Options, Failure> {
    let mut options = Options::default().digits(digits(digits_wanted, MOST_DIGITS)?);
    options.lowest = positive("lowest", lowest)?;
    Ok(options)
}

/// A model about its equilibrium, its modes, and what is suspicious in them.
fn solved(job: &mut Job, model: model::Model, options: &Options) -> Result<(Linearized, NormalModes), Failure> {
    let linearized = derive::linearized(model)?;
    let modes = oscillation::normal_modes(&linearized, options)?;
    job.warnings.extend(modes.warnings(&linearized));
    Ok((linearized, modes))
}

fn modes_of(job: &mut Job, args: &ModesArgs) -> Result<Modes, Failure> {
    let (options, unit) = (args.options(job)?, args.unit()?);
    let few = options.lowest.is_some() || options.near.is_some() || options.given.is_some();
    let model = job.model(if few { Size::Any } else { Size::Dense })?;
    let (linearized, mut modes) = solved(job, model, &options)?;
    sensitivity::put_uncertainties(&linearized, &mut modes, &options)?;
    match args.normalize.as_str() {
        "mass" => {}
        "max" => modes = modes.with_largest_component_one(),
        other => return Err(Failure::request(format!("shapes have no length `{other}`"), "`mass` or `max`")),
    }
    Ok(Modes { linearized, modes, options, unit })
}

/// Modes and warnings.
#[pyfunction]
pub(crate) fn modes(py: Python<'_>, model: &Model, args: ModesArgs) -> PyResult<(Modes, Shown)> {
    model.run(py, move |job| modes_of(job, &args))
}

/// The shapes as SVG, or the frequencies alone.
#[pyfunction]
pub(crate) fn plot_modes(py: Python<'_>, model: &Model, args: ModesArgs, spectrum: bool) -> PyResult<Answer> {
    model.answer(py, move |job| {
        job.settings = job.settings.clone().with_points();
        let Modes { linearized, modes, .. } = modes_of(job, &args)?;
        let picture = if spectrum { report::spectrum_svg } else { report::modes_svg };
        Ok(Written::drawn(picture(&linearized, &modes)))
    })
}

/// A page with the modes in motion.
#[pyfunction]
pub(crate) fn show(
    py: Python<'_>,
    model: &Model,
    digits_wanted: i64,
    lowest: Option<i64>,
    over: Vec<String>,
) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let help = "write `over=\"k=1..4:9\"` or `over={\"k\": (1, 4, 9)}`, of one or two parameters";
        let ranges: Vec<Range> = over.iter().map(|text| range(text, help)).collect::<Result<_, _>>()?;
        job.settings = job.settings.clone().with_points();
        let options = options(digits_wanted, lowest)?;
        let model = job.model(if lowest.is_some() { Size::Any } else { Size::Dense })?;
        let shown = options.lowest.unwrap_or(model.coordinates.len());
        if shown > report::MOST_MODES {
            let help = format!("choose some: `lowest=20`; a page has room for {}", report::MOST_MODES);
            return Err(Failure::request(format!("{shown} modes are too many for a page"), &help));
        }
        let nodes = (!ranges.is_empty()).then(|| Nodes::new(&job.made_from(), &model, &ranges, &options));
        let nodes = nodes.transpose();
        let nodes =
            nodes.map_err(|error| Failure::request(error.to_string(), error.help().as_deref().unwrap_or(help)))?;
        // A derivation may fail where there are modes, and is left out then.
        let derivation = derive::derive(&model, &Parts::all()).ok();
        let (linearized, modes) = solved(job, model, &options)?;
        let grid = match nodes {
            Some(nodes) => {
                let places = in_parallel(job, None, nodes.count(), || |at: usize| nodes.place(at))?;
                Some(nodes.followed(&places, (&linearized, &modes)))
            }
            None => None,
        };
        let figure = grid.as_ref().map_or_else(|| figure::figure(&linearized, &[]), |grid| grid.figure.clone());
        let text = report::show_html(&ShownPage {
            text: &job.source.page.text,
            linearized: &linearized,
            modes: &modes,
            options: &options,
            figure: figure.as_ref(),
            derivation: derivation.as_ref(),
            grid: grid.as_ref(),
        });
        Ok(Written::drawn(text))
    })
}

/// What is wanted of a derivation.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct DeriveArgs {
    cubic: bool,
    quartic: bool,
    limit: Vec<(String, String)>,
    expand: Option<(String, u32)>,
    only: Option<Vec<String>>,
}

impl DeriveArgs {
    /// The parameters that are named must be there.
    fn check(&self, model: &model::Model) -> Result<(), Failure> {
        let names = self.limit.iter().map(|(name, _)| name).chain(self.expand.as_ref().map(|(name, _)| name));
        for name in names {
            let found = model.parameters.iter().find(|own| own.name == *name);
            if !found.is_some_and(|own| own.is_symbol(&model.pool)) {
                let what = match found {
                    Some(_) => format!("`{name}` is not in the formulas: what it is defined as is written out there"),
                    None => format!("there is no parameter `{name}`"),
                };
                return Err(Failure::request(what, "`limit` and `expand` are about parameters of the model"));
            }
        }
        for chapter in self.only.iter().flatten() {
            if !derive::CHAPTERS.contains(&chapter.as_str()) {
                return Err(Failure::request(
                    format!("a derivation has no chapter `{chapter}`"),
                    &derive::CHAPTERS.join(", "),
                ));
            }
        }
        Ok(())
    }
}

/// A derivation and warnings.
#[pyfunction]
pub(crate) fn derivation(py: Python<'_>, model: &Model, args: DeriveArgs) -> PyResult<(Derivation, Shown)> {
    model.run(py, move |job| {
        let model = job.model(Size::Any)?;
        args.check(&model)?;
        let parts = Parts::all().cubic(args.cubic).quartic(args.quartic).numbers(args.limit.is_empty());
        let mut derivation = derive::derive(&model, &parts)?;
        for (name, value) in &args.limit {
            let Some(parameter) = model.parameters.iter().find(|own| own.name == *name) else { continue };
            let number = Constant::of_parameter(value, parameter, &model.pool)
                .map_err(|_| Failure::request(format!("`{value}` is not a number"), "`limit={'k': 0}`"))?;
            derivation.limit(name, number);
        }
        if let Some((name, order)) = &args.expand {
            derivation.expand(name, *order);
        }
        derivation.only.clone_from(&args.only);
        derivation.put_given(&job.source.file, &job.settings, &model);
        Ok(Derivation { derivation })
    })
}

/// How frequencies change with parameters.
#[pyfunction]
pub(crate) fn sensitivities(
    py: Python<'_>,
    model: &Model,
    digits_wanted: i64,
    lowest: Option<i64>,
) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let options = options(digits_wanted, lowest)?;
        let model = job.model(Size::Dense)?;
        let (linearized, mut modes) = solved(job, model, &options)?;
        let found = sensitivity::sensitivities(&linearized, &modes);
        found.put_uncertainties(&linearized, &mut modes);
        Ok(Written {
            json: report::sensitivity_json(&linearized, &modes, &found, &options),
            text: report::sensitivity_text(&linearized, &modes, &found, &options, &Style::default()),
        })
    })
}

/// How frequencies begin to change with the amplitude.
#[pyfunction]
pub(crate) fn amplitudes(py: Python<'_>, model: &Model, digits_wanted: i64) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let digits = digits(digits_wanted, MOST_DIGITS)?;
        let options = Options::default().digits(digits.max(SHAPE_DIGITS));
        let model = job.values(Size::Dense)?;
        amplitude::check(&model)?;
        let (linearized, modes) = solved(job, model, &options)?;
        let found = amplitude::amplitude(&linearized, &modes)?;
        Ok(Written {
            json: report::amplitude_json(&linearized, &modes, &found, digits),
            text: report::amplitude_text(&linearized, &modes, &found, digits, &Style::default()),
        })
    })
}

/// What is wanted of the equilibria in a box.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct EquilibriaArgs {
    region: String,
    over: Option<String>,
    svg: bool,
}

/// Every equilibrium in a box, or branches of them over a parameter.
#[pyfunction]
pub(crate) fn all_equilibria(py: Python<'_>, model: &Model, args: EquilibriaArgs) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let over = args.over.as_deref().map(|text| range(text, "write `over={\"P\": (0, 1, 101)}`")).transpose()?;
        let model = job.values(Size::Any)?;
        let region = Region::parse(&args.region, &model)?;
        let style = Style::default();
        let (written, reasons) = if let Some(over) = over {
            let found = equilibria::follow(&job.made_from(), &region, &over)?;
            let written = if args.svg {
                Written::drawn(report::diagram_svg(&model, &found))
            } else {
                let text = report::diagram_text(&model, &found, &style);
                Written { json: report::diagram_json(&model, &found), text }
            };
            (written, found.reasons)
        } else {
            let found = equilibria::find(&model, &region)?;
            let written = if args.svg {
                let landscape = equilibria::landscape(&model, &region)?;
                Written::drawn(report::equilibria_svg(&model, &found, &landscape))
            } else {
                let text = report::equilibria_text(&model, &found, &style);
                Written { json: report::equilibria_json(&model, &found), text }
            };
            (written, found.reasons)
        };
        job.warnings.extend(reasons.iter().map(Diagnostic::remark));
        Ok(written)
    })
}

/// Principal moments and axes of the tensors of a model.
#[pyfunction]
pub(crate) fn tensors(py: Python<'_>, model: &Model, digits_wanted: i64) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let digits = digits(digits_wanted, MOST_DIGITS)?;
        let source = &job.source;
        let model = model::elaborate(&source.file, &source.tables, &job.settings.clone().only_tensors())?;
        let tensors = inertia::of_model(&model, digits)?;
        let warnings = tensors.iter().filter_map(inertia::NamedTensor::warning);
        job.warnings.extend(warnings);
        job.warnings.extend(sensitivity::ignored(&model));
        let name = model.name.as_deref();
        Ok(Written {
            json: report::tensors_json(name, &tensors, digits),
            text: report::tensors_text(name, &tensors, digits, &Style::default()),
        })
    })
}

/// M, K and what there is of G, C and N, as an archive of NumPy.
#[pyfunction]
pub(crate) fn archive<'py>(py: Python<'py>, model: &Model) -> PyResult<(Bound<'py, PyBytes>, Shown)> {
    let (bytes, warnings) = model.run(py, |job| {
        let model = job.values(Size::Any)?;
        let linearized = derive::linearized(model)?;
        let matrices = report::matrices(&linearized).map_err(|error| match linearized.not_finite() {
            Some(undefined) => Failure::from(undefined),
            None => Failure(vec![Diagnostic::global(error.to_string())]),
        })?;
        let mut bytes = Vec::new();
        let written = report::write_npz(&matrices, &mut bytes);
        written.map_err(|error: io::Error| Failure(vec![Diagnostic::global(error.to_string())]))?;
        Ok(bytes)
    })?;
    Ok((PyBytes::new(py, &bytes), warnings))
}

/// A model as source code in C, Rust or Python.
#[pyfunction]
pub(crate) fn source_code(py: Python<'_>, model: &Model, language: String) -> PyResult<Answer> {
    model.answer(py, move |job| {
        let language = match language.as_str() {
            "c" => Language::C,
            "rust" => Language::Rust,
            "python" => Language::Python,
            other => return Err(Failure::request(format!("there is no code in `{other}`"), "`c`, `rust` or `python`")),
        };
        let compiled = code::code(&job.model(Size::Any)?)?;
        Ok(Written::drawn(report::code_text(&compiled, language, None)))
    })
}
