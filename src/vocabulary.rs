//! Closed vocabularies: the words that reports and files have for the values of an enumeration, each written once.

/// An enumeration whose values have a word in reports and files: the type, `name`, `ALL`, its text, its JSON and its JSON Schema, which lists the words.
macro_rules! vocabulary {
    ($(#[$of_type:meta])* $type:ident { $($(#[$of_value:meta])* $value:ident = $word:literal),* $(,)? }) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        $(#[$of_type])*
        #[non_exhaustive]
        pub enum $type {
            $($(#[$of_value])* #[serde(rename = $word)] $value,)*
        }

        impl $type {
            /// All of them.
            pub const ALL: [$type; [$($word),*].len()] = [$($type::$value),*];

            /// As reports and files write it.
            pub const fn name(self) -> &'static str {
                match self {
                    $($type::$value => $word,)*
                }
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }
    };
}

pub(crate) use vocabulary;
