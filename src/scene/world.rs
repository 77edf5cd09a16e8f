//! A scene and the problem posed in it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::body::{Body, BodyDef, MAX_BODIES, MAX_SIMULATED};
use super::gripper::Gripper;
use super::rearrangement::CONTACT_SLACK;
use super::state::{Mask, State, check_pose};
use super::workspace::{LeaveRule, LeaveScope, Workspace};
use crate::bounds;
use crate::error::{Error, Result};
use crate::geom::{Pose2, pieces_gap_below};

/// How far two bodies may overlap before a state is refused, metres. Cameras see touching bodies overlap a little;
/// engines push such bodies apart by no more than the overlap.
pub const DEFAULT_OVERLAP_TOLERANCE: f64 = 0.006;

/// Coefficients of the surfaces that are not bodies. A contact uses the product of its two surfaces' coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Friction {
    pub ground: f64,
    pub tip: f64,
}

impl Default for Friction {
    /// The originals' Bullet scenes: with blocks of 0.5 this gives 0.55 on the ground and 0.45 at the tip.
    fn default() -> Self {
        Self { ground: 1.1, tip: 0.9 }
    }
}

/// Everything about the world that does not move: immutable while planning.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    bodies: Vec<Body>,
    gripper: Gripper,
    workspace: Workspace,
    friction: Friction,
    overlap_tolerance: f64,
}

/// Collects bodies and settings, checks them, and makes a [`Scene`].
#[derive(Debug, Clone, Default)]
pub struct SceneBuilder {
    bodies: Vec<Body>,
    gripper: Gripper,
    workspace: Workspace,
    friction: Friction,
    overlap_tolerance: Option<f64>,
}

impl SceneBuilder {
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a body and gives its index. On error nothing changes.
    pub fn add_body(&mut self, def: BodyDef) -> Result<usize> {
        let index = self.bodies.len();
        if index == MAX_BODIES {
            return Err(Error::argument("bodies", format!("a scene holds at most {MAX_BODIES} bodies")));
        }
        let mut body = Body::new(def).map_err(|e| e.within(&format!("bodies[{index}]")))?;
        if body.name.is_empty() {
            body.name = format!("body {index}");
        }
        if self.bodies.iter().any(|b| b.name == body.name) {
            return Err(Error::argument(format!("bodies[{index}].name"), format!("`{}` is taken", body.name)));
        }
        self.bodies.push(body);
        Ok(index)
    }

    pub fn gripper(&mut self, gripper: Gripper) -> &mut Self {
        self.gripper = gripper;
        self
    }

    pub fn workspace(&mut self, workspace: Workspace) -> &mut Self {
        self.workspace = workspace;
        self
    }

    pub fn friction(&mut self, friction: Friction) -> &mut Self {
        self.friction = friction;
        self
    }

    /// See [`DEFAULT_OVERLAP_TOLERANCE`].
    pub fn overlap_tolerance(&mut self, metres: f64) -> &mut Self {
        self.overlap_tolerance = Some(metres);
        self
    }

    pub fn build(self) -> Result<Scene> {
        if self.bodies.is_empty() {
            return Err(Error::argument("bodies", "the scene has no bodies; add at least one"));
        }
        self.gripper.validate()?;
        self.workspace.validate()?;
        bounds::FRICTION.check("friction.ground", self.friction.ground)?;
        bounds::FRICTION.check("friction.tip", self.friction.tip)?;
        let overlap_tolerance = self.overlap_tolerance.unwrap_or(DEFAULT_OVERLAP_TOLERANCE);
        bounds::OVERLAP.check("overlap_tolerance", overlap_tolerance)?;
        Ok(Scene {
            bodies: self.bodies,
            gripper: self.gripper,
            workspace: self.workspace,
            friction: self.friction,
            overlap_tolerance,
        })
    }
}

impl Scene {
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    pub fn body(&self, index: usize) -> &Body {
        &self.bodies[index]
    }

    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    pub fn gripper(&self) -> &Gripper {
        &self.gripper
    }

    pub fn workspace(&self) -> &Workspace {
        &self.workspace
    }

    pub fn friction(&self) -> &Friction {
        &self.friction
    }

    pub fn overlap_tolerance(&self) -> f64 {
        self.overlap_tolerance
    }

