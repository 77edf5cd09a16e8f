//! Random rearrangements for tests: rectangles, triangles, L shapes and discs on the published table.

use std::f64::consts::PI;
use std::sync::Arc;

use jostle::geom::{Footprint, Pose2, Shape, pieces_gap, vec2};
use jostle::run::{Key, Stream};
use jostle::scene::{BodyDef, Goal, Rearrangement, SceneBuilder, State, Workspace};

fn shape(stream: &mut Stream) -> (Shape, f64) {
    let mut side = || stream.uniform(0.05, 0.22);
    let (a, b) = (side(), side());
    let (long, short) = (a.max(b), a.min(b).max(0.4 * a.max(b)));
    let (x, y) = (long / 2.0, short / 2.0);
    let shape = match stream.index(4) {
        0 => Shape::ConvexPolygon(vec![[-x, -y], [x, -y], [0.3 * x, y]]),
        1 => Shape::Polygon(vec![[-x, -y], [x, -y], [x, 0.0], [0.0, 0.0], [0.0, y], [-x, y]]),
        2 => Shape::Disc { radius: (x + y) / 2.0 },
        _ => Shape::rectangle(long, short),
    };
    (shape, long)
}

/// Poses in the workspace, 2 mm apart or more; `None` if there seems to be no room.
fn poses(workspace: &Workspace, footprints: &[Footprint], stream: &mut Stream) -> Option<Vec<Pose2>> {
    let mut placed: Vec<Pose2> = Vec::new();
    for (index, footprint) in footprints.iter().enumerate() {
        let free = (0..400).find_map(|_| {
            let pose = Pose2::new(stream.uniform(0.0, 0.78), stream.uniform(0.0, 0.52), stream.uniform(-PI, PI));
            let clear = |other: usize| pieces_gap(footprint, &pose, &footprints[other], &placed[other]) > 0.002;
            (workspace.margin(footprint, &pose) > 0.0 && (0..index).all(clear)).then_some(pose)
        });
        placed.push(free?);
    }
    Some(placed)
}

/// A problem of so many bodies that cover at least `fill` of the table; `push_only` is the least longest side, metres,
/// from which a body can only be dragged.
pub fn random_problem(seed: u64, bodies: usize, fill: f64, push_only: f64) -> Rearrangement {
    for attempt in 0.. {
        let mut stream = Key::new(seed).child(attempt).stream();
        let workspace = Workspace::rectangle(vec2(0.0, 0.0), vec2(0.78, 0.52));
        let mut builder = SceneBuilder::new();
        builder.workspace(workspace);
        let mut footprints = Vec::new();
        for _ in 0..bodies {
            let (shape, long) = shape(&mut stream);
            footprints.push(Footprint::new(shape.clone()).unwrap());
            builder.add_body(BodyDef { pickable: long < push_only, ..BodyDef::new(shape) }).unwrap();
        }
        let covered: f64 = footprints.iter().map(|f| f.area).sum::<f64>() / (0.78 * 0.52);
        if covered < fill || covered > fill + 0.15 {
            continue;
        }
        let Some(start) = poses(&workspace, &footprints, &mut stream) else { continue };
        let Some(end) = poses(&workspace, &footprints, &mut stream) else { continue };
        let goals = end.into_iter().map(|pose| Some(Goal::at(pose))).collect();
        let scene = Arc::new(builder.build().unwrap());
        return Rearrangement::new(format!("random {seed}"), scene, State::new(start), goals).unwrap();
    }
    unreachable!()
}
