//! The world of one push: filled from the state, stepped, read out. Its memory is used again by the next push.

use super::contact::{GroundPoint, Manifold, Pose};
use super::kernel::Motion;
use super::model::{Flat, Model, Real};
use super::near::{Bounds, Pair, SKIN};
use super::settings::PrismSettings;
use super::solver::{GroundSpan, Rows, Rubbing, Span};
use crate::action::Push;
use crate::geom::{Pose2, Vec2};
use crate::physics::transition::DEEPEST;
use crate::scene::{Mask, State, Stroke};

/// What a world waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Phase {
    #[default]
    Done,
    /// The tip moves for so many steps more.
    Pushing(u32),
    /// The tip is gone; bodies come to rest within so many steps.
    Settling(u32),
}

/// How the next step is made.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pace {
    /// Seconds.
    pub(super) dt: Real,
    /// Of a pair's threshold.
    pub(super) body_share: Real,
    pub(super) ground_breaking: Real,
    correction: Real,
    iterations: u32,
}

/// A manifold that takes part in a step, and the rows it has there.
#[derive(Clone, Copy)]
pub(super) struct Active<S> {
    /// Index of the pair or of the piece.
    of: u32,
    /// The points that have rows.
    points: u8,
    span: S,
}

#[derive(Default)]
pub struct World {
    /// Of the simulation's frame, in the world.
    pub(super) origin: Vec2,
    pub(super) present: Vec<u32>,
    pub(super) poses: Vec<Pose>,
    pub(super) awake: Vec<bool>,
    pub(super) velocity: Vec<([Real; 3], [Real; 3])>,
    pub rows: Rows,
    /// All pieces' corners and normals at their places.
    pub(super) corners: Vec<Flat>,
    pub(super) normals: Vec<Flat>,
    pub(super) middles: Vec<Flat>,
    pub(super) bounds: Vec<Bounds>,
    pub(super) ground: Vec<Manifold<GroundPoint>>,
    pub(super) pairs: Vec<Pair>,
    pub(super) pairs_before: Vec<Pair>,
    pub(super) active_pairs: Vec<Active<Span>>,
    pub(super) active_ground: Vec<Active<GroundSpan>>,
    /// Greatest way that a point of a body can have moved since the beginning, and when the list of pairs was made.
    pub(super) way: Real,
    pub(super) way_at_list: Real,
    pub(super) tip_is_down: bool,
    /// Of the tip, where the robot has a path for it.
    stroke: Stroke,
    /// Bodies that were awake at some time.
    pub(super) stirred: Mask,
    /// Bodies that another pressed in this step.
    pub(super) pressed: Mask,
    /// Steps for which a body has been slow without being pressed.
    pub(super) still: Vec<u32>,
    /// Half steps that are left of the step.
    pub(super) halves: u32,
    /// Deepest overlap of two bodies in this step, borders included.
    pub(super) deepest: Real,
    /// Deepest overlap of the tip and a body so far.
    pub(super) tip_deepest: Real,
    /// Steps since a body woke, and how many were awake then.
    pub(super) since_wake: u32,
    pub(super) were_awake: u32,
    pub(super) pace: Pace,
    pub(super) phase: Phase,
    pub(super) touched: Mask,
    pub(super) toppled: Mask,
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
        (self.halves, self.since_wake, self.were_awake) = (0, u32::MAX / 2, 0);
        self.stirred = Mask::EMPTY;
        (self.deepest, self.tip_deepest) = (0.0, 0.0);
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
        self.stroke = model.path.as_ref().map_or(Stroke::default(), |path| path.stroke(push.start(), push.end()));
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
        self.move_tip_up_and_down(model, settings);
        self.find_contacts(model, settings);
        self.set_motions(model, settings);
        self.make_rows(model, settings);
        self.rows.warm_start();
        true
    }

    /// Where the robot has a path for the tip, brings it to its height there, with the velocity up or down that it has.
    fn move_tip_up_and_down(&mut self, model: &Model, settings: &PrismSettings) {
        let Some(path) = model.path.as_ref().filter(|_| self.tip_is_down) else { return };
        let tip = model.tip();
        let pose = &mut self.poses[tip];
        let way = f64::from(pose.at[0] * pose.cos + pose.at[1] * pose.sin);
        pose.at[2] = path.height(&self.stroke, way) as Real + model.bodies[tip].half_height;
        self.velocity[tip].0[2] = (path.slope(&self.stroke, way) * settings.speed) as Real;
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
        self.halves = self.halves.saturating_sub(1);
        self.phase = match self.phase {
            _ if self.halves > 0 && self.toppled.is_empty() => self.phase,
            _ if !self.toppled.is_empty() => Phase::Done,
            Phase::Pushing(left) => Phase::Pushing(left - 1),
            Phase::Settling(left) => Phase::Settling(left - 1),
            Phase::Done => Phase::Done,
        };
    }

    /// A body may be in another.
    pub fn is_deep(&self) -> bool {
        f64::from(self.deepest) > DEEPEST
    }

    /// The tip went into a body on its way.
    pub fn is_unsolved(&self, settings: &PrismSettings) -> bool {
        let step = settings.speed * settings.time_step;
        f64::from(self.tip_deepest) > DEEPEST + 2.0 * settings.border + step
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

    /// All bodies are slow, and none is deep in another, as a light one that was squeezed between heavy ones may be.
    fn at_rest(&self, settings: &PrismSettings) -> bool {
        let limit = settings.settle_speed as Real;
        self.deepest < settings.border as Real
            && self.present.iter().all(|&i| {
                let (v, w) = &self.velocity[i as usize];
                !self.awake[i as usize] || (v[0] * v[0] + v[1] * v[1] < limit * limit && w[2].abs() * 0.03 < limit)
            })
    }

    /// Begins a step, or its second half.
    fn choose_pace(&mut self, settings: &PrismSettings) {
        if self.halves == 0 {
            let awake = self.present.iter().filter(|&&i| self.awake[i as usize]).count() as u32;
            self.since_wake = if awake > self.were_awake { 0 } else { self.since_wake + 1 };
            self.were_awake = awake;
            let first_touch = awake == 0 || (self.since_wake as usize) < settings.halved_steps;
            if first_touch && settings.halved_steps > 0 {
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
        let [x, y, z] = self.velocity[tip].0;
        self.rows.motion[tip] = Motion { v: [x, y, z, 0.0], ..Motion::default() };
    }

    fn make_rows(&mut self, model: &Model, settings: &PrismSettings) {
        let Pace { dt, correction, .. } = self.pace;
        let share = settings.warm_start as Real;
        let ignored = settings.ignored_gap as Real;
        let target = |gap: Real| {
            let g = gap + settings.slop as Real;
            if g > 0.0 { -g / dt } else { (-g * correction / dt).min(settings.correction_speed as Real) }
        };
        self.rows.clear();
        self.active_pairs.clear();
        self.active_ground.clear();
        self.deepest = 0.0;
        let (mut least, mut greatest) = (Real::INFINITY, 0.0 as Real);
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
                self.deepest = self.deepest.max(-p.gap);
                if bodies[0] == model.tip() {
                    self.tip_deepest = self.tip_deepest.max(-p.gap);
                }
                let impulse = p.impulse.map(|x| x * share);
                self.rows.add_bodies(bodies, p.arm, p.normal, target(p.gap), rub, impulse);
            }
            if points != 0 {
                let torque = pair.manifold.torque.map(|x| x * share);
                let span = self.rows.end_bodies(from, torque);
                self.active_pairs.push(Active { of: k as u32, points, span });
                for i in bodies.into_iter().filter(|&i| i != model.tip()) {
                    let inverse = model.bodies[i].inverse_mass;
                    (least, greatest) = (least.min(inverse), greatest.max(inverse));
                }
            } else {
                pair.manifold.torque = [0.0; 3];
            }
        }
        let uneven = greatest > settings.uneven_masses as Real * least;
        self.rows.uneven_residual = settings.uneven_residual as Real;
        self.rows.uneven_sweeps = if uneven { settings.uneven_sweeps as u32 } else { 0 };
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
