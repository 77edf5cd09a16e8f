//! The contact solver: Gauss-Seidel over contacts, eight lanes at once, each in its own list.
//!
//! Unknowns are the impulses (normal, tangential) of the contacts. A body with the sum P of its impulses (in scaled
//! coordinates) moves by v = P max(0, 1 - phi/|P|), the gradient of the convex potential max(0, |P| - phi)^2 / 2, whose
//! Hessian is s 1 + (1 - s) p p' with s = 1 - phi/|P| and p = P/|P|. A contact is solved by one Newton step with its
//! exact 2x2 block of that Hessian, then projected onto its friction cone.

use crate::physics::lanes::{LANES, Numbers, Simd8, Twice};

/// Pushes side by side: two registers full.
pub const PUSHES: usize = 2 * LANES;

/// A contact between bodies `a` and `b` (the tip or a body, and a body) as the solver reads it.
///
/// By rows of four: 0 normal x, y, and `a`'s turning by a unit normal and tangential impulse; 1 the same turnings of
/// `b`, and the inverse roots of both masses; 2 normal and tangential displacement that is still wanted, friction, and
/// the slots of both bodies' impulses; 3 the impulses, normal and tangential.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Record(pub [[f32; 4]; 4]);

impl Record {
    /// The record of a lane that has nothing to do: between two bodies that are nobody's.
    pub fn idle() -> Record {
        Record([[0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, Self::pack(SLOTS - 1, SLOTS - 1)], [0.0; 4]])
    }

    /// The slots as two halves of a float's bits.
    #[inline(always)]
    pub fn pack(a: usize, b: usize) -> f32 {
        f32::from_bits((a as u32) << 12 | b as u32)
    }

    #[inline(always)]
    fn slots(&self) -> (usize, usize) {
        let bits = self.0[2][3].to_bits() as usize;
        (bits >> 12 & (SLOTS - 1), bits & (SLOTS - 1))
    }
}

/// Room for the impulses of every lane's bodies; a power of two.
pub const SLOTS: usize = 4096;
/// Slots of a lane: 128 bodies, the tip, and some more so that lanes do not fall on the same lines of the cache.
pub const LANE_SLOTS: usize = 132;
/// The tip's slot in its lane: it takes every impulse and does not move by it.
pub const TIP_SLOT: usize = 128;

/// Impulse of a body in scaled coordinates (x, y, turning) and the size at which it yields.
pub type Impulse = [f32; 4];

/// How far a lane has come in its list.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cursor {
    /// The next contact.
    pub at: usize,
    /// Contacts of the list; 0 for a lane that has nothing to do.
    pub len: usize,
    pub sweeps: usize,
    pub most_sweeps: usize,
    /// Solved when no impulse changed by more in a sweep.
    pub tolerance: f32,
}

#[derive(Debug, Clone, Copy)]
pub struct Constants {
    pub least_slope: f32,
}

/// Works until the step of at least one lane is solved. The lanes that are, one bit each.
#[inline(always)]
pub fn sweep<S: Simd8>(
    s: S,
    constants: Constants,
    lists: &mut [&mut [Record]; PUSHES],
    cursors: &mut [Cursor; PUSHES],
    changes: &mut [[f32; LANES]; 2],
    impulses: &mut [Impulse; SLOTS],
) -> u32 {
    if cursors.iter().all(|cursor| cursor.len == 0) {
        return 0;
    }
    let mut at: [usize; PUSHES] = std::array::from_fn(|l| cursors[l].at);
    let len: [usize; PUSHES] = std::array::from_fn(|l| cursors[l].len);
    let mut finished = 0;
    while finished == 0 {
        let greatest = [s.load(&changes[0]), s.load(&changes[1])];
        let greatest = tick(s, constants, lists, &at, impulses, greatest);
        *changes = [s.store(greatest[0]), s.store(greatest[1])];
        for l in 0..PUSHES {
            // A lane without a list stays at its only record.
            let next = at[l] + 1;
            at[l] = if len[l] > 0 { next } else { 0 };
            if next == len[l] {
                at[l] = 0;
                let cursor = &mut cursors[l];
                cursor.sweeps += 1;
                let change = &mut changes[l / LANES][l % LANES];
                if *change <= cursor.tolerance || cursor.sweeps >= cursor.most_sweeps {
                    finished |= 1 << l;
                }
                *change = 0.0;
            }
        }
    }
    for (cursor, at) in cursors.iter_mut().zip(at) {
        cursor.at = at;
    }
    finished
}

