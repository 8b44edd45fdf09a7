use super::*;

fn picture(width: u32, height: u32, bright: f32) -> Vec<[f32; 3]> {
    let at = |i: u32| [(i % width) as f32 / width as f32, (i / width) as f32 / height as f32, bright];
    (0..width * height).map(at).collect()
}

fn cell(width: u32, height: u32, bright: f32) -> Cell {
    let linear = picture(width, height, bright);
    let captions = ["4 samples, depth 4".into(), "12.3 M rays in 1.23 s".into()];
    Cell::new(View { width, height, linear: &linear }, captions)
}

fn sheet(width: u32, height: u32) -> Sheet {
    let section = |heading: &str, count: u8| Section {
        heading: heading.into(),
        cells: (0..count).map(|i| cell(width, height, f32::from(i) / 3.0)).collect(),
    };
    let mut sections = vec![
        section("Anti-aliasing: samples per pixel, at depth 4", 4),
        section("Depth: rays in the longest path, with 4 samples", 4),
        section("At the scenes' own settings", 1),
    ];
    sections[2].cells.push(cell(width.div_ceil(2), height.div_ceil(2), 0.8));
    Sheet {
        title: "cornell.toml".into(),
        subtitle: "whitted 0.1.0 on llvmpipe (LLVM 15.0.6, 256 bits)".into(),
        sections,
    }
}

#[test]
fn every_picture_is_on_the_sheet_pixel_by_pixel() {
    let sheet = sheet(300, 250);
    let canvas = sheet.draw();
    let row = 3 * canvas.width as usize;
    for cell in sheet.sections.iter().flat_map(|s| &s.cells) {
        let picture = &cell.picture;
        let line = 3 * picture.width as usize;
        let last = &picture.rgb[picture.rgb.len() - line..];
        let found = canvas.rgb.chunks(row).any(|r| r.windows(line).any(|w| w == last));
        assert!(found, "the last line of a picture is not on the sheet");
    }
}

#[test]
fn the_margin_is_clear_all_round() {
    for (width, height) in [(300, 250), (3, 2), (1, 1)] {
        let canvas = sheet(width, height).draw();
        let (w, h) = (canvas.width, canvas.height);
        let inside = |x: u32, y: u32| (20..w - 20).contains(&x) && (20..h - 20).contains(&y);
        for (i, pixel) in (0u32..).zip(canvas.rgb.as_chunks::<3>().0) {
            assert!(inside(i % w, i / w) || *pixel == GROUND, "{},{} of {w}x{h}", i % w, i / w);
        }
    }
}

#[test]
fn shrinking_takes_means_in_linear_light() {
    let linear = [[0.0; 3], [1.0; 3], [0.0; 3], [5.0; 3], [0.5; 3], [f32::NAN; 3]];
    let small = shrunk(View { width: 3, height: 2, linear: &linear }, 2);
    assert_eq!((small.width, small.height), (2, 1));
    // (0 + 1 + 1 + 0.5) / 4, and the column at the edge: NaN stays NaN, code 0.
    assert_eq!(small.rgb, [[code8(0.625); 3], [0; 3]].as_flattened());
    assert_eq!(cell(1281, 2, 0.0).picture.width, 427);
}

#[test]
fn a_sheet_is_a_png() {
    let mut bytes = Vec::new();
    sheet(60, 50).encode(&Metadata::default(), &mut bytes).unwrap();
    let image = ::image::load_from_memory(&bytes).unwrap();
    assert!(image.width() > 4 * 60 && image.height() > 3 * 50);
}