    /// The index of the body with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|b| b.name == name)
    }

    /// A builder that holds what this scene holds.
    pub fn to_builder(&self) -> SceneBuilder {
        SceneBuilder {
            bodies: self.bodies.clone(),
            gripper: self.gripper.clone(),
            workspace: self.workspace,
            friction: self.friction,
            overlap_tolerance: Some(self.overlap_tolerance),
        }
    }

    /// The same scene for another gripper.
    pub fn with_gripper(&self, gripper: Gripper) -> Result<Scene> {
        gripper.validate()?;
        Ok(Scene { gripper, ..self.clone() })
    }

    /// The same scene with friction scaled: one factor for the tip, one for each body (on all its contacts).
    pub fn with_scaled_friction(&self, tip: f64, bodies: &[f64]) -> Scene {
        let mut scene = self.clone();
        scene.friction.tip *= tip;
        for (body, factor) in scene.bodies.iter_mut().zip(bodies) {
            body.friction *= factor;
        }
        scene
    }

    /// The same scene in a workspace that ends so far within its border; beyond it where negative.
    #[must_use]
    pub fn with_shrunk_workspace(mut self, by: f64) -> Scene {
        self.workspace = self.workspace.shrunk(by);
        self
    }

    /// The same scene with every length times `factor`, and the same masses.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Scene {
        Scene {
            bodies: self.bodies.iter().map(|body| body.scaled(factor)).collect(),
            gripper: self.gripper.scaled(factor),
            workspace: self.workspace.scaled(factor),
            friction: self.friction,
            overlap_tolerance: factor * self.overlap_tolerance,
        }
    }

    /// Refuses a scene that has too many bodies for the engines.
    pub fn check_simulated(&self) -> Result<()> {
        if self.len() > MAX_SIMULATED {
            let reason = format!(
                "has {} bodies; at most {MAX_SIMULATED} can be pushed about, up to {MAX_BODIES} rearranged",
                self.len()
            );
            return Err(Error::argument("bodies", reason));
        }
        Ok(())
    }

    /// Refuses a state that does not fit the scene: wrong count, out of bounds, or bodies that overlap too far.
    pub fn check_state(&self, state: &State) -> Result<()> {
        if state.len() != self.len() {
            return Err(Error::argument(
                "poses",
                format!("has {} poses for {} bodies; give one for each", state.len(), self.len()),
            ));
        }
        for (i, pose) in state.poses().iter().enumerate() {
            check_pose(&format!("poses[{i}]"), &Pose2::from(*pose))?;
        }
        for (i, pi) in state.iter() {
            for (j, pj) in state.iter().filter(|(j, _)| *j > i) {
                let (a, b) = (&self.bodies[i].footprint, &self.bodies[j].footprint);
                let gap = pieces_gap_below(a, &pi, b, &pj, 0.0);
                if gap < -self.overlap_tolerance {
                    return Err(Error::argument(
                        format!("poses[{j}]"),
                        format!(
                            "`{}` overlaps `{}` by {:.1} mm; at most {:.1} mm is taken as measuring noise",
                            self.bodies[j].name,
                            self.bodies[i].name,
                            -gap * 1e3,
                            self.overlap_tolerance * 1e3
                        ),
                    ));
                }
            }
        }
        Ok(())
    }

    /// The present bodies that have left the workspace by its rule and scope.
    pub fn left(&self, state: &State, target: Option<usize>) -> Mask {
        let mut left = Mask::EMPTY;
        for (i, pose) in state.iter() {
            let counts = self.workspace.leave_scope == LeaveScope::AllBodies || target == Some(i);
            if counts && !self.workspace.holds(&self.bodies[i].footprint, &pose) {
                left.insert(i);
            }
        }
        left
    }
}

/// A retrieval problem: bring `target` out of the clutter.
#[derive(Debug, Clone)]
pub struct Problem {
    /// Where it came from: a file's stem, a generator's seed.
    pub name: String,
    pub scene: Arc<Scene>,
    pub state: State,
    /// Index of the body to retrieve.
    pub target: usize,
}

impl Problem {
    /// Checks that the state fits the scene and that the target is there, in the workspace, and can be grasped.
    pub fn new(name: impl Into<String>, scene: Arc<Scene>, state: State, target: usize) -> Result<Problem> {
        let problem = Problem { name: name.into(), scene, state, target };
        problem.validate()?;
        Ok(problem)
    }

