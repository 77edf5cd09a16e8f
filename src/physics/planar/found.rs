//! The contacts of a step as they are found, with the impulses that they had in the step before.

use super::lane::{Lane, Shared};
use super::model::Model;
use super::sweep::{Impulse, LANE_SLOTS, Record, SLOTS, TIP_SLOT};
use crate::physics::narrow::{Manifold, Point};
use crate::scene::Mask;

/// A contact's identity, for the impulses of the next step.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// The pair of outlines; the tip counts as one after the last.
    pub pair: u64,
    pub feature: u32,
    /// The body, if it is the tip that presses it; else none.
    pub pressed: Option<u16>,
    pub x: f32,
    pub y: f32,
    /// Impulses, once the step is solved.
    pub normal: f32,
    pub tangential: f32,
}

/// Two bodies, or the tip and a body, that may touch.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// The tip if there is none.
    pub a: Option<usize>,
    pub b: usize,
    /// Both pieces; the tip counts as one after the last.
    pub pieces: u64,
    /// Of both together, metres.
    pub border: f32,
    /// Of the tip in the step, metres.
    pub tip_move: [f32; 2],
    /// Contacts that stay farther apart are none.
    pub reach: f32,
}

/// The contacts found so far.
pub struct Found<'a> {
    pub model: &'a Model,
    pub lane: usize,
    pub correction: f32,
    pub threshold: f32,
    pub contacts: Vec<Record>,
    pub known: Vec<Known>,
    pub reached: Vec<u16>,
    pub in_reach: Mask,
    pub overlap: f32,
    pub deepest: f32,
    /// By body, the tip last: where its contacts with what it reaches are in [`Found::known`].
    pub spans: Vec<[usize; 2]>,
    /// Where those of the body that is being looked at were in the step before.
    before: [usize; 2],
    /// They come in about the same order as then: where to look first.
    hint: usize,
}

