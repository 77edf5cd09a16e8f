//! Where the bodies are: all that a search node holds of the world.

use std::ops::{BitAnd, BitOr};

use crate::bounds;
use crate::error::Result;
use crate::geom::{Pose2, normalize_angle};

/// A body's pose as stored: three floats.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct BodyPose {
    /// Metres.
    pub x: f32,
    /// Metres.
    pub y: f32,
    /// Radians in (-pi, pi].
    pub theta: f32,
}

/// The greatest single-precision angle below pi. Pi itself rounds to a number above pi, which would be normalised to
/// the other end of the turn when it is read back.
const GREATEST_ANGLE: f32 = 3.141_592_5;

/// Refuses a pose that a state cannot hold well enough. Asks of x and y what single precision makes of them, so that
/// what is stored is judged as what was given.
pub fn check_pose(field: &str, pose: &Pose2) -> Result<()> {
    let axes = [
        ("x", pose.x, f64::from(pose.x as f32), bounds::POSITION),
        ("y", pose.y, f64::from(pose.y as f32), bounds::POSITION),
        ("theta", pose.theta, pose.theta, bounds::HEADING),
    ];
    // Names are made only for what is refused: warm images allocate nothing.
    for (axis, value, stored, bound) in axes {
        if !(bound.least..=bound.greatest).contains(&stored) {
            bound.check(&format!("{field}.{axis}"), value)?;
        }
    }
    Ok(())
}

impl From<Pose2> for BodyPose {
    #[inline]
    fn from(p: Pose2) -> Self {
        // What is refused stays refused when it is stored.
        if !(bounds::HEADING.least..=bounds::HEADING.greatest).contains(&p.theta) {
            return BodyPose { x: p.x as f32, y: p.y as f32, theta: f32::NAN };
        }
        let theta = (normalize_angle(p.theta) as f32).clamp(-GREATEST_ANGLE, GREATEST_ANGLE);
        BodyPose { x: p.x as f32, y: p.y as f32, theta }
    }
}

impl From<BodyPose> for Pose2 {
    #[inline]
    fn from(p: BodyPose) -> Self {
        Pose2::new(p.x as f64, p.y as f64, p.theta as f64)
    }
}

/// A set of body indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Mask([u64; Mask::WORDS]);

impl Mask {
    const WORDS: usize = 4;
    /// Indices that a set can hold: 0 up to this.
    pub const BITS: usize = 64 * Self::WORDS;
    pub const EMPTY: Mask = Mask([0; Self::WORDS]);

    /// The first `n` bodies.
    #[inline]
    pub fn first(n: usize) -> Mask {
        let word = |k: usize| match n.saturating_sub(64 * k) {
            left @ 0..64 => (1 << left) - 1,
            _ => u64::MAX,
        };
        Mask(std::array::from_fn(word))
    }

    #[inline]
    pub fn contains(self, body: usize) -> bool {
        self.0.get(body / 64).is_some_and(|word| word >> (body % 64) & 1 == 1)
    }

    #[inline]
    pub fn insert(&mut self, body: usize) {
        if let Some(word) = self.0.get_mut(body / 64) {
            *word |= 1 << (body % 64);
        }
    }

    #[inline]
    pub fn remove(&mut self, body: usize) {
        if let Some(word) = self.0.get_mut(body / 64) {
            *word &= !(1 << (body % 64));
        }
    }

    #[inline]
    pub fn is_empty(self) -> bool {
        self == Mask::EMPTY
    }

    #[inline]
    pub fn count(self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The bodies of this set that are not in the other.
    #[inline]
    #[must_use]
    pub fn without(self, other: Mask) -> Mask {
        Mask(std::array::from_fn(|k| self.0[k] & !other.0[k]))
    }

    /// The indices, ascending.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        let mut word = 0;
        std::iter::from_fn(move || {
            while rest[word] == 0 {
                word += 1;
                if word == Self::WORDS {
                    word -= 1;
                    return None;
                }
            }
            let bit = rest[word].trailing_zeros() as usize;
            rest[word] &= rest[word] - 1;
            Some(64 * word + bit)
        })
    }
}

/// The bit of body `k` is the k-th.
impl From<u128> for Mask {
    #[inline]
    fn from(bits: u128) -> Mask {
        let mut mask = Mask::EMPTY;
        (mask.0[0], mask.0[1]) = (bits as u64, (bits >> 64) as u64);
        mask
    }
}

impl BitAnd for Mask {
    type Output = Mask;

    #[inline]
    fn bitand(self, other: Mask) -> Mask {
        Mask(std::array::from_fn(|k| self.0[k] & other.0[k]))
    }
}

impl BitOr for Mask {
    type Output = Mask;

    #[inline]
    fn bitor(self, other: Mask) -> Mask {
        Mask(std::array::from_fn(|k| self.0[k] | other.0[k]))
    }
}

/// The poses of all bodies of a scene, and which of them are there.
/// Plain data: equal states are equal bit for bit, except that an absent body's pose is kept as it was.
#[derive(Debug, Default, PartialEq)]
pub struct State {
    poses: Vec<BodyPose>,
    present: Mask,
}

impl Clone for State {
    fn clone(&self) -> Self {
        Self { poses: self.poses.clone(), present: self.present }
    }

