//! The trained networks that are part of the library (`models/`, feature `models`).

use super::kind::Kind;
use super::model::{LoadOptions, Model};
use crate::error::{Error, Result};

/// A network that was embedded when the library was built.
#[derive(Debug, Clone, Copy)]
pub struct Builtin {
    pub name: &'static str,
    /// [`Kind::id`] of its kind.
    pub kind: &'static str,
    pub sha256: &'static str,
    pub bytes: &'static [u8],
}

/// The built-in networks; none in a build without them.
pub const BUILTINS: &[Builtin] = include!(concat!(env!("OUT_DIR"), "/builtin.rs"));

impl Builtin {
    /// The built-in network with this name.
    pub fn find(name: &str) -> Result<&'static Builtin> {
        BUILTINS.iter().find(|builtin| builtin.name == name).ok_or_else(|| {
            let known: Vec<_> = BUILTINS.iter().map(|builtin| builtin.name).collect();
            let known =
                if known.is_empty() { "this build has none".into() } else { format!("known: {}", known.join(", ")) };
            Error::not_found("model", format!("no built-in network is named `{name}`; {known}"))
        })
    }
}

impl Model {
    /// Loads a built-in network.
    pub fn builtin(name: &str, options: &LoadOptions) -> Result<Model> {
        let builtin = Builtin::find(name)?;
        let options = LoadOptions { sha256: Some(builtin.sha256.into()), ..options.clone() };
        Model::from_bytes(builtin.name, builtin.bytes, Some(Kind::by_name(builtin.kind)?), &options)
    }

    /// Loads the built-in network of this name, or the file of this path if none is named so. `kind`: what it must be; any
    /// if absent.
    pub fn open(name_or_path: &str, kind: Option<Kind>, options: &LoadOptions) -> Result<Model> {
        match Builtin::find(name_or_path) {
            Ok(_) => {
                let model = Model::builtin(name_or_path, options)?;
                if let Some(kind) = kind {
                    model.expect(kind)?;
                }
                Ok(model)
            }
            // A name without a folder and an ending is meant as a built-in one.
            Err(error) if !name_or_path.contains(['/', '\\', '.']) && !std::path::Path::new(name_or_path).exists() => {
                Err(error)
            }
            Err(_) => Model::load(name_or_path, kind, options),
        }
    }
}
