//! The table of a wire struct, checked against the compiler when it is built.

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

/// Mixes the fields of a struct into a hash.
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
