//! One record's changes of one strip, applied and undone in one pass (thesis 3.4).

use super::history::Removal;

/// Applies a record: `places` become `target`, then repetitions go. Elements behind the first of them move once each.
/// Returns how many elements were written.
pub(super) fn coarsen(strip: &mut [u32], length: &mut u32, places: &[u32], removals: &[Removal], target: u32) -> u32 {
    for &place in places {
        strip[place as usize] = target;
    }
    let mut written = places.len() as u32;
    if let Some(first) = removals.first() {
        let mut write = first.at as usize;
        let ends = removals[1..].iter().map(|r| r.at).chain([*length]);
        for (removal, end) in removals.iter().zip(ends) {
            let read = removal.at as usize + removal.len();
            shift_down(strip, read, write, end as usize - read);
            write += end as usize - read;
        }
        written += write as u32 - first.at;
        *length = write as u32;
    }
    written
}

/// Undoes [`coarsen`]: repetitions come back as copies of what stands before them, then `places` become `vertex`. From
/// the back, so that nothing is overwritten before it has moved.
pub(super) fn refine(strip: &mut [u32], length: &mut u32, places: &[u32], removals: &[Removal], vertex: u32) -> u32 {
    let mut written = places.len() as u32;
    if let Some(first) = removals.first() {
        let mut read = *length as usize;
        let mut write = read + removals.iter().map(|r| r.len()).sum::<usize>();
        *length = write as u32;
        written += write as u32 - first.at;
        for removal in removals.iter().rev() {
            let end = removal.at as usize + removal.len();
            let count = write - end;
            read -= count;
            shift_up(strip, read, end, count);
            write = removal.at as usize;
            let period = removal.period();
            for i in 0..removal.len() {
                strip[write + i] = strip[read - period + i % period];
            }
        }
    }
    for &place in places {
        strip[place as usize] = vertex;
    }
    written
}

/// Most runs are short, and a call costs as much as moving some elements.
const SHORT: usize = 16;

fn shift_down(strip: &mut [u32], from: usize, to: usize, count: usize) {
    if count < SHORT {
        for i in 0..count {
            strip[to + i] = strip[from + i];
        }
    } else {
        strip.copy_within(from..from + count, to);
    }
}

fn shift_up(strip: &mut [u32], from: usize, to: usize, count: usize) {
    if count < SHORT {
        for i in (0..count).rev() {
            strip[to + i] = strip[from + i];
        }
    } else {
        strip.copy_within(from..from + count, to);
    }
}
