//! The pages behind `librate explain`: every code has one, and every example on them does what the
//! page says.
//!
//! A block `lag wrong` makes exactly the mistake of its page, a block `lag` none. Further words:
//! `set=NAME=VALUE` is a setting, `check` stops before the modes, `derive` asks for M and K in symbols, `study` for
//! a study of many sets of parameters, `start=…`, `mode=K`, `until=TIME` and `proved` for a motion, `amplitude=A` and `energy=E`
//! for a period, `box=RANGES` and maybe `over=…` for equilibria, `response` with `over=…` and maybe `input=…` for a steady response, `amplitude` for
//! changes of frequencies, `floquet` for multipliers, `inertia` for its
//! tensors. A block `csv NAME` is the file of that name for the models below it; blocks `points` and `stl` (`wrong` or not)
//! are files for `librate inertia`.
#![cfg(feature = "cli")]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use librate::Error;
use librate::amplitude::{self, amplitude};
use librate::batch::{Study, StudyError};
use librate::diagnostic::Diagnostic;
use librate::equilibria::{self, Region};
use librate::explain::{codes, explain};
use librate::floquet::{self, floquet};
use librate::inertia::{self, Amount, Mesh};
use librate::linearize::linearize;
use librate::model::{Constant, Model, Range, Settings, TableTexts, elaborate};
use librate::modes::{Kind, Options};
use librate::motion::{Enclosed, Start, System, Times};
use librate::oscillation::normal_modes;
use librate::period::{Oscillator, Request};
use librate::response;
use librate::syntax::{self, format};

/// Mistakes of files too large for a page, of binary files and of the command line, and those that no text is known to
/// make.
const WITHOUT_A_MODEL: [&str; 12] =
    ["E0001", "E0036", "E0310", "E0411", "E0420", "E0421", "E0422", "E0604", "E0608", "E0609", "E0724", "E0806"];

/// Longest line of a page, for terminals.
const WIDTH: usize = 100;

/// The codes in quotes in a source text: a letter and four digits.
fn codes_in(source: &str) -> impl Iterator<Item = &str> {
    source.split('"').filter(|text| {
        text.strip_prefix(['E', 'W'])
            .is_some_and(|number| number.len() == 4 && number.bytes().all(|b| b.is_ascii_digit()))
    })
}

/// Every code that an error or a warning can have, from the sources that give them.
fn codes_of_the_sources() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut folders = vec![Path::new("src").to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if ["codes.rs", "error.rs", "warning.rs"].iter().any(|name| path.ends_with(name)) {
                let source = std::fs::read_to_string(&path).unwrap();
                for code in codes_in(&source) {
                    assert!(found.insert(code.to_owned()), "{code} is given twice");
                }
            }
        }
    }
    // A mistake that only follows from another one is never told.
    assert!(found.remove("E0100"));
    found
}

#[test]
fn every_code_has_a_page_and_every_page_a_code() {
    let pages: Vec<&str> = codes().collect();
    assert!(pages.is_sorted(), "the pages are found by bisection");
    let pages: BTreeSet<String> = pages.into_iter().map(str::to_owned).collect();
    assert_eq!(pages, codes_of_the_sources());
    let files: BTreeSet<String> = std::fs::read_dir("docs/errors")
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .map(|name| name.strip_suffix(".md").unwrap().to_owned())
        .collect();
    assert_eq!(pages, files);
}

#[test]
fn pages_are_found_by_code() {
    let page = explain("E0007").unwrap();
    assert!(page.starts_with("# E0007: the multiplication sign is missing\n"));
    assert_eq!(explain(" e0007\n"), Some(page));
    for unknown in ["", "E", "E0100", "E9999", "7", "E00070"] {
        assert_eq!(explain(unknown), None);
    }
}

/// `# E0012: what is wrong`, each only once, and lines that fit a terminal.
#[test]
fn pages_have_one_form() {
    let mut titles = BTreeMap::new();
    for code in codes() {
        let page = explain(code).unwrap();
        let mut lines = page.lines();
        let title = lines.next().unwrap();
        let title = title.strip_prefix(&format!("# {code}: ")).unwrap();
        assert!(!title.starts_with(char::is_uppercase), "{code}: {title}");
        assert!(!title.ends_with(['.', ' ']), "{code}: {title}");
        if let Some(other) = titles.insert(title, code) {
            panic!("{other} and {code} have the same title");
        }
        assert_eq!(lines.next(), Some(""), "{code}");
        assert!(!lines.next().unwrap().is_empty(), "{code}");
        assert!(page.ends_with('\n') && !page.ends_with("\n\n"), "{code}");
        for line in page.lines() {
            assert!(line.chars().count() <= WIDTH, "{code}: {line}");
            assert_eq!(line, line.trim_end(), "{code}");
        }
    }
}

