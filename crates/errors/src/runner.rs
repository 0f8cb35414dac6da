//! Where the backward pass runs: on a thread of its own, or on the forward pass's between its
//! blocks.

use crate::backward::{Backward, FollowedBlock};
use crate::block::Block;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Scope;

/// Runs the backward pass over blocks, in the order in which they are sent.
pub(crate) trait Runner {
    /// Hands over a block.
    fn send(&mut self, block: Block);
    /// Returns the oldest block not yet returned, waiting for it if need be; `None` if there is
    /// none, or the other thread has panicked.
    fn receive(&mut self) -> Option<FollowedBlock>;
}

/// Follows a block as soon as it is sent, on the sender's thread.
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

/// Follows blocks on a thread of its own.
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
