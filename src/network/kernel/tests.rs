use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

fn random<E: Element>(length: usize, seed: u64) -> Vec<E> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..length).map(|_| E::from_f64(random.random_range(-1.0..1.0))).collect()
}

fn close<E: Element>(a: E, b: f64, tolerance: f64) -> bool {
    (a.to_f64() - b).abs() <= tolerance * b.abs().max(1.0)
}

fn products_agree<E: Element>(tolerance: f64) {
    for kernels in E::all_kernels() {
        for (rows, columns, depth) in [(1, 64, 1), (6, 64, 64), (13, 16, 5), (64, 64, 6), (7, 80, 3)] {
            let (a, b) = (random::<E>(rows * depth, 1), random::<E>(depth * columns, 2));
            let before = random::<E>(rows * columns, 3);
            for transposed in [false, true] {
                let (a_row, a_depth) = if transposed { (1, rows) } else { (depth, 1) };
                let mut c = before.clone();
                let start = Start::Result;
                let f = Factors { rows, columns, depth, a: &a, a_row, a_depth, b: &b, b_row: columns, start };
                (kernels.product)(&f, &mut c, columns);
                for i in 0..rows {
                    for j in 0..columns {
                        let sum: f64 =
                            (0..depth).map(|k| a[i * a_row + k * a_depth].to_f64() * b[k * columns + j].to_f64()).sum();
                        let expected = before[i * columns + j].to_f64() + sum;
                        assert!(close(c[i * columns + j], expected, tolerance), "{} {rows}×{columns}", kernels.name);
                    }
                }
            }
        }
    }
}

#[test]
fn products_are_those_of_the_definition() {
    products_agree::<f32>(1e-5);
    products_agree::<f64>(1e-13);
}

#[test]
fn functions_are_accurate_on_every_machine() {
    use Function::{Cos, Exp, Sigmoid, Sign, Sin, Softplus, Tanh};
    let x: Vec<f32> = (0..64 * TILE).map(|i| (i as f32 - 2048.0) * 0.01).collect();
    for kernels in f32::all_kernels() {
        for function in [Cos, Exp, Sigmoid, Sign, Sin, Softplus, Tanh] {
            let mut y = vec![0.0; x.len()];
            (kernels.apply)(function, Some(&x), &mut y);
            for (x, y) in x.iter().zip(&y) {
                let exact = functions::in_f64(function, f64::from(*x));
                assert!(close(*y, exact, 4e-7), "{} {function:?}({x}) = {y}, not {exact}", kernels.name);
            }
        }
    }
}

#[test]
fn a_sick_number_stays_visible() {
    for kernels in f32::all_kernels() {
        for function in [Function::Tanh, Function::Exp, Function::Sigmoid, Function::Softplus, Function::Sin] {
            let mut y = vec![0.0; TILE];
            (kernels.apply)(function, Some(&[f32::NAN; TILE]), &mut y);
            assert!(y.iter().all(|y| y.is_nan()), "{} {function:?}", kernels.name);
        }
    }
}

#[test]
fn transposes_and_sums() {
    for kernels in f32::all_kernels() {
        for features in [1_usize, 5, 16, 37, 64] {
            let row = features.next_multiple_of(PAD);
            let x = random::<f32>(features * TILE, 4);
            let mut y = vec![f32::NAN; row * TILE];
            (kernels.transpose)(&x, features, &mut y);
            for sample in 0..TILE {
                for feature in 0..row {
                    let expected = if feature < features { x[feature * TILE + sample] } else { 0.0 };
                    assert_eq!(y[sample * row + feature], expected, "{}", kernels.name);
                }
            }
            let (mut columns, mut rows) = (vec![1.0; row], vec![1.0; features]);
            (kernels.add_column_sums)(&y, &mut columns);
            (kernels.add_row_sums)(&x, &mut rows);
            for feature in 0..features {
                let sum: f64 = 1.0 + x[feature * TILE..][..TILE].iter().map(|x| f64::from(*x)).sum::<f64>();
                assert!(close(columns[feature], sum, 1e-5) && close(rows[feature], sum, 1e-5), "{}", kernels.name);
            }
        }
    }
}

#[test]
fn triangles_multiply() {
    let n = 4;
    let (packed, v) = (random::<f64>(n * (n + 1) / 2 * TILE, 5), random::<f64>(n * TILE, 6));
    for kernels in f64::all_kernels() {
        for transposed in [false, true] {
            let mut y = vec![0.0; n * TILE];
            (kernels.lower_product)(&packed, &v, transposed, &mut y);
            for sample in 0..TILE {
                for i in 0..n {
                    let entry =
                        |i: usize, j: usize| if j > i { 0.0 } else { packed[lower_index(n, i, j) * TILE + sample] };
                    let sum: f64 =
                        (0..n).map(|j| if transposed { entry(j, i) } else { entry(i, j) } * v[j * TILE + sample]).sum();
                    assert!(close(y[i * TILE + sample], sum, 1e-14));
                }
            }
        }
    }
}
