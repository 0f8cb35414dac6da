//! Where the backward pass runs: on a thread of its own, or between the blocks of the first.

use crate::backward::{Backward, Followed};
use crate::block::Block;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Scope;

/// The backward pass.
pub(crate) trait Follower {
    /// Gives it a block.
    fn send(&mut self, block: Block);
    /// Returns the oldest block that was not returned yet; nothing if there is none, or the other
    /// thread has panicked.
    fn receive(&mut self) -> Option<Followed>;
}

/// Follows at once.
pub(crate) struct Here<'a> {
    backward: Backward<'a>,
    followed: VecDeque<Followed>,
}

impl<'a> Here<'a> {
    pub(crate) fn new(backward: Backward<'a>) -> Self {
        Self { backward, followed: VecDeque::new() }
    }
}

impl Follower for Here<'_> {
    fn send(&mut self, block: Block) {
        self.followed.push_back(self.backward.run(block));
    }
    fn receive(&mut self) -> Option<Followed> {
        self.followed.pop_front()
    }
}

/// Follows on another thread.
pub(crate) struct Beside {
    blocks: Sender<Block>,
    followed: Receiver<Followed>,
}

/// Starts a thread that ends with the last block.
pub(crate) fn beside<'scope>(
    scope: &'scope Scope<'scope, '_>,
    mut backward: Backward<'scope>,
) -> Beside {
    let (blocks, coming) = channel();
    let (sender, followed) = channel();
    scope.spawn(move || {
        for block in coming {
            if sender.send(backward.run(block)).is_err() {
                return;
            }
        }
    });
    Beside { blocks, followed }
}

impl Follower for Beside {
    fn send(&mut self, block: Block) {
        // If it panicked, `receive` says so, and the scope goes on panicking.
        let _ = self.blocks.send(block);
    }
    fn receive(&mut self) -> Option<Followed> {
        self.followed.recv().ok()
    }
}
