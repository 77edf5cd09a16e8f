//! Registers of x86-64.

use std::arch::x86_64::{__m128, __m256, __m512};

use super::group::{Group, each_of_sixteen, every_of_sixteen};
use super::simd::{LANES, Numbers, Simd8, twice};

/// AVX registers.
#[derive(Debug, Clone, Copy)]
pub struct Avx2(pub(super) pulp::x86::V3);

/// AVX registers, of which there are twice as many as with AVX2.
#[derive(Debug, Clone, Copy)]
pub struct Avx512(pub(super) pulp::x86::V4);

/// AVX-512 registers.
#[derive(Debug, Clone, Copy)]
pub struct Sixteen(pulp::x86::V4);

macro_rules! eight {
    ($name:ident, $wide:ident) => {
        impl $name {
            #[inline(always)]
            fn pair(self, low: [f32; 4], high: [f32; 4]) -> __m256 {
                self.0.avx._mm256_set_m128(pulp::cast::<_, __m128>(high), pulp::cast::<_, __m128>(low))
            }

            #[inline(always)]
            fn halves(self, pair: __m256) -> [[f32; 4]; 2] {
                pulp::cast(pair)
            }
        }

        impl Numbers for $name {
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

        impl Simd8 for $name {
            $wide!();

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
            fn less(self, a: __m256, b: __m256) -> u32 {
                // 17: less than, ordered, quiet.
                self.0.avx._mm256_movemask_ps(self.0.avx._mm256_cmp_ps::<17>(a, b)) as u32
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
    };
}

macro_rules! sixteen {
    () => {
        type Wide = Sixteen;

        #[inline(always)]
        fn wide(self) -> Sixteen {
            Sixteen(self.0)
        }
    };
}

eight!(Avx2, twice);
eight!(Avx512, sixteen);

impl Numbers for Sixteen {
    type F = __m512;

    #[inline(always)]
    fn splat(self, x: f32) -> __m512 {
        self.0.avx512f._mm512_set1_ps(x)
    }
    #[inline(always)]
    fn add(self, a: __m512, b: __m512) -> __m512 {
        self.0.avx512f._mm512_add_ps(a, b)
    }
    #[inline(always)]
    fn sub(self, a: __m512, b: __m512) -> __m512 {
        self.0.avx512f._mm512_sub_ps(a, b)
    }
    #[inline(always)]
    fn mul(self, a: __m512, b: __m512) -> __m512 {
        self.0.avx512f._mm512_mul_ps(a, b)
    }
    #[inline(always)]
    fn div(self, a: __m512, b: __m512) -> __m512 {
        self.0.avx512f._mm512_div_ps(a, b)
    }
    #[inline(always)]
    fn sqrt(self, a: __m512) -> __m512 {
        self.0.avx512f._mm512_sqrt_ps(a)
    }
    #[inline(always)]
    fn min(self, a: __m512, b: __m512) -> __m512 {
        self.0.avx512f._mm512_min_ps(a, b)
    }
    #[inline(always)]
    fn max(self, a: __m512, b: __m512) -> __m512 {
        self.0.avx512f._mm512_max_ps(a, b)
    }
    #[inline(always)]
    fn abs(self, a: __m512) -> __m512 {
        self.0.avx512dq._mm512_andnot_ps(self.splat(-0.0), a)
    }
    #[inline(always)]
    fn with_sign(self, a: __m512, sign: __m512) -> __m512 {
        self.0.avx512dq._mm512_or_ps(a, self.0.avx512dq._mm512_and_ps(self.splat(-0.0), sign))
    }
    #[inline(always)]
    fn if_less(self, a: __m512, b: __m512, yes: __m512, no: __m512) -> __m512 {
        // 17: less than, ordered, quiet.
        let less = self.0.avx512f._mm512_cmp_ps_mask::<17>(a, b);
        self.0.avx512f._mm512_mask_blend_ps(less, no, yes)
    }
}

impl Group<16> for Sixteen {
    #[inline(always)]
    fn join(self, x: &[f32; 16]) -> __m512 {
        pulp::cast(*x)
    }
    #[inline(always)]
    fn split(self, x: __m512) -> [f32; 16] {
        pulp::cast(x)
    }
    #[inline(always)]
    fn gather(self, row: impl Fn(usize) -> [f32; 4]) -> [__m512; 4] {
        let avx = self.0.avx512f;
        let r = row;
        // A register of every fourth row.
        macro_rules! four {
            ($i:literal) => {{
                let low = avx._mm512_castps128_ps512(pulp::cast::<_, __m128>(r($i)));
                let low = avx._mm512_insertf32x4::<1>(low, pulp::cast::<_, __m128>(r($i + 4)));
                let low = avx._mm512_insertf32x4::<2>(low, pulp::cast::<_, __m128>(r($i + 8)));
                avx._mm512_insertf32x4::<3>(low, pulp::cast::<_, __m128>(r($i + 12)))
            }};
        }
        self.transpose([four!(0), four!(1), four!(2), four!(3)])
    }
    #[inline(always)]
    fn scatter(self, columns: [__m512; 4]) -> [[f32; 4]; 16] {
        let rows = self.transpose(columns);
        let [a, b, c, d] = [0, 1, 2, 3].map(
            #[inline(always)]
            |k| pulp::cast::<_, [[f32; 4]; 4]>(rows[k]),
        );
        [a[0], b[0], c[0], d[0], a[1], b[1], c[1], d[1], a[2], b[2], c[2], d[2], a[3], b[3], c[3], d[3]]
    }
    #[inline(always)]
    fn every<T>(of: impl Fn(usize) -> T) -> [T; 16] {
        every_of_sixteen(of)
    }
    #[inline(always)]
    fn each(visit: impl FnMut(usize)) {
        each_of_sixteen(visit);
    }
}

impl Sixteen {
    /// Transposes four blocks of four by four.
    #[inline(always)]
    fn transpose(self, [a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
        let avx = self.0.avx512f;
        let (ab_low, ab_high) = (avx._mm512_unpacklo_ps(a, b), avx._mm512_unpackhi_ps(a, b));
        let (cd_low, cd_high) = (avx._mm512_unpacklo_ps(c, d), avx._mm512_unpackhi_ps(c, d));
        [
            avx._mm512_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low),
            avx._mm512_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low),
            avx._mm512_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
            avx._mm512_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
        ]
    }
}
