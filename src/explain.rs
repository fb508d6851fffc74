//! What the codes of mistakes mean, at length: one page a code, under `docs/errors`.

/// The pages by code, ascending.
const PAGES: &[(&str, &str)] = &[];

/// All codes that have a page, ascending.
pub fn codes() -> impl Iterator<Item = &'static str> {
    PAGES.iter().map(|(code, _)| *code)
}

/// The page about a code, as Markdown: what is wrong, why it matters, a model with the mistake and one
/// without.
///
/// The case of letters does not count; `None` if there is no such code.
#[must_use]
pub fn explain(code: &str) -> Option<&'static str> {
    let code = code.trim().to_ascii_uppercase();
    let at = PAGES.binary_search_by(|(own, _)| (*own).cmp(code.as_str()));
    at.ok().map(|at| PAGES[at].1)
}
