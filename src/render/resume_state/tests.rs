use super::*;
use crate::kernel::abi::Film;
use crate::plan::tiles::Tile;
use crate::render::film::Sums;
use crate::report::{DeviceInfo, ProgramInfo, Report};
use crate::settings::Share;

fn identity() -> Identity {
    let settings = SettingsInfo { width: 4, height: 3, samples: 2, depth: 1, ..SettingsInfo::default() };
    Identity {
        program: ProgramInfo::default(),
        device: DeviceInfo { name: "a".into(), ..DeviceInfo::default() },
        settings,
        request: String::new(),
        scene: "0".into(),
    }
}

/// Two rows of three, one of them with a single sample, and half a row with none.
fn state() -> ResumeState<Sums> {
    let mut sums = Sums::new(identity().settings.region(), 1, Share::WHOLE, Report::default());
    let film = |i: u8| Film { sum: [f32::from(i), -0.0, 1e-40], compensation: [0.25, 0.0, f32::from(i)] };
    let films: Vec<Film> = (0..4).map(film).collect();
    sums.set(&Tile { x: 0, y: 0, width: 4, height: 1 }, 2, &films);
    sums.set(&Tile { x: 1, y: 1, width: 2, height: 1 }, 1, &films[2..]);
    let mut tally = Tally { samples: 10, depths: vec![[10, 0, 0, 3]], ..Tally::default() };
    tally.passes.insert((1, 2), (3, 0.5));
    ResumeState::new(identity(), TimeInfo::default(), tally, sums)
}

fn bytes(state: &ResumeState<Sums>) -> Vec<u8> {
    let mut bytes = Vec::new();
    state.write(&mut bytes).unwrap();
    bytes
}

fn read(bytes: &[u8]) -> io::Result<ResumeState<Sums>> {
    ResumeState::read(&mut &bytes[..])
}

/// A file of `header` and `numbers` whose checksum is right.
fn sealed(header: &str, numbers: &[u8]) -> Vec<u8> {
    let content = [MAGIC, header.as_bytes(), b"\n", numbers].concat();
    [&content[..], &Sha256::digest(&content)[..]].concat()
}

/// Header and numbers of the file of [`state`].
fn parts() -> (String, Vec<u8>) {
    let whole = bytes(&state());
    let content = &whole[MAGIC.len()..whole.len() - CHECKSUM];
    let end = content.iter().position(|b| *b == b'\n').unwrap();
    (String::from_utf8(content[..end].to_vec()).unwrap(), content[end + 1..].to_vec())
}

