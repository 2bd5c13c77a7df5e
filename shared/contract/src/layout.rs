//! The tables of the wire structs, and the hash that tells two layouts apart.
//!
//! A transport that compares only name, size and alignment lets reordered
//! fields of equal size pass. So every wire struct has a table here, checked
//! against the compiler at build time, and the hash of all tables travels in
//! the names of the types and in every request to join.

use crate::field_table::hash_fields;
pub use crate::field_table::{Field, Table};

/// All wire structs, in the order in which a tick meets them.
#[must_use]
pub fn tables() -> [Table; 4] {
    [
        Table { name: "Frame", size: 10840, fields: crate::frame::FRAME_FIELDS },
        Table { name: "Answer", size: 192, fields: crate::answer::ANSWER_FIELDS },
        Table { name: "Tally", size: 3384, fields: crate::tally::TALLY_FIELDS },
        Table { name: "TallyEntry", size: 208, fields: crate::tally::TALLY_ENTRY_FIELDS },
    ]
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
