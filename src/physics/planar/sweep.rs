//! The contact solver: Gauss-Seidel over contacts, one, eight or sixteen lanes at once, each in its own list.
//!
//! Unknowns are the impulses (normal, tangential) of the contacts. A body with the sum P of its impulses (in scaled
//! coordinates) moves by v = P max(0, 1 - phi/|P|), the gradient of the convex potential max(0, |P| - phi)^2 / 2, whose
//! Hessian is s 1 + (1 - s) p p' with s = 1 - phi/|P| and p = P/|P|. A contact is solved by one Newton step with its
//! exact 2x2 block of that Hessian, then projected onto its friction cone.

use crate::physics::lanes::{Group, LANES, Numbers};

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
    pub at: u32,
    /// Contacts of the list; 0 for a lane that has nothing to do.
    pub len: u32,
    pub sweeps: u32,
    pub most_sweeps: u32,
    /// Solved when no impulse changed by more in a sweep.
    pub tolerance: f32,
    /// Greatest change of an impulse in the sweep that is under way.
    pub change: f32,
}

#[derive(Debug, Clone, Copy)]
pub struct Constants {
    pub least_slope: f32,
}

/// Works until the step of at least one lane is solved. The lanes that are, one bit each.
#[inline(always)]
pub fn sweep<const N: usize, G: Group<N>>(
    s: G,
    constants: Constants,
    lists: &mut [&mut [Record]; N],
    cursors: &mut [Cursor; N],
    impulses: &mut [Impulse; SLOTS],
) -> u32 {
    if cursors.iter().all(|cursor| cursor.len == 0) {
        return 0;
    }
    let mut at: [u32; N] = std::array::from_fn(|l| cursors[l].at);
    // A lane without a list stays at its only record and never comes to an end.
    let len: [u32; N] = std::array::from_fn(|l| if cursors[l].len > 0 { cursors[l].len } else { u32::MAX });
    let on: [u32; N] = std::array::from_fn(|l| u32::from(cursors[l].len > 0));
    let mut greatest = s.join(&std::array::from_fn(|l| cursors[l].change));
    let mut finished = 0;
    while finished == 0 {
        greatest = tick(s, constants, lists, &at, impulses, greatest);
        let mut ended = 0u32;
        for l in 0..N {
            at[l] += on[l];
            ended |= u32::from(at[l] == len[l]) << l;
        }
        if ended == 0 {
            continue;
        }
        let mut changes = s.split(greatest);
        while ended != 0 {
            let l = ended.trailing_zeros() as usize % N;
            ended &= ended - 1;
            at[l] = 0;
            let cursor = &mut cursors[l];
            cursor.sweeps += 1;
            if changes[l] <= cursor.tolerance || cursor.sweeps >= cursor.most_sweeps {
                finished |= 1 << l;
            }
            changes[l] = 0.0;
        }
        greatest = s.join(&changes);
    }
    let changes = s.split(greatest);
    for (l, cursor) in cursors.iter_mut().enumerate() {
        (cursor.at, cursor.change) = (at[l], changes[l]);
    }
    finished
}

/// One contact of every lane.
#[inline(always)]
fn tick<const N: usize, G: Group<N>>(
    s: G,
    constants: Constants,
    lists: &mut [&mut [Record]; N],
    at: &[u32; N],
    impulses: &mut [Impulse; SLOTS],
    greatest: G::F,
) -> G::F {
    let records: [&Record; N] = G::every(
        #[inline(always)]
        |l| &lists[l][at[l] as usize],
    );
    let slots: [(usize, usize); N] = G::every(
        #[inline(always)]
        |l| records[l].slots(),
    );
    let [nx, ny, turn_an, turn_at] = s.gather(
        #[inline(always)]
        |l| records[l].0[0],
    );
    let [turn_bn, turn_bt, root_a, root_b] = s.gather(
        #[inline(always)]
        |l| records[l].0[1],
    );
    let [want_n, want_t, friction, _] = s.gather(
        #[inline(always)]
        |l| records[l].0[2],
    );
    let [old_n, old_t, mark0, mark1] = s.gather(
        #[inline(always)]
        |l| records[l].0[3],
    );
    let pa = s.gather(
        #[inline(always)]
        |l| impulses[slots[l].0],
    );
    let pb = s.gather(
        #[inline(always)]
        |l| impulses[slots[l].1],
    );

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
    let new_a = s.scatter([s.sub(pa[0], s.mul(fx, root_a)), s.sub(pa[1], s.mul(fy, root_a)), s.sub(pa[2], za), pa[3]]);
    let new_b = s.scatter([s.add(pb[0], s.mul(fx, root_b)), s.add(pb[1], s.mul(fy, root_b)), s.add(pb[2], zb), pb[3]]);
    let kept = s.scatter([new_n, new_t, mark0, mark1]);
    G::each(
        #[inline(always)]
        |l| {
            impulses[slots[l].0] = new_a[l];
            impulses[slots[l].1] = new_b[l];
            lists[l][at[l] as usize].0[3] = kept[l];
        },
    );
    s.max(s.max(s.abs(dn), s.abs(dt)), greatest)
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
