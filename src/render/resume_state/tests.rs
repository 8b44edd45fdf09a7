use super::*;
use crate::report::{DeviceInfo, ProgramInfo};

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

fn state() -> ResumeState<Tiles> {
    let linear = (0..12u8).map(|i| [f32::from(i), -0.0, 1e-40]).collect();
    let finished = vec![Tile { x: 0, y: 0, width: 4, height: 1 }, Tile { x: 1, y: 1, width: 2, height: 1 }];
    let mut tally = Tally { samples: 12, ..Tally::default() };
    tally.passes.insert((1, 2), (3, 0.5));
    let tiles = Tiles::of(&Drawn { linear, finished, tally: tally.clone() }, identity().settings.region());
    ResumeState::new(identity(), TimeInfo::default(), tally, tiles)
}

fn bytes(state: &ResumeState<Tiles>) -> Vec<u8> {
    let mut bytes = Vec::new();
    state.write(&mut bytes).unwrap();
    bytes
}

fn read(bytes: &[u8]) -> io::Result<ResumeState<Tiles>> {
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
    assert_eq!(read, state());
    let (drawn, _) = read.into_drawn(&identity()).unwrap();
    let red: Vec<f32> = drawn.linear.iter().map(|p| p[0]).collect();
    assert_eq!(red, [0.0, 1.0, 2.0, 3.0, 0.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(drawn.linear[5][1].to_bits(), (-0.0f32).to_bits(), "every bit is kept");
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
    let cases = [
        sealed(&header.replace("\"width\":2", "\"width\":4"), &numbers),
        sealed(&header.replace("\"width\":2", "\"width\":4294967295"), &numbers),
        sealed(&header.replace("\"tiles\":[", "\"tile\":["), &numbers),
        sealed(&header, &numbers[12..]),
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
    let other = header.replace("\"kind\":\"tiles\"", "\"kind\":\"bounded\"");
    assert_ne!(other, header);
    let why = read(&sealed(&other, &numbers)).unwrap_err().to_string();
    assert!(why.contains("--error or --budget"), "{why}");
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
