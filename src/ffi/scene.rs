//! Scenes: what a robot knows of its table.

use std::ffi::c_char;
use std::sync::{Arc, OnceLock, RwLock};

use super::abi::{
    boolean, fill, fill_text, jostle_body, jostle_body_pose, jostle_pose2, out, out_handle, pose, read, slice, text,
};
use super::body::{jostle_body_def, read_def};
use super::context::{Context, jostle_context};
use super::guard::{self, free, guard};
use super::handle::{Kind, Object};
use super::log::Log;
use super::status::{Failure, JOSTLE_ERROR_NOT_FOUND, Outcome, jostle_status};
use crate::error::Error;
use crate::geom::Pose2;
use crate::grasp::{GraspParams, GraspTest};
use crate::scene::{
    Body, BodyDef, Clearing, DEFAULT_OVERLAP_TOLERANCE, Friction, Goal, Gripper, MAX_BODIES, Problem, Rearrangement,
    Scene as Model, SceneBuilder, State, Workspace, check_pose,
};

/// What a robot knows of its table: bodies and where they are, gripper, workspace, friction. Opaque.
pub struct jostle_scene(());

/// The bodies of a scene by id, in the order of the library's indices.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Bodies(Vec<jostle_body>);

impl Bodies {
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn id(&self, index: usize) -> jostle_body {
        self.0.get(index).copied().unwrap_or_default()
    }

    pub fn index(&self, body: jostle_body, field: &str) -> Outcome<usize> {
        if body.id == 0 {
            return Err(Failure::argument(field, "is zero, which is no body"));
        }
        self.0.iter().position(|&known| known == body).ok_or_else(|| {
            Failure::new(
                JOSTLE_ERROR_NOT_FOUND,
                format!("{field}: body {:#x} is not in this scene; it was removed, or is another scene's", body.id),
            )
        })
    }

    /// All poses of a state with their ids.
    pub fn poses(&self, state: &State) -> Vec<jostle_body_pose> {
        (0..state.len().min(self.len()))
            .map(|i| jostle_body_pose {
                body: self.id(i),
                pose: state.pose(i).into(),
                present: u32::from(state.is_present(i)),
                reserved: 0,
            })
            .collect()
    }
}

/// What the handle holds: definitions and poses as given, and the library's scene made of them when it is needed.
#[derive(Clone)]
pub(super) struct Content {
    bodies: Bodies,
    defs: Vec<BodyDef>,
    poses: Vec<Pose2>,
    present: Vec<bool>,
    /// One for each body.
    pub goals: Vec<Option<Goal>>,
    pub gripper: Gripper,
    pub workspace: Workspace,
    pub friction: Friction,
    pub overlap_tolerance: f64,
    /// Of the next body: never given out again, so that the id of a removed body stays unknown.
    next: u64,
    /// Distinguishes the ids of unrelated scenes.
    family: u64,
    model: OnceLock<Arc<Model>>,
    /// The grasp test made ready for the model.
    grasps: OnceLock<Arc<GraspTest>>,
    /// Of the problem it came from; empty for a scene that was built.
    name: String,
}

/// A scene as planners and simulators take it.
pub(super) struct Observed {
    pub model: Arc<Model>,
    pub state: State,
    pub bodies: Bodies,
}

impl Content {
    fn new() -> Content {
        use std::sync::atomic::{AtomicU64, Ordering};
        static FAMILIES: AtomicU64 = AtomicU64::new(1);
        Content {
            bodies: Bodies::default(),
            defs: Vec::new(),
            poses: Vec::new(),
            present: Vec::new(),
            goals: Vec::new(),
            gripper: Gripper::default(),
            workspace: Workspace::default(),
            friction: Friction::default(),
            overlap_tolerance: DEFAULT_OVERLAP_TOLERANCE,
            next: 1,
            family: FAMILIES.fetch_add(1, Ordering::Relaxed),
            model: OnceLock::new(),
            grasps: OnceLock::new(),
            name: String::new(),
        }
    }

