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

/// Top left corners of all places of `canvas` that show `part`.
fn places(canvas: &Canvas, part: &Canvas) -> Vec<[u32; 2]> {
    let lines = |c: &Canvas| c.rgb.chunks(3 * c.width as usize).map(<[u8]>::to_vec).collect::<Vec<_>>();
    let (rows, wanted) = (lines(canvas), lines(part));
    let mut found = Vec::new();
    for (y, row) in rows.iter().enumerate().take(rows.len() + 1 - wanted.len()) {
        for x in 0..=(canvas.width - part.width) as usize {
            let fits = |(k, line): (usize, &Vec<u8>)| rows[y + k][3 * x..].starts_with(line);
            if row[3 * x..].starts_with(&wanted[0]) && wanted.iter().enumerate().all(fits) {
                found.push([x as u32, y as u32]);
            }
        }
    }
    found
}

#[test]
fn every_picture_is_on_the_sheet_as_large_as_the_others() {
    let sheet = sheet(300, 250);
    let canvas = sheet.draw();
    for cell in sheet.sections.iter().flat_map(|s| &s.cells) {
        let picture = &cell.picture;
        let shown = picture.enlarged(600 / picture.width);
        assert_eq!(shown.width, 600);
        // The last line: no frame of a part covers it all.
        let last = shown.cropped([0, shown.height - 1], [600, 1]);
        assert!(!places(&canvas, &last).is_empty(), "{} by {}", picture.width, picture.height);
    }
}

#[test]
fn every_picture_has_its_parts_below_it_framed_as_in_the_picture() {
    // Two of four pictures have a square each; nothing else differs.
    let (width, height) = (80, 60);
    let linear = |square: Option<u32>| -> Vec<[f32; 3]> {
        let inside = |at: u32, from: u32| (from..from + 4).contains(&at);
        let is = |i: u32| square.is_some_and(|s| inside(i % width, s) && inside(i / width, s / 2));
        let pixel = |(i, p): (u32, [f32; 3])| if is(i) { [1.0, 0.0, 1.0] } else { p };
        (0..).zip(picture(width, height, 0.5)).map(pixel).collect()
    };
    let cell = |(samples, square): (u32, Option<u32>)| {
        let linear = linear(square);
        let captions = [format!("{samples} samples"), String::new()];
        Cell::new(View { width, height, linear: &linear }, captions)
    };
    let cells: Vec<Cell> = [(1, None), (2, None), (4, Some(10)), (8, Some(60))].map(cell).into();
    let section = Section { heading: "h".into(), cells };
    let row = Row::new(&section, 640);
    // From the third to the fourth both squares change, either is a window; the other is then the
    // one of the pair before, if it changes there.
    let corners: Vec<[u32; 2]> = row.parts.iter().map(|p| p.window.corner).collect();
    let size = row.parts[0].window.size;
    // Shown 8 times, enlarged 4 times more: two parts and the gap between them fit in 640 pixels. 9 * 60 / 80, up.
    assert_eq!(size, [9, 7]);
    let holds = |corner: [u32; 2], square: u32| {
        let spans = |axis: usize, at: u32| corner[axis] <= at && at + 4 <= corner[axis] + size[axis];
        spans(0, square) && spans(1, square / 2)
    };
    assert!(corners.iter().any(|c| holds(*c, 10)), "{corners:?}");
    assert_eq!(row.legend()[0].0, "×4: where “4 samples” and “8 samples” differ most");
    let sheet = Sheet { title: String::new(), subtitle: String::new(), sections: vec![section.clone()] };
    let canvas = sheet.draw();
    for (part, color) in row.parts.iter().zip(PARTS) {
        for (i, cell) in section.cells.iter().enumerate() {
            let enlarged = cell.picture.cropped(part.window.corner, part.window.size).enlarged(8 * ENLARGED);
            let found = places(&canvas, &enlarged);
            let column = MARGIN + i as u32 * (640 + GAP)..MARGIN + i as u32 * (640 + GAP) + 640;
            let here: Vec<_> = found.iter().filter(|[x, _]| column.contains(x)).collect();
            let [[x, y]] = here[..] else { panic!("picture {i}: {found:?}") };
            assert_eq!(canvas.pixel([x - 1, y - 1]), Some(color));
            assert_eq!(canvas.pixel([x + enlarged.width, y + enlarged.height]), Some(color));
        }
    }
}

#[test]
fn the_margin_is_clear_all_round() {
    let long = |mut sheet: Sheet| {
        let caption = &mut sheet.sections[0].cells[3].captions[1];
        *caption = "a caption that is much wider than its picture and than the others, too".into();
        sheet
    };
    for (width, height) in [(300, 250), (3, 2), (1, 1)] {
        for sheet in [sheet(width, height), long(sheet(width, height))] {
            let canvas = sheet.draw();
            let (w, h) = (canvas.width, canvas.height);
            let inside = |x: u32, y: u32| (20..w - 20).contains(&x) && (20..h - 20).contains(&y);
            for (i, pixel) in (0u32..).zip(canvas.rgb.as_chunks::<3>().0) {
                assert!(inside(i % w, i / w) || *pixel == GROUND, "{},{} of {w}x{h}", i % w, i / w);
            }
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
