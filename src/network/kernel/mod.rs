//! The inner loops, each written once over `lanes` and compiled for AVX-512, AVX2 and every other machine; the best set
//! that the machine has is chosen at run time by [`Element::kernels`].
//!
//! A *tile* holds [`TILE`] samples of a quantity, feature after feature: element `[feature · TILE + sample]`. So every loop
//! over samples is a loop over full vectors, whatever the number of features.
#![allow(unsafe_code)] // SIMD: bounds are checked once at the door of each kernel, not at each element.

mod functions;
mod lanes;

use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::OnceLock;

pub use functions::Function;
use lanes::{Lanes, Portable};

/// Samples in a tile.
pub const TILE: usize = 64;
/// Rows of parameters, and of transposed tiles, are padded with zeros to a multiple of this many elements.
pub const PAD: usize = 16;

/// What networks calculate with: `f32` to train, `f64` to check.
pub trait Element:
    Copy
    + Send
    + Sync
    + PartialOrd
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// 0
    const ZERO: Self;
    /// Rounds a number to this type.
    fn from_f64(value: f64) -> Self;
    /// The number, exactly.
    fn to_f64(self) -> f64;
    /// The square root.
    fn sqrt(self) -> Self;
    /// To the nearest integer.
    fn round(self) -> Self;
    /// 2 to this power.
    fn exp2(self) -> Self;
    /// The fastest kernels that this machine has.
    fn kernels() -> &'static Kernels<Self>;
    /// All kernels that this machine has, the fastest first.
    fn all_kernels() -> Vec<&'static Kernels<Self>>;
    #[doc(hidden)]
    fn function<L: Lanes<Element = Self>>(lanes: L, function: Function, x: L::Vector) -> L::Vector;
}

/// What a matrix product adds to.
#[derive(Debug, Clone, Copy)]
pub enum Start<'a, E> {
    /// Nothing: it overwrites.
    Zero,
    /// One value for each row.
    Column(&'a [E]),
    /// What stands in the result.
    Result,
}

/// The operands of C = start + A B, with A read at `row · a_row + k · a_depth` (so it may stand transposed) and B, C row after
/// row. The number of columns is a multiple of [`PAD`].
#[derive(Debug, Clone, Copy)]
pub struct Factors<'a, E> {
    /// Rows of A and C.
    pub rows: usize,
    /// Columns of B and C.
    pub columns: usize,
    /// Columns of A and rows of B.
    pub depth: usize,
    /// A.
    pub a: &'a [E],
    /// Distance of two rows of A.
    pub a_row: usize,
    /// Distance of two columns of A.
    pub a_depth: usize,
    /// B.
    pub b: &'a [E],
    /// Distance of two rows of B.
    pub b_row: usize,
    /// What the product is added to.
    pub start: Start<'a, E>,
}

/// A tile that is read; `None` is the one that is written, with what stood in it before.
pub type Operand<'a, E> = Option<&'a [E]>;
/// factor · tile
pub type Single<'a, E> = (E, Operand<'a, E>);
/// factor · tile · tile, element by element
pub type Pair<'a, E> = (E, Operand<'a, E>, Operand<'a, E>);

/// Settings of one step of Adam with decoupled weight decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdamStep<E> {
    /// Learning rate.
    pub rate: E,
    /// Decay of the mean of the gradient.
    pub beta_1: E,
    /// Decay of the mean of its square.
    pub beta_2: E,
    /// 1 / (1 − β₁ᵗ)
    pub unbias_1: E,
    /// 1 / (1 − β₂ᵗ)
    pub unbias_2: E,
    /// Added to the root of the mean square.
    pub epsilon: E,
    /// Weight decay, per unit of learning rate.
    pub decay: E,
}

