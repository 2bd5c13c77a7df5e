//! The same world without an operating system: the golden runs as a module in
//! WebAssembly, computed by an interpreter (wasmi), by a compiler (the V8 of Node) and
//! by a browser, with the digests that native code has.

use std::sync::OnceLock;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use rusty_sim::GOLDENS;
use rusty_tests::browser::Browser;
use rusty_tests::*;
use wasmi::{Engine, Linker, Module, Store};

const TARGET: &str = "wasm32-unknown-unknown";

/// What the table says, in order.
fn expected() -> Vec<&'static str> {
    GOLDENS.iter().map(|golden| golden.expected).collect()
}

/// Whether the compiler has a standard library for the target.
fn target_is_installed() -> bool {
    let mut ask = Command::new("rustc");
    ask.current_dir(repository()).args(["--print", "target-libdir", "--target", TARGET]);
    let said = ask.output().unwrap();
    assert!(said.status.success(), "{ask:?}: {}", String::from_utf8_lossy(&said.stderr));
    let folder = String::from_utf8(said.stdout).unwrap();
    fs::read_dir(folder.trim()).is_ok_and(|mut entries| entries.next().is_some())
}

/// The module, built once; `None`, with a printed reason, where the compiler
/// cannot. It is built next to the binaries under test, where what runs while building
/// (derive macros) is there already, and with the widgets, which use the same crates.
fn module() -> Option<&'static PathBuf> {
    static MODULE: OnceLock<Option<PathBuf>> = OnceLock::new();
    let module = MODULE.get_or_init(|| {
        if !target_is_installed() {
            skipped(&format!("no {TARGET} here; `rustup target add {TARGET}` installs it"));
            return None;
        }
        let folder = binaries().parent().unwrap();
        let mut build = Command::new(env!("CARGO"));
        build.current_dir(repository()).args(["build", "--quiet", "--profile", "widgets"]);
        build.args(["--lib", "-p", "rusty-wasm-goldens", "-p", "rusty-widgets"]);
        build.args(["--target", TARGET]).arg("--target-dir").arg(folder);
        // Flags for the CPU of these tests are none for WebAssembly.
        build.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
        assert!(build.status().unwrap().success(), "{TARGET}: the world does not build");
        Some(folder.join(TARGET).join("widgets/rusty_wasm_goldens.wasm"))
    });
    module.as_ref()
}

#[test]
fn an_interpreter_of_webassembly_computes_the_same_bits() {
    let Some(path) = module() else { return };
    let engine = Engine::default();
    let module = Module::new(&engine, fs::read(path).unwrap()).unwrap();
    // No clock, no file, no randomness: there is nothing the module asks for.
    assert_eq!(module.imports().map(|i| i.name().to_owned()).collect::<Vec<_>>(), [""; 0]);
    let mut store = Store::new(&engine, ());
    let linker = Linker::new(&engine);
    let instance = linker.instantiate_and_start(&mut store, &module).unwrap();
    let count = instance.get_typed_func::<(), u32>(&store, "golden_count").unwrap();
    let digest = instance.get_typed_func::<u32, u32>(&store, "golden_digest").unwrap();
    let memory = instance.get_memory(&store, "memory").unwrap();

    let count = count.call(&mut store, ()).unwrap();
    let mut found = Vec::new();
    for index in 0..count {
        let address = digest.call(&mut store, index).unwrap();
        let mut digits = [0; 32];
        memory.read(&store, address as usize, &mut digits).unwrap();
        found.push(String::from_utf8(digits.to_vec()).unwrap());
    }
    assert_eq!(found, expected());
    assert_eq!(digest.call(&mut store, count).unwrap(), 0, "there is no run after the last");
}

#[test]
fn a_log_recorded_in_webassembly_has_the_same_bytes() {
    let Some(path) = module() else { return };
    let engine = Engine::default();
    let module = Module::new(&engine, fs::read(path).unwrap()).unwrap();
    let mut store = Store::new(&engine, ());
    let instance = Linker::new(&engine).instantiate_and_start(&mut store, &module).unwrap();
    let record = instance.get_typed_func::<u32, u32>(&store, "golden_log").unwrap();
    let length = instance.get_typed_func::<(), u32>(&store, "golden_log_length").unwrap();
    let memory = instance.get_memory(&store, "memory").unwrap();
    // A driver's commands as a list, and a script with a name.
    for name in ["apartment-driven", "apartment-sensed"] {
        let index = GOLDENS.iter().position(|golden| golden.name == name).unwrap();
        let address = record.call(&mut store, index as u32).unwrap();
        let length = length.call(&mut store, ()).unwrap();
        let mut bytes = vec![0; length as usize];
        memory.read(&store, address as usize, &mut bytes).unwrap();
        let native = GOLDENS[index].record().unwrap().write(Vec::new()).unwrap();
        assert!(bytes == native, "{name}: {} and {} bytes", bytes.len(), native.len());
    }
    assert_eq!(record.call(&mut store, GOLDENS.len() as u32).unwrap(), 0);
}

/// Asks a module for its digests, a line each.
const SCRIPT: &str = "
    const bytes = require('fs').readFileSync(process.argv[1]);
    WebAssembly.instantiate(bytes, {}).then(({ instance: { exports } }) => {
        for (let i = 0; i < exports.golden_count(); i++) {
            const at = exports.golden_digest(i);
            console.log(Buffer.from(exports.memory.buffer, at, 32).toString());
        }
    });";

#[test]
fn the_compiler_of_a_browser_computes_the_same_bits() {
    let Some(path) = module() else { return };
    if Command::new("node").arg("--version").output().is_err() {
        skipped("there is no node on the path, so V8 was not asked");
        return;
    }
    let node = Process::spawn(Command::new("node").args(["-e", SCRIPT]).arg(path));
    let said = node.wait().expect(0).stdout;
    assert_eq!(said.lines().collect::<Vec<_>>(), expected());
}

/// A page that computes the digests of the module in it.
const PAGE: &str = "<!doctype html><script>
    const bytes = Uint8Array.from(atob('MODULE'), (c) => c.charCodeAt(0));
    WebAssembly.instantiate(bytes, {}).then(({ instance: { exports } }) => {
        globalThis.digests = Array.from({ length: exports.golden_count() }, (_, i) => {
            const at = exports.golden_digest(i);
            return new TextDecoder().decode(new Uint8Array(exports.memory.buffer, at, 32));
        });
    });</script>";

#[test]
fn a_browser_computes_the_same_bits() {
    let Some(path) = module() else { return };
    let Some(mut browser) = Browser::start() else { return };
    let (folder, module) = (folder(), BASE64_STANDARD.encode(fs::read(path).unwrap()));
    folder.write("goldens.html", PAGE.replace("MODULE", &module));
    browser.open(&folder.at("goldens.html"), "");
    browser.until("globalThis.digests");
    assert_eq!(browser.value("digests"), json!(expected()));
}
