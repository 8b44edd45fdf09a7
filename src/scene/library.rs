//! The MTL files that meshes name, each read once; their materials join the scene when first used.

use super::error::{SceneError, Source, did_you_mean, list, unreadable};
use super::{Material, mtl};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The scene's materials and the MTL files behind some of them.
pub(super) struct Library {
    /// Materials in use; [`super::Face::material`] points here.
    pub materials: Vec<Material>,
    files: HashMap<PathBuf, Vec<Material>>,
    used: HashMap<(PathBuf, String), usize>,
}

impl Library {
    /// A library that holds the scene text's own materials.
    pub fn new(materials: Vec<Material>) -> Library {
        Library { materials, files: HashMap::new(), used: HashMap::new() }
    }

    /// Reads an MTL file unless that is done.
    pub fn open(&mut self, path: &Path) -> Result<(), SceneError> {
        if !self.files.contains_key(path) {
            let text = std::fs::read(path).map_err(|e| unreadable(path, "material file", e))?;
            let materials = mtl::read(Source { file: path, text: &text })?;
            self.files.insert(path.to_owned(), materials);
        }
        Ok(())
    }

    /// The MTL files read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.keys().map(PathBuf::as_path)
    }

    /// Index of material `name` in the first of `files` that has it.
    pub fn find(&mut self, files: &[PathBuf], name: &str) -> Option<usize> {
        let (file, material) =
            files.iter().find_map(|f| Some((f, self.files.get(f)?.iter().find(|m| m.name == name)?)))?;
        let key = (file.clone(), name.to_owned());
        let index = *self.used.entry(key).or_insert_with(|| {
            self.materials.push(material.clone());
            self.materials.len() - 1
        });
        Some(index)
    }

    /// "; did you mean `x`?" and the list of names in `files`.
    pub fn proposals(&self, files: &[PathBuf], name: &str) -> (String, String) {
        let names = || files.iter().filter_map(|f| self.files.get(f)).flatten().map(|m| m.name.as_str());
        (did_you_mean(name, names()), list(names()))
    }
}
