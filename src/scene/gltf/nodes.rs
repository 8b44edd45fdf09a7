//! The tree of nodes: which are in the scene, and where they stand.

use super::buffers::missing;
use super::json::{Node, Root};
use crate::scene::error::{SceneError, did_you_mean};
use crate::scene::model_file::{ModelFile, shown, some};
use crate::scene::notes::Reading;
use glam::{DAffine3, DMat4, DQuat, DVec3};

/// One node of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visit {
    /// Index of the node.
    pub node: usize,
    /// From its space to the file's.
    pub world: DAffine3,
    /// It is the wanted node or below it.
    pub wanted: bool,
}

/// All nodes of the default scene, or of the first, or without scenes all there are: parents before children, in the
/// file's order. `name` is the node that is wanted, with all below it.
pub fn walk(
    file: ModelFile,
    root: &Root,
    name: Option<&str>,
    reading: &mut Reading,
) -> Result<Vec<Visit>, SceneError> {
    let mut is_child = vec![false; root.nodes.len()];
    for node in &root.nodes {
        for &child in &node.children {
            *is_child.get_mut(child).ok_or_else(|| missing(file, "node", child, root.nodes.len()))? = true;
        }
    }
    let (mut roots, rest) = roots(file, root, &is_child, reading)?;
    // Some files list every node: those below another one come after it, and are then known.
    roots.extend(rest);
    let mut state = vec![State::New; root.nodes.len()];
    let mut visits = Vec::new();
    for &start in &roots {
        if state[start] == State::New {
            let mut walk = Walk { file, root, name, state: &mut state, visits: &mut visits };
            walk.from(start)?;
        }
    }
    if let Some(name) = name
        && !visits.iter().any(|v| v.wanted)
    {
        let names: Vec<&str> = visits.iter().filter_map(|v| root.nodes[v.node].name.as_deref()).collect();
        let remedy = match names.len() {
            0 => "remove `node`: the file's nodes have no names".to_owned(),
            _ => format!("use one of {}", some(&names)),
        };
        let near = shown(&did_you_mean(name, names.iter().copied()));
        return Err(file.error(format!("there is no node `{}`{near}", shown(name)), remedy));
    }
    Ok(visits)
}

/// The scene's roots that are no node's children, and those that are.
fn roots(
    file: ModelFile,
    root: &Root,
    is_child: &[bool],
    reading: &mut Reading,
) -> Result<(Vec<usize>, Vec<usize>), SceneError> {
    let index = root.scene.unwrap_or(0);
    let listed: Vec<usize> = match root.scenes.get(index) {
        Some(scene) => scene.nodes.clone(),
        None if root.scene.is_none() => {
            let message = "the file has no scene: all its nodes are read";
            file.assume(reading, 1, message, "export the model again, with a scene")?;
            (0..root.nodes.len()).filter(|i| !is_child[*i]).collect()
        }
        None => return Err(missing(file, "scene", index, root.scenes.len())),
    };
    if root.scenes.len() > 1 {
        let message = format!("the file has {} scenes: scene {index} is read", root.scenes.len());
        file.inform(reading, &message);
    }
    if let Some(wrong) = listed.iter().find(|i| **i >= root.nodes.len()) {
        return Err(missing(file, "node", *wrong, root.nodes.len()));
    }
    Ok(listed.into_iter().partition(|i| !is_child[*i]))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    New,
    /// On the way from a root to the node being visited.
    Open,
    Done,
}

/// What is left to do for a node.
enum Step {
    Enter { node: usize, above: DAffine3, wanted: bool },
    Leave(usize),
}

struct Walk<'w, 'a> {
    file: ModelFile<'a>,
    root: &'w Root,
    name: Option<&'w str>,
    state: &'w mut [State],
    visits: &'w mut Vec<Visit>,
}

impl Walk<'_, '_> {
    /// Visits `start` and all below it, without recursion: a file may be as deep as it likes.
    fn from(&mut self, start: usize) -> Result<(), SceneError> {
        let mut steps =
            vec![Step::Enter { node: start, above: DAffine3::IDENTITY, wanted: self.name.is_none() }];
        while let Some(step) = steps.pop() {
            let (index, above, wanted) = match step {
                Step::Enter { node, above, wanted } => (node, above, wanted),
                Step::Leave(node) => {
                    self.state[node] = State::Done;
                    continue;
                }
            };
            match self.state[index] {
                State::New => self.state[index] = State::Open,
                State::Open => {
                    return Err(self.file.error(
                        format!("{} is below itself: its children lead back to it", called(self.root, index)),
                        "take it out of its own descendants' `children`",
                    ));
                }
                State::Done => {
                    return Err(self.file.error(
                        format!("{} has two parents", called(self.root, index)),
                        "name each node in the `children` of one node only",
                    ));
                }
            }
            let node = &self.root.nodes[index];
            let world = above * local(self.file, self.root, index, node)?;
            let wanted = wanted || (self.name.is_some() && node.name.as_deref() == self.name);
            self.visits.push(Visit { node: index, world, wanted });
            steps.push(Step::Leave(index));
            let children = node.children.iter().rev();
            steps.extend(children.map(|&node| Step::Enter { node, above: world, wanted }));
        }
        Ok(())
    }
}

/// What messages call node `index`.
pub fn called(root: &Root, index: usize) -> String {
    match root.nodes[index].name.as_deref() {
        Some(name) => format!("node {index} `{}`", shown(name)),
        None => format!("node {index}"),
    }
}

/// From the node's space to its parent's.
fn local(file: ModelFile, root: &Root, index: usize, node: &Node) -> Result<DAffine3, SceneError> {
    let wrong = |message: &str| {
        file.error(format!("{}: {message}", called(root, index)), "correct the file, or export it again")
    };
    let affine = match node.matrix {
        Some(matrix) => {
            let bottom = [matrix[3], matrix[7], matrix[11], matrix[15]];
            if bottom != [0.0, 0.0, 0.0, 1.0] {
                return Err(wrong("the last row of its matrix is not 0 0 0 1"));
            }
            DAffine3::from_mat4(DMat4::from_cols_array(&matrix))
        }
        None => {
            let scale = node.scale.map_or(DVec3::ONE, DVec3::from_array);
            let translation = node.translation.map_or(DVec3::ZERO, DVec3::from_array);
            let rotation = match node.rotation.map(DQuat::from_array) {
                None => DQuat::IDENTITY,
                Some(q) if q.length_squared() > 0.0 && q.length_squared().is_finite() => q.normalize(),
                Some(_) => return Err(wrong("its rotation has length 0")),
            };
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        }
    };
    if affine.is_finite() { Ok(affine) } else { Err(wrong("its place is not finite")) }
}
