use super::*;

fn identity() -> Identity {
    let settings = SettingsInfo { width: 4, height: 3, samples: 2, depth: 1, ..SettingsInfo::default() };
    Identity {
        program: ProgramInfo::default(),
        device: DeviceInfo { name: "a".into(), ..DeviceInfo::default() },
        settings,
        scene: "0".into(),
    }
}

fn unfinished() -> Unfinished {
    let linear = (0..12u8).map(|i| [f32::from(i), -0.0, 1e-40]).collect();
    let finished = vec![Tile { x: 0, y: 0, width: 4, height: 1 }, Tile { x: 1, y: 1, width: 2, height: 1 }];
    let mut tally = Tally { samples: 12, ..Tally::default() };
    tally.passes.insert((1, 2), (3, 0.5));
    Unfinished::new(identity(), TimeInfo::default(), &Drawn { linear, finished, tally })
}

fn bytes() -> Vec<u8> {
    let mut bytes = Vec::new();
    unfinished().write(&mut bytes).unwrap();
    bytes
}

#[test]
fn what_was_written_is_read() {
    let read = Unfinished::read(&mut bytes().as_slice()).unwrap();
    assert_eq!(read, unfinished());
    let (drawn, _) = read.into_drawn(&identity()).unwrap();
    let red: Vec<f32> = drawn.linear.iter().map(|p| p[0]).collect();
    assert_eq!(red, [0.0, 1.0, 2.0, 3.0, 0.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(drawn.linear[5][1].to_bits(), (-0.0f32).to_bits(), "every bit is kept");
}

#[test]
fn a_damaged_file_is_refused() {
    let good = bytes();
    let header = good.iter().position(|&b| b == b'\n').unwrap();
    let mut flipped = good.clone();
    flipped[header + 5] ^= 1;
    let text = String::from_utf8_lossy(&good[..header]).replace("\"width\":2", "\"width\":4");
    let outside = [text.as_bytes(), &good[header..]].concat();
    let longer = [&good[..], &[0; 12]].concat();
    let cases = [&good[..good.len() - 1], &good[..header / 2], &[], &flipped, &outside, &longer];
    for (i, mut case) in cases.into_iter().enumerate() {
        assert!(Unfinished::read(&mut case).is_err(), "case {i}");
    }
}

#[test]
fn each_difference_is_told() {
    let mut now = identity();
    assert_eq!(identity().check(&now), Ok(()));
    now.scene = "1".into();
    let why = |now: &Identity| identity().check(now).unwrap_err().0;
    assert!(why(&now).starts_with("the scene"), "{}", why(&now));
    now.device.driver = "newer".into();
    assert!(why(&now).contains("device a, , Vulkan , this one has a, newer"), "{}", why(&now));
    now.settings.samples = 3;
    assert!(why(&now).contains("--samples 2 --depth 1"), "{}", why(&now));
    now.program.version = "9.9.9".into();
    assert!(why(&now).contains("program"), "{}", why(&now));
}
