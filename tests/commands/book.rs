//! The book: what it shows is what is printed, its models run, its gallery is made from the headers of the models, its links lead somewhere.
//! With `UPDATE_BOOK=1` outputs and gallery are written anew.
#![cfg(feature = "cli")]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

use crate::cli_support::run;
use crate::common;
use librate::linearize::linearize;
use librate::model::{Model, Settings, TableTexts, elaborate};
use librate::modes::Options;
use librate::oscillation::normal_modes;

const BOOK: &str = "docs/book/src";

pub(crate) fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The pages, chapters of the course among them.
fn pages() -> Vec<PathBuf> {
    let of = |folder: String| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let all = of(BOOK.to_owned()).chain(of(format!("{BOOK}/course")));
    let mut pages: Vec<PathBuf> = all.filter(|path| path.extension().is_some_and(|own| own == "md")).collect();
    pages.sort();
    pages
}

/// Compares a page with what it is to be, or writes that.
pub(crate) fn hold(page: &Path, wanted: &str) {
    if std::env::var_os("UPDATE_BOOK").is_some() {
        std::fs::write(page, wanted).unwrap();
    } else {
        similar_asserts(&read(page), wanted, page);
    }
}

fn similar_asserts(found: &str, wanted: &str, page: &Path) {
    let first = found.lines().zip(wanted.lines()).find(|(found, wanted)| found != wanted);
    assert!(found == wanted, "{} is not up to date (UPDATE_BOOK=1 writes it anew): {first:?}", page.display());
}

/// What a command of a block prints; errors where that is nothing.
fn answer(line: &str) -> String {
    let words: Vec<String> = line.split_whitespace().map(|word| word.replace('\'', "")).collect();
    let [program, arguments @ ..] = &words[..] else { panic!("{line}") };
    assert_eq!(program, "librate", "{line}");
    let found = run(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    let text = if found.out.is_empty() { found.err } else { found.out };
    let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
    lines.join("\n").trim_end().to_owned()
}

#[test]
fn the_book_shows_what_is_printed() {
    let mut commands = 0;
    for page in pages() {
        let text = read(&page);
        let mut parts = text.split("```console\n");
        let mut wanted = parts.next().unwrap().to_owned();
        for part in parts {
            let (block, rest) = part.split_once("```").unwrap();
            let answers = block.lines().filter_map(|line| line.strip_prefix("$ "));
            let answers: Vec<String> = answers.map(|line| format!("$ {line}\n{}\n", answer(line))).collect();
            commands += answers.len();
            let _ = write!(wanted, "```console\n{}```{rest}", answers.join("\n"));
        }
        hold(&page, &wanted);
    }
    assert!(commands > 50);
}

#[test]
fn models_of_the_book_run() {
    let mut models = 0;
    for page in pages() {
        let text = read(&page);
        for block in text.split("```lag\n").skip(1).map(|rest| rest.split_once("```").unwrap().0) {
            models += 1;
            if let Some(included) = included(block, &page) {
                assert!(included.is_file(), "{}: {block}", page.display());
                continue;
            }
            let file = librate::syntax::parse(block).unwrap_or_else(|e| panic!("{block}\n{e:?}"));
            let model = elaborate(&file, &TableTexts::new(), &Settings::new()).unwrap();
            let linearized = linearize(model).unwrap_or_else(|e| panic!("{block}\n{e}"));
            let normal = normal_modes(&linearized, &Options::default()).unwrap();
            assert_eq!(normal.modes.len(), linearized.dimension());
        }
    }
    assert!(models > 12);
}

/// The file that a text puts in.
fn included(text: &str, page: &Path) -> Option<PathBuf> {
    let (_, rest) = text.split_once("{{#include ")?;
    Some(page.parent()?.join(rest.split_once("}}")?.0))
}

/// Ends of links in a text, without those of the web and places on the page itself.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let ends = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(end, _)| end);
    let ends = ends.map(|end| end.split('#').next().unwrap_or_default());
    ends.filter(|end| !end.is_empty() && !end.contains("://"))
}

