//! Drawing diagnostics below the lines they are about.

use annotate_snippets::{
    Annotation, AnnotationKind, Element, Group, Level, Renderer, Snippet, normalize_untrusted_str,
};
use librate::diagnostic::{Diagnostic, Label, Severity};

use super::input::Source;

/// Places further apart than this many lines are shown as two excerpts.
const NEAR: usize = 30;

/// All diagnostics as text, with a count at the end if there is more than one.
pub(crate) fn diagnostics(
    source: &Source,
    diagnostics: &[Diagnostic],
    color: bool,
    width: usize,
) -> String {
    let renderer = if color {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    let renderer = renderer.term_width(width);
    let page = Page::new(source);
    let mut out = String::new();
    for diagnostic in diagnostics {
        let drawn = if diagnostic.primary.is_some() {
            renderer.render(&[group(&page, diagnostic)])
        } else {
            without_place(&renderer, &diagnostic.message, diagnostic.help.as_deref())
        };
        out.push_str(&drawn);
        out.push_str("\n\n");
    }
    let errors = diagnostics
        .iter()
        .filter(|diagnostic| diagnostic.severity == Severity::Error)
        .count();
    if errors > 1 {
        let title = Level::ERROR.primary_title(format!("{} has {errors} mistakes", source.name));
        out.push_str(&renderer.render(&[Group::with_title(title)]));
        out.push('\n');
    } else if out.ends_with("\n\n") {
        out.pop();
    }
    out
}

/// A message that is not about a place in a model.
pub(crate) fn message(text: &str, help: Option<&str>, color: bool) -> String {
    let renderer = if color {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    format!("{}\n", without_place(&renderer, text, help))
}

/// A report that has no excerpt: the fix stands on a line of its own.
fn without_place(renderer: &Renderer, text: &str, help: Option<&str>) -> String {
    let title = |title| renderer.render(&[Group::with_title(title)]);
    let mut out = title(Level::ERROR.primary_title(text));
    if let Some(help) = help {
        out.push('\n');
        out.push_str(&title(Level::HELP.primary_title(help)));
    }
    out
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
    fn new(source: &'a Source) -> Self {
        let text = source.text.strip_prefix('\u{feff}').unwrap_or(&source.text);
        let mut lines = vec![0];
        lines.extend(text.match_indices('\n').map(|(at, _)| at + 1));
        Self {
            name: &source.name,
            text,
            mark: source.text.len() - text.len(),
            lines,
        }
    }

    /// The bytes a label is about, at the borders of characters of this text.
    fn range(&self, label: &Label) -> (usize, usize) {
        let place = |at: u32| {
            let mut at = (at as usize).saturating_sub(self.mark).min(self.text.len());
            while !self.text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = place(label.span.start);
        (start, place(label.span.end).max(start))
    }

    /// The number of the line that holds a byte, from 0.
    fn line(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at) - 1
    }

    /// An excerpt from one line to another, both included.
    fn excerpt(&self, first: usize, last: usize) -> (usize, &'a str) {
        let start = self.lines[first];
        let end = self
            .lines
            .get(last + 1)
            .map_or(self.text.len(), |next| *next);
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

fn group<'a>(page: &Page<'a>, diagnostic: &'a Diagnostic) -> Group<'a> {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group = Group::with_title(level.primary_title(diagnostic.message.as_str()));
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
    marks.sort_by_key(|mark| (mark.start, mark.end));
    let mut clusters: Vec<Vec<Mark>> = Vec::new();
    for mark in marks {
        match clusters.last_mut() {
            Some(cluster)
                if cluster
                    .iter()
                    .any(|other| mark.first <= other.last.saturating_add(NEAR)) =>
            {
                cluster.push(mark);
            }
            Some(_) | None => clusters.push(vec![mark]),
        }
    }
    // The place of the mistake first.
    clusters.sort_by_key(|cluster| !cluster.iter().any(|mark| mark.primary));
    for cluster in clusters {
        group = group.element(snippet(page, &cluster));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(normalize_untrusted_str(help)));
    }
    group
}

fn snippet<'a>(page: &Page<'a>, cluster: &[Mark<'a>]) -> Element<'a> {
    let first = cluster.iter().map(|mark| mark.first).min().unwrap_or(0);
    let last = cluster.iter().map(|mark| mark.last).max().unwrap_or(first);
    let (offset, text) = page.excerpt(first, last);
    let annotations = cluster.iter().map(|mark| -> Annotation<'a> {
        let kind = if mark.primary {
            AnnotationKind::Primary
        } else {
            AnnotationKind::Context
        };
        let label = (!mark.text.is_empty()).then_some(mark.text);
        kind.span(mark.start - offset..mark.end - offset)
            .label(label)
    });
    Snippet::source(text)
        .line_start(first + 1)
        .path(page.name)
        .annotations(annotations)
        .into()
}
