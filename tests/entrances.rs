//! One validation for every entrance: what a builder, a scene file or the C API accepts, all accept, and a refusal names
//! the same field. And what is accepted can be planned with.

use std::collections::BTreeMap;
use std::ffi::{CStr, CString};
use std::sync::Arc;

use jostle::bounds;
use jostle::error::Error;
use jostle::ffi::abi::jostle_vec2;
use jostle::ffi::body::{self, jostle_body_def, jostle_body_def_init, jostle_shape_part};
use jostle::ffi::context::{jostle_context_free, jostle_context_new};
use jostle::ffi::options::*;
use jostle::ffi::scene::*;
use jostle::ffi::scene_file::jostle_scene_read;
use jostle::ffi::simulator::{
    jostle_simulator_free, jostle_simulator_new, jostle_simulator_options, jostle_simulator_options_init,
};
use jostle::ffi::status::{JOSTLE_OK, jostle_last_error, jostle_status};
use jostle::geom::{CompoundPart, Pose2, Shape, vec2};
use jostle::physics::PhysicsOptions;
use jostle::plan::clear::{ClearOptions, ClearPlanner};
use jostle::plan::rearrange::{RearrangeOptions, RearrangePlanner};
use jostle::plan::{Control, Planner, PlannerOptions};
use jostle::run::{Budget, Key, Stream};
use jostle::scene::{
    BodyDef, Clearing, Friction, Goal, Gripper, Problem, Rearrangement, SceneBuilder, State, Workspace,
};
use serde_json::json;

/// A scene of a target and another body, of which one number is varied.
#[derive(Debug, Clone)]
struct Given {
    def: BodyDef,
    pose: Pose2,
    gripper: Gripper,
    workspace: Workspace,
    friction: Friction,
    overlap_tolerance: f64,
}

const TARGET: Pose2 = Pose2 { x: 0.5, y: 0.0, theta: 0.0 };

impl Given {
    fn new(shape: Shape) -> Given {
        Given {
            def: BodyDef::new(shape),
            pose: Pose2::new(0.6, 90.0, 0.3),
            gripper: Gripper::default(),
            workspace: Workspace::default(),
            friction: Friction::default(),
            overlap_tolerance: 0.006,
        }
    }

    /// The field that a builder refuses; none if it accepts everything.
    fn rust(&self) -> Option<String> {
        let made = || {
            let mut builder = SceneBuilder::new();
            builder.add_body(BodyDef::new(Shape::rectangle(0.04, 0.04)))?;
            builder.add_body(self.def.clone())?;
            builder.gripper(self.gripper.clone()).workspace(self.workspace).friction(self.friction);
            builder.overlap_tolerance(self.overlap_tolerance);
            Problem::new("", Arc::new(builder.build()?), State::new([TARGET, self.pose]), 0)
        };
        made().err().map(|error| field(&error))
    }

    /// The same of a scene file; `None` where JSON has no way to write the number.
    fn file(&self) -> Option<Option<String>> {
        let text = self.json()?;
        Some(Problem::from_json(&text).err().map(|error| field(&error)))
    }

    fn json(&self) -> Option<String> {
        let d = &self.def;
        let mut body = json!({
            "shape": d.shape, "height": d.height, "mass": d.mass, "friction": d.friction, "pose": self.pose,
        });
        d.centre_of_mass.inspect(|centre| body["centre_of_mass"] = json!(centre));
        d.inertia.inspect(|inertia| body["inertia"] = json!(inertia));
        let square = json!({"shape": Shape::rectangle(0.04, 0.04), "pose": TARGET});
        let document = json!({
            "version": 1, "bodies": [square, body], "target": 0, "gripper": self.gripper, "workspace": self.workspace,
            "friction": self.friction, "overlap_tolerance": self.overlap_tolerance,
        });
        // Only these may be null; elsewhere it stands for a number that is none.
        (!document.to_string().contains("null")).then(|| document.to_string())
    }

    /// The same of the C API.
    fn c(&self) -> Option<String> {
        // SAFETY: all pointers are to values that outlive the calls.
        unsafe { self.through_c().err().map(|message| c_field(&message)) }
    }

