//! The contact solver: Gauss-Seidel over contacts, one, eight or sixteen lanes at once, each in its own list.
//!
//! Unknowns are the impulses (normal, tangential) of the contacts. A body with the sum P of its impulses (in scaled
//! coordinates) moves by v = P max(0, 1 - phi/|P|), the gradient of the convex potential max(0, |P| - phi)^2 / 2, whose
//! Hessian is s 1 + (1 - s) p p' with s = 1 - phi/|P| and p = P/|P|. A contact is solved by one Newton step with its
//! exact 2x2 block of that Hessian, to which a share of its last change is added (heavy ball, Polyak 1964: long chains
//! converge slowly and steadily), then projected onto its friction cone. Most sweeps leave out the contacts that do not
//! press; a step is solved only when a sweep over all of them changes little.

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
        let mut record = Record([[0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, Self::pack(SLOTS - 1, SLOTS - 1)], [0.0; 4]]);
        record.set_stride(0);
        record
    }

    /// The slots in a float's bits, and that the next contact is to follow.
    #[inline(always)]
    pub fn pack(a: usize, b: usize) -> f32 {
        f32::from_bits(1 << STRIDE_SHIFT | (a as u32) << 12 | b as u32)
    }

    /// How many contacts further on the next one lies that is to be visited.
    #[inline(always)]
    fn stride(&self) -> u32 {
        self.0[2][3].to_bits() >> STRIDE_SHIFT
    }

    #[inline(always)]
    fn set_stride(&mut self, stride: u32) {
        let bits = self.0[2][3].to_bits() & ((1 << STRIDE_SHIFT) - 1);
        self.0[2][3] = f32::from_bits(stride << STRIDE_SHIFT | bits);
    }

    #[inline(always)]
    pub fn slots(&self) -> (usize, usize) {
        let bits = self.0[2][3].to_bits() as usize;
        (bits >> 12 & (SLOTS - 1), bits & (SLOTS - 1))
    }
}

/// Contacts of every lane that a call visits at most, so that its caller can look at the time: some tens of microseconds.
const MOST_TICKS: u32 = 2048;
/// Bits of a record's slots.
const STRIDE_SHIFT: u32 = 24;
/// Shorter lists are always visited whole.
const WORTH_PARTING: u32 = 5;
/// Contacts that a stride may pass over, less one: keeps the bits those of a finite number.
const LONGEST_STRIDE: u32 = 63;

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
    /// Sweeps until all contacts are visited again; 0 if the sweep that is under way visits them all.
    pub partial: u32,
    /// The first contact of the sweep that is under way.
    pub first: u32,
    /// The step is solved.
    pub solved: bool,
    pub sweeps: u32,
    pub most_sweeps: u32,
    /// Solved when no impulse changed by more in a sweep.
    pub tolerance: f32,
    /// Greatest change of an impulse in the sweep that is under way.
    pub change: f32,
    /// The same of the sweep before.
    pub last_change: f32,
    /// Share of an impulse's last change that is added to its next one.
    pub momentum: f32,
    /// The same, at most.
    pub most_momentum: f32,
    /// Sweeps since the momentum was last given up.
    pub steady: u32,
}

#[derive(Debug, Clone, Copy)]
pub struct Constants {
    pub least_slope: f32,
    /// Sweeps over the contacts that press between two over all of them.
    pub partial: u32,
}

/// Every contact is to be visited.
fn visit_all(records: &mut [Record]) {
    records.iter_mut().for_each(|record| record.set_stride(1));
}

/// Only those contacts are to be visited that press, and a few between which others would have to be passed over. The
/// first of them.
fn visit_pressing(records: &mut [Record]) -> u32 {
    let n = records.len();
    let mut next = n;
    for i in (0..n).rev() {
        let pressing = records[i].0[3][0] > 0.0;
        if pressing || next - i == LONGEST_STRIDE as usize {
            records[i].set_stride((next - i) as u32);
            next = i;
        }
    }
    next as u32
}

impl Cursor {
    /// Goes on with a list that has become longer.
    pub fn resume(&mut self, records: &mut [Record], most_sweeps: u32) {
        visit_all(records);
        (self.at, self.first, self.partial, self.solved) = (0, 0, 0, false);
        (self.len, self.most_sweeps) = (records.len() as u32, most_sweeps);
        (self.change, self.last_change, self.momentum, self.steady) = (0.0, f32::MAX, 0.0, 0);
    }

