//! The parametric push sampler.

use super::directions::{Source, Tables, extent_behind};
use super::params::{ContourRule, Order, SamplerParams};
use super::{Placed, PushSampler, SamplerScratch, unknown};
use crate::action::Push;
use crate::error::{Result, check_positive};
use crate::geom::{Obb, Vec2};
use crate::run::Stream;
use crate::scene::{Scene, State};

/// More accepted directions than these of one body are not told apart any more (with 0.2 rad between them, 31 fit).
const MAX_ACCEPTED: usize = 64;

/// Pushes towards the centroids of bodies; see [`SamplerParams`].
#[derive(Debug, Clone)]
pub struct ContourSampler {
    name: &'static str,
    params: SamplerParams,
    /// Commanded length of a push, metres; the parameters', fitted to the gripper, if absent.
    length: Option<f64>,
    tables: Option<Tables>,
}

/// What is the same for every push of a call.
struct Rules<'a> {
    scene: &'a Scene,
    min: Vec2,
    max: Vec2,
    half: [f64; 2],
    box_radius: f64,
    travel: f64,
    params: &'a SamplerParams,
}

impl Rules<'_> {
    fn inside(&self, p: Vec2, inset: f64) -> bool {
        p.x - self.min.x >= inset && self.max.x - p.x >= inset && p.y - self.min.y >= inset && self.max.y - p.y >= inset
    }

    fn borders_hold(&self, start: Vec2, end: Vec2) -> bool {
        self.inside(start, self.params.start_inset) && self.params.end_inset.is_none_or(|inset| self.inside(end, inset))
    }

    /// No body is in the start box. The body that was in the way comes first next time: it often is again.
    fn clear(&self, start: Vec2, direction: Vec2, placed: &[Placed], near: &mut [usize]) -> bool {
        let tool = Obb { centre: start, axis: direction, half: self.half };
        for k in 0..near.len() {
            let p = &placed[near[k]];
            let away = (p.frame.origin - start).norm_squared();
            if away < p.far && (away < p.close || tool.overlaps_near(&self.scene.body(p.body).footprint, &p.frame)) {
                near.swap(0, k);
                return false;
            }
        }
        true
    }

    /// The push from `start`, moved back as far as it takes.
    fn legal(&self, start: Vec2, direction: Vec2, travel: f64, placed: &[Placed], near: &mut [usize]) -> Option<Push> {
        for back in std::iter::once(0.0).chain(self.params.back_off.iter().copied()) {
            let start = start - direction * back;
            let end = start + direction * travel;
            if self.borders_hold(start, end) && self.clear(start, direction, placed, near) {
                return Some(Push::new(start, end));
            }
        }
        None
    }

    /// The push that goes on where `previous` ended.
    fn continuation(&self, previous: &Push, within: f64, placed: &[Placed]) -> Option<Push> {
        let (direction, end) = (previous.direction(), previous.end());
        let mut nearest = within * within;
        let mut found = None;
        for p in placed {
            let body = self.scene.body(p.body);
            // The contact lies within `radius` of the body's origin, so most bodies are out of the question.
            let reach = body.footprint.radius + within;
            if !body.pushable || (p.frame.origin - end).norm_squared() > reach * reach {
                continue;
            }
            let Some(behind) =
                extent_behind(&body.footprint, p.frame.inverse_vector(direction), 0.0, self.params.strip)
            else {
                continue;
            };
            let contact = p.frame.point(body.footprint.centroid) - direction * behind;
            let distance = (contact - end).norm_squared();
            let start = contact - direction * self.params.stand_off;
            let next = start + direction * self.travel;
            if distance <= nearest && self.borders_hold(start, next) {
                nearest = distance;
                found = Some(Push { body: Some(p.body), ..Push::new(start, next) });
            }
        }
        found
    }
}

impl ContourSampler {
    /// A sampler with parameters of your own, for the published gripper; for another they are fitted to it.
    pub fn new(name: &'static str, params: SamplerParams) -> Result<Self> {
        params.validate()?;
        Ok(Self { name, params, length: None, tables: None })
    }

    /// A preset by name: one of [`super::NAMES`].
    pub fn preset(name: &str) -> Result<Self> {
        let (name, params) = match name {
            "vft" => ("vft", SamplerParams::vft()),
            "more" => ("more", SamplerParams::more()),
            "pmbs" => ("pmbs", SamplerParams::pmbs()),
            "pmbs_contour" => ("pmbs_contour", SamplerParams::pmbs_contour()),
            "dense" => ("dense", SamplerParams::dense()),
            "rich" => ("rich", SamplerParams::rich()),
            _ => return Err(unknown(name)),
        };
        Self::new(name, params)
    }