    /// What a problem holds.
    pub fn of(name: &str, scene: &Model, state: &State, goals: &[Option<Goal>]) -> Content {
        let mut content = Content::new();
        for (i, body) in scene.bodies().iter().enumerate() {
            content.push(body.def(), state.pose(i), state.is_present(i));
            content.goals[i] = goals.get(i).copied().flatten();
        }
        content.gripper = scene.gripper().clone();
        content.workspace = *scene.workspace();
        content.friction = *scene.friction();
        content.overlap_tolerance = scene.overlap_tolerance();
        content.name = name.to_owned();
        content
    }

    pub fn index(&self, body: jostle_body, field: &str) -> Outcome<usize> {
        self.bodies.index(body, field)
    }

    pub fn id(&self, index: usize) -> jostle_body {
        self.bodies.id(index)
    }

    fn push(&mut self, def: BodyDef, pose: Pose2, present: bool) -> jostle_body {
        // Upper half: the scene it was made in; lower half: its number there. Clones share both.
        let id = jostle_body { id: self.family << 32 | self.next };
        self.next += 1;
        self.bodies.0.push(id);
        self.defs.push(def);
        self.poses.push(pose);
        self.present.push(present);
        self.goals.push(None);
        self.changed();
        id
    }

    /// Something other than a pose was changed.
    pub fn changed(&mut self) {
        self.model = OnceLock::new();
        self.grasps = OnceLock::new();
    }

    /// Adds a body whose name, where it is taken, gets a number. `field` is what errors call it.
    pub fn add(&mut self, mut def: BodyDef, pose: Pose2, field: &str) -> Outcome<jostle_body> {
        if self.defs.len() == MAX_BODIES {
            return Err(Failure::argument("scene", format!("holds {MAX_BODIES} bodies, the most it can")));
        }
        Body::new(def.clone()).map_err(|error| error.within(field))?;
        check_pose(&format!("{field}.pose"), &pose)?;
        let name = def.name.clone();
        let mut number = 1;
        while self.defs.iter().any(|known| known.name == def.name) {
            number += 1;
            def.name = format!("{name} ({number})");
        }
        Ok(self.push(def, pose, true))
    }

    pub fn model(&self) -> Outcome<Arc<Model>> {
        if let Some(model) = self.model.get() {
            return Ok(Arc::clone(model));
        }
        let mut builder = SceneBuilder::new();
        for def in &self.defs {
            builder.add_body(def.clone())?;
        }
        builder
            .gripper(self.gripper.clone())
            .workspace(self.workspace)
            .friction(self.friction)
            .overlap_tolerance(self.overlap_tolerance);
        let model = Arc::new(builder.build()?);
        Ok(Arc::clone(self.model.get_or_init(|| model)))
    }

    /// What grasps of a body are examined with, and its index: it is present, and no bodies overlap.
    pub fn graspable(&self, body: jostle_body) -> Outcome<(Observed, Arc<GraspTest>, usize)> {
        let index = self.bodies.index(body, "body")?;
        let observed = self.observed()?;
        if !observed.state.is_present(index) {
            return Err(Failure::argument("body", format!("`{}` is not present", self.defs[index].name)));
        }
        let test = self.grasp_test(&observed.model)?;
        Ok((observed, test, index))
    }

    fn grasp_test(&self, model: &Model) -> Outcome<Arc<GraspTest>> {
        if let Some(test) = self.grasps.get() {
            return Ok(Arc::clone(test));
        }
        let test = Arc::new(GraspTest::new(GraspParams::default())?.prepared(model));
        Ok(Arc::clone(self.grasps.get_or_init(|| test)))
    }

    pub fn state(&self) -> State {
        let mut state = State::new(self.poses.iter().copied());
        for (i, &present) in self.present.iter().enumerate() {
            state.set_present(i, present);
        }
        state
    }

    /// The scene as it stands, checked.
    pub fn observed(&self) -> Outcome<Observed> {
        let (model, state) = (self.model()?, self.state());
        model.check_state(&state)?;
        Ok(Observed { model, state, bodies: self.bodies.clone() })
    }

    /// The problem of retrieving `target`, checked.
    pub fn problem(&self, target: jostle_body) -> Outcome<(Problem, Bodies)> {
        let target = self.bodies.index(target, "target")?;
        let Observed { model, state, bodies } = self.observed()?;
        Ok((Problem::new(self.name.clone(), model, state, target)?, bodies))
    }

