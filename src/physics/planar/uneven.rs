//! Steps of bodies whose masses differ greatly: what is still missing when the usual sweeps end, and more of them if that
//! is much.
//!
//! A light body between the tip and a heavy one hands on little of what is asked of it in each sweep: the error falls by
//! a share that is about the ratio of their masses, and so do the changes by which the usual sweeps are ended. So such a
//! step is judged by what its contacts still lack.

use super::lane::{Lane, Shared};
use super::sweep::{Impulse, LANE_SLOTS, Record, SLOTS, TIP_SLOT};

/// Sweeps between two looks at what is missing.
pub const AT_A_TIME: u32 = 32;

/// Whether the lane's step wants more sweeps than so many: its bodies' masses differ greatly, its contacts lack much, and
/// it has not had its most.
pub fn wants_more(lane: &Lane, shared: &Shared<'_>, impulses: &[Impulse; SLOTS], sweeps: u32) -> bool {
    let settings = shared.settings;
    if !shared.model.uneven || sweeps as usize >= settings.uneven_sweeps || !uneven(lane, shared) {
        return false;
    }
    let allowed = settings.uneven_residual as f32 * lane.travel;
    let base = lane.index * LANE_SLOTS;
    lane.contacts.iter().any(|record| lack(record, impulses, base) > allowed)
}

/// Whether the masses of the bodies that take part, and the scene's typical one, differ greatly.
fn uneven(lane: &Lane, shared: &Shared<'_>) -> bool {
    let roots = lane.reached.iter().map(|&i| shared.model.bodies[usize::from(i)].inverse_root);
    let (least, greatest) = roots.fold((1.0f32, 1.0f32), |(low, high), root| (low.min(root), high.max(root)));
    greatest * greatest > shared.settings.uneven_masses as f32 * (least * least)
}

/// By how much the bodies of a contact miss the displacement that it wants, metres: as they are, and any deeper where
/// they do not press each other.
fn lack(record: &Record, impulses: &[Impulse; SLOTS], base: usize) -> f32 {
    let (a, b) = record.slots();
    let [
        [nx, ny, turn_an, turn_at],
        [turn_bn, turn_bt, root_a, root_b],
        [want_n, want_t, friction, _],
        [normal, tangential, ..],
    ] = record.0;
    let (an, at) =
        if a == base + TIP_SLOT { (0.0, 0.0) } else { moved(impulses[a], [nx, ny], root_a, turn_an, turn_at) };
    let (bn, bt) = moved(impulses[b], [nx, ny], root_b, turn_bn, turn_bt);
    let gap = want_n + (bn - an);
    if normal <= 0.0 {
        return (-gap).max(0.0);
    }
    let slip = if tangential.abs() < 0.999 * friction * normal { (want_t + (bt - at)).abs() } else { 0.0 };
    gap.abs().max(slip)
}

/// How far an impulse moves a body along a contact's normal and tangent.
fn moved([x, y, z, threshold]: Impulse, [nx, ny]: [f32; 2], root: f32, turn_n: f32, turn_t: f32) -> (f32, f32) {
    let size = (x * x + y * y + z * z).sqrt();
    if size <= threshold {
        return (0.0, 0.0);
    }
    let slope = 1.0 - threshold / size;
    let along = (nx * x + ny * y) * root + turn_n * z;
    let across = (nx * y - ny * x) * root + turn_t * z;
    (slope * along, slope * across)
}
