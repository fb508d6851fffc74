//! Mistakes and warnings as tables: what each is called, its code, what it holds, what is said of it and where.
//!
//! An entry reads like a variant of a `thiserror` enum with the code in front of its name and, behind `=>`, what a person is
//! shown: a place with a label, a second place, the fix. All fields can be named there, as references; the place in the file
//! stands in parentheses behind the name. Codes never change, and [`explain`](crate::explain::explain) tells more about each.

/// Makes an enum of such entries; what other stages say goes through behind `else`.
#[macro_export]
macro_rules! mistakes {
    (
        $(#[$meta:meta])* $severity:ident $name:ident {
            $(
                $(#[$own:meta])*
                $code:literal $variant:ident $(($place:ident))?
                    $({ $($(#[$doc:meta])* $field:ident: $type:ty),* $(,)? })? => $shown:expr,
            )*
        }
        $(else { $($(#[$passed:meta])* $stage:ident($(#[$from:ident])? $error:ty),)* })?
    ) => {
        $(#[$meta])*
        #[non_exhaustive]
        pub enum $name {
            $($(#[$own])* $variant {
                $($($(#[$doc])* $field: $type,)*)?
                $(#[doc = "The place in the model file."] $place: $crate::span::Span,)?
            },)*
            $($($(#[$passed])* $stage($(#[$from])? $error),)*)?
        }

        impl $name {
            /// The code of this kind, `E0012` or `W0001`: it never changes, and
            /// `librate explain` tells more about it.
            #[must_use]
            pub fn code(&self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $code,)*
                    $($(Self::$stage(error) => error.code(),)*)?
                }
            }
        }

        impl From<&$name> for $crate::diagnostic::Diagnostic {
            fn from(error: &$name) -> Self {
                #[allow(unused_variables, reason = "an entry need not show all that it holds")]
                let shown = match error {
                    $($name::$variant { $($($field,)*)? $($place)? } => $shown,)*
                    $($($name::$stage(error) => return error.into(),)*)?
                };
                shown.told($crate::diagnostic::Severity::$severity, error.to_string(), error.code())
            }
        }
    };
}
