//! What there is to know of one grasp, and of the best ones of a body.

use super::jaw::Pieces;
use super::test::{Best, GraspCheck, GraspScratch, GraspTest, Limit, Met, Trial, look};
use crate::action::Grasp;
use crate::bounds;
use crate::error::{Error, Result};
use crate::geom::{normalize_angle, vec2};
use crate::scene::{GraspFeatures, Grasper, Scene, State};

/// Grasps of a list are at least so far apart (metres, for the published gripper: [`crate::scene::Gripper::scale`]) or their
/// closing directions at least so much (radians): two steps of the test's directions and of its positions.
pub const APART: (f64, f64) = (0.010, 0.35);

/// What rounding takes from a grasp that the test finds exactly on the edge, metres.
const HAIR: f64 = 1e-9;

/// How much room each condition of the grasp rule has; it is met while that is not negative. Metres, but for `wedge`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraspSpares {
    /// Of the open fingers to the target itself.
    pub fit: f64,
    /// Of the length of the target that the pads cover.
    pub cover: f64,
    /// Of the fingers to the other bodies; infinite without any.
    pub finger: f64,
    /// Of the space between the fingers to the other bodies; infinite without any.
    pub between: f64,
    /// Of the gripper's opening over the one asked for.
    pub opening: f64,
    /// Of the angle between the gripped faces, radians.
    pub wedge: f64,
    /// The body that `finger` is to.
    pub finger_body: Option<usize>,
    /// The body that `between` is to.
    pub between_body: Option<usize>,
}

/// One grasp examined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraspExamination {
    /// As it was given, with its width, margin and score.
    pub grasp: Grasp,
    /// All conditions are met.
    pub allowed: bool,
    /// The condition that is not met; of an allowed grasp, the one with the least spare room.
    pub limit: Limit,
    /// Angle between the gripped faces, radians.
    pub wedge: f64,
    /// The chance that the gripper keeps the target; none for a gripper without a model of that.
    pub chance: Option<f64>,
    /// None where no part of the target is between the pads, as for the features.
    pub spares: Option<GraspSpares>,
    pub features: Option<GraspFeatures>,
    /// How far the closed pads reach down the target, metres; none for a gripper without a model of keeping.
    pub depth: Option<f64>,
}

impl GraspTest {
    /// All that is known of one grasp. Its `width`, `margin` and `score` are not read; an `opening` of 0 is the gripper's.
    ///
    /// # Errors
    /// A body that is not in the scene or not present, and numbers that no gripper can be told.
    pub fn examine(
        &self,
        scene: &Scene,
        state: &State,
        grasp: &Grasp,
        scratch: &mut GraspScratch,
    ) -> Result<GraspExamination> {
        let grasper = &scene.gripper().grasp;
        let opening = if grasp.opening == 0.0 { grasper.opening } else { grasp.opening };
        let grasp = Grasp { opening, width: 0.0, margin: 0.0, score: 0.0, ..*grasp };
        there(scene, state, grasp.body)?;
        bounds::POSITION.check("grasp.position[0]", grasp.position[0])?;
        bounds::POSITION.check("grasp.position[1]", grasp.position[1])?;
        bounds::HEADING.check("grasp.angle", grasp.angle)?;
        bounds::FINGER.check("grasp.opening", opening)?;
        let score = self.params().score.fitted(scene.gripper());
        // A body far along the closing direction is met by pads that open without end, and not by these.
        let met = look(scene, state, &grasp, score, scratch).filter(|met| met.is_between(opening));
        let Some(met) = met else {
            return Ok(examined(scene, grasp, &GraspCheck::missing(scene, grasp.body), None, None));
        };
        let check = met.judged(scene, &grasp, &score, HAIR);
        let spares = spares(grasper, &grasp, &check, &met, &scratch.pieces);
        Ok(examined(scene, grasp, &check, Some(spares), Some(met.features)))
    }

