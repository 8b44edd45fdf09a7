//! Why a command ended early, and with which exit code.

use crate::render::RenderError;

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
    /// Ctrl-C: 128 + SIGINT.
    Interrupted = 130,
}

impl Code {
    /// All codes in ascending order, each with its meaning as help, manual page and guide print it.
    pub const ALL: [(Code, &str); 9] = [
        (Code::Done, "done"),
        (Code::Failed, "failure"),
        (Code::Usage, "usage: the command line is wrong or cannot be carried out"),
        (Code::Scene, "the scene is wrong; the message names the place and a remedy"),
        (Code::NoDevice, "no suitable device"),
        (Code::DeviceLost, "the device was lost"),
        (Code::AboveThreshold, "compare: the difference is above --threshold"),
        (Code::Unmet, "render: --error or --time was not kept; the image is saved, the message says why"),
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
    /// The exit code of this failure.
    pub fn code(&self) -> Code {
        match self {
            Failure::Usage(_) => Code::Usage,
            Failure::Scene(_) => Code::Scene,
            Failure::Render(RenderError::NoDevice(_)) => Code::NoDevice,
            Failure::Render(RenderError::DeviceLost(_)) => Code::DeviceLost,
            Failure::AboveThreshold(_) => Code::AboveThreshold,
            Failure::Unmet(_) => Code::Unmet,
            Failure::Interrupted(_) => Code::Interrupted,
            Failure::Render(
                RenderError::DoesNotFit(_) | RenderError::Mismatch(_) | RenderError::Failed(_),
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

    #[test]
    fn the_table_lists_each_code_once_in_ascending_order() {
        let codes = Code::ALL.map(|(code, _)| code as u8);
        assert!(codes.windows(2).all(|pair| pair[0] < pair[1]), "{codes:?}");
    }
}
