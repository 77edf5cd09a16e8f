//! Eight single-precision numbers at once, with the same bits on every instruction set.
//!
//! Only operations that IEEE 754 rounds correctly are offered (+ - * / and the square root, and choices between two
//! numbers), none of them fused, so code that is written once against [`Simd8`] gives equal bits wherever it runs.
//! Every function must be `#[inline(always)]` up to the closure given to [`Simd8::vectorize`]: what is not inlined there
//! is compiled for the narrowest instruction set. It would still be right, only slower.

use serde::{Deserialize, Serialize};

/// Numbers in a register.
pub const LANES: usize = 8;

/// An instruction set that the code can be compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstructionSet {
    /// 256-bit registers of x86-64-v3 (AVX2).
    Avx2,
    /// 128-bit registers of x86-64-v2 (SSE4.2).
    Sse42,
    /// Plain arrays, and whatever the compiler makes of them for the oldest processor of the target.
    Plain,
}

impl InstructionSet {
    pub const ALL: [InstructionSet; 3] = [InstructionSet::Avx2, InstructionSet::Sse42, InstructionSet::Plain];

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => pulp::x86::V3::is_available(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse42 => pulp::x86::V2::is_available(),
            #[cfg(not(target_arch = "x86_64"))]
            InstructionSet::Avx2 | InstructionSet::Sse42 => false,
            InstructionSet::Plain => true,
        }
    }

    /// The widest one of this processor.
    pub fn best() -> InstructionSet {
        Self::ALL.into_iter().find(|set| set.is_available()).unwrap_or(InstructionSet::Plain)
    }

    /// Runs `code` with it, or with plain arrays where the processor does not have it.
    pub fn with<C: WithSimd>(self, code: C) -> C::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => match pulp::x86::V3::try_new() {
                Some(token) => code.run(Avx2(token)),
                None => code.run(Plain),
            },
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse42 => match pulp::x86::V2::try_new() {
                Some(token) => code.run(Sse42(token)),
                None => code.run(Plain),
            },
            _ => code.run(Plain),
        }
    }
}

/// Code that is generic over the instruction set.
pub trait WithSimd {
    type Output;
    fn run<S: Simd8>(self, simd: S) -> Self::Output;
}

/// Operations on several numbers at once.
pub trait Numbers: Copy + Send + Sync + 'static {
    /// The numbers.
    type F: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn sqrt(self, a: Self::F) -> Self::F;
    /// `a < b ? a : b`, so `b` where either is not a number.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a > b ? a : b`, so `b` where either is not a number.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    /// The number `a`, which is not negative, with the sign of `sign`.
    fn with_sign(self, a: Self::F, sign: Self::F) -> Self::F;
    /// `a < b ? yes : no`.
    fn if_less(self, a: Self::F, b: Self::F, yes: Self::F, no: Self::F) -> Self::F;
}

/// Proof that the processor has an instruction set, and its operations on eight numbers.
pub trait Simd8: Numbers {
    /// Compiles `code`, with all that is inlined into it, for the instruction set.
    fn vectorize<R>(self, code: impl FnOnce() -> R) -> R;

    fn load(self, x: &[f32; LANES]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; LANES];
    /// Columns of eight rows of four: result `k` holds the `k`-th number of every row.
    fn columns(self, rows: [[f32; 4]; LANES]) -> [Self::F; 4];
    /// The rows of four columns: undoes [`Simd8::columns`].
    fn rows(self, columns: [Self::F; 4]) -> [[f32; 4]; LANES];
}

macro_rules! array_numbers {
    () => {
        type F = [f32; LANES];

        #[inline(always)]
        fn splat(self, x: f32) -> Self::F {
            [x; LANES]
        }
        #[inline(always)]
        fn add(self, a: Self::F, b: Self::F) -> Self::F {
            std::array::from_fn(|i| a[i] + b[i])
        }
        #[inline(always)]
        fn sub(self, a: Self::F, b: Self::F) -> Self::F {
            std::array::from_fn(|i| a[i] - b[i])
        }
        #[inline(always)]
        fn mul(self, a: Self::F, b: Self::F) -> Self::F {
            std::array::from_fn(|i| a[i] * b[i])
        }
        #[inline(always)]
        fn div(self, a: Self::F, b: Self::F) -> Self::F {
            std::array::from_fn(|i| a[i] / b[i])
        }
        #[inline(always)]
        fn sqrt(self, a: Self::F) -> Self::F {
            a.map(f32::sqrt)
        }
        #[inline(always)]
        fn min(self, a: Self::F, b: Self::F) -> Self::F {
            std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
        }
        #[inline(always)]
        fn max(self, a: Self::F, b: Self::F) -> Self::F {
            std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
        }
        #[inline(always)]
        fn abs(self, a: Self::F) -> Self::F {
            a.map(f32::abs)
        }
        #[inline(always)]
        fn with_sign(self, a: Self::F, sign: Self::F) -> Self::F {
            std::array::from_fn(|i| a[i].copysign(sign[i]))
        }
        #[inline(always)]
        fn if_less(self, a: Self::F, b: Self::F, yes: Self::F, no: Self::F) -> Self::F {
            std::array::from_fn(|i| if a[i] < b[i] { yes[i] } else { no[i] })
        }
    };
}

