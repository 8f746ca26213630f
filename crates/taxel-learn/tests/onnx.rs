//! Networks by scikit-learn and PyTorch, against onnxruntime's answers (testdata/onnx/check.py made both).

use std::path::Path;

use taxel_learn::{Rows, onnx};

fn agrees(name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/onnx");
    let network =
        onnx::import(&std::fs::read(folder.join(format!("{name}.onnx"))).unwrap()).unwrap();
    let text = std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
    let mut rows = Rows::new(8);
    let mut expected = Vec::new();
    for line in text.lines() {
        let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        rows.push(cells[0], cells[1..9].iter().copied(), 0.0);
        expected.push(cells[9]);
    }
    let largest = expected.iter().fold(0f64, |a, b| a.max(b.abs()));
    assert!(largest > 1.0);
    for (ours, theirs) in network.estimate(&rows).iter().zip(&expected) {
        assert!(
            (ours - theirs).abs() < 1e-5 * largest,
            "{ours} against {theirs}"
        );
    }
}

#[test]
fn a_network_by_scikit_learn_says_what_onnxruntime_says() {
    agrees("sklearn");
}

#[test]
fn a_network_by_pytorch_says_what_onnxruntime_says() {
    agrees("torch");
}
