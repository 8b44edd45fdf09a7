//! How scenes and the files that they name are read.

/// How a scene is read; [`Scene::load_with`](super::Scene::load_with) takes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Whatever would be assumed with a note ([`Scene::notes`](super::Scene::notes)) is an error instead, and MTL's `Ka` is
    /// followed to the letter.
    pub strict: bool,
    /// Names and values: `${name}` in a scene's text stands for the value. Every name must occur there.
    pub variables: Vec<(String, String)>,
    /// Width and height in pixels for which a model that is read by itself is framed; those of its own camera, or
    /// 600 x 500, if absent. A scene's text has its own.
    pub size: Option<[u32; 2]>,
}
