//! No ONNX file makes its reader panic; a network that is taken in gives a load for a press.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel_learn::{Rows, onnx};

fuzz_target!(|data: &[u8]| {
    if let Ok(network) = onnx::import(data) {
        let columns = network.columns();
        let mut rows = Rows::new(columns);
        rows.push(1.0, vec![1.0; columns], 0.0);
        assert_eq!(network.estimate(&rows).len(), 1);
        let _ = onnx::export(&network);
    }
});
