//! OpenEXR: linear `f32`, every bit kept.

use super::metadata::Window;
use super::{Metadata, More, View};
use ::exr::error::Error;
use ::exr::meta::MetaData;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, IntegerBounds, Layer, LayerAttributes, Text, Vec2,
    WritableImage,
};
use std::io::{self, Cursor, Read, Write};

/// The pixels that an OpenEXR file holds, where they are a part of those that it is of: data and display window.
/// `None` for all others, and what is no such file.
pub(super) fn window(from: impl Read) -> Option<Window> {
    let meta = MetaData::read_from_buffered(from, false).ok()?;
    let header = meta.headers.first()?;
    let (display, at) = (header.shared_attributes.display_window, header.own_attributes.layer_position);
    let numbers = |v: Vec2<usize>| Some([u32::try_from(v.0).ok()?, u32::try_from(v.1).ok()?]);
    let offset = at - display.position;
    let at = [u32::try_from(offset.0).ok()?, u32::try_from(offset.1).ok()?];
    let window = Window { at, size: numbers(header.layer_size)?, full: numbers(display.size)? };
    (window.size != window.full && window.is_inside()).then_some(window)
}

/// Red, green, blue, multiplied by alpha as the format says, then alpha and the further channels.
pub(super) fn encode(
    view: View<'_>,
    more: &More<'_>,
    metadata: &Metadata,
    out: &mut dyn Write,
) -> io::Result<()> {
    let of = |c: usize| FlatSamples::F32(view.linear.iter().map(|pixel| pixel[c]).collect());
    let mut list: Vec<AnyChannel<FlatSamples>> =
        ["R", "G", "B"].iter().enumerate().map(|(c, name)| AnyChannel::new(*name, of(c))).collect();
    if let Some(alpha) = more.alpha {
        list.push(AnyChannel::new("A", FlatSamples::F32(alpha.to_vec())));
    }
    for (name, values) in &more.channels {
        list.push(AnyChannel::new(name.as_str(), FlatSamples::F32(values.clone())));
    }
    let attributes = LayerAttributes {
        // One standard attribute: the crate's table of own attributes is written in random order.
        comments: Some(utf8(&metadata.lines().join("\n"))),
        software_name: Some(utf8(env!("CARGO_PKG_NAME"))),
        ..LayerAttributes::default()
    };
    let size = (view.width as usize, view.height as usize);
    let pixels = AnyChannels::sort(list.into_iter().collect());
    let window = metadata.window().filter(|window| window.size == [view.width, view.height]);
    let mut layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, pixels);
    if let Some(Window { at: [x, y], .. }) = window {
        layer.attributes.layer_position = Vec2(x as i32, y as i32);
    }
    let mut image = Image::from_layer(layer);
    if let Some(Window { full: [width, height], .. }) = window {
        image.attributes.display_window = IntegerBounds::new((0, 0), (width as usize, height as usize));
    }

    // The format is written with seeks; a pipe has none.
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_unbuffered(&mut bytes).map_err(|error| match error {
        Error::Io(error) => error,
        other => io::Error::other(other),
    })?;
    out.write_all(bytes.get_ref())
}

/// The crate's own conversion is to Latin-1, and panics beyond it; the format says UTF-8.
fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}
