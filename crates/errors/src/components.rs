//! Steps of a block that have no face in common, not even by way of other steps: each such
//! component can be followed by itself.

use crate::block::Block;
use lodc_mesh::{Csr, DisjointSets, NONE};

/// The connected components of a block, in the order of their first steps: steps are connected if
/// they touch the same face.
#[derive(Default)]
pub(crate) struct Components {
    /// The faces that each component touches.
    pub(crate) faces: Csr,
    /// For each entry of [`Block::touched`] the index of its face among the values of `faces`.
    pub(crate) face_indices: Vec<u32>,
    /// The steps of each component, as indices in the block, in their order. Steps that touch no
    /// face are in none.
    pub(crate) steps: Csr,
    /// For each face of the mesh its number among those of the block; [`NONE`] between blocks.
    number_of_face: Vec<u32>,
}

impl Components {
    /// For blocks of a mesh of `face_count` faces.
    pub(crate) fn new(face_count: usize) -> Self {
        Self { number_of_face: vec![NONE; face_count], ..Self::default() }
    }

    /// Finds the components of a block.
    pub(crate) fn find(&mut self, block: &Block) {
        // Faces are numbered in the order in which steps touch them first.
        let Self { number_of_face, face_indices: numbers, .. } = self;
        let mut faces = Vec::new();
        numbers.clear();
        for touched in &block.touched {
            let number = &mut number_of_face[touched.face as usize];
            if *number == NONE {
                *number = faces.len() as u32;
                faces.push(touched.face);
            }
            numbers.push(*number);
        }
        faces.iter().for_each(|&face| number_of_face[face as usize] = NONE);

        let mut sets = DisjointSets::new(faces.len());
        // Each step that touches faces, with the number of the first of them.
        let mut steps = Vec::with_capacity(block.steps.len());
        let mut numbers_left = &numbers[..];
        for (step, view) in (0..).zip(block.views()) {
            let (touched, others) = numbers_left.split_at(view.touched.len());
            numbers_left = others;
            let Some(&first) = touched.first() else { continue };
            touched.iter().for_each(|&number| sets.join(first, number));
            steps.push((step, first));
        }

        // The smallest number of a set comes before all others of it.
        let mut components: Vec<u32> = Vec::with_capacity(faces.len());
        let mut count = 0;
        for number in 0..faces.len() as u32 {
            let smallest = sets.find(number);
            if smallest == number {
                components.push(count);
                count += 1;
            } else {
                components.push(components[smallest as usize]);
            }
        }
        let component_of = |number: u32| components[number as usize];
        let count = count as usize;
        self.steps =
            Csr::new(count, steps.iter().map(|&(step, first)| (component_of(first), step)));
        self.faces = Csr::new(count, components.iter().copied().zip(0..));
        let mut index_of_number = vec![0; faces.len()];
        for (value, index) in self.faces.values.iter_mut().zip(0..) {
            index_of_number[*value as usize] = index;
            *value = faces[*value as usize];
        }
        for index in &mut self.face_indices {
            *index = index_of_number[*index as usize];
        }
    }
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
            assert_eq!(components.faces.values, [3, 4, 9, 8, 7, 11, 10]);
            assert_eq!(components.faces.offsets, [0, 4, 5, 7]);
            assert_eq!(components.face_indices, [0, 1, 4, 1, 2, 2, 3, 5, 6]);
            assert_eq!(components.steps.values, [0, 3, 4, 1, 5]);
            assert_eq!(components.steps.offsets, [0, 3, 4, 5]);
        }
        components.find(&block(&[&[], &[]]));
        assert!(components.steps.values.is_empty() && components.faces.values.is_empty());
    }
}
