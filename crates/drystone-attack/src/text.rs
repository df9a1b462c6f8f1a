//! Converts the `Debug` text of a value to source that makes the value.

/// Name of a struct, an expression for one with default fields, and the `Debug` text of that.
pub(crate) type Default = (&'static str, &'static str, fn() -> String);

/// A value parsed from `Debug` text.
#[derive(Clone, Debug, PartialEq)]
enum Node {
    Atom(String),
    Struct(String, Vec<(String, Node)>),
    Tuple(String, Vec<Node>),
    List(Vec<Node>),
}

/// The source of a value; default fields are left out.
pub(crate) fn plain(debug: &str, defaults: &[Default]) -> String {
    let mut rest = debug;
    let node = parse(&mut rest);
    write(&node, defaults)
}

fn parse(rest: &mut &str) -> Node {
    *rest = rest.trim_start();
    if let Some(inner) = rest.strip_prefix('[') {
        *rest = inner;
        return Node::List(parse_list(rest, ']'));
    }
    let end = rest.find([' ', ',', '(', ')', '{', '}', '[', ']']).unwrap_or(rest.len());
    let (word, after) = rest.split_at(end);
    *rest = after;
    let word = word.to_owned();
    if let Some(inner) = rest.strip_prefix('(') {
        *rest = inner;
        return Node::Tuple(word, parse_list(rest, ')'));
    }
    let Some(inner) = rest.strip_prefix(" {") else { return Node::Atom(word) };
    *rest = inner;
    let mut fields = Vec::new();
    loop {
        *rest = rest.trim_start_matches([' ', ',']);
        if let Some(after) = rest.strip_prefix('}') {
            *rest = after;
            return Node::Struct(word, fields);
        }
        let Some((name, after)) = rest.split_once(": ") else { return Node::Struct(word, fields) };
        *rest = after;
        fields.push((name.to_owned(), parse(rest)));
    }
}

fn parse_list(rest: &mut &str, end: char) -> Vec<Node> {
    let mut items = Vec::new();
    loop {
        *rest = rest.trim_start_matches([' ', ',']);
        if let Some(after) = rest.strip_prefix(end) {
            *rest = after;
            return items;
        }
        if rest.is_empty() {
            return items;
        }
        items.push(parse(rest));
    }
}

fn write(node: &Node, defaults: &[Default]) -> String {
    let all = |items: &[Node]| {
        items.iter().map(|item| write(item, defaults)).collect::<Vec<_>>().join(", ")
    };
    match node {
        Node::Atom(word) => format!("{}{}", path(word, false), atom(word)),
        Node::List(items) => format!("[{}]", all(items)),
        Node::Tuple(word, items) => format!("{}{word}({})", path(word, true), all(items)),
        Node::Struct(word, fields) if word == "Vec3" => {
            let values: Vec<String> = fields.iter().map(|(_, v)| write(v, defaults)).collect();
            format!("vec3({})", values.join(", "))
        }
        Node::Struct(word, fields) => {
            let usual = defaults.iter().find(|(name, ..)| name == word);
            let base = usual.map(|(.., text)| parse(&mut text().as_str()));
            let is_usual = |name: &str, value: &Node| match &base {
                Some(Node::Struct(_, usual)) => usual.iter().any(|(n, v)| n == name && v == value),
                _ => false,
            };
            let changed: Vec<&(String, Node)> =
                fields.iter().filter(|(name, value)| !is_usual(name, value)).collect();
            let mut parts: Vec<String> = changed
                .iter()
                .map(|(name, value)| format!("{name}: {}", write(value, defaults)))
                .collect();
            if let Some((_, expression, _)) = usual.filter(|_| changed.len() < fields.len()) {
                if parts.is_empty() {
                    return (*expression).to_owned();
                }
                parts.push(format!("..{expression}"));
            }
            format!("{}{word} {{ {} }}", path(word, false), parts.join(", "))
        }
    }
}

/// A number, or a name unchanged.
fn atom(word: &str) -> &str {
    match word {
        "NaN" => "f32::NAN",
        "inf" => "f32::INFINITY",
        "-inf" => "f32::NEG_INFINITY",
        _ => word,
    }
}

/// The enum of a variant, which `Debug` leaves out.
fn path(variant: &str, is_tuple: bool) -> &'static str {
    match variant {
        "Static" | "Kinematic" | "Dynamic" => "BodyKind::",
        "FromShapes" | "Exact" => "MassDef::",
        "Mass" if is_tuple => "MassDef::",
        "GeometricMean" | "Multiply" | "Maximum" | "Minimum" | "Average" => "Combine::",
        "Free" | "Locked" | "Limited" => "JointMotion::",
        "Ball" | "Distance" => "JointKind::",
        "SixDof" | "Pulley" if is_tuple => "JointKind::",
        "Equal" | "AtMost" => "LinkKind::",
        "Spring" if is_tuple => "LinkKind::",
        "Rate" | "Frequency" => "LinkSpring::",
        "Sphere" | "Capsule" | "Box" | "Cylinder" | "Cone" | "HalfSpace" => "Shape::",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use drystone::joint::{Hinge, JointAxis};
    use drystone::{Filter, JointKind, Material, vec3};

    use super::{Default, plain};

    const DEFAULTS: &[Default] =
        &[("JointAxis", "JointAxis::FREE", || format!("{:?}", JointAxis::FREE))];

    fn of<T: core::fmt::Debug>(value: &T) -> String {
        plain(&format!("{value:?}"), DEFAULTS)
    }

    #[test]
    fn values_become_the_source_that_makes_them() {
        assert_eq!(of(&Some(vec3(1.0, f32::NAN, -0.0))), "Some(vec3(1.0, f32::NAN, -0.0))");
        assert_eq!(of(&JointAxis::FREE), "JointAxis::FREE");
        assert_eq!(
            of(&JointAxis::limited(f32::NEG_INFINITY, 1e20)),
            "JointAxis { motion: JointMotion::Limited { min: f32::NEG_INFINITY, max: 1e20, spring: None }, \
             ..JointAxis::FREE }"
        );
        let six = of(&JointKind::SixDof(Hinge::new().six_dof()));
        assert!(six.starts_with("JointKind::SixDof(SixDof { frame_a: Quat { x: 0.0"), "{six}");
        assert!(of(&Material::default()).contains("friction_combine: Combine::GeometricMean"));
        assert_eq!(of(&[Filter::default()]).matches("layers: 1").count(), 1);
    }
}