    /// Goes on for so many sweeps, however little they change: what a light body between heavy ones lacks comes to it by
    /// little in each. With the whole of an impulse's last change added, as many are enough as the root of the ratio of
    /// masses, and not the ratio (Nesterov 1983).
    pub fn extend(&mut self, records: &mut [Record], sweeps: u32) {
        visit_all(records);
        (self.at, self.first, self.partial, self.solved) = (0, 0, 0, false);
        (self.change, self.tolerance, self.most_momentum) = (0.0, 0.0, 1.0);
        self.most_sweeps = self.sweeps + sweeps;
    }

    /// What the next sweep is to be, and where it begins.
    #[inline(always)]
    fn end_of_sweep(&mut self, constants: Constants, change: f32, records: &mut [Record]) -> u32 {
        self.sweeps += 1;
        let small = change <= self.tolerance;
        if self.partial == 0 {
            self.first = 0;
            if small || self.sweeps >= self.most_sweeps {
                self.solved = true;
            } else if constants.partial > 0 && self.len >= WORTH_PARTING {
                self.first = visit_pressing(records);
                self.partial = constants.partial;
                if self.first >= self.len {
                    (self.first, self.partial) = (0, 0);
                    visit_all(records);
                }
            }
        } else {
            self.partial = if small { 0 } else { self.partial - 1 };
            if self.partial == 0 {
                self.first = 0;
                visit_all(records);
            }
        }
        // Momentum grows while changes become smaller, and is given up when one is greater.
        self.steady = if change > self.last_change { 1 } else { self.steady + 1 };
        let k = self.steady.saturating_sub(2) as f32;
        self.momentum = self.most_momentum * k / (k + 3.0);
        self.last_change = change;
        self.first
    }
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
    let mut greatest = s.join(&std::array::from_fn(|l| cursors[l].change));
    let mut momenta: [f32; N] = std::array::from_fn(|l| cursors[l].momentum);
    let mut momentum = s.join(&momenta);
    let mut finished = 0;
    let mut ticks = 0;
    while finished == 0 && ticks < MOST_TICKS {
        ticks += 1;
        greatest = tick(s, constants, lists, &mut at, impulses, greatest, momentum);
        let mut ended = 0u32;
        for l in 0..N {
            ended |= u32::from(at[l] >= len[l]) << l;
        }
        if ended == 0 {
            continue;
        }
        let mut changes = s.split(greatest);
        while ended != 0 {
            let l = ended.trailing_zeros() as usize % N;
            ended &= ended - 1;
            let cursor = &mut cursors[l];
            at[l] = cursor.end_of_sweep(constants, changes[l], lists[l]);
            finished |= u32::from(cursor.solved) << l;
            momenta[l] = cursor.momentum;
            changes[l] = 0.0;
        }
        greatest = s.join(&changes);
        momentum = s.join(&momenta);
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
    at: &mut [u32; N],
    impulses: &mut [Impulse; SLOTS],
    greatest: G::F,
    momentum: G::F,
) -> G::F {
    let records: [&Record; N] = G::every(
        #[inline(always)]
        |l| &lists[l][at[l] as usize],
    );
    let next: [u32; N] = G::every(
        #[inline(always)]
        |l| at[l] + records[l].stride(),
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
    let [old_n, old_t, last_n, last_t] = s.gather(
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
    let new_n = s.max(s.add(new_n, s.mul(momentum, last_n)), zero);
    let limit = s.mul(friction, new_n);
    let new_t = s.add(new_t, s.mul(momentum, last_t));
    let new_t = s.with_sign(s.min(s.abs(new_t), limit), new_t);

    let (dn, dt) = (s.sub(new_n, old_n), s.sub(new_t, old_t));
    let (fx, fy) = (s.sub(s.mul(nx, dn), s.mul(ny, dt)), s.add(s.mul(ny, dn), s.mul(nx, dt)));
    let (za, zb) = (s.add(s.mul(turn_an, dn), s.mul(turn_at, dt)), s.add(s.mul(turn_bn, dn), s.mul(turn_bt, dt)));
    let new_a = s.scatter([s.sub(pa[0], s.mul(fx, root_a)), s.sub(pa[1], s.mul(fy, root_a)), s.sub(pa[2], za), pa[3]]);
    let new_b = s.scatter([s.add(pb[0], s.mul(fx, root_b)), s.add(pb[1], s.mul(fy, root_b)), s.add(pb[2], zb), pb[3]]);
    let kept = s.scatter([new_n, new_t, dn, dt]);
    G::each(
        #[inline(always)]
        |l| {
            impulses[slots[l].0] = new_a[l];
            impulses[slots[l].1] = new_b[l];
            lists[l][at[l] as usize].0[3] = kept[l];
        },
    );
    *at = next;
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
