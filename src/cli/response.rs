//! `librate response`.

use clap::Args;
use librate::diagnostic::Diagnostic;
use librate::model::Range;
use librate::refine;
use librate::report::{self, ResponseLines};
use librate::response::{Peaks, Request, ResponseError, Study, Value};

use super::args::{DOUBLE_DOUBLE_DIGITS, ModelArgs, digits, positive, shown};
use super::threads::{all, in_order};
use super::{Answer, Failure, Loaded, Size, failed, load_values, wrong_request};

const WHAT: &str = "computing the response over the range";

/// So many frequencies are worked on at a time.
const BLOCK: usize = 64;

#[derive(Debug, Args)]
#[command(mut_arg("verbose", shown))]
pub(crate) struct ResponseArgs {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The coordinate on which a force of unit amplitude acts: `x[1]`; without it the model's own drive
    #[arg(long, value_name = "COORDINATE")]
    pub(crate) input: Option<String>,
    /// A coordinate whose response is wanted, or several with commas; may be repeated, all without it
    #[arg(long = "output", value_name = "COORDINATE")]
    pub(crate) outputs: Vec<String>,
    /// The angular frequencies in rad/s, or the values of the parameter in the drive's: first, last and how many
    #[arg(long, value_name = "NAME=a..b:count")]
    pub(crate) over: String,
    /// The maxima and minima of each amplitude in place of its values; the range needs no count
    #[arg(long)]
    pub(crate) peaks: bool,
    /// Significant digits, up to 30
    #[arg(long, value_name = "D", default_value = "10", value_parser = digits::<DOUBLE_DOUBLE_DIGITS>)]
    pub(crate) digits: usize,
    /// Threads; by default as many as there are cores
    #[arg(long, value_name = "COUNT", value_parser = positive)]
    pub(crate) threads: Option<usize>,
    /// JSON instead of CSV, with bounds
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn text(args: &ResponseArgs) -> Result<Answer, Failure> {
    let help = match args.input {
        Some(_) => "write `--over omega=a..b:count`, for example `--over omega=0..20:201`",
        None => "write `--over NAME=a..b:count` with the parameter in the frequency of the drive: `--over W=0..20:201`",
    };
    let range = if args.peaks && !args.model.drawn { Range::parse_ends(&args.over) } else { Range::parse(&args.over) };
    let range = range.map_err(|error| wrong_request(error.to_string(), help))?;
    if args.input.is_some() && range.name() != "omega" {
        let message = format!("the frequency of a force given with --input is `omega`, not `{}`", range.name());
        return Err(wrong_request(message, help));
    }
    let Loaded { source, made, model, mut warnings } = load_values(&args.model, Size::Any)?;
    let request = Request { input: args.input.clone(), outputs: args.outputs.clone(), range, digits: args.digits };
    let fails = |error: ResponseError, warnings: &[Diagnostic]| failed(&source, warnings, error);
    let study = Study::new(model, made, request).map_err(|error| fails(error, &warnings))?;
    let mut peaks: Vec<Peaks> = Vec::new();
    if args.peaks {
        let worker = || |output| study.peaks(output);
        let found = all(args.threads, study.outputs(), "looking for peaks", worker, || Ok(()))?;
        peaks = found.into_iter().collect::<Result<_, _>>().map_err(|error| fails(error, &warnings))?;
        warnings.extend(peaks.iter().filter_map(|own| own.remark(args.over.split('=').next().unwrap_or_default())));
    }
    let mut response = study.response([]);
    let mut table = report::response_header(&response);
    if args.model.drawn {
        let all = drawn(args, study, |error| fails(error, &warnings))?;
        all.into_iter().for_each(|(place, values)| response.push(place, values));
    } else if !args.peaks {
        let count = study.len();
        let block = |block: usize| {
            let places = block * BLOCK..count.min((block + 1) * BLOCK);
            if !args.json {
                return report::response_lines(&study, places, args.digits);
            }
            let remarkable = places.clone().map(|at| study.place(at)).zip(study.all_values(places)?).collect();
            Ok(ResponseLines { remarkable, ..Default::default() })
        };
        let blocks = count.div_ceil(BLOCK);
        in_order(
            args.threads,
            blocks,
            WHAT,
            || block,
            |found| {
                let found = found.map_err(|error| fails(error, &warnings))?;
                table.push_str(&found.text);
                found.remarkable.into_iter().for_each(|(place, values)| response.push(place, values));
                Ok(())
            },
        )?;
    }
    warnings.extend(response.remarks());
    let text = match (args.model.drawn, args.peaks, args.json) {
        (true, ..) => report::response_svg(&response, &peaks),
        (false, true, true) => report::peaks_json(&response, &peaks),
        (false, true, false) => report::peaks_csv(&response, &peaks, args.digits),
        (false, false, true) => report::response_json(&response),
        (false, false, false) => table,
    };
    Ok(Answer::new(text, Some((source, warnings))))
}

/// With places between where curves bend.
fn drawn(
    args: &ResponseArgs,
    study: Study,
    fails: impl Fn(ResponseError) -> Failure,
) -> Result<Vec<(f64, Vec<Value>)>, Failure> {
    let (count, (finest, step)) = (study.len(), refine::finest(study.range()));
    let study = study.over(finest);
    // Logarithms, so that flanks of peaks are as smooth as what is low.
    let row = |(_, values): &(f64, Vec<Value>)| {
        let shown = values.iter().take(report::MOST_RESPONSES);
        shown.flat_map(|own| [own.amplitude().ln(), own.phase()]).collect()
    };
    let found = refine::refined(count, step, row, |places| {
        let worker = || {
            |at: usize| {
                let mut values = study.all_values(places[at]..places[at] + 1)?;
                Ok::<_, ResponseError>((study.place(places[at]), values.pop().unwrap_or_default()))
            }
        };
        let found = all(args.threads, places.len(), WHAT, worker, || Ok(()))?;
        found.into_iter().map(|own| own.map_err(&fails)).collect::<Result<Vec<_>, _>>()
    });
    // Curves go to the right.
    found.map(|mut found| {
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    })
}