/// One machine's set of kernels for one element type. All slices are whole tiles unless said otherwise.
#[allow(clippy::type_complexity)] // signatures are all that stands here
pub struct Kernels<E: Element> {
    /// `AVX-512`, `AVX2` or `portable`.
    pub name: &'static str,
    /// C = start + A B; the last argument is the distance of two rows of C.
    pub product: fn(&Factors<E>, &mut [E], usize),
    /// y = f(x)
    pub apply: fn(Function, Operand<E>, &mut [E]),
    /// y = constant + Σ singles + Σ pairs, at most 3 of each
    pub combine: fn(E, &[Single<E>], &[Pair<E>], &mut [E]),
    /// y\[sample\]\[feature\] = x\[feature\]\[sample\], rows of y padded with zeros; the argument is the number of features
    pub transpose: fn(&[E], usize, &mut [E]),
    /// tile\[feature\]\[sample\] = rows\[pick of sample\]\[feature\] for [`TILE`] picks among rows of the given padded length
    pub gather: fn(&[E], usize, &[u32; TILE], &mut [E]),
    /// sums\[feature\] += Σ over samples of a transposed tile
    pub add_column_sums: fn(&[E], &mut [E]),
    /// sums\[feature\] += Σ over samples of a tile
    pub add_row_sums: fn(&[E], &mut [E]),
    /// y\[feature\] = value\[feature\] for all samples
    pub fill: fn(&[E], &mut [E]),
    /// y\[0\] = Σ over features of x
    pub sum_features: fn(&[E], &mut [E]),
    /// y = L v or Lᵀ v for a packed lower triangle, see [`lower_index`]
    pub lower_product: fn(&[E], &[E], bool, &mut [E]),
    /// Packed lower triangle of a bᵀ
    pub lower_outer: fn(&[E], &[E], &mut [E]),
    /// Adam on (weights, gradient, mean, mean square)
    pub adam: fn(&AdamStep<E>, &mut [E], &[E], &mut [E], &mut [E]),
    /// y = x, in whole vectors: what is read soon as vectors must be written as such, or the reader has to wait
    pub copy: fn(&[E], &mut [E]),
    /// y += factor · x, any equal lengths
    pub add_scaled: fn(E, &[E], &mut [E]),
}

/// Where entry (i, j), i ≥ j, of a lower triangle of order n stands: the diagonal first, then (1,0), (2,0), (2,1), (3,0), …
pub const fn lower_index(n: usize, i: usize, j: usize) -> usize {
    if i == j { i } else { n + i * (i - 1) / 2 + j }
}

#[inline(always)]
fn product<L: Lanes, const R: usize, const N: usize>(
    lanes: L,
    f: &Factors<L::Element>,
    c: &mut [L::Element],
    c_row: usize,
) {
    let Factors { rows, columns, depth, a, a_row, a_depth, b, b_row, start } = *f;
    if rows == 0 || columns == 0 {
        return;
    }
    assert!(columns % PAD == 0 && depth > 0, "whole vectors");
    assert!((rows - 1) * a_row + (depth - 1) * a_depth < a.len(), "A ends early");
    assert!((depth - 1) * b_row + columns <= b.len(), "B ends early");
    assert!((rows - 1) * c_row + columns <= c.len(), "C ends early");
    if let Start::Column(values) = start {
        assert!(rows <= values.len(), "the bias ends early");
    }
    let mut row = 0;
    while row < rows {
        // Blocks of equal height, so that none is so low that it waits for its own sums.
        let height = (rows - row).div_ceil((rows - row).div_ceil(R));
        // SAFETY: all indices of the block are below the bounds checked above.
        unsafe {
            match height {
                8 if R >= 8 => strip::<L, 8, N>(lanes, f, c.as_mut_ptr(), c_row, row),
                7 if R >= 7 => strip::<L, 7, N>(lanes, f, c.as_mut_ptr(), c_row, row),
                6 if R >= 6 => strip::<L, 6, N>(lanes, f, c.as_mut_ptr(), c_row, row),
                5 if R >= 5 => strip::<L, 5, N>(lanes, f, c.as_mut_ptr(), c_row, row),
                4 => strip::<L, 4, N>(lanes, f, c.as_mut_ptr(), c_row, row),
                3 => strip::<L, 3, N>(lanes, f, c.as_mut_ptr(), c_row, row),
                2 => strip::<L, 2, N>(lanes, f, c.as_mut_ptr(), c_row, row),
                _ => strip::<L, 1, N>(lanes, f, c.as_mut_ptr(), c_row, row),
            }
        }
        row += height;
    }
}

