//! Elementary functions on vectors: short polynomials for f32 (errors below 3e-7), the standard library for f64.

use serde::{Deserialize, Serialize};

use super::lanes::Lanes;

/// A function of one variable that a graph can apply to every element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Function {
    /// tanh x
    Tanh,
    /// 1 / (1 + e⁻ˣ)
    Sigmoid,
    /// ln(1 + eˣ)
    Softplus,
    /// eˣ
    Exp,
    /// sin x
    Sin,
    /// cos x
    Cos,
    /// −1, 0 or 1
    Sign,
}

/// The function in f64, as the standard library has it.
pub(super) fn in_f64(function: Function, x: f64) -> f64 {
    match function {
        Function::Tanh => x.tanh(),
        Function::Sigmoid => 1.0 / (1.0 + (-x).exp()),
        Function::Softplus => x.max(0.0) + (-x.abs()).exp().ln_1p(),
        Function::Exp => x.exp(),
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
        Function::Sign => {
            if x > 0.0 {
                1.0
            } else if x < 0.0 {
                -1.0
            } else {
                0.0
            }
        }
    }
}

/// The function on a vector of f32.
#[inline(always)]
pub(super) fn in_f32<L: Lanes<Element = f32>>(lanes: L, function: Function, x: L::Vector) -> L::Vector {
    match function {
        Function::Tanh => tanh(lanes, x),
        Function::Sigmoid => sigmoid(lanes, x),
        Function::Softplus => softplus(lanes, x),
        Function::Exp => exp(lanes, x),
        Function::Sin => sin_shifted(lanes, x, 0.0),
        Function::Cos => sin_shifted(lanes, x, 0.5),
        Function::Sign => lanes.map(x, |x| in_f64(Function::Sign, f64::from(x)) as f32),
    }
}

/// c₀ + c₁ x + c₂ x² + …
#[inline(always)]
fn polynomial<L: Lanes<Element = f32>, const N: usize>(lanes: L, x: L::Vector, coefficients: [f32; N]) -> L::Vector {
    let mut sum = lanes.splat(coefficients[N - 1]);
    for k in (0..N - 1).rev() {
        sum = lanes.mul_add(sum, x, lanes.splat(coefficients[k]));
    }
    sum
}

/// A rational approximation of degree 13 over 6, the one of the Eigen library (`ptanh_float`).
#[inline(always)]
fn tanh<L: Lanes<Element = f32>>(lanes: L, x: L::Vector) -> L::Vector {
    const LIMIT: f32 = 7.905_311;
    const ODD: [f32; 7] = [
        4.893_524_6e-3,
        6.372_619_3e-4,
        1.485_722_4e-5,
        5.122_297_1e-8,
        -8.604_672e-11,
        2.000_188e-13,
        -2.760_768_5e-16,
    ];
    const EVEN: [f32; 4] = [4.893_525e-3, 2.268_434_6e-3, 1.185_347_1e-4, 1.198_258_4e-6];
    let x = lanes.min(lanes.max(x, lanes.splat(-LIMIT)), lanes.splat(LIMIT));
    let square = lanes.mul(x, x);
    let above = lanes.mul(x, polynomial(lanes, square, ODD));
    lanes.div(above, polynomial(lanes, square, EVEN))
}

/// eˣ = 2ⁿ eʳ with |r| ≤ ln 2 / 2, eʳ by its series.
#[inline(always)]
fn exp<L: Lanes<Element = f32>>(lanes: L, x: L::Vector) -> L::Vector {
    // ln 2 in two parts, so that n · ln 2 keeps the digits that x loses.
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let x = lanes.min(lanes.max(x, lanes.splat(-87.0)), lanes.splat(88.0));
    let n = lanes.round(lanes.mul(x, lanes.splat(std::f32::consts::LOG2_E)));
    let r = lanes.mul_add(n, lanes.splat(-LN_2_HIGH), x);
    let r = lanes.mul_add(n, lanes.splat(-LN_2_LOW), r);
    let series = polynomial(lanes, r, [1.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0]);
    lanes.mul(series, lanes.power_of_two(n))
}

#[inline(always)]
fn sigmoid<L: Lanes<Element = f32>>(lanes: L, x: L::Vector) -> L::Vector {
    let one = lanes.splat(1.0);
    lanes.div(one, lanes.add(one, exp(lanes, lanes.sub(lanes.splat(0.0), x))))
}

/// max(x, 0) + ln(1 + u) with u = e^−|x| ≤ 1 and ln(1 + u) = 2 artanh(u / (2 + u)), whose series converges quickly.
#[inline(always)]
fn softplus<L: Lanes<Element = f32>>(lanes: L, x: L::Vector) -> L::Vector {
    let zero = lanes.splat(0.0);
    let u = exp(lanes, lanes.min(x, lanes.sub(zero, x)));
    let s = lanes.div(u, lanes.add(u, lanes.splat(2.0)));
    let series = polynomial(lanes, lanes.mul(s, s), std::array::from_fn::<f32, 8, _>(|k| 2.0 / (2 * k + 1) as f32));
    lanes.mul_add(s, series, lanes.max(x, zero))
}

/// sin(x + shift · π): with k the nearest integer to x / π + shift it is (−1)ᵏ sin r, r = x − (k − shift) π.
#[inline(always)]
fn sin_shifted<L: Lanes<Element = f32>>(lanes: L, x: L::Vector, shift: f32) -> L::Vector {
    // π in three parts of few digits each, so that the products with k are exact for |x| up to some thousands.
    const PI_PARTS: [f32; 3] = [3.140_625, 9.675_026e-4, 1.509_958e-7];
    let shift = lanes.splat(shift);
    let k = lanes.round(lanes.mul_add(x, lanes.splat(std::f32::consts::FRAC_1_PI), shift));
    let turns = lanes.sub(shift, k);
    let mut r = x;
    for part in PI_PARTS {
        r = lanes.mul_add(turns, lanes.splat(part), r);
    }
    // (−1)ᵏ = 1 − 2 · (k mod 2)², where k − 2 · round(k / 2) is −1, 0 or 1.
    let odd = lanes.mul_add(lanes.round(lanes.mul(k, lanes.splat(0.5))), lanes.splat(-2.0), k);
    let sign = lanes.mul_add(lanes.mul(odd, odd), lanes.splat(-2.0), lanes.splat(1.0));
    const SERIES: [f32; 7] =
        [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0];
    lanes.mul(lanes.mul(sign, r), polynomial(lanes, lanes.mul(r, r), SERIES))
}
