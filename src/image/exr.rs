//! OpenEXR: linear `f32`, every bit kept.

use super::{Metadata, View};
use ::exr::error::Error;
use ::exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, Vec2, WritableImage};
use std::io::{self, Cursor, Write};

pub(super) fn encode(view: View<'_>, metadata: &Metadata, out: &mut dyn Write) -> io::Result<()> {
    let width = view.width as usize;
    let attributes = LayerAttributes {
        // One standard attribute: the crate's table of own attributes is written in random order.
        comments: Some(utf8(&metadata.lines().join("\n"))),
        software_name: Some(utf8(env!("CARGO_PKG_NAME"))),
        ..LayerAttributes::default()
    };
    let pixels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = view.linear[at.y() * width + at.x()];
        (r, g, b)
    });
    let layer = Layer::new((width, view.height as usize), attributes, Encoding::SMALL_LOSSLESS, pixels);

    // The format is written with seeks; a pipe has none.
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_unbuffered(&mut bytes).map_err(
        |error| match error {
            Error::Io(error) => error,
            other => io::Error::other(other),
        },
    )?;
    out.write_all(bytes.get_ref())
}

/// The crate's own conversion is to Latin-1, and panics beyond it; the format says UTF-8.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}