macro_rules! array_moves {
    () => {
        #[inline(always)]
        fn load(self, x: &[f32; LANES]) -> Self::F {
            *x
        }
        #[inline(always)]
        fn store(self, x: Self::F) -> [f32; LANES] {
            x
        }
        #[inline(always)]
        fn columns(self, rows: [[f32; 4]; LANES]) -> [Self::F; 4] {
            std::array::from_fn(|k| std::array::from_fn(|i| rows[i][k]))
        }
        #[inline(always)]
        fn rows(self, columns: [Self::F; 4]) -> [[f32; 4]; LANES] {
            std::array::from_fn(|i| std::array::from_fn(|k| columns[k][i]))
        }
    };
}

/// Plain arrays.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

impl Numbers for Plain {
    array_numbers!();
}

impl Simd8 for Plain {
    array_moves!();

    #[inline(always)]
    fn vectorize<R>(self, code: impl FnOnce() -> R) -> R {
        code()
    }
}

/// Arrays, compiled for SSE4.2.
#[cfg(target_arch = "x86_64")]
#[derive(Debug, Clone, Copy)]
pub struct Sse42(pulp::x86::V2);

#[cfg(target_arch = "x86_64")]
impl Numbers for Sse42 {
    array_numbers!();
}

#[cfg(target_arch = "x86_64")]
impl Simd8 for Sse42 {
    array_moves!();

    #[inline(always)]
    fn vectorize<R>(self, code: impl FnOnce() -> R) -> R {
        self.0.vectorize(code)
    }
}

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{__m128, __m256};

    use super::{LANES, Numbers, Simd8};

    /// AVX registers.
    #[derive(Debug, Clone, Copy)]
    pub struct Avx2(pub(super) pulp::x86::V3);

    impl Avx2 {
        #[inline(always)]
        fn pair(self, low: [f32; 4], high: [f32; 4]) -> __m256 {
            self.0.avx._mm256_set_m128(pulp::cast::<_, __m128>(high), pulp::cast::<_, __m128>(low))
        }

        #[inline(always)]
        fn halves(self, pair: __m256) -> [[f32; 4]; 2] {
            pulp::cast(pair)
        }
    }

    impl Numbers for Avx2 {
        type F = __m256;

        #[inline(always)]
        fn splat(self, x: f32) -> __m256 {
            self.0.avx._mm256_set1_ps(x)
        }
        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            self.0.avx._mm256_add_ps(a, b)
        }
        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            self.0.avx._mm256_sub_ps(a, b)
        }
        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            self.0.avx._mm256_mul_ps(a, b)
        }
        #[inline(always)]
        fn div(self, a: __m256, b: __m256) -> __m256 {
            self.0.avx._mm256_div_ps(a, b)
        }
        #[inline(always)]
        fn sqrt(self, a: __m256) -> __m256 {
            self.0.avx._mm256_sqrt_ps(a)
        }
        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            self.0.avx._mm256_min_ps(a, b)
        }
        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            self.0.avx._mm256_max_ps(a, b)
        }
        #[inline(always)]
        fn abs(self, a: __m256) -> __m256 {
            self.0.avx._mm256_andnot_ps(self.splat(-0.0), a)
        }
        #[inline(always)]
        fn with_sign(self, a: __m256, sign: __m256) -> __m256 {
            self.0.avx._mm256_or_ps(a, self.0.avx._mm256_and_ps(self.splat(-0.0), sign))
        }
        #[inline(always)]
        fn if_less(self, a: __m256, b: __m256, yes: __m256, no: __m256) -> __m256 {
            // 17: less than, ordered, quiet.
            self.0.avx._mm256_blendv_ps(no, yes, self.0.avx._mm256_cmp_ps::<17>(a, b))
        }
    }

    impl Simd8 for Avx2 {
        #[inline(always)]
        fn vectorize<R>(self, code: impl FnOnce() -> R) -> R {
            self.0.vectorize(code)
        }
        #[inline(always)]
        fn load(self, x: &[f32; LANES]) -> __m256 {
            pulp::cast(*x)
        }
        #[inline(always)]
        fn store(self, x: __m256) -> [f32; LANES] {
            pulp::cast(x)
        }
        #[inline(always)]
        fn columns(self, r: [[f32; 4]; LANES]) -> [__m256; 4] {
            let avx = self.0.avx;
            let (a, b) = (self.pair(r[0], r[4]), self.pair(r[1], r[5]));
            let (c, d) = (self.pair(r[2], r[6]), self.pair(r[3], r[7]));
            let (ab_low, ab_high) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpackhi_ps(a, b));
            let (cd_low, cd_high) = (avx._mm256_unpacklo_ps(c, d), avx._mm256_unpackhi_ps(c, d));
            [
                avx._mm256_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low),
                avx._mm256_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low),
                avx._mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
                avx._mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
            ]
        }
        #[inline(always)]
        fn rows(self, c: [__m256; 4]) -> [[f32; 4]; LANES] {
            let avx = self.0.avx;
            let (ab_low, ab_high) = (avx._mm256_unpacklo_ps(c[0], c[1]), avx._mm256_unpackhi_ps(c[0], c[1]));
            let (cd_low, cd_high) = (avx._mm256_unpacklo_ps(c[2], c[3]), avx._mm256_unpackhi_ps(c[2], c[3]));
            let [r04, r15, r26, r37] = [
                avx._mm256_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low),
                avx._mm256_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low),
                avx._mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
                avx._mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
            ];
            let ([r0, r4], [r1, r5]) = (self.halves(r04), self.halves(r15));
            let ([r2, r6], [r3, r7]) = (self.halves(r26), self.halves(r37));
            [r0, r1, r2, r3, r4, r5, r6, r7]
        }
    }
}

