//! The code of a budget that is used up: E0901.

use super::Exceeded;

impl Exceeded {
    /// The code of this kind of mistake: it never changes, and [`explain`](crate::explain::explain) tells more about it.
    #[must_use]
    pub fn code(&self) -> &'static str {
        "E0901"
    }
}
