#!/usr/bin/env bash
# parry2d 0.31.1, 2026-11-30.
# One would guess: TriMesh::from_polygon triangulates every simple polygon, however it lies.
# What is so: at some turns it gives None for the outline of a T with a corner in the middle of two straight edges: single
# precision bends collinear corners, and an ear that bends outwards by the last bit is none. Its neighbours half a degree away
# are fine.
# Why it matters: bodies with notches are accepted or refused by their heading. Triangulate with exact predicates in double
# precision, in the body's own frame, before the shape is turned.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cargo init --quiet --name finding --vcs none
cat >>Cargo.toml <<'TOML'
parry2d = "=0.31.1"
TOML
cat >src/main.rs <<'RUST'
use parry2d::math::Vector;
use parry2d::shape::TriMesh;

fn main() {
    // A T of 3 x 3, with a further corner in the middle of its top and of its foot.
    let corners = [
        [0.0, 0.0], [1.5, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0], [2.0, 3.0], [1.5, 3.0], [1.0, 3.0], [1.0, 1.0], [0.0, 1.0f64],
    ];
    let triangulated = |turn: u32| {
        let (sin, cos) = (f64::from(turn) * std::f64::consts::TAU / 720.0).sin_cos();
        let turned = corners.iter().map(|[x, y]| {
            let (x, y) = ((x - 1.5) / 3.0, (y - 1.5) / 3.0);
            Vector::new((cos * x - sin * y) as f32, (sin * x + cos * y) as f32)
        });
        TriMesh::from_polygon(turned.collect()).is_some()
    };
    let refused: Vec<u32> = (0..720).filter(|&turn| !triangulated(turn)).collect();
    println!("parry2d 0.31.1: of 720 turns of one T, {} are refused, such as {:?} (in half degrees)", refused.len(),
             &refused[..refused.len().min(5)]);
    std::process::exit(i32::from(refused.is_empty() || refused.len() > 360));
}
RUST
CARGO_TARGET_DIR=$folder/target cargo run --quiet
