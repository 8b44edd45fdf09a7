//! Why a command ended early, and with which exit code.

use crate::cli::progress;
use crate::render::RenderError;

/// Anything but success.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line asks for something that cannot be.
    #[error("{0}\n\nFor more information, try '--help'.")]
    Usage(String),
    /// The scene cannot be read or is wrong.
    #[error("{0}")]
    Scene(String),
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
    #[error("{0:#}")]
    Other(#[from] anyhow::Error),
}

impl Failure {
    /// 1 failure, 2 usage, 3 scene, 4 no suitable device, 5 device lost, 6 above the threshold, 7 error or time
    /// not kept, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Usage(_) => 2,
            Failure::Scene(_) => 3,
            Failure::Render(RenderError::NoDevice(_)) => 4,
            Failure::Render(RenderError::DeviceLost(_)) => 5,
            Failure::AboveThreshold(_) => 6,
            Failure::Unmet(_) => 7,
            Failure::Interrupted(_) => progress::INTERRUPTED,
            Failure::Render(
                RenderError::DoesNotFit(_) | RenderError::Mismatch(_) | RenderError::Failed(_),
            )
            | Failure::Other(_) => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_has_its_code() {
        let text = String::from("x");
        let cases = [
            (Failure::Other(anyhow::anyhow!("x")), 1),
            (RenderError::Failed(text.clone()).into(), 1),
            (RenderError::DoesNotFit(text.clone()).into(), 1),
            (Failure::Usage(text.clone()), 2),
            (Failure::Scene(text.clone()), 3),
            (RenderError::NoDevice(text.clone()).into(), 4),
            (RenderError::DeviceLost(text.clone()).into(), 5),
            (Failure::AboveThreshold(text.clone()), 6),
            (Failure::Unmet(text.clone()), 7),
            (Failure::Interrupted(text), 130),
        ];
        for (failure, code) in cases {
            assert_eq!(failure.exit_code(), code, "{failure:?}");
        }
    }
}
