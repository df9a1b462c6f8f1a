//! Values of the format that can be said in more than one way: a turn, a mass, a name or the thing
//! itself.
//!
//! Each is read by hand, not by an untagged enum of serde: that one forgets where it was and what
//! it expected.

use core::fmt;
use core::marker::PhantomData;
use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Three numbers.
pub(crate) type Triple = [f32; 3];

/// A number that may be infinite: `"inf"` or `"-inf"`, which JSON has no number for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound(pub(crate) f32);

impl Serialize for Bound {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0 == f32::INFINITY {
            serializer.serialize_str("inf")
        } else if self.0 == f32::NEG_INFINITY {
            serializer.serialize_str("-inf")
        } else {
            serializer.serialize_f32(self.0)
        }
    }
}

impl<'de> Deserialize<'de> for Bound {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(BoundVisitor)
    }
}

struct BoundVisitor;

#[expect(clippy::cast_possible_truncation, reason = "numbers are read as f32")]
#[expect(clippy::cast_precision_loss, reason = "numbers are read as f32")]
impl Visitor<'_> for BoundVisitor {
    type Value = Bound;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, \"inf\" or \"-inf\"")
    }

    fn visit_f64<E: Error>(self, v: f64) -> Result<Bound, E> {
        Ok(Bound(v as f32))
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<Bound, E> {
        Ok(Bound(v as f32))
    }

    fn visit_i64<E: Error>(self, v: i64) -> Result<Bound, E> {
        Ok(Bound(v as f32))
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<Bound, E> {
        match v {
            "inf" => Ok(Bound(f32::INFINITY)),
            "-inf" => Ok(Bound(f32::NEG_INFINITY)),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(v), &self)),
        }
    }
}

impl JsonSchema for Bound {
    fn schema_name() -> Cow<'static, str> {
        "Bound".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, or \"inf\" or \"-inf\".",
            "anyOf": [{"type": "number"}, {"enum": ["inf", "-inf"]}]
        })
    }
}

/// A rotation: a unit quaternion `[x, y, z, w]`, or an axis of any length with an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Turn {
    /// The four numbers as they are.
    Quaternion([f32; 4]),
    /// About this axis by this angle [degrees].
    About(AxisAngle),
}

/// A turn about an axis, by the right hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AxisAngle {
    /// The axis, of any length but none.
    pub(crate) axis: Triple,
    /// The angle [degrees].
    pub(crate) degrees: f32,
}

impl Serialize for Turn {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Quaternion(q) => q.serialize(serializer),
            Self::About(about) => about.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Turn {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TurnVisitor)
    }
}

struct TurnVisitor;

impl<'de> Visitor<'de> for TurnVisitor {
    type Value = Turn;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a unit quaternion [x, y, z, w], or {\"axis\": [x, y, z], \"degrees\": angle}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Turn, A::Error> {
        let mut q = [0.0; 4];
        for (i, slot) in q.iter_mut().enumerate() {
            *slot = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        if seq.next_element::<f32>()?.is_some() {
            return Err(A::Error::invalid_length(5, &self));
        }
        Ok(Turn::Quaternion(q))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Turn, A::Error> {
        AxisAngle::deserialize(MapAccessDeserializer::new(map)).map(Turn::About)
    }
}

impl JsonSchema for Turn {
    fn schema_name() -> Cow<'static, str> {
        "Turn".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let about = generator.subschema_for::<AxisAngle>();
        json_schema!({
            "description": "A rotation: a unit quaternion [x, y, z, w], or a turn about an axis.",
            "anyOf": [
                {"type": "array", "items": {"type": "number"}, "minItems": 4, "maxItems": 4},
                about
            ]
        })
    }
}

/// A reference to another thing of the file: its name, or its number in its list, counted from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Ref {
    /// By name.
    Name(String),
    /// By number.
    Number(usize),
}

impl Default for Ref {
    fn default() -> Self {
        Self::Number(0)
    }
}

impl Serialize for Ref {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Name(name) => serializer.serialize_str(name),
            Self::Number(n) => n.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Ref {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RefVisitor)
    }
}

struct RefVisitor;

impl Visitor<'_> for RefVisitor {
    type Value = Ref;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name, or a number counted from 0")
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<Ref, E> {
        Ok(Ref::Name(v.to_owned()))
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<Ref, E> {
        usize::try_from(v).map(Ref::Number).map_err(|_| E::custom("a number that is too large"))
    }
}

