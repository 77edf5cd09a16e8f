//! One lane's push: where everything is, and what happens between two steps.

use super::model::Model;
use super::settings::PlanarSettings;
use super::sweep::{Cursor, Impulse, LANE_SLOTS, Record, SLOTS, TIP_SLOT};
use super::trig::sin_cos;
use crate::physics::lanes::{LANES, Simd8};
use crate::physics::narrow::{Frame2, Octet, Placed, Point, contact};
use crate::physics::transition::{PushJob, PushResult, PushStatus};
use crate::scene::{BodyPose, Mask, Scene, State};

/// A gap below this ends the free travel of the tip, metres.
const NEAR: f32 = 5e-5;

/// A contact's identity, for the impulses of the next step.
#[derive(Debug, Clone, Copy)]
struct Known {
    /// The pair of outlines; the tip counts as one after the last.
    pair: u64,
    feature: u32,
    x: f32,
    y: f32,
    /// Impulses, once the step is solved.
    normal: f32,
    tangential: f32,
}

/// Everything of a push that is being executed. Its vectors keep their memory from push to push.
#[derive(Debug, Default)]
pub struct Lane {
    index: usize,
    poses: Vec<BodyPose>,
    /// Origins and rotations of all bodies.
    frames: Vec<Frame2>,
    present: Vec<u16>,
    /// Bounding circles of the present bodies, in their order; filled up with circles that nothing is near.
    circles: Vec<Circles>,
    borders: Vec<f32>,
    /// From the centre of mass to the centre of pressure, world frame.
    leads: Vec<[f32; 2]>,
    octets: Vec<Octet>,
    /// Middles of the outlines' bounding circles.
    centres: Vec<[f32; 2]>,
    moved: Mask,
    touched: Mask,
    /// Bodies that contacts join to the tip, from the tip outwards.
    reached: Vec<u16>,
    pub contacts: Vec<Record>,
    known: Vec<Known>,
    before: Vec<Known>,
    tip: Vec<Octet>,
    tip_centre: [f32; 2],
    direction: [f32; 2],
    /// Of a step, metres.
    travel: f32,
    steps_left: usize,
    /// Deepest overlap of two bodies at the beginning of the step, borders included, metres.
    overlap: f32,
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
        let squared = s.add(s.mul(dx, dx), s.mul(dy, dy));
        let far = s.store(s.sub(squared, s.mul(reach, reach)));
        far.iter().enumerate().fold(0, |bits, (l, &far)| bits | u32::from(far < 0.0) << l)
    }
}

