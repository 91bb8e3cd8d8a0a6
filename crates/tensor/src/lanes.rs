//! Lanes backed by vector registers, and the choice among them at run time.

use crate::real::Real;

/// A set of vector instructions that lanes can run on. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneLevel {
    /// One `f64` at a time, on any machine.
    Portable,
    /// Four lanes with AVX2 and FMA.
    Avx2,
    /// Eight lanes with AVX-512.
    Avx512,
}

impl LaneLevel {
    /// Every level, the slowest first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// The fastest level of this machine.
    pub fn best() -> Self {
        Self::ALL.into_iter().rev().find(|level| level.is_available()).unwrap_or(Self::Portable)
    }

    /// Whether this machine has the instructions.
    pub fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq"),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// How many elements stand side by side.
    pub fn lanes(self) -> usize {
        match self {
            Self::Portable => 1,
            Self::Avx2 => 4,
            Self::Avx512 => 8,
        }
    }

    /// The level's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

/// Something to be made for the lanes that [`dispatch`] chooses.
pub trait WithLanes {
    /// What is made.
    type Output;

    /// Makes it for numbers of type `R`.
    fn with_lanes<R: Real>(self) -> Self::Output;
}

/// Makes `what` for the lanes of `level`, or of the best level below it that this machine has.
///
/// The lane types have no other way out of this crate: they exist only where their instructions do.
pub fn dispatch<W: WithLanes>(level: LaneLevel, what: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if level == LaneLevel::Avx512 && LaneLevel::Avx512.is_available() {
        return what.with_lanes::<x86::F64x8>();
    }
    #[cfg(target_arch = "x86_64")]
    if level != LaneLevel::Portable && LaneLevel::Avx2.is_available() {
        return what.with_lanes::<x86::F64x4>();
    }
    what.with_lanes::<f64>()
}

/// Asks for `value`, which is not empty, to be brought into the nearest cache.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for byte in (0..size_of::<T>()).step_by(64).chain((align_of::<T>() < 64).then_some(size_of::<T>() - 1)) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch reads nothing that the program sees, whatever the address.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast::<i8>().wrapping_add(byte));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    // Why the intrinsics below are sound: a value of a lane type is made only by code generic over `Real`, which gets
    // these types from `dispatch` alone, after it has asked the processor for the instructions.
    #![allow(clippy::undocumented_unsafe_blocks)]

    use crate::array::array;
    use crate::elementary;
    use crate::inlined;
    use crate::lanes::LaneLevel;
    use crate::real::{Kernel, Mask, Real};
    use std::arch::x86_64::*;
    use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

    /// Four `f64` in one AVX register.
    #[derive(Clone, Copy, Debug)]
    #[repr(transparent)]
    pub struct F64x4(__m256d);

    /// The answer of a comparison of [`F64x4`]: all bits of a lane set or none.
    #[derive(Clone, Copy, Debug)]
    #[repr(transparent)]
    pub struct Mask4(__m256d);

    /// Eight `f64` in one AVX-512 register.
    #[derive(Clone, Copy, Debug)]
    #[repr(transparent)]
    pub struct F64x8(__m512d);

    /// The answer of a comparison of [`F64x8`], a bit a lane.
    #[derive(Clone, Copy, Debug)]
    #[repr(transparent)]
    pub struct Mask8(__mmask8);

