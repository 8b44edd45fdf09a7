//! How scenes and the files that they name are read.

/// How a scene is read; [`Scene::load_with`](super::Scene::load_with) takes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Whatever would be assumed with a note ([`Scene::notes`](super::Scene::notes)) is an error instead, and MTL files are
    /// followed to the letter.
    pub strict: bool,
}
