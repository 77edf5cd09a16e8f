//! The kinds of networks and their interfaces: which tensors go in and come out.

use crate::error::{Error, Result};

/// What a network is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Motion of every body by a push (DIPN: deep interaction prediction network).
    Dipn,
    /// Value of each push (PPN: push prediction network).
    Ppn,
    /// Whether the target can be grasped (GC: grasp classifier).
    Gc,
    /// Quality of a grasp at every place and angle (GN: grasp network).
    Gn,
    /// Instances in a height image.
    Segmentation,
}

/// A dimension of a tensor as an interface asks for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// How many items a call has; must be symbolic.
    Batch,
    /// Bodies of a scene; must be symbolic.
    Objects,
    Fixed(usize),
    /// Side of the image: one number for all tensors.
    Side,
    /// Half the side.
    HalfSide,
    /// How many things were found; anything.
    Found,
    /// A picture's side that the file may leave open.
    Free,
}

/// A tensor that an interface has. All are 32-bit floats but for `integer` ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TensorSpec {
    pub name: &'static str,
    pub axes: &'static [Axis],
    /// A file may do without it.
    pub optional: bool,
    /// 64-bit integers.
    pub integer: bool,
}

const fn tensor(name: &'static str, axes: &'static [Axis]) -> TensorSpec {
    TensorSpec { name, axes, optional: false, integer: false }
}

use Axis::{Batch, Fixed, Found, Free, HalfSide, Objects, Side};

/// Points of an outline.
pub const OUTLINE_POINTS: usize = 32;
/// Closing directions of a grasp map, over half a turn.
pub const GRASP_ANGLES: usize = 16;

/// The inputs and outputs of a kind, in the order of the self-test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interface {
    pub kind: Kind,
    pub number: u32,
    pub inputs: &'static [TensorSpec],
    pub outputs: &'static [TensorSpec],
    /// Items that run side by side, in scenes of up to 64 bodies; fewer in larger ones. Every call of the runtime has
    /// exactly so many, so that an item's result does not depend on how many there are; what is missing is filled up with
    /// zeros.
    pub chunk: usize,
}

const OUTLINE: TensorSpec = tensor("outline", &[Batch, Objects, Fixed(OUTLINE_POINTS), Fixed(2)]);
const CENTRE: TensorSpec = tensor("centre", &[Batch, Objects, Fixed(2)]);
const BODY: TensorSpec = tensor("body", &[Batch, Objects, Fixed(4)]);
const PUSH: TensorSpec = tensor("push", &[Batch, Fixed(4)]);
const GUESS: TensorSpec = TensorSpec { optional: true, ..tensor("guess", &[Batch, Objects, Fixed(3)]) };
const PRESENT: TensorSpec = tensor("present", &[Batch, Objects]);
const TARGET: TensorSpec = tensor("target", &[Batch, Objects]);

/// Every interface that this version understands.
pub const INTERFACES: [Interface; 6] = [
    Interface {
        kind: Kind::Dipn,
        number: 1,
        inputs: &[OUTLINE, CENTRE, BODY, PUSH, GUESS, PRESENT],
        outputs: &[tensor("motion", &[Batch, Objects, Fixed(3)])],
        chunk: 4,
    },
    Interface {
        kind: Kind::Ppn,
        number: 1,
        inputs: &[OUTLINE, CENTRE, BODY, PUSH, PRESENT, TARGET],
        outputs: &[tensor("value", &[Batch])],
        chunk: 8,
    },
    Interface {
        kind: Kind::Gc,
        number: 1,
        inputs: &[tensor("image", &[Batch, Fixed(2), Side, Side])],
        outputs: &[tensor("probability", &[Batch])],
        chunk: 1,
    },
    Interface {
        kind: Kind::Gn,
        number: 1,
        inputs: &[tensor("image", &[Batch, Fixed(2), Side, Side])],
        outputs: &[tensor("quality", &[Batch, Fixed(GRASP_ANGLES), HalfSide, HalfSide])],
        chunk: 1,
    },
    Interface {
        kind: Kind::Segmentation,
        number: 1,
        inputs: &[tensor("image", &[Batch, Fixed(1), Side, Side])],
        outputs: &[
            tensor("foreground", &[Batch, Side, Side]),
            tensor("centre", &[Batch, Side, Side]),
            tensor("offset", &[Batch, Fixed(2), Side, Side]),
        ],
        chunk: 1,
    },
    // torchvision's detection models, exported with these names.
    Interface {
        kind: Kind::Segmentation,
        number: 2,
        inputs: &[tensor("image", &[Fixed(3), Free, Free])],
        outputs: &[
            tensor("boxes", &[Found, Fixed(4)]),
            TensorSpec { integer: true, ..tensor("labels", &[Found]) },
            tensor("scores", &[Found]),
            tensor("masks", &[Found, Fixed(1), Free, Free]),
        ],
        chunk: 1,
    },
];

impl Kind {
    pub const ALL: [Kind; 5] = [Kind::Dipn, Kind::Ppn, Kind::Gc, Kind::Gn, Kind::Segmentation];

    /// The name in a file's metadata.
    pub fn id(self) -> &'static str {
        match self {
            Kind::Dipn => "dipn",
            Kind::Ppn => "ppn",
            Kind::Gc => "gc",
            Kind::Gn => "gn",
            Kind::Segmentation => "segmentation",
        }
    }

    /// The kind with this name.
    pub fn by_name(name: &str) -> Result<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.id() == name).ok_or_else(|| {
            let known: Vec<_> = Kind::ALL.iter().map(|kind| kind.id()).collect();
            Error::not_found("kind", format!("no kind of network is named `{name}`; known: {}", known.join(", ")))
        })
    }

    /// The interfaces of the kind.
    pub fn interfaces(self) -> impl Iterator<Item = &'static Interface> {
        INTERFACES.iter().filter(move |interface| interface.kind == self)
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.id())
    }
}

impl TensorSpec {
    /// The tensor in words, such as `` `centre` float32[batch, num_objects, 2] ``.
    pub fn describe(&self, side: Option<usize>) -> String {
        let dims: Vec<_> = self
            .axes
            .iter()
            .map(|axis| match axis {
                Batch => "batch".into(),
                Objects => "num_objects".into(),
                Fixed(n) => n.to_string(),
                Side => side.map_or("S".into(), |s| s.to_string()),
                HalfSide => side.map_or("S/2".into(), |s| (s / 2).to_string()),
                Found => "found".into(),
                Free => "any".into(),
            })
            .collect();
        let dtype = if self.integer { "int64" } else { "float32" };
        format!("`{}` {dtype}[{}]", self.name, dims.join(", "))
    }
}