/// `R` rows of the product, `N` vectors at a time.
#[inline(always)]
unsafe fn strip<L: Lanes, const R: usize, const N: usize>(
    lanes: L,
    f: &Factors<L::Element>,
    c: *mut L::Element,
    c_row: usize,
    row: usize,
) {
    let mut column = 0;
    // SAFETY: `product` has checked the bounds of all rows and columns.
    unsafe {
        while column + N * L::WIDTH <= f.columns {
            block::<L, R, N>(lanes, f, c, c_row, row, column);
            column += N * L::WIDTH;
        }
        while column < f.columns {
            block::<L, R, 1>(lanes, f, c, c_row, row, column);
            column += L::WIDTH;
        }
    }
}

/// `R` rows by `N` vectors of the product, all of whose sums stay in registers.
#[inline(always)]
unsafe fn block<L: Lanes, const R: usize, const N: usize>(
    lanes: L,
    f: &Factors<L::Element>,
    c: *mut L::Element,
    c_row: usize,
    row: usize,
    column: usize,
) {
    // SAFETY: `product` has checked the bounds of all rows and columns.
    unsafe {
        let c = c.add(row * c_row + column);
        let mut sums = [[lanes.splat(L::Element::ZERO); N]; R];
        match f.start {
            Start::Zero => {}
            Start::Column(values) => {
                for i in 0..R {
                    sums[i] = [lanes.splat(*values.get_unchecked(row + i)); N];
                }
            }
            Start::Result => {
                for i in 0..R {
                    for j in 0..N {
                        sums[i][j] = lanes.load(c.add(i * c_row + j * L::WIDTH));
                    }
                }
            }
        }
        let mut a = f.a.as_ptr().add(row * f.a_row);
        let mut b = f.b.as_ptr().add(column);
        for _ in 0..f.depth {
            let mut vectors = [lanes.splat(L::Element::ZERO); N];
            for j in 0..N {
                vectors[j] = lanes.load(b.add(j * L::WIDTH));
            }
            for i in 0..R {
                let factor = lanes.splat(*a.add(i * f.a_row));
                for j in 0..N {
                    sums[i][j] = lanes.mul_add(factor, vectors[j], sums[i][j]);
                }
            }
            // The last step may point past the end, where nothing is read.
            a = a.wrapping_add(f.a_depth);
            b = b.wrapping_add(f.b_row);
        }
        for i in 0..R {
            for j in 0..N {
                lanes.store(c.add(i * c_row + j * L::WIDTH), sums[i][j]);
            }
        }
    }
}

/// y = f(x), vector by vector; a macro and not a closure, since a closure would not inherit the instructions.
macro_rules! each {
    ($lanes:ident, $y:ident, $index:ident => $value:expr) => {
        for $index in (0..$y.len() / L::WIDTH).map(|vector| vector * L::WIDTH) {
            let value = $value;
            // SAFETY: the index ends a whole vector before the end of y.
            unsafe { $lanes.store($y.as_mut_ptr().add($index), value) };
        }
    };
}

/// The vector at an index of a slice.
macro_rules! at {
    ($lanes:ident, $x:expr, $index:expr) => {
        // SAFETY: the kernel has checked that x is at least as long as the range of its index.
        unsafe { $lanes.load($x.as_ptr().add($index)) }
    };
}

/// Where an operand stands, once its length is checked.
fn start_of<E: Element>(operand: Operand<E>, y: &mut [E]) -> *const E {
    match operand {
        Some(x) => {
            assert!(x.len() == y.len(), "tiles of equal size");
            x.as_ptr()
        }
        None => y.as_mut_ptr(),
    }
}

#[inline(always)]
fn apply<L: Lanes>(lanes: L, function: Function, x: Operand<L::Element>, y: &mut [L::Element]) {
    assert!(y.len().is_multiple_of(PAD), "whole tiles");
    let x = start_of(x, y);
    macro_rules! arms {
        ($($name:ident),*) => {
            // One loop for each function, so that the choice stands outside of it.
            match function {
                // SAFETY: x has as many elements as y; where it is y, each vector is read before it is written.
                $(Function::$name => each!(lanes, y, i => {
                    L::Element::function(lanes, Function::$name, unsafe { lanes.load(x.add(i)) })
                }),)*
            }
        };
    }
    arms!(Tanh, Sigmoid, Softplus, Exp, Sin, Cos, Sign);
}

