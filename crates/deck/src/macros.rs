//! The one place where a key is written: its name, type, default and documentation make the reader and the docs.

/// A table of the deck. Each key has `= required`, `= optional`, `= default("text as in a deck")` or `= flatten` (the
/// keys of another type stand in this table, too).
macro_rules! deck_table {
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident {
            $( $(#[doc = $key_doc:literal])* $key:ident : $type:ty = $presence:ident $(($default:literal))? ,)*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug)]
        pub struct $name {
            $( $(#[doc = $key_doc])* pub $key: $crate::macros::field_type!($presence $type), )*
            /// Where the table stands.
            pub span: $crate::diagnostics::Span,
        }

        impl $crate::decoder::ReadKeys for $name {
            fn keys() -> $crate::schema::TableSchema {
                let mut schema = $crate::schema::TableSchema { doc: concat!($($doc, "\n"),*), ..Default::default() };
                $( $crate::macros::describe_key!(
                    schema, $presence $(($default))?, $key, concat!($($key_doc, "\n"),*), $type); )*
                schema
            }

            fn read(reader: &mut $crate::decoder::TableReader<'_, '_>) -> Option<Self> {
                $( let $key = $crate::macros::read_key!(reader, $presence $(($default))?, $key, $type); )*
                Some(Self { $( $key: $key?, )* span: reader.span() })
            }
        }

        $crate::macros::decode_as_table!($name);
    };
}

/// Keys of a table that depend on the value of one of them, the tag; `or` names the value of a tag that is not there.
macro_rules! deck_variants {
    (
        $(#[doc = $doc:literal])*
        pub enum $name:ident by $tag:ident $(or $absent:literal)? {
            $( $(#[doc = $case_doc:literal])* $case:ident = $choice:literal {
                $( $(#[doc = $key_doc:literal])* $key:ident : $type:ty = $presence:ident $(($default:literal))? ,)*
            } )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug)]
        pub enum $name {
            $( $(#[doc = $case_doc])* $case {
                $( $(#[doc = $key_doc])* $key: $crate::macros::field_type!($presence $type), )*
            }, )*
        }

        impl $crate::decoder::ReadKeys for $name {
            fn keys() -> $crate::schema::TableSchema {
                let mut cases = Vec::new();
                $( {
                    #[allow(unused_mut)]
                    let mut schema = $crate::schema::TableSchema::default();
                    $( $crate::macros::describe_key!(
                        schema, $presence $(($default))?, $key, concat!($($key_doc, "\n"),*), $type); )*
                    let choice = $crate::schema::Choice { name: $choice, doc: concat!($($case_doc, "\n"),*) };
                    cases.push((choice, schema.keys));
                } )*
                let default = [$($absent)?].first().copied();
                let variants = $crate::schema::Variants {
                    tag: stringify!($tag), doc: concat!($($doc, "\n"),*), default, cases
                };
                $crate::schema::TableSchema { variants: vec![variants], ..Default::default() }
            }

            fn read(reader: &mut $crate::decoder::TableReader<'_, '_>) -> Option<Self> {
                let variants = Self::keys().variants.swap_remove(0);
                let chosen = reader.tag(stringify!($tag), &variants)?;
                $( if chosen == $choice {
                    $( let $key = $crate::macros::read_key!(reader, $presence $(($default))?, $key, $type); )*
                    return Some(Self::$case { $( $key: $key?, )* });
                } )*
                None
            }
        }

        $crate::macros::decode_as_table!($name);
    };
}

/// One of several names, each standing for a value of `$type`.
macro_rules! deck_choice {
    ($type:ty { $( $name:literal => $value:expr, $doc:literal; )* }) => {
        impl $crate::decoder::FromDeck for $type {
            fn schema() -> $crate::schema::Schema {
                $crate::schema::Schema::Choice(
                    vec![$( $crate::schema::Choice { name: $name, doc: $doc } ),*])
            }

            fn decode(
                node: &$crate::tree::Node,
                decoder: &mut $crate::decoder::Decoder,
            ) -> Option<Self> {
                decoder.choice(node, &[$( ($crate::schema::Choice { name: $name, doc: $doc }, $value) ),*])
            }
        }
    };
}

macro_rules! decode_as_table {
    ($name:ident) => {
        impl $crate::decoder::FromDeck for $name {
            fn schema() -> $crate::schema::Schema {
                $crate::schema::Schema::Table(<Self as $crate::decoder::ReadKeys>::keys())
            }

            fn decode(node: &$crate::tree::Node, decoder: &mut $crate::decoder::Decoder) -> Option<Self> {
                decoder.table(node)
            }
        }
    };
}

macro_rules! field_type {
    (optional $type:ty) => { Option<$type> };
    ($presence:ident $type:ty) => { $type };
}

macro_rules! describe_key {
    ($schema:ident, flatten, $key:ident, $doc:expr, $type:ty) => {
        $schema.absorb(<$type as $crate::decoder::ReadKeys>::keys())
    };
    ($schema:ident, $presence:ident $(($default:literal))?, $key:ident, $doc:expr, $type:ty) => {
        $schema.keys.push($crate::schema::KeySchema {
            name: stringify!($key),
            doc: $doc,
            presence: $crate::macros::presence!($presence $(($default))?),
            value: <$type as $crate::decoder::FromDeck>::schema(),
        })
    };
}

macro_rules! presence {
    (required) => {
        $crate::schema::Presence::Required
    };
    (optional) => {
        $crate::schema::Presence::Optional
    };
    (default($default:literal)) => {
        $crate::schema::Presence::Default($default)
    };
}

macro_rules! read_key {
    ($reader:ident, required, $key:ident, $type:ty) => {
        $reader.required::<$type>(stringify!($key))
    };
    ($reader:ident, optional, $key:ident, $type:ty) => {
        $reader.optional::<$type>(stringify!($key))
    };
    ($reader:ident, default($default:literal), $key:ident, $type:ty) => {
        $reader.default::<$type>(stringify!($key), $default)
    };
    ($reader:ident, flatten, $key:ident, $type:ty) => {
        <$type as $crate::decoder::ReadKeys>::read($reader)
    };
}

pub(crate) use {
    deck_choice, deck_table, deck_variants, decode_as_table, describe_key, field_type, presence, read_key,
};
