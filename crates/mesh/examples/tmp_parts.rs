use estar_mesh::generate::{BoxSpec, box_mesh};
use estar_mesh::quality::{ElementQuality, volume, QualityReport};
use std::time::Instant; use std::hint::black_box;
fn t<T>(n:&str, f: impl Fn()->T){ let mut v:Vec<f64>=(0..5).map(|_|{let s=Instant::now(); black_box(f()); s.elapsed().as_secs_f64()}).collect(); v.sort_by(f64::total_cmp); println!("{n} {:.3}", v[0]); }
fn main(){ let mesh=box_mesh(&BoxSpec::new([1.0;3],[100;3]).unwrap()); let n=mesh.element_count();
 t("positions", || (0..n).map(|e| mesh.positions(e)[3][1]).sum::<f64>());
 t("volume", || (0..n).map(|e| volume(mesh.elements().shape(e), &mesh.positions(e))).sum::<f64>());
 t("quality", || (0..n).map(|e| ElementQuality::new(mesh.elements().shape(e), &mesh.positions(e)).scaled_jacobian).sum::<f64>());
 t("report", || QualityReport::new(&mesh).errors().len());
 let keys=|| (0..n).map(|e| { let mut k=[u32::MAX;10]; let m=mesh.elements().nodes(e); k[..m.len()].copy_from_slice(m); k.sort_unstable(); (k,e as u32)}).collect::<Vec<_>>();
 t("keys", keys); t("keys sorted", || { let mut k=keys(); k.sort_unstable(); k.len() });
}
