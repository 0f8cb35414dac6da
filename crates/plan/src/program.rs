//! The buffers and kernels of a program for a graphics device, named by numbers that passes refer
//! to.

use std::sync::Arc;

/// A buffer of a [`Program`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BufferId(pub usize);

/// A kernel of a [`Program`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct KernelId(pub usize);

/// A run of 32-bit words on the device.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// The content, for messages.
    pub name: &'static str,
    /// The words at the start.
    pub contents: Contents,
}

/// The words of a buffer at the start.
#[derive(Clone, Debug)]
pub enum Contents {
    /// These words.
    Words(Arc<[u32]>),
    /// This number of zeros.
    Zeros(usize),
}

impl Contents {
    /// Number of words.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Words(words) => words.len(),
            Self::Zeros(len) => *len,
        }
    }
    /// Returns whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The text of a kernel, as an engine may take it too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shader {
    /// The name of its file, without the extension.
    pub name: &'static str,
    /// Its own text.
    pub wgsl: &'static str,
}

/// The end of every kernel's text, the same in all: the constant `WORKGROUP`, the struct `Thread`
/// and the function `number_of`, by which a thread finds its number.
const SHARED: &str = include_str!("prelude.wgsl");

impl Shader {
    /// Returns the whole text: the kernel's own, then what all kernels share.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{}\n{SHARED}", self.wgsl)
    }
}

/// A compute shader with the entry point `main`, 256 threads to a workgroup. Binding 0 is a uniform
/// buffer with a pass's parameters, bindings 1, 2, … are its buffers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kernel {
    /// The name of its file, without the extension.
    pub name: &'static str,
    /// The whole text, see [`Shader::text`].
    pub wgsl: String,
    /// Values of its pipeline-overridable constants.
    pub constants: Vec<(&'static str, u32)>,
}

/// Threads in a workgroup of every kernel: what every device allows.
pub const WORKGROUP: u32 = 256;

/// One run of a kernel over a number of threads. More threads than these may run, to fill
/// workgroups and rows of workgroups, so each thread finds its number (`prelude.wgsl`) and ends if
/// that is too large.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The kernel.
    pub kernel: KernelId,
    /// Its bindings 1, 2, …
    pub buffers: Vec<BufferId>,
    /// Number of threads.
    pub threads: u32,
    /// Words of the uniform buffer, at most [`Self::MAX_PARAMETERS`].
    pub parameters: Vec<u32>,
}

impl Pass {
    /// Words that the uniform buffer of a pass has room for. Chosen by hand.
    pub const MAX_PARAMETERS: usize = 60;
}

/// Words that a buffer must hold.
#[derive(Clone, Debug)]
pub struct Expected {
    /// The buffer.
    pub buffer: BufferId,
    /// They start at this word of it.
    pub first: usize,
    /// The words.
    pub words: Arc<[u32]>,
    /// Floats in them that may be off by one unit in the last place on hardware.
    pub tolerance: Option<Tolerance>,
}

/// The words that are results of floating-point arithmetic. Software adapters must give the same
/// bits; WGSL does not demand that of hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance {
    /// Words of a record.
    pub stride: usize,
    /// Number of words at the front of each that are computed; the others are copies.
    pub floats: usize,
}

impl Expected {
    /// A buffer from its first word on.
    pub fn new(buffer: BufferId, words: impl Into<Arc<[u32]>>) -> Self {
        Self { buffer, first: 0, words: words.into(), tolerance: None }
    }
}

/// Buffers and kernels.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// All buffers.
    pub buffers: Vec<Buffer>,
    /// All kernels.
    pub kernels: Vec<Kernel>,
}

impl Program {
    /// Adds a buffer with these words in it.
    pub fn words(&mut self, name: &'static str, words: impl Into<Arc<[u32]>>) -> BufferId {
        self.buffer(name, Contents::Words(words.into()))
    }
    /// Adds a buffer of zeros.
    pub fn zeros(&mut self, name: &'static str, len: usize) -> BufferId {
        self.buffer(name, Contents::Zeros(len))
    }
    fn buffer(&mut self, name: &'static str, contents: Contents) -> BufferId {
        self.buffers.push(Buffer { name, contents });
        BufferId(self.buffers.len() - 1)
    }
    /// Adds a kernel, or finds it if it is there.
    pub fn kernel(&mut self, shader: Shader) -> KernelId {
        self.kernel_with(shader, &[])
    }
    /// Adds a kernel with values of its pipeline-overridable constants, or finds it if it is there.
    pub fn kernel_with(&mut self, shader: Shader, constants: &[(&'static str, u32)]) -> KernelId {
        let existing =
            self.kernels.iter().position(|k| k.name == shader.name && k.constants == constants);
        KernelId(existing.unwrap_or_else(|| {
            self.kernels.push(Kernel {
                name: shader.name,
                wgsl: shader.text(),
                constants: constants.to_vec(),
            });
            self.kernels.len() - 1
        }))
    }
    /// Returns the words of every buffer with given words, except the buffers `written`, which
    /// passes write to.
    #[must_use]
    pub fn uploaded(&self, written: &[BufferId]) -> Vec<Expected> {
        let buffers = (0..self.buffers.len()).map(BufferId).filter(|id| !written.contains(id));
        let expected = |id: BufferId| match &self.buffers[id.0].contents {
            Contents::Words(words) => Some(Expected::new(id, Arc::clone(words))),
            Contents::Zeros(_) => None,
        };
        buffers.filter_map(expected).collect()
    }
    /// Words of all buffers together.
    #[must_use]
    pub fn size(&self) -> u64 {
        self.buffers.iter().map(|b| b.contents.len() as u64).sum()
    }
    /// Words of all buffers together, as they are and with a normal for each of `vertices`
    /// vertices.
    #[must_use]
    pub fn words_with_normals(&self, vertices: usize) -> (u64, u64) {
        (self.size(), self.size() + 3 * vertices as u64)
    }
}