#[inline(always)]
fn combine<L: Lanes>(
    lanes: L,
    constant: L::Element,
    singles: &[Single<L::Element>],
    pairs: &[Pair<L::Element>],
    y: &mut [L::Element],
) {
    assert!(y.len().is_multiple_of(PAD), "whole tiles");
    let s = |index: usize, y: &mut [L::Element]| (singles[index].0, start_of(singles[index].1, y));
    let p =
        |index: usize, y: &mut [L::Element]| (pairs[index].0, start_of(pairs[index].1, y), start_of(pairs[index].2, y));
    match (singles.len(), pairs.len()) {
        (0, 0) => y.fill(constant),
        (1, 0) => terms(lanes, constant, [s(0, y)], [], y),
        (2, 0) => terms(lanes, constant, [s(0, y), s(1, y)], [], y),
        (3, 0) => terms(lanes, constant, [s(0, y), s(1, y), s(2, y)], [], y),
        (0, 1) => terms(lanes, constant, [], [p(0, y)], y),
        (0, 2) => terms(lanes, constant, [], [p(0, y), p(1, y)], y),
        (0, 3) => terms(lanes, constant, [], [p(0, y), p(1, y), p(2, y)], y),
        (1, 1) => terms(lanes, constant, [s(0, y)], [p(0, y)], y),
        (1, 2) => terms(lanes, constant, [s(0, y)], [p(0, y), p(1, y)], y),
        (2, 1) => terms(lanes, constant, [s(0, y), s(1, y)], [p(0, y)], y),
        _ => panic!("a combination has at most three terms"),
    }
}

/// The operands begin at these pointers and have as many elements as y; `combine` sees to it.
#[inline(always)]
fn terms<L: Lanes, const S: usize, const P: usize>(
    lanes: L,
    constant: L::Element,
    singles: [(L::Element, *const L::Element); S],
    pairs: [(L::Element, *const L::Element, *const L::Element); P],
    y: &mut [L::Element],
) {
    let constant = lanes.splat(constant);
    each!(lanes, y, i => {
        let mut sum = constant;
        // SAFETY: the operands have as many elements as y; where one is y, each vector is read before it is written.
        unsafe {
            for (factor, a) in singles {
                sum = lanes.mul_add(lanes.splat(factor), lanes.load(a.add(i)), sum);
            }
            for (factor, a, b) in pairs {
                let a = lanes.mul(lanes.splat(factor), lanes.load(a.add(i)));
                sum = lanes.mul_add(a, lanes.load(b.add(i)), sum);
            }
        }
        sum
    });
}

#[inline(always)]
fn transpose<L: Lanes>(lanes: L, x: &[L::Element], features: usize, y: &mut [L::Element]) {
    let row = features.next_multiple_of(PAD);
    assert!(x.len() == features * TILE && y.len() == row * TILE, "a tile and its transpose");
    let whole = features / L::WIDTH * L::WIDTH;
    for feature in (0..whole).step_by(L::WIDTH) {
        for sample in (0..TILE).step_by(L::WIDTH) {
            // SAFETY: both blocks lie within the sizes checked above.
            unsafe {
                let from = x.as_ptr().add(feature * TILE + sample);
                lanes.transpose(from, TILE, y.as_mut_ptr().add(sample * row + feature), row);
            }
        }
    }
    for sample in 0..TILE {
        for feature in whole..row {
            y[sample * row + feature] = if feature < features { x[feature * TILE + sample] } else { L::Element::ZERO };
        }
    }
}

