//! `librate show`: a page with the modes in motion.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use librate::derive::{self, Parts};
use librate::diagnostic::Diagnostic;
use librate::grid::{Grid, Nodes};
use librate::linearize::Linearized;
use librate::model::{Model, Range};
use librate::oscillation::NormalModes;
use librate::report::{self, Shown, Style};
use librate::{figure, modes};

use super::input::Source;
use super::output::{visible, write_file};
use super::threads::all;
use super::{Answer, Failure, Loaded, Made, Size, args, during, failed, load, range, solved, wrong_request};
use serde_json::Value;

/// Loads the page again once there is another one.
const LIVE: &str = "\
<pre id=\"fault\" role=\"alert\" hidden></pre>
<script>setInterval(() => {
  const script = document.createElement('script');
  script.src = encodeURIComponent(\"NAME\") + '?' + Date.now();
  script.onload = () => {
    script.remove();
    const fault = document.getElementById('fault');
    fault.textContent = window.librateFault || '';
    fault.hidden = !window.librateFault;
    if (!window.librateFault && window.librateSaved !== 'VERSION') location.reload();
  };
  script.onerror = () => script.remove();
  document.head.append(script);
}, 1000);</script>
";

pub(super) fn text(args: &args::Show) -> Result<Answer, Failure> {
    let answer = page(args);
    if let (Err(Failure::Model(source, all)), Some(file)) = (&answer, args.output.as_ref().filter(|_| args.live)) {
        // The page is still that of the last model without errors.
        if file.exists() {
            let told = report::diagnostics_text(&source.name, &source.text, all, &Style::default());
            write_beside(
                file,
                &format!("window.librateFault = {};\n", Value::from(&*visible(&told, false))),
                &mut source.clone(),
            )?;
        }
    }
    answer
}

fn page(args: &args::Show) -> Result<Answer, Failure> {
    let Loaded { mut source, made, model, mut warnings } =
        load(&args.model, if args.lowest.is_some() { Size::Any } else { Size::Dense })?;
    let shown = args.lowest.unwrap_or(model.coordinates.len());
    if shown > report::MOST_MODES {
        let help = format!("choose some: `--lowest 20`; a page has room for {}", report::MOST_MODES);
        return Err(wrong_request(format!("{shown} modes are too many for a page"), &help));
    }
    let mut options = modes::Options::default().digits(args.digits);
    options.lowest = args.lowest;
    let nodes = nodes(args, &made, &model, &options)?;
    let computed = during(&args.model, "computing the modes", || solved(model.clone(), &options));
    let (linearized, modes) = computed.map_err(|error| failed(&source, &warnings, error))?;
    warnings.extend(modes.warnings(&linearized));
    let grid = nodes.map(|nodes| grid(args, &source, nodes, (&linearized, &modes))).transpose()?;
    let figure = grid.as_ref().map_or_else(|| figure::figure(&linearized, &[]), |grid| grid.figure.clone());
    let nothing_left = figure.is_none() && linearized.model().drawing.is_some();
    let left_out = figure.as_ref().map_or(0, |own| own.left_out);
    if left_out > 0 || nothing_left {
        let what = match left_out {
            0 => "all that `draw` names has",
            1 => "one thing that `draw` names has",
            _ => "some of what `draw` names has",
        };
        let told = Diagnostic::remark(format!("{what} no place at the equilibrium, and is left out"));
        warnings.push(told.with_help("its value there is no number"));
    }
    if let Some(own) = figure.as_ref().filter(|own| !own.still.is_empty() && linearized.model().drawing.is_none()) {
        let told = Diagnostic::remark(report::still_words(own));
        warnings.push(told.with_help("`draw` says what is to be drawn: `draw point [x, 0]`"));
    }
    // Last, as it may take up all of a budget; where it fails it is left out.
    let derivation = during(&args.model, "deriving", || derive::derive(&model, &Parts::all()).ok());
    args.model.guard.accept();
    warnings.extend(derivation.as_ref().and_then(|own| own.left_out.as_ref()).map(report::left_out));
    let mut page = report::show_html(&Shown {
        text: &source.text,
        linearized: &linearized,
        modes: &modes,
        options: &options,
        figure: figure.as_ref(),
        derivation: derivation.as_ref(),
        grid: grid.as_ref(),
    });
    if let Some(file) = args.output.as_ref().filter(|_| args.live) {
        make_live(file, &mut page, &mut source)?;
    }
    Answer::new(page, Some((source, warnings))).into_file(args.output.as_deref())
}

/// The grid that is asked for.
fn nodes(args: &args::Show, made: &Made, model: &Model, options: &modes::Options) -> Result<Option<Nodes>, Failure> {
    let help = "write `--over NAME=a..b:count` once or twice, for example `--over k=1..4:9`";
    let ranges: Vec<Range> = args.over.iter().map(|text| range(text, help)).collect::<Result<_, _>>()?;
    if ranges.is_empty() {
        return Ok(None);
    }
    let nodes = Nodes::new(made, model, &ranges, options);
    nodes.map(Some).map_err(|error| wrong_request(error.to_string(), error.help().as_deref().unwrap_or(help)))
}

/// The modes over the grid.
fn grid(args: &args::Show, source: &Source, nodes: Nodes, own: (&Linearized, &NormalModes)) -> Result<Grid, Failure> {
    let place = || |at: usize| nodes.place(at);
    let step = || args.model.guard.go_on(source);
    let places = all(None, nodes.count(), "computing the modes over the grid", place, step)?;
    Ok(nodes.followed(&places, own))
}

/// A page from a file may load scripts alone: one beside it says which page is the newest, and what is wrong with the model now.
fn make_live(file: &Path, page: &mut String, source: &mut Source) -> Result<(), Failure> {
    let mut hasher = DefaultHasher::new();
    page.hash(&mut hasher);
    let version = hasher.finish().to_string();
    let name = beside(file).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let script = LIVE.replace("VERSION", &version).replace("\"NAME\"", &Value::from(name).to_string());
    if let Some(at) = page.rfind("</body>") {
        page.insert_str(at, &script);
    }
    write_beside(file, &format!("window.librateSaved = \"{version}\";\nwindow.librateFault = null;\n"), source)
}

/// `page.html.js`
fn beside(file: &Path) -> PathBuf {
    let mut beside = file.as_os_str().to_owned();
    beside.push(".js");
    PathBuf::from(beside)
}

fn write_beside(file: &Path, script: &str, source: &mut Source) -> Result<(), Failure> {
    write_file(&beside(file), script, source)
}