    pub fn params(&self) -> &SamplerParams {
        &self.params
    }

    /// The same sampler with another commanded length, metres, whatever the gripper.
    pub fn with_length(mut self, length: f64) -> Result<Self> {
        check_positive("sampler.length", length)?;
        self.length = Some(length);
        Ok(Self { tables: None, ..self })
    }

    /// The same sampler with another share of the length really travelled.
    pub fn with_travel(mut self, travel: f64) -> Result<Self> {
        self.params.travel = travel;
        self.params.validate()?;
        Ok(Self { tables: None, ..self })
    }

    /// The same sampler made ready for a scene.
    #[must_use]
    pub fn prepared(&self, scene: &Scene) -> Self {
        Self { tables: Some(self.tables_of(scene)), params: self.params.clone(), ..*self }
    }

    fn tables_of(&self, scene: &Scene) -> Tables {
        Tables::new(scene, &self.params, self.length)
    }
}

impl PushSampler for ContourSampler {
    fn name(&self) -> &'static str {
        self.name
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn PushSampler> {
        Box::new(self.prepared(scene))
    }

    fn sample(
        &self,
        scene: &Scene,
        state: &State,
        _target: usize,
        previous: Option<&Push>,
        rng: &mut Stream,
        scratch: &mut SamplerScratch,
        out: &mut Vec<Push>,
    ) {
        let fresh;
        let tables = match &self.tables {
            Some(tables) if tables.fits(scene) => tables,
            _ => {
                fresh = self.tables_of(scene);
                &fresh
            }
        };
        let params = &tables.params;
        let (min, max) = params.region.resolve(scene.workspace());
        let half = params.start_box.half(&scene.gripper().push);
        let rules = Rules {
            scene,
            min,
            max,
            half,
            box_radius: half[0].hypot(half[1]),
            travel: params.length * params.travel,
            params,
        };
        let separation = if let ContourRule::Greedy { separation, .. } = params.contour { separation } else { 0.0 };
        let limit = separation.cos();
        let SamplerScratch { placed, near, others } = scratch;
        out.clear();
        others.clear();
        placed.clear();
        let box_inner = half[0].min(half[1]);
        placed.extend(state.iter().map(|(body, pose)| {
            let far = scene.body(body).footprint.radius + rules.box_radius;
            // A body whose origin is outside of it may be missed however near it is.
            let inner = tables.bodies[body].inner;
            let close = if inner > 0.0 { inner + box_inner } else { 0.0 };
            Placed { body, frame: pose.frame(), far: far * far, close: close * close }
        }));
        if let (Some(previous), Some(within)) = (previous, params.continue_within) {
            out.extend(rules.continuation(previous, within, placed));
        }
        let first = out.len();
        for at in 0..placed.len() {
            let Placed { body, frame, .. } = placed[at];
            if !scene.body(body).pushable {
                continue;
            }
            let table = &tables.bodies[body];
            near.clear();
            near.extend((0..placed.len()).filter(|&k| {
                let reach = table.reach + rules.box_radius + scene.body(placed[k].body).footprint.radius;
                (placed[k].frame.origin - frame.origin).norm_squared() < reach * reach
            }));
            let (mut accepted, mut count) = ([Vec2::zeros(); MAX_ACCEPTED], 0);
            for candidate in &table.candidates {
                // Angles between directions are the same in the body's frame.
                if candidate.source == Source::Greedy
                    && accepted[..count].iter().any(|d| d.dot(&candidate.direction) >= limit)
                {
                    continue;
                }
                let direction = frame.vector(candidate.direction);
                let (start, travel) = (frame.point(candidate.start), rules.travel * candidate.share);
                let Some(push) = rules.legal(start, direction, travel, placed, near) else { continue };
                let push = Push { body: Some(body), ..push };
                if candidate.source == Source::Axis {
                    out.push(push)
                } else {
                    others.push(push)
                }
                if count < MAX_ACCEPTED {
                    accepted[count] = candidate.direction;
                    count += 1;
                }
            }
        }
        if params.order == Order::AxesFirst {
            rng.shuffle(&mut out[first..]);
            rng.shuffle(others);
            out.extend_from_slice(others);
        } else {
            out.extend_from_slice(others);
            rng.shuffle(&mut out[first..]);
        }
    }
}