    /// The problem of bringing every body to its goal, checked.
    pub fn rearrangement(&self) -> Outcome<(Rearrangement, Bodies)> {
        if self.goals.iter().all(Option::is_none) {
            return Err(Failure::argument("scene", "no body has a goal; set one with jostle_scene_set_goal"));
        }
        let Observed { model, state, bodies } = self.observed()?;
        Ok((Rearrangement::new(self.name.clone(), model, state, self.goals.clone())?, bodies))
    }

    /// The problem of taking everything off the table, checked. Goals do not matter to it.
    pub fn clearing(&self) -> Outcome<(Clearing, Bodies)> {
        let Observed { model, state, bodies } = self.observed()?;
        Ok((Clearing::new(self.name.clone(), model, state)?, bodies))
    }

    fn hash(&self) -> Outcome<u64> {
        let settings =
            (&self.defs, &self.gripper, &self.workspace, &self.friction, self.overlap_tolerance, &self.present);
        let text = serde_json::to_vec(&settings)
            .map_err(|e| Failure::from(Error::Internal(format!("a scene cannot be written: {e}"))))?;
        let mut h = 0xcbf2_9ce4_8422_2325u64;
        let mut mix = |byte: u8| h = (h ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        text.iter().for_each(|&byte| mix(byte));
        // Scenes without goals have the hashes they had before there were goals.
        if self.goals.iter().any(Option::is_some) {
            let goals = serde_json::to_vec(&self.goals)
                .map_err(|e| Failure::from(Error::Internal(format!("goals cannot be written: {e}"))))?;
            goals.iter().for_each(|&byte| mix(byte));
        }
        let stored = State::new(self.poses.iter().copied());
        for pose in (0..self.poses.len()).map(|body| stored.pose(body)) {
            // As states and files hold them: in single precision, headings within half a turn.
            for value in [pose.x, pose.y, pose.theta] {
                // Adding zero makes one of the two zeros.
                (value + 0.0).to_bits().to_le_bytes().iter().for_each(|&byte| mix(byte));
            }
        }
        Ok(h)
    }
}

pub(super) struct Scene {
    log: Arc<Log>,
    pub content: RwLock<Content>,
}

impl Scene {
    pub fn new(log: &Arc<Log>, content: Content) -> Scene {
        Scene { log: Arc::clone(log), content: RwLock::new(content) }
    }
}

impl Object for Scene {
    const KIND: Kind = Kind::Scene;
    type Handle = jostle_scene;
    fn log(&self) -> &Arc<Log> {
        &self.log
    }
}

/// Runs `body` with shared use of a scene.
pub(super) fn with(
    function: &'static str,
    scene: *const jostle_scene,
    body: impl FnOnce(&Content) -> Outcome,
) -> jostle_status {
    guard(function, |call| {
        let scene = call.open::<Scene>(scene, "scene")?;
        let content = guard::read(&scene.content, "scene")?;
        body(&content)
    })
}

/// Runs `body` with exclusive use of a scene.
pub(super) fn with_mut(
    function: &'static str,
    scene: *mut jostle_scene,
    body: impl FnOnce(&mut Content) -> Outcome,
) -> jostle_status {
    guard(function, |call| {
        let scene = call.open::<Scene>(scene, "scene")?;
        let mut content = guard::write(&scene.content, "scene")?;
        body(&mut content)
    })
}

/// Makes an empty scene: gripper robotiq_2f85, workspace of 0.448 m square centred at (0.5, 0).
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *scene and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null), HANDLE, MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_new(
    context: *const jostle_context,
    scene: *mut *mut jostle_scene,
) -> jostle_status {
    guard("jostle_scene_new", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(scene, "scene") }?;
        let context = call.open::<Context>(context, "context")?;
        out.give(Scene::new(&context.log, Content::new()))
    })
}

/// Makes a copy with a life of its own. Bodies have the same ids in both.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *copy and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED, MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_clone(scene: *const jostle_scene, copy: *mut *mut jostle_scene) -> jostle_status {
    guard("jostle_scene_clone", |call| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out_handle(copy, "copy") }?;
        let scene = call.open::<Scene>(scene, "scene")?;
        let content = guard::read(&scene.content, "scene")?.clone();
        out.give(Scene::new(&scene.log, content))
    })
}