#[test]
fn links_lead_somewhere() {
    // As they are in their folders, and in the book, which has nothing beyond its own.
    let holds = |page: &Path, text: &str| {
        for end in links(text).filter(|end| !end.starts_with("pictures/")) {
            let target = page.parent().unwrap().join(end);
            assert!(target.exists(), "{}: {end}", page.display());
            if let Ok(own) = target.strip_prefix(BOOK) {
                let mut depth = own.components().scan(0, |depth, part| {
                    *depth += if part == Component::ParentDir { -1 } else { 1 };
                    Some(*depth)
                });
                assert!(depth.all(|depth| depth >= 0), "{}: {end} is not in the book", page.display());
            }
        }
    };
    let summary = read(&Path::new(BOOK).join("SUMMARY.md"));
    let listed: BTreeSet<PathBuf> = links(&summary).map(|end| Path::new(BOOK).join(end)).collect();
    let all: BTreeSet<PathBuf> = pages().into_iter().filter(|page| !page.ends_with("SUMMARY.md")).collect();
    assert_eq!(listed, all);
    let documents = std::fs::read_dir("docs").unwrap().map(|entry| entry.unwrap().path());
    let documents = documents.filter(|path| path.extension().is_some_and(|own| own == "md"));
    let more = ["README.md", "ARCHITECTURE.md", "python/README.md", "editors/README.md", "editors/vscode/README.md"]
        .map(PathBuf::from);
    for page in documents.chain(all).chain(more) {
        let text = read(&page);
        holds(&page, &text);
        if let Some(included) = included(&text, &page) {
            holds(&page, &read(&included));
        }
    }
}

/// The chapter on tests names them by their places.
#[test]
fn what_is_said_to_be_checked_is_there() {
    let text = read(&Path::new(BOOK).join("checking.md"));
    let places =
        text.split('`').skip(1).step_by(2).filter(|own| !own.contains(char::is_whitespace) && own.contains(['/', '.']));
    let places: Vec<&str> = places.collect();
    places.iter().for_each(|own| assert!(Path::new(own).exists(), "{own}"));
    assert!(places.len() > 25);
}

/// The comment at the beginning of a model, by lines.
fn header(text: &str) -> Vec<&str> {
    text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim).collect()
}

/// A name in words.
fn title(name: &str) -> String {
    let words = name.replace('_', " ");
    let (first, rest) = words.split_at(1);
    first.to_uppercase() + rest
}

/// For Markdown.
fn plain(text: &str) -> String {
    text.replace('*', "\\*").replace('_', "\\_").replace('<', "&lt;")
}

/// The books that a header names with a place in them, each with that place.
fn books(header: &str) -> Vec<(String, String)> {
    let place = r"(?:§|ch\. |chapter |sections? |article |example )[\dIVX]+(?:[.-]\d+)*(?:,? problems?(?: \d+\w?)?)?";
    let author = r"\p{Lu}[\w-]+(?: \p{Lu}[\w-]+)?";
    let authors = format!("{author}(?:(?:, {author})* (?:&|and) {author})?");
    let reference = format!(r"({authors}), (\p{{Lu}}[^;,.§]*), ({place}(?: and (?:{place}|\d[\d.]*\d))*)");
    let reference = fancy_regex::Regex::new(&reference).unwrap();
    let found = reference.captures_iter(header).map(|own| own.unwrap());
    found.map(|own| (format!("{}, {}", own[1].replace(" and ", " & "), &own[2]), own[3].to_owned())).collect()
}

/// Links to models by places in a book, in the order of their numbers.
type Places = BTreeMap<(Vec<u32>, String), Vec<String>>;

/// The numbers in a text, in order.
fn numbers(text: &str) -> Vec<u32> {
    text.split(|c: char| !c.is_ascii_digit()).filter_map(|own| own.parse().ok()).collect()
}

