//! How likely things are, learnt from those that were.

/// Chances are parts of two to this.
pub(super) const SCALE: u32 = 15;
pub(super) const WHOLE: u16 = 1 << SCALE;

/// Fewer counts make a model quick to forget; measured on ten meshes.
const MOST_SEEN: u8 = 160;
/// The least chance of a bit, of 65,536: never certain, the other must stay possible.
const CAUTION: u32 = 24;
/// The least chance of a symbol, of [`WHOLE`].
const FLOOR: i16 = 4;
/// What is left to be shared out among symbols.
const SHARED: i16 = (WHOLE - 16 * FLOOR as u16) as i16;

/// 65,536 / (n + 1.6): how far the n-th observation moves a chance. The mean of what was seen at
/// first, a sliding mean later.
const STEPS: [u16; 256] = {
    let mut table = [0; 256];
    let mut n = 0;
    while n < table.len() {
        table[n] = (655_360 / (10 * n as u32 + 16)) as u16;
        n += 1;
    }
    table
};

/// How likely a bit is to be set, learnt from those before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bit {
    /// Of 65,536.
    chance: u16,
    seen: u8,
}

impl Bit {
    pub(super) const NEW: Self = Self { chance: 1 << 15, seen: 0 };

    /// The chance of a set bit, of [`WHOLE`].
    pub(super) fn set(self) -> u16 {
        self.chance >> 1
    }

    #[inline]
    pub(super) fn learn(&mut self, bit: bool) {
        let step = u32::from(STEPS[usize::from(self.seen)]);
        let chance = u32::from(self.chance);
        let more = (chance + (((65_535 - chance) * step) >> 16)).min(65_535 - CAUTION);
        let less = (chance - ((chance * step) >> 16)).max(CAUTION);
        self.chance = if bit { more } else { less } as u16;
        self.seen += u8::from(self.seen < MOST_SEEN);
    }
}

/// How likely each of sixteen symbols is, learnt from those before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Symbol {
    /// For each symbol the chance of all below it, without their [`FLOOR`]s.
    below: [i16; 16],
    seen: u8,
}

/// For each symbol what the chances of all below each move towards when it is seen.
const GOALS: [[i16; 16]; 16] = {
    let mut goals = [[0; 16]; 16];
    let mut i = 0;
    while i < 256 {
        goals[i / 16][i % 16] = if i % 16 > i / 16 { SHARED } else { 0 };
        i += 1;
    }
    goals
};

/// A symbol model begins as if it had seen so many.
const PRIOR: u8 = 2;

impl Symbol {
    pub(super) const NEW: Self = {
        let mut below = [0; 16];
        let mut i = 0;
        while i < 16 {
            below[i] = SHARED / 16 * i as i16;
            i += 1;
        }
        Self { below, seen: PRIOR }
    };

    /// The symbol that has a place among [`WHOLE`].
    #[inline(always)]
    pub(super) fn at(&self, slot: u16) -> usize {
        let mut symbols = 0;
        for (i, &below) in (0i16..).zip(&self.below) {
            symbols += i16::from(below + FLOOR * i <= slot as i16);
        }
        (symbols - 1) as usize & 15
    }

    /// Where a symbol begins among [`WHOLE`], and its chance.
    #[inline(always)]
    pub(super) fn part(&self, symbol: usize) -> (u16, u16) {
        let start = |s: usize| (self.below[s & 15] + FLOOR * s as i16) as u16;
        let (from, to) = (start(symbol), if symbol == 15 { WHOLE } else { start(symbol + 1) });
        (from, to - from)
    }

    #[inline(always)]
    pub(super) fn learn(&mut self, symbol: usize) {
        let step = STEPS[usize::from(self.seen)] as i16;
        for (below, goal) in self.below.iter_mut().zip(&GOALS[symbol & 15]) {
            *below += ((i32::from(goal - *below) * i32::from(step)) >> 16) as i16;
        }
        self.seen += u8::from(self.seen < MOST_SEEN);
    }
}