    /// The first `LANES` indices, all of rows that are there, `fields` rows to an index.
    #[inline(always)]
    fn inside<'a, const LANES: usize>(indices: &'a [u16], fields: usize, rows: &[[f64; 4]]) -> &'a [u16; LANES] {
        let (indices, _) = indices.split_first_chunk().expect("an index for every lane");
        let mut largest = 0;
        for &index in indices {
            largest = index.max(largest);
        }
        assert!((largest as usize + 1) * fields <= rows.len(), "rows for all indices");
        indices
    }

    macro_rules! operators {
        ($lanes:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $xor:ident, $set:ident) => {
            operators!(@binary $lanes, Add, add, $add);
            operators!(@binary $lanes, Sub, sub, $sub);
            operators!(@binary $lanes, Mul, mul, $mul);
            operators!(@binary $lanes, Div, div, $div);
            operators!(@scalar $lanes, Add, add);
            operators!(@scalar $lanes, Sub, sub);
            operators!(@scalar $lanes, Mul, mul);

            impl Neg for $lanes {
                type Output = Self;
                #[inline(always)]
                fn neg(self) -> Self {
                    Self(unsafe { $xor(self.0, $set(-0.0)) })
                }
            }

            impl AddAssign for $lanes {
                #[inline(always)]
                fn add_assign(&mut self, other: Self) {
                    *self = *self + other;
                }
            }

            impl SubAssign for $lanes {
                #[inline(always)]
                fn sub_assign(&mut self, other: Self) {
                    *self = *self - other;
                }
            }
        };
        (@binary $lanes:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
            impl $trait for $lanes {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self(unsafe { $intrinsic(self.0, other.0) })
                }
            }
        };
        (@scalar $lanes:ident, $trait:ident, $method:ident) => {
            impl $trait<f64> for $lanes {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: f64) -> Self {
                    $trait::$method(self, Self::splat(other))
                }
            }
        };
    }

    operators!(F64x4, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd, _mm256_xor_pd, _mm256_set1_pd);
    operators!(F64x8, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd, _mm512_xor_pd, _mm512_set1_pd);

    impl Real for F64x4 {
        type Mask = Mask4;

        const LANES: usize = 4;
        const LEVEL: LaneLevel = LaneLevel::Avx2;

        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(unsafe { _mm256_set1_pd(value) })
        }

        #[inline(always)]
        fn from_lanes(value: impl FnMut(usize) -> f64) -> Self {
            let lanes: [f64; 4] = array(value);
            Self(unsafe { _mm256_loadu_pd(lanes.as_ptr()) })
        }

        #[inline(always)]
        fn gather<const FIELDS: usize>(rows: &[[f64; 4]], indices: &[u16]) -> [[Self; 3]; FIELDS] {
            let indices: &[u16; 4] = inside(indices, FIELDS, rows);
            let mut fields = [[Self::splat(0.0); 3]; FIELDS];
            for (field, components) in fields.iter_mut().enumerate() {
                // SAFETY: the rows of all indices are there.
                unsafe {
                    let row = inlined!(|lane: usize| {
                        _mm256_loadu_pd(rows.as_ptr().add(indices[lane] as usize * FIELDS + field).cast())
                    });
                    let (a, b, c, d) = (row(0), row(1), row(2), row(3));
                    let (xz_01, y_01) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
                    let (xz_23, y_23) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
                    *components = [
                        Self(_mm256_permute2f128_pd::<0x20>(xz_01, xz_23)),
                        Self(_mm256_permute2f128_pd::<0x20>(y_01, y_23)),
                        Self(_mm256_permute2f128_pd::<0x31>(xz_01, xz_23)),
                    ];
                }
            }
            fields
        }

        #[inline(always)]
        fn scatter([x, y, z]: [Self; 3], rows: &mut [[f64; 4]], stride: usize) {
            let last = stride.checked_mul(Self::LANES - 1);
            assert!(last.is_some_and(|last| last < rows.len()), "rows for all lanes");
            let row = rows.as_mut_ptr().cast::<f64>();
            // SAFETY: the last lane's row is inside of the rows, and the others come before it.
            unsafe {
                let zero = _mm256_setzero_pd();
                let (xy_02, xy_13) = (_mm256_unpacklo_pd(x.0, y.0), _mm256_unpackhi_pd(x.0, y.0));
                let (z_02, z_13) = (_mm256_unpacklo_pd(z.0, zero), _mm256_unpackhi_pd(z.0, zero));
                _mm256_storeu_pd(row, _mm256_permute2f128_pd::<0x20>(xy_02, z_02));
                _mm256_storeu_pd(row.add(4 * stride), _mm256_permute2f128_pd::<0x20>(xy_13, z_13));
                _mm256_storeu_pd(row.add(8 * stride), _mm256_permute2f128_pd::<0x31>(xy_02, z_02));
                _mm256_storeu_pd(row.add(12 * stride), _mm256_permute2f128_pd::<0x31>(xy_13, z_13));
            }
        }

        #[inline(always)]
        fn lane(self, lane: usize) -> f64 {
            let mut lanes = [0.0; 4];
            self.store(&mut lanes);
            lanes[lane]
        }

        #[inline(always)]
        fn store(self, target: &mut [f64]) {
            let target = &mut target[..Self::LANES];
            unsafe { _mm256_storeu_pd(target.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            Self(unsafe { _mm256_fmadd_pd(self.0, factor.0, addend.0) })
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(unsafe { _mm256_sqrt_pd(self.0) })
        }

        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self(unsafe { _mm256_max_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(unsafe { _mm256_min_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn round(self) -> Self {
            Self(unsafe { _mm256_round_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0) })
        }

        #[inline(always)]
        fn lt(self, other: Self) -> Mask4 {
            Mask4(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn le(self, other: Self) -> Mask4 {
            Mask4(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn select(mask: Mask4, chosen: Self, otherwise: Self) -> Self {
            Self(unsafe { _mm256_blendv_pd(otherwise.0, chosen.0, mask.0) })
        }

        #[inline(always)]
        fn power_of_two(self) -> Self {
            let shifted = self + elementary::EXPONENT_SHIFTER;
            Self(unsafe { _mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_castpd_si256(shifted.0))) })
        }

        #[inline(always)]
        fn exponent_and_mantissa(self) -> (Self, Self) {
            unsafe {
                let bits = _mm256_castpd_si256(self.0);
                let set = |value: u64| _mm256_set1_epi64x(value.cast_signed());
                let exponent = _mm256_or_si256(_mm256_srli_epi64::<52>(bits), set(elementary::TWO_52_BITS));
                let fraction = _mm256_and_si256(bits, set(elementary::FRACTION_BITS));
                let mantissa = _mm256_or_si256(fraction, set(elementary::ONE_BITS));
                let exponent = Self(_mm256_castsi256_pd(exponent)) - elementary::TWO_52_AND_BIAS;
                (exponent, Self(_mm256_castsi256_pd(mantissa)))
            }
        }

        #[inline(always)]
        fn vectorize<K: Kernel>(kernel: K) -> K::Output {
            #[target_feature(enable = "avx2,fma")]
            fn run<K: Kernel>(kernel: K) -> K::Output {
                kernel.run()
            }
            unsafe { run(kernel) }
        }
    }

    impl Mask for Mask4 {
        #[inline(always)]
        fn any(self) -> bool {
            unsafe { _mm256_movemask_pd(self.0) != 0 }
        }
    }

    impl BitAnd for Mask4 {
        type Output = Self;
        #[inline(always)]
        fn bitand(self, other: Self) -> Self {
            Self(unsafe { _mm256_and_pd(self.0, other.0) })
        }
    }

    impl BitOr for Mask4 {
        type Output = Self;
        #[inline(always)]
        fn bitor(self, other: Self) -> Self {
            Self(unsafe { _mm256_or_pd(self.0, other.0) })
        }
    }

    impl Not for Mask4 {
        type Output = Self;
        #[inline(always)]
        fn not(self) -> Self {
            Self(unsafe { _mm256_xor_pd(self.0, _mm256_castsi256_pd(_mm256_set1_epi64x(-1))) })
        }
    }

    impl Real for F64x8 {
        type Mask = Mask8;

        const LANES: usize = 8;
        const LEVEL: LaneLevel = LaneLevel::Avx512;

        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(unsafe { _mm512_set1_pd(value) })
        }

        #[inline(always)]
        fn from_lanes(value: impl FnMut(usize) -> f64) -> Self {
            let lanes: [f64; 8] = array(value);
            Self(unsafe { _mm512_loadu_pd(lanes.as_ptr()) })
        }

        #[inline(always)]
        fn gather<const FIELDS: usize>(rows: &[[f64; 4]], indices: &[u16]) -> [[Self; 3]; FIELDS] {
            let indices: &[u16; 8] = inside(indices, FIELDS, rows);
            let mut fields = [[Self::splat(0.0); 3]; FIELDS];
            for (field, components) in fields.iter_mut().enumerate() {
                // SAFETY: the rows of all indices are there.
                unsafe {
                    let row = inlined!(|lane: usize| {
                        _mm256_loadu_pd(rows.as_ptr().add(indices[lane] as usize * FIELDS + field).cast())
                    });
                    let both = inlined!(|a: __m256d, b: __m256d| _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(a), b));
                    let (a, b) = (both(row(0), row(2)), both(row(1), row(3)));
                    let (c, d) = (both(row(4), row(6)), both(row(5), row(7)));
                    let (xz_0123, y_0123) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
                    let (xz_4567, y_4567) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
                    *components = [
                        Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(xz_0123, xz_4567)),
                        Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(y_0123, y_4567)),
                        Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(xz_0123, xz_4567)),
                    ];
                }
            }
            fields
        }

        #[inline(always)]
        fn scatter([x, y, z]: [Self; 3], rows: &mut [[f64; 4]], stride: usize) {
            let last = stride.checked_mul(Self::LANES - 1);
            assert!(last.is_some_and(|last| last < rows.len()), "rows for all lanes");
            let row = rows.as_mut_ptr().cast::<f64>();
            // SAFETY: the last lane's row is inside of the rows, and the others come before it.
            unsafe {
                let zero = _mm512_setzero_pd();
                let (xy_0246, xy_1357) = (_mm512_unpacklo_pd(x.0, y.0), _mm512_unpackhi_pd(x.0, y.0));
                let (z_0246, z_1357) = (_mm512_unpacklo_pd(z.0, zero), _mm512_unpackhi_pd(z.0, zero));
                let (low, high) =
                    (_mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11), _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15));
                let pairs = [
                    (0, _mm512_permutex2var_pd(xy_0246, low, z_0246)),
                    (1, _mm512_permutex2var_pd(xy_1357, low, z_1357)),
                    (4, _mm512_permutex2var_pd(xy_0246, high, z_0246)),
                    (5, _mm512_permutex2var_pd(xy_1357, high, z_1357)),
                ];
                for (lane, rows_of_two) in pairs {
                    _mm256_storeu_pd(row.add(4 * stride * lane), _mm512_castpd512_pd256(rows_of_two));
                    _mm256_storeu_pd(row.add(4 * stride * (lane + 2)), _mm512_extractf64x4_pd::<1>(rows_of_two));
                }
            }
        }

        #[inline(always)]
        fn lane(self, lane: usize) -> f64 {
            let mut lanes = [0.0; 8];
            self.store(&mut lanes);
            lanes[lane]
        }

        #[inline(always)]
        fn store(self, target: &mut [f64]) {
            let target = &mut target[..Self::LANES];
            unsafe { _mm512_storeu_pd(target.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, addend.0) })
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(unsafe { _mm512_sqrt_pd(self.0) })
        }

        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm512_abs_pd(self.0) })
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self(unsafe { _mm512_max_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(unsafe { _mm512_min_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn round(self) -> Self {
            Self(unsafe { _mm512_roundscale_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0) })
        }

        #[inline(always)]
        fn lt(self, other: Self) -> Mask8 {
            Mask8(unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn le(self, other: Self) -> Mask8 {
            Mask8(unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn select(mask: Mask8, chosen: Self, otherwise: Self) -> Self {
            Self(unsafe { _mm512_mask_blend_pd(mask.0, otherwise.0, chosen.0) })
        }

        #[inline(always)]
        fn power_of_two(self) -> Self {
            let shifted = self + elementary::EXPONENT_SHIFTER;
            Self(unsafe { _mm512_castsi512_pd(_mm512_slli_epi64::<52>(_mm512_castpd_si512(shifted.0))) })
        }

        #[inline(always)]
        fn exponent_and_mantissa(self) -> (Self, Self) {
            unsafe {
                let bits = _mm512_castpd_si512(self.0);
                let set = |value: u64| _mm512_set1_epi64(value.cast_signed());
                let exponent = _mm512_or_si512(_mm512_srli_epi64::<52>(bits), set(elementary::TWO_52_BITS));
                let fraction = _mm512_and_si512(bits, set(elementary::FRACTION_BITS));
                let mantissa = _mm512_or_si512(fraction, set(elementary::ONE_BITS));
                let exponent = Self(_mm512_castsi512_pd(exponent)) - elementary::TWO_52_AND_BIAS;
                (exponent, Self(_mm512_castsi512_pd(mantissa)))
            }
        }

        #[inline(always)]
        fn vectorize<K: Kernel>(kernel: K) -> K::Output {
            #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
            fn run<K: Kernel>(kernel: K) -> K::Output {
                kernel.run()
            }
            unsafe { run(kernel) }
        }
    }

    impl Mask for Mask8 {
        #[inline(always)]
        fn any(self) -> bool {
            self.0 != 0
        }
    }

    impl BitAnd for Mask8 {
        type Output = Self;
        #[inline(always)]
        fn bitand(self, other: Self) -> Self {
            Self(self.0 & other.0)
        }
    }

    impl BitOr for Mask8 {
        type Output = Self;
        #[inline(always)]
        fn bitor(self, other: Self) -> Self {
            Self(self.0 | other.0)
        }
    }

    impl Not for Mask8 {
        type Output = Self;
        #[inline(always)]
        fn not(self) -> Self {
            Self(!self.0)
        }
    }
}
