//! Takes the versions of the peers from the lock file.

fn main() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.lock");
    println!("cargo::rerun-if-changed={path}");
    let lock = std::fs::read_to_string(path).unwrap_or_default();
    for name in ["rapier3d", "box3d-sys"] {
        let entry = format!("name = \"{name}\"\nversion = \"");
        let rest = lock.split(&entry).nth(1).and_then(|rest| rest.split('"').next());
        let key = name.replace('-', "_").to_uppercase();
        println!("cargo::rustc-env={key}_VERSION={}", rest.unwrap_or("unknown"));
    }
}
