//! Means of the textures that materials name, each picture decoded once.

use super::accessors::Accessors;
use super::buffers::resource;
use crate::scene::mean_color::{self, TextureMean};
use crate::scene::model_file::shown;
use std::collections::HashMap;

/// Means by picture; `None` for one that cannot be decoded.
#[derive(Default)]
pub struct Textures {
    known: HashMap<usize, Option<TextureMean>>,
    /// Why pictures could not be decoded.
    pub failures: Vec<String>,
}

impl Textures {
    /// The mean of texture `index`; `None`, and a line in `failures`, if it cannot be had.
    pub fn mean(&mut self, accessors: &mut Accessors, index: usize) -> Option<TextureMean> {
        let Some(image) = accessors.root.textures.get(index).and_then(|texture| texture.source) else {
            self.failures.push(format!("texture {index} has no picture of a format that is read"));
            return None;
        };
        if let Some(known) = self.known.get(&image) {
            return *known;
        }
        let mean = match picture(accessors, image) {
            Ok(mean) => Some(mean),
            Err(message) => {
                self.failures.push(format!("picture {image}: {}", shown(&message)));
                None
            }
        };
        self.known.insert(image, mean);
        mean
    }
}

fn picture(accessors: &mut Accessors, index: usize) -> Result<TextureMean, String> {
    let root = accessors.root;
    let Some(image) = root.images.get(index) else {
        return Err("the file has none of this number".to_owned());
    };
    if let Some(view) = image.buffer_view {
        let (bytes, _) = accessors.buffers.view(root, view).map_err(|e| e.message)?;
        return mean_color::of(bytes);
    }
    let uri = image.uri.as_deref().ok_or("it has neither `uri` nor `bufferView`")?;
    let bytes = resource(accessors.file, uri, None, "it").map_err(|e| e.message)?;
    mean_color::of(&bytes)
}
