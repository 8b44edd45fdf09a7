//! Surface layers as pictures: numbers with a legend, directions and numbers of things as colours.

use crate::image::{Bits, Format, Metadata, View, code8, heat, png8};
use crate::render::SurfaceLayer;
use std::io;

/// A layer as a PNG.
pub struct SurfacePicture {
    /// Bytes of the file.
    pub png: Vec<u8>,
    /// Pixels, the legend included.
    pub size: [u32; 2],
    /// Quantity and unit.
    pub what: &'static str,
}

/// What a picture of the layer shows.
fn what(layer: SurfaceLayer) -> &'static str {
    match layer {
        SurfaceLayer::Z => "z: distance along the view, metres",
        SurfaceLayer::Normal => "normal: x, y, z from -1 to 1 as red, green, blue from 0 to 255",
        SurfaceLayer::Albedo => "albedo: diffuse colour",
        SurfaceLayer::Object => "object: a colour for each number, black for nothing",
        SurfaceLayer::Material => "material: a colour for each number, black for nothing",
    }
}

/// Paints rows of `width` pixels.
///
/// # Errors
/// If the picture cannot be encoded.
pub fn paint(
    layer: SurfaceLayer,
    values: &[[f32; 3]],
    width: u32,
    metadata: &Metadata,
) -> io::Result<SurfacePicture> {
    let height = (values.len() / width.max(1) as usize) as u32;
    let mut png = Vec::new();
    let mut codes = |of: &dyn Fn(&[f32; 3]) -> [u8; 3]| {
        let rgb: Vec<u8> = values.iter().flat_map(of).collect();
        png8(width, height, &rgb, metadata, &mut png)
    };
    let mut size = [width, height];
    match layer {
        SurfaceLayer::Z => {
            // What is nowhere has no distance.
            let number = |z: &[f32; 3]| if z[0].is_finite() { f64::from(z[0]) } else { f64::NAN };
            let numbers: Vec<f64> = values.iter().map(number).collect();
            let nearest = numbers.iter().copied().fold(f64::INFINITY, f64::min);
            let (_, farthest) = heat::Range::Auto.ends(&numbers);
            let range = heat::Range::Given(if nearest.is_finite() { nearest } else { 0.0 }, farthest);
            let painted = heat::paint(&numbers, width, range, what(layer));
            size = painted.size();
            painted.write(metadata, &mut png)?;
        }
        SurfaceLayer::Normal => codes(&|n| match n {
            [0.0, 0.0, 0.0] => [0; 3],
            _ => n.map(|x| (127.5 + 127.5 * x).round() as u8),
        })?,
        SurfaceLayer::Albedo => {
            let view = View { width, height, linear: values };
            Format::Png(Bits::Eight).encode(view, metadata, &mut png)?;
        }
        SurfaceLayer::Object | SurfaceLayer::Material => codes(&|n| color_of(n[0] as u32))?,
    }
    Ok(SurfacePicture { png, size, what: what(layer) })
}

/// A colour for a number: hues a golden angle apart, so that neighbours differ most; black for 0.
fn color_of(number: u32) -> [u8; 3] {
    if number == 0 {
        return [0; 3];
    }
    let hue = f64::from(number) * 0.618_033_988_749_894_9;
    let channel = |shift: f64| {
        let wave = (std::f64::consts::TAU * (hue + shift)).cos();
        code8((0.35 + 0.3 * wave) as f32)
    };
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(channel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn numbers_that_are_near_look_different() {
        let colors: HashSet<[u8; 3]> = (0..100).map(color_of).collect();
        assert_eq!(colors.len(), 100);
        let apart = |a: [u8; 3], b: [u8; 3]| (0..3).map(|i| a[i].abs_diff(b[i])).max();
        assert!((1..100).all(|n| apart(color_of(n), color_of(n + 1)) > Some(60)));
    }

    #[test]
    fn every_layer_is_painted() {
        let values = [[f32::INFINITY; 3], [0.0; 3], [0.5, -0.5, 1.0], [7.0; 3]];
        for layer in SurfaceLayer::ALL {
            let picture = paint(layer, &values, 2, &Metadata::default()).unwrap();
            assert!(picture.png.starts_with(b"\x89PNG"), "{}", layer.name());
            assert!(picture.what.starts_with(layer.name()) && picture.size[0] >= 2);
        }
    }
}