#[inline(always)]
fn gather<L: Lanes>(lanes: L, rows: &[L::Element], row: usize, picks: &[u32; TILE], tile: &mut [L::Element]) {
    assert!(row.is_multiple_of(PAD) && tile.len() == row * TILE, "a tile of padded rows");
    assert!(picks.iter().all(|pick| (*pick as usize + 1) * row <= rows.len()), "all picks exist");
    let mut near = [L::Element::ZERO; PAD * PAD];
    for first in (0..TILE).step_by(L::WIDTH) {
        for feature in (0..row).step_by(L::WIDTH) {
            // SAFETY: the picks were checked; WIDTH is at most PAD, so the block fits `near`; the tile has `row` features.
            unsafe {
                for sample in 0..L::WIDTH {
                    let from = rows.as_ptr().add(picks[first + sample] as usize * row + feature);
                    lanes.store(near.as_mut_ptr().add(sample * PAD), lanes.load(from));
                }
                lanes.transpose(near.as_ptr(), PAD, tile.as_mut_ptr().add(feature * TILE + first), TILE);
            }
        }
    }
}

#[inline(always)]
fn add_column_sums<L: Lanes>(lanes: L, x: &[L::Element], sums: &mut [L::Element]) {
    let row = sums.len();
    assert!(x.len() == row * TILE && row % PAD == 0, "a transposed tile and its sums");
    each!(lanes, sums, i => {
        // Four sums at a time hide the latency of the addition.
        let mut parts = [at!(lanes, sums, i), lanes.splat(L::Element::ZERO), lanes.splat(L::Element::ZERO), lanes.splat(L::Element::ZERO)];
        for sample in (0..TILE).step_by(4) {
            for (k, part) in parts.iter_mut().enumerate() {
                *part = lanes.add(*part, at!(lanes, x, (sample + k) * row + i));
            }
        }
        lanes.add(lanes.add(parts[0], parts[1]), lanes.add(parts[2], parts[3]))
    });
}

#[inline(always)]
fn add_row_sums<L: Lanes>(lanes: L, x: &[L::Element], sums: &mut [L::Element]) {
    for (row, sum) in x.chunks_exact(TILE).zip(sums) {
        let mut total = at!(lanes, row, 0);
        for i in (L::WIDTH..TILE).step_by(L::WIDTH) {
            total = lanes.add(total, at!(lanes, row, i));
        }
        *sum = *sum + lanes.sum(total);
    }
}

#[inline(always)]
fn fill<L: Lanes>(lanes: L, values: &[L::Element], y: &mut [L::Element]) {
    for (value, row) in values.iter().zip(y.chunks_exact_mut(TILE)) {
        each!(lanes, row, _i => lanes.splat(*value));
    }
}

#[inline(always)]
fn sum_features<L: Lanes>(lanes: L, x: &[L::Element], y: &mut [L::Element]) {
    assert!(y.len() == TILE && x.len() % TILE == 0, "a tile and one row");
    each!(lanes, y, i => {
        let mut sum = lanes.splat(L::Element::ZERO);
        for row in x.chunks_exact(TILE) {
            sum = lanes.add(sum, at!(lanes, row, i));
        }
        sum
    });
}

#[inline(always)]
fn lower_product<L: Lanes>(lanes: L, packed: &[L::Element], v: &[L::Element], transposed: bool, y: &mut [L::Element]) {
    let n = v.len() / TILE;
    assert!(packed.len() == n * (n + 1) / 2 * TILE && y.len() == n * TILE && v.len() == n * TILE, "orders agree");
    for (i, row) in y.chunks_exact_mut(TILE).enumerate() {
        each!(lanes, row, sample => {
            let mut sum = lanes.splat(L::Element::ZERO);
            for j in if transposed { i..n } else { 0..i + 1 } {
                let entry = lower_index(n, i.max(j), i.min(j));
                sum = lanes.mul_add(at!(lanes, packed, entry * TILE + sample), at!(lanes, v, j * TILE + sample), sum);
            }
            sum
        });
    }
}

#[inline(always)]
fn lower_outer<L: Lanes>(lanes: L, a: &[L::Element], b: &[L::Element], y: &mut [L::Element]) {
    let n = a.len() / TILE;
    assert!(y.len() == n * (n + 1) / 2 * TILE && a.len() == n * TILE && b.len() == n * TILE, "orders agree");
    for i in 0..n {
        for j in 0..=i {
            let start = lower_index(n, i, j) * TILE;
            let row = &mut y[start..start + TILE];
            each!(lanes, row, sample => lanes.mul(at!(lanes, a, i * TILE + sample), at!(lanes, b, j * TILE + sample)));
        }
    }
}

