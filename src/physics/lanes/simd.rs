//! Eight single-precision numbers at once, with the same bits on every instruction set.
//!
//! Only operations that IEEE 754 rounds correctly are offered (+ - * / and the square root, and choices between two
//! numbers), none of them fused, so code that is written once against [`Simd8`] gives equal bits wherever it runs.
//! Every function must be `#[inline(always)]` up to the closure given to [`Simd8::vectorize`]: what is not inlined there
//! is compiled for the narrowest instruction set. It would still be right, only slower.

use serde::{Deserialize, Serialize};

use super::group::Group;
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};

/// Numbers in a register.
pub const LANES: usize = 8;

/// An instruction set that the code can be compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstructionSet {
    /// 512-bit registers of x86-64-v4 (AVX-512).
    Avx512,
    /// 256-bit registers of x86-64-v3 (AVX2).
    Avx2,
    /// 128-bit registers of x86-64-v2 (SSE4.2).
    Sse42,
    /// Plain arrays, and whatever the compiler makes of them for the oldest processor of the target.
    Plain,
}

impl InstructionSet {
    pub const ALL: [InstructionSet; 4] =
        [InstructionSet::Avx512, InstructionSet::Avx2, InstructionSet::Sse42, InstructionSet::Plain];

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => pulp::x86::V4::is_available(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => pulp::x86::V3::is_available(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse42 => pulp::x86::V2::is_available(),
            #[cfg(not(target_arch = "x86_64"))]
            InstructionSet::Avx512 | InstructionSet::Avx2 | InstructionSet::Sse42 => false,
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
            InstructionSet::Avx512 => match pulp::x86::V4::try_new() {
                Some(token) => code.run(Avx512(token)),
                None => code.run(Plain),
            },
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
    /// Twice as many numbers.
    type Wide: Group<{ 2 * LANES }>;

    fn wide(self) -> Self::Wide;
    /// Compiles `code`, with all that is inlined into it, for the instruction set.
    fn vectorize<R>(self, code: impl FnOnce() -> R) -> R;

    fn load(self, x: &[f32; LANES]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; LANES];
    /// Where `a < b`, one bit each.
    fn less(self, a: Self::F, b: Self::F) -> u32;
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
        fn less(self, a: Self::F, b: Self::F) -> u32 {
            (0..LANES).fold(0, |bits, i| bits | u32::from(a[i] < b[i]) << i)
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

/// Two registers where there is none that is twice as wide.
macro_rules! twice {
    () => {
        type Wide = $crate::physics::lanes::Twice<Self>;

        #[inline(always)]
        fn wide(self) -> Self::Wide {
            $crate::physics::lanes::Twice(self)
        }
    };
}
#[cfg(target_arch = "x86_64")]
pub(super) use twice;

/// Plain arrays.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

impl Numbers for Plain {
    array_numbers!();
}

impl Simd8 for Plain {
    array_moves!();
    twice!();

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
    twice!();

    #[inline(always)]
    fn vectorize<R>(self, code: impl FnOnce() -> R) -> R {
        self.0.vectorize(code)
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
                    assert_eq!(s.less(a, b), 0b0001_0010);
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
