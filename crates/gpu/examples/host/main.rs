//! An engine's host, small enough to copy: reads a `.lodc` file of the gpu layout, uploads its
//! sections as they lie there, takes levels out on the graphics device (everywhere the same, then
//! by the view) and draws each into a PNG. docs/ENGINE.md quotes it.
//!
//! `lodc build bunny.obj --layout gpu && cargo run -p lodc-gpu --example host -- bunny.lodc out`

#![expect(clippy::print_stdout, reason = "an example shows what it does")]

mod file;
mod gpu;
mod levels;
mod picture;
#[cfg(test)]
mod tests;
mod view;

use file::Mapped;
use gpu::Gpu;
use levels::Levels;
use picture::{Camera, Picture};
use std::error::Error;
use std::path::Path;
use view::ByView;

/// A level that was drawn.
#[derive(Debug, PartialEq)]
struct Drawn {
    name: String,
    triangles: u32,
    /// Pixels that show the object.
    covered: usize,
}

/// Shares of the triangles of LOD 0 that are drawn, and pixels that a level by view may err by.
const SHARES: [f64; 3] = [1.0, 0.25, 0.02];
const PIXELS: [f32; 2] = [1.0, 8.0];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, folder] = arguments.as_slice() else {
        println!("usage: host FILE.lodc FOLDER");
        return Ok(());
    };
    let Some(gpu) = Gpu::open() else {
        println!("no graphics device");
        return Ok(());
    };
    let bytes = std::fs::read(file)?;
    for drawn in draw_all(&gpu, &bytes, Path::new(folder))? {
        println!("{}.png: {} triangles", drawn.name, drawn.triangles);
    }
    Ok(())
}

/// Draws the levels of a file's first object into PNG files of a folder.
fn draw_all(gpu: &Gpu, bytes: &[u8], folder: &Path) -> Result<Vec<Drawn>, Box<dyn Error>> {
    let file = Mapped::read(bytes)?;
    let camera = Camera::around(file.mesh());
    let picture = Picture::new(gpu);
    std::fs::create_dir_all(folder)?;
    let mut all = Vec::new();
    let mut draw = |name: String, drawn: &levels::OnDevice| -> Result<(), Box<dyn Error>> {
        let image = picture.draw(gpu, &camera, drawn);
        let triangles = drawn.triangles(gpu);
        let covered = image.bytes.chunks(4).filter(|pixel| pixel[..3] != [0; 3]).count();
        std::fs::write(folder.join(&name).with_extension("png"), picture::png(&image))?;
        all.push(Drawn { name, triangles, covered });
        Ok(())
    };
    let mut levels = Levels::new(gpu, &file);
    for share in SHARES {
        levels.show(gpu, file.lod_for(share));
        draw(format!("level-{}", share * 100.0), levels.drawn())?;
    }
    let views = ByView::new(gpu, &file);
    for pixels in PIXELS {
        views.show(gpu, camera.eye, camera.slope(pixels));
        draw(format!("view-{pixels}"), views.drawn())?;
    }
    Ok(all)
}
