//! OpenEXR: linear `f32`, every bit kept.

use super::{Metadata, View};
use ::exr::error::Error;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Text, WritableImage,
};
use std::io::{self, Cursor, Write};

/// Red, green, blue, and `NAME.Y` for each further channel: a layer in the sense of the format.
pub(super) fn encode(
    view: View<'_>,
    channels: &[(&str, Vec<f32>)],
    metadata: &Metadata,
    out: &mut dyn Write,
) -> io::Result<()> {
    let of = |c: usize| FlatSamples::F32(view.linear.iter().map(|pixel| pixel[c]).collect());
    let mut list: Vec<AnyChannel<FlatSamples>> =
        ["R", "G", "B"].iter().enumerate().map(|(c, name)| AnyChannel::new(*name, of(c))).collect();
    for (name, values) in channels {
        list.push(AnyChannel::new(format!("{name}.Y").as_str(), FlatSamples::F32(values.clone())));
    }
    let attributes = LayerAttributes {
        // One standard attribute: the crate's table of own attributes is written in random order.
        comments: Some(utf8(&metadata.lines().join("\n"))),
        software_name: Some(utf8(env!("CARGO_PKG_NAME"))),
        ..LayerAttributes::default()
    };
    let size = (view.width as usize, view.height as usize);
    let pixels = AnyChannels::sort(list.into_iter().collect());
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, pixels);

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