    /// The target is there and beyond the workspace by more than measuring noise: [`Problem::new`] refuses it.
    pub fn target_left(&self) -> bool {
        let pose = self.state.is_present(self.target).then(|| self.state.pose(self.target));
        pose.is_some_and(|pose| check_inside(&self.scene, self.scene.body(self.target), &pose).is_err())
    }

    /// What [`Problem::new`] checks, for a problem whose fields were changed since.
    pub fn validate(&self) -> Result<()> {
        self.scene.check_state(&self.state)?;
        check_target(&self.scene, &self.state, self.target)
    }
}

/// Refuses a target that does not exist, is not present, may not be grasped or has left the workspace.
pub(crate) fn check_target(scene: &Scene, state: &State, target: usize) -> Result<()> {
    let body = scene.bodies().get(target).ok_or_else(|| {
        Error::not_found("target", format!("there is no body {target}; the scene has {}", scene.len()))
    })?;
    if !state.is_present(target) {
        return Err(Error::argument("target", format!("`{}` is not present in the observed state", body.name)));
    }
    if !body.pickable {
        return Err(Error::argument("target", format!("`{}` is not pickable; set its flag", body.name)));
    }
    check_inside(scene, body, &state.pose(target))
}

/// Refuses a target that has left the workspace by its rule: no planner would bring it back. As with overlaps, measuring
/// noise is allowed for.
fn check_inside(scene: &Scene, body: &Body, pose: &Pose2) -> Result<()> {
    let workspace = scene.workspace();
    let outside = -workspace.room(&body.footprint, pose);
    if outside > scene.overlap_tolerance().max(CONTACT_SLACK) {
        let [min, max] = [workspace.min, workspace.max];
        return Err(Error::argument(
            "target",
            format!(
                "`{}` at ({:.3}, {:.3}) m {} by {:.1} mm, which goes from ({}, {}) to ({}, {}) m; move the body, or enlarge \
                 the workspace",
                body.name,
                pose.x,
                pose.y,
                match workspace.leave_rule {
                    LeaveRule::Centre => "lies outside of the workspace",
                    LeaveRule::Footprint => "reaches out of the workspace",
                },
                outside * 1e3,
                min[0],
                min[1],
                max[0],
                max[1]
            ),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Pose2, Shape};

    fn two_squares() -> Scene {
        let mut b = SceneBuilder::new();
        b.add_body(BodyDef::new(Shape::rectangle(0.04, 0.04))).unwrap();
        b.add_body(BodyDef::new(Shape::rectangle(0.04, 0.04))).unwrap();
        b.build().unwrap()
    }

    #[test]
    fn an_overlap_beyond_the_tolerance_is_refused_by_name() {
        let scene = two_squares();
        let at = |x: f64| State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.5 + x, 0.0, 0.0)]);
        scene.check_state(&at(0.04)).unwrap();
        scene.check_state(&at(0.036)).unwrap();
        let error = scene.check_state(&at(0.03)).unwrap_err().to_string();
        assert!(error.starts_with("poses[1]: `body 1` overlaps `body 0` by 10.0 mm"), "{error}");
    }

    #[test]
    fn leaving_follows_rule_and_scope() {
        use super::super::workspace::LeaveRule;
        let scene = two_squares();
        let state = State::new([Pose2::new(0.5, 0.0, 0.0), Pose2::new(0.72, 0.0, 0.0)]);
        assert!(scene.left(&state, Some(0)).is_empty());
        let mut b = scene.to_builder();
        b.workspace(Workspace { leave_rule: LeaveRule::Footprint, ..Workspace::default() });
        let strict = b.build().unwrap();
        assert_eq!(strict.left(&state, Some(0)).iter().collect::<Vec<_>>(), [1]);
        let mut b = strict.to_builder();
        b.workspace(Workspace { leave_scope: LeaveScope::TargetOnly, ..*strict.workspace() });
        assert!(b.build().unwrap().left(&state, Some(0)).is_empty());
    }

    #[test]
    fn a_failed_body_changes_nothing_and_names_its_index() {
        let mut b = SceneBuilder::new();
        b.add_body(BodyDef::new(Shape::rectangle(0.04, 0.04))).unwrap();
        let mut def = BodyDef::new(Shape::rectangle(0.04, 0.04));
        def.mass = -1.0;
        assert!(b.add_body(def).unwrap_err().to_string().starts_with("bodies[1].mass: is -1"));
        assert_eq!(b.build().unwrap().len(), 1);
    }
}
