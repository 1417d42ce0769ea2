//! How the library is linked.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // Importers unload it when they are done with an instance; threads that sweep large trees may still wait within it.
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}
