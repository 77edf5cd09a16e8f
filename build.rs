//! Names the shared library after its ABI, so that programs find the one they were linked with.

/// Rises only when the C interface breaks; it is the `N` of `libjostle.so.N` and `JOSTLE_ABI_VERSION` in the header
/// (the external-consumer test compares the two).
const ABI_VERSION: u32 = 0;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libjostle.so.{ABI_VERSION}");
        // A symbol that nothing defines is an error here and not in the program that loads the library.
        println!("cargo::rustc-cdylib-link-arg=-Wl,-z,defs");
    }
}
