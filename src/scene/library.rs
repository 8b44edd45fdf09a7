//! The MTL files that meshes name, each read once; their materials join the scene when first used.

use super::error::{SceneError, Source, did_you_mean, list, unreadable};
use super::material::plain;
use super::mtl::{self, Textures, Written};
use super::notes::Reading;
use super::{Material, text, tokens};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The scene's materials and the MTL files behind some of them.
pub(super) struct Library {
    /// Materials in use; [`super::Face::material`] points here.
    pub materials: Vec<Material>,
    files: Vec<File>,
    by_path: HashMap<PathBuf, usize>,
    textures: Textures,
    /// Index of the material of faces that have none.
    default: Option<usize>,
}

/// One MTL file.
struct File {
    path: PathBuf,
    text: Vec<u8>,
    written: Vec<Written>,
    /// By name, as bytes.
    by_name: HashMap<Vec<u8>, usize>,
    /// By name without a comment, in small letters; of several the first.
    by_loose_name: HashMap<Vec<u8>, usize>,
    /// Index in the scene of those in use.
    in_scene: Vec<Option<usize>>,
}

/// An MTL file of a library.
pub(super) type FileNumber = usize;

/// How a name was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Match {
    /// As written.
    Exact,
    /// In other letter case.
    OtherCase,
}

/// `name` up to a comment.
fn without_comment(name: &[u8]) -> &[u8] {
    let comment = name.windows(2).position(|pair| pair[0].is_ascii_whitespace() && pair[1] == b'#');
    name[..comment.unwrap_or(name.len())].trim_ascii_end()
}

impl File {
    fn new(path: &Path, bytes: &[u8], reading: &mut Reading) -> Result<File, SceneError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let object = format!("material file `{name}`");
        let lines = text::lines(Source { file: path, text: bytes }, &object)?.into_owned();
        let written = mtl::read(Source { file: path, text: &lines }, &object, reading)?;
        let by_name = written.iter().enumerate().map(|(i, m)| (m.name.clone(), i)).collect();
        let mut by_loose_name = HashMap::new();
        for (i, m) in written.iter().enumerate() {
            by_loose_name.entry(without_comment(&m.name).to_ascii_lowercase()).or_insert(i);
        }
        let in_scene = vec![None; written.len()];
        Ok(File { path: path.to_owned(), text: lines, written, by_name, by_loose_name, in_scene })
    }

    fn find(&self, name: &[u8], loosely: bool) -> Option<(usize, Match)> {
        let short = without_comment(name);
        let exact = self.by_name.get(name).or_else(|| self.by_name.get(short));
        if let Some(i) = exact {
            return Some((*i, Match::Exact));
        }
        let i = *self.by_loose_name.get(&short.to_ascii_lowercase())?;
        let same_case = without_comment(&self.written[i].name) == short;
        (same_case || loosely).then_some((i, if same_case { Match::Exact } else { Match::OtherCase }))
    }
}

impl Library {
    /// A library that holds the scene text's own materials.
    pub fn new(materials: Vec<Material>) -> Library {
        Library {
            materials,
            files: Vec::new(),
            by_path: HashMap::new(),
            textures: Textures::default(),
            default: None,
        }
    }

    /// Reads an MTL file unless that is done.
    pub fn open(&mut self, path: &Path, reading: &mut Reading) -> Result<FileNumber, SceneError> {
        if let Some(number) = self.by_path.get(path) {
            return Ok(*number);
        }
        let bytes = std::fs::read(path).map_err(|e| unreadable(path, "material file", e))?;
        self.files.push(File::new(path, &bytes, reading)?);
        self.by_path.insert(path.to_owned(), self.files.len() - 1);
        Ok(self.files.len() - 1)
    }

    /// The MTL files read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| file.path.as_path())
    }

    /// Index of material `name` in the first of `files` that has it: as written, or else, unless the reading is strict, in
    /// other letter case.
    pub fn find(
        &mut self,
        files: &[FileNumber],
        name: &[u8],
        reading: &mut Reading,
    ) -> Result<Option<(usize, Match)>, SceneError> {
        let of = |loosely| files.iter().find_map(|f| Some((*f, self.files[*f].find(name, loosely)?)));
        let Some((number, (i, how))) = of(false).or_else(|| of(!reading.strict)) else { return Ok(None) };
        let file = &mut self.files[number];
        if let Some(index) = file.in_scene[i] {
            return Ok(Some((index, how)));
        }
        let source = Source { file: &file.path, text: &file.text };
        self.materials.push(file.written[i].material(source, &mut self.textures, reading)?);
        let index = self.materials.len() - 1;
        file.in_scene[i] = Some(index);
        Ok(Some((index, how)))
    }

    /// Index of the material of faces that have none.
    pub fn default_material(&mut self) -> usize {
        *self.default.get_or_insert_with(|| {
            self.materials.push(plain("default"));
            self.materials.len() - 1
        })
    }

    /// "; did you mean `x`?" and the list of names in `files`.
    pub fn proposals(&self, files: &[FileNumber], name: &str) -> (String, String) {
        let all = files.iter().flat_map(|f| &self.files[*f].written);
        let names: Vec<String> = all.map(|m| tokens::name(&m.name)).collect();
        let names = || names.iter().map(String::as_str);
        (did_you_mean(name, names()), list(names()))
    }
}