impl<'a> Found<'a> {
    /// Takes the lists out of the lane, so that the rest of it can be read meanwhile.
    pub fn of(lane: &mut Lane, shared: &Shared<'a>) -> Found<'a> {
        Found {
            model: shared.model,
            lane: lane.index,
            correction: shared.settings.correction as f32,
            threshold: lane.travel / shared.settings.compliance as f32,
            contacts: std::mem::take(&mut lane.contacts),
            known: std::mem::take(&mut lane.known),
            reached: std::mem::take(&mut lane.reached),
            in_reach: lane.in_reach,
            overlap: lane.overlap,
            deepest: lane.deepest,
            spans: std::mem::take(&mut lane.spans),
            before: [0; 2],
            hint: 0,
        }
    }

    pub fn back_to(self, lane: &mut Lane) {
        (lane.contacts, lane.known, lane.reached) = (self.contacts, self.known, self.reached);
        (lane.in_reach, lane.overlap, lane.spans) = (self.in_reach, self.overlap, self.spans);
        lane.deepest = self.deepest;
    }

    /// From now on contacts are those of `body`, or the tip if it is the number of bodies, with what it reaches.
    pub fn begin(&mut self, lane: &Lane, body: usize) {
        self.before = lane.spans_before.get(body).copied().unwrap_or_default();
        self.hint = self.before[0];
        self.spans[body] = [self.known.len(); 2];
    }

    /// That was all of them.
    pub fn end(&mut self, body: usize) {
        self.spans[body][1] = self.known.len();
    }

    /// Lets a body take part in the step.
    pub fn reach(&mut self, body: usize, impulses: &mut [Impulse; SLOTS]) {
        if !self.in_reach.contains(body) {
            self.in_reach.insert(body);
            self.reached.push(body as u16);
            impulses[self.lane * LANE_SLOTS + body] =
                [0.0, 0.0, 0.0, self.threshold * self.model.bodies[body].threshold];
        }
    }

    /// Makes the contacts between body `a`, or the tip, and body `b`, whose borders are given together. Those of the tip
    /// are left out where they stay farther than `reach`.
    #[inline(always)]
    pub fn add(&mut self, lane: &Lane, manifold: &Manifold, pair: Pair, impulses: &mut [Impulse; SLOTS]) {
        for point in &manifold.points[..manifold.count] {
            self.add_point(lane, manifold.normal, point, &pair, impulses);
        }
    }

    #[inline(always)]
    fn add_point(
        &mut self,
        lane: &Lane,
        [nx, ny]: [f32; 2],
        point: &Point,
        pair: &Pair,
        impulses: &mut [Impulse; SLOTS],
    ) {
        let Pair { a, b, pieces, border, tip_move: [tip_x, tip_y], reach } = *pair;
        let gap = point.gap - border;
        let approach = nx * tip_x + ny * tip_y;
        if gap - approach.max(0.0) >= reach {
            return;
        }
        self.reach(b, impulses);
        let base = self.lane * LANE_SLOTS;
        let turning = |[x, y, scale, _]: [f32; 4]| {
            let (rx, ry) = (point.x - x, point.y - y);
            [(rx * ny - ry * nx) * scale, (rx * nx + ry * ny) * scale]
        };
        let lever_b = lane.levers[b];
        let ([turn_bn, turn_bt], root_b, friction) = (turning(lever_b), lever_b[3], self.model.bodies[b].friction);
        let (slot_a, [turn_an, turn_at], root_a, friction) = match a {
            Some(a) => {
                let lever = lane.levers[a];
                (base + a, turning(lever), lever[3], self.model.bodies[a].friction * friction)
            }
            None => (base + TIP_SLOT, [0.0; 2], 0.0, self.model.tip_friction * friction),
        };
        self.overlap = self.overlap.max(if a.is_some() { -gap } else { 0.0 });
        self.deepest = self.deepest.max(-point.gap);
        let wanted = if gap < 0.0 { gap * self.correction } else { gap };
        let (normal, tangential) = self.warm(lane, pieces, point);
        self.contacts.push(Record([
            [nx, ny, turn_an, turn_at],
            [turn_bn, turn_bt, root_a, root_b],
            [wanted - approach, ny * tip_x - nx * tip_y, friction, Record::pack(slot_a, base + b)],
            [normal, tangential, 0.0, 0.0],
        ]));
        let pressed = if a.is_none() { Some(b as u16) } else { None };
        let (x, y) = (point.x, point.y);
        self.known.push(Known { pair: pieces, feature: point.feature, pressed, x, y, normal: 0.0, tangential: 0.0 });
        if normal > 0.0 {
            let (fx, fy) = (nx * normal - ny * tangential, ny * normal + nx * tangential);
            let pa = &mut impulses[slot_a];
            pa[0] -= fx * root_a;
            pa[1] -= fy * root_a;
            pa[2] -= turn_an * normal + turn_at * tangential;
            let pb = &mut impulses[base + b];
            pb[0] += fx * root_b;
            pb[1] += fy * root_b;
            pb[2] += turn_bn * normal + turn_bt * tangential;
        }
    }

    /// The impulses that the same contact had in the step before: of the same features, else of the nearest point of
    /// the pair that was not taken.
    fn warm(&mut self, lane: &Lane, pair: u64, point: &Point) -> (f32, f32) {
        let [first, last] = self.before;
        for i in (self.hint..last).chain(first..self.hint) {
            let known = &lane.before[i];
            if known.pair == pair && known.feature == point.feature {
                self.hint = i + 1;
                return (known.normal, known.tangential);
            }
        }
        let mut nearest = 2.5e-5;
        let mut impulse = (0.0, 0.0);
        for known in lane.before[first..last].iter().filter(|k| k.pair == pair) {
            let (dx, dy) = (known.x - point.x, known.y - point.y);
            if dx * dx + dy * dy < nearest {
                nearest = dx * dx + dy * dy;
                impulse = (known.normal, known.tangential);
            }
        }
        impulse
    }
}
