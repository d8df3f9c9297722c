//! The vectors of a machine behind one trait, so that each kernel is written once: AVX-512, AVX2 and plain arrays, each
//! for f32 and f64.
//!
//! A value of a SIMD type is only made by [`super::table`] after the machine was seen to have the instructions; that is
//! the proof on which every intrinsic here relies.

use super::Element;

/// One kind of vector. `self` is an empty value that proves that the machine has it.
pub trait Lanes: Copy {
    /// What a lane holds.
    type Element: Element;
    /// The vector.
    type Vector: Copy;
    /// How many lanes it has: a divisor of 16.
    const WIDTH: usize;

    fn splat(self, value: Self::Element) -> Self::Vector;
    /// # Safety
    /// `WIDTH` elements are readable at `from`.
    unsafe fn load(self, from: *const Self::Element) -> Self::Vector;
    /// # Safety
    /// `WIDTH` elements are writable at `to`.
    unsafe fn store(self, to: *mut Self::Element, value: Self::Vector);
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn div(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn sqrt(self, a: Self::Vector) -> Self::Vector;
    /// a · b + c
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// To the nearest integer, still as a float.
    fn round(self, a: Self::Vector) -> Self::Vector;
    /// 2ᵃ for integers a between −126 and 127.
    fn power_of_two(self, a: Self::Vector) -> Self::Vector;

    /// Writes the `WIDTH` × `WIDTH` elements at `from` transposed to `to`; both have rows at the given distances.
    /// # Safety
    /// All of them are readable and writable.
    #[inline(always)]
    unsafe fn transpose(self, from: *const Self::Element, from_row: usize, to: *mut Self::Element, to_row: usize) {
        // SAFETY: the caller vouches for the elements.
        unsafe { transpose_one_by_one::<Self::Element, 4>(from, from_row, to, to_row) }
    }

    /// A scalar function, lane by lane.
    #[inline(always)]
    fn map(self, a: Self::Vector, function: impl Fn(Self::Element) -> Self::Element) -> Self::Vector {
        let mut lanes = [Self::Element::ZERO; 16];
        // SAFETY: WIDTH is at most 16, so the array has room for the whole vector.
        unsafe { self.store(lanes.as_mut_ptr(), a) };
        for lane in &mut lanes[..Self::WIDTH] {
            *lane = function(*lane);
        }
        // SAFETY: as above.
        unsafe { self.load(lanes.as_ptr()) }
    }

    /// The sum of all lanes, in a fixed order.
    #[inline(always)]
    fn sum(self, a: Self::Vector) -> Self::Element {
        let mut lanes = [Self::Element::ZERO; 16];
        // SAFETY: WIDTH is at most 16, so the array has room for the whole vector.
        unsafe { self.store(lanes.as_mut_ptr(), a) };
        let mut sum = Self::Element::ZERO;
        for lane in &lanes[..Self::WIDTH] {
            sum = sum + *lane;
        }
        sum
    }
}

/// # Safety
/// `N` rows of `N` elements are readable and writable at the given distances.
#[inline(always)]
unsafe fn transpose_one_by_one<E: Copy, const N: usize>(from: *const E, from_row: usize, to: *mut E, to_row: usize) {
    for i in 0..N {
        for j in 0..N {
            // SAFETY: the caller vouches for the elements.
            unsafe { *to.add(j * to_row + i) = *from.add(i * from_row + j) };
        }
    }
}

/// Plain arrays, which the compiler turns into whatever every machine of the target has.
#[derive(Clone, Copy)]
pub(super) struct Portable<E>(pub std::marker::PhantomData<E>);

impl<E: Element> Lanes for Portable<E> {
    type Element = E;
    type Vector = [E; 4];
    const WIDTH: usize = 4;

