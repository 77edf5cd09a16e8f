//! The world of one push: filled from the state, stepped, read out. Its memory is used again by the next push.

use super::collide::{Axes, Outline, Touch, dot, sub, touch};
use super::contact::{BodyPoint, GroundPoint, Manifold, Pose};
use super::kernel::Motion;
use super::model::{Flat, Model, Real, Shape};
use super::settings::PrismSettings;
use super::solver::{GroundSpan, Rows, Rubbing, Span};
use crate::action::Push;
use crate::geom::{Pose2, Vec2};
use crate::scene::{Mask, State};

/// Pairs nearer than this (beyond the reach of contacts) are listed; the list is made anew when bodies have moved by half
/// of it. Metres.
const SKIN: Real = 0.012;
/// The world is this far beyond any reach of contacts, metres: a tall body's lean.
const LEAN: Real = 0.003;

/// What a world waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Phase {
    #[default]
    Done,
    /// The tip moves for so many steps more.
    Pushing(u32),
    /// The tip is gone; bodies come to rest within so many steps.
    Settling(u32),
}

/// How the next step is made.
#[derive(Debug, Clone, Copy, Default)]
struct Pace {
    /// Seconds.
    dt: Real,
    /// Of a pair's threshold.
    body_share: Real,
    ground_breaking: Real,
    correction: Real,
    iterations: u32,
}

/// Two pieces that are near each other.
#[derive(Debug, Clone, Copy)]
struct Pair {
    /// Order in the list.
    key: u64,
    pieces: [u32; 2],
    bodies: [u32; 2],
    threshold: Real,
    /// How much the borders give way, because the bodies began nearer than the borders allow.
    slack: Real,
    friction: Real,
    rolling: Real,
    /// See [`touch`].
    axes: Axes,
    /// The pieces cannot meet before bodies have moved this far; see `World::way`.
    apart_until: Real,
    manifold: Manifold<BodyPoint>,
}

/// A manifold that takes part in a step, and the rows it has there.
#[derive(Clone, Copy)]
struct Active<S> {
    /// Index of the pair or of the piece.
    of: u32,
    /// The points that have rows.
    points: u8,
    span: S,
}

/// Box round a piece.
#[derive(Debug, Clone, Copy, Default)]
struct Bounds {
    low: Flat,
    high: Flat,
}

impl Bounds {
    #[inline]
    fn gap(&self, other: &Bounds) -> Real {
        let x = (self.low[0] - other.high[0]).max(other.low[0] - self.high[0]);
        let y = (self.low[1] - other.high[1]).max(other.low[1] - self.high[1]);
        x.max(y)
    }
}

#[derive(Default)]
pub struct World {
    /// Of the simulation's frame, in the world.
    origin: Vec2,
    present: Vec<u32>,
    poses: Vec<Pose>,
    awake: Vec<bool>,
    velocity: Vec<([Real; 3], [Real; 3])>,
    pub rows: Rows,
    /// All pieces' corners and normals at their places.
    corners: Vec<Flat>,
    normals: Vec<Flat>,
    middles: Vec<Flat>,
    bounds: Vec<Bounds>,
    ground: Vec<Manifold<GroundPoint>>,
    pairs: Vec<Pair>,
    pairs_before: Vec<Pair>,
    active_pairs: Vec<Active<Span>>,
    active_ground: Vec<Active<GroundSpan>>,
    /// Greatest way that a point of a body can have moved since the beginning, and when the list of pairs was made.
    way: Real,
    way_at_list: Real,
    tip_is_down: bool,
    /// Bodies that were awake at some time.
    stirred: Mask,
    /// Bodies that another pressed in this step.
    pressed: Mask,
    /// Steps for which a body has been slow without being pressed.
    still: Vec<u32>,
    /// Half steps that are left of the step.
    halves: u32,
    /// Steps since a body woke.
    since_wake: u32,
    was_awake: u32,
    pace: Pace,
    phase: Phase,
    touched: Mask,
    toppled: Mask,
    /// Steps and sweeps of this push.
    pub steps: u32,
    pub sweeps: u32,
}

