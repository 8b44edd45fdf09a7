use super::*;
use std::time::Duration;

fn ms(zero: Instant, at: f64) -> Instant {
    zero + Duration::from_secs_f64(at / 1e3)
}

/// A frame of two submits whose device clock is 1000 s ahead, and a copy between them.
fn frame(zero: Instant, drift: f64) -> (Vec<Phase>, Vec<Submit>) {
    let pass = |kernel, begin: f64, length: f64| Dispatched {
        kernel,
        depth: 1,
        begin: Some(1000.0 + begin / 1e3),
        seconds: length / 1e3,
        items: Some(64),
        children: Some(0),
        samples: 64,
    };
    let submit = |begin, end, passes| Submit { begin: ms(zero, begin), end: ms(zero, end), passes };
    let phase =
        |name: &str, begin, end| Phase { name: name.into(), begin: ms(zero, begin), end: ms(zero, end) };
    let phases = vec![phase("parse scene", 0.0, 1.0), phase("frame", 1.0, 20.0), phase("render", 2.0, 19.0)];
    let first = vec![pass(Kernel::Generate, 3.5, 1.0), pass(Kernel::Intersect, 4.5, 2.25)];
    let second = vec![pass(Kernel::Generate, 13.5 + drift, 1.0), pass(Kernel::Intersect, 14.5 + drift, 2.0)];
    (phases, vec![submit(3.0, 7.0, first), submit(7.0, 8.0, vec![]), submit(13.0, 17.0, second)])
}

/// Complete events of a track in order of their beginnings, the longer first.
fn track(trace: &Value, tid: u32) -> Vec<(String, f64, f64)> {
    let mut events: Vec<_> = trace["traceEvents"]
        .as_array()
        .expect("events")
        .iter()
        .filter(|e| e["ph"] == "X" && e["tid"] == tid)
        .map(|e| {
            let (ts, dur) = (e["ts"].as_f64().expect("ts"), e["dur"].as_f64().expect("dur"));
            (e["name"].as_str().expect("a name").to_owned(), ts, ts + dur)
        })
        .collect();
    events.sort_by(|a, b| a.1.total_cmp(&b.1).then(b.2.total_cmp(&a.2)));
    events
}

/// Events that reach beyond the one they began in. A tenth of a nanosecond is the rounding of a
/// sum.
fn crossings(events: &[(String, f64, f64)]) -> usize {
    let mut open: Vec<f64> = Vec::new();
    let mut found = 0;
    for (_, begin, end) in events {
        while open.last().is_some_and(|last| *last <= begin + 1e-4) {
            open.pop();
        }
        found += usize::from(open.last().is_some_and(|last| *end > last + 1e-4));
        open.push(*end);
    }
    found
}

#[test]
fn events_nest_and_passes_lie_in_their_submits() {
    let zero = Instant::now();
    let (phases, submits) = frame(zero, 0.0);
    let value = trace(zero, "device", &phases, &submits, |d| d.items.map(|i| 60 * i));
    let text = serde_json::to_string(&value).unwrap();
    let back: Value = serde_json::from_str(&text).unwrap();
    let (host, device) = (track(&back, HOST), track(&back, DEVICE));
    assert_eq!((host.len(), device.len()), (6, 4));
    assert_eq!((crossings(&host), crossings(&device)), (0, 0));
    let names: Vec<&str> = device.iter().map(|e| e.0.as_str()).collect();
    assert_eq!(names, ["generate", "intersect", "generate", "intersect"]);
    // The true shift is -1000 s, and the submits leave +-0.25 to 0.5 ms around it: the second pass
    // begins where the first ends, in a submit from 3 to 7 ms.
    assert!((device[0].2 - device[1].1).abs() < 1e-3);
    assert!(device[0].1 >= 3000.0 && device[1].2 <= 7000.0, "{device:?}");
    assert!((device[0].1 - 3500.0).abs() <= 500.0);
    let first = value["traceEvents"].as_array().unwrap().iter().find(|e| e["name"] == "intersect").unwrap();
    assert_eq!((&first["args"]["items"], &first["args"]["bytes"]), (&64.into(), &3840.into()));
    assert!(value["otherData"]["device_clock_uncertainty_us"].as_f64().unwrap() <= 500.0);
}

#[test]
fn an_overlap_would_be_noticed() {
    let zero = Instant::now();
    let (mut phases, submits) = frame(zero, 0.0);
    phases.push(Phase { name: "crossing".into(), begin: ms(zero, 0.5), end: ms(zero, 1.5) });
    let value = trace(zero, "device", &phases, &submits, |_| None);
    assert!(crossings(&track(&value, HOST)) > 0);
}

#[test]
fn clocks_of_different_pace_are_aligned_submit_by_submit() {
    let zero = Instant::now();
    for (drift, whole) in [(0.0, true), (5.0, false)] {
        let (_, submits) = frame(zero, drift);
        let alignment = Alignment::of(zero, &submits);
        assert_eq!(matches!(alignment, Alignment::Whole(..)), whole);
        let value = trace(zero, "device", &[], &submits, |_| None);
        let device = track(&value, DEVICE);
        assert_eq!(crossings(&device), 0);
        assert!(device[2].1 >= 13_000.0 && device[3].2 <= 17_000.0, "{device:?}");
    }
}

#[test]
fn without_timestamps_passes_follow_each_other() {
    let zero = Instant::now();
    let (phases, mut submits) = frame(zero, 0.0);
    submits.iter_mut().flat_map(|s| &mut s.passes).for_each(|p| p.begin = None);
    let value = trace(zero, "device", &phases, &submits, |_| None);
    let device = track(&value, DEVICE);
    assert_eq!(crossings(&device), 0);
    assert!(device[0].1 >= 3000.0 && (device[0].2 - device[1].1).abs() < 1e-3 && device[1].2 <= 7000.0);
    assert!(value["otherData"]["device_clock_uncertainty_us"].is_null());
}