/// Frees a scene. Planners, plans and simulators that were given it keep what they need.
///
/// Thread: any.
/// RT: no.
/// Nullable: scene (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_free(scene: *mut jostle_scene) {
    free::<Scene>("jostle_scene_free", scene, "scene", false);
}

/// Adds a body. Whether it overlaps others is checked when all are placed: by jostle_scene_check, jostle_scene_update
/// and whatever plans or simulates.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `def` and all it points to are copied.
/// Errors: ARGUMENT (null, a field of def: the message names it), HANDLE, BUSY, NOT_FOUND (def.block), POISONED,
/// ABI. On failure the scene is unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_add_body(
    scene: *mut jostle_scene,
    def: *const jostle_body_def,
    body: *mut jostle_body,
) -> jostle_status {
    with_mut("jostle_scene_add_body", scene, |content| {
        // SAFETY: the caller promises a definition that keeps its promises, and a writable place.
        let (out, mut new) = unsafe { (out(body, "body")?, read_def(def)?) };
        if content.defs.len() == MAX_BODIES {
            return Err(Failure::argument("scene", format!("holds {MAX_BODIES} bodies, the most it can")));
        }
        if new.def.name.is_empty() {
            new.def.name = format!("body {}", content.next - 1);
        }
        if content.defs.iter().any(|known| known.name == new.def.name) {
            return Err(Failure::argument("def.name", format!("`{}` is taken", new.def.name)));
        }
        out.set(content.push(new.def, new.pose, new.present));
        Ok(())
    })
}

/// Takes a body out of the scene for good; its id is not used again. (To say that a known body is not there for now,
/// use jostle_scene_set_present.)
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_remove_body(scene: *mut jostle_scene, body: jostle_body) -> jostle_status {
    with_mut("jostle_scene_remove_body", scene, |content| {
        let index = content.bodies.index(body, "body")?;
        content.bodies.0.remove(index);
        content.defs.remove(index);
        content.poses.remove(index);
        content.present.remove(index);
        content.goals.remove(index);
        content.changed();
        Ok(())
    })
}

/// Number of bodies, present or not.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_body_count(scene: *const jostle_scene, count: *mut usize) -> jostle_status {
    with("jostle_scene_body_count", scene, |content| {
        // SAFETY: the caller promises a writable place.
        unsafe { out(count, "count") }?.set(content.bodies.len());
        Ok(())
    })
}

/// The body with this name.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, not UTF-8), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_find_body(
    scene: *const jostle_scene,
    name: *const c_char,
    body: *mut jostle_body,
) -> jostle_status {
    with("jostle_scene_find_body", scene, |content| {
        // SAFETY: the caller promises text and a writable place.
        let (out, name) = unsafe { (out(body, "body")?, text(name, "name")?) };
        let index = content.defs.iter().position(|def| def.name == name).ok_or_else(|| {
            Failure::new(JOSTLE_ERROR_NOT_FOUND, format!("name: no body of the scene is named `{name}`"))
        })?;
        out.set(content.bodies.id(index));
        Ok(())
    })
}

/// Copies a body's name to `buffer`; `length` counts the closing zero. A null buffer of capacity 0 asks for the length.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, BUFFER (length was written), NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_body_name(
    scene: *const jostle_scene,
    body: jostle_body,
    buffer: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> jostle_status {
    with("jostle_scene_body_name", scene, |content| {
        let index = content.bodies.index(body, "body")?;
        // SAFETY: the caller promises room for `capacity` characters.
        unsafe { fill_text(buffer, capacity, length, &content.defs[index].name) }
    })
}

/// Places a body. For what a camera saw of many bodies use jostle_scene_update.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `pose` is copied.
/// Errors: ARGUMENT (null, not finite, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_pose(
    scene: *mut jostle_scene,
    body: jostle_body,
    pose: *const jostle_pose2,
) -> jostle_status {
    with_mut("jostle_scene_set_pose", scene, |content| {
        // SAFETY: the caller promises a readable pose.
        let to = self::pose(unsafe { read(pose, "pose") }?, "pose")?;
        let index = content.bodies.index(body, "body")?;
        content.poses[index] = to;
        Ok(())
    })
}

