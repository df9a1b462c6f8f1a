//! Names of bodies.

use std::collections::BTreeSet;

/// Unique names of bodies by their numbers in a file: their own, `name#number` where another body
/// has it already.
pub(crate) fn unique(numbers: &[usize], own: impl Fn(usize) -> String) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut out = Vec::with_capacity(numbers.len());
    for &number in numbers {
        let mut name = own(number);
        if taken.contains(&name) {
            name = format!("{name}#{number}");
        }
        while !taken.insert(name.clone()) {
            name.push('\'');
        }
        out.push(name);
    }
    out
}
