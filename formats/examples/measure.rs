use lodc_formats::lods::{PackOptions, Quantize, Unpacker, pack};
use lodc_formats::{Limits, lodc};
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let q = Quantize { position: Some(14), normal: Some(10), uv: Some(12) };
    for path in &a[2..] {
        let file = lodc::read(&std::fs::read(path).unwrap(), &[]).unwrap();
        let name = path.rsplit('/').next().unwrap().trim_end_matches(".lodc");
        let (mut v, mut t) = (0, 0);
        for o in &file.objects {
            let m = o.simplified.mesh();
            let mut used = vec![false; m.vertex_count()];
            for &x in m.triangles().as_flattened() { used[x as usize] = true; }
            v += used.iter().filter(|u| **u).count();
            t += m.triangles().len();
        }
        let mut line = format!("{name:16} {v:7} {t:7}");
        for kind in a[1].split(',') {
            let options = PackOptions {
                quantize: if kind.contains('q') { q } else { Quantize::default() },
                exact: kind.contains('e'),
                ..PackOptions::default()
            };
            let start = Instant::now();
            let packed = pack(&file, &options).unwrap();
            let enc = start.elapsed().as_secs_f64();
            let mut best = f64::MAX;
            for _ in 0..if kind.contains('t') { 5 } else { 1 } {
                let start = Instant::now();
                let mut u = Unpacker::new(Limits::DEFAULT);
                u.feed(&packed.bytes).unwrap();
                assert!(u.is_complete());
                best = best.min(start.elapsed().as_secs_f64());
            }
            let bytes: u64 = packed.objects.iter().map(|o| o.bytes).sum();
            line += &format!(" | {kind} {:8} {:6.2} b/v", packed.bytes.len(), bytes as f64 * 8.0 / v as f64);
            if kind.contains('t') { line += &format!(" enc {:.2} dec {:.2} Mt/s", t as f64 / enc / 1e6, t as f64 / best / 1e6); }
        }
        println!("{line}");
    }
}
