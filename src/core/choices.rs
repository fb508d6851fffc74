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

/// Makes an enum of variants with their words, and the method that gives these; and a list of all variants, where it has a name.
#[macro_export]
macro_rules! worded {
    (
        $(#[$meta:meta])* $name:ident {
            $($(#[$own:meta])* $variant:ident $word:literal,)*
        } $(#[$doc:meta])* $method:ident $(#[$about:meta])* $all:ident
    ) => {
        $crate::worded! {
            $(#[$meta])* $name { $($(#[$own])* $variant $word,)* } $(#[$doc])* $method
        }

        impl $name {
            $(#[$about])*
            pub const $all: [Self; [$($word),*].len()] = [$(Self::$variant),*];
        }
    };
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
