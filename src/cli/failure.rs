//! Why a command ended early, and with which exit code.

use crate::render::RenderError;
use crate::scene::SceneError;
use std::error::Error;

/// Exit code of the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// What was asked for is done.
    Done = 0,
    /// A failure without a code of its own.
    Failed = 1,
    /// The command line cannot be carried out. clap exits with the same code.
    Usage = 2,
    /// The scene is wrong.
    Scene = 3,
    /// No device can render.
    NoDevice = 4,
    /// The device was lost.
    DeviceLost = 5,
    /// `compare --threshold`.
    AboveThreshold = 6,
    /// `render --error` or `--time`.
    Unmet = 7,
    /// A render with rays that were not finite or were lost.
    Unsound = 8,
    /// Ctrl-C: 128 + SIGINT.
    Interrupted = 130,
}

impl Code {
    /// All codes in ascending order, each with its meaning as help, manual page and guide print it.
    pub const ALL: [(Code, &str); 10] = [
        (Code::Done, "done"),
        (Code::Failed, "failure"),
        (Code::Usage, "usage: the command line is wrong or cannot be carried out"),
        (Code::Scene, "the scene is wrong; the message names the place and a remedy"),
        (Code::NoDevice, "no suitable device"),
        (Code::DeviceLost, "the device was lost"),
        (
            Code::AboveThreshold,
            "compare: the difference is above --threshold, or significant; or a picture of a folder has no partner. verify: the picture is another one",
        ),
        (
            Code::Unmet,
            "render: --error, --time or --budget could not be kept; the image is saved, the message says why",
        ),
        (
            Code::Unsound,
            "render: rays or pixels were not finite, or rays were lost; the image is saved and may be wrong",
        ),
        (Code::Interrupted, "interrupted; what was done is saved"),
    ];
}

/// Anything but success.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line asks for something that cannot be.
    #[error("{0}\n\nFor more information, try '--help'.")]
    Usage(String),
    /// The scene cannot be read or is wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The renderer gave up.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Two pictures differ by more than was allowed.
    #[error("{0}")]
    AboveThreshold(String),
    /// An error or a time that was asked for was not kept; says why and what was saved.
    #[error("{0}")]
    Unmet(String),
    /// The image may be wrong; says why and what was saved.
    #[error("{0}")]
    Unsound(String),
    /// Stopped by Ctrl-C; says what was saved.
    #[error("{0}")]
    Interrupted(String),
    /// Frames of a batch failed; each was reported when it did.
    #[error("{failed} of {of} frames failed, frame {frame} first")]
    Frames {
        /// Number of frames that failed.
        failed: usize,
        /// Number of frames.
        of: usize,
        /// The first that failed.
        frame: u32,
        /// What it failed with.
        code: Code,
    },
    /// Anything else.
    #[error(transparent)]
    Other(#[from] anyhow::Error),
}

impl Failure {
    /// The failure and its causes: on one line, or below a message of several lines.
    pub fn message(&self) -> String {
        let mut text = self.to_string();
        let joint = if text.contains('\n') { "\n  cause: " } else { ": " };
        let mut cause = self.source();
        while let Some(error) = cause {
            text = text + joint + &error.to_string();
            cause = error.source();
        }
        text
    }

    /// The exit code of this failure.
    pub fn code(&self) -> Code {
        match self {
            Failure::Usage(_) | Failure::Render(RenderError::Settings(_)) => Code::Usage,
            Failure::Scene(_) => Code::Scene,
            Failure::Render(RenderError::NoDevice(_) | RenderError::NoDouble { .. }) => Code::NoDevice,
            Failure::Render(RenderError::DeviceLost(_)) => Code::DeviceLost,
            Failure::AboveThreshold(_) => Code::AboveThreshold,
            Failure::Unmet(_) => Code::Unmet,
            Failure::Unsound(_) => Code::Unsound,
            Failure::Interrupted(_) | Failure::Render(RenderError::Interrupted(_)) => Code::Interrupted,
            Failure::Frames { code, .. } => *code,
            Failure::Render(
                RenderError::OutOfMemory(_)
                | RenderError::DoesNotFit(_)
                | RenderError::TooManyRays { .. }
                | RenderError::Mismatch(_)
                | RenderError::Vulkan(_),
            )
            | Failure::Other(_) => Code::Failed,
        }
    }

    /// [`Failure::code`] as a number.
    pub fn exit_code(&self) -> u8 {
        self.code() as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{PlanError, Shortage};
    use crate::scene::Scene;
    use crate::vk::VkError;
    use ash::vk;

    #[test]
    fn each_cause_has_its_code() {
        let text = String::from("x");
        let render = |error: VkError| Failure::from(RenderError::from(error));
        let call = VkError::Call { call: "vkX", object: text.clone(), result: vk::Result::NOT_READY };
        let shortage = Shortage { buffer: None, bytes: 2, limit: 1 };
        let cases = [
            (Failure::Other(anyhow::anyhow!("x")), 1),
            (render(call), 1),
            (RenderError::from(PlanError::RayTooLarge { shortage }).into(), 1),
            (Failure::Usage(text.clone()), 2),
            (Scene::load("none.toml").unwrap_err().into(), 3),
            (render(VkError::NoDevice(text.clone())), 4),
            (render(VkError::Interrupted { at: text.clone() }), 130),
            (RenderError::NoDouble { device: text.clone() }.into(), 4),
            (render(VkError::Lost { pass: text.clone() }), 5),
            (Failure::AboveThreshold(text.clone()), 6),
            (Failure::Unmet(text.clone()), 7),
            (Failure::Interrupted(text), 130),
        ];
        for (failure, code) in cases {
            assert_eq!(failure.exit_code(), code, "{failure:?}");
        }
    }

    #[test]
    fn causes_follow_the_message() {
        let why = Failure::from(anyhow::anyhow!("inner").context("middle").context("outer"));
        assert_eq!(why.message(), "outer: middle: inner");
        let scene = Failure::from(Scene::load("no/such.toml").unwrap_err()).message();
        let lines: Vec<&str> = scene.lines().collect();
        assert!(lines[0].starts_with("no/such.toml: scene") && lines[1].starts_with("  help: "), "{scene}");
        assert!(lines[2].starts_with("  cause: ") && lines.len() == 3, "{scene}");
    }

    #[test]
    fn the_table_lists_each_code_once_in_ascending_order() {
        let codes = Code::ALL.map(|(code, _)| code as u8);
        assert!(codes.windows(2).all(|pair| pair[0] < pair[1]), "{codes:?}");
    }
}