/// The model that is drawn, and how it is set: of families with a hundred members or more one of ten.
fn drawn(file: &Path, text: &str) -> (Option<Model>, &'static str) {
    let number = text.lines().find_map(|line| line.strip_prefix("param N = ")?.parse::<u32>().ok());
    let settings: &[&str] = if number.is_some_and(|own| own >= 100) { &["N=10"] } else { &[] };
    // Its table of points is made by a program.
    let is_there = !file.ends_with("large/network.lag");
    let model = is_there.then(|| common::model_in(text, file.parent().unwrap(), settings));
    (model, if settings.is_empty() { "" } else { " --set N=10" })
}

#[test]
fn the_gallery_is_made_from_headers() {
    let mut chapters: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let folders = ["", "amplitude", "equilibria", "hard", "large", "period", "response", "rolling"];
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(Path::new("models").join(folder)).unwrap());
    let mut files: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|own| own == "lag"));
    files.sort();
    assert!(files.len() > 200);
    let mut by_book: BTreeMap<String, Places> = BTreeMap::new();
    for file in files {
        let text = read(&file);
        let path = file.strip_prefix("models").unwrap().with_extension("");
        let name = path.file_name().unwrap().to_str().unwrap();
        let folder = path.parent().and_then(Path::to_str).filter(|folder| !folder.is_empty());
        let header = header(&text);
        assert!(!header.is_empty(), "{name} says nothing of itself");
        let is_source = |line: &&&str| line.starts_with("A mechanics course on ") || line.starts_with("A course on ");
        let course = header.iter().find(is_source).and_then(|line| line.split_once("course on ")).map(|(_, rest)| rest);
        let course = course.map(|rest| rest.split([':', ';', '.']).next().unwrap_or(rest));
        let lines: Vec<String> = header.iter().map(|line| plain(line)).collect();
        let (model, setting) = drawn(&file, &text);
        let anchor = path.display().to_string().replace('/', "_");
        let picture = match model.map(linearize) {
            Some(Ok(_)) => format!("![](pictures/{anchor}.svg)"),
            Some(Err(error)) => format!("No modes are drawn: {}.", plain(&error.to_string())),
            None => "No modes are drawn: it has no points before a program makes them.".to_owned(),
        };
        let lines = lines.join("\n");
        let entry =
            format!("### {} {{#{anchor}}}\n\n{picture}\n\n{lines}\n\n`{}{setting}`\n", title(name), file.display());
        chapters.entry(course.or(folder).unwrap_or("other books").to_owned()).or_default().push(entry);
        for (book, place) in books(&header.join(" ")) {
            let places = by_book.entry(book).or_default();
            let link = format!("[{}](#{anchor})", title(name).to_lowercase());
            places.entry((numbers(&place), place)).or_default().push(link);
        }
    }
    let mut gallery = "# Gallery of models\n\nAll models of the folder `models`, by the subject of the lecture, with their sources and what is known of them. \
        A test makes this page from\ntheir headers; another page says [how they are checked](checking.md). Those of \
        `models/hard` are hard for numerical methods,\nthose of `models/large` have up to a million coordinates: [speed and error](speed-and-error.md) measures some of them. \
        Where `--set N=10` is\nbehind a file, the picture is of a small member of the family.\n\n## By book and section\n\n"
        .to_owned();
    for (book, places) in by_book {
        let places = places.into_iter().map(|((_, place), links)| format!("{place}: {}", links.join(", ")));
        let _ = writeln!(gallery, "- **{book}**: {}", places.collect::<Vec<_>>().join("; "));
    }
    for (subject, entries) in chapters {
        let _ = write!(gallery, "\n## {}\n\n{}", title(&subject), entries.join("\n"));
    }
    hold(&Path::new(BOOK).join("gallery.md"), &gallery);
}