    unsafe fn through_c(&self) -> Result<(), String> {
        // SAFETY: as promised by the caller.
        unsafe {
            let (mut context, mut scene) = (std::ptr::null_mut(), std::ptr::null_mut());
            said(jostle_context_new(std::ptr::null(), &mut context))?;
            said(jostle_scene_new(context, &mut scene))?;
            let (mut target, mut other) = Default::default();
            let mut made = || {
                let square = Given { pose: TARGET, ..Given::new(Shape::rectangle(0.04, 0.04)) };
                square.add(scene, &mut target)?;
                self.add(scene, &mut other)?;
                let gripper = jostle_gripper::from(&self.gripper);
                said(jostle_scene_set_gripper(scene, &gripper))?;
                said(jostle_scene_set_workspace(scene, &jostle_workspace::from(&self.workspace)))?;
                said(jostle_scene_set_friction(scene, self.friction.ground, self.friction.tip))?;
                said(jostle_scene_set_overlap_tolerance(scene, self.overlap_tolerance))?;
                // What comes out goes in again.
                let mut pose = Default::default();
                said(jostle_scene_get_pose(scene, other, &mut pose))?;
                said(jostle_scene_set_pose(scene, other, &pose))?;
                let mut options: jostle_simulator_options = std::mem::zeroed();
                said(jostle_simulator_options_init(&mut options, size_of::<jostle_simulator_options>()))?;
                options.engine = c"planar".as_ptr();
                let mut simulator = std::ptr::null_mut();
                said(jostle_simulator_new(context, scene, target, &options, &mut simulator))?;
                jostle_simulator_free(simulator);
                Ok(())
            };
            let result = made();
            jostle_scene_free(scene);
            jostle_context_free(context);
            result
        }
    }

    unsafe fn add(&self, scene: *mut jostle_scene, body: &mut jostle::ffi::abi::jostle_body) -> Result<(), String> {
        // SAFETY: as promised by the caller; the corners outlive the call.
        unsafe {
            let mut def: jostle_body_def = std::mem::zeroed();
            said(jostle_body_def_init(&mut def, size_of::<jostle_body_def>()))?;
            let corners: Vec<jostle_vec2>;
            let parts: Vec<jostle_shape_part>;
            (def.pose, def.height, def.mass, def.friction) =
                (self.pose.into(), self.def.height, self.def.mass, self.def.friction);
            def.inertia = self.def.inertia.unwrap_or(0.0);
            if let Some(centre) = self.def.centre_of_mass {
                (def.has_centre_of_mass, def.centre_of_mass) = (1, centre.into());
            }
            match &self.def.shape {
                Shape::Disc { radius } => (def.shape, def.radius) = (body::JOSTLE_SHAPE_DISC, *radius),
                Shape::Polygon(points) | Shape::ConvexPolygon(points) => {
                    corners = points.iter().map(|&p| p.into()).collect();
                    (def.points, def.point_count) = (corners.as_ptr(), corners.len());
                    if matches!(self.def.shape, Shape::ConvexPolygon(_)) {
                        def.shape = body::JOSTLE_SHAPE_CONVEX_POLYGON;
                    }
                }
                Shape::Compound(list) => {
                    let part = |part: &CompoundPart| match part.shape {
                        Shape::Disc { radius } => jostle_shape_part {
                            shape: body::JOSTLE_SHAPE_DISC,
                            reserved: 0,
                            pose: part.pose.into(),
                            points: std::ptr::null(),
                            point_count: 0,
                            radius,
                        },
                        _ => unreachable!("the compounds here are of discs"),
                    };
                    parts = list.iter().map(part).collect();
                    (def.shape, def.parts, def.part_count) = (body::JOSTLE_SHAPE_COMPOUND, parts.as_ptr(), parts.len());
                }
            }
            said(jostle_scene_add_body(scene, &def, body))
        }
    }
}

fn said(status: jostle_status) -> Result<(), String> {
    if status == JOSTLE_OK {
        return Ok(());
    }
    // SAFETY: the message is a string of this thread until its next call.
    Err(unsafe { CStr::from_ptr(jostle_last_error()) }.to_string_lossy().into_owned())
}

/// The field of an error, without the place of the body in the scene.
fn field(error: &Error) -> String {
    let (Error::Argument { field, .. } | Error::NotFound { field, .. }) = error else { panic!("{error}") };
    field.replace("bodies[1].", "").replace("poses[1]", "pose")
}

