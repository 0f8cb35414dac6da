//! One camera's item buffer (the face that each pixel shows) while the mesh is simplified, exact to
//! the pixel after every collapse, and the number of pixels of each face.
//!
//! Each pixel keeps all fragments in order of depth, not only the nearest: a face that moves away
//! uncovers what is behind it, and nothing has to be drawn again for that.

use crate::cut::{Corner, WorkingMesh};
use lodc_raster::{Camera, Fragment, Layers, Point, Window, scan};

/// The item of background pixels; all other items are faces.
pub(super) const BACKGROUND: u32 = u32::MAX;

/// The item buffer of one camera.
pub(super) struct View {
    /// The projection of each group's position.
    points: Vec<Point>,
    layers: Layers,
    size: u32,
    /// Number of pixels of each face.
    face_pixels: Vec<u32>,
    /// Number of background pixels.
    background: u32,
    /// A buffer for the front items of a window before a collapse.
    fronts_before: Vec<u32>,
}

impl View {
    /// Draws the live faces.
    pub(super) fn new(mesh: &WorkingMesh, camera: &Camera) -> Self {
        let size = camera.size;
        let mut view = Self {
            points: mesh
                .group_positions
                .iter()
                .map(|p| camera.project(p.position.as_dvec3()))
                .collect(),
            layers: Layers::new(size as usize * size as usize),
            size,
            face_pixels: vec![0; mesh.faces.len()],
            background: 0,
            fronts_before: Vec::new(),
        };
        for face in mesh.live() {
            view.draw(mesh.faces[face as usize].groups, face);
        }
        for pixel in 0..size as usize * size as usize {
            match view.layers.front(pixel).item() {
                BACKGROUND => view.background += 1,
                face => view.face_pixels[face as usize] += 1,
            }
        }
        view
    }

    /// Number of pixels of an item.
    #[inline]
    pub(super) fn area(&self, item: u32) -> u32 {
        if item == BACKGROUND { self.background } else { self.face_pixels[item as usize] }
    }

    /// Numbers of pixels of all faces and, last, of the background.
    #[cfg(test)]
    pub(super) fn areas(&self) -> Vec<u32> {
        self.face_pixels.iter().copied().chain([self.background]).collect()
    }

    /// Number of pixels of the picture.
    pub(super) fn pixels(&self) -> u32 {
        self.size * self.size
    }

    /// A window around all pixels that a group's faces cover before or after a collapse onto any
    /// neighbour: their corners are those of the star in either case.
    pub(super) fn window(&self, mesh: &WorkingMesh, star: &[Corner]) -> Window {
        let groups = star.iter().flat_map(|c| mesh.faces[c.face() as usize].groups);
        Window::whole(self.size).around(groups.map(|g| self.points[g as usize]))
    }

    /// The index of a pixel.
    #[inline]
    fn pixel(&self, column: i32, row: i32) -> usize {
        (row * self.size as i32 + column) as usize
    }

    /// Calls `visit` with the pixels of a window, row by row.
    fn each_pixel(&self, window: Window, mut visit: impl FnMut(usize)) {
        for row in window.top..window.bottom {
            for column in window.left..window.right {
                visit(self.pixel(column, row));
            }
        }
    }

    /// Calls `visit` with every pixel of a window and what is in front of it, row by row.
    #[inline]
    pub(super) fn each_front(&self, window: Window, mut visit: impl FnMut(usize, Fragment)) {
        for row in window.top..window.bottom {
            let first = self.pixel(window.left, row);
            for (pixel, front) in (first..).zip(self.layers.fronts(first, window.width())) {
                visit(pixel, front);
            }
        }
    }

    /// The first fragment behind the front whose item is not skipped.
    #[inline]
    pub(super) fn behind(&self, pixel: usize, skips: impl Fn(u32) -> bool) -> Fragment {
        self.layers.behind(pixel).find(|f| !skips(f.item())).unwrap_or(Fragment::NOTHING)
    }

    /// Calls `visit` with column, row and fragment of every pixel that a face would cover with its
    /// corners at these groups.
    #[inline]
    pub(super) fn cover(
        &self,
        groups: [u32; 3],
        face: u32,
        window: Window,
        mut visit: impl FnMut(i32, i32, Fragment),
    ) {
        let corners = groups.map(|g| self.points[g as usize]);
        scan(corners, window, |column, row, depth| visit(column, row, Fragment::new(face, depth)));
    }

    fn draw(&mut self, groups: [u32; 3], face: u32) {
        let corners = groups.map(|g| self.points[g as usize]);
        let (size, layers) = (self.size as i32, &mut self.layers);
        scan(corners, Window::whole(self.size), |column, row, depth| {
            layers.insert((row * size + column) as usize, Fragment::new(face, depth));
        });
    }

    fn erase(&mut self, groups: [u32; 3], face: u32) {
        let corners = groups.map(|g| self.points[g as usize]);
        let (size, layers) = (self.size as i32, &mut self.layers);
        scan(corners, Window::whole(self.size), |column, row, _| {
            layers.remove((row * size + column) as usize, face);
        });
    }

    /// Moves `from`'s faces to `to`; faces at both are removed. Calls `changed` pixel by pixel for
    /// every item whose number of pixels changes, with the numbers before and after.
    pub(super) fn collapse(
        &mut self,
        mesh: &WorkingMesh,
        from: u32,
        to: u32,
        mut changed: impl FnMut(u32, u32, u32),
    ) {
        let star = mesh.star(from);
        let window = self.window(mesh, star);
        let mut fronts_before = std::mem::take(&mut self.fronts_before);
        fronts_before.clear();
        self.each_pixel(window, |pixel| fronts_before.push(self.layers.front(pixel).item()));
        for &corner in star {
            let face = corner.face();
            let groups = mesh.faces[face as usize].groups;
            self.erase(groups, face);
            if !groups.contains(&to) {
                self.draw(groups.map(|g| if g == from { to } else { g }), face);
            }
        }
        let mut i = 0;
        for row in window.top..window.bottom {
            for column in window.left..window.right {
                let (old, new) =
                    (fronts_before[i], self.layers.front(self.pixel(column, row)).item());
                i += 1;
                if old != new {
                    for (item, change) in [(old, -1), (new, 1)] {
                        let area = if item == BACKGROUND {
                            &mut self.background
                        } else {
                            &mut self.face_pixels[item as usize]
                        };
                        let before = std::mem::replace(area, area.wrapping_add_signed(change));
                        changed(item, before, *area);
                    }
                }
            }
        }
        self.fronts_before = fronts_before;
    }
}
