// SPDX-License-Identifier: MIT
// $ECTWIN_LIBDIR has libectwin.so: a build of ectwin, or the lib folder of an installation.
fn main() {
    println!("cargo:rerun-if-env-changed=ECTWIN_LIBDIR");
    if let Ok(folder) = std::env::var("ECTWIN_LIBDIR") {
        println!("cargo:rustc-link-search=native={folder}");
        println!("cargo:rustc-link-arg=-Wl,-rpath,{folder}");
    }
    println!("cargo:rustc-link-lib=dylib=ectwin");
}
