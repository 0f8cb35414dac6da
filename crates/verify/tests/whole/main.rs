//! Verification of whole sequences: real ones, large ones and damaged ones.

mod high_valence;
mod large;
mod sensitivity;
