//! Where the backward pass (from the level to the input) runs over blocks of steps: on a thread of
//! its own, or on that of the forward pass (from the input to the level), between its blocks.

use crate::backward::{Backward, FollowedBlock};
use crate::block::Block;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Scope;

/// Runs the backward pass over blocks, in the order in which they are sent.
pub(crate) trait Runner {
    /// Hands over a block.
    fn send(&mut self, block: Block);
    /// Returns the oldest block not yet returned, waiting for it if need be; `None` if the other
    /// thread has panicked. To be called no more often than `send`: a thread would wait forever.
    fn receive(&mut self) -> Option<FollowedBlock>;
}

/// Runs over a block as soon as it is sent, on the sender's thread.
pub(crate) struct InlineRunner<'a> {
    backward: Backward<'a>,
    followed: VecDeque<FollowedBlock>,
}

impl<'a> InlineRunner<'a> {
    pub(crate) fn new(backward: Backward<'a>) -> Self {
        Self { backward, followed: VecDeque::new() }
    }
}

impl Runner for InlineRunner<'_> {
    fn send(&mut self, block: Block) {
        self.followed.push_back(self.backward.run(block));
    }
    fn receive(&mut self) -> Option<FollowedBlock> {
        self.followed.pop_front()
    }
}

/// Runs over blocks on a thread of its own.
pub(crate) struct ThreadRunner {
    blocks: Sender<Block>,
    followed: Receiver<FollowedBlock>,
}

impl ThreadRunner {
    /// Starts the thread; it ends when the runner is dropped.
    pub(crate) fn spawn<'scope>(
        scope: &'scope Scope<'scope, '_>,
        mut backward: Backward<'scope>,
    ) -> Self {
        let (blocks, block_receiver) = channel();
        let (followed_sender, followed) = channel();
        scope.spawn(move || {
            for block in block_receiver {
                if followed_sender.send(backward.run(block)).is_err() {
                    return;
                }
            }
        });
        Self { blocks, followed }
    }
}

impl Runner for ThreadRunner {
    fn send(&mut self, block: Block) {
        // An error means that the thread has panicked: `receive` then returns `None`, and the
        // scope passes the panic on.
        let _ = self.blocks.send(block);
    }
    fn receive(&mut self) -> Option<FollowedBlock> {
        self.followed.recv().ok()
    }
}