/// A block between fences: the words behind the first one, and the text.
struct Block<'a> {
    words: Vec<&'a str>,
    text: &'a str,
}

fn blocks(page: &str) -> Vec<Block<'_>> {
    let parts: Vec<&str> = page.split("```").collect();
    assert_eq!(parts.len() % 2, 1, "a fence is open");
    let inside = parts.iter().skip(1).step_by(2);
    inside
        .map(|part| {
            let (words, text) = part.split_once('\n').unwrap();
            Block { words: words.split_whitespace().collect(), text }
        })
        .collect()
}

/// What is wrong with the motion that is asked for, if one is.
fn asked_motion(
    model: &Model,
    start: Option<&str>,
    mode: Option<&str>,
    until: Option<&str>,
    proved: bool,
) -> Option<Error> {
    if start.is_none() && mode.is_none() {
        return None;
    }
    let constant = |text: &str| Constant::parse(text).unwrap();
    let follow = || -> Result<(), Error> {
        let system = System::new(model)?;
        let linearized = linearize(model.clone());
        let start = match mode {
            Some(mode) => {
                let linearized = linearized?;
                let modes = normal_modes(&linearized, &Options::default())?;
                let mode = mode.parse().unwrap();
                Start::mode(mode, &constant("1/10"), linearized.model(), (&linearized, &modes), &system)?
            }
            None => Start::parse(start.unwrap(), model, linearized.as_ref().ok(), &system)?,
        };
        let times = Times::new(&constant(until.unwrap_or("1")), 3)?;
        if proved {
            Enclosed::new(model)?.motion(&start, &times, 10)?;
        } else {
            system.motion(&start, &times)?;
        }
        Ok(())
    };
    follow().err()
}

/// The motion whose period is asked for instead of modes.
fn asked_period(block: &Block<'_>) -> Option<Request> {
    block.words.iter().find_map(|word| {
        let (name, value) = word.split_once('=')?;
        let value = Constant::parse(value);
        match name {
            "amplitude" => Some(Request::Amplitude(value.unwrap())),
            "energy" => Some(Request::Energy(value.unwrap())),
            _ => None,
        }
    })
}

