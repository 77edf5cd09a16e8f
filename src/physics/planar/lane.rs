//! One lane's push: where everything is, and what happens between two steps.

use super::found::{Found, Known, Pair};
use super::model::Model;
use super::settings::PlanarSettings;
use super::sweep::{Cursor, Impulse, LANE_SLOTS, Record, SLOTS, TIP_SLOT};
use super::trig::sin_cos;
use super::uneven;
use crate::geom::Pose2;
use crate::physics::approach::is_thrown;
use crate::physics::lanes::{LANES, Simd8};
use crate::physics::narrow::{Frame2, Octet, Placed, contact};
use crate::physics::transition::{DEEPEST, PushJob, PushResult, PushStatus};
use crate::run::Stop;
use crate::scene::{BodyPose, Mask, Scene, State};

/// A gap below this ends the free travel of the tip, metres.
const NEAR: f32 = 5e-5;
/// Bodies are looked for a little farther than their contacts, so that rounding leaves nothing out, metres.
const ROUNDING: f32 = 1e-4;

/// Everything of a push that is being executed. Its vectors keep their memory from push to push.
#[derive(Debug, Default)]
pub struct Lane {
    pub(super) index: usize,
    poses: Vec<BodyPose>,
    /// Origins and rotations of all bodies.
    frames: Vec<Frame2>,
    present: Vec<u16>,
    /// Bounding circles of the bodies; of those that are absent, and to fill up, circles that nothing is near.
    circles: Vec<Circles>,
    borders: Vec<f32>,
    /// From the centre of mass to the centre of pressure, world frame.
    leads: Vec<[f32; 2]>,
    /// Where and how impulses act on bodies: the centre of pressure, world frame; what an impulse times its arm turns the
    /// body by, in scaled coordinates; and the inverse root of its mass.
    pub(super) levers: Vec<[f32; 4]>,
    octets: Vec<Octet>,
    /// Middles of the outlines' bounding circles.
    centres: Vec<[f32; 2]>,
    moved: Mask,
    touched: Mask,
    /// Bodies that contacts join to the tip or to one that moves, from the tip outwards.
    pub(super) reached: Vec<u16>,
    pub(super) in_reach: Mask,
    /// Those of them whose own contacts were looked for.
    spread: Mask,
    /// Bodies that moved in the step before.
    yielded: Mask,
    /// By body, the tip last: where its contacts with what it reaches are in `known`, and were in `before`.
    pub(super) spans: Vec<[usize; 2]>,
    pub(super) spans_before: Vec<[usize; 2]>,
    pub contacts: Vec<Record>,
    pub(super) known: Vec<Known>,
    pub(super) before: Vec<Known>,
    tip: Vec<Octet>,
    tip_centre: [f32; 2],
    direction: [f32; 2],
    /// Of a step, metres.
    pub(super) travel: f32,
    steps_left: usize,
    /// Of the whole push, metres.
    length: f32,
    /// By body, the way from which on the tip no longer pushes it. Empty where the robot has no path for the tip: there
    /// it always does.
    over: Vec<f32>,
    /// Deepest overlap of two bodies at the beginning of the step, borders included, metres.
    pub(super) overlap: f32,
    /// Deepest overlap of the tip or a body and a body at the beginning of the step, without borders, metres.
    pub(super) deepest: f32,
    /// What is allowed of it: what was at the beginning of the push, or [`DEEPEST`].
    allowed: f32,
    clean_up_left: usize,
}

/// Eight bounding circles.
#[derive(Debug, Clone, Copy)]
struct Circles {
    x: [f32; LANES],
    y: [f32; LANES],
    radius: [f32; LANES],
}

impl Circles {
    /// Circles of negative infinite radius, which are near to nothing.
    const NOWHERE: Circles = Circles { x: [0.0; LANES], y: [0.0; LANES], radius: [f32::NEG_INFINITY; LANES] };

    /// Which of them are nearer to a circle than its radius, one bit each.
    #[inline(always)]
    fn near<S: Simd8>(&self, s: S, x: f32, y: f32, radius: f32) -> u32 {
        let (dx, dy) = (s.sub(s.load(&self.x), s.splat(x)), s.sub(s.load(&self.y), s.splat(y)));
        let reach = s.max(s.add(s.load(&self.radius), s.splat(radius)), s.splat(0.0));
        s.less(s.add(s.mul(dx, dx), s.mul(dy, dy)), s.mul(reach, reach))
    }
}