/// One contact of every lane.
#[inline(always)]
fn tick<S: Simd8>(
    simd: S,
    constants: Constants,
    lists: &mut [&mut [Record]; PUSHES],
    at: &[usize; PUSHES],
    impulses: &mut [Impulse; SLOTS],
    greatest: [S::F; 2],
) -> [S::F; 2] {
    let records: [&Record; PUSHES] = every(
        #[inline(always)]
        |l| &lists[l][at[l]],
    );
    let slots: [(usize, usize); PUSHES] = every(
        #[inline(always)]
        |l| records[l].slots(),
    );
    let [nx, ny, turn_an, turn_at] = columns(
        simd,
        #[inline(always)]
        |l| records[l].0[0],
    );
    let [turn_bn, turn_bt, root_a, root_b] = columns(
        simd,
        #[inline(always)]
        |l| records[l].0[1],
    );
    let [want_n, want_t, friction, _] = columns(
        simd,
        #[inline(always)]
        |l| records[l].0[2],
    );
    let [old_n, old_t, mark0, mark1] = columns(
        simd,
        #[inline(always)]
        |l| records[l].0[3],
    );
    let pa = columns(
        simd,
        #[inline(always)]
        |l| impulses[slots[l].0],
    );
    let pb = columns(
        simd,
        #[inline(always)]
        |l| impulses[slots[l].1],
    );

    let s = Twice(simd);
    let zero = s.splat(0.0);
    let one = s.splat(1.0);
    let least = s.splat(constants.least_slope);
    let [an, at_, ann, ant, att] = side(s, [nx, ny], pa, root_a, turn_an, turn_at, least);
    let [bn, bt, bnn, bnt, btt] = side(s, [nx, ny], pb, root_b, turn_bn, turn_bt, least);
    // What is missing of the wanted displacement, negative where too little.
    let gap_n = s.add(want_n, s.sub(bn, an));
    let gap_t = s.add(want_t, s.sub(bt, at_));
    let tiny = s.splat(1e-12);
    let (hnn, hnt, htt) = (s.add(s.add(ann, bnn), tiny), s.add(ant, bnt), s.add(s.add(att, btt), tiny));
    // Sticking: both displacements are as wanted.
    let inverse = s.div(one, s.sub(s.mul(hnn, htt), s.mul(hnt, hnt)));
    let stick_n = s.sub(old_n, s.mul(inverse, s.sub(s.mul(htt, gap_n), s.mul(hnt, gap_t))));
    let stick_t = s.sub(old_t, s.mul(inverse, s.sub(s.mul(hnn, gap_t), s.mul(hnt, gap_n))));
    // Sliding: the tangential impulse is at its limit on the side where sticking would have it.
    let mu = s.with_sign(friction, stick_t);
    let stiff = s.max(s.add(hnn, s.mul(mu, hnt)), s.mul(s.splat(0.1), hnn));
    let slide = s.sub(old_n, s.div(s.add(gap_n, s.mul(hnt, s.sub(s.mul(mu, old_n), old_t))), stiff));
    let slide_n = s.max(slide, zero);
    let slide_t = s.mul(mu, slide_n);
    // Which it is: sticking needs |t| <= friction n, which also keeps n from being negative.
    let limit = s.mul(friction, stick_n);
    let new_n = s.if_less(limit, s.abs(stick_t), slide_n, stick_n);
    let new_t = s.if_less(limit, s.abs(stick_t), slide_t, stick_t);
    let new_n = s.max(new_n, zero);

    let (dn, dt) = (s.sub(new_n, old_n), s.sub(new_t, old_t));
    let (fx, fy) = (s.sub(s.mul(nx, dn), s.mul(ny, dt)), s.add(s.mul(ny, dn), s.mul(nx, dt)));
    let (za, zb) = (s.add(s.mul(turn_an, dn), s.mul(turn_at, dt)), s.add(s.mul(turn_bn, dn), s.mul(turn_bt, dt)));
    let new_a = back(simd, [s.sub(pa[0], s.mul(fx, root_a)), s.sub(pa[1], s.mul(fy, root_a)), s.sub(pa[2], za), pa[3]]);
    let new_b = back(simd, [s.add(pb[0], s.mul(fx, root_b)), s.add(pb[1], s.mul(fy, root_b)), s.add(pb[2], zb), pb[3]]);
    let kept = back(simd, [new_n, new_t, mark0, mark1]);
    // Written out, so that the numbers go from registers to their places.
    macro_rules! write_back {
        ($($l:literal)*) => {$(
            impulses[slots[$l].0] = new_a[$l / LANES][$l % LANES];
            impulses[slots[$l].1] = new_b[$l / LANES][$l % LANES];
            lists[$l][at[$l]].0[3] = kept[$l / LANES][$l % LANES];
        )*};
    }
    write_back!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    s.max(s.max(s.abs(dn), s.abs(dt)), greatest)
}

