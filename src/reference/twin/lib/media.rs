//! Twin of `glsl/lib/optics/media.glsl`. `list` is one ray's part of `media`.

/// Whether the ray is in `solid`.
pub fn is_inside(list: &[u32], solid: u32) -> bool {
    list.contains(&solid)
}

/// The solid whose matter the ray is in, leaving `without` aside; 0 = the surrounding space.
pub fn medium(list: &[u32], without: u32, priorities: &[i32]) -> u32 {
    let mut found = 0;
    for m in list {
        let outranks = || found == 0 || priorities[*m as usize] >= priorities[found as usize];
        if *m != 0 && *m != without && outranks() {
            found = *m;
        }
    }
    found
}
