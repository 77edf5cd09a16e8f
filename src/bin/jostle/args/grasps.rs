//! What `jostle grasps` is asked.

use std::path::PathBuf;

use clap::Args;

use super::{JsonArgs, ProfileArg};

#[derive(Debug, Args)]
pub struct GraspsArgs {
    /// A scene file (JSON) or an original test case (text)
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// The body, by its number from 0 or its name [default: the scene's target]
    #[arg(long, value_name = "BODY")]
    pub target: Option<String>,
    /// Most grasps to list; no two are alike: they are 10 mm apart (for the published gripper), or their closing directions
    /// 0.35 radians
    #[arg(long, default_value_t = 5, value_name = "K")]
    pub k: usize,
    /// Examine this grasp instead: metres, and radians from +x to the closing direction; may be given again
    #[arg(long, value_name = "X,Y,ANGLE", value_parser = parse_place, allow_hyphen_values = true)]
    pub at: Vec<[f64; 3]>,
    /// A gripper to take the place of the scene's: NAME, or NAME:FILE with the chance that it keeps a body
    #[arg(long, value_name = "NAME[:FILE]")]
    pub gripper: Option<String>,
    /// Conventions for an original test case
    #[arg(long, value_enum, default_value = "auto")]
    pub profile: ProfileArg,
    #[command(flatten)]
    pub json: JsonArgs,
    /// Draw the grasps into this file, a panel for each
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
}

fn parse_place(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let numbers = numbers.map_err(|e| format!("{e}; write X,Y,ANGLE as three numbers"))?;
    numbers.try_into().map_err(|n: Vec<f64>| format!("{} numbers; write X,Y,ANGLE as three", n.len()))
}