/// What the lanes of a call share.
pub struct Shared<'a> {
    pub scene: &'a Scene,
    pub model: &'a Model,
    pub settings: &'a PlanarSettings,
    /// What takes long is broken off when it is requested: the push is not to be used then.
    pub stop: &'a Stop,
}

/// Pairs of pieces between two looks at the stop: some tens of microseconds.
const PAIRS_PER_LOOK: usize = 64;

impl Lane {
    pub fn new(index: usize) -> Lane {
        Lane { index, ..Lane::default() }
    }

    /// Loads a push and prepares its first step. False if that was all of it; the result is written then.
    pub fn begin<S: Simd8>(
        &mut self,
        s: S,
        shared: &Shared<'_>,
        job: &PushJob<'_>,
        result: &mut PushResult,
        impulses: &mut [Impulse; SLOTS],
        cursor: &mut Cursor,
    ) -> bool {
        result.state.clone_from(job.state);
        result.touched = Mask::EMPTY;
        result.left = Mask::EMPTY;
        let push = &job.push;
        if !push.is_finite() || push.length() < 1e-6 {
            result.status = PushStatus::Illegal { body: None };
            return false;
        }
        result.status = PushStatus::Executed;
        self.load(s, shared, job.state);
        let (start, direction, length) = (push.start(), push.direction(), push.length());
        self.direction = [direction.x as f32, direction.y as f32];
        self.length = length as f32;
        self.over.clear();
        if let Some(path) = &shared.model.path {
            let stroke = path.stroke(push.start(), push.end());
            let share = shared.settings.tipping_share;
            self.over.extend(shared.model.heights.iter().map(|top| path.over(&stroke, share * top) as f32));
        }
        self.place_tip(s, shared, [start.x as f32, start.y as f32]);
        if let Some(body) = self.landed_on(s, shared) {
            result.status = PushStatus::Illegal { body: Some(body) };
            return false;
        }
        let Some(free) = self.free_travel(s, shared, length as f32) else { return false };
        self.shrink_borders(s, shared);
        let steps = ((length - f64::from(free)) / shared.settings.step_length).ceil().max(1.0);
        self.travel = ((length - f64::from(free)) / steps) as f32;
        self.steps_left = steps as usize;
        self.clean_up_left = shared.settings.clean_up_steps;
        self.place_tip(
            s,
            shared,
            [start.x as f32 + self.direction[0] * free, start.y as f32 + self.direction[1] * free],
        );
        let lead = shared.settings.pressure_lead as f32;
        self.leads.fill([self.direction[0] * lead, self.direction[1] * lead]);
        for k in 0..self.present.len() {
            self.place_lever(shared.model, usize::from(self.present[k]));
        }
        self.prepare(s, shared, impulses, cursor) || self.finish(shared, job, result)
    }

    /// Moves everything by the solved step and prepares the next. False if the push is over; the result is written then.
    pub fn advance<S: Simd8>(
        &mut self,
        s: S,
        shared: &Shared<'_>,
        job: &PushJob<'_>,
        result: &mut PushResult,
        impulses: &mut [Impulse; SLOTS],
        cursor: &mut Cursor,
    ) -> bool {
        if self.spread_out(s, shared, impulses) {
            let most_sweeps = most_sweeps(shared, self.contacts.len());
            cursor.resume(&mut self.contacts, most_sweeps);
            return true;
        }
        if uneven::wants_more(self, shared, impulses, cursor.sweeps) {
            cursor.extend(&mut self.contacts, uneven::AT_A_TIME);
            return true;
        }
        self.note_impulses();
        self.integrate(s, shared, impulses);
        self.move_tip(s, shared);
        self.prepare(s, shared, impulses, cursor) || self.finish(shared, job, result)
    }

