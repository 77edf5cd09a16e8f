//! Executes pushes in Box2D 3: the first line of the input has the settings, each other line a push, and each line of the
//! output the poses that its bodies have afterwards. All input is in SI units; see plans.py, which writes it.

use std::io::BufRead;

use boxdd::{
    BodyBuilder, BodyId, BodyType, Foundation, FoundationConfig, MassData, MotorJointDef, Position, Result, ShapeDef,
    SurfaceMaterial, Vec2, World, WorldBuilder, shapes,
};
use serde::Deserialize;

#[derive(Deserialize)]
struct Settings {
    /// Lengths are multiplied by this before Box2D sees them.
    scale: f32,
    /// What Box2D is told by b2SetLengthUnitsPerMeter.
    length_units: f32,
    /// Greatest length of a step, seconds; steps are made a little shorter so that a push is a whole number of them.
    step: f32,
    substeps: i32,
    /// Linear and angular damping of bodies, 1/s.
    #[serde(default)]
    damping: f32,
    /// Makes contacts anew in every step.
    #[serde(default)]
    no_recycling: bool,
}

#[derive(Deserialize)]
struct Push {
    bodies: Vec<PushedBody>,
    /// x, y where the middle of the tip comes down, and where it is taken away; none: the bodies are left alone.
    path: Option<[[f32; 2]; 2]>,
    /// Along the push and across it.
    tip: [f32; 2],
    tip_friction: f32,
    speed: f32,
    /// Seconds after the push.
    settle: f32,
}

#[derive(Deserialize)]
struct PushedBody {
    pose: [f32; 3],
    /// Corners of the convex pieces in the body's frame.
    pieces: Vec<Vec<[f32; 2]>>,
    /// Radius of a disc about the origin of the body's frame.
    disc: Option<f32>,
    mass: f32,
    centre: [f32; 2],
    inertia: f32,
    friction: f32,
    feet: Vec<Foot>,
}

/// Friction on the ground: a motor joint with the ground that wants no velocity.
#[derive(Deserialize)]
struct Foot {
    at: [f32; 2],
    /// The greatest.
    force: f32,
    torque: f32,
}

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let mut lines = std::io::stdin().lock().lines();
    let settings: Settings = serde_json::from_str(&lines.next().ok_or("no settings")??)?;
    let foundation = Foundation::initialize(FoundationConfig::new(settings.length_units))?;
    for line in lines {
        let poses = execute(foundation, &settings, &serde_json::from_str(&line?)?)?;
        println!("{}", serde_json::to_string(&poses)?);
    }
    Ok(())
}

/// Box2D mixes two coefficients to the root of their product; from their squares it makes the product.
fn shape(friction: f32) -> Result<ShapeDef> {
    ShapeDef::builder().material(SurfaceMaterial::new().with_friction(friction * friction)?).build()
}

fn execute(foundation: &'static Foundation, settings: &Settings, push: &Push) -> Result<Vec<[f32; 3]>> {
    let s = settings.scale;
    let def = WorldBuilder::from(foundation.world_def()).gravity(Vec2::new(0.0, 0.0)).enable_sleep(false).build()?;
    let mut world = foundation.create_world(def)?;
    if settings.no_recycling {
        world.set_contact_recycle_distance(0.0)?;
    }
    let ground = world.create_body(BodyBuilder::from(foundation.body_def()).build()?)?;
    let mut ids = Vec::new();
    for body in &push.bodies {
        ids.push(add(foundation, &mut world, settings, ground, body)?);
    }
    if let Some([[x0, y0], [x1, y1]]) = push.path {
        let travel = (x1 - x0).hypot(y1 - y0);
        let velocity = Vec2::new((x1 - x0) / travel * push.speed * s, (y1 - y0) / travel * push.speed * s);
        let tip = BodyBuilder::from(foundation.body_def())
            .body_type(BodyType::Kinematic)
            .position(Position::new(x0 * s, y0 * s))
            .angle((y1 - y0).atan2(x1 - x0))
            .linear_velocity(velocity);
        let tip = world.create_body(tip.build()?)?;
        let polygon = shapes::box_polygon(push.tip[0] / 2.0 * s, push.tip[1] / 2.0 * s)?;
        world.body(tip)?.create_polygon(&shape(push.tip_friction)?, &polygon)?;
        steps(&mut world, settings, travel / push.speed)?;
        world.body(tip)?.destroy()?;
    }
    steps(&mut world, settings, push.settle)?;
    ids.into_iter()
        .map(|id| {
            let body = world.body(id)?;
            let (position, rotation) = (body.position()?, body.rotation()?);
            Ok([position.x / s, position.y / s, rotation.angle()])
        })
        .collect()
}

fn steps(world: &mut World, settings: &Settings, seconds: f32) -> Result<()> {
    let count = (seconds / settings.step).ceil().max(1.0);
    for _ in 0..count as usize {
        let _ = world.step(seconds / count, settings.substeps)?;
    }
    Ok(())
}

fn add(
    foundation: &'static Foundation,
    world: &mut World,
    settings: &Settings,
    ground: BodyId,
    body: &PushedBody,
) -> Result<BodyId> {
    let s = settings.scale;
    let [x, y, theta] = body.pose;
    let def = BodyBuilder::from(foundation.body_def())
        .body_type(BodyType::Dynamic)
        .position(Position::new(x * s, y * s))
        .angle(theta)
        .linear_damping(settings.damping)
        .angular_damping(settings.damping);
    let id = world.create_body(def.build()?)?;
    let def = shape(body.friction)?;
    let mut made = world.body(id)?;
    for piece in &body.pieces {
        made.create_polygon(&def, &shapes::polygon_from_points(piece.iter().map(|p| [p[0] * s, p[1] * s]), 0.0)?)?;
    }
    if let Some(radius) = body.disc {
        made.create_circle(&def, &shapes::circle([0.0, 0.0], radius * s)?)?;
    }
    let centre = Vec2::new(body.centre[0] * s, body.centre[1] * s);
    made.set_mass_data(MassData::new(body.mass, centre, body.inertia * s * s)?)?;
    drop(made);
    for foot in &body.feet {
        let at = [foot.at[0] * s, foot.at[1] * s];
        let base = world.joint_base(ground, id)?.with_local_frame_components([0.0, 0.0], 0.0, at, 0.0)?;
        let joint =
            MotorJointDef::new(base).max_velocity_force(foot.force * s).max_velocity_torque(foot.torque * s * s);
        world.create_motor_joint(&joint)?;
    }
    Ok(id)
}
