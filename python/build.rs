//! A plain `cargo build` links on macOS as well, where what Python itself has is found only when the module is loaded.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