/// The field of a message of the C API as Rust has it.
fn c_field(message: &str) -> String {
    let field = message.split(": ").next().unwrap_or_default().replacen("def.", "", 1);
    let field = field.replace(".p.", ".").replace("gripper.push_", "gripper.push.").replace("poses[1]", "pose");
    match field.as_str() {
        "radius" => "shape.disc.radius".into(),
        "ground" | "tip" => format!("friction.{field}"),
        "metres" => "overlap_tolerance".into(),
        _ if field.starts_with("points") => field.replace("points", "shape.polygon"),
        _ if field.starts_with("parts") => {
            field.replace("parts", "shape.compound").replace("].radius", "].disc.radius")
        }
        _ => match field.strip_prefix("gripper.") {
            Some(rest) if !rest.starts_with("push.") => format!("gripper.grasp.{rest}"),
            _ => field,
        },
    }
}

/// A number that is varied, by name, and what it is varied in.
type Slot = (&'static str, fn(&mut Given, f64));

fn l_shape(far: f64) -> Shape {
    Shape::Polygon(vec![[0.0, 0.0], [far, 0.0], [0.04, 0.02], [0.02, 0.02], [0.02, 0.06], [0.0, 0.06]])
}

const SLOTS: &[Slot] = &[
    ("mass", |g, v| g.def.mass = v),
    ("height", |g, v| g.def.height = v),
    ("friction", |g, v| g.def.friction = v),
    ("inertia", |g, v| g.def.inertia = Some(v)),
    ("centre_of_mass", |g, v| g.def.centre_of_mass = Some([v, 0.0])),
    ("shape.disc.radius", |g, v| g.def.shape = Shape::Disc { radius: v }),
    ("shape.polygon", |g, v| g.def.shape = l_shape(v)),
    ("shape.compound", |g, v| {
        let disc = |x: f64, radius: f64| CompoundPart { pose: Pose2::new(x, 0.0, 0.0), shape: Shape::Disc { radius } };
        g.def.shape = Shape::Compound(vec![disc(0.0, 0.02), disc(v, 0.02)]);
    }),
    ("shape.compound[1].disc.radius", |g, v| {
        let disc = |x: f64, radius: f64| CompoundPart { pose: Pose2::new(x, 0.0, 0.0), shape: Shape::Disc { radius } };
        g.def.shape = Shape::Compound(vec![disc(0.0, 0.02), disc(0.02, v)]);
    }),
    ("pose.x", |g, v| g.pose.x = v),
    ("pose.y", |g, v| g.pose = Pose2::new(5.0, v, 0.0)),
    ("pose.theta", |g, v| g.pose.theta = v),
    ("workspace.min.x", |g, v| g.workspace.min[0] = v),
    ("workspace.max.y", |g, v| g.workspace.max[1] = v),
    ("gripper.push.width", |g, v| g.gripper.push.width = v),
    ("gripper.push.thickness", |g, v| g.gripper.push.thickness = v),
    ("gripper.push.clearance", |g, v| g.gripper.push.clearance = v),
    ("gripper.grasp.opening", |g, v| g.gripper.grasp.opening = v),
    ("gripper.grasp.finger_width", |g, v| g.gripper.grasp.finger_width = v),
    ("gripper.grasp.finger_thickness", |g, v| g.gripper.grasp.finger_thickness = v),
    ("gripper.grasp.finger_clearance", |g, v| g.gripper.grasp.finger_clearance = v),
    ("gripper.grasp.fit", |g, v| g.gripper.grasp.fit = v),
    ("gripper.grasp.pad_edge", |g, v| g.gripper.grasp.pad_edge = v),
    ("gripper.grasp.min_cover", |g, v| g.gripper.grasp.min_cover = v),
    ("gripper.grasp.lowest", |g, v| g.gripper.grasp.lowest = v),
    ("gripper.grasp.max_wedge", |g, v| g.gripper.grasp.max_wedge = v),
    ("friction.ground", |g, v| g.friction.ground = v),
    ("friction.tip", |g, v| g.friction.tip = v),
    ("overlap_tolerance", |g, v| g.overlap_tolerance = v),
];

/// Numbers of every magnitude, the ends of every bound and their neighbours, and what is no number.
fn numbers(draw: &mut Stream) -> Vec<f64> {
    let mut values = vec![0.0, -0.0, f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX, -f64::MAX, 5e-324, 1e-320];
    for bound in bounds::BOUNDS {
        for end in [bound.least, bound.greatest] {
            values.extend([end, end.next_up(), end.next_down()]);
        }
    }
    for _ in 0..24 {
        let size = 10f64.powf(draw.uniform(-320.0, 308.0));
        let near = 10f64.powf(draw.uniform(-7.0, 4.0));
        values.extend([size, -size, near, -near]);
    }
    values
}

#[test]
fn every_entrance_gives_the_same_verdict_and_names_the_same_field() {
    let mut draw = Key::new(17).stream();
    let mut verdicts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for &(name, set) in SLOTS {
        for value in numbers(&mut draw) {
            let mut given = Given::new(l_shape(0.06));
            set(&mut given, value);
            // In C an inertia of 0 asks for that of a prism, and the file and the builder have an absent one for it.
            if name == "inertia" && value == 0.0 {
                continue;
            }
            let rust = given.rust();
            assert_eq!(given.c(), rust, "{name} = {value:e}: C and the builder");
            if let Some(file) = given.file() {
                assert_eq!(file, rust, "{name} = {value:e}: the file and the builder");
            }
            let refused = usize::from(rust.is_some());
            verdicts.entry(name).or_default()[refused] += 1;
            if !value.is_finite() {
                assert!(rust.is_some(), "{name} = {value} is accepted");
            }
        }
    }
    println!("accepted, refused: {verdicts:?}");
    for (name, [accepted, refused]) in verdicts {
        assert!(accepted > 0 && refused > 0, "{name}: {accepted} accepted, {refused} refused");
    }
}

#[test]
fn the_count_of_corners_and_parts_has_the_same_limit_at_every_entrance() {
    let ring = |count: usize| {
        let corner = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / count as f64;
            // Every other corner lies further in, so that the outline is no convex one.
            let radius = if i.is_multiple_of(2) { 0.2 } else { 0.199 };
            [radius * angle.cos(), radius * angle.sin()]
        };
        (0..count).map(corner).collect()
    };
    for (corners, refused) in [(2, true), (4097, true), (5000, true), (100_000, true)] {
        let given = Given::new(Shape::Polygon(ring(corners)));
        let verdict = given.rust();
        assert_eq!(
            (verdict.is_some(), given.c(), given.file()),
            (refused, verdict.clone(), Some(verdict)),
            "{corners}"
        );
    }
    // The most that is allowed; convex, so that no splitting hides the limit.
    let round = |i: usize| (std::f64::consts::TAU * i as f64 / 4096.0).sin_cos();
    let circle = (0..4096).map(|i| [round(i).1, round(i).0]).collect();
    let given = Given::new(Shape::Polygon(circle));
    assert_eq!((given.rust(), given.c(), given.file()), (None, None, Some(None)));
    let disc = |i: usize| CompoundPart {
        pose: Pose2::new(0.03 * (i % 16) as f64, 0.03 * (i / 16) as f64, 0.0),
        shape: Shape::Disc { radius: 0.015 },
    };
    for (parts, refused) in [(0, true), (1, false), (256, false), (257, true)] {
        let given = Given::new(Shape::Compound((0..parts).map(disc).collect()));
        let verdict = given.rust();
        assert_eq!(verdict.is_some(), refused, "{parts}: {verdict:?}");
        assert_eq!((given.c(), given.file()), (verdict.clone(), Some(verdict)), "{parts}");
    }
}

