//! Factors and inverses by what they multiply to.

use taxel_linalg::{
    Spd, View, ViewMut, dot, inverse, inverse_symmetric, multiply, solve_symmetric,
};

fn example(n: usize) -> Vec<f64> {
    let mut matrix = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            matrix[i * n + j] = 1.0 / (1.0 + i.abs_diff(j) as f64);
        }
        matrix[i * n + i] += n as f64;
    }
    matrix
}

#[test]
fn inverse_times_matrix_is_identity() {
    for n in [1, 2, 7, 33, 64] {
        let matrix = example(n);
        let mut spd = Spd::new(n);
        assert!(spd.factorise(&matrix));
        let (mut inv, mut product) = (vec![0.0; n * n], vec![0.0; n * n]);
        spd.inverse_into(&mut inv);
        multiply(
            ViewMut::new(&mut product, n, n),
            View::new(&matrix, n, n),
            View::new(&inv, n, n),
        );
        for i in 0..n {
            for j in 0..n {
                let expected = f64::from(u8::from(i == j));
                assert!((product[i * n + j] - expected).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn an_indefinite_matrix_is_refused() {
    assert!(!Spd::new(2).factorise(&[1.0, 2.0, 2.0, 1.0]));
}

#[test]
fn systems_are_solved_and_matrices_inverted() {
    let n = 9;
    let matrix = example(n);
    let right: Vec<f64> = (0..n).map(|i| i as f64 - 3.0).collect();
    let x = solve_symmetric(&matrix, &right).expect("positive definite");
    let inverse_one = inverse_symmetric(&matrix, n).expect("positive definite");
    let inverse_two = inverse(View::new(&matrix, n, n));
    for i in 0..n {
        assert!((dot(&matrix[i * n..][..n], &x) - right[i]).abs() < 1e-13);
        assert!((dot(&inverse_one[i * n..][..n], &right) - x[i]).abs() < 1e-13);
        assert!((dot(&inverse_two[i * n..][..n], &right) - x[i]).abs() < 1e-13);
    }
    assert_eq!(solve_symmetric(&[1.0, 2.0, 2.0, 1.0], &[1.0, 1.0]), None);
    assert_eq!(inverse_symmetric(&[1.0, 2.0, 2.0, 1.0], 2), None);
    // Not symmetric: rows and columns are not exchanged.
    assert_eq!(
        inverse(View::new(&[1.0, 2.0, 0.0, 1.0], 2, 2)),
        [1.0, -2.0, 0.0, 1.0]
    );
}