/// Twice as many numbers: every operation on two registers, one after the other. Code that waits for the results of
/// its own divisions and roots does twice as much in about the same time.
#[derive(Debug, Clone, Copy)]
pub struct Twice<N>(pub N);

impl<N: Numbers> Numbers for Twice<N> {
    type F = [N::F; 2];

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F {
        [self.0.splat(x); 2]
    }
    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        [self.0.add(a[0], b[0]), self.0.add(a[1], b[1])]
    }
    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        [self.0.sub(a[0], b[0]), self.0.sub(a[1], b[1])]
    }
    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        [self.0.mul(a[0], b[0]), self.0.mul(a[1], b[1])]
    }
    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        [self.0.div(a[0], b[0]), self.0.div(a[1], b[1])]
    }
    #[inline(always)]
    fn sqrt(self, a: Self::F) -> Self::F {
        [self.0.sqrt(a[0]), self.0.sqrt(a[1])]
    }
    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        [self.0.min(a[0], b[0]), self.0.min(a[1], b[1])]
    }
    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        [self.0.max(a[0], b[0]), self.0.max(a[1], b[1])]
    }
    #[inline(always)]
    fn abs(self, a: Self::F) -> Self::F {
        [self.0.abs(a[0]), self.0.abs(a[1])]
    }
    #[inline(always)]
    fn with_sign(self, a: Self::F, sign: Self::F) -> Self::F {
        [self.0.with_sign(a[0], sign[0]), self.0.with_sign(a[1], sign[1])]
    }
    #[inline(always)]
    fn if_less(self, a: Self::F, b: Self::F, yes: Self::F, no: Self::F) -> Self::F {
        [self.0.if_less(a[0], b[0], yes[0], no[0]), self.0.if_less(a[1], b[1], yes[1], no[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation on numbers that show its rules.
    struct All;

    impl WithSimd for All {
        type Output = Vec<[u32; LANES]>;

        fn run<S: Simd8>(self, s: S) -> Self::Output {
            s.vectorize(
                #[inline(always)]
                || {
                    let a = s.load(&[1.0, -2.5, 0.0, -0.0, 1e-20, 3.3e7, f32::NAN, 7.1]);
                    let b = s.load(&[0.3, 0.7, -0.0, 0.0, 1e20, -1.5, 1.0, f32::NAN]);
                    let c = s.splat(0.1);
                    let rows = std::array::from_fn(|i| std::array::from_fn(|k| (10 * i + k) as f32));
                    let columns = s.columns(rows);
                    assert_eq!(s.rows(columns), rows);
                    assert_eq!(s.store(columns[3])[6], 63.0);
                    let results = [
                        s.add(a, b),
                        s.sub(a, b),
                        s.mul(a, b),
                        s.div(a, b),
                        s.sqrt(s.abs(a)),
                        s.min(a, b),
                        s.max(a, b),
                        s.with_sign(c, a),
                        s.if_less(a, b, c, a),
                        columns[0],
                        columns[1],
                        columns[2],
                    ];
                    // Which payload a NaN has is not defined: only that it is one.
                    let bits = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
                    results.iter().map(|r| s.store(*r).map(bits)).collect()
                },
            )
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let plain = InstructionSet::Plain.with(All);
        assert_eq!(plain.len(), 12);
        for set in InstructionSet::ALL {
            assert_eq!(set.with(All), plain, "{set:?}");
        }
        assert!(InstructionSet::best().is_available());
    }
}
