//! Diagnostics, drawn below the lines they are about.

use std::collections::HashSet;

use annotate_snippets::{
    Annotation, AnnotationKind, Element, Group, Level, Origin, Renderer, Snippet, Title, normalize_untrusted_str,
};
use librate_core::diagnostic::{Diagnostic, Label, Severity};
use librate_core::order::Order;

use super::Style;

/// Places further apart than this many lines are shown as two excerpts.
const NEAR: usize = 30;

/// Of excerpts longer than this many bytes only the neighbourhood of the mistake is shown, ...
const LONG: usize = 20_000;
/// ... so many bytes to either side.
const AROUND: usize = 60;
/// Nobody reads more mistakes than this.
const MOST: usize = 1000;

/// All diagnostics about a text of that name, each drawn into it, with a count at the end if there is more than one error.
///
/// Control characters in what is quoted from the text are left as they are, but for those in messages.
#[must_use]
pub fn diagnostics_text(name: &str, text: &str, diagnostics: &[Diagnostic], style: &Style) -> String {
    let renderer = renderer(style).term_width(style.width);
    let page = Page::new(name, text);
    let mut out = String::new();
    for diagnostic in diagnostics.iter().take(MOST) {
        let drawn = if diagnostic.primary.is_some() {
            renderer.render(&[group(&page, diagnostic)])
        } else {
            let (message, help) = (&diagnostic.message, diagnostic.help.as_deref());
            without_place(&renderer, level(diagnostic), message, help, diagnostic.code)
        };
        out.push_str(&drawn);
        out.push_str("\n\n");
    }
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
    if errors > 1 {
        let shown = if diagnostics.len() > MOST { format!("; the first {MOST} are shown") } else { String::new() };
        let title = format!("{} has {errors} errors{shown}", page.name);
        let title = Level::ERROR.primary_title(title);
        out.push_str(&renderer.render(&[Group::with_title(title)]));
        out.push('\n');
    } else if out.ends_with("\n\n") {
        out.pop();
    }
    out
}

/// What is to be said of values of a range: each kind of mistake once, with the first value that has it.
#[derive(Clone, Debug)]
pub struct Remarks {
    /// The name of the range.
    name: String,
    told: HashSet<String>,
    /// All of them.
    pub all: Vec<Diagnostic>,
}

impl Remarks {
    /// Nothing so far.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), told: HashSet::new(), all: Vec::new() }
    }

    /// What is to be said of a value.
    pub fn add(&mut self, value: f64, diagnostics: Vec<Diagnostic>) {
        for mut diagnostic in diagnostics {
            if self.told.insert(diagnostic.code.map_or_else(|| diagnostic.message.clone(), str::to_owned)) {
                diagnostic.message = format!("at {} = {value}: {}", self.name, diagnostic.message);
                self.all.push(diagnostic);
            }
        }
    }
}

/// An error that is not about a place in a text, and the fix where there is one.
#[must_use]
pub fn message_text(message: &str, help: Option<&str>, style: &Style) -> String {
    format!("{}\n", without_place(&renderer(style), Level::ERROR, message, help, None))
}

fn renderer(style: &Style) -> Renderer {
    if style.color { Renderer::styled() } else { Renderer::plain() }
}

/// A report that has no excerpt: the fix stands on a line of its own.
fn without_place(
    renderer: &Renderer,
    level: Level<'_>,
    text: &str,
    help: Option<&str>,
    code: Option<&'static str>,
) -> String {
    let title = |title| renderer.render(&[Group::with_title(title)]);
    let mut out = title(with_code(level.primary_title(text), code));
    if let Some(help) = help {
        out.push('\n');
        out.push_str(&title(Level::HELP.primary_title(help)));
    }
    out
}

fn with_code<'a>(title: Title<'a>, code: Option<&'static str>) -> Title<'a> {
    match code {
        Some(code) => title.id(code),
        None => title,
    }
}

/// The text with the places of its lines.
struct Page<'a> {
    name: &'a str,
    /// Without a byte order mark, which would be a column of its own.
    text: &'a str,
    /// How many bytes of the mark were dropped.
    mark: usize,
    /// Where each line begins.
    lines: Vec<usize>,
}

impl<'a> Page<'a> {
    fn new(name: &'a str, whole: &'a str) -> Self {
        let text = whole.strip_prefix('\u{feff}').unwrap_or(whole);
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { name, text, mark: whole.len() - text.len(), lines }
    }

