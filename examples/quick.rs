//! quick
use whitted::{render::*, settings::*, scene};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let s = scene::load(a[1].as_ref()).unwrap();
    let mut set = Settings::of(&s);
    if let Some(n) = a.get(3) { set.samples = n.parse().unwrap(); }
    if let Some(n) = a.get(4) { set.depth = n.parse().unwrap(); }
    let mut r = Renderer::new(&DeviceChoice::Best, std::env::var("VALIDATE").is_ok()).unwrap();
    if let Ok(v) = std::env::var("BRUTE") { r.force_brute_force(Some(v == "1")); }
    let t = std::time::Instant::now();
    let out = r.render(&s, &set, &mut Quiet).unwrap();
    eprintln!("{:?}", t.elapsed());
    for m in r.validation_messages() { eprintln!("VAL {m}"); }
    eprintln!("{:#?} {:?} {:?} {:?}", out.report.time, out.report.rays, out.report.counters, out.report.plan);
    for p in &out.report.passes { eprintln!("{:10} {} {:4} {:.4} {:9} {:.1} ns/item", p.name, p.depth, p.launches, p.seconds, p.items, p.seconds*1e9/p.items as f64); }
    let b: Vec<u8> = out.linear.iter().flatten().map(|c| { let c = c.clamp(0.0, 1.0); let e = if c <= 0.0031308 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }; (e * 255.0 + 0.5) as u8 }).collect();
    image::save_buffer(&a[2], &b, out.width, out.height, image::ColorType::Rgb8).unwrap();
}