/// Where a body is.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_get_pose(
    scene: *const jostle_scene,
    body: jostle_body,
    pose: *mut jostle_pose2,
) -> jostle_status {
    with("jostle_scene_get_pose", scene, |content| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(pose, "pose") }?;
        out.set(content.poses[content.bodies.index(body, "body")?].into());
        Ok(())
    })
}

/// Says whether a body is there (1) or was taken away (0).
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (zero body, present not 0 or 1), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_set_present(
    scene: *mut jostle_scene,
    body: jostle_body,
    present: u32,
) -> jostle_status {
    with_mut("jostle_scene_set_present", scene, |content| {
        let present = boolean(present, "present")?;
        let index = content.bodies.index(body, "body")?;
        content.present[index] = present;
        Ok(())
    })
}

/// Writes 1 to *present if the body is there, else 0.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_get_present(
    scene: *const jostle_scene,
    body: jostle_body,
    present: *mut u32,
) -> jostle_status {
    with("jostle_scene_get_present", scene, |content| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(present, "present") }?;
        out.set(u32::from(content.present[content.bodies.index(body, "body")?]));
        Ok(())
    })
}

/// Takes over one observation of many bodies: all of it or, on failure, nothing. Bodies that are not listed stay as
/// they were. The result is checked: bodies may overlap by the overlap tolerance at most.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: poses (with count 0).
/// Owns: `poses` is copied.
/// Errors: ARGUMENT (null, not finite, zero body, a body listed twice, bodies that overlap: the message names the
/// index), HANDLE, BUSY, NOT_FOUND, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_update(
    scene: *mut jostle_scene,
    poses: *const jostle_body_pose,
    count: usize,
) -> jostle_status {
    with_mut("jostle_scene_update", scene, |content| {
        // SAFETY: the caller promises `count` readable poses.
        let given = unsafe { slice(poses, count, "poses") }?;
        let mut at = content.poses.clone();
        let mut present = content.present.clone();
        let mut seen = vec![None; content.bodies.len()];
        for (i, entry) in given.iter().enumerate() {
            let field = format!("poses[{i}]");
            let index = content.bodies.index(entry.body, &format!("{field}.body"))?;
            if let Some(first) = seen[index].replace(i) {
                return Err(Failure::argument(&field, format!("names the same body as poses[{first}]")));
            }
            at[index] = pose(entry.pose, &format!("{field}.pose"))?;
            present[index] = boolean(entry.present, &format!("{field}.present"))?;
        }
        if !content.defs.is_empty() {
            let model = content.model()?;
            let mut state = State::new(at.iter().copied());
            present.iter().enumerate().for_each(|(i, &there)| state.set_present(i, there));
            model.check_state(&state)?;
        }
        (content.poses, content.present) = (at, present);
        Ok(())
    })
}

/// Copies the poses of all bodies, in the order in which they were added.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUSY, BUFFER (count was written), POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_poses(
    scene: *const jostle_scene,
    buffer: *mut jostle_body_pose,
    capacity: usize,
    count: *mut usize,
) -> jostle_status {
    with("jostle_scene_poses", scene, |content| {
        let poses: Vec<jostle_body_pose> = (0..content.bodies.len())
            .map(|i| jostle_body_pose {
                body: content.bodies.id(i),
                pose: content.poses[i].into(),
                present: u32::from(content.present[i]),
                reserved: 0,
            })
            .collect();
        // SAFETY: the caller promises room for `capacity` poses.
        unsafe { fill(buffer, capacity, count, &poses) }
    })
}

/// Checks that the scene can be planned with: it has bodies, and none overlap by more than the tolerance.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (what is wrong, with the index of the pose), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_check(scene: *const jostle_scene) -> jostle_status {
    with("jostle_scene_check", scene, |content| content.observed().map(drop))
}

/// A hash of all that the scene holds: equal scenes have equal hashes, in every process of this version. Poses count as
/// files and plans hold them, in single precision, so what was written and read again has the same hash.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jostle_scene_hash(scene: *const jostle_scene, hash: *mut u64) -> jostle_status {
    with("jostle_scene_hash", scene, |content| {
        // SAFETY: the caller promises a writable place.
        let out = unsafe { out(hash, "hash") }?;
        out.set(content.hash()?);
        Ok(())
    })
}
