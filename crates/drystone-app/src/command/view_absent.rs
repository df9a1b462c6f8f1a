//! `drystone view` in a build without a window.

use crate::cli::View;
use crate::output::{Failure, Outcome};

/// Says that there is none.
pub(crate) fn view(_: &View) -> Outcome {
    Err(Failure::failed("view: this program was built without its feature `view`"))
}