    /// The best grasps of a body, examined, best first: at most `most`, of which no two are alike ([`APART`]). The first is
    /// that of [`best`](Self::best); each of the others is the best of those unlike the ones before it. Scores closer than
    /// 1e-9 are equal. Empty where the body has no grasp.
    ///
    /// # Errors
    /// A body that is not in the scene or not present.
    pub fn best_apart(
        &self,
        scene: &Scene,
        state: &State,
        body: usize,
        most: usize,
        scratch: &mut GraspScratch,
    ) -> Result<Vec<GraspExamination>> {
        there(scene, state, body)?;
        let grasps = self.with_tables(scene, |tables| {
            let first = self.search(tables, scene, state, body, scratch, None)?;
            let mut trial = Trial::new(self, tables, scene, state, body, scratch)?;
            let found: Vec<Best> = trial.table.candidates.iter().filter_map(|c| trial.grasp(c, None)).collect();
            let found = found.iter().map(|best| (*best, trial.placed(best))).collect();
            Some(thinned(first, found, most, scene.gripper().scale()))
        });
        grasps.unwrap_or_default().iter().map(|grasp| self.examine(scene, state, grasp, scratch)).collect()
    }
}

/// `first`, and of the others again and again the best one that is unlike all before it.
fn thinned(first: Grasp, mut found: Vec<(Best, Grasp)>, most: usize, scale: f64) -> Vec<Grasp> {
    let mut chosen = Vec::new();
    let mut next = Some(first);
    while let Some(grasp) = next.filter(|_| chosen.len() < most) {
        found.retain(|(_, other)| apart(&grasp, other, scale));
        chosen.push(grasp);
        let better = |a: (Best, Grasp), b: &(Best, Grasp)| if b.0.beats(&a.0) { *b } else { a };
        next = found.split_first().map(|(first, rest)| rest.iter().fold(*first, better).1);
    }
    chosen
}

/// Two grasps of a body are unlike ([`APART`]). A closing direction and its reverse are the same.
fn apart(a: &Grasp, b: &Grasp, scale: f64) -> bool {
    let off = vec2(a.position[0] - b.position[0], a.position[1] - b.position[1]).norm();
    off >= scale * APART.0 || (0.5 * normalize_angle(2.0 * (a.angle - b.angle))).abs() >= APART.1
}

/// The body can be asked for.
fn there(scene: &Scene, state: &State, body: usize) -> Result<()> {
    match scene.bodies().get(body) {
        None => {
            let reason = format!("is {body}, but the scene has {} bodies; count from 0", scene.len());
            Err(Error::argument("grasp.body", reason))
        }
        Some(named) if !state.is_present(body) => {
            Err(Error::argument("grasp.body", format!("`{}` is not present; ask for a body that is", named.name)))
        }
        Some(_) => Ok(()),
    }
}

fn examined(
    scene: &Scene,
    grasp: Grasp,
    check: &GraspCheck,
    spares: Option<GraspSpares>,
    features: Option<GraspFeatures>,
) -> GraspExamination {
    let keeping = scene.gripper().keeping.as_ref();
    GraspExamination {
        grasp: Grasp { width: check.width, margin: check.margin, score: check.score, ..grasp },
        allowed: check.holds(),
        limit: check.limit,
        wedge: check.wedge,
        chance: check.chance,
        spares,
        features,
        depth: keeping.zip(features).map(|(keeping, f)| keeping.depth(f.width, f.height)),
    }
}

fn spares(grasper: &Grasper, grasp: &Grasp, check: &GraspCheck, met: &Met, others: &Pieces) -> GraspSpares {
    let [(finger, finger_body), (between, between_body)] = others.nearest(grasp.opening, grasper);
    GraspSpares {
        fit: met.fit_spare(grasp.opening, grasper),
        cover: met.cover() - grasper.min_cover,
        finger,
        between,
        opening: grasper.opening - grasp.opening,
        wedge: grasper.max_wedge - check.wedge,
        finger_body,
        between_body,
    }
}