    /// Contacts of the next step that has any. False if there is no such step.
    fn prepare<S: Simd8>(
        &mut self,
        s: S,
        shared: &Shared<'_>,
        impulses: &mut [Impulse; SLOTS],
        cursor: &mut Cursor,
    ) -> bool {
        while self.steps_left + self.clean_up_left > 0 && !shared.stop.requested() {
            self.find_contacts(s, shared, impulses);
            if shared.model.uneven && self.deepest > self.allowed + self.travel {
                return false;
            }
            let apart = self.overlap <= shared.settings.clean_up_overlap as f32 && self.deepest <= self.allowed;
            if self.steps_left == 0 && apart {
                return false;
            }
            if !self.contacts.is_empty() {
                let settings = shared.settings;
                let share = if self.steps_left > 0 { settings.tolerance } else { settings.clean_up_tolerance };
                *cursor = Cursor {
                    partial: 0,
                    first: 0,
                    solved: false,
                    at: 0,
                    len: self.contacts.len() as u32,
                    sweeps: 0,
                    most_sweeps: most_sweeps(shared, self.contacts.len()),
                    tolerance: share as f32 * self.travel,
                    change: 0.0,
                    last_change: f32::MAX,
                    momentum: 0.0,
                    most_momentum: settings.momentum as f32,
                    steady: 0,
                };
                return true;
            }
            self.move_tip(s, shared);
        }
        self.find_contacts(s, shared, impulses);
        false
    }

    /// Writes the result; always false.
    fn finish(&mut self, shared: &Shared<'_>, job: &PushJob<'_>, result: &mut PushResult) -> bool {
        let before = job.state;
        if self.deepest > self.allowed {
            result.take_back(before);
            return false;
        }
        result.touched = self.touched;
        let workspace = shared.scene.workspace();
        for body in self.moved.iter() {
            let pose: Pose2 = self.poses[body].into();
            if !pose.is_finite() || is_thrown(&job.push, &before.pose(body), &pose) {
                result.take_back(before);
                return false;
            }
            result.state.set_pose(body, pose);
            // What is stored is what is judged.
            let (pose, footprint) = (result.state.pose(body), &shared.scene.body(body).footprint);
            if !workspace.holds(footprint, &pose) && workspace.holds(footprint, &before.pose(body)) {
                result.left.insert(body);
            }
        }
        false
    }