    /// The bytes a label is about, at the borders of characters of this text.
    fn range(&self, label: &Label) -> (usize, usize) {
        let place = |at: u32| self.border((at as usize).saturating_sub(self.mark).min(self.text.len()));
        let start = place(label.span.start);
        (start, place(label.span.end).max(start))
    }

    /// The number of the line that holds a byte, from 0.
    fn line(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at) - 1
    }

    /// The beginning of the character at a place.
    fn border(&self, mut at: usize) -> usize {
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }

    /// An excerpt from one line to another, both included.
    fn excerpt(&self, first: usize, last: usize) -> (usize, &'a str) {
        let start = self.lines[first];
        let end = self.lines.get(last + 1).map_or(self.text.len(), |next| *next);
        (start, &self.text[start..end])
    }
}

/// A label on its way into an excerpt.
struct Mark<'a> {
    primary: bool,
    start: usize,
    end: usize,
    first: usize,
    last: usize,
    text: &'a str,
}

fn level(diagnostic: &Diagnostic) -> Level<'static> {
    if diagnostic.severity == Severity::Warning { Level::WARNING } else { Level::ERROR }
}

fn group<'a>(page: &Page<'a>, diagnostic: &'a Diagnostic) -> Group<'a> {
    let title = level(diagnostic).primary_title(diagnostic.message.as_str());
    let mut group = Group::with_title(with_code(title, diagnostic.code));
    let labels = diagnostic
        .primary
        .iter()
        .map(|label| (true, label))
        .chain(diagnostic.secondary.iter().map(|label| (false, label)));
    let mut marks: Vec<Mark> = labels
        .map(|(primary, label)| {
            let (start, end) = page.range(label);
            Mark {
                primary,
                start,
                end,
                first: page.line(start),
                last: page.line(end.max(start + 1) - 1).max(page.line(start)),
                text: &label.text,
            }
        })
        .collect();
    marks.order_by_key(|mark| (mark.start, mark.end));
    let mut clusters: Vec<Vec<Mark>> = Vec::new();
    for mark in marks {
        match clusters.last_mut() {
            Some(cluster) if cluster.iter().any(|other| mark.first <= other.last.saturating_add(NEAR)) => {
                cluster.push(mark);
            }
            Some(_) | None => clusters.push(vec![mark]),
        }
    }
    // The place of the mistake first.
    clusters.order_by_key(|cluster| !cluster.iter().any(|mark| mark.primary));
    for cluster in clusters {
        group = group.elements(snippet(page, &cluster));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(normalize_untrusted_str(help)));
    }
    group
}

fn snippet<'a>(page: &Page<'a>, cluster: &[Mark<'a>]) -> Vec<Element<'a>> {
    let first = cluster.iter().map(|mark| mark.first).min().unwrap_or(0);
    let last = cluster.iter().map(|mark| mark.last).max().unwrap_or(first);
    let (offset, text) = page.excerpt(first, last);
    if text.len() > LONG {
        let mark = cluster.iter().find(|mark| mark.primary).or(cluster.first());
        return mark.map_or_else(Vec::new, |mark| cutting(page, mark));
    }
    let annotations = cluster.iter().map(|mark| annotation(mark, offset, mark.end));
    vec![Snippet::source(text).line_start(first + 1).path(page.name).annotations(annotations).into()]
}

fn annotation<'a>(mark: &Mark<'a>, offset: usize, end: usize) -> Annotation<'a> {
    let kind = if mark.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
    let label = (!mark.text.is_empty()).then_some(mark.text);
    kind.span(mark.start - offset..end - offset).label(label)
}

/// The neighbourhood of a mark where its lines are too long to be laid out again and again.
fn cutting<'a>(page: &Page<'a>, mark: &Mark<'a>) -> Vec<Element<'a>> {
    let line_start = page.lines[mark.first];
    let column = page.text[line_start..mark.start].chars().count() + 1;
    let origin = Origin::path(page.name).line(mark.first + 1).char_column(column);
    let start = page.border(mark.start.saturating_sub(AROUND)).max(line_start);
    let end = page.border(mark.end.min(mark.start + AROUND)).max(mark.start);
    let rest = &page.text[end..page.border((end + AROUND).min(page.text.len()))];
    let stop = end + rest.find('\n').unwrap_or(rest.len());
    let snippet =
        Snippet::source(&page.text[start..stop]).line_start(mark.first + 1).annotation(annotation(mark, start, end));
    vec![origin.into(), snippet.into()]
}
