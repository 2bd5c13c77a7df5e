//! The places of the book (the open plane, the hallway and the apartment), a lobby, and
//! places that are hard for a filter ([`crate::generated_places`]).
//!
//! The book's own floor plans are not published. The two here were found by a
//! search for plans consistent with every digit the chapter prints; matching is
//! selection, not recovery. Say so wherever they are shown. The others are our own.

use std::sync::LazyLock;

use crate::generated_places;
use crate::world::World;
use crate::world_error::WorldError;
use crate::world_spec::WorldSpec;

/// The names that [`place`] knows, each with a line about it.
pub const PLACES: &[(&str, &str)] = &[
    ("open", "the plane without walls, 2 km across"),
    ("hallway", "a corridor 12 m long and 1.6 m wide with three identical doors"),
    ("apartment", "12 m by 9 m, five rooms off one corridor, with glass and two doors"),
    ("lobby", "12 m by 6 m between a front of glass and two rooms behind glass"),
    ("corridor", "48 m by 2 m with the same niche every 4 m"),
    ("twin-rooms", "two rooms, each the image of the other in half a turn"),
    ("workshop", "12 m by 9 m with 70 boxes at all angles"),
    ("warehouse", "51 m by 64 m with 1023 shelves: 4096 walls"),
];

/// The seed of the furniture of built-in places.
const SEED: u64 = 1;

static OPEN: LazyLock<World> = LazyLock::new(|| embedded(include_str!("../worlds/open.json")));
static HALLWAY: LazyLock<World> =
    LazyLock::new(|| embedded(include_str!("../worlds/hallway.json")));
static APARTMENT: LazyLock<World> =
    LazyLock::new(|| embedded(include_str!("../worlds/apartment.json")));
static LOBBY: LazyLock<World> = LazyLock::new(|| embedded(include_str!("../worlds/lobby.json")));

/// The plane without walls; bounds ±1000 m.
#[must_use]
pub fn open() -> World {
    OPEN.clone()
}

/// The Hallway: a corridor with three identical doors, each in a recess.
#[must_use]
pub fn hallway() -> World {
    HALLWAY.clone()
}

/// The Apartment: five rooms off one corridor.
#[must_use]
pub fn apartment() -> World {
    APARTMENT.clone()
}

/// The lobby: two rooms behind glass, and a front and a porch of glass.
#[must_use]
pub fn lobby() -> World {
    LOBBY.clone()
}

/// The place of that name, exactly as [`PLACES`] writes it; `None` if there is
/// none.
#[must_use]
pub fn place(name: &str) -> Option<World> {
    match name {
        "open" => Some(open()),
        "hallway" => Some(hallway()),
        "apartment" => Some(apartment()),
        "lobby" => Some(lobby()),
        "corridor" => Some(made(generated_places::corridor())),
        "twin-rooms" => Some(made(generated_places::twin_rooms())),
        "workshop" => Some(made(generated_places::workshop(SEED))),
        "warehouse" => Some(made(generated_places::warehouse(SEED))),
        _ => None,
    }
}

/// A world compiled into the program.
#[allow(
    clippy::expect_used,
    reason = "the text is a constant of this crate, and a test parses every one of them"
)]
fn embedded(text: &str) -> World {
    parse(text).expect("an embedded world must be valid; its test must have failed, too")
}

/// A world made by rule.
#[allow(clippy::expect_used, reason = "the rules are code of this crate, and a test calls all")]
fn made(spec: WorldSpec) -> World {
    World::new(spec).expect("a world made by rule must be valid; its test must have failed, too")
}

/// What can go wrong with a text, as a value.
fn parse(text: &str) -> Result<World, WorldError> {
    World::new(WorldSpec::from_json_str(text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_embedded_world_is_valid() {
        for text in [
            include_str!("../worlds/open.json"),
            include_str!("../worlds/hallway.json"),
            include_str!("../worlds/apartment.json"),
            include_str!("../worlds/lobby.json"),
        ] {
            assert_eq!(parse(text).map(|_| ()), Ok(()));
        }
    }

    #[test]
    fn every_place_is_known_by_its_name() {
        for (name, about) in PLACES {
            assert_eq!(place(name).unwrap().name(), *name);
            assert!(!about.is_empty());
        }
        assert!(place("Apartment").is_none());
        assert!(open().is_open() && !hallway().is_open());
        assert_eq!(hallway().walls().len(), 16);
        assert_eq!(apartment().walls().len(), 31);
    }
}
