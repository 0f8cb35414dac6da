//! Verification of whole sequences: real ones, large ones and damaged ones.

mod hubs;
mod large;
mod sensitivity;
