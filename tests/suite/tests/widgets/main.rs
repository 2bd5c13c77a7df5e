//! The widgets: a module without imports, and pages whose digests are those of the
//! commands that they show.

mod module;
mod pages;

use std::sync::OnceLock;

use rusty_tests::*;

/// The folder with the pages, written once; `None`, with a printed reason, where the
/// compiler cannot build for WebAssembly.
fn built() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        let out = binaries().parent().unwrap().join("widgets-tested");
        // A first build compiles the world twice.
        let limit = Duration::from_secs(1800);
        let mut widgets = Command::new(binary("widgets"));
        let ended = Process::spawn(widgets.args(["--out", arg(&out)])).wait_within(limit);
        if ended.code != Some(0) && ended.stderr.contains("rustup target add") {
            skipped(ended.stderr.trim());
            return None;
        }
        ended.expect(0);
        Some(out)
    });
    built.as_deref()
}

/// The text of an element of a page's file.
fn element(page: &Path, id: &str) -> String {
    let html = fs::read_to_string(page).unwrap();
    let (_, rest) = html.split_once(&format!("id=\"{id}\">")).unwrap();
    rest.split("</script>").next().unwrap().to_owned()
}