impl JsonSchema for Ref {
    fn schema_name() -> Cow<'static, str> {
        "Ref".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A name, or a number in the list, counted from 0.",
            "anyOf": [{"type": "string"}, {"type": "integer", "minimum": 0}]
        })
    }
}

/// A thing that stands here, or the name of one of a table at the top of the file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Or<T> {
    /// By name.
    Name(String),
    /// Here.
    Here(T),
}

impl<T: Serialize> Serialize for Or<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Name(name) => serializer.serialize_str(name),
            Self::Here(value) => value.serialize(serializer),
        }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Or<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OrVisitor(PhantomData))
    }
}

struct OrVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for OrVisitor<T> {
    type Value = Or<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name, or an object in place")
    }

    fn visit_str<E: Error>(self, v: &str) -> Result<Or<T>, E> {
        Ok(Or::Name(v.to_owned()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Or<T>, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(Or::Here)
    }
}

impl<T: JsonSchema> JsonSchema for Or<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("NameOr{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let here = generator.subschema_for::<T>();
        json_schema!({"anyOf": [{"type": "string", "description": "Its name."}, here]})
    }
}

/// The mass of a body: a number [kg], or all of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mass {
    /// Mass alone [kg]: center and inertia are in proportion to the shapes.
    Total(f32),
    /// Given in full.
    Full(FullMass),
}

/// Mass, center of mass and inertia of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FullMass {
    /// Mass [kg]; above 0.
    pub(crate) mass: f32,
    /// Center of mass [m, body]; the origin if left out.
    pub(crate) center: Option<Triple>,
    /// Inertia about the center of mass [kg m², body]: `[xx, yy, zz]`, or `[xx, yy, zz, xy, xz,
    /// yz]`. Zero along a principal axis locks the turn about it.
    #[schemars(length(min = 3, max = 6))]
    pub(crate) inertia: Vec<f32>,
}

impl Serialize for Mass {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Total(mass) => serializer.serialize_f32(*mass),
            Self::Full(full) => full.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Mass {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(MassVisitor)
    }
}

struct MassVisitor;

#[expect(clippy::cast_possible_truncation, reason = "numbers are read as f32")]
#[expect(clippy::cast_precision_loss, reason = "numbers are read as f32")]
impl<'de> Visitor<'de> for MassVisitor {
    type Value = Mass;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number of kg, or {\"mass\": kg, \"center\": [x, y, z], \"inertia\": [..]}")
    }

    fn visit_f64<E: Error>(self, v: f64) -> Result<Mass, E> {
        Ok(Mass::Total(v as f32))
    }

    fn visit_u64<E: Error>(self, v: u64) -> Result<Mass, E> {
        Ok(Mass::Total(v as f32))
    }

    fn visit_i64<E: Error>(self, v: i64) -> Result<Mass, E> {
        Ok(Mass::Total(v as f32))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Mass, A::Error> {
        FullMass::deserialize(MapAccessDeserializer::new(map)).map(Mass::Full)
    }
}

impl JsonSchema for Mass {
    fn schema_name() -> Cow<'static, str> {
        "Mass".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let full = generator.subschema_for::<FullMass>();
        json_schema!({"anyOf": [{"type": "number", "description": "Mass [kg]."}, full]})
    }
}

/// Things by name, in the order of the file. A name that is there twice is refused: serde's maps
/// keep the last one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table<T>(pub(crate) Vec<(String, T)>);

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Table<T> {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T: Serialize> Serialize for Table<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Table<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TableVisitor(PhantomData))
    }
}

struct TableVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for TableVisitor<T> {
    type Value = Table<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object with a name for each")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Table<T>, A::Error> {
        let mut all = Vec::new();
        let mut names = std::collections::BTreeSet::new();
        while let Some((name, value)) = map.next_entry::<String, T>()? {
            if !names.insert(name.clone()) {
                return Err(A::Error::custom(format_args!("the name `{name}` is there twice")));
            }
            all.push((name, value));
        }
        Ok(Table(all))
    }
}

impl<T: JsonSchema> JsonSchema for Table<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("TableOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let value = generator.subschema_for::<T>();
        json_schema!({"type": "object", "additionalProperties": value})
    }
}
