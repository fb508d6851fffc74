//! What is declared in a table: options, chosen by one method a field, and enums whose variants have a word each.

/// Makes methods of a struct of options that put another value into a field of the same name.
#[macro_export]
macro_rules! choices {
    ($($(#[$doc:meta])* $field:ident: $type:ty,)*) => {
        $(
            $(#[$doc])*
            pub fn $field(mut self, $field: $type) -> Self {
                self.$field = $field;
                self
            }
        )*
    };
}

/// Makes an enum of variants with their words, and the method that gives these.
#[macro_export]
macro_rules! worded {
    (
        $(#[$meta:meta])* $name:ident {
            $($(#[$own:meta])* $variant:ident $word:literal,)*
        } $(#[$doc:meta])* $method:ident
    ) => {
        $(#[$meta])*
        pub enum $name {
            $($(#[$own])* $variant,)*
        }

        impl $name {
            $(#[$doc])*
            #[must_use]
            pub const fn $method(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)*
                }
            }
        }
    };
}
