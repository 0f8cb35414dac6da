//! A host of levels on a graphics device: two instances of an object, each at its own level, and
//! one whose parts have levels of their own, drawn off screen. docs/ENGINE.md begins with it.
//!
//! `cargo run -p lodc --features gpu,build,export --example host -- bunny.lodc`

mod picture;
#[cfg(test)]
mod tests;

use lodc::gpu::{Criterion, Device, ResidentObject, ViewLevels, ViewQuery};
use picture::{Camera, Picture};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: host FILE.lodc")?;
    let file = lodc::open(path)?;
    draw(&Device::open(None)?, &file, "host").map(drop)
}

fn draw(device: &Device, file: &lodc::File, name: &str) -> Result<[usize; 2], Box<dyn Error>> {
    let object = &file.objects()[0];
    let mesh = object.simplified.mesh();
    let camera = Camera::around(mesh);
    let picture = Picture::new(device, mesh, &camera);

    // Once: upload, and make what the shaders need.
    let mut near = ResidentObject::new(device, object)?;
    let mut far = near.another()?; // a second instance shares all but what it shows
    let mut by_view = ViewLevels::new(device, object)?;

    // In every frame: choose, extract, draw.
    let mut encoder = device.encoder();
    near.show(&mut encoder, near.within(0.01 * mesh.diagonal() as f32))?;
    far.show(&mut encoder, far.with_triangles(500))?;
    let criterion = Criterion::ScreenError { eye: camera.eye, slope: camera.slope(2.0) };
    by_view.show(&mut encoder, &ViewQuery { criterion, morph: true })?;

    let mut pass = picture.begin(&mut encoder);
    near.draw(&mut pass);
    far.draw(&mut pass);
    drop(pass);
    device.submit(encoder)?;
    let covered = picture.write(device, &format!("{name}.levels.png"))?;

    let mut encoder = device.encoder();
    by_view.draw(&mut picture.begin(&mut encoder));
    device.submit(encoder)?;
    Ok([covered, picture.write(device, &format!("{name}.view.png"))?])
}