#[inline(always)]
fn copy<L: Lanes>(lanes: L, x: &[L::Element], y: &mut [L::Element]) {
    assert!(x.len() == y.len() && y.len() % PAD == 0, "whole tiles of equal size");
    each!(lanes, y, i => at!(lanes, x, i));
}

#[inline(always)]
fn adam<L: Lanes>(
    lanes: L,
    step: &AdamStep<L::Element>,
    weights: &mut [L::Element],
    gradient: &[L::Element],
    mean: &mut [L::Element],
    square: &mut [L::Element],
) {
    let length = weights.len();
    assert!(
        length % PAD == 0 && gradient.len() == length && mean.len() == length && square.len() == length,
        "equal sizes"
    );
    let one = L::Element::from_f64(1.0);
    let splat = |value| lanes.splat(value);
    for i in (0..length).step_by(L::WIDTH) {
        let g = at!(lanes, gradient, i);
        let m = lanes.mul_add(splat(step.beta_1), at!(lanes, mean, i), lanes.mul(splat(one - step.beta_1), g));
        let g_square = lanes.mul(g, g);
        let s = lanes.mul_add(splat(step.beta_2), at!(lanes, square, i), lanes.mul(splat(one - step.beta_2), g_square));
        let root = lanes.add(lanes.sqrt(lanes.mul(splat(step.unbias_2), s)), splat(step.epsilon));
        let w = at!(lanes, weights, i);
        let towards = lanes.mul_add(splat(step.decay), w, lanes.div(lanes.mul(splat(step.unbias_1), m), root));
        // SAFETY: i ends a whole vector before the end of all four, which have the same length.
        unsafe {
            lanes.store(mean.as_mut_ptr().add(i), m);
            lanes.store(square.as_mut_ptr().add(i), s);
            lanes.store(weights.as_mut_ptr().add(i), lanes.mul_add(splat(-step.rate), towards, w));
        }
    }
}

#[inline(always)]
fn add_scaled<L: Lanes>(lanes: L, factor: L::Element, x: &[L::Element], y: &mut [L::Element]) {
    assert!(x.len() == y.len(), "equal sizes");
    each!(lanes, y, i => lanes.mul_add(lanes.splat(factor), at!(lanes, x, i), at!(lanes, y, i)));
    for i in y.len() / L::WIDTH * L::WIDTH..y.len() {
        y[i] = y[i] + factor * x[i];
    }
}

