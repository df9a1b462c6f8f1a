//! Memory and processor time of a process, so that a busy machine does not look like a hang.

/// Memory of a process, by its number or `self`, in bytes; 0 if unavailable.
#[must_use]
pub fn resident_bytes(process: &str) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/statm")).unwrap_or_default();
    let pages = text.split_whitespace().nth(1).and_then(|pages| pages.parse::<u64>().ok());
    pages.unwrap_or(0) * 4096
}

/// Processor time [s]; 0 if unavailable.
#[must_use]
pub fn worked_seconds(process: &str) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    // The name, in brackets, may contain spaces.
    let Some((_, rest)) = text.rsplit_once(')') else { return 0.0 };
    let ticks =
        rest.split_whitespace().skip(11).take(2).filter_map(|word| word.parse::<f64>().ok());
    // Ticks are 1/100 s on every system with /proc.
    ticks.sum::<f64>() / 100.0
}

#[cfg(test)]
mod tests {
    use super::{resident_bytes, worked_seconds};

    #[test]
    fn a_process_that_is_not_there_has_nothing() {
        assert_eq!(resident_bytes("none"), 0);
        assert!(worked_seconds("none").abs() < 1.0e-9);
        let all = std::path::Path::new("/proc/self/stat").exists();
        assert_eq!(all, resident_bytes("self") > 0);
    }
}
