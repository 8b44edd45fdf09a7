//! How scene files are read.

use super::values::{self, Size};
use crate::scene::{Axis, ReadOptions};
use clap::Args;

/// How a scene and the files that it names are read.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadArgs {
    /// Refuse what files leave open or get wrong, instead of saying what is assumed
    #[arg(long)]
    pub strict: bool,

    /// Put VALUE where the scene's text has `${NAME}`; may be repeated
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = values::variable)]
    pub variables: Vec<(String, String)>,

    /// What points up in a model: x, y, z, -x, -y or -z; its own camera is then left out [default: z in PLY, STL and NFF, else y]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub up: Option<Axis>,
}

impl ReadArgs {
    /// As the reader takes them. A model read by itself is framed for `size`.
    pub fn options(&self, size: Option<Size>) -> ReadOptions {
        ReadOptions {
            strict: self.strict,
            variables: self.variables.clone(),
            up: self.up,
            size: size.map(|Size { width, height }| [width, height]),
        }
    }
}
