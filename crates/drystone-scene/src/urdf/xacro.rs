//! Files of xacro, the macro language that most URDF files are written in.

use crate::error::SceneError;
use crate::read::xml::Element;

/// Refuses a file that is still to be expanded: its numbers are formulas, its links are in macros.
/// Definitions alone change nothing.
pub(super) fn refuse(robot: &Element<'_>) -> Result<(), SceneError> {
    let mut stack = vec![*robot];
    while let Some(element) = stack.pop() {
        let is_call =
            element.prefix() == Some("xacro") && !["property", "arg"].contains(&element.tag());
        let is_formula = |(_, value): (&str, &str)| value.contains("${") || value.contains("$(");
        if is_call || (element.prefix().is_none() && element.attributes().any(is_formula)) {
            let allowed = "a URDF file: expand this one by `xacro FILE > robot.urdf` \
                           (`pip install xacro`, or `ros2 run xacro xacro`)";
            return Err(
                element.error("it is a xacro file, which has to be expanded first", allowed)
            );
        }
        let inside: Vec<Element<'_>> = element.children().collect();
        stack.extend(inside.into_iter().rev());
    }
    Ok(())
}
