//! The picture of `render --reference`.

use crate::cli::args::RenderArgs;
use crate::cli::failure::Failure;
use crate::image::Picture;
use crate::render::{Convergence, Observer};
use crate::report::ReferenceInfo;
use crate::settings::Settings;
use anyhow::{Context, anyhow};

/// A picture that the image is compared with on its way.
pub(super) struct Reference {
    file: String,
    picture: Picture,
}

impl Reference {
    /// The picture of the arguments, if there is one, checked to have the size of the image.
    pub(super) fn of(args: &RenderArgs, settings: &Settings) -> Result<Option<Reference>, Failure> {
        let Some(path) = &args.accuracy.reference else { return Ok(None) };
        let picture = Picture::read(path).context("--reference")?;
        let [x0, y0, x1, y1] = settings.region();
        let (width, height) = (x1 - x0, y1 - y0);
        if (picture.width, picture.height) != (width, height) {
            return Err(Failure::Other(anyhow!(
                "--reference {} has {}x{} pixels and the image {width}x{height}: render both at the same --size and --crop",
                path.display(),
                picture.width,
                picture.height,
            )));
        }
        Ok(Some(Reference { file: path.display().to_string(), picture }))
    }
}

/// Runs a render under `observer`, compared with `reference` if there is one. Gives its result and the comparison.
pub(super) fn compared<T>(
    reference: Option<&Reference>,
    observer: &mut dyn Observer,
    render: impl FnOnce(&mut dyn Observer) -> T,
) -> (T, Option<ReferenceInfo>) {
    let Some(Reference { file, picture }) = reference else { return (render(observer), None) };
    let mut convergence = Convergence::new(&picture.linear, observer);
    let result = render(&mut convergence);
    let info = ReferenceInfo { file: file.clone(), points: convergence.into_points() };
    (result, Some(info))
}
