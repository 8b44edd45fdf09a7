//! An 8-bit sRGB raster with rectangles, pictures and text.

use super::text;

/// sRGB codes.
pub(crate) type Color = [u8; 3];

/// Rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Canvas {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) rgb: Vec<u8>,
}

impl Canvas {
    pub(crate) fn new(width: u32, height: u32, ground: Color) -> Canvas {
        let pixels = width as usize * height as usize;
        Canvas { width, height, rgb: ground.repeat(pixels) }
    }

    /// Fills a rectangle; what lies outside is dropped.
    pub(crate) fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], color: Color) {
        for row in y..y.saturating_add(height).min(self.height) {
            for column in x..x.saturating_add(width).min(self.width) {
                self.set([column, row], color);
            }
        }
    }

    /// Draws a frame of `border` pixels round a rectangle; what lies outside is dropped.
    pub(crate) fn outline(&mut self, corner: [u32; 2], size: [u32; 2], border: u32, color: Color) {
        let start = corner.map(|c| c.saturating_sub(border));
        let end = [0, 1].map(|axis| corner[axis].saturating_add(size[axis]).saturating_add(border));
        for row in start[1]..end[1].min(self.height) {
            for column in start[0]..end[0].min(self.width) {
                let inside = |at: u32, axis: usize| (corner[axis]..end[axis] - border).contains(&at);
                if !(inside(column, 0) && inside(row, 1)) {
                    self.set([column, row], color);
                }
            }
        }
    }

    /// A part of the picture; what lies outside is left out.
    pub(crate) fn cropped(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Canvas {
        let end = |start: u32, length: u32, whole: u32| start.saturating_add(length).min(whole);
        let (right, bottom) = (end(x, width, self.width), end(y, height, self.height));
        let pixels =
            (y..bottom).flat_map(|row| (x..right).filter_map(move |column| self.pixel([column, row])));
        let rgb = pixels.flatten().collect();
        Canvas { width: right.saturating_sub(x), height: bottom.saturating_sub(y), rgb }
    }

    /// Every pixel as a square of `factor` pixels a side.
    pub(crate) fn enlarged(&self, factor: u32) -> Canvas {
        let (width, height) = (self.width * factor, self.height * factor);
        let pixels =
            (0..height).flat_map(|y| (0..width).filter_map(move |x| self.pixel([x / factor, y / factor])));
        Canvas { width, height, rgb: pixels.flatten().collect() }
    }

    /// Copies a picture; what lies outside is dropped.
    pub(crate) fn paste(&mut self, [x, y]: [u32; 2], picture: &Canvas) {
        for (index, pixel) in (0u32..).zip(picture.rgb.as_chunks::<3>().0) {
            self.set([x + index % picture.width, y + index / picture.width], *pixel);
        }
    }

    /// One line of text: `at` is the top left corner of the line, `size` its height in pixels. What lies
    /// outside is dropped.
    pub(crate) fn text(&mut self, at: [u32; 2], text: &str, size: u32, color: Color) {
        text::draw(text, size, |x, y, coverage| {
            let [x, y] = [i64::from(at[0]) + i64::from(x), i64::from(at[1]) + i64::from(y)];
            let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
            if let Some(old) = self.pixel([x, y]) {
                let mix = |c| f32::from(old[c]) + coverage * (f32::from(color[c]) - f32::from(old[c]));
                self.set([x, y], [0, 1, 2].map(|c| mix(c).round() as u8));
            }
        });
    }

    /// The pixel at a place, if it is inside.
    pub(crate) fn pixel(&self, [x, y]: [u32; 2]) -> Option<Color> {
        let at = 3 * (y as usize * self.width as usize + x as usize);
        (x < self.width && y < self.height).then(|| [0, 1, 2].map(|c| self.rgb[at + c]))
    }

    fn set(&mut self, [x, y]: [u32; 2], color: Color) {
        if x < self.width && y < self.height {
            let at = 3 * (y as usize * self.width as usize + x as usize);
            self.rgb[at..at + 3].copy_from_slice(&color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(canvas: &Canvas) -> Vec<String> {
        let row =
            |row: &[u8]| row.as_chunks::<3>().0.iter().map(|p| if p[0] > 0 { '#' } else { '.' }).collect();
        canvas.rgb.chunks(3 * canvas.width as usize).map(row).collect()
    }

    #[test]
    fn text_takes_the_colour_and_blends_at_its_edges() {
        let mut canvas = Canvas::new(40, 40, [100; 3]);
        canvas.text([4, 0], "L", 40, [200; 3]);
        let codes: Vec<u8> = canvas.rgb.as_chunks::<3>().0.iter().map(|p| p[0]).collect();
        assert_eq!((codes.iter().min(), codes.iter().max()), (Some(&100), Some(&200)));
        assert!(codes.iter().any(|c| (101..200).contains(c)));
        // Nothing of it is left of its corner or above the line.
        assert!((0..40).all(|y| canvas.pixel([3, y]) == Some([100; 3])));
    }

    #[test]
    fn frames_and_parts_are_where_they_should_be() {
        let mut canvas = Canvas::new(6, 5, [0; 3]);
        canvas.outline([2, 2], [2, 1], 1, [9; 3]);
        assert_eq!(lit(&canvas), ["......", ".####.", ".#..#.", ".####.", "......"]);
        canvas.outline([0, 0], [1, 1], 1, [9; 3]);
        canvas.outline([5, 4], [u32::MAX; 2], 1, [9; 3]);
        assert_eq!(lit(&canvas), [".#....", "#####.", ".#..#.", ".#####", "....#."]);
        assert_eq!(lit(&canvas.cropped([3, 2], [2, 2])), [".#", "##"]);
        assert_eq!(lit(&canvas.cropped([4, 3], [u32::MAX, 9])), ["##", "#."]);
        assert!(canvas.cropped([7, 7], [1, 1]).rgb.is_empty());
        assert_eq!(lit(&canvas.cropped([4, 3], [2, 2]).enlarged(2)), ["####", "####", "##..", "##.."]);
    }

    #[test]
    fn drawing_is_cut_at_the_edges() {
        let mut canvas = Canvas::new(3, 2, [0; 3]);
        canvas.fill([2, 1], [9, u32::MAX], [1; 3]);
        canvas.paste([1, 1], &Canvas::new(5, 5, [1; 3]));
        canvas.text([1, 1], "wide", 24, [0; 3]);
        canvas.text([0, u32::MAX], "wide", 24, [0; 3]);
        assert_eq!(lit(&canvas)[0], "...");
        assert_eq!(canvas.rgb.len(), 18);
        assert_eq!(
            (canvas.pixel([2, 1]).is_some(), canvas.pixel([3, 1]), canvas.pixel([0, 2])),
            (true, None, None)
        );
    }
}
