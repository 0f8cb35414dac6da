//! What one record takes out of one strip, taken out and put back in one pass (thesis 3.4).

use super::history::Removal;

/// Takes repetitions out. Elements behind the first of them move once each. Returns how many elements were written.
pub(super) fn remove(strip: &mut [u32], length: &mut u32, removals: &[(u32, Removal)]) -> u64 {
    let Some(&(_, first)) = removals.first() else { return 0 };
    let mut write = first.at as usize;
    let ends = removals[1..].iter().map(|(_, r)| r.at).chain([*length]);
    for ((_, removal), end) in removals.iter().zip(ends) {
        let read = removal.at as usize + removal.len();
        shift_down(strip, read, write, end as usize - read);
        write += end as usize - read;
    }
    *length = write as u32;
    (write - first.at as usize) as u64
}

/// Undoes [`remove`]: repetitions come back as copies of what stands before them. From the back, so that nothing is
/// overwritten before it has moved.
pub(super) fn restore(strip: &mut [u32], length: &mut u32, removals: &[(u32, Removal)]) -> u64 {
    let Some(&(_, first)) = removals.first() else { return 0 };
    let mut read = *length as usize;
    let mut write = read + removals.iter().map(|(_, r)| r.len()).sum::<usize>();
    let written = write - first.at as usize;
    *length = write as u32;
    for (_, removal) in removals.iter().rev() {
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
    written as u64
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
