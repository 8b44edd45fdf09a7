//! Why a command ended early, and with which exit code.

use crate::cli::progress;
use crate::render::RenderError;
use crate::scene::SceneError;
use std::error::Error;

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
    /// Stopped by Ctrl-C; says what was saved.
    #[error("{0}")]
    Interrupted(String),
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

    /// 1 failure, 2 usage, 3 scene, 4 no suitable device, 5 device lost, 6 above the threshold, 7 error or time
    /// not kept, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Usage(_) => 2,
            Failure::Scene(_) => 3,
            Failure::Render(RenderError::NoDevice(_) | RenderError::NoDouble { .. }) => 4,
            Failure::Render(RenderError::DeviceLost(_)) => 5,
            Failure::AboveThreshold(_) => 6,
            Failure::Unmet(_) => 7,
            Failure::Interrupted(_) => progress::INTERRUPTED,
            Failure::Render(
                RenderError::OutOfMemory(_)
                | RenderError::DoesNotFit(_)
                | RenderError::TooManyRays { .. }
                | RenderError::OneSample
                | RenderError::Mismatch(_)
                | RenderError::Vulkan(_),
            )
            | Failure::Other(_) => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::PlanError;
    use crate::scene::Scene;
    use crate::vk::VkError;
    use ash::vk;

    #[test]
    fn each_cause_has_its_code() {
        let text = String::from("x");
        let render = |error: VkError| Failure::from(RenderError::from(error));
        let call = VkError::Call { call: "vkX", object: text.clone(), result: vk::Result::NOT_READY };
        let cases = [
            (Failure::Other(anyhow::anyhow!("x")), 1),
            (render(call), 1),
            (RenderError::from(PlanError::TooManyToTry { primitives: 2, limit: 1 }).into(), 1),
            (Failure::Usage(text.clone()), 2),
            (Scene::load("none.toml").unwrap_err().into(), 3),
            (render(VkError::NoDevice(text.clone())), 4),
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
}
