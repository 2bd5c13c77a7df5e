//! The tables of the wire structs, and the hash that tells two layouts apart.
//!
//! A transport that compares only name, size and alignment lets reordered
//! fields of equal size pass. So every wire struct has a table here, checked
//! against the compiler at build time, and the hash of all tables travels in
//! the names of the types and in every request to join.

use serde::Serialize;
use xxhash_rust::const_xxh3::xxh3_64 as const_xxh3_64;

/// One field of a wire struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Field {
    /// Name of the field, with its unit.
    pub name: &'static str,
    /// Type, as Rust spells it.
    #[serde(rename = "type")]
    pub ty: &'static str,
    /// Bytes from the start of the struct.
    pub offset: usize,
    /// Bytes.
    pub size: usize,
}

/// One wire struct: its name, its size and its fields in order.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Table {
    /// Name of the struct.
    pub name: &'static str,
    /// Bytes of the whole struct; alignment is 8 throughout.
    pub size: usize,
    /// The fields, without gaps.
    pub fields: &'static [Field],
}

/// Declares the table of a struct and lets the compiler check it: every
/// offset, no gap, no padding at the end.
macro_rules! field_table {
    ($(#[$doc:meta])* pub const $table:ident for $ty:ty, size $total:literal {
        $($name:ident : $kind:literal at $offset:literal, $size:literal;)*
    }) => {
        $(#[$doc])*
        pub const $table: &[Field] = &[
            $(Field { name: stringify!($name), ty: $kind, offset: $offset, size: $size },)*
        ];
        const _: () = {
            assert!(std::mem::size_of::<$ty>() == $total);
            assert!(std::mem::align_of::<$ty>() == 8);
            $(assert!(std::mem::offset_of!($ty, $name) == $offset);)*
            let mut next = 0;
            let mut i = 0;
            while i < $table.len() {
                assert!($table[i].offset == next, "a gap or an overlap between fields");
                next += $table[i].size;
                i += 1;
            }
            assert!(next == $total, "padding at the end");
        };
    };
}
pub(crate) use field_table;

/// All wire structs, in the order in which a tick meets them.
#[must_use]
pub fn tables() -> [Table; 4] {
    [
        Table { name: "Frame", size: 8888, fields: crate::frame::FRAME_FIELDS },
        Table { name: "Answer", size: 192, fields: crate::answer::ANSWER_FIELDS },
        Table { name: "Tally", size: 3384, fields: crate::tally::TALLY_FIELDS },
        Table { name: "TallyEntry", size: 208, fields: crate::tally::TALLY_ENTRY_FIELDS },
    ]
}

pub(crate) const fn hash_fields(mut hash: u64, fields: &[Field]) -> u64 {
    let mut i = 0;
    while i < fields.len() {
        let f = fields[i];
        hash ^= const_xxh3_64(f.name.as_bytes()).rotate_left(1);
        hash = hash.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        hash ^= const_xxh3_64(f.ty.as_bytes()).rotate_left(2);
        hash = hash.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        hash ^= ((f.offset as u64) << 32) | f.size as u64;
        hash = hash.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        i += 1;
    }
    hash
}

/// A hash of every field's name, type, offset and size.
///
/// Two builds with the same hash read each other's memory.
#[must_use]
pub const fn layout_hash() -> u64 {
    let mut hash = crate::PROTOCOL_VERSION as u64;
    hash = hash_fields(hash, crate::frame::FRAME_FIELDS);
    hash = hash_fields(hash, crate::answer::ANSWER_FIELDS);
    hash = hash_fields(hash, crate::tally::TALLY_FIELDS);
    hash_fields(hash, crate::tally::TALLY_ENTRY_FIELDS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_sees_names_types_offsets_and_order() {
        const A: &[Field] = &[
            Field { name: "a", ty: "u64", offset: 0, size: 8 },
            Field { name: "b", ty: "u64", offset: 8, size: 8 },
        ];
        const B: &[Field] = &[
            Field { name: "b", ty: "u64", offset: 0, size: 8 },
            Field { name: "a", ty: "u64", offset: 8, size: 8 },
        ];
        const C: &[Field] = &[
            Field { name: "a", ty: "f64", offset: 0, size: 8 },
            Field { name: "b", ty: "u64", offset: 8, size: 8 },
        ];
        let (a, b, c) = (hash_fields(1, A), hash_fields(1, B), hash_fields(1, C));
        assert!(a != b && a != c && b != c);
    }

    #[test]
    fn the_tables_are_as_large_as_their_structs() {
        for table in tables() {
            let sum: usize = table.fields.iter().map(|f| f.size).sum();
            assert_eq!(sum, table.size, "{}", table.name);
        }
    }
}
