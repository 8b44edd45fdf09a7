use super::*;
use crate::settings::sampler::pcg4d;
use glam::DVec3;

fn boxes(n: u32, spheres: u32, spread: f64) -> Vec<Item> {
    (0..n)
        .map(|i| {
            let h = pcg4d([i, 1, 2, 3]).map(|c| f64::from(c) / f64::from(u32::MAX) - 0.5);
            let lo = DVec3::new(h[0], h[1], h[2]) * spread;
            // Of very different sizes.
            let hi = lo + DVec3::splat(h[3].abs().powi(8) * 100.0);
            // As f32 holds them.
            let bounds = Bounds { lo: lo.as_vec3().as_dvec3(), hi: hi.as_vec3().as_dvec3() };
            Item { bounds, is_sphere: i < spheres }
        })
        .collect()
}

#[test]
fn sound_for_all_sizes() {
    for n in [0, 1, 2, 3, 5, 17, 100, 3000] {
        let items = boxes(n, n / 3, 1.0);
        build(&items, &Wanted::default()).validate(&items).unwrap();
    }
}

#[test]
fn coincident_and_clustered_items_stay_within_the_stack() {
    let same = vec![Item { bounds: Bounds::EMPTY.with(DVec3::ZERO), is_sphere: false }; 100_000];
    build(&same, &Wanted::default()).validate(&same).unwrap();
    // Each item half as far out as the last: SAH would peel them off one by one.
    let cluster: Vec<Item> = (0..500)
        .map(|i| Item {
            bounds: Bounds::of_sphere(DVec3::splat(2f64.powi(-i)), 2f64.powi(-i - 2)),
            is_sphere: true,
        })
        .collect();
    build(&cluster, &Wanted::default()).validate(&cluster).unwrap();
}

/// Boxes that defeat heuristics: flat, equal, denormal, huge, nested, in geometric progressions of
/// either kind, and all of them together.
#[test]
fn odd_boxes_stay_within_the_stack() {
    let item = |lo: DVec3, size: DVec3, i: usize| Item {
        bounds: Bounds { lo, hi: lo + size },
        is_sphere: i.is_multiple_of(3),
    };
    let row = |n: usize, f: &dyn Fn(usize) -> (DVec3, DVec3)| -> Vec<Item> {
        (0..n)
            .map(|i| {
                let (lo, size) = f(i);
                item(lo, size, i)
            })
            .collect()
    };
    let power = |i: usize| 2f64.powi(-(i as i32 % 1000));
    let sets: Vec<Vec<Item>> = vec![
        row(1000, &|i| (DVec3::X * power(i), DVec3::ZERO)),
        row(1000, &|i| (DVec3::splat(-power(i)), DVec3::splat(2.0 * power(i)))),
        row(700, &|i| (DVec3::splat(5.693442e-39 * (i % 7) as f64), DVec3::X * 5.693442e-39)),
        row(500, &|i| (DVec3::Y * 1e38 * (i % 2) as f64, DVec3::Z * 1e37)),
        row(4096, &|i| (DVec3::new((i % 16) as f64, (i / 16 % 16) as f64, (i / 256) as f64), DVec3::ZERO)),
        // One far from a great many at one place.
        row(50_000, &|i| (DVec3::X * if i == 0 { 1e30 } else { 0.0 }, DVec3::ZERO)),
        // Two places a denormal apart.
        row(333, &|i| (DVec3::X * if i % 2 == 0 { 0.0 } else { f64::from_bits(1) }, DVec3::ZERO)),
    ];
    let all: Vec<Item> = sets.concat();
    for items in sets.iter().chain([&all]) {
        let built = build(items, &Wanted::default());
        built.validate(items).unwrap();
        assert!(built.stack <= STACK_SIZE as usize, "{}", built.stack);
    }
}

#[test]
fn validate_catches_defects() {
    let items = boxes(300, 100, 1.0);
    let good = build(&items, &Wanted::default());
    let mut shrunk = good.clone();
    shrunk.nodes[0].hi_0[1] = shrunk.nodes[0].lo_0[1];
    assert!(shrunk.validate(&items).unwrap_err().contains("sticks out"));
    let mut lost = good.clone();
    lost.order[7] = lost.order[8];
    assert!(lost.validate(&items).is_err());
    let mut deep = good;
    deep.depth = 2;
    assert!(deep.validate(&items).unwrap_err().contains("deeper"));
}

