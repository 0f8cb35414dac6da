//! Replays on a graphics device, compared with what must come out.

mod by_hand;
mod engine;
mod faults;
mod limits;
mod many;
mod replay;
mod support;
