//! `librate show`: a page with the modes in motion.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use librate::derive::{self, Parts};
use librate::report::{self, Shown};
use librate::{figure, modes};

use super::input::Source;
use super::output::{into_file, write_file};
use super::{Answer, Failure, Loaded, Size, args, during, failed, load, solved, wrong_request};
use serde_json::Value;

/// A page of more modes would be too long to look through.
const MOST_MODES: usize = 200;

/// Loads the page again once there is another one.
const LIVE: &str = "\
<script>setInterval(() => {
  const script = document.createElement('script');
  script.src = encodeURIComponent(\"NAME\") + '?' + Date.now();
  script.onload = () => { script.remove(); if (window.librateSaved !== 'VERSION') location.reload(); };
  script.onerror = () => script.remove();
  document.head.append(script);
}, 1000);</script>
";

pub(super) fn text(args: &args::Show) -> Result<Answer, Failure> {
    let Loaded { mut source, model, mut warnings, .. } =
        load(&args.model, if args.lowest.is_some() { Size::Any } else { Size::Dense })?;
    let shown = args.lowest.unwrap_or(model.coordinates.len());
    if shown > MOST_MODES {
        let help = format!("choose some: `--lowest 20`; a page has room for {MOST_MODES}");
        return Err(wrong_request(format!("{shown} modes are too many for a page"), &help));
    }
    let mut options = modes::Options::default().digits(args.digits);
    options.lowest = args.lowest;
    // A derivation may fail where there are modes, and is left out then.
    let work = || (derive::derive(&model, &Parts::all()).ok(), solved(model, &options));
    let (derivation, computed) = during(&args.model, "computing the modes", work);
    let (linearized, modes) = computed.map_err(|error| failed(&source, &warnings, error))?;
    warnings.extend(modes.warnings(&linearized));
    let figure = figure::figure(&linearized);
    let mut page = report::show_html(&Shown {
        text: &source.text,
        linearized: &linearized,
        modes: &modes,
        options: &options,
        figure: figure.as_ref(),
        derivation: derivation.as_ref(),
    });
    if let Some(file) = args.output.as_ref().filter(|_| args.live) {
        make_live(file, &mut page, &mut source)?;
    }
    into_file(args.output.as_deref(), &mut page, &mut source)?;
    Ok(Answer::new(page, Some((source, warnings))))
}

/// A page from a file may load scripts alone: one beside it says which page is the newest.
fn make_live(file: &Path, page: &mut String, source: &mut Source) -> Result<(), Failure> {
    let mut hasher = DefaultHasher::new();
    page.hash(&mut hasher);
    let version = hasher.finish().to_string();
    let mut beside = file.as_os_str().to_owned();
    beside.push(".js");
    let name = Path::new(&beside).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let script = LIVE.replace("VERSION", &version).replace("\"NAME\"", &Value::from(name).to_string());
    if let Some(at) = page.rfind("</body>") {
        page.insert_str(at, &script);
    }
    write_file(Path::new(&beside), &format!("window.librateSaved = \"{version}\";\n"), source)
}
