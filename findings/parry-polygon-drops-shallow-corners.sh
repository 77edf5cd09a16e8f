#!/usr/bin/env bash
# parry2d 0.31.1, 2026-11-30.
# One would guess: ConvexPolygon::from_convex_polyline leaves out collinear corners, within rounding; there is a
# from_convex_polyline_unmodified for those who want every one of them kept.
# What is so: a corner goes if its sides turn by less than about 1.5 degrees, and the test is made with each corner against its
# neighbours as given: a regular polygon of 240 corners loses every one and is None, one of 200 keeps all.
# Why it matters: finely cut arcs (scanned or meshed outlines) become other shapes in rapier: a quarter disc of 60 segments is
# a triangle. Use the unmodified constructor, or simplify outlines to a tolerance in metres first.
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
use parry2d::shape::ConvexPolygon;

fn kept(points: Vec<Vector>) -> Option<usize> {
    ConvexPolygon::from_convex_polyline(points).map(|polygon| polygon.points().len())
}

fn arc(corners: usize, share: f32) -> Vec<Vector> {
    let angle = |k: usize| share * std::f32::consts::TAU * k as f32 / corners as f32;
    (0..corners).map(|k| Vector::new(angle(k).cos(), angle(k).sin())).collect()
}

fn main() {
    let whole: Vec<_> = [200, 240].into_iter().map(|n| kept(arc(n, 1.0))).collect();
    let quarter = |n: usize| {
        let mut points = arc(4 * n, 1.0);
        points.truncate(n + 1);
        points.push(Vector::new(0.0, 0.0));
        kept(points)
    };
    let (coarse, fine) = (quarter(55), quarter(60));
    println!("parry2d 0.31.1: corners kept of regular polygons of 200 and 240: {whole:?}; of a quarter disc of 55 and of 60 \
              segments (57 and 62 corners): {coarse:?}, {fine:?}");
    let as_said = whole[0] == Some(200) && whole[1] != Some(240) && coarse.is_some_and(|n| n > 50) && fine.is_none_or(|n| n < 10);
    std::process::exit(i32::from(!as_said));
}
RUST
CARGO_TARGET_DIR=$folder/target cargo run --quiet