/// What the lanes of a call share.
pub struct Shared<'a> {
    pub scene: &'a Scene,
    pub model: &'a Model,
    pub settings: &'a PlanarSettings,
}

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
        self.prepare(s, shared, impulses, cursor) || self.finish(shared, job.state, result)
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
        self.note_impulses();
        self.integrate(s, shared, impulses);
        self.move_tip(s, shared);
        self.prepare(s, shared, impulses, cursor) || self.finish(shared, job.state, result)
    }

    /// Contacts of the next step that has any. False if there is no such step.
    fn prepare<S: Simd8>(
        &mut self,
        s: S,
        shared: &Shared<'_>,
        impulses: &mut [Impulse; SLOTS],
        cursor: &mut Cursor,
    ) -> bool {
        while self.steps_left + self.clean_up_left > 0 {
            self.find_contacts(s, shared, impulses);
            if self.steps_left == 0 && self.overlap <= shared.settings.clean_up_overlap as f32 {
                return false;
            }
            if !self.contacts.is_empty() {
                let settings = shared.settings;
                let chain = (settings.sweeps_per_contact * self.contacts.len() as f64) as usize;
                *cursor = Cursor {
                    at: 0,
                    len: self.contacts.len() as u32,
                    sweeps: 0,
                    most_sweeps: settings.sweeps.max(chain) as u32,
                    tolerance: settings.tolerance as f32 * self.travel,
                    change: 0.0,
                };
                return true;
            }
            self.known.clear();
            self.move_tip(s, shared);
        }
        false
    }

    /// Writes the result; always false.
    fn finish(&mut self, shared: &Shared<'_>, before: &State, result: &mut PushResult) -> bool {
        result.touched = self.touched;
        let workspace = shared.scene.workspace();
        for body in self.moved.iter() {
            let pose = self.poses[body].into();
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
        self.octets.resize(model.octet_count, Octet::ZERO);
        self.centres.resize(model.outlines.len(), [0.0; 2]);
        self.tip.resize(1, Octet::ZERO);
        self.moved = Mask::EMPTY;
        self.touched = Mask::EMPTY;
        self.known.clear();
        self.circles.clear();
        self.circles.resize(self.present.len().div_ceil(LANES), Circles::NOWHERE);
        for k in 0..self.present.len() {
            self.place(s, model, usize::from(self.present[k]));
            let body = usize::from(self.present[k]);
            self.circles[k / LANES].radius[k % LANES] = model.bodies[body].radius;
            self.place_circle(k);
        }
    }

    /// Brings the bounding circle of a present body to its frame.
    fn place_circle(&mut self, k: usize) {
        let (frame, circles) = (&self.frames[usize::from(self.present[k])], &mut self.circles[k / LANES]);
        (circles.x[k % LANES], circles.y[k % LANES]) = (frame.x, frame.y);
    }

    /// Brings a body's outlines to its pose.
    fn place<S: Simd8>(&mut self, s: S, model: &Model, body: usize) {
        let pose = self.poses[body];
        let (sin, cos) = sin_cos(pose.theta);
        let frame = Frame2 { x: pose.x, y: pose.y, cos, sin };
        self.frames[body] = frame;
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
        for k in 0..self.present.len() {
            for l in k + 1..self.present.len() {
                let (a, b) = (usize::from(self.present[k]), usize::from(self.present[l]));
                let mut least = full;
                self.pairs(shared.model, a, b, full, |_, _, first, second| {
                    least = least.min(contact(s, first, second, full).gap());
                });
                let half = 0.5 * least.max(0.0);
                self.borders[a] = self.borders[a].min(half);
                self.borders[b] = self.borders[b].min(half);
            }
        }
    }

    /// Calls `visit` with the pieces of two bodies whose bounding circles are nearer than `within`.
    fn pairs(
        &self,
        model: &Model,
        a: usize,
        b: usize,
        within: f32,
        mut visit: impl FnMut(usize, usize, Placed<'_>, Placed<'_>),
    ) {
        let (fa, fb) = (&self.frames[a], &self.frames[b]);
        let (ba, bb) = (&model.bodies[a], &model.bodies[b]);
        if !nearer([fa.x, fa.y], [fb.x, fb.y], ba.radius + bb.radius + within) {
            return;
        }
        for p in ba.pieces.clone() {
            for q in bb.pieces.clone() {
                let reach = model.outlines[p].radius + model.outlines[q].radius + within;
                if nearer(self.centres[p], self.centres[q], reach) {
                    visit(p, q, self.placed(model, p), self.placed(model, q));
                }
            }
        }
    }

    /// Bodies joined to the tip by contacts, and the contacts, from the tip outwards.
    fn find_contacts<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, impulses: &mut [Impulse; SLOTS]) {
        let model = shared.model;
        let reach = shared.settings.reach as f32;
        std::mem::swap(&mut self.known, &mut self.before);
        let mut found = Found {
            model,
            lane: self.index,
            correction: shared.settings.correction as f32,
            threshold: self.travel / shared.settings.compliance as f32,
            contacts: std::mem::take(&mut self.contacts),
            known: std::mem::take(&mut self.known),
            reached: std::mem::take(&mut self.reached),
            in_reach: Mask::EMPTY,
            overlap: 0.0,
            hint: 0,
        };
        found.contacts.clear();
        found.known.clear();
        found.reached.clear();
        impulses[self.index * LANE_SLOTS + TIP_SLOT] = [0.0, 0.0, 0.0, 1.0];
        let step = if self.steps_left > 0 { self.travel } else { 0.0 };
        let tip_move = [self.direction[0] * step, self.direction[1] * step];
        let tip_within = reach + step + shared.settings.border as f32;
        let tip = self.placed_tip(model);
        for &body in &self.present {
            let body = usize::from(body);
            let frame = &self.frames[body];
            if !nearer(self.tip_centre, [frame.x, frame.y], model.tip.radius + model.bodies[body].radius + tip_within) {
                continue;
            }
            for piece in model.bodies[body].pieces.clone() {
                let circles = model.tip.radius + model.outlines[piece].radius + tip_within;
                if !nearer(self.tip_centre, self.centres[piece], circles) {
                    continue;
                }
                let manifold = contact(s, tip, self.placed(model, piece), tip_within);
                let pair = (model.outlines.len() as u64) << 32 | piece as u64;
                for point in &manifold.points[..manifold.count] {
                    let point = Point { gap: point.gap - self.borders[body], ..*point };
                    let [nx, ny] = manifold.normal;
                    if point.gap - (nx * tip_move[0] + ny * tip_move[1]).max(0.0) < reach {
                        found.add(self, None, body, manifold.normal, point, tip_move, pair, impulses);
                    }
                }
            }
        }
        if self.steps_left == 0 {
            // The tip may have left bodies behind that still overlap.
            self.moved.iter().for_each(|body| found.reach(body, impulses));
        }
        let mut next = 0;
        let mut expanded = Mask::EMPTY;
        while next < found.reached.len() {
            let a = usize::from(found.reached[next]);
            next += 1;
            expanded.insert(a);
            // A little more than is asked below, so that rounding leaves nothing out.
            let within = reach + 2.0 * shared.settings.border as f32 + 1e-4;
            let (frame, radius) = (self.frames[a], model.bodies[a].radius + within);
            for (group, circles) in self.circles.iter().enumerate() {
                let mut near = s.vectorize(
                    #[inline(always)]
                    || circles.near(s, frame.x, frame.y, radius),
                );
                while near != 0 {
                    let k = group * LANES + near.trailing_zeros() as usize;
                    near &= near - 1;
                    let b = usize::from(self.present[k]);
                    if expanded.contains(b) {
                        continue;
                    }
                    let border = self.borders[a] + self.borders[b];
                    let within = reach + border;
                    self.pairs(model, a, b, within, |p, q, first, second| {
                        let manifold = contact(s, first, second, within);
                        let pair = (p as u64) << 32 | q as u64;
                        for point in &manifold.points[..manifold.count] {
                            let point = Point { gap: point.gap - border, ..*point };
                            found.overlap = found.overlap.max(-point.gap);
                            found.add(self, Some(a), b, manifold.normal, point, [0.0; 2], pair, impulses);
                        }
                    });
                }
            }
        }
        let Found { contacts, known, reached, overlap, .. } = found;
        self.overlap = overlap;
        self.contacts = contacts;
        self.known = known;
        self.reached = reached;
    }

    /// Keeps the impulses of the solved step, and which bodies the tip pressed.
    fn note_impulses(&mut self) {
        for (known, record) in self.known.iter_mut().zip(&self.contacts) {
            known.normal = record.0[3][0];
            known.tangential = record.0[3][1];
            if record.0[3][0] > 0.0 && record.0[3][2] == TIP_MARK {
                self.touched.insert(record.0[3][3] as usize);
            }
        }
    }

    /// Moves the reached bodies by what their impulses say.
    fn integrate<S: Simd8>(&mut self, s: S, shared: &Shared<'_>, impulses: &[Impulse; SLOTS]) {
        let lead = shared.settings.pressure_lead as f32;
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
            self.place(s, shared.model, i);
        }
        (0..self.present.len()).for_each(|k| self.place_circle(k));
    }
}