impl World {
    /// Fills the world: the tip has travelled `travel` metres from the push's start.
    pub fn fill(&mut self, model: &Model, settings: &PrismSettings, state: &State, push: &Push, travel: f64) {
        let tip = model.tip();
        self.origin = push.start();
        self.present.clear();
        self.poses.clear();
        self.poses.resize(tip + 1, Pose::default());
        self.awake.clear();
        self.awake.resize(tip + 1, false);
        self.velocity.clear();
        self.velocity.resize(tip + 1, Default::default());
        self.rows.motion.clear();
        self.rows.motion.resize(tip + 2, Motion::default());
        self.corners.resize(model.corners.len(), [0.0; 2]);
        self.normals.resize(model.corners.len(), [0.0; 2]);
        self.middles.resize(model.pieces.len(), [0.0; 2]);
        self.bounds.resize(model.pieces.len(), Bounds::default());
        self.ground.resize(model.pieces.len(), Manifold::default());
        self.ground.iter_mut().for_each(Manifold::clear);
        self.pairs.clear();
        self.way = 0.0;
        (self.halves, self.since_wake, self.was_awake) = (0, u32::MAX / 2, 0);
        self.stirred = Mask::EMPTY;
        self.still.clear();
        self.still.resize(tip + 1, 0);
        self.touched = Mask::EMPTY;
        self.toppled = Mask::EMPTY;
        (self.steps, self.sweeps) = (0, 0);

        for (i, pose) in state.iter() {
            let body = &model.bodies[i];
            let centre = pose.transform_point(Vec2::new(f64::from(body.centre[0]), f64::from(body.centre[1])));
            let at = centre - self.origin;
            self.place(model, i, at, pose.theta, body.half_height + settings.border as Real);
            self.present.push(i as u32);
        }
        let direction = push.direction();
        let middle = (settings.tip_low + settings.tip_high) / 2.0;
        self.place(model, tip, direction * travel, push.angle(), middle as Real);
        self.tip_is_down = true;
        self.awake[tip] = true;

        // Equal steps that end exactly at the push's end.
        let left = push.length() - travel;
        let steps = (left / (settings.speed * settings.time_step)).ceil().max(1.0);
        let velocity = direction * (left / (steps * settings.time_step));
        self.velocity[tip].0 = [velocity.x as Real, velocity.y as Real, 0.0];

        self.list_pairs(model, settings);
        self.give_way(model, settings);
        self.phase = Phase::Pushing(steps as u32);
    }

    fn place(&mut self, model: &Model, body: usize, at: Vec2, theta: f64, z: Real) {
        let (sin, cos) = theta.sin_cos();
        self.poses[body] = Pose {
            at: [at.x as Real, at.y as Real, z],
            theta: theta as Real,
            cos: cos as Real,
            sin: sin as Real,
            tilt: [0.0; 2],
        };
        self.outline(model, body);
    }

    /// Puts the body's corners and normals where the body is.
    fn outline(&mut self, model: &Model, body: usize) {
        let pose = self.poses[body];
        let (first, end) = model.bodies[body].pieces;
        for p in first as usize..end as usize {
            let shape = &model.pieces[p];
            let mut bounds = Bounds { low: [Real::INFINITY; 2], high: [Real::NEG_INFINITY; 2] };
            let r = pose.turn(shape.middle);
            let c = [pose.at[0] + r[0], pose.at[1] + r[1]];
            self.middles[p] = c;
            if shape.is_disc {
                self.bounds[p] = Bounds { low: c, high: c };
                continue;
            }
            for k in shape.corners.0 as usize..shape.corners.1 as usize {
                let r = pose.turn(model.corners[k]);
                let c = [pose.at[0] + r[0], pose.at[1] + r[1]];
                self.corners[k] = c;
                self.normals[k] = pose.turn(model.normals[k]);
                bounds.low = [bounds.low[0].min(c[0]), bounds.low[1].min(c[1])];
                bounds.high = [bounds.high[0].max(c[0]), bounds.high[1].max(c[1])];
            }
            self.bounds[p] = bounds;
        }
    }

