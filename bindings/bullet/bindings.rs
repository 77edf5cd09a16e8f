/* Made by bindgen of shim.h; see tests/bullet_bindings.rs. */

pub mod jostle_bt_status {
    #[allow(unused_imports)]
    use super::*;
    pub type Type = ::std::os::raw::c_uint;
    pub const JOSTLE_BT_OK: Type = 0;
    pub const JOSTLE_BT_BAD_ARGUMENT: Type = 1;
    pub const JOSTLE_BT_NO_MEMORY: Type = 2;
    pub const JOSTLE_BT_EXCEPTION: Type = 3;
    pub const JOSTLE_BT_WRONG_LIBRARY: Type = 4;
}
pub mod jostle_bt_solver {
    #[allow(unused_imports)]
    use super::*;
    pub type Type = ::std::os::raw::c_uint;
    pub const JOSTLE_BT_SOLVER_BULLET: Type = 0;
    pub const JOSTLE_BT_SOLVER_COMPACT: Type = 1;
    pub const JOSTLE_BT_SOLVER_COMPACT_ROOT: Type = 2;
}
pub mod jostle_bt_ground {
    #[allow(unused_imports)]
    use super::*;
    pub type Type = ::std::os::raw::c_uint;
    pub const JOSTLE_BT_GROUND_BOX: Type = 0;
    pub const JOSTLE_BT_GROUND_PLANE: Type = 1;
}
#[repr(C)]
#[derive(Debug, Default, Copy, Clone)]
pub struct jostle_bt_settings {
    pub time_step: f64,
    pub gravity: f64,
    pub erp: f64,
    pub friction_erp: f64,
    pub linear_slop: f64,
    pub residual: f64,
    pub warm_start: f64,
    pub contact_processing: f64,
    pub margin: f64,
    pub ground_height: f64,
    pub ground_friction: f64,
    pub ground_restitution: f64,
    pub iterations: i32,
    pub solver: i32,
    pub ground: i32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of jostle_bt_settings"][::std::mem::size_of::<jostle_bt_settings>() - 112usize];
    ["Alignment of jostle_bt_settings"][::std::mem::align_of::<jostle_bt_settings>() - 8usize];
    ["Offset of field: jostle_bt_settings::time_step"][::std::mem::offset_of!(jostle_bt_settings, time_step) - 0usize];
    ["Offset of field: jostle_bt_settings::gravity"][::std::mem::offset_of!(jostle_bt_settings, gravity) - 8usize];
    ["Offset of field: jostle_bt_settings::erp"][::std::mem::offset_of!(jostle_bt_settings, erp) - 16usize];
    ["Offset of field: jostle_bt_settings::friction_erp"]
        [::std::mem::offset_of!(jostle_bt_settings, friction_erp) - 24usize];
    ["Offset of field: jostle_bt_settings::linear_slop"]
        [::std::mem::offset_of!(jostle_bt_settings, linear_slop) - 32usize];
    ["Offset of field: jostle_bt_settings::residual"][::std::mem::offset_of!(jostle_bt_settings, residual) - 40usize];
    ["Offset of field: jostle_bt_settings::warm_start"]
        [::std::mem::offset_of!(jostle_bt_settings, warm_start) - 48usize];
    ["Offset of field: jostle_bt_settings::contact_processing"]
        [::std::mem::offset_of!(jostle_bt_settings, contact_processing) - 56usize];
    ["Offset of field: jostle_bt_settings::margin"][::std::mem::offset_of!(jostle_bt_settings, margin) - 64usize];
    ["Offset of field: jostle_bt_settings::ground_height"]
        [::std::mem::offset_of!(jostle_bt_settings, ground_height) - 72usize];
    ["Offset of field: jostle_bt_settings::ground_friction"]
        [::std::mem::offset_of!(jostle_bt_settings, ground_friction) - 80usize];
    ["Offset of field: jostle_bt_settings::ground_restitution"]
        [::std::mem::offset_of!(jostle_bt_settings, ground_restitution) - 88usize];
    ["Offset of field: jostle_bt_settings::iterations"]
        [::std::mem::offset_of!(jostle_bt_settings, iterations) - 96usize];
    ["Offset of field: jostle_bt_settings::solver"][::std::mem::offset_of!(jostle_bt_settings, solver) - 100usize];
    ["Offset of field: jostle_bt_settings::ground"][::std::mem::offset_of!(jostle_bt_settings, ground) - 104usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct jostle_bt_body_def {
    pub mass: f64,
    pub inertia: [f64; 3usize],
    pub friction: f64,
    pub rolling_friction: f64,
    pub spinning_friction: f64,
    pub position: [f64; 3usize],
    pub rotation: [f64; 4usize],
    pub points: *const f64,
    pub piece_sizes: *const u32,
    pub piece_count: u32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of jostle_bt_body_def"][::std::mem::size_of::<jostle_bt_body_def>() - 136usize];
    ["Alignment of jostle_bt_body_def"][::std::mem::align_of::<jostle_bt_body_def>() - 8usize];
    ["Offset of field: jostle_bt_body_def::mass"][::std::mem::offset_of!(jostle_bt_body_def, mass) - 0usize];
    ["Offset of field: jostle_bt_body_def::inertia"][::std::mem::offset_of!(jostle_bt_body_def, inertia) - 8usize];
    ["Offset of field: jostle_bt_body_def::friction"][::std::mem::offset_of!(jostle_bt_body_def, friction) - 32usize];
    ["Offset of field: jostle_bt_body_def::rolling_friction"]
        [::std::mem::offset_of!(jostle_bt_body_def, rolling_friction) - 40usize];
    ["Offset of field: jostle_bt_body_def::spinning_friction"]
        [::std::mem::offset_of!(jostle_bt_body_def, spinning_friction) - 48usize];
    ["Offset of field: jostle_bt_body_def::position"][::std::mem::offset_of!(jostle_bt_body_def, position) - 56usize];
    ["Offset of field: jostle_bt_body_def::rotation"][::std::mem::offset_of!(jostle_bt_body_def, rotation) - 80usize];
    ["Offset of field: jostle_bt_body_def::points"][::std::mem::offset_of!(jostle_bt_body_def, points) - 112usize];
    ["Offset of field: jostle_bt_body_def::piece_sizes"]
        [::std::mem::offset_of!(jostle_bt_body_def, piece_sizes) - 120usize];
    ["Offset of field: jostle_bt_body_def::piece_count"]
        [::std::mem::offset_of!(jostle_bt_body_def, piece_count) - 128usize];
};
impl Default for jostle_bt_body_def {
    fn default() -> Self {
        let mut s = ::std::mem::MaybeUninit::<Self>::uninit();
        unsafe {
            ::std::ptr::write_bytes(s.as_mut_ptr(), 0, 1);
            s.assume_init()
        }
    }
}
#[repr(C)]
#[derive(Debug, Default, Copy, Clone)]
pub struct jostle_bt_box_def {
    pub half: [f64; 3usize],
    pub mass: f64,
    pub friction: f64,
    pub kinematic: i32,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of jostle_bt_box_def"][::std::mem::size_of::<jostle_bt_box_def>() - 48usize];
    ["Alignment of jostle_bt_box_def"][::std::mem::align_of::<jostle_bt_box_def>() - 8usize];
    ["Offset of field: jostle_bt_box_def::half"][::std::mem::offset_of!(jostle_bt_box_def, half) - 0usize];
    ["Offset of field: jostle_bt_box_def::mass"][::std::mem::offset_of!(jostle_bt_box_def, mass) - 24usize];
    ["Offset of field: jostle_bt_box_def::friction"][::std::mem::offset_of!(jostle_bt_box_def, friction) - 32usize];
    ["Offset of field: jostle_bt_box_def::kinematic"][::std::mem::offset_of!(jostle_bt_box_def, kinematic) - 40usize];
};
#[repr(C)]
#[derive(Debug, Default, Copy, Clone)]
pub struct jostle_bt_motion {
    pub position: [f64; 3usize],
    pub rotation: [f64; 4usize],
    pub linear: [f64; 3usize],
    pub angular: [f64; 3usize],
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of jostle_bt_motion"][::std::mem::size_of::<jostle_bt_motion>() - 104usize];
    ["Alignment of jostle_bt_motion"][::std::mem::align_of::<jostle_bt_motion>() - 8usize];
    ["Offset of field: jostle_bt_motion::position"][::std::mem::offset_of!(jostle_bt_motion, position) - 0usize];
    ["Offset of field: jostle_bt_motion::rotation"][::std::mem::offset_of!(jostle_bt_motion, rotation) - 24usize];
    ["Offset of field: jostle_bt_motion::linear"][::std::mem::offset_of!(jostle_bt_motion, linear) - 56usize];
    ["Offset of field: jostle_bt_motion::angular"][::std::mem::offset_of!(jostle_bt_motion, angular) - 80usize];
};
#[repr(C)]
#[derive(Debug)]
pub struct jostle_bt_world {
    _unused: [u8; 0],
}
unsafe extern "C" {
    pub fn jostle_bt_check(found: *mut ::std::os::raw::c_char, size: u32) -> jostle_bt_status::Type;
    pub fn jostle_bt_world_new(
        settings: *const jostle_bt_settings,
        out: *mut *mut jostle_bt_world,
    ) -> jostle_bt_status::Type;
    pub fn jostle_bt_world_free(world: *mut jostle_bt_world);
    pub fn jostle_bt_add_body(world: *mut jostle_bt_world, def: *const jostle_bt_body_def) -> jostle_bt_status::Type;
    pub fn jostle_bt_add_box(world: *mut jostle_bt_world, def: *const jostle_bt_box_def) -> jostle_bt_status::Type;
    pub fn jostle_bt_place_bodies(world: *mut jostle_bt_world) -> jostle_bt_status::Type;
    pub fn jostle_bt_box(
        world: *const jostle_bt_world,
        box_: u32,
        out: *mut jostle_bt_motion,
    ) -> jostle_bt_status::Type;
    pub fn jostle_bt_move_box(
        world: *mut jostle_bt_world,
        box_: u32,
        motion: *const jostle_bt_motion,
    ) -> jostle_bt_status::Type;
    pub fn jostle_bt_remove_box(world: *mut jostle_bt_world, box_: u32) -> jostle_bt_status::Type;
    pub fn jostle_bt_step(world: *mut jostle_bt_world) -> jostle_bt_status::Type;
    pub fn jostle_bt_body(
        world: *const jostle_bt_world,
        body: u32,
        out: *mut jostle_bt_motion,
    ) -> jostle_bt_status::Type;
    pub fn jostle_bt_contacts(
        world: *const jostle_bt_world,
        box_: u32,
        within: f64,
        touching: *mut u8,
        force: *mut f64,
        count: u32,
    ) -> jostle_bt_status::Type;
    pub fn jostle_bt_hull(
        points: *const f64,
        count: u32,
        margin: f64,
        out: *mut f64,
        capacity: u32,
        written: *mut u32,
    ) -> jostle_bt_status::Type;
}