impl Pieces {
    /// Spare room of the fingers of a jaw at the origin, and of the space between them, and the bodies that leave it.
    fn nearest(&self, opening: f64, grasper: &Grasper) -> [(f64, Option<usize>); 2] {
        let finger = vec2(grasper.finger_thickness / 2.0, grasper.finger_width / 2.0);
        let space = vec2(opening / 2.0, grasper.finger_width / 2.0 - grasper.pad_edge);
        let off = opening / 2.0 + grasper.finger_thickness / 2.0;
        let mut least = [(f64::INFINITY, None); 2];
        let lower = |least: &mut (f64, Option<usize>), spare: f64, body: usize| {
            if spare < least.0 {
                *least = (spare, Some(body));
            }
        };
        for piece in self.iter() {
            for side in [-off, off] {
                let gap = self.growth(piece, vec2(side, 0.0), finger, f64::INFINITY);
                lower(&mut least[0], gap - grasper.finger_clearance, piece.body);
            }
            lower(&mut least[1], self.growth(piece, vec2(0.0, 0.0), space, f64::INFINITY), piece.body);
        }
        least
    }
}

impl Limit {
    /// In one or two words.
    pub fn name(&self) -> &'static str {
        match self {
            Limit::Missing => "nothing between",
            Limit::NotPickable => "not pickable",
            Limit::Opening => "opening",
            Limit::Width => "width",
            Limit::Finger { .. } => "finger",
            Limit::Jaw { .. } => "between",
            Limit::Cover => "cover",
            Limit::Wedge => "wedge",
            Limit::Depth => "depth",
        }
    }

    /// The body that is in the way.
    pub fn body(&self) -> Option<usize> {
        match self {
            Limit::Finger { body } | Limit::Jaw { body } => Some(*body),
            _ => None,
        }
    }
}

impl GraspExamination {
    /// Why it is not allowed and what to change, or what leaves it least room: a sentence.
    pub fn reason(&self, scene: &Scene) -> String {
        let name = |body: usize| scene.bodies().get(body).map_or("?", |body| body.name.as_str());
        let target = name(self.grasp.body);
        let mm = |metres: f64| format!("{:.2} mm", 1e3 * metres);
        let (grasper, short) = (&scene.gripper().grasp, mm(-self.grasp.margin));
        if self.allowed {
            let to = self.limit.body().filter(|body| *body != self.grasp.body).map(name);
            let to = to.map_or(String::new(), |other| format!(" (`{other}`)"));
            let room = mm(self.grasp.margin);
            return format!("it is allowed; the least spare room is {room}, that of {}{to}", self.limit.name());
        }
        match self.limit {
            Limit::Missing => {
                format!("no part of `{target}` is between the pads; move the grasp to the body")
            }
            Limit::NotPickable => format!("`{target}` is not pickable; say that it is, or choose another body"),
            Limit::Opening => format!(
                "the opening of {} is more than the gripper's {}; open it less",
                mm(self.grasp.opening),
                mm(grasper.opening)
            ),
            Limit::Width => format!(
                "`{target}` is {} wide here, and an opening of {} takes {}; turn or shift the grasp, or open wider",
                mm(self.grasp.width),
                mm(self.grasp.opening),
                mm(self.grasp.opening - 2.0 * grasper.fit)
            ),
            Limit::Finger { body } if body == self.grasp.body => format!(
                "a finger comes down on `{target}` itself or {short} too near to it; move the grasp along its closing \
                 direction"
            ),
            Limit::Finger { body } => {
                format!("a finger is {short} too near to `{}`; move the grasp, or push that body away", name(body))
            }
            Limit::Jaw { body } => format!(
                "`{}` reaches {short} into the space between the fingers; move the grasp, or push that body away",
                name(body)
            ),
            Limit::Cover => format!(
                "the pads cover {short} less of `{target}` than the {} that they must; move the grasp along the pads",
                mm(grasper.min_cover)
            ),
            Limit::Depth => format!(
                "the fingers end {} above the table, which is {short} too high for `{target}`; use fingers that reach lower, \
                 or choose another body",
                mm(grasper.lowest)
            ),
            Limit::Wedge => format!(
                "the gripped faces are {:.1} degrees out of parallel, and the gripper takes {:.1}; turn the grasp",
                self.wedge.to_degrees(),
                grasper.max_wedge.to_degrees()
            ),
        }
    }
}
