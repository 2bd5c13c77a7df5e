//! The module: its size, what it asks for, and its numbers in an interpreter.

use std::io::Read as _;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use flate2::read::GzDecoder;
use rusty_tests::*;
use wasmi::{Engine, Instance, Linker, Module, Store, TypedFunc, WasmParams};

use crate::{built, element};

/// The module of a page: as it is packed, and as it is.
fn module(page: &Path) -> (Vec<u8>, Vec<u8>) {
    let packed = BASE64_STANDARD.decode(element(page, "module")).unwrap();
    let mut bytes = Vec::new();
    GzDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
    (packed, bytes)
}

#[test]
fn the_modules_import_nothing_and_are_small() {
    let Some(folder) = built() else { return };
    for (page, most) in [("seed-lab.html", 160_000), ("filters.html", 400_000)] {
        let (packed, bytes) = module(&folder.join(page));
        assert!(packed.len() <= most, "{page}: {} bytes with gzip", packed.len());
        let module = Module::new(&Engine::default(), &bytes).unwrap();
        assert_eq!(module.imports().map(|i| i.name().to_owned()).collect::<Vec<_>>(), [""; 0]);
    }
}

/// The module in an interpreter.
struct Held {
    store: Store<()>,
    instance: Instance,
}

impl Held {
    fn of(bytes: &[u8]) -> Self {
        let engine = Engine::default();
        let module = Module::new(&engine, bytes).unwrap();
        let mut store = Store::new(&engine, ());
        let instance = Linker::new(&engine).instantiate_and_start(&mut store, &module).unwrap();
        Self { store, instance }
    }

    fn call<P: WasmParams>(&mut self, name: &str, parameters: P) -> u32 {
        let function: TypedFunc<P, u32> = self.instance.get_typed_func(&self.store, name).unwrap();
        function.call(&mut self.store, parameters).unwrap()
    }

    /// The bytes of the latest text or numbers, elements of this size.
    fn bytes(&mut self, name: &str, size: usize) -> Vec<u8> {
        let at = self.call(name, ()) as usize;
        let length = self.call(&format!("{name}_length"), ()) as usize;
        let mut bytes = vec![0; length * size];
        let memory = self.instance.get_memory(&self.store, "memory").unwrap();
        memory.read(&self.store, at, &mut bytes).unwrap();
        bytes
    }

    fn text(&mut self) -> String {
        String::from_utf8(self.bytes("text", 1)).unwrap()
    }

    fn numbers(&mut self) -> Vec<f64> {
        let bytes = self.bytes("numbers", 8);
        bytes.chunks(8).map(|word| f64::from_le_bytes(word.try_into().unwrap())).collect()
    }

    fn open(&mut self, scenario: &str, seed: u64) -> u32 {
        let at = self.call("input", scenario.len() as u32);
        let memory = self.instance.get_memory(&self.store, "memory").unwrap();
        memory.write(&mut self.store, at as usize, scenario.as_bytes()).unwrap();
        self.call("begin", (seed, 0))
    }
}

/// The columns of a sweep in the order of the module's figures.
const COLUMNS: [&str; 12] = [
    "ticks",
    "time_s",
    "distance_m",
    "final_position_error_m",
    "final_heading_error_rad",
    "mean_position_error_m",
    "ate_rmse_m",
    "p95_position_error_m",
    "max_position_error_m",
    "rmse_heading_error_rad",
    "max_heading_error_rad",
    "blocked_ticks",
];

#[test]
fn the_seed_lab_has_the_table_of_a_sweep_to_the_bit() {
    let Some(pages) = built() else { return };
    let mut held = Held::of(&module(&pages.join("seed-lab.html")).1);
    let scenario = "name=seed-lab\nticks=30\ndt_s=0.1\nscan_every=0\nworld=open\n\
                    start.x_m=0\nstart.y_m=0\nstart.theta_rad=0\nrobot.slip_std=0.05\n\
                    robot.radius_bias_right=0.01\nscript.kind=straight\nscript.v_m_s=0.5\n\
                    floor.bounds.0=-1000\nfloor.bounds.1=-1000\nfloor.bounds.2=1000\n\
                    floor.bounds.3=1000\n";
    let place = folder();
    let table = place.at("lab.csv");
    let sweep = "sweep seed-lab --seeds 7..12 --ticks 30 --set dt_s=0.1 --set robot.slip_std=0.05 \
                 --set robot.radius_bias_right=0.01 --out";
    let words: Vec<&str> = sweep.split_whitespace().chain([arg(&table)]).collect();
    sim_server(&words).expect(0);
    let table = Table::read(&table);
    assert_eq!(held.open(scenario, 0), 1, "{}", held.text());
    assert_eq!(held.call("lab", (7u64, 5u32)), 1, "{}", held.text());
    assert_eq!(held.text().lines().collect::<Vec<_>>(), table.column("digest"));
    let numbers = held.numbers();
    let rows: Vec<&[f64]> = numbers.chunks(COLUMNS.len() + 6 * 30).collect();
    assert_eq!(rows.len(), 5);
    for (i, column) in COLUMNS.iter().enumerate() {
        let found = rows.iter().map(|row| row[i].to_bits());
        let expected = table.numbers(column).into_iter().map(f64::to_bits);
        assert!(found.eq(expected), "{column}");
    }
}

#[test]
fn what_cannot_be_simulated_here_is_refused_by_name() {
    let Some(pages) = built() else { return };
    let mut held = Held::of(&module(&pages.join("seed-lab.html")).1);
    for (scenario, named) in [
        ("robot.slip_std=much", "robot.slip_std=much"),
        ("lidar.divergence_rad=0.1", "lidar.divergence_rad"),
        ("robot.slip_std=-1", "robot.slip_std"),
        ("participant.0.name=ekf\nparticipant.0.command.0=ekf", "ekf"),
    ] {
        let floor = "floor.bounds.0=-9\nfloor.bounds.1=-9\nfloor.bounds.2=9\nfloor.bounds.3=9";
        assert_eq!(held.open(&format!("{floor}\n{scenario}"), 1), 0);
        assert!(held.text().contains(named), "{scenario}: {}", held.text());
        assert_eq!(held.call("advance", 5u32), 0, "no run of it goes on");
    }
}
