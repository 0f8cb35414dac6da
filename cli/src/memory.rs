//! Peak memory of the process and memory of the machine, for messages and estimates; never part of
//! an output file.

use std::fs;

/// Forgets the peak so far, where the system allows that, so that each input's peak is its own.
pub(crate) fn reset_peak() {
    // 5 resets the peak of resident memory (VmHWM).
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Peak resident bytes of this process; 0 where the system does not say.
pub(crate) fn peak_bytes() -> u64 {
    bytes_of("/proc/self/status", "VmHWM:").unwrap_or(0)
}

/// Bytes of memory that this process may use: the machine's, or less if its control group says so.
pub(crate) fn available_bytes() -> Option<u64> {
    let machine = bytes_of("/proc/meminfo", "MemTotal:");
    let group =
        fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|t| t.trim().parse().ok());
    machine.into_iter().chain(group).min()
}

/// The bytes that a line such as `VmHWM:     1234 kB` says.
fn bytes_of(file: &str, key: &str) -> Option<u64> {
    let text = fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()? * 1024)
}