/// The codes of everything that is told about a model, from reading to its modes.
///
/// Modes that are neither proved to oscillate nor told about are a surprise.
fn told(block: &Block<'_>, files: &BTreeMap<&str, &str>) -> Vec<&'static str> {
    let code = |diagnostic: Diagnostic| diagnostic.code.unwrap();
    let mut settings = Settings::new();
    for setting in block.words.iter().filter_map(|word| word.strip_prefix("set=")) {
        if let Err(error) = settings.add(setting) {
            return vec![error.code()];
        }
    }
    let file = match syntax::parse(block.text) {
        Ok(file) => file,
        Err(errors) => return errors.iter().map(|error| code(error.into())).collect(),
    };
    let tables = files.iter().fold(TableTexts::new(), |tables, (name, text)| tables.with((*name).to_owned(), *text));
    if block.words.contains(&"inertia") {
        let model = elaborate(&file, &tables, &settings.only_tensors()).unwrap();
        let errors = inertia::of_model(&model, 10).err().unwrap_or_default();
        return errors.iter().map(|error| code(error.into())).collect();
    }
    let checked = match elaborate(&file, &tables, &settings) {
        Ok(checked) => checked,
        Err(errors) => return errors.iter().map(|error| code(error.into())).collect(),
    };
    let mut told: Vec<&str> = checked.warnings(&file).into_iter().map(code).collect();
    told.extend(inertia::warnings(&checked).into_iter().map(code));
    if block.words.contains(&"check") {
        return told;
    }
    if block.words.contains(&"derive") {
        told.extend(librate_core::linearize::derive(checked.assumed().into_owned()).err().map(|error| error.code()));
        return told;
    }
    let word = |name: &str| block.words.iter().find_map(|word| word.strip_prefix(name));
    if let Some(error) =
        asked_motion(&checked, word("start="), word("mode="), word("until="), block.words.contains(&"proved"))
    {
        told.extend(error.diagnostics().into_iter().map(code));
        return told;
    }
    if word("start=").is_some() || word("mode=").is_some() {
        return told;
    }
    if block.words.contains(&"study") {
        if let Err(StudyError::Linearize { error }) = Study::new(checked, &["k"]) {
            told.push(error.code());
        }
        return told;
    }
    if block.words.contains(&"floquet") {
        let found = floquet(&checked, &floquet::Options::default());
        told.extend(found.err().map(|error| error.code()));
        return told;
    }
    if block.words.contains(&"response") {
        let range = Range::parse(word("over=").unwrap()).unwrap();
        let request =
            response::Request { input: word("input=").map(str::to_owned), outputs: Vec::new(), range, digits: 10 };
        let has_peaks = block.words.contains(&"peaks");
        let responds = |study: response::Study| match has_peaks {
            true => study.peaks(0).map(|_| ()),
            false => (0..study.len()).try_for_each(|place| study.values(place).map(|_| ())),
        };
        let found = response::Study::new(checked, librate::Source { file, tables, settings }, request);
        let remarks = found.iter().flat_map(|study| study.response([]).remarks());
        told.extend(remarks.filter_map(|own| own.code));
        told.extend(found.and_then(responds).err().map(|error| error.code()));
        return told;
    }
    if block.words.contains(&"amplitude") {
        let changes = || -> Result<(), Error> {
            amplitude::check(&checked)?;
            let linearized = linearize(checked)?;
            let modes = normal_modes(&linearized, &Options::default())?;
            let found = amplitude(&linearized, &modes)?;
            assert!(found.modes.iter().all(|mode| mode.change.is_some()));
            Ok(())
        };
        if let Err(error) = changes() {
            told.extend(error.diagnostics().into_iter().map(code));
        }
        return told;
    }
    if let Some(region) = word("box=") {
        let over = word("over=").map(|over| Range::parse(over).unwrap());
        let found = Region::parse(region, &checked).and_then(|region| match over {
            Some(range) => equilibria::follow(&librate::Source { file, tables, settings }, &region, &range)
                .err()
                .map_or(Ok(()), Err),
            None => equilibria::find(&checked, &region).map(|_| ()),
        });
        told.extend(found.err().map(|error| error.code()));
        return told;
    }
    if let Some(request) = asked_period(block) {
        let found =
            Oscillator::of_model(&checked).and_then(|oscillator| oscillator.period(&request, &Default::default()));
        told.extend(found.err().map(|error| error.code()));
        return told;
    }
    let linearized = match linearize(checked) {
        Ok(linearized) => linearized,
        Err(error) => {
            told.push(error.code());
            return told;
        }
    };
    match normal_modes(&linearized, &Options::default()) {
        Ok(normal) => {
            told.extend(normal.warnings(&linearized).into_iter().map(code));
            assert!(
                !told.is_empty()
                    || normal.modes.iter().all(|mode| {
                        // What turns steadily is free to.
                        let turns = linearized.model().rates.any();
                        mode.omega.mid_f64() > 0.0 || turns && mode.kind == Kind::Zero
                    }),
                "{}",
                block.text
            );
        }
        Err(error) => told.push(error.code()),
    }
    told
}

#[test]
fn models_on_the_pages_do_what_the_pages_say() {
    let mut surprises = String::new();
    for code in codes() {
        let (mut wrong, mut right) = (0, 0);
        let mut files = BTreeMap::new();
        for block in blocks(explain(code).unwrap()) {
            match block.words.as_slice() {
                ["csv", name] => {
                    files.insert(*name, block.text);
                }
                ["lag", "wrong", ..] => {
                    wrong += 1;
                    let told = told(&block, &files);
                    if told != [code] {
                        writeln!(surprises, "{code}: {told:?} from\n{}", block.text).unwrap();
                    }
                }
                ["lag", ..] => {
                    right += 1;
                    let told = told(&block, &files);
                    if !told.is_empty() {
                        writeln!(surprises, "{code}: {told:?} from\n{}", block.text).unwrap();
                    }
                    if format(block.text).unwrap() != block.text {
                        writeln!(surprises, "{code}: `fmt` changes\n{}", block.text).unwrap();
                    }
                }
                ["times", rest @ ..] => {
                    let told = Times::table(block.text).err().map(|error| error.code());
                    let expected = rest.contains(&"wrong").then_some(code);
                    if told != expected {
                        writeln!(surprises, "{code}: {told:?} from\n{}", block.text).unwrap();
                    }
                    wrong += usize::from(expected.is_some());
                    right += usize::from(expected.is_none());
                }
                [kind @ ("points" | "stl"), rest @ ..] => {
                    let body = match *kind {
                        "points" => inertia::of_points(block.text, 10),
                        _ => Mesh::read_stl(block.text.as_bytes()).and_then(|mesh| mesh.body(&Amount::Unit, 10)),
                    };
                    let told = body.err().map(|error| error.code());
                    let expected = rest.contains(&"wrong").then_some(code);
                    if told != expected {
                        writeln!(surprises, "{code}: {told:?} from\n{}", block.text).unwrap();
                    }
                    wrong += usize::from(expected.is_some());
                    right += usize::from(expected.is_none());
                }
                ["text"] => {}
                words => panic!("{code}: a block of {words:?}"),
            }
        }
        let shown = wrong > 0 && right > 0;
        let excepted = WITHOUT_A_MODEL.contains(&code) && wrong == 0;
        if !shown && !excepted {
            writeln!(surprises, "{code}: {wrong} wrong and {right} right models").unwrap();
        }
    }
    assert_eq!(surprises, "");
}
