//! The handbook's table of random streams is that of the code.

use rusty_sim::noise::Source;

use crate::read;

/// The rows of the table: number, name and slots per tick.
fn rows() -> Vec<[String; 3]> {
    let page = read("docs/sensors.md");
    let (_, section) = page.split_once("\n## Noise\n").unwrap();
    let table = section.lines().skip_while(|line| !line.starts_with('|'));
    let lines = table.skip(2).take_while(|line| line.starts_with('|'));
    let cells = |line: &str| {
        let cells: Vec<String> = line.split('|').map(|cell| cell.trim().replace('`', "")).collect();
        [1, 2, 4].map(|i| cells[i].clone())
    };
    lines.map(cells).collect()
}

#[test]
fn the_table_of_streams_is_that_of_the_code() {
    let row = |source: Source| {
        let slots = source.tick_words().map_or("–".to_owned(), |words| (words / 2).to_string());
        let number = match source {
            Source::Own(first) => format!("2^{} + n", (source.number() - u64::from(first)).ilog2()),
            _ => source.number().to_string(),
        };
        [number, source.name().to_owned(), slots]
    };
    let expected: Vec<_> = Source::BUILT_IN.into_iter().chain([Source::Own(0)]).map(row).collect();
    assert_eq!(rows(), expected, "left: docs/sensors.md, right: the code");
}