    /// Keeps the memory it has, so that a search's nodes can be used again.
    fn clone_from(&mut self, source: &Self) {
        self.poses.clone_from(&source.poses);
        self.present = source.present;
    }
}

impl State {
    /// All bodies present, at these poses.
    pub fn new(poses: impl IntoIterator<Item = Pose2>) -> Self {
        let poses: Vec<BodyPose> = poses.into_iter().map(BodyPose::from).collect();
        let present = Mask::first(poses.len());
        Self { poses, present }
    }

    /// Number of bodies of the scene, present or not.
    #[inline]
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    #[inline]
    pub fn pose(&self, body: usize) -> Pose2 {
        self.poses[body].into()
    }

    #[inline]
    pub fn poses(&self) -> &[BodyPose] {
        &self.poses
    }

    #[inline]
    pub fn set_pose(&mut self, body: usize, pose: Pose2) {
        self.poses[body] = pose.into();
    }

    #[inline]
    pub fn present(&self) -> Mask {
        self.present
    }

    #[inline]
    pub fn is_present(&self, body: usize) -> bool {
        self.present.contains(body)
    }

    #[inline]
    pub fn set_present(&mut self, body: usize, present: bool) {
        if present {
            self.present.insert(body);
        } else {
            self.present.remove(body);
        }
    }

    /// The present bodies with their poses, by index.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (usize, Pose2)> + '_ {
        self.present.iter().filter(|&i| i < self.poses.len()).map(|i| (i, self.pose(i)))
    }

    /// Makes this the other state with every length times `factor`, in the memory it has.
    pub fn scale_from(&mut self, other: &State, factor: f64) {
        self.poses.clear();
        self.poses.extend(other.poses.iter().map(|&pose| BodyPose::from(Pose2::from(pose).scaled(factor))));
        self.present = other.present;
    }

    /// A hash of the exact bits of present bodies' poses.
    pub fn hash_bits(&self) -> u64 {
        let mut h = 0xcbf2_9ce4_8422_2325u64 ^ self.poses.len() as u64;
        let mut mix = |v: u64| h = (h ^ v).wrapping_mul(0x0100_0000_01b3).rotate_left(23);
        // As many words as the bodies need, and two at least: more room for bodies has not changed the hash of a state.
        let words = self.poses.len().div_ceil(64).clamp(2, Mask::WORDS);
        self.present.0[..words].iter().for_each(|&word| mix(word));
        for (i, _) in self.iter() {
            let p = self.poses[i];
            for v in [p.x, p.y, p.theta] {
                mix(u64::from(v.to_bits()));
            }
        }
        h
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clone_from_reuses_memory() {
        let a = State::new((0..8).map(|i| Pose2::new(i as f64, 0.0, 0.0)));
        let mut b = a.clone();
        let before = b.poses().as_ptr();
        b.clone_from(&a);
        assert_eq!(before, b.poses().as_ptr());
        assert_eq!(a, b);
    }

    #[test]
    fn a_stored_pose_survives_being_read_and_stored_again() {
        use std::f64::consts::PI;
        for theta in [PI, -PI, PI - 1e-8, 1e-8 - PI, 9.0, 0.1] {
            let once = BodyPose::from(Pose2::new(0.1, 0.2, theta));
            assert_eq!(BodyPose::from(Pose2::from(once)), once, "{theta}");
        }
        assert!(BodyPose::from(Pose2::new(0.0, 0.0, f64::NAN)).theta.is_nan());
    }

    #[test]
    fn masks_iterate_ascending() {
        let mut m = Mask::EMPTY;
        for i in [127, 0, 64, 255] {
            m.insert(i);
        }
        assert_eq!(m.iter().collect::<Vec<_>>(), [0, 64, 127, 255]);
        m.remove(64);
        assert!(m.count() == 3 && !m.contains(64) && m.contains(127) && !m.contains(128));
        assert!((0..=Mask::BITS).all(|n| Mask::first(n).iter().eq(0..n)));
        m.insert(Mask::BITS);
        assert!(m.count() == 3 && !m.contains(Mask::BITS));
    }

    #[test]
    fn masks_are_sets() {
        let mut stream = crate::run::Key::new(1).stream();
        for _ in 0..50 {
            let mut draw = || {
                let members: std::collections::BTreeSet<usize> = (0..40).map(|_| stream.index(Mask::BITS)).collect();
                let mut mask = Mask::EMPTY;
                members.iter().for_each(|&body| mask.insert(body));
                (mask, members)
            };
            let ((a, in_a), (b, in_b)) = (draw(), draw());
            assert!((a & b).iter().eq(in_a.intersection(&in_b).copied()));
            assert!((a | b).iter().eq(in_a.union(&in_b).copied()));
            assert!(a.without(b).iter().eq(in_a.difference(&in_b).copied()));
        }
    }

    #[test]
    fn the_hash_sees_every_bit_of_present_bodies_only() {
        let a = State::new([Pose2::new(0.1, 0.2, 0.3), Pose2::new(1.0, 2.0, 3.0)]);
        let mut b = a.clone();
        b.set_pose(1, Pose2::new(1.0, 2.0, 3.0000002));
        assert_ne!(a.hash_bits(), b.hash_bits());
        let (mut c, mut d) = (a.clone(), b.clone());
        c.set_present(1, false);
        d.set_present(1, false);
        assert_eq!(c.hash_bits(), d.hash_bits());
    }
}