/// The set of kernels of one machine and element type: each body above, compiled with the machine's instructions.
/// `$rows` × `$vectors` is the block of a product that fits its registers.
macro_rules! table {
    ($name:ident, $title:literal, $element:ty, $lanes:expr, $rows:literal, $vectors:literal $(, $features:literal)?) => {
        impl $name {
            pub(super) const TABLE: Kernels<$element> = Kernels {
                name: $title,
                product: table!(@ $($features)?; $lanes; product::<_, $rows, $vectors>;
                    (f: &Factors<$element>, c: &mut [$element], c_row: usize)),
                apply: table!(@ $($features)?; $lanes; apply; (f: Function, x: Operand<$element>, y: &mut [$element])),
                combine: table!(@ $($features)?; $lanes; combine;
                    (constant: $element, singles: &[Single<$element>], pairs: &[Pair<$element>], y: &mut [$element])),
                transpose: table!(@ $($features)?; $lanes; transpose; (x: &[$element], n: usize, y: &mut [$element])),
                gather: table!(@ $($features)?; $lanes; gather;
                    (rows: &[$element], row: usize, picks: &[u32; TILE], tile: &mut [$element])),
                add_column_sums: table!(@ $($features)?; $lanes; add_column_sums; (x: &[$element], y: &mut [$element])),
                add_row_sums: table!(@ $($features)?; $lanes; add_row_sums; (x: &[$element], y: &mut [$element])),
                fill: table!(@ $($features)?; $lanes; fill; (x: &[$element], y: &mut [$element])),
                sum_features: table!(@ $($features)?; $lanes; sum_features; (x: &[$element], y: &mut [$element])),
                lower_product: table!(@ $($features)?; $lanes; lower_product;
                    (l: &[$element], v: &[$element], t: bool, y: &mut [$element])),
                lower_outer: table!(@ $($features)?; $lanes; lower_outer;
                    (a: &[$element], b: &[$element], y: &mut [$element])),
                adam: table!(@ $($features)?; $lanes; adam;
                    (s: &AdamStep<$element>, w: &mut [$element], g: &[$element], m: &mut [$element], v: &mut [$element])),
                copy: table!(@ $($features)?; $lanes; copy; (x: &[$element], y: &mut [$element])),
                add_scaled: table!(@ $($features)?; $lanes; add_scaled;
                    (factor: $element, x: &[$element], y: &mut [$element])),
            };
        }
    };
    (@ $($features:literal)?; $lanes:expr; $body:expr; ($($argument:ident: $kind:ty),*)) => {{
        $(#[target_feature(enable = $features)])?
        fn compiled($($argument: $kind),*) {
            $body($lanes, $($argument),*);
        }
        fn door($($argument: $kind),*) {
            // SAFETY: `all_kernels` hands out a table only where the machine has its instructions.
            #[allow(unused_unsafe)]
            unsafe { compiled($($argument),*) }
        }
        door
    }};
}

struct PortableF32;
struct PortableF64;
table!(PortableF32, "portable", f32, Portable(PhantomData), 4, 2);
table!(PortableF64, "portable", f64, Portable(PhantomData), 4, 2);

#[cfg(target_arch = "x86_64")]
mod x86 {
    // SAFETY (all `new` below): they run only inside functions compiled for these instructions.
    use super::lanes::{Avx2F32, Avx2F64, Avx512F32, Avx512F64};
    use super::*;

    pub(super) struct WideF32;
    pub(super) struct WideF64;
    pub(super) struct MiddleF32;
    pub(super) struct MiddleF64;
    table!(WideF32, "AVX-512", f32, unsafe { Avx512F32::new() }, 6, 4, "avx512f,avx512dq,avx2,fma");
    table!(WideF64, "AVX-512", f64, unsafe { Avx512F64::new() }, 6, 4, "avx512f,avx512dq,avx2,fma");
    table!(MiddleF32, "AVX2", f32, unsafe { Avx2F32::new() }, 6, 2, "avx2,fma");
    table!(MiddleF64, "AVX2", f64, unsafe { Avx2F64::new() }, 6, 2, "avx2,fma");
}

/// The element types differ only in names here.
macro_rules! element {
    ($element:ty, $portable:ident, $middle:ident, $wide:ident, |$lanes:ident, $function:ident, $x:ident| $vector:expr) => {
        impl Element for $element {
            const ZERO: Self = 0.0;
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $element
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn round(self) -> Self {
                self.round_ties_even()
            }
            #[inline(always)]
            fn exp2(self) -> Self {
                self.exp2()
            }
            fn all_kernels() -> Vec<&'static Kernels<Self>> {
                let mut all = Vec::with_capacity(3);
                #[cfg(target_arch = "x86_64")]
                {
                    let has_avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
                    if has_avx2 && is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                        all.push(&x86::$wide::TABLE);
                    }
                    if has_avx2 {
                        all.push(&x86::$middle::TABLE);
                    }
                }
                all.push(&$portable::TABLE);
                all
            }
            fn kernels() -> &'static Kernels<Self> {
                static BEST: OnceLock<&'static Kernels<$element>> = OnceLock::new();
                BEST.get_or_init(|| Self::all_kernels()[0])
            }
            #[inline(always)]
            fn function<L: Lanes<Element = Self>>($lanes: L, $function: Function, $x: L::Vector) -> L::Vector {
                $vector
            }
        }
    };
}

element!(f32, PortableF32, MiddleF32, WideF32, |lanes, function, x| functions::in_f32(lanes, function, x));
element!(f64, PortableF64, MiddleF64, WideF64, |lanes, function, x| lanes.map(x, |x| functions::in_f64(function, x)));

#[cfg(test)]
mod tests;
