//! A clearing problem: take everything off the table (pushing-assisted grasping, dissertation chapter on DIPN).

use std::sync::Arc;

use super::state::{Mask, State};
use super::world::Scene;
use crate::error::Result;

/// Take every body off the table, one grasp at a time, with pushes where no grasp is possible.
///
/// Every present body that is [`pickable`](super::Body::pickable) is to be taken; one that is not is an obstacle that
/// stays. No body may leave the workspace by its leave rule, whatever its leave scope: here every body is a target.
#[derive(Debug, Clone)]
pub struct Clearing {
    /// Where it came from: a file's stem, a generator's seed.
    pub name: String,
    pub scene: Arc<Scene>,
    pub state: State,
}

impl Clearing {
    /// Checks that the state fits the scene. A table without a body to take is a problem too, and solved.
    pub fn new(name: impl Into<String>, scene: Arc<Scene>, state: State) -> Result<Clearing> {
        let problem = Clearing { name: name.into(), scene, state };
        problem.validate()?;
        Ok(problem)
    }

    /// What [`Clearing::new`] checks, for a problem whose fields were changed since.
    pub fn validate(&self) -> Result<()> {
        self.scene.check_state(&self.state)
    }

    /// The same problem with the bodies elsewhere.
    #[must_use]
    pub fn at(&self, state: State) -> Clearing {
        Clearing { name: self.name.clone(), scene: Arc::clone(&self.scene), state }
    }

    /// The bodies that are still to be taken in a state.
    pub fn remaining(&self, state: &State) -> Mask {
        let mut remaining = Mask::EMPTY;
        for (i, _) in state.iter().filter(|(i, _)| self.scene.body(*i).pickable) {
            remaining.insert(i);
        }
        remaining
    }

    /// The present bodies that have left the workspace.
    pub fn left(&self, state: &State) -> Mask {
        let mut left = Mask::EMPTY;
        for (i, pose) in state.iter() {
            if !self.scene.workspace().holds(&self.scene.body(i).footprint, &pose) {
                left.insert(i);
            }
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BodyDef, SceneBuilder};
    use super::*;
    use crate::geom::{Pose2, Shape};

    #[test]
    fn what_is_pickable_remains_until_it_is_taken_and_obstacles_stay() {
        let mut builder = SceneBuilder::new();
        for pickable in [true, false, true] {
            builder.add_body(BodyDef { pickable, ..BodyDef::new(Shape::rectangle(0.04, 0.04)) }).unwrap();
        }
        let state = State::new([0.0, 0.1, 0.3].map(|y| Pose2::new(0.5, y, 0.0)));
        let problem = Clearing::new("three", Arc::new(builder.build().unwrap()), state.clone()).unwrap();
        assert_eq!(problem.remaining(&state), Mask::from(0b101));
        assert_eq!(problem.left(&state), Mask::from(0b100), "0.3 m is beyond the workspace's edge");
        let mut less = state;
        less.set_present(0, false);
        less.set_present(2, false);
        assert!(problem.remaining(&less).is_empty() && problem.left(&less).is_empty());
        problem.at(less).validate().unwrap();
    }
}
