//! Pixels for plotters, with text in the crate's own font.

use crate::image::text;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind};
use std::convert::Infallible;

/// 8-bit RGB rows.
pub(super) struct Raster<'a> {
    rgb: &'a mut [u8],
    width: u32,
    height: u32,
}

impl<'a> Raster<'a> {
    pub(super) fn new(rgb: &'a mut [u8], width: u32, height: u32) -> Raster<'a> {
        Raster { rgb, width, height }
    }
}

/// Height of a line of text in pixels, from plotters' font size: its own measure of widths, too.
fn line<S: BackendTextStyle>(style: &S) -> u32 {
    style.size().round().max(1.0) as u32
}

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for Raster<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done {
        if (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y) {
            let at = 3 * (y as usize * self.width as usize + x as usize);
            let (r, g, b) = color.rgb;
            for (old, new) in self.rgb[at..at + 3].iter_mut().zip([r, g, b]) {
                let mixed = f64::from(*old) * (1.0 - color.alpha) + f64::from(new) * color.alpha;
                *old = mixed.round() as u8;
            }
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        let size = line(style);
        let (width, height) = (text::width(text, size) as i32, size as i32);
        let dx = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let dy = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        let color = style.color();
        let mut done = Ok(());
        text::draw(text, size, |x, y, coverage| {
            let (x, y) = style.transform().transform(x + dx, y + dy);
            let color = BackendColor { alpha: color.alpha * f64::from(coverage), ..color };
            if done.is_ok() {
                done = self.draw_pixel((at.0 + x, at.1 + y), color);
            }
        });
        done
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let size = line(style);
        Ok((text::width(text, size), size))
    }
}
