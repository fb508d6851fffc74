//! The model language, `.lag`, for tree-sitter.

use tree_sitter_language::LanguageFn;

#[allow(unsafe_code, reason = "the parser is in C")]
unsafe extern "C" {
    fn tree_sitter_librate() -> *const ();
}

/// The language, for `tree_sitter::Parser::set_language`.
#[allow(unsafe_code, reason = "it is the function that tree-sitter made for this")]
pub const LANGUAGE: LanguageFn = unsafe { LanguageFn::from_raw(tree_sitter_librate) };
