//! What the system tells of a process: memory and time, so that a busy machine makes nothing hang.

/// Memory that a process has, by its number or `self`, in bytes; 0 where that is not told.
#[must_use]
pub fn resident_bytes(process: &str) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/statm")).unwrap_or_default();
    let pages = text.split_whitespace().nth(1).and_then(|pages| pages.parse::<u64>().ok());
    pages.unwrap_or(0) * 4096
}

/// Time that it worked [s]; 0 where that is not told.
#[must_use]
pub fn worked_seconds(process: &str) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    // Its name, in brackets, may have spaces in it.
    let Some((_, rest)) = text.rsplit_once(')') else { return 0.0 };
    let ticks =
        rest.split_whitespace().skip(11).take(2).filter_map(|word| word.parse::<f64>().ok());
    // A hundredth of a second, wherever /proc is.
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