/// Marks a contact of the tip in its record.
const TIP_MARK: f32 = 1.0;

#[inline(always)]
fn nearer(a: [f32; 2], b: [f32; 2], distance: f32) -> bool {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    dx * dx + dy * dy < distance * distance
}

/// The contacts found so far.
struct Found<'a> {
    model: &'a Model,
    lane: usize,
    correction: f32,
    threshold: f32,
    contacts: Vec<Record>,
    known: Vec<Known>,
    reached: Vec<u16>,
    in_reach: Mask,
    overlap: f32,
    /// Contacts come in about the same order as in the step before: where to look first.
    hint: usize,
}

impl Found<'_> {
    /// Lets a body take part in the step.
    fn reach(&mut self, body: usize, impulses: &mut [Impulse; SLOTS]) {
        if !self.in_reach.contains(body) {
            self.in_reach.insert(body);
            self.reached.push(body as u16);
            impulses[self.lane * LANE_SLOTS + body] =
                [0.0, 0.0, 0.0, self.threshold * self.model.bodies[body].threshold];
        }
    }

    /// How a unit impulse along the normal and the tangent turns a body, in scaled coordinates, and the inverse root
    /// of its mass.
    #[inline(always)]
    fn turning(&self, lane: &Lane, i: usize, [nx, ny]: [f32; 2], point: &Point) -> [f32; 3] {
        let (body, frame) = (&self.model.bodies[i], &lane.frames[i]);
        let [mx, my] = frame.vector(body.centre_of_mass[0], body.centre_of_mass[1]);
        let rx = point.x - (frame.x + mx + lane.leads[i][0]);
        let ry = point.y - (frame.y + my + lane.leads[i][1]);
        let scale = body.inverse_root / body.torque_radius;
        [(rx * ny - ry * nx) * scale, (rx * nx + ry * ny) * scale, body.inverse_root]
    }

    /// Makes a contact between body `a`, or the tip, and body `b`.
    #[allow(clippy::too_many_arguments)]
    fn add(
        &mut self,
        lane: &Lane,
        a: Option<usize>,
        b: usize,
        normal: [f32; 2],
        point: Point,
        tip_move: [f32; 2],
        pair: u64,
        impulses: &mut [Impulse; SLOTS],
    ) {
        let base = self.lane * LANE_SLOTS;
        self.reach(b, impulses);
        let [nx, ny] = normal;
        let (slot_a, [turn_an, turn_at, root_a], friction) = match a {
            Some(a) => (base + a, self.turning(lane, a, normal, &point), self.model.bodies[a].friction),
            None => (base + TIP_SLOT, [0.0; 3], self.model.tip_friction),
        };
        let [turn_bn, turn_bt, root_b] = self.turning(lane, b, normal, &point);
        let gap = if point.gap < 0.0 { point.gap * self.correction } else { point.gap };
        let want_n = gap - (nx * tip_move[0] + ny * tip_move[1]);
        let want_t = ny * tip_move[0] - nx * tip_move[1];
        let (normal_impulse, tangential) = self.warm(lane, pair, &point);
        let mark = if a.is_none() { TIP_MARK } else { 0.0 };
        self.contacts.push(Record([
            [nx, ny, turn_an, turn_at],
            [turn_bn, turn_bt, root_a, root_b],
            [want_n, want_t, friction * self.model.bodies[b].friction, Record::pack(slot_a, base + b)],
            [normal_impulse, tangential, mark, b as f32],
        ]));
        self.known.push(Known { pair, feature: point.feature, x: point.x, y: point.y, normal: 0.0, tangential: 0.0 });
        if normal_impulse > 0.0 {
            let (fx, fy) = (nx * normal_impulse - ny * tangential, ny * normal_impulse + nx * tangential);
            let pa = &mut impulses[slot_a];
            pa[0] -= fx * root_a;
            pa[1] -= fy * root_a;
            pa[2] -= turn_an * normal_impulse + turn_at * tangential;
            let pb = &mut impulses[base + b];
            pb[0] += fx * root_b;
            pb[1] += fy * root_b;
            pb[2] += turn_bn * normal_impulse + turn_bt * tangential;
        }
    }

    /// The impulses that the same contact had in the step before: of the same features, else of the nearest point of
    /// the pair that was not taken.
    fn warm(&mut self, lane: &Lane, pair: u64, point: &Point) -> (f32, f32) {
        let before = &lane.before;
        let n = before.len();
        for k in 0..n {
            let i = if self.hint + k < n { self.hint + k } else { self.hint + k - n };
            let known = &before[i];
            if known.pair == pair && known.feature == point.feature {
                self.hint = if i + 1 < n { i + 1 } else { 0 };
                return (known.normal, known.tangential);
            }
        }
        let mut nearest = 2.5e-5;
        let mut impulse = (0.0, 0.0);
        for known in before.iter().filter(|k| k.pair == pair) {
            let (dx, dy) = (known.x - point.x, known.y - point.y);
            if dx * dx + dy * dy < nearest {
                nearest = dx * dx + dy * dy;
                impulse = (known.normal, known.tangential);
            }
        }
        impulse
    }
}