    fn load<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, state: &State) {
        let model = shared.model;
        let n = model.bodies.len();
        self.poses.clear();
        self.poses.extend_from_slice(state.poses());
        self.present.clear();
        self.present.extend(state.present().iter().filter(|&i| i < n).map(|i| i as u16));
        self.frames.resize(n, Frame2 { x: 0.0, y: 0.0, cos: 1.0, sin: 0.0 });
        self.borders.clear();
        self.borders.resize(n, shared.settings.border as f32);
        self.leads.resize(n, [0.0; 2]);
        self.levers.resize(n, [0.0; 4]);
        self.octets.resize(model.octet_count, Octet::ZERO);
        self.centres.resize(model.outlines.len(), [0.0; 2]);
        self.tip.resize(1, Octet::ZERO);
        self.moved = Mask::EMPTY;
        // Nothing is known of the first step: all may move.
        self.yielded = state.present();
        self.touched = Mask::EMPTY;
        self.known.clear();
        self.spans.clear();
        self.circles.clear();
        self.circles.resize(n.div_ceil(LANES), Circles::NOWHERE);
        for k in 0..self.present.len() {
            let body = usize::from(self.present[k]);
            self.place(s, model, body);
            self.circles[body / LANES].radius[body % LANES] = model.bodies[body].radius;
        }
    }

    /// Brings a body's centre of pressure to its frame.
    #[inline(always)]
    fn place_lever(&mut self, model: &Model, i: usize) {
        let (body, frame, [lead_x, lead_y]) = (&model.bodies[i], &self.frames[i], self.leads[i]);
        let [mx, my] = frame.vector(body.centre_of_mass[0], body.centre_of_mass[1]);
        self.levers[i] =
            [frame.x + mx + lead_x, frame.y + my + lead_y, body.inverse_root / body.torque_radius, body.inverse_root];
    }

    /// Brings a body's outlines to its pose.
    fn place<S: Simd8>(&mut self, s: S, model: &Model, body: usize) {
        let pose = self.poses[body];
        let (sin, cos) = sin_cos(pose.theta);
        let frame = Frame2 { x: pose.x, y: pose.y, cos, sin };
        self.frames[body] = frame;
        let circles = &mut self.circles[body / LANES];
        (circles.x[body % LANES], circles.y[body % LANES]) = (frame.x, frame.y);
        for piece in model.bodies[body].pieces.clone() {
            let octets = &mut self.octets[model.octets[piece].clone()];
            self.centres[piece] = model.outlines[piece].place(s, &frame, octets);
        }
    }

    #[inline]
    fn placed<'a>(&'a self, model: &'a Model, piece: usize) -> Placed<'a> {
        let outline = &model.outlines[piece];
        Placed {
            octets: &self.octets[model.octets[piece].clone()],
            corners: outline.corners,
            centre: self.centres[piece],
            radius: outline.radius,
        }
    }

    fn place_tip<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, at: [f32; 2]) {
        let frame = Frame2 { x: at[0], y: at[1], cos: self.direction[0], sin: self.direction[1] };
        self.tip_centre = shared.model.tip.place(s, &frame, &mut self.tip);
    }

    #[inline]
    fn placed_tip(&self, model: &Model) -> Placed<'_> {
        Placed { octets: &self.tip, corners: model.tip.corners, centre: self.tip_centre, radius: model.tip.radius }
    }

    fn move_tip<S: Simd8>(&mut self, s: S, shared: &Shared<'_>) {
        if self.steps_left == 0 {
            self.clean_up_left = self.clean_up_left.saturating_sub(1);
            return;
        }
        self.steps_left -= 1;
        let [x, y] = self.tip_centre;
        self.place_tip(s, shared, [x + self.direction[0] * self.travel, y + self.direction[1] * self.travel]);
    }

    /// The body that the tip would come down on: the one it overlaps most.
    fn landed_on<S: Simd8>(&self, s: S, shared: &Shared<'_>) -> Option<usize> {
        let mut deepest = -shared.settings.landing_tolerance as f32;
        let mut landed = None;
        self.tip_neighbours(shared.model, 0.0, |body, piece| {
            let gap = contact(s, self.placed_tip(shared.model), piece, 0.0).gap();
            if gap < deepest {
                deepest = gap;
                landed = Some(body);
            }
        });
        landed
    }

    /// Calls `visit` with the present bodies' pieces whose bounding circles are nearer to the tip's than `within`.
    fn tip_neighbours(&self, model: &Model, within: f32, mut visit: impl FnMut(usize, Placed<'_>)) {
        let [x, y] = self.tip_centre;
        for &body in &self.present {
            let body = usize::from(body);
            let frame = &self.frames[body];
            if !nearer([x, y], [frame.x, frame.y], model.tip.radius + model.bodies[body].radius + within) {
                continue;
            }
            for piece in model.bodies[body].pieces.clone() {
                if nearer([x, y], self.centres[piece], model.tip.radius + model.outlines[piece].radius + within) {
                    visit(body, self.placed(model, piece));
                }
            }
        }
    }

    /// How far the tip travels before it comes within the border of a body; `None` if it never does. Conservative
    /// advancement: along the normal of a separating line the tip may come as near as the line is away.
    fn free_travel<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, length: f32) -> Option<f32> {
        let model = shared.model;
        let border = shared.settings.border as f32;
        let start = self.tip_centre;
        let [ux, uy] = self.direction;
        let mut first = length;
        for k in 0..self.present.len() {
            let body = usize::from(self.present[k]);
            for piece in model.bodies[body].pieces.clone() {
                // The bounding circle has to lie on the way.
                let reach = model.tip.radius + model.outlines[piece].radius + border;
                let (dx, dy) = (self.centres[piece][0] - start[0], self.centres[piece][1] - start[1]);
                let (along, across) = (dx * ux + dy * uy, dy * ux - dx * uy);
                if across.abs() > reach || along < -reach || along > first + reach {
                    continue;
                }
                let mut travel = (along - reach).max(0.0);
                for _ in 0..32 {
                    self.place_tip(s, shared, [start[0] + ux * travel, start[1] + uy * travel]);
                    let found = contact(s, self.placed_tip(model), self.placed(model, piece), f32::INFINITY);
                    let gap = found.gap() - border;
                    if gap < NEAR {
                        first = first.min(travel);
                        break;
                    }
                    let closing = found.normal[0] * ux + found.normal[1] * uy;
                    if closing * (first - travel) <= gap {
                        break;
                    }
                    travel += gap / closing;
                }
            }
        }
        (first < length).then_some(first)
    }

    /// Half the gap to the nearest neighbour where that is less than the border.
    fn shrink_borders<S: Simd8>(&mut self, s: S, shared: &Shared<'_>) {
        let full = 2.0 * shared.settings.border as f32;
        self.allowed = DEEPEST as f32;
        for k in 0..self.present.len() {
            for l in k + 1..self.present.len() {
                let (a, b) = (usize::from(self.present[k]), usize::from(self.present[l]));
                let (fa, fb) = (&self.frames[a], &self.frames[b]);
                let circles = shared.model.bodies[a].radius + shared.model.bodies[b].radius + full;
                if !nearer([fa.x, fa.y], [fb.x, fb.y], circles) {
                    continue;
                }
                let mut least = full;
                self.pairs(shared, a, b, full, |_, _, first, second| {
                    least = least.min(contact(s, first, second, full).gap());
                });
                self.allowed = self.allowed.max(-least);
                let half = 0.5 * least.max(0.0);
                self.borders[a] = self.borders[a].min(half);
                self.borders[b] = self.borders[b].min(half);
            }
        }
    }

    /// Calls `visit` with the pieces of two bodies whose own bounding circles are nearer than `within`.
    fn pairs(
        &self,
        shared: &Shared<'_>,
        a: usize,
        b: usize,
        within: f32,
        mut visit: impl FnMut(usize, usize, Placed<'_>, Placed<'_>),
    ) {
        let model = shared.model;
        let (first, second) = (model.bodies[a].pieces.clone(), model.bodies[b].pieces.clone());
        let looks = first.len() * second.len() > PAIRS_PER_LOOK;
        for p in first {
            if looks && shared.stop.requested() {
                return;
            }
            for q in second.clone() {
                let reach = model.outlines[p].radius + model.outlines[q].radius + within;
                if nearer(self.centres[p], self.centres[q], reach) {
                    visit(p, q, self.placed(model, p), self.placed(model, q));
                }
            }
        }
    }

    /// Contacts of the tip, and of the bodies that they join to it as far as those are likely to move, from the tip
    /// outwards.
    fn find_contacts<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, impulses: &mut [Impulse; SLOTS]) {
        let model = shared.model;
        let reach = shared.settings.reach as f32;
        std::mem::swap(&mut self.known, &mut self.before);
        std::mem::swap(&mut self.spans, &mut self.spans_before);
        self.contacts.clear();
        self.known.clear();
        self.spans.clear();
        self.spans.resize(model.bodies.len() + 1, [0; 2]);
        self.reached.clear();
        (self.in_reach, self.spread, self.overlap, self.deepest) = (Mask::EMPTY, Mask::EMPTY, 0.0, 0.0);
        let mut found = Found::of(self, shared);
        found.begin(self, model.bodies.len());
        impulses[self.index * LANE_SLOTS + TIP_SLOT] = [0.0, 0.0, 0.0, 1.0];
        let step = if self.steps_left > 0 { self.travel } else { 0.0 };
        let tip_move = [self.direction[0] * step, self.direction[1] * step];
        let tip_within = reach + step + shared.settings.border as f32;
        let tip = self.placed_tip(model);
        let way = self.length - self.steps_left as f32 * self.travel;
        for body in self.near(s, self.tip_centre, model.tip.radius + tip_within + ROUNDING).iter() {
            if self.over.get(body).is_some_and(|over| way >= *over) {
                continue;
            }
            for piece in model.bodies[body].pieces.clone() {
                let circles = model.tip.radius + model.outlines[piece].radius + tip_within;
                if !nearer(self.tip_centre, self.centres[piece], circles) {
                    continue;
                }
                let manifold = contact(s, tip, self.placed(model, piece), tip_within);
                let pieces = (model.outlines.len() as u64) << 32 | piece as u64;
                let pair = Pair { a: None, b: body, pieces, border: self.borders[body], tip_move, reach };
                found.add(self, &manifold, pair, impulses);
            }
        }
        found.end(model.bodies.len());
        if self.steps_left == 0 {
            // The tip may have left bodies behind that still overlap.
            self.moved.iter().for_each(|body| found.reach(body, impulses));
        }
        found.back_to(self);
        self.spread_out(s, shared, impulses);
    }

    /// Adds the contacts of reached bodies that move or moved in the step before, and of what they reach. A body that
    /// stands presses no other, so its contacts would do nothing. False if there are no more.
    fn spread_out<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, impulses: &mut [Impulse; SLOTS]) -> bool {
        let model = shared.model;
        let reach = shared.settings.reach as f32;
        let mut found = Found::of(self, shared);
        let before = found.contacts.len();
        let mut next = 0;
        while next < found.reached.len() {
            let a = usize::from(found.reached[next]);
            next += 1;
            let moves = self.steps_left == 0 || self.yielded.contains(a) || {
                let [x, y, z, threshold] = impulses[self.index * LANE_SLOTS + a];
                x * x + y * y + z * z > threshold * threshold
            };
            if !moves || self.spread.contains(a) {
                continue;
            }
            self.spread.insert(a);
            let Frame2 { x, y, .. } = self.frames[a];
            let within = reach + 2.0 * shared.settings.border as f32 + ROUNDING;
            let near = self.near(s, [x, y], model.bodies[a].radius + within);
            found.begin(self, a);
            for b in near.without(self.spread).iter() {
                let border = self.borders[a] + self.borders[b];
                let within = reach + border;
                self.pairs(shared, a, b, within, |p, q, first, second| {
                    let manifold = contact(s, first, second, within);
                    let pieces = (p as u64) << 32 | q as u64;
                    let pair = Pair { a: Some(a), b, pieces, border, tip_move: [0.0; 2], reach: f32::INFINITY };
                    found.add(self, &manifold, pair, impulses);
                });
            }
            found.end(a);
        }
        let more = found.contacts.len() > before;
        found.back_to(self);
        more
    }

    /// The bodies whose bounding circles are nearer than `radius` to a point.
    fn near<S: Simd8>(&self, s: S, [x, y]: [f32; 2], radius: f32) -> Mask {
        let circles = &self.circles;
        s.vectorize(
            #[inline(always)]
            || {
                let near = circles.iter().zip((0u32..128).step_by(LANES));
                Mask::from(near.fold(0, |bits, (eight, first)| bits | u128::from(eight.near(s, x, y, radius)) << first))
            },
        )
    }

    /// Keeps the impulses of the solved step, and which bodies the tip pressed.
    fn note_impulses(&mut self) {
        for (known, record) in self.known.iter_mut().zip(&self.contacts) {
            known.normal = record.0[3][0];
            known.tangential = record.0[3][1];
            if record.0[3][0] > 0.0
                && let Some(body) = known.pressed
            {
                self.touched.insert(usize::from(body));
            }
        }
    }

    /// Moves the reached bodies by what their impulses say.
    fn integrate<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, impulses: &[Impulse; SLOTS]) {
        let lead = shared.settings.pressure_lead as f32;
        self.yielded = Mask::EMPTY;
        for k in 0..self.reached.len() {
            let i = usize::from(self.reached[k]);
            let body = &shared.model.bodies[i];
            let [x, y, z, threshold] = impulses[self.index * LANE_SLOTS + i];
            let size = (x * x + y * y + z * z).sqrt();
            if size <= threshold {
                continue;
            }
            let share = (1.0 - threshold / size) * body.inverse_root;
            let (dx, dy) = (x * share, y * share);
            let turn = z * share / body.torque_radius;
            let frame = self.frames[i];
            let [mx, my] = frame.vector(body.centre_of_mass[0], body.centre_of_mass[1]);
            // From the body's origin to the centre of pressure, which moves straight; the body turns about it.
            let (px, py) = (mx + self.leads[i][0], my + self.leads[i][1]);
            let (sin, cos) = sin_cos(turn);
            let pose = &mut self.poses[i];
            pose.x += dx + (px - (cos * px - sin * py));
            pose.y += dy + (py - (sin * px + cos * py));
            pose.theta += turn;
            // Where the body mostly turns there is no "ahead": the lead fades out.
            let ahead = lead / size;
            self.leads[i] = [x * ahead, y * ahead];
            self.moved.insert(i);
            self.yielded.insert(i);
            self.place(s, shared.model, i);
            self.place_lever(shared.model, i);
        }
    }
}

/// Sweeps that a step with so many contacts may take.
fn most_sweeps(shared: &Shared<'_>, contacts: usize) -> u32 {
    let n = contacts as f64;
    // What a contact asks goes through a chain as by diffusion: long ones need sweeps with their square.
    let chain = shared.settings.sweeps_per_contact * n * (n / 75.0).max(1.0);
    shared.settings.sweeps.max(chain as usize) as u32
}

#[inline(always)]
fn nearer(a: [f32; 2], b: [f32; 2], distance: f32) -> bool {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    dx * dx + dy * dy < distance * distance
}