    #[inline(always)]
    fn splat(self, value: E) -> [E; 4] {
        [value; 4]
    }
    #[inline(always)]
    unsafe fn load(self, from: *const E) -> [E; 4] {
        // SAFETY: the caller vouches for 4 readable elements.
        unsafe { from.cast::<[E; 4]>().read_unaligned() }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut E, value: [E; 4]) {
        // SAFETY: the caller vouches for 4 writable elements.
        unsafe { to.cast::<[E; 4]>().write_unaligned(value) }
    }
    #[inline(always)]
    fn add(self, a: [E; 4], b: [E; 4]) -> [E; 4] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub(self, a: [E; 4], b: [E; 4]) -> [E; 4] {
        std::array::from_fn(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul(self, a: [E; 4], b: [E; 4]) -> [E; 4] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div(self, a: [E; 4], b: [E; 4]) -> [E; 4] {
        std::array::from_fn(|i| a[i] / b[i])
    }
    // NaN in the first operand passes through, so that a sick network is seen and not clamped into health.
    #[inline(always)]
    fn min(self, a: [E; 4], b: [E; 4]) -> [E; 4] {
        std::array::from_fn(|i| if a[i] > b[i] { b[i] } else { a[i] })
    }
    #[inline(always)]
    fn max(self, a: [E; 4], b: [E; 4]) -> [E; 4] {
        std::array::from_fn(|i| if a[i] < b[i] { b[i] } else { a[i] })
    }
    #[inline(always)]
    fn sqrt(self, a: [E; 4]) -> [E; 4] {
        a.map(Element::sqrt)
    }
    #[inline(always)]
    fn mul_add(self, a: [E; 4], b: [E; 4], c: [E; 4]) -> [E; 4] {
        std::array::from_fn(|i| a[i] * b[i] + c[i])
    }
    #[inline(always)]
    fn round(self, a: [E; 4]) -> [E; 4] {
        a.map(Element::round)
    }
    #[inline(always)]
    fn power_of_two(self, a: [E; 4]) -> [E; 4] {
        a.map(Element::exp2)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::{Avx2F32, Avx2F64, Avx512F32, Avx512F64};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Element, Lanes};

    macro_rules! lanes {
        ($name:ident, $element:ty, $vector:ty, $width:literal, $splat:ident, $load:ident, $store:ident, $add:ident, $sub:ident,
         $mul:ident, $div:ident, $min:ident, $max:ident, $sqrt:ident, $fma:ident, round($a:ident) = $round:expr, power($lanes:ident, $n:ident) = $power:expr,
         transpose($from:ident, $from_row:ident, $to:ident, $to_row:ident) = $transpose:expr) => {
            #[derive(Clone, Copy)]
            pub(in super::super) struct $name(());

            impl $name {
                /// # Safety
                /// The machine has the instructions.
                pub(in super::super) const unsafe fn new() -> Self {
                    $name(())
                }
            }

            // SAFETY (all blocks): a value of this type exists only where the machine has the instructions (see `new`).
            impl Lanes for $name {
                type Element = $element;
                type Vector = $vector;
                const WIDTH: usize = $width;

                #[inline(always)]
                fn splat(self, value: $element) -> $vector {
                    unsafe { $splat(value) }
                }
                #[inline(always)]
                unsafe fn load(self, from: *const $element) -> $vector {
                    // SAFETY: the caller vouches for the elements.
                    unsafe { $load(from) }
                }
                #[inline(always)]
                unsafe fn store(self, to: *mut $element, value: $vector) {
                    // SAFETY: the caller vouches for the elements.
                    unsafe { $store(to, value) }
                }
                #[inline(always)]
                fn add(self, a: $vector, b: $vector) -> $vector {
                    unsafe { $add(a, b) }
                }
                #[inline(always)]
                fn sub(self, a: $vector, b: $vector) -> $vector {
                    unsafe { $sub(a, b) }
                }
                #[inline(always)]
                fn mul(self, a: $vector, b: $vector) -> $vector {
                    unsafe { $mul(a, b) }
                }
                #[inline(always)]
                fn div(self, a: $vector, b: $vector) -> $vector {
                    unsafe { $div(a, b) }
                }
                // The instruction gives its second operand where one is NaN: so the value goes second.
                #[inline(always)]
                fn min(self, a: $vector, b: $vector) -> $vector {
                    unsafe { $min(b, a) }
                }
                #[inline(always)]
                fn max(self, a: $vector, b: $vector) -> $vector {
                    unsafe { $max(b, a) }
                }
                #[inline(always)]
                fn sqrt(self, a: $vector) -> $vector {
                    unsafe { $sqrt(a) }
                }
                #[inline(always)]
                fn mul_add(self, a: $vector, b: $vector, c: $vector) -> $vector {
                    unsafe { $fma(a, b, c) }
                }
                #[inline(always)]
                fn round(self, $a: $vector) -> $vector {
                    unsafe { $round }
                }
                #[inline(always)]
                #[allow(unused_unsafe)]
                fn power_of_two(self, $n: $vector) -> $vector {
                    let $lanes = self;
                    let _ = $lanes;
                    unsafe { $power }
                }
                #[inline(always)]
                unsafe fn transpose(
                    self,
                    $from: *const $element,
                    $from_row: usize,
                    $to: *mut $element,
                    $to_row: usize,
                ) {
                    // SAFETY: the caller vouches for the elements.
                    unsafe { $transpose }
                }
            }
        };
    }

    lanes!(
        Avx512F32,
        f32,
        __m512,
        16,
        _mm512_set1_ps,
        _mm512_loadu_ps,
        _mm512_storeu_ps,
        _mm512_add_ps,
        _mm512_sub_ps,
        _mm512_mul_ps,
        _mm512_div_ps,
        _mm512_min_ps,
        _mm512_max_ps,
        _mm512_sqrt_ps,
        _mm512_fmadd_ps,
        round(a) = _mm512_roundscale_ps::<0x08>(a),
        power(lanes, n) = _mm512_scalef_ps(_mm512_set1_ps(1.0), n),
        transpose(from, from_row, to, to_row) = transpose_16(from, from_row, to, to_row)
    );
    lanes!(
        Avx512F64,
        f64,
        __m512d,
        8,
        _mm512_set1_pd,
        _mm512_loadu_pd,
        _mm512_storeu_pd,
        _mm512_add_pd,
        _mm512_sub_pd,
        _mm512_mul_pd,
        _mm512_div_pd,
        _mm512_min_pd,
        _mm512_max_pd,
        _mm512_sqrt_pd,
        _mm512_fmadd_pd,
        round(a) = _mm512_roundscale_pd::<0x08>(a),
        power(lanes, n) = _mm512_scalef_pd(_mm512_set1_pd(1.0), n),
        transpose(from, from_row, to, to_row) = super::transpose_one_by_one::<f64, 8>(from, from_row, to, to_row)
    );
    lanes!(
        Avx2F32,
        f32,
        __m256,
        8,
        _mm256_set1_ps,
        _mm256_loadu_ps,
        _mm256_storeu_ps,
        _mm256_add_ps,
        _mm256_sub_ps,
        _mm256_mul_ps,
        _mm256_div_ps,
        _mm256_min_ps,
        _mm256_max_ps,
        _mm256_sqrt_ps,
        _mm256_fmadd_ps,
        round(a) = _mm256_round_ps::<0x08>(a),
        power(lanes, n) = {
            // The exponent field of a float is n + 127.
            let exponent = _mm256_add_epi32(_mm256_cvtps_epi32(n), _mm256_set1_epi32(127));
            _mm256_castsi256_ps(_mm256_slli_epi32::<23>(exponent))
        },
        transpose(from, from_row, to, to_row) = transpose_8(from, from_row, to, to_row)
    );
    lanes!(
        Avx2F64,
        f64,
        __m256d,
        4,
        _mm256_set1_pd,
        _mm256_loadu_pd,
        _mm256_storeu_pd,
        _mm256_add_pd,
        _mm256_sub_pd,
        _mm256_mul_pd,
        _mm256_div_pd,
        _mm256_min_pd,
        _mm256_max_pd,
        _mm256_sqrt_pd,
        _mm256_fmadd_pd,
        round(a) = _mm256_round_pd::<0x08>(a),
        power(lanes, n) = lanes.map(n, Element::exp2),
        transpose(from, from_row, to, to_row) = super::transpose_one_by_one::<f64, 4>(from, from_row, to, to_row)
    );

    /// Transposes 16 × 16 elements: within pairs, within fours, then the 128-bit parts.
    ///
    /// # Safety
    /// The machine has AVX-512F; 16 rows of 16 elements are readable and writable at the given distances.
    #[inline(always)]
    unsafe fn transpose_16(from: *const f32, from_row: usize, to: *mut f32, to_row: usize) {
        // SAFETY: the caller vouches for the instructions and the elements.
        unsafe {
            let mut rows = [_mm512_setzero_ps(); 16];
            let mut fours = rows;
            for (i, row) in rows.iter_mut().enumerate() {
                *row = _mm512_loadu_ps(from.add(i * from_row));
            }
            for g in (0..16).step_by(4) {
                let pair = |a, b| (_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
                let ((a, b), (c, d)) = (pair(rows[g], rows[g + 1]), pair(rows[g + 2], rows[g + 3]));
                let join = |a, c| {
                    let (a, c) = (_mm512_castps_pd(a), _mm512_castps_pd(c));
                    [_mm512_castpd_ps(_mm512_unpacklo_pd(a, c)), _mm512_castpd_ps(_mm512_unpackhi_pd(a, c))]
                };
                [fours[g], fours[g + 1]] = join(a, c);
                [fours[g + 2], fours[g + 3]] = join(b, d);
            }
            for c in 0..4 {
                let (a, b, d, e) = (fours[c], fours[4 + c], fours[8 + c], fours[12 + c]);
                let (even_ab, odd_ab) = (_mm512_shuffle_f32x4::<0x88>(a, b), _mm512_shuffle_f32x4::<0xdd>(a, b));
                let (even_de, odd_de) = (_mm512_shuffle_f32x4::<0x88>(d, e), _mm512_shuffle_f32x4::<0xdd>(d, e));
                _mm512_storeu_ps(to.add(c * to_row), _mm512_shuffle_f32x4::<0x88>(even_ab, even_de));
                _mm512_storeu_ps(to.add((4 + c) * to_row), _mm512_shuffle_f32x4::<0x88>(odd_ab, odd_de));
                _mm512_storeu_ps(to.add((8 + c) * to_row), _mm512_shuffle_f32x4::<0xdd>(even_ab, even_de));
                _mm512_storeu_ps(to.add((12 + c) * to_row), _mm512_shuffle_f32x4::<0xdd>(odd_ab, odd_de));
            }
        }
    }

    /// Transposes 8 × 8 elements in the same way.
    ///
    /// # Safety
    /// The machine has AVX2; 8 rows of 8 elements are readable and writable at the given distances.
    #[inline(always)]
    unsafe fn transpose_8(from: *const f32, from_row: usize, to: *mut f32, to_row: usize) {
        // SAFETY: the caller vouches for the instructions and the elements.
        unsafe {
            let mut rows = [_mm256_setzero_ps(); 8];
            let mut fours = rows;
            for (i, row) in rows.iter_mut().enumerate() {
                *row = _mm256_loadu_ps(from.add(i * from_row));
            }
            for g in (0..8).step_by(4) {
                let pair = |a, b| (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
                let ((a, b), (c, d)) = (pair(rows[g], rows[g + 1]), pair(rows[g + 2], rows[g + 3]));
                let join = |a, c| {
                    let (a, c) = (_mm256_castps_pd(a), _mm256_castps_pd(c));
                    [_mm256_castpd_ps(_mm256_unpacklo_pd(a, c)), _mm256_castpd_ps(_mm256_unpackhi_pd(a, c))]
                };
                [fours[g], fours[g + 1]] = join(a, c);
                [fours[g + 2], fours[g + 3]] = join(b, d);
            }
            for c in 0..4 {
                let (a, b) = (fours[c], fours[4 + c]);
                _mm256_storeu_ps(to.add(c * to_row), _mm256_permute2f128_ps::<0x20>(a, b));
                _mm256_storeu_ps(to.add((4 + c) * to_row), _mm256_permute2f128_ps::<0x31>(a, b));
            }
        }
    }
}