/// Each bound of each present child one step inward: whatever sticks out then must be seen.
#[test]
fn a_step_too_tight_is_seen() {
    let items = boxes(300, 100, 1.0);
    let good = build(&items, &Wanted::default());
    good.validate(&items).unwrap();
    // Rounded outward, a bound lies less than a step outside what it holds.
    for axis in [0, 10, 20] {
        for node in 0..good.compressed.len() {
            for child in 0..8 {
                let mut tight = good.clone();
                let slot = &mut tight.compressed[node][child];
                if slot.link == crate::kernel::abi::NONE || slot.lo >> axis & 1023 == 1023 {
                    continue;
                }
                slot.lo += 1 << axis;
                let message = tight.validate(&items).unwrap_err();
                assert!(message.contains("sticks out"), "{message}");
                let mut tight = good.clone();
                let slot = &mut tight.compressed[node][child];
                if slot.hi >> axis & 1023 == 0 {
                    continue;
                }
                slot.hi -= 1 << axis;
                assert!(tight.validate(&items).is_err(), "node {node}, child {child}, axis {axis}");
            }
        }
    }
}

#[test]
fn either_form_alone_is_the_one_of_both() {
    let items = boxes(3000, 1000, 1.0);
    let [both, nodes, compressed] = [Forms::Both, Forms::Nodes, Forms::Compressed]
        .map(|forms| build(&items, &Wanted { forms, ..Wanted::default() }));
    [&both, &nodes, &compressed].iter().for_each(|b| b.validate(&items).unwrap());
    assert!(nodes.compressed.is_empty() && compressed.nodes.is_empty());
    assert!(both.nodes == nodes.nodes && both.compressed == compressed.compressed);
    assert!(both.order == nodes.order && both.order == compressed.order);
    // Of more children each, there are fewer.
    assert!(
        both.compressed.len() * 3 < both.nodes.len() * 2,
        "{} {}",
        both.compressed.len(),
        both.nodes.len()
    );
}

fn on_threads(count: usize, items: &[Item], wanted: &Wanted) -> Bvh {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
    pool.install(|| build(items, wanted))
}

#[test]
fn the_same_whatever_the_number_of_threads() {
    // Enough that bins are filled together, and that subtrees are parted.
    let items = boxes(150_000, 20_000, 1.0);
    for quality in Hierarchy::ALL {
        let wanted = Wanted { quality, ..Wanted::default() };
        let alone = on_threads(1, &items, &wanted);
        alone.validate(&items).unwrap();
        assert!(alone == on_threads(3, &items, &wanted), "{}", quality.name());
    }
}

#[test]
fn more_work_makes_better_trees() {
    let mut sums = [0.0; 2];
    for (count, spread) in [(3000, 1.0), (20_000, 1.0), (20_000, 0.05)] {
        let items = boxes(count, 0, spread);
        let cost = |quality| {
            let built = build(&items, &Wanted { quality, ..Wanted::default() });
            built.validate(&items).unwrap();
            let (nodes, primitives) = built.expected();
            nodes + primitives
        };
        sums.iter_mut().zip(Hierarchy::ALL.map(cost)).for_each(|(sum, cost)| *sum += cost);
    }
    let [balanced, best] = sums;
    assert!(best < balanced, "{best} {balanced}");
}