#[test]
fn what_was_written_is_read() {
    let read = read(&bytes(&state())).unwrap();
    assert_eq!(bytes(&read), bytes(&state()), "every bit is kept");
    let red: Vec<f32> = read.payload.linear().iter().map(|p| p[0]).collect();
    assert_eq!(red, [0.125, 0.625, 1.125, 1.625, 0.0, 2.25, 3.25, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(read.payload.done(), 10);
    assert!(!read.is_finished());
    let (tile, samples) = (|x, y, width, height| Tile { x, y, width, height }, 2);
    let mut left = read.payload.left(samples, 4);
    left.reverse();
    assert_eq!(left[0], (tile(0, 1, 1, 1), 0));
    assert_eq!(left[1], (tile(1, 1, 1, 1), 1));
    assert_eq!(left.last(), Some(&(tile(0, 2, 4, 1), 0)));
    assert_eq!(left.iter().map(|(tile, _)| tile.pixels()).sum::<u32>(), 8);
}

/// One bit flipped anywhere, the end cut off anywhere, or more bytes.
#[test]
fn every_damage_is_an_error() {
    let good = bytes(&state());
    for at in 0..good.len() {
        let mut flipped = good.clone();
        flipped[at] ^= 1 << (at % 8);
        assert!(read(&flipped).is_err(), "byte {at}");
        assert!(read(&good[..at]).is_err(), "cut at {at}");
    }
    assert!(read(&[&good[..], &[0; 12]].concat()).is_err());
}

/// Files that this program does not write, with a checksum that is right all the same.
#[test]
fn what_does_not_fit_is_an_error() {
    let (header, numbers) = parts();
    assert!(read(&sealed(&header, &numbers)).is_ok());
    let edited = |from: &str, to: &str| {
        let other = header.replace(from, to);
        assert_ne!(other, header, "{from}");
        sealed(&other, &numbers)
    };
    let cases = [
        edited("\"width\":4", "\"width\":5"),
        edited("\"width\":4,\"height\":3", "\"width\":4294967295,\"height\":4294967295"),
        edited("\"samples\":2", "\"samples\":1"),
        edited("\"count\":1", "\"count\":0"),
        edited("\"count\":1", "\"count\":4294967295"),
        edited("\"sets\":1", "\"sets\":2"),
        edited("\"replicates\":0", "\"replicates\":4294967295"),
        edited("\"share\":{", "\"part\":{"),
        // A row that the pass table has not, one at a depth that none has, a time and counts beyond all reason.
        edited("[[1,2],", "[[1,99],"),
        edited("[[1,2],", "[[4000000000,2],"),
        edited("[3,0.5]", "[3,-0.5]"),
        edited("[3,0.5]", "[18446744073709551615,0.5]"),
        edited("[[10,0,0,3]]", "[[10,0,18446744073709551615,3]]"),
        edited("\"wall\":0.0", "\"wall\":-1.0"),
        sealed(&header, &numbers[24..]),
        // Runs: more than there are, of no pixels, of more than 2^32.
        sealed(&header, &[&[255; 4], &numbers[4..]].concat()),
        sealed(&header, &[&[0; 4], &numbers[4..]].concat()),
        sealed(&header, &[&numbers[..8], &[255; 4], &numbers[12..]].concat()),
        sealed(&header, &[&numbers[..], &[0; 12]].concat()),
        sealed("", &[]),
        [MAGIC, &Sha256::digest(MAGIC)[..]].concat(),
    ];
    for (i, case) in cases.iter().enumerate() {
        assert!(read(case).is_err(), "case {i}");
    }
}

#[test]
fn another_kind_is_told_by_its_header() {
    let (header, numbers) = parts();
    let other = header.replace("\"kind\":\"sums\"", "\"kind\":\"bounded\"");
    assert_ne!(other, header);
    let why = read(&sealed(&other, &numbers)).unwrap_err().to_string();
    assert!(why.contains("--error, --time or --budget"), "{why}");
}

#[test]
fn the_first_difference_is_named() {
    let mut now = identity();
    assert_eq!(identity().check(&now), Ok(()));
    let why = |now: &Identity| identity().check(now).unwrap_err().0;
    now.scene = "1".into();
    assert!(why(&now).contains("scene"), "{}", why(&now));
    now.device.driver = "newer".into();
    assert!(why(&now).contains("newer"), "{}", why(&now));
    now.settings.samples = 3;
    assert!(why(&now).contains("--samples 2") && why(&now).contains("--samples 3"), "{}", why(&now));
    now.request = "--error 0.1".into();
    assert!(why(&now).contains("--error 0.1"), "{}", why(&now));
    now.program.version = "9.9.9".into();
    assert!(why(&now).contains("9.9.9"), "{}", why(&now));
}

/// What a damaged file with a right checksum says must not be used, and must not be a panic either: bytes anywhere,
/// in the header too.
#[test]
fn no_forged_file_is_a_panic() {
    let (header, numbers) = parts();
    let content = [header.as_bytes(), b"\n", &numbers].concat();
    for at in 0..content.len() {
        for value in [0, b'9', b'-', 255] {
            let mut forged = content.clone();
            forged[at] = value;
            let forged = [MAGIC, &forged[..]].concat();
            if let Ok(state) = read(&[&forged[..], &Sha256::digest(&forged)[..]].concat()) {
                let (sums, mut tally, _) = state.clone().into_parts(&state.identity).unwrap();
                tally.add(&tally.clone());
                tally.fill(&mut Report::clone(&sums.outline));
                assert_eq!(sums.linear().len(), 12);
            }
        }
    }
}