/// What `of` gives for every lane, without a detour through memory.
#[inline(always)]
fn every<T>(of: impl Fn(usize) -> T) -> [T; PUSHES] {
    let o = of;
    [o(0), o(1), o(2), o(3), o(4), o(5), o(6), o(7), o(8), o(9), o(10), o(11), o(12), o(13), o(14), o(15)]
}

/// The columns of a row of every lane.
#[inline(always)]
fn columns<S: Simd8>(s: S, row: impl Fn(usize) -> [f32; 4]) -> [[S::F; 2]; 4] {
    let r = row;
    let a = s.columns([r(0), r(1), r(2), r(3), r(4), r(5), r(6), r(7)]);
    let b = s.columns([r(8), r(9), r(10), r(11), r(12), r(13), r(14), r(15)]);
    [[a[0], b[0]], [a[1], b[1]], [a[2], b[2]], [a[3], b[3]]]
}

/// The rows of both groups of lanes.
#[inline(always)]
fn back<S: Simd8>(s: S, c: [[S::F; 2]; 4]) -> [[[f32; 4]; LANES]; 2] {
    [s.rows([c[0][0], c[1][0], c[2][0], c[3][0]]), s.rows([c[0][1], c[1][1], c[2][1], c[3][1]])]
}

/// What a body with the impulse `p` contributes to a contact: its motion along the normal and the tangent, and the
/// contact's block of the Hessian (normal, mixed, tangential).
#[inline(always)]
fn side<S: Numbers>(
    s: S,
    [nx, ny]: [S::F; 2],
    [x, y, z, threshold]: [S::F; 4],
    root: S::F,
    turn_n: S::F,
    turn_t: S::F,
    least: S::F,
) -> [S::F; 5] {
    let one = s.splat(1.0);
    let squared = s.add(s.add(s.add(s.mul(x, x), s.mul(y, y)), s.mul(z, z)), s.splat(1e-24));
    let inverse = s.div(one, s.sqrt(squared));
    let slope = s.max(s.sub(one, s.mul(threshold, inverse)), s.splat(0.0));
    let (nx, ny) = (s.mul(nx, root), s.mul(ny, root));
    // The direction of the impulse along the normal and the tangent.
    let along_n = s.mul(s.add(s.add(s.mul(nx, x), s.mul(ny, y)), s.mul(turn_n, z)), inverse);
    let along_t = s.mul(s.add(s.sub(s.mul(nx, y), s.mul(ny, x)), s.mul(turn_t, z)), inverse);
    let speed = s.mul(slope, s.mul(squared, inverse));
    let flat = s.max(slope, least);
    let rest = s.sub(one, flat);
    let mass = s.mul(root, root);
    let nn = s.add(s.mul(flat, s.add(mass, s.mul(turn_n, turn_n))), s.mul(rest, s.mul(along_n, along_n)));
    let nt = s.add(s.mul(flat, s.mul(turn_n, turn_t)), s.mul(rest, s.mul(along_n, along_t)));
    let tt = s.add(s.mul(flat, s.add(mass, s.mul(turn_t, turn_t))), s.mul(rest, s.mul(along_t, along_t)));
    [s.mul(speed, along_n), s.mul(speed, along_t), nn, nt, tt]
}
