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

/// The largest difference of A A⁻¹ from the identity, A⁻¹ as `spd` finds it both ways.
fn off_identity(spd: &mut Spd, matrix: &[f64], n: usize) -> [f64; 2] {
    let mut inverses = [vec![f64::NAN; n * n], vec![f64::NAN; n * n]];
    assert!(spd.factorise(matrix));
    spd.inverse_into(&mut inverses[0]);
    // Only the lower triangle is read.
    let mut lower = matrix.to_vec();
    for i in 0..n {
        lower[i * n + i + 1..(i + 1) * n].fill(f64::NAN);
    }
    assert!(spd.invert(&lower, &mut inverses[1]));
    inverses.map(|inverse| {
        let mut product = vec![0.0; n * n];
        multiply(
            ViewMut::new(&mut product, n, n),
            View::new(matrix, n, n),
            View::new(&inverse, n, n),
        );
        let identity = |at: usize| f64::from(u8::from(at.is_multiple_of(n + 1)));
        let off = product.iter().enumerate();
        off.map(|(at, x)| (x - identity(at)).abs())
            .fold(0.0, f64::max)
    })
}

#[test]
fn inverse_times_matrix_is_identity() {
    let mut spd = Spd::new(65);
    for n in [65, 1, 2, 3, 7, 8, 9, 16, 33, 64] {
        spd.resize(n);
        for scale in [1.0, 1e-300, 3e-7, 1e12, 1e300] {
            let matrix: Vec<f64> = example(n).iter().map(|x| x * scale).collect();
            let off = off_identity(&mut spd, &matrix, n);
            assert!(off.iter().all(|off| *off < 3e-15), "{n} {scale:e} {off:?}");
        }
    }
}

/// Rows of sizes far apart and nearly dependent ones: by sweeping 1.5 times as far off as by Cholesky.
#[test]
fn ill_conditioned_matrices_are_inverted_nearly_as_well_as_by_a_factor() {
    let mut worst = [0.0f64; 2];
    for n in [2, 5, 16, 31, 64] {
        let mut matrix = example(n);
        for i in 0..n {
            for j in 0..n {
                // Nearly all ones, 1e-6 from singular.
                matrix[i * n + j] = 1.0 + 1e-6 * matrix[i * n + j];
                let size = |at: usize| 10f64.powi(at as i32 % 7 - 3);
                matrix[i * n + j] *= size(i) * size(j);
            }
        }
        let off = off_identity(&mut Spd::new(n), &matrix, n);
        for (worst, off) in worst.iter_mut().zip(off) {
            *worst = worst.max(off);
        }
    }
    println!("by a factor and by sweeping {worst:?}");
    assert!(worst[1] < 2.0 * worst[0], "{worst:?}");
}

#[test]
fn an_indefinite_matrix_is_refused() {
    let indefinite = [1.0, 2.0, 2.0, 1.0];
    assert!(!Spd::new(2).factorise(&indefinite));
    for matrix in [
        indefinite,
        [1.0, 1.0, 1.0, 1.0],
        [0.0; 4],
        [-1.0, 0.0, 0.0, 1.0],
        [1.0, f64::NAN, f64::NAN, 1.0],
        [f64::INFINITY, 0.0, 0.0, 1.0],
    ] {
        assert!(!Spd::new(2).invert(&matrix, &mut [0.0; 4]), "{matrix:?}");
    }
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
