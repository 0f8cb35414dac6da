//! Steps of a block that have no face in common, not even by way of other steps: each such
//! component can be followed by itself.

use crate::block::Block;
use lodc_mesh::NONE;

/// The connected components of a block: steps are connected if they touch the same face.
#[derive(Default)]
pub(crate) struct Components {
    /// The faces that the block touches, component by component.
    pub(crate) faces: Vec<u32>,
    /// For each entry of [`Block::touched`] the index of its face in `faces`.
    pub(crate) face_indices: Vec<u32>,
    /// The steps of the block that touch faces, component by component, each in their order.
    pub(crate) steps: Vec<u32>,
    /// The ends of each component in `faces` and in `steps`.
    pub(crate) ends: Vec<[u32; 2]>,
    /// For each face of the mesh its index among those of the block; [`NONE`] between blocks.
    index_of_face: Vec<u32>,
    /// Buffers: of a forest over the faces of a block, the parent of each, and the component of
    /// each root.
    parents: Vec<u32>,
    component_of_root: Vec<u32>,
}

impl Components {
    /// For blocks of a mesh of `face_count` faces.
    pub(crate) fn new(face_count: usize) -> Self {
        Self { index_of_face: vec![NONE; face_count], ..Self::default() }
    }

    /// Finds the components of a block, in the order of their first steps.
    pub(crate) fn find(&mut self, block: &Block) {
        let touched_by_step = self.connect(block);
        // Components are numbered in the order of steps; their sizes become their ends.
        self.ends.clear();
        self.component_of_root.clear();
        self.component_of_root.resize(self.parents.len(), NONE);
        for &[_, first_face] in &touched_by_step {
            let component = self.component_of(first_face);
            self.ends[component as usize][1] += 1;
        }
        for face in 0..self.parents.len() as u32 {
            let component = self.component_of(face);
            self.ends[component as usize][0] += 1;
        }
        let mut starts = Vec::with_capacity(self.ends.len());
        let mut sum = [0, 0];
        for end in &mut self.ends {
            starts.push(sum);
            sum = [sum[0] + end[0], sum[1] + end[1]];
            *end = sum;
        }
        self.steps.resize(touched_by_step.len(), 0);
        for &[step, first_face] in &touched_by_step {
            let start = &mut starts[self.component_of(first_face) as usize];
            self.steps[start[1] as usize] = step;
            start[1] += 1;
        }
        self.sort_faces(&mut starts);
    }

    /// Numbers the faces of a block in the order in which they are touched first, and connects
    /// those of each step. Returns each step that touches faces, with the first of them.
    fn connect(&mut self, block: &Block) -> Vec<[u32; 2]> {
        self.faces.clear();
        self.face_indices.clear();
        self.steps.clear();
        self.parents.clear();
        let mut touched_by_step = Vec::with_capacity(block.steps.len());
        for (step, view) in (0..).zip(block.views()) {
            let mut first_face = NONE;
            for touched in view.touched {
                let new_index = self.faces.len() as u32;
                let slot = &mut self.index_of_face[touched.face as usize];
                if *slot == NONE {
                    *slot = new_index;
                    self.faces.push(touched.face);
                    self.parents.push(new_index);
                }
                let index = *slot;
                self.face_indices.push(index);
                if first_face == NONE {
                    first_face = index;
                }
                let roots = [first_face, index].map(|face| root(&mut self.parents, face));
                self.parents[roots[0].max(roots[1]) as usize] = roots[0].min(roots[1]);
            }
            if first_face != NONE {
                touched_by_step.push([step, first_face]);
            }
        }
        for &face in &self.faces {
            self.index_of_face[face as usize] = NONE;
        }
        touched_by_step
    }

    /// Returns the component of a face of the block; a new one if its root has none yet.
    fn component_of(&mut self, face: u32) -> u32 {
        let component = &mut self.component_of_root[root(&mut self.parents, face) as usize];
        if *component == NONE {
            *component = self.ends.len() as u32;
            self.ends.push([0, 0]);
        }
        *component
    }

    /// Puts the faces in the order of components, of which `starts` has the first faces.
    fn sort_faces(&mut self, starts: &mut [[u32; 2]]) {
        let mut new_indices = Vec::with_capacity(self.faces.len());
        for face in 0..self.faces.len() as u32 {
            let start = &mut starts[self.component_of(face) as usize][0];
            new_indices.push(*start);
            *start += 1;
        }
        let mut sorted = vec![0; self.faces.len()];
        for (&face, &index) in self.faces.iter().zip(&new_indices) {
            sorted[index as usize] = face;
        }
        self.faces = sorted;
        for index in &mut self.face_indices {
            *index = new_indices[*index as usize];
        }
    }
}

/// Returns the root of a tree in a forest, and halves the way to it.
fn root(parents: &mut [u32], mut i: u32) -> u32 {
    while parents[i as usize] != i {
        parents[i as usize] = parents[parents[i as usize] as usize];
        i = parents[i as usize];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::{Step, TouchedFace};

    /// A block whose steps touch the given faces.
    fn block(steps: &[&[u32]]) -> Block {
        let mut block = Block::default();
        for &faces in steps {
            block.touched.extend(faces.iter().map(|&face| TouchedFace::dead(face, [0; 3])));
            block.steps.push(Step {
                touched_end: block.touched.len() as u32,
                targets_end: 0,
                source: NONE,
                live_faces: 1,
                max_squared: 0.0,
                mean_square: 0.0,
            });
        }
        block
    }

    #[test]
    fn steps_are_connected_by_common_faces() {
        let mut components = Components::new(20);
        // Steps 0 and 4 are connected by step 3 alone.
        let steps: [&[u32]; 6] = [&[3, 4], &[7], &[], &[4, 9], &[9, 8], &[11, 10]];
        for _ in 0..2 {
            components.find(&block(&steps));
            assert_eq!(components.faces, [3, 4, 9, 8, 7, 11, 10]);
            assert_eq!(components.face_indices, [0, 1, 4, 1, 2, 2, 3, 5, 6]);
            assert_eq!(components.steps, [0, 3, 4, 1, 5]);
            assert_eq!(components.ends, [[4, 3], [5, 4], [7, 5]]);
        }
        components.find(&block(&[&[], &[]]));
        assert!(components.ends.is_empty() && components.faces.is_empty());
    }
}