    #[inline]
    fn outline_of(&self, shape: &Shape, piece: usize) -> Outline<'_> {
        let middle = self.middles[piece];
        if shape.is_disc {
            return Outline::Disc(middle);
        }
        let range = shape.corners.0 as usize..shape.corners.1 as usize;
        Outline::Polygon { corners: &self.corners[range.clone()], normals: &self.normals[range], middle }
    }

    /// Makes the list of near pairs anew, the tip's first; known ones keep their contacts.
    fn list_pairs(&mut self, model: &Model, settings: &PrismSettings) {
        std::mem::swap(&mut self.pairs, &mut self.pairs_before);
        self.pairs.clear();
        self.way_at_list = self.way;
        let tip = model.tip();
        let mut known = 0;
        let count = self.present.len();
        for first in 0..=count {
            // The tip comes first, then the bodies.
            let a = if first == 0 { tip } else { self.present[first - 1] as usize };
            if a == tip && !self.tip_is_down {
                continue;
            }
            for second in first..count {
                let b = self.present[second] as usize;
                let reach = model.bodies[a].radius + model.bodies[b].radius + SKIN + LEAN;
                let d = sub([self.poses[b].at[0], self.poses[b].at[1]], [self.poses[a].at[0], self.poses[a].at[1]]);
                if dot(d, d) > reach * reach {
                    continue;
                }
                self.list_pieces(model, settings, [a, b], first as u64, &mut known);
            }
        }
    }

    fn list_pieces(
        &mut self,
        model: &Model,
        settings: &PrismSettings,
        [a, b]: [usize; 2],
        rank: u64,
        known: &mut usize,
    ) {
        let (body_a, body_b) = (&model.bodies[a], &model.bodies[b]);
        for p in body_a.pieces.0..body_a.pieces.1 {
            for q in body_b.pieces.0..body_b.pieces.1 {
                let (shape_a, shape_b) = (&model.pieces[p as usize], &model.pieces[q as usize]);
                let threshold = settings.body_breaking as Real * shape_a.motion_disc.min(shape_b.motion_disc);
                let reach = shape_a.round + shape_b.round + threshold + SKIN + LEAN;
                if self.bounds[p as usize].gap(&self.bounds[q as usize]) > reach {
                    continue;
                }
                let key = if rank == 0 { u64::from(q) } else { (u64::from(p) + 1) << 32 | u64::from(q) };
                while self.pairs_before.get(*known).is_some_and(|pair| pair.key < key) {
                    *known += 1;
                }
                if let Some(pair) = self.pairs_before.get(*known).filter(|pair| pair.key == key) {
                    self.pairs.push(*pair);
                    continue;
                }
                self.pairs.push(Pair {
                    key,
                    pieces: [p, q],
                    bodies: [a as u32, b as u32],
                    threshold,
                    slack: 0.0,
                    friction: body_a.friction * body_b.friction,
                    rolling: body_a.friction * body_b.rolling + body_b.friction * body_a.rolling,
                    axes: [0; 2],
                    apart_until: 0.0,
                    manifold: Manifold::default(),
                });
            }
        }
    }

    /// Lets the borders of pairs give way that begin nearer than these allow.
    fn give_way(&mut self, model: &Model, settings: &PrismSettings) {
        for k in 0..self.pairs.len() {
            let mut pair = self.pairs[k];
            let [a, b] = pair.pieces.map(|p| &model.pieces[p as usize]);
            if let Ok(found) = self.nearest(model, &mut pair, a.round + b.round) {
                let overlap = a.round + b.round - found.gap;
                let borders = a.border + b.border;
                self.pairs[k].slack = (overlap - settings.border_overlap as Real).clamp(0.0, borders);
            }
        }
    }

    /// See [`touch`].
    #[inline]
    fn nearest(&self, model: &Model, pair: &mut Pair, reach: Real) -> Result<Touch, Real> {
        let [p, q] = pair.pieces.map(|p| p as usize);
        let gap = self.bounds[p].gap(&self.bounds[q]);
        if gap > reach {
            return Err(gap);
        }
        let (a, b) = (&model.pieces[p], &model.pieces[q]);
        touch(self.outline_of(a, p), self.outline_of(b, q), reach, &mut pair.axes)
    }

    /// Prepares the next step up to where its impulses are to be solved for. False if the push is over.
    pub fn begin_step(&mut self, model: &Model, settings: &PrismSettings) -> bool {
        if self.phase == Phase::Pushing(0) {
            self.tip_is_down = false;
            self.list_pairs(model, settings);
            self.phase = Phase::Settling((settings.settle_time / settings.time_step).ceil() as u32);
        }
        if let Phase::Settling(left) = self.phase
            && (left == 0 || self.at_rest(settings))
        {
            self.phase = Phase::Done;
        }
        if self.phase == Phase::Done {
            return false;
        }
        if 2.0 * (self.way - self.way_at_list) > SKIN {
            self.list_pairs(model, settings);
        }
        self.choose_pace(settings);
        self.find_contacts(model, settings);
        self.set_motions(model, settings);
        self.make_rows(model, settings);
        self.rows.warm_start();
        true
    }

    /// Moves the bodies by the velocities that were solved for.
    pub fn end_step(&mut self, model: &Model, settings: &PrismSettings) {
        self.steps += 1;
        self.sweeps += self.rows.sweeps;
        self.take_impulses(model, settings);
        self.integrate(model, self.pace.dt);
        self.lull(settings);
        let limit = settings.topple_tilt as Real;
        for &i in &self.present {
            let tilt = self.poses[i as usize].tilt;
            if tilt[0].abs() > limit || tilt[1].abs() > limit {
                self.toppled.insert(i as usize);
            }
        }
        if self.halves > 0 {
            self.halves -= 1;
        }
        self.phase = match self.phase {
            _ if self.halves > 0 && self.toppled.is_empty() => self.phase,
            _ if !self.toppled.is_empty() => Phase::Done,
            Phase::Pushing(left) => Phase::Pushing(left - 1),
            Phase::Settling(left) => Phase::Settling(left - 1),
            Phase::Done => Phase::Done,
        };
    }

    pub fn touched(&self) -> Mask {
        self.touched
    }

    /// Bodies that lean too far to be simulated.
    pub fn toppled(&self) -> Mask {
        self.toppled
    }

    /// Writes the bodies' poses into the state they came from. A body that never moved keeps its bits.
    pub fn read(&self, model: &Model, state: &mut State) {
        for i in self.stirred.iter() {
            let pose = &self.poses[i];
            let theta = f64::from(pose.theta);
            let centre = self.origin + Vec2::new(f64::from(pose.at[0]), f64::from(pose.at[1]));
            let local = Vec2::new(f64::from(model.bodies[i].centre[0]), f64::from(model.bodies[i].centre[1]));
            let after = Pose2::at(centre - Pose2::new(0.0, 0.0, theta).transform_point(local), theta);
            let before = state.pose(i);
            let moved = (after.position() - before.position()).norm() > 1e-6
                || crate::geom::normalize_angle(after.theta - before.theta).abs() > 1e-5;
            if moved {
                state.set_pose(i, after);
            }
        }
    }

    fn at_rest(&self, settings: &PrismSettings) -> bool {
        let limit = settings.settle_speed as Real;
        self.present.iter().all(|&i| {
            let (v, w) = &self.velocity[i as usize];
            !self.awake[i as usize] || (v[0] * v[0] + v[1] * v[1] < limit * limit && w[2].abs() * 0.03 < limit)
        })
    }

    fn choose_pace(&mut self, settings: &PrismSettings) {
        if self.halves == 0 {
            let awake = self.present.iter().filter(|&&i| self.awake[i as usize]).count() as u32;
            self.since_wake = if awake > self.was_awake { 0 } else { self.since_wake + 1 };
            self.was_awake = awake;
            if (awake as usize) <= settings.halved_awake || (self.since_wake as usize) < settings.halved_after_wake {
                self.halves = 2;
            }
        }
        self.pace = if self.halves > 0 {
            Pace {
                dt: (0.5 * settings.time_step) as Real,
                body_share: (settings.half_body_breaking / settings.body_breaking) as Real,
                ground_breaking: settings.half_ground_breaking as Real,
                correction: settings.half_correction as Real,
                iterations: settings.half_iterations as u32,
            }
        } else {
            Pace {
                dt: settings.time_step as Real,
                body_share: 1.0,
                ground_breaking: settings.ground_breaking as Real,
                correction: settings.correction as Real,
                iterations: settings.iterations as u32,
            }
        };
        self.rows.most_sweeps = self.pace.iterations;
    }

    /// Lets bodies sleep again that have come to rest.
    fn lull(&mut self, settings: &PrismSettings) {
        let limit = settings.settle_speed as Real;
        for &i in &self.present {
            let i = i as usize;
            if !self.awake[i] {
                continue;
            }
            self.stirred.insert(i);
            let (v, w) = &mut self.velocity[i];
            let slow = v[0] * v[0] + v[1] * v[1] < limit * limit && w[2].abs() * 0.03 < limit;
            if !slow || self.pressed.contains(i) {
                self.still[i] = 0;
                continue;
            }
            self.still[i] += 1;
            if self.still[i] as usize == settings.rest_steps {
                (*v, *w) = ([0.0; 3], [0.0; 3]);
                self.awake[i] = false;
                self.still[i] = 0;
            }
        }
    }

    fn find_contacts(&mut self, model: &Model, settings: &PrismSettings) {
        let mut pairs = std::mem::take(&mut self.pairs);
        for pair in &mut pairs {
            let [a, b] = pair.bodies.map(|i| i as usize);
            if !(self.awake[a] || self.awake[b]) || self.way < pair.apart_until {
                continue;
            }
            let shapes = pair.pieces.map(|p| &model.pieces[p as usize]);
            let (pose_a, pose_b) = (self.poses[a], self.poses[b]);
            let heights = common_heights(model, [a, b], [&pose_a, &pose_b]);
            let round = shapes[0].round + shapes[1].round;
            let lean = lean(&pose_a, heights) + lean(&pose_b, heights);
            let threshold = pair.threshold * self.pace.body_share;
            let reach = threshold + round - pair.slack + lean;
            let found = self.nearest(model, pair, reach);
            if let Ok(found) = found {
                let (gap, height) = heights
                    .into_iter()
                    .map(|h| {
                        (found.gap - round + pair.slack + dot(found.normal, sub(pose_b.shift(h), pose_a.shift(h))), h)
                    })
                    .fold((Real::INFINITY, 0.0), |best, next| if next.0 < best.0 { next } else { best });
                if gap < threshold {
                    let point = new_point(&found, height, [&pose_a, &pose_b], shapes.map(|s| s.round));
                    pair.manifold.add(point, threshold);
                }
                if a == model.tip() && !self.awake[b] && gap < settings.wake_gap as Real {
                    self.awake[b] = true;
                }
            }
            pair.manifold.refresh(&pose_a, &pose_b, pair.slack, threshold);
            if let Err(gap) = found
                && pair.manifold.points().is_empty()
            {
                // Both may move, and lean.
                pair.apart_until = self.way + 0.5 * (gap - (reach - threshold + pair.threshold) - (LEAN - lean).max(0.0));
            }
        }
        self.pairs = pairs;
        let border = settings.border as Real;
        for &i in &self.present {
            let i = i as usize;
            if !self.awake[i] {
                continue;
            }
            let (body, pose) = (&model.bodies[i], self.poses[i]);
            for p in body.pieces.0 as usize..body.pieces.1 as usize {
                let shape = &model.pieces[p];
                let threshold = self.pace.ground_breaking * shape.motion_disc;
                // Lowest where the base leans most downwards.
                let down = pose.turn_back(pose.tilt);
                let corners = &model.corners[shape.corners.0 as usize..shape.corners.1 as usize];
                let mut best = (Real::NEG_INFINITY, [0.0; 2]);
                for &c in corners {
                    let d = dot(c, down);
                    if d > best.0 {
                        best = (d, c);
                    }
                }
                let arm = pose.arm([best.1[0], best.1[1], -body.half_height]);
                let gap = pose.at[2] + arm[2] - border;
                let manifold = &mut self.ground[p];
                if gap < threshold {
                    let anchor = [pose.at[0] + arm[0], pose.at[1] + arm[1]];
                    manifold.add(GroundPoint { local: best.1, anchor, ..GroundPoint::default() }, threshold);
                }
                manifold.refresh(&pose, body.half_height, border, threshold);
            }
        }
    }

    fn set_motions(&mut self, model: &Model, settings: &PrismSettings) {
        let dt = self.pace.dt;
        let keep = 1.0 - settings.damping as Real * dt;
        for &i in &self.present {
            let i = i as usize;
            let motion = &mut self.rows.motion[i];
            if !self.awake[i] {
                *motion = Motion::default();
                continue;
            }
            let (body, pose) = (&model.bodies[i], &self.poses[i]);
            let (v, w) = self.velocity[i];
            let [ix, iy, iz] = body.inverse_inertia;
            let (c, s) = (pose.cos, pose.sin);
            *motion = Motion {
                v: [v[0] * keep, v[1] * keep, v[2] * keep - settings.gravity as Real * dt, body.inverse_mass],
                w: [w[0] * keep, w[1] * keep, w[2] * keep, 1.0 / iz],
                i: [c * c * ix + s * s * iy, c * s * (ix - iy), s * s * ix + c * c * iy, iz],
            };
        }
        let tip = model.tip();
        let [x, y, _] = self.velocity[tip].0;
        self.rows.motion[tip] = Motion { v: [x, y, 0.0, 0.0], ..Motion::default() };
    }

    fn make_rows(&mut self, model: &Model, settings: &PrismSettings) {
        let Pace { dt, correction, .. } = self.pace;
        let share = settings.warm_start as Real;
        let ignored = settings.ignored_gap as Real;
        let target = |gap: Real| {
            let g = gap + settings.slop as Real;
            if g > 0.0 {
                -g / dt
            } else {
                (-g * correction / dt).min(settings.correction_speed as Real)
            }
        };
        self.rows.clear();
        self.active_pairs.clear();
        self.active_ground.clear();
        for (k, pair) in self.pairs.iter_mut().enumerate() {
            let bodies = pair.bodies.map(|i| i as usize);
            if pair.manifold.points().is_empty() || !(self.awake[bodies[0]] || self.awake[bodies[1]]) {
                continue;
            }
            if bodies[0] == model.tip() && !self.awake[bodies[1]] {
                continue;
            }
            let rub = Rubbing { friction: pair.friction, rolling: pair.rolling };
            let from = self.rows.bodies.len() as u32;
            let mut points = 0;
            for (i, p) in pair.manifold.points_mut().iter_mut().enumerate() {
                if p.gap + self.rows.parting(bodies, &p.arm, p.normal) * dt > ignored {
                    p.impulse = [0.0; 3];
                    continue;
                }
                points |= 1 << i;
                let impulse = p.impulse.map(|x| x * share);
                self.rows.add_bodies(bodies, p.arm, p.normal, target(p.gap), rub, impulse);
            }
            if points != 0 {
                let torque = pair.manifold.torque.map(|x| x * share);
                let span = self.rows.end_bodies(from, torque);
                self.active_pairs.push(Active { of: k as u32, points, span });
            } else {
                pair.manifold.torque = [0.0; 3];
            }
        }
        for &i in &self.present {
            let i = i as usize;
            if !self.awake[i] {
                continue;
            }
            let body = &model.bodies[i];
            let rub = Rubbing {
                friction: model.ground_friction * body.friction,
                rolling: model.ground_friction * body.rolling,
            };
            self.rows.begin_ground(i);
            for p in body.pieces.0 as usize..body.pieces.1 as usize {
                let manifold = &mut self.ground[p];
                let (mut points, mut count) = (0, 0);
                for (k, point) in manifold.points_mut().iter_mut().enumerate() {
                    if point.gap + self.rows.lifting(i, &point.arm) * dt > ignored {
                        point.impulse = [0.0; 3];
                        continue;
                    }
                    points |= 1 << k;
                    count += 1;
                    let impulse = point.impulse.map(|x| x * share);
                    self.rows.add_ground(i, point.arm, target(point.gap), rub, impulse);
                }
                if points != 0 {
                    let torque = manifold.torque.map(|x| x * share);
                    let span = self.rows.end_ground(count, torque);
                    self.active_ground.push(Active { of: p as u32, points, span });
                } else {
                    manifold.torque = [0.0; 3];
                }
            }
        }
    }

    /// Stores the impulses for the next step, notes what the tip touched, wakes what was pressed.
    fn take_impulses(&mut self, model: &Model, settings: &PrismSettings) {
        self.pressed = Mask::EMPTY;
        for active in &self.active_pairs {
            let pair = &mut self.pairs[active.of as usize];
            let mut row = active.span.0;
            let mut greatest: Real = 0.0;
            for (i, p) in pair.manifold.points_mut().iter_mut().enumerate() {
                if active.points >> i & 1 == 1 {
                    p.impulse = self.rows.body_impulse(row);
                    greatest = greatest.max(p.impulse[0]);
                    row += 1;
                }
            }
            pair.manifold.torque = self.rows.body_torque(active.span);
            let [a, b] = pair.bodies.map(|i| i as usize);
            if a == model.tip() {
                if greatest > 0.0 {
                    self.touched.insert(b);
                    self.pressed.insert(b);
                }
            } else if greatest > 0.0 {
                self.pressed.insert(a);
                self.pressed.insert(b);
            }
            if a != model.tip() && greatest > settings.wake_impulse as Real {
                self.awake[a] = true;
                self.awake[b] = true;
            }
        }
        for active in &self.active_ground {
            let manifold = &mut self.ground[active.of as usize];
            let mut row = 0;
            for (i, p) in manifold.points_mut().iter_mut().enumerate() {
                if active.points >> i & 1 == 1 {
                    p.impulse = self.rows.ground_impulse(active.span, row);
                    row += 1;
                }
            }
            manifold.torque = self.rows.ground_torque(active.span);
        }
    }

    fn integrate(&mut self, model: &Model, dt: Real) {
        let tip = model.tip();
        let mut fastest: Real = 0.0;
        for k in 0..=self.present.len() {
            let i = if k == self.present.len() { tip } else { self.present[k] as usize };
            if !self.awake[i] || (i == tip && !self.tip_is_down) {
                continue;
            }
            let Motion { v: [vx, vy, vz, _], w: [wx, wy, wz, _], .. } = self.rows.motion[i];
            let (v, w) = ([vx, vy, vz], [wx, wy, wz]);
            let pose = &mut self.poses[i];
            for (x, u) in pose.at.iter_mut().zip(v) {
                *x += u * dt;
            }
            let [a, b] = pose.tilt;
            pose.tilt = [a + (w[1] - w[2] * b) * dt, b + (w[2] * a - w[0]) * dt];
            if w[2] != 0.0 {
                pose.theta += w[2] * dt;
                (pose.sin, pose.cos) = pose.theta.sin_cos();
            }
            self.velocity[i] = (v, w);
            let speed = (v[0] * v[0] + v[1] * v[1]).sqrt() + w[2].abs() * model.bodies[i].radius;
            fastest = fastest.max(speed);
            self.outline(model, i);
        }
        self.way += fastest * dt;
    }
}

