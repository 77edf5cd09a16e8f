//! The score of every grasp of a body on a grid of positions and directions: the truth that a grasp map is to tell.

use super::hold::{Rule, Subject};
use super::jaw::Pieces;
use super::test::{GraspScratch, GraspTest, Room, seen_from};
use crate::geom::{Pose2, Vec2, vec2};
use crate::scene::{Scene, State};

/// Positions and closing directions to score.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraspGrid {
    /// World position of the grid's middle, metres.
    pub centre: Vec2,
    /// Cells on each side of the square. Rows run along +y of the world, columns along +x.
    pub side: usize,
    /// Side of a cell, metres.
    pub cell: f64,
    /// Closing directions over half a turn: `k pi / angles` from +x.
    pub angles: usize,
}

impl GraspGrid {
    /// The middle of a cell as seen from the grid's, metres.
    pub fn offset(&self, row: usize, col: usize) -> Vec2 {
        let half = self.side as f64 / 2.0;
        vec2((col as f64 + 0.5 - half) * self.cell, (row as f64 + 0.5 - half) * self.cell)
    }

    /// The closing direction of index `k`, radians.
    pub fn angle(&self, k: usize) -> f64 {
        std::f64::consts::PI * k as f64 / self.angles as f64
    }
}

impl GraspTest {
    /// Hands every grasp of the body with a score above zero to `visit`: index of the direction, row, column, score.
    /// The jaw's middle is that of the cell and the gripper opens fully. Each score is what [`GraspTest::check`] says of
    /// that grasp. Directions in order, within them rows, then columns.
    pub fn on_grid(
        &self,
        scene: &Scene,
        state: &State,
        body: usize,
        grid: &GraspGrid,
        scratch: &mut GraspScratch,
        mut visit: impl FnMut(usize, usize, usize, f64),
    ) {
        if body >= scene.len() || !state.is_present(body) || !scene.body(body).pickable {
            return;
        }
        let grasper = &scene.gripper().grasp;
        let (opening, half) = (grasper.opening, grasper.finger_width / 2.0);
        let gripper = scene.gripper();
        let rule = Rule::new(gripper, self.params().score.fitted(gripper));
        let footprint = &scene.body(body).footprint;
        let subject = Subject::new(scene.body(body));
        let own = state.pose(body).frame();
        // No part of a jaw that holds the body is farther from its origin.
        let reach = footprint.radius + opening + grasper.finger_thickness + grasper.finger_width;
        let mut others = Pieces::default();
        for k in 0..grid.angles {
            let jaw = Pose2::at(grid.centre, grid.angle(k)).frame();
            let seen = seen_from(&jaw, &own);
            others.clear();
            for (i, pose) in state.iter().filter(|(i, _)| *i != body) {
                let far = reach + scene.body(i).footprint.radius;
                if (pose.position() - own.origin).norm_squared() < far * far {
                    others.add(i, &scene.body(i).footprint, &seen_from(&jaw, &pose.frame()));
                }
            }
            // Extents of the body as the jaw sees it: what is out of their reach needs no closer look.
            let along =
                |x: f64, y: f64| footprint.support(seen.inverse_vector(vec2(x, y))) + seen.origin.dot(&vec2(x, y));
            let (right, left, top, bottom) = (along(1.0, 0.0), -along(-1.0, 0.0), along(0.0, 1.0), -along(0.0, -1.0));
            for row in 0..grid.side {
                for col in 0..grid.side {
                    let at = jaw.inverse_vector(grid.offset(row, col));
                    let cover = top.min(at.y + half) - bottom.max(at.y - half);
                    let span = opening / 2.0 - grasper.fit;
                    if cover < grasper.min_cover || at.x < left - span || at.x > right + span {
                        continue;
                    }
                    let hold = subject.hold(&seen, at.y, opening, &rule, &mut scratch.pieces);
                    let Some(hold) = hold else { continue };
                    let fits = at.x >= hold.lo
                        && at.x <= hold.hi
                        && hold.fit_spare(at.x, opening, grasper) >= 0.0
                        && hold.cover >= grasper.min_cover
                        && hold.wedge <= grasper.max_wedge;
                    if !fits {
                        continue;
                    }
                    let room = Room::about(&others, at.x, at.y, opening, grasper, rule.enough_clearance());
                    if room.spare >= 0.0 {
                        let value = hold.scored(at.x, opening, room.gap, room.spare, &rule);
                        if value > 0.0 {
                            visit(k, row, col, value);
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::GraspParams;
    use super::*;
    use crate::action::Grasp;
    use crate::scene::generate::{Generator, GeneratorParams};

    #[test]
    fn every_cell_has_the_score_of_the_single_check() {
        let generator = Generator::new(GeneratorParams { bodies: 2..=5, ..GeneratorParams::default() }, 3).unwrap();
        let (mut positive, mut negative) = (0, 0);
        for index in 0..6 {
            let problem = generator.problem(index).unwrap();
            let (scene, state) = (&*problem.scene, &problem.state);
            let test = GraspTest::new(GraspParams::default()).unwrap();
            let mut scratch = GraspScratch::default();
            let body = index as usize % scene.len();
            let centre = state.pose(body).transform_point(scene.body(body).footprint.centroid);
            let grid = GraspGrid { centre, side: 24, cell: 0.006, angles: 4 };
            let mut map = vec![0.0; grid.angles * grid.side * grid.side];
            test.on_grid(scene, state, body, &grid, &mut scratch, |k, row, col, score| {
                map[(k * grid.side + row) * grid.side + col] = score;
            });
            for k in 0..grid.angles {
                for row in 0..grid.side {
                    for col in 0..grid.side {
                        let at = centre + grid.offset(row, col);
                        let opening = scene.gripper().grasp.opening;
                        let grasp =
                            Grasp { body, position: [at.x, at.y], angle: grid.angle(k), opening, ..Grasp::default() };
                        let wanted = test.check(scene, state, &grasp, &mut scratch);
                        let got: f64 = map[(k * grid.side + row) * grid.side + col];
                        // A grasp on the verge may fall to either side.
                        if wanted.margin.abs() > 1e-9 {
                            assert!((got - wanted.score).abs() < 1e-9, "{k} {row} {col}: {got} {wanted:?}");
                        }
                        if got > 0.0 { positive += 1 } else { negative += 1 }
                    }
                }
            }
        }
        assert!(positive > 200 && negative > 200, "{positive} {negative}");
    }
}
