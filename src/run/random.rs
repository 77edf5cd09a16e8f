//! Random numbers as a function of where they are used.
//!
//! A [`Key`] names a place in a computation (a seed, then the branch taken at each step); a [`Stream`] draws numbers
//! from a key. Nothing depends on how many numbers were drawn elsewhere, on the order of execution or on threads.
//!
//! Algorithm: with `mix` the finaliser of SplitMix64 (Steele, Lea, Flood 2014; variant 13 of Stafford) and
//! `G = 0x9e3779b97f4a7c15`,
//! * `Key::new(s)     = mix(s + G)`,
//! * `key.child(i)    = mix(key ^ mix(i + G))`, which for a given key is one-to-one in `i`: siblings never collide,
//! * number `n` of a stream is `mix(key + (n + 1) G)`, that is SplitMix64 seeded with the key.
//!
//! The values are part of the library's behaviour: a test pins them. Integers, `unit` and `index` are the same on
//! every machine; `normal` uses the platform's logarithm.

/// The golden ratio's fraction, odd: the increment of SplitMix64.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Names a place in a computation. Plain data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Key(u64);

impl Key {
    /// The key of a whole computation.
    pub fn new(seed: u64) -> Self {
        Key(mix(seed.wrapping_add(GOLDEN)))
    }

    /// The key of branch `index` of this place.
    #[must_use]
    pub fn child(self, index: u64) -> Self {
        Key(mix(self.0 ^ mix(index.wrapping_add(GOLDEN))))
    }

    /// The numbers of this place, from the first.
    pub fn stream(self) -> Stream {
        Stream { state: self.0 }
    }

    /// The key as a number, for records.
    pub fn bits(self) -> u64 {
        self.0
    }

    /// The key that [`bits`](Self::bits) came from.
    pub fn from_bits(bits: u64) -> Self {
        Key(bits)
    }
}

/// A sequence of random numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stream {
    state: u64,
}

impl Stream {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN);
        mix(self.state)
    }

    /// Uniform in `[0, 1)`, a multiple of 2^-53.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in `[low, high)`; `low` where the two are equal.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in `0..n`, without bias (Lemire 2019). 0 where `n` is 0.
    pub fn index(&mut self, n: usize) -> usize {
        let n = n as u64;
        if n == 0 {
            return 0;
        }
        let mut product = u128::from(self.bits()) * u128::from(n);
        if (product as u64) < n {
            // Of the 2^64 values, the first (2^64 mod n) would favour some results.
            let excess = n.wrapping_neg() % n;
            while (product as u64) < excess {
                product = u128::from(self.bits()) * u128::from(n);
            }
        }
        (product >> 64) as usize
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Normal with mean 0 and standard deviation 1 (Marsaglia's polar method; the second of each pair is dropped, so
    /// that a stream has no hidden state).
    pub fn normal(&mut self) -> f64 {
        loop {
            let x = 2.0 * self.unit() - 1.0;
            let y = 2.0 * self.unit() - 1.0;
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                return x * (-2.0 * square.ln() / square).sqrt();
            }
        }
    }

    /// Puts `items` in random order, every order equally likely (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.index(last + 1));
        }
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Changing these changes every seeded result of the library.
    #[test]
    fn golden_values() {
        // SplitMix64 with seed 0, as published.
        let mut zero = Key::from_bits(0).stream();
        assert_eq!([zero.bits(), zero.bits()], [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]);
        let key = Key::new(7);
        assert_eq!(key.bits(), 0x63cb_e1e4_5932_0dd7);
        assert_eq!(key.child(0).bits(), GOLDEN_CHILDREN[0]);
        assert_eq!(key.child(1).bits(), GOLDEN_CHILDREN[1]);
        assert_eq!(key.child(1).child(0).bits(), GOLDEN_CHILDREN[2]);
        let mut stream = key.stream();
        assert_eq!(stream.unit().to_bits(), GOLDEN_UNIT);
        let mut items = [0, 1, 2, 3, 4, 5, 6, 7];
        stream.shuffle(&mut items);
        assert_eq!(items, GOLDEN_ORDER);
    }

    const GOLDEN_CHILDREN: [u64; 3] = [0xec3b_eb78_42b2_9ba4, 0x0621_80e5_8fc8_f67e, 0xf433_1947_247f_a1ab];
    const GOLDEN_UNIT: u64 = 0x3fe7_1698_52ef_d579;
    const GOLDEN_ORDER: [i32; 8] = [7, 4, 2, 0, 1, 6, 3, 5];

    #[test]
    fn an_index_is_in_range_and_uniform() {
        let mut stream = Key::new(1).stream();
        assert_eq!(stream.index(0), 0);
        assert_eq!(stream.index(1), 0);
        let mut counts = [0u32; 7];
        for _ in 0..70_000 {
            counts[stream.index(7)] += 1;
        }
        // Chi-squared with 6 degrees of freedom: 22.5 is the 0.1 % point.
        let chi: f64 = counts.iter().map(|&c| (f64::from(c) - 1e4).powi(2) / 1e4).sum();
        assert!(chi < 22.5, "{counts:?}");
        let huge = usize::MAX / 3 * 2;
        assert!((0..1000).all(|_| stream.index(huge) < huge));
    }

    #[test]
    fn normal_has_its_moments() {
        let mut stream = Key::new(2).stream();
        let values: Vec<f64> = (0..100_000).map(|_| stream.normal()).collect();
        let mean = values.iter().sum::<f64>() / 1e5;
        let square = values.iter().map(|v| v * v).sum::<f64>() / 1e5;
        assert!(mean.abs() < 0.015 && (square - 1.0).abs() < 0.02, "{mean} {square}");
    }

    #[test]
    fn a_shuffle_keeps_the_items_and_reaches_every_order() {
        let mut seen = std::collections::BTreeSet::new();
        for seed in 0..200 {
            let mut items = [0, 1, 2, 3];
            Key::new(seed).stream().shuffle(&mut items);
            seen.insert(items);
            items.sort_unstable();
            assert_eq!(items, [0, 1, 2, 3]);
        }
        assert_eq!(seen.len(), 24);
    }
}
