//! Every way in which the session's threads can take turns, or thousands of them drawn by chance: the very files of the
//! queue and the recorder, with shuttle's locks and threads in place of the system's.
//!
//! `cargo test --features taxel-app/models --test models`. A failure prints a schedule that `shuttle::replay` takes.

#![allow(dead_code, reason = "the models use a part of each file")]

mod error {
    pub use taxel_app::Error;
}
mod session;
