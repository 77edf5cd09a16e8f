//! Numbers of one, eight or sixteen lanes, and what moves them between the lanes' rows and registers.

use super::simd::{LANES, Numbers, Simd8};

/// Numbers of `N` lanes. Every lane may have rows of four numbers anywhere in memory.
pub trait Group<const N: usize>: Numbers {
    fn join(self, x: &[f32; N]) -> Self::F;
    fn split(self, x: Self::F) -> [f32; N];
    /// Columns of the lanes' rows: result `k` holds the `k`-th number of every row.
    fn gather(self, row: impl Fn(usize) -> [f32; 4]) -> [Self::F; 4];
    /// The rows of four columns.
    fn scatter(self, columns: [Self::F; 4]) -> [[f32; 4]; N];
    /// What `of` gives for every lane, without a detour through memory.
    fn every<T>(of: impl Fn(usize) -> T) -> [T; N];
    /// Calls `visit` with every lane; written out, so that numbers go from registers to their places.
    fn each(visit: impl FnMut(usize));
}

#[inline(always)]
pub fn every_of_sixteen<T>(of: impl Fn(usize) -> T) -> [T; 16] {
    let o = of;
    [o(0), o(1), o(2), o(3), o(4), o(5), o(6), o(7), o(8), o(9), o(10), o(11), o(12), o(13), o(14), o(15)]
}

macro_rules! each {
    ($visit:ident: $($l:literal)*) => {$( $visit($l); )*};
}

#[inline(always)]
pub fn each_of_sixteen(mut visit: impl FnMut(usize)) {
    each!(visit: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
}

impl<S: Simd8> Group<LANES> for S {
    #[inline(always)]
    fn join(self, x: &[f32; LANES]) -> Self::F {
        self.load(x)
    }
    #[inline(always)]
    fn split(self, x: Self::F) -> [f32; LANES] {
        self.store(x)
    }
    #[inline(always)]
    fn gather(self, row: impl Fn(usize) -> [f32; 4]) -> [Self::F; 4] {
        self.columns(<S as Group<LANES>>::every(row))
    }
    #[inline(always)]
    fn scatter(self, columns: [Self::F; 4]) -> [[f32; 4]; LANES] {
        self.rows(columns)
    }
    #[inline(always)]
    fn every<T>(of: impl Fn(usize) -> T) -> [T; LANES] {
        let o = of;
        [o(0), o(1), o(2), o(3), o(4), o(5), o(6), o(7)]
    }
    #[inline(always)]
    fn each(mut visit: impl FnMut(usize)) {
        each!(visit: 0 1 2 3 4 5 6 7);
    }
}

/// A single number.
#[derive(Debug, Clone, Copy)]
pub struct One;

impl Numbers for One {
    type F = f32;

    #[inline(always)]
    fn splat(self, x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn add(self, a: f32, b: f32) -> f32 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f32, b: f32) -> f32 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f32, b: f32) -> f32 {
        a * b
    }
    #[inline(always)]
    fn div(self, a: f32, b: f32) -> f32 {
        a / b
    }
    #[inline(always)]
    fn sqrt(self, a: f32) -> f32 {
        a.sqrt()
    }
    #[inline(always)]
    fn min(self, a: f32, b: f32) -> f32 {
        if a < b { a } else { b }
    }
    #[inline(always)]
    fn max(self, a: f32, b: f32) -> f32 {
        if a > b { a } else { b }
    }
    #[inline(always)]
    fn abs(self, a: f32) -> f32 {
        a.abs()
    }
    #[inline(always)]
    fn with_sign(self, a: f32, sign: f32) -> f32 {
        a.copysign(sign)
    }
    #[inline(always)]
    fn if_less(self, a: f32, b: f32, yes: f32, no: f32) -> f32 {
        if a < b { yes } else { no }
    }
}

impl Group<1> for One {
    #[inline(always)]
    fn join(self, x: &[f32; 1]) -> f32 {
        x[0]
    }
    #[inline(always)]
    fn split(self, x: f32) -> [f32; 1] {
        [x]
    }
    #[inline(always)]
    fn gather(self, row: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
        row(0)
    }
    #[inline(always)]
    fn scatter(self, columns: [f32; 4]) -> [[f32; 4]; 1] {
        [columns]
    }
    #[inline(always)]
    fn every<T>(of: impl Fn(usize) -> T) -> [T; 1] {
        [of(0)]
    }
    #[inline(always)]
    fn each(mut visit: impl FnMut(usize)) {
        visit(0);
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

impl<S: Simd8> Group<{ 2 * LANES }> for Twice<S> {
    #[inline(always)]
    fn join(self, x: &[f32; 16]) -> [S::F; 2] {
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        low.copy_from_slice(&x[..LANES]);
        high.copy_from_slice(&x[LANES..]);
        [self.0.load(&low), self.0.load(&high)]
    }
    #[inline(always)]
    fn split(self, x: [S::F; 2]) -> [f32; 16] {
        let halves = [self.0.store(x[0]), self.0.store(x[1])];
        std::array::from_fn(|i| halves[i / LANES][i % LANES])
    }
    #[inline(always)]
    fn gather(self, row: impl Fn(usize) -> [f32; 4]) -> [[S::F; 2]; 4] {
        let r = row;
        let a = self.0.columns([r(0), r(1), r(2), r(3), r(4), r(5), r(6), r(7)]);
        let b = self.0.columns([r(8), r(9), r(10), r(11), r(12), r(13), r(14), r(15)]);
        [[a[0], b[0]], [a[1], b[1]], [a[2], b[2]], [a[3], b[3]]]
    }
    #[inline(always)]
    fn scatter(self, c: [[S::F; 2]; 4]) -> [[f32; 4]; 16] {
        let [a, b, c, d] = c;
        let r = [self.0.rows([a[0], b[0], c[0], d[0]]), self.0.rows([a[1], b[1], c[1], d[1]])];
        every_of_sixteen(
            #[inline(always)]
            |i| r[i / LANES][i % LANES],
        )
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