#[test]
fn a_cache_gives_back_what_was_built() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path(), 1 << 30);
    let items = boxes(5000, 700, 1.0);
    let wanted = Wanted::default();
    let built = build(&items, &wanted);
    let cached = Wanted { cache: Some(&cache), ..wanted };
    let only_file = || {
        let mut files = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().path());
        let file = files.next().unwrap();
        assert_eq!(files.next(), None);
        file
    };
    assert!(build(&items, &cached) == built, "cold");
    let file = only_file();
    let whole = std::fs::read(&file).unwrap();
    assert!(build(&items, &cached) == built, "warm");

    // Damaged anywhere, cut short or empty: built anew, and mended.
    let damages = (0..whole.len()).step_by(whole.len() / 40).map(|at| {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        bytes
    });
    let cut = [0, 11, 40, whole.len() - 1].map(|length| whole[..length].to_vec());
    for bytes in damages.chain(cut) {
        std::fs::write(&file, bytes).unwrap();
        assert!(build(&items, &cached) == built, "damaged");
        assert_eq!(std::fs::read(only_file()).unwrap(), whole);
    }

    // A name tells everything that a tree follows from.
    std::fs::remove_file(file).unwrap();
    let mut moved = items.clone();
    moved[4321].bounds.hi.x = 3.0;
    let others = [
        (&items, Wanted { quality: Hierarchy::Best, ..cached }),
        (&items, Wanted { outside: [false, true], ..cached }),
        (&items, Wanted { forms: Forms::Compressed, ..cached }),
        (&items, Wanted { forms: Forms::Nodes, ..cached }),
        (&moved, cached),
        (&items, cached),
    ];
    for (i, (items, wanted)) in others.iter().enumerate() {
        assert!(build(items, wanted) == build(items, &Wanted { cache: None, ..*wanted }), "{i}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), i + 1);
    }
}

/// Whatever happens to a file, the hierarchy is the one that is built without it, and the file is mended.
#[test]
fn no_bit_of_a_cached_file_changes_a_hierarchy() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::new(folder.path(), 1 << 30);
    let (items, others) = (boxes(9, 3, 1.0), boxes(9, 3, 0.9));
    let cached = Wanted { cache: Some(&cache), ..Wanted::default() };
    let files = || std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().path()).collect::<Vec<_>>();
    let built = build(&items, &cached);
    let file = files().remove(0);
    let whole = std::fs::read(&file).unwrap();
    for bit in 0..8 * whole.len() {
        let mut damaged = whole.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(&file, damaged).unwrap();
        assert!(build(&items, &cached) == built, "bit {bit}");
        assert!(std::fs::read(&file).unwrap() == whole, "bit {bit}");
    }
    // A whole file of as many other boxes under this name.
    build(&others, &cached);
    let other = files().into_iter().find(|f| *f != file).unwrap();
    std::fs::copy(&other, &file).unwrap();
    assert!(build(&items, &cached) == built, "of other boxes");
    assert!(std::fs::read(&file).unwrap() == whole);
    // No file at all, and one that cannot be replaced.
    std::fs::remove_file(&file).unwrap();
    std::fs::create_dir(&file).unwrap();
    assert!(build(&items, &cached) == built, "a folder");
}

#[test]
fn a_cache_keeps_what_was_used_last() {
    let folder = tempfile::tempdir().unwrap();
    let sets: Vec<Vec<Item>> = (0..4).map(|i| boxes(1000 + i, 0, 1.0)).collect();
    let files = || std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().path()).collect::<Vec<_>>();
    let roomy = Cache::new(folder.path(), u64::MAX);
    let build_in = |cache: &Cache, set: usize| {
        build(&sets[set], &Wanted { cache: Some(cache), ..Wanted::default() });
    };
    build_in(&roomy, 0);
    let first = files()[0].clone();
    let size = std::fs::metadata(&first).unwrap().len();
    build_in(&roomy, 1);
    let second = files().into_iter().find(|f| *f != first).unwrap();
    // Times of files may be coarse: an hour apart they are in order.
    let hours_ago = |file: &std::path::Path, hours: u64| {
        let time = std::time::SystemTime::now() - std::time::Duration::from_secs(3600 * hours);
        std::fs::File::open(file).unwrap().set_modified(time).unwrap();
    };
    hours_ago(&first, 2);
    hours_ago(&second, 1);
    // Used again, the first is the younger one.
    build_in(&roomy, 0);
    let tight = Cache::new(folder.path(), 2 * size + size / 2);
    build_in(&tight, 2);
    assert!(first.exists() && !second.exists());
    assert_eq!(files().len(), 2);
    // What is larger than the whole cache is not kept.
    build_in(&Cache::new(folder.path(), size / 2), 3);
    assert_eq!(files().len(), 2);
}
