//! Networks that come back as they went, and files that lie.

use super::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

#[test]
fn what_is_exported_is_imported_the_same() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let model = PaperMlp {
        network: Mlp::new(&[9, 5, 4, 1], false, &mut random),
        scaler: Scaler {
            mean: (0..9).map(|i| 20.0 + i as f32).collect(),
            deviation: (0..9).map(|i| 1.0 + i as f32).collect(),
        },
    };
    let again = import(&export(&model)).unwrap();
    assert_eq!(again.network, model.network);
    for (a, b) in again.scaler.mean.iter().zip(&model.scaler.mean) {
        assert!((a - b).abs() < 1e-4);
    }
}

#[test]
fn bytes_that_are_no_onnx_are_refused() {
    for bytes in [
        &b""[..],
        b"not onnx at all",
        &[0x3a, 0xff, 0xff, 0xff, 0xff, 0xff],
    ] {
        assert!(import(bytes).is_err());
    }
}

/// A file of one graph: operators with their inputs (and an attribute's bytes), then constants.
fn file(nodes: &[(&str, &[&str])], constants: &[(&str, &[usize], &[f32])]) -> Vec<u8> {
    let mut graph = Graph::default();
    for (operator, inputs) in nodes {
        graph.push_node(operator, inputs, "x");
    }
    for (name, shape, values) in constants {
        graph.push_tensor(name, shape, values);
    }
    of_graph(&graph)
}

fn of_graph(graph: &Graph) -> Vec<u8> {
    let model = Model {
        graph: Some(graph.encode_to_vec().into()),
        ..Model::default()
    };
    model.encode_to_vec()
}

#[test]
fn files_that_unpack_to_many_times_their_size_are_refused_before_that() {
    // Two bytes of a file each.
    let error = import(&[8u8, 0].repeat(MAX_PARTS + 1)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("the file has more than 8000 parts"),
        "{error}"
    );
    let empty = |count: usize| vec![Bytes::new(); count];
    let graph = Graph {
        node: empty(MAX_PARTS + 1),
        ..Graph::default()
    };
    let error = import(&of_graph(&graph)).unwrap_err();
    assert!(
        error.to_string().contains("the graph has more than"),
        "{error}"
    );
    let node = Node {
        attribute: empty(MAX_PARTS + 1),
        ..Node::default()
    };
    let graph = Graph {
        node: vec![node.encode_to_vec().into()],
        ..Graph::default()
    };
    let error = import(&of_graph(&graph)).unwrap_err();
    assert!(
        error.to_string().contains("an operator has more than"),
        "{error}"
    );
    // One field of packed dimensions, a byte each.
    let mut tensor = vec![0x0a, 0x80, 0x08];
    tensor.extend([1; 1024]);
    let graph = Graph {
        initializer: vec![tensor.into()],
        ..Graph::default()
    };
    let error = import(&of_graph(&graph)).unwrap_err();
    assert!(
        error.to_string().contains("1024 bytes of dimensions"),
        "{error}"
    );
}

#[test]
fn headers_that_lie_are_refused_before_memory_is_taken_for_them() {
    let w = |shape: &[usize], values: &[f32]| {
        import(&file(&[("MatMul", &["x", "w"])], &[("w", shape, values)]))
            .unwrap_err()
            .to_string()
    };
    assert!(w(&[usize::MAX, usize::MAX], &[1.0]).contains("1 weights for"));
    assert!(w(&[3, 0], &[]).contains("0 weights for 3 x 0"));
    assert!(w(&[1; 9], &[1.0]).contains("more than 8 dimensions"));
    assert!(w(&[1], &[1.0]).contains("weights of shape [1]"));
    assert!(w(&[2, 1], &[1.0, f32::NAN]).contains("holds NaN"));
    // One constant, many layers of it: little of a file, much of a memory.
    let square = vec![0.0; 1000 * 1000];
    let many = vec![("MatMul", &["x", "w"][..]); 12];
    let error = import(&file(&many, &[("w", &[1000, 1000], &square)]))
        .unwrap_err()
        .to_string();
    assert!(
        error.to_string().contains("more than 8388608 weights"),
        "{error}"
    );
    let many = vec![("Identity", &["x"][..]); MAX_NODES + 1];
    assert!(
        import(&file(&many, &[]))
            .unwrap_err()
            .to_string()
            .contains("more than 1000")
    );
}

#[test]
fn numbers_that_do_not_go_with_the_layers_are_refused() {
    let constants: [(&str, &[usize], &[f32]); 4] = [
        ("w", &[2, 2], &[1.0, 0.0, 0.0, 1.0]),
        ("three", &[3], &[1.0, 2.0, 3.0]),
        ("two", &[2], &[1.0, 2.0]),
        ("none", &[0], &[]),
    ];
    let error =
        |nodes: &[(&str, &[&str])]| import(&file(nodes, &constants)).unwrap_err().to_string();
    let layer: (&str, &[&str]) = ("MatMul", &["x", "w"]);
    let after = error(&[layer, ("Add", &["x", "three"])]);
    assert!(after.contains("3 numbers for 2 outputs"), "{after}");
    let empty = error(&[("Sub", &["x", "none"]), layer]);
    assert!(empty.contains("0 numbers after one of 1"), "{empty}");
    let both = error(&[("Sub", &["x", "two"]), ("Div", &["x", "three"]), layer]);
    assert!(both.contains("3 numbers after one of"), "{both}");
    // A StandardScaler without its attributes.
    assert!(error(&[("Scaler", &["x"]), layer]).contains("0 numbers"));
    let relu = error(&[layer, ("Relu", &["x"]), ("Mul", &["x", "two"]), layer]);
    assert!(relu.contains("a factor after a Relu"), "{relu}");
}
