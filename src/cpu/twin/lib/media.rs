//! Twin of `glsl/lib/media.glsl`. `list` is one ray's part of `media`.

/// Whether the ray is in `solid`.
pub fn is_inside(list: &[u32], solid: u32) -> bool {
    list.contains(&solid)
}

/// The last solid entered, leaving `without` aside; 0 = none.
pub fn innermost(list: &[u32], without: u32) -> u32 {
    let mut found = 0;
    for m in list {
        if *m != 0 && *m != without {
            found = *m;
        }
    }
    found
}
