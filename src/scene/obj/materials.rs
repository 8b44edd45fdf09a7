//! Which material faces have: `mtllib` and `usemtl`.

use crate::scene::beside;
use crate::scene::error::{SceneError, Source};
use crate::scene::library::{FileNumber, Library, Match};
use crate::scene::notes::Reading;
use crate::scene::tokens::{Word, Words};
use std::path::Path;

/// The material in use, and where those named are looked for.
pub(super) struct Materials<'a> {
    library: &'a mut Library,
    /// The scene's material for the whole mesh: the file's own are not looked at.
    whole: Option<usize>,
    /// That of the last `usemtl`.
    current: Option<usize>,
    /// The files named above.
    files: Vec<FileNumber>,
    /// All files that the text names, once they are asked for.
    everywhere: Option<Vec<FileNumber>>,
}

impl<'a> Materials<'a> {
    pub fn new(whole: Option<usize>, library: &'a mut Library) -> Materials<'a> {
        Materials { library, whole, current: whole, files: Vec::new(), everywhere: None }
    }

    /// The material of `count` triangles, the first of them of the face at byte `offset`.
    pub fn of_faces(
        &mut self,
        source: Source,
        offset: usize,
        object: &str,
        count: usize,
        reading: &mut Reading,
    ) -> Result<usize, SceneError> {
        if let Some(material) = self.current {
            return Ok(material);
        }
        if reading.strict {
            let remedy = "put `usemtl NAME` above it, or give `material` in the scene's [[mesh]]";
            return Err(source.error(offset, object, "a face without a material", remedy));
        }
        reading.count(
            source,
            offset,
            "triangles without a material get the default one, of diffuse 0.8",
            count,
        );
        Ok(self.library.default_material())
    }

    /// Follows the statement that `keyword` opens.
    pub fn statement(
        &mut self,
        words: &mut Words,
        keyword: Word,
        reading: &mut Reading,
    ) -> Result<(), SceneError> {
        match (self.whole, keyword.bytes) {
            (None, b"usemtl") => self.use_material(words, keyword, reading),
            (None, b"mtllib") => self.open(words, keyword, reading),
            _ => Ok(()),
        }
    }

    fn use_material(
        &mut self,
        words: &mut Words,
        keyword: Word,
        reading: &mut Reading,
    ) -> Result<(), SceneError> {
        let name = words.line().unwrap_or(Word { bytes: b"", offset: keyword.offset });
        if name.bytes.is_empty() && reading.strict {
            return Err(words.error(keyword.offset, "`usemtl` without a name", "write `usemtl NAME`"));
        }
        let mut found = self.library.find(&self.files, name.bytes, reading)?;
        if found.is_none() && !reading.strict {
            let files = self.everywhere(words.source, reading);
            found = self.library.find(&files, name.bytes, reading)?;
        }
        if let Some((material, how)) = found {
            if how == Match::OtherCase {
                reading.count(words.source, name.offset, "`usemtl` is followed in another letter case", 1);
            }
            self.current = Some(material);
            return Ok(());
        }
        if reading.strict {
            return Err(self.unknown(words, name));
        }
        let message =
            "`usemtl` names a material that no MTL file has: the default one, of diffuse 0.8, is used";
        reading.count(words.source, name.offset, message, 1);
        self.current = Some(self.library.default_material());
        Ok(())
    }

    fn unknown(&self, words: &Words, name: Word) -> SceneError {
        let (near, names) = self.library.proposals(&self.files, &name.text());
        let remedy = match names.as_str() {
            "" => "put `mtllib FILE.mtl` above it, or give `material` in the scene's [[mesh]]".to_owned(),
            names => format!("use one of {names}, or give `material` in the scene's [[mesh]]"),
        };
        words.error(
            name.offset,
            format!("no material `{}` in the MTL files named above{near}", name.text()),
            remedy,
        )
    }

    /// The files that any `mtllib` of the text names, where they can be read.
    fn everywhere(&mut self, source: Source, reading: &mut Reading) -> Vec<FileNumber> {
        if let Some(files) = &self.everywhere {
            return files.clone();
        }
        let mut words = Words::new(source, String::new());
        let mut files = Vec::new();
        while let Some(keyword) = words.keyword() {
            if keyword.bytes == b"mtllib" {
                for (_, path) in named(&mut words, true) {
                    // What is missing or wrong is said where the statement stands.
                    files.extend(path.and_then(|(path, _)| self.library.open(&path, reading).ok()));
                }
            }
            words.end_line();
        }
        self.everywhere = Some(files.clone());
        files
    }

    fn open(&mut self, words: &mut Words, keyword: Word, reading: &mut Reading) -> Result<(), SceneError> {
        let files = named(words, !reading.strict);
        if files.is_empty() {
            let (message, remedy) = ("`mtllib` without a file", "write `mtllib FILE.mtl`");
            return reading.assume(words.source, keyword.offset, &words.object, message, remedy);
        }
        for (name, path) in files {
            let Some((path, as_written)) = path else {
                if reading.strict {
                    let folder = words.source.file.parent().unwrap_or(Path::new(""));
                    return Err(words.error(
                        name.offset,
                        format!("there is no file `{}`", folder.join(name.text()).display()),
                        "correct the path (it starts at this file's folder), or give `material` in the [[mesh]]",
                    ));
                }
                reading.count(words.source, name.offset, "`mtllib` names a file that is missing", 1);
                continue;
            };
            if !as_written {
                let message = "`mtllib` is found by another letter case or folder than it says";
                reading.count(words.source, name.offset, message, 1);
            }
            let number = self.library.open(&path, reading)?;
            self.files.push(number);
        }
        Ok(())
    }
}

/// A file's name, and where it was found, as written or not.
type Named<'a> = (Word<'a>, Option<(std::path::PathBuf, bool)>);

/// The files that the rest of the line names: several, or one whose name holds blanks.
fn named<'a>(words: &mut Words<'a>, loosely: bool) -> Vec<Named<'a>> {
    let folder = words.source.file.parent().unwrap_or(Path::new(""));
    let Some(first) = words.word() else { return Vec::new() };
    let mut all = vec![first];
    while let Some(word) = words.word() {
        all.push(word);
    }
    let find = |word: Word<'a>| (word, beside::find(folder, word.bytes, loosely));
    if let [first, .., last] = all[..] {
        let bytes = &words.source.text[first.offset..last.offset + last.bytes.len()];
        let whole = find(Word { bytes, offset: first.offset });
        if whole.1.is_some() {
            return vec![whole];
        }
    }
    all.into_iter().map(find).collect()
}
