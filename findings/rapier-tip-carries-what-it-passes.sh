#!/usr/bin/env bash
# rapier2d 0.36.1, 2026-11-30.
# One would guess: a kinematic tip that passes beside a block at a distance leaves it where it is; contacts are looked for
# ahead (20 mm in the default unit of length), but push only what comes nearer.
# What is so: with default parameters a tip that passes a block of 45 mm at a distance of 2.5, 5 or 10 mm carries it along, for
# 50 mm and more; at 7.5 mm it does not. A contact is used again while its bodies moved by less than 50 mm against each other
# (contact_recycling), and so keeps a normal of long ago. Without recycling nothing moves from 2.5 mm on, and with length_unit
# = 0.01 nothing at all.
# Why it matters: table-top scenes in metres with default parameters push by ghosts, at some distances and not at others, and
# simulated pushes look plausible all the same. Set length_unit to the size of the bodies, or turn recycling off.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cargo init --quiet --name finding --vcs none
cat >>Cargo.toml <<'TOML'
rapier2d = "=0.36.1"
TOML
cat >src/main.rs <<'RUST'
use rapier2d::prelude::*;

/// How far a block moves, mm, while a tip passes it on the left at this distance.
fn moved(clear: f32, recycling: bool, length_unit: f32) -> f32 {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::ZERO;
    world.integration_parameters.contact_recycling = recycling;
    world.integration_parameters.length_unit = length_unit;
    let block = world.insert_body(RigidBodyBuilder::dynamic());
    world.insert_collider(ColliderBuilder::cuboid(0.0225, 0.0225).density(50.0).friction(0.5), Some(block));
    let start = Vector::new(-0.05, 0.0225 + 0.015 + clear);
    let body = RigidBodyBuilder::kinematic_velocity_based().translation(start).linvel(Vector::new(0.13, 0.0));
    world.insert(body, ColliderBuilder::cuboid(0.011, 0.015).friction(0.9));
    for _ in 0..46 {
        world.step();
    }
    world.bodies[block].translation().length() * 1e3
}

fn main() {
    let clear = [0.0025, 0.005, 0.0075, 0.01];
    let row = |recycling, unit| clear.map(|clear| moved(clear, recycling, unit));
    let (usual, fresh, small) = (row(true, 1.0), row(false, 1.0), row(true, 0.01));
    println!("rapier2d 0.36.1: a tip passes at {:?} mm; the block moves {usual:.1?} mm, without recycling {fresh:.1?}, with a \
              unit of 10 mm {small:.1?}", clear.map(|clear| clear * 1e3));
    let still = |row: [f32; 4]| row.iter().all(|moved| *moved < 0.01);
    let carried = usual.iter().filter(|moved| **moved > 20.0).count();
    std::process::exit(i32::from(!(carried >= 2 && still(fresh) && still(small))));
}
RUST
CARGO_TARGET_DIR=$folder/target cargo run --quiet