/// A target that could be grasped, but where the robot does not work.
#[test]
fn a_target_outside_of_the_workspace_is_refused_with_both_named() {
    let folder = std::env::temp_dir().join(format!("jostle-entrances-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut draw = Key::new(18).stream();
    for i in 0..60 {
        let rule = if i % 2 == 0 { "centre" } else { "footprint" };
        let out = draw.uniform(-0.1, 0.1);
        let edge = 0.724 + if rule == "centre" { 0.0 } else { -0.02 };
        let text = json!({
            "version": 1, "target": 0, "bodies": [
                {"name": "jar", "shape": Shape::rectangle(0.04, 0.04), "pose": {"x": edge + out, "y": 0.0}}],
            "workspace": {"min": [0.276, -0.224], "max": [0.724, 0.224], "leave_rule": rule},
        });
        let refused = out > 0.006;
        let read = Problem::from_json(&text.to_string());
        assert_eq!(read.is_err(), refused, "{rule}, {out}: {read:?}");
        let mut inside = Problem::from_json(&text.to_string().replace(&(edge + out).to_string(), "0.5")).unwrap();
        inside.state.set_pose(0, Pose2::new(edge + out, 0.0, 0.0));
        assert_eq!((inside.validate().is_err(), inside.target_left()), (refused, refused), "{rule}, {out}");
        let mut planner =
            Planner::new(PlannerOptions { budget: Budget::iterations(1), threads: 1, ..PlannerOptions::default() })
                .unwrap();
        if let Err(error) = read {
            let error = error.to_string();
            assert!(error.starts_with("target: `jar` at (") && error.contains("workspace by "), "{error}");
            assert!(planner.solve(&inside, &Control::default()).unwrap_err().to_string().starts_with("target: `jar`"));
        }
        let path = folder.join("one.json");
        std::fs::write(&path, text.to_string()).unwrap();
        // SAFETY: all pointers are to values that outlive the calls.
        let c = unsafe {
            let path = CString::new(path.to_str().unwrap()).unwrap();
            let (mut context, mut scene, mut target) = (std::ptr::null_mut(), std::ptr::null_mut(), Default::default());
            said(jostle_context_new(std::ptr::null(), &mut context)).unwrap();
            let read = said(jostle_scene_read(context, path.as_ptr(), &mut scene, &mut target));
            jostle_scene_free(scene);
            jostle_context_free(context);
            read
        };
        assert_eq!(c.is_err(), refused, "{rule}, {out}: {c:?}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A number of a bound's range: an end of it now and then, else of any magnitude between them.
fn any(draw: &mut Stream, bound: &bounds::Bound) -> f64 {
    let least = bound.least.max(1e-9);
    match draw.index(8) {
        0 => bound.least,
        1 => bound.greatest,
        _ => (10f64.powf(draw.uniform(least.log10(), bound.greatest.log10()))).clamp(bound.least, bound.greatest),
    }
}

/// A scene whose every number may have any value that is allowed.
fn wild(draw: &mut Stream) -> Option<(Arc<jostle::scene::Scene>, State)> {
    // Bodies, gripper and table of about one size now and then, else each of its own.
    let size = 10f64.powf(draw.uniform(-2.5, 0.5));
    let length = |draw: &mut Stream, bound: &bounds::Bound| match draw.chance(0.7) {
        true => (size * draw.uniform(0.3, 1.0)).clamp(bound.least, bound.greatest),
        false => any(draw, bound),
    };
    let mut gripper = Gripper::default();
    gripper.push.width = length(draw, &bounds::FINGER);
    gripper.push.thickness = length(draw, &bounds::FINGER);
    gripper.push.clearance = any(draw, &bounds::GAP);
    gripper.grasp.opening = length(draw, &bounds::FINGER);
    gripper.grasp.finger_width = length(draw, &bounds::FINGER);
    gripper.grasp.finger_thickness = length(draw, &bounds::FINGER);
    gripper.grasp.fit = gripper.grasp.opening * draw.uniform(0.0, 0.4);
    gripper.grasp.pad_edge = gripper.grasp.finger_width * draw.uniform(0.0, 0.5);
    gripper.grasp.min_cover = gripper.grasp.finger_width * draw.unit();
    let side = (size * draw.uniform(4.0, 20.0)).clamp(1e-3, 90.0);
    let at = draw.uniform(-50.0, 50.0) * f64::from(u8::from(draw.chance(0.3)));
    let mut builder = SceneBuilder::new();
    let corner = |v: f64| vec2(at + v, at + v);
    builder.workspace(Workspace::rectangle(corner(-side / 2.0), corner(side / 2.0)));
    builder.gripper(gripper);
    builder.friction(Friction { ground: any(draw, &bounds::FRICTION), tip: any(draw, &bounds::FRICTION) });
    let mut poses = Vec::new();
    for i in 0..3 {
        let shape = match draw.index(3) {
            0 => Shape::Disc { radius: length(draw, &bounds::RADIUS) },
            1 => {
                let (a, b) = (length(draw, &bounds::RADIUS), length(draw, &bounds::RADIUS));
                Shape::Polygon(vec![[0.0, 0.0], [a, 0.0], [a, b / 3.0], [a / 3.0, b / 3.0], [a / 3.0, b], [0.0, b]])
            }
            _ => Shape::rectangle(length(draw, &bounds::RADIUS), length(draw, &bounds::RADIUS)),
        };
        let mut def = BodyDef::new(shape);
        def.mass = any(draw, &bounds::MASS);
        def.height = length(draw, &bounds::HEIGHT);
        def.friction = any(draw, &bounds::FRICTION);
        if draw.chance(0.3) {
            let gyration = any(draw, &bounds::GYRATION);
            def.inertia = Some(def.mass * gyration * gyration);
        }
        if draw.chance(0.2) {
            def.centre_of_mass = Some([any(draw, &bounds::LOCAL), 0.0]);
        }
        builder.add_body(def).ok()?;
        let spread = size * 1.3 * i as f64;
        poses.push(Pose2::new(at + spread, at + size * draw.uniform(-0.2, 0.2), draw.uniform(-3.0, 3.0)));
    }
    Some((Arc::new(builder.build().ok()?), State::new(poses)))
}

#[test]
fn what_is_accepted_can_be_planned_with() {
    let budget = Budget::iterations(4);
    let mut planned = [0usize; 5];
    for seed in 0..60 {
        let mut draw = Key::new(19).child(seed).stream();
        let Some((scene, state)) = wild(&mut draw) else { continue };
        let wrong = |what: &str, error: Error| panic!("{what} of scene {seed}: {error}\n{scene:?}\n{state:?}");
        if let Ok(problem) = Problem::new("wild", Arc::clone(&scene), state.clone(), 0) {
            for (i, engine) in ["planar", "prism", "rapier"].into_iter().enumerate() {
                let physics = Some(PhysicsOptions::named(engine, None, jostle::physics::Purpose::Planning).unwrap());
                let options =
                    PlannerOptions { planner: "pmbs".into(), physics, budget, threads: 1, ..PlannerOptions::default() };
                match Planner::new(options).and_then(|mut p| p.solve(&problem, &Control::default())) {
                    Ok(_) => planned[i] += 1,
                    Err(error) => wrong(engine, error),
                }
            }
        }
        if let Ok(problem) = Clearing::new("wild", Arc::clone(&scene), state.clone()) {
            let options = ClearOptions { budget, threads: 1, ..ClearOptions::default() };
            match ClearPlanner::new(options).and_then(|mut p| p.solve(&problem, &Control::default())) {
                Ok(_) => planned[3] += 1,
                Err(error) => wrong("greedy", error),
            }
        }
        let shift = Goal::at(Pose2::new(state.pose(1).x, state.pose(1).y + 1e-4, 0.0));
        let goals = vec![None, Some(shift), None];
        if let Ok(problem) = Rearrangement::new("wild", Arc::clone(&scene), state.clone(), goals) {
            let options = RearrangeOptions { budget, threads: 1, ..RearrangeOptions::default() };
            match RearrangePlanner::new(options).and_then(|mut p| p.solve(&problem, &Control::default())) {
                Ok(_) => planned[4] += 1,
                Err(error) => wrong("untangle", error),
            }
        }
    }
    println!("planned with planar, prism, rapier, greedy, untangle: {planned:?}");
    assert!(planned.iter().all(|&count| count >= 8), "too few scenes were accepted: {planned:?}");
}

/// The inputs that other people sent, where they are at hand.
#[test]
fn inputs_that_crashed_are_refused_by_name() {
    let root = std::env::var_os("JOSTLE_SHARED")
        .map_or_else(|| std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), std::path::PathBuf::from);
    for (name, wanted) in [
        ("mass-1e39", "mass: is 1e39; it must lie in 1e-9 to 1000 kg"),
        ("disc-2e298", "bodies[0].shape.disc.radius: is 2e298; it must lie in 6e-4 to 10 m"),
        ("far-from-origin", "bodies[0].pose.x: is 500000.5621117; it must lie in -100 to 100 m"),
        ("graspable-but-outside", "target: `cube 0` at (0.900, 0.000) m lies outside of the workspace by 176.0 mm"),
        ("nested-unknown-field", "version: is 2; this library reads version 1"),
    ] {
        let path = root.join(format!("data/faults/{name}.json"));
        if !path.exists() {
            println!("skipped: {} is not there (set JOSTLE_SHARED)", path.display());
            continue;
        }
        let error = Problem::read(&path).unwrap_err().to_string();
        assert!(error.contains(wanted), "{name}: {error}");
    }
}
