//! What options are chosen by, one method a field.

/// Makes methods of a struct of options that put another value into a field of the same name.
#[macro_export]
macro_rules! choices {
    ($($(#[$doc:meta])* $field:ident: $type:ty,)*) => {
        $(
            $(#[$doc])*
            #[must_use]
            pub fn $field(mut self, $field: $type) -> Self {
                self.$field = $field;
                self
            }
        )*
    };
}