/// How far a body's outline can be shifted by its lean between these heights.
#[inline]
fn lean(pose: &Pose, heights: [Real; 2]) -> Real {
    let height = (heights[0] - pose.at[2]).abs().max((heights[1] - pose.at[2]).abs());
    (pose.tilt[0].abs() + pose.tilt[1].abs()) * height
}

/// The lower and the upper end of the heights at which both bodies are. Where there are none, as for a tip over a flat
/// body, both are the lower body's top: the world is planar, and a tip never passes over a body.
#[inline]
fn common_heights(model: &Model, bodies: [usize; 2], poses: [&Pose; 2]) -> [Real; 2] {
    let half = bodies.map(|i| model.bodies[i].half_height);
    let low = (poses[0].at[2] - half[0]).max(poses[1].at[2] - half[1]);
    let high = (poses[0].at[2] + half[0]).min(poses[1].at[2] + half[1]);
    [low.min(high), high]
}

#[inline]
fn new_point(found: &Touch, height: Real, poses: [&Pose; 2], round: [Real; 2]) -> BodyPoint {
    let n = found.normal;
    let sides = [round[0], -round[1]];
    let local = [0, 1].map(|k| {
        let pose = poses[k];
        let on = [found.points[k][0] + n[0] * sides[k], found.points[k][1] + n[1] * sides[k]];
        let r = [on[0] - pose.at[0], on[1] - pose.at[1]];
        let l = pose.turn_back(r);
        [l[0], l[1], height - pose.at[2] + pose.tilt[0] * r[0] + pose.tilt[1] * r[1]]
    });
    BodyPoint { local, normal: n, ..BodyPoint::default() }
}
