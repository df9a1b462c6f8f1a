//! Event reports of a shape's contacts.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::DefError;
use super::check::within;
use crate::base::limits;

/// The events that the contacts of a shape report. Both shapes of a pair count.
///
/// ```
/// use drystone::ShapeDef;
/// use drystone::events::ContactReports;
///
/// let glass = ContactReports { hit_speed: Some(0.2), ..ContactReports::default() };
/// let pane = ShapeDef::box_half([1.0, 1.0, 0.01]).with_reports(glass);
/// let scale = ShapeDef::box_half([0.5, 0.1, 0.5]).with_reports(ContactReports::with_forces());
/// # let _ = (pane, scale);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ContactReports {
    /// Begin and end of contacts: [`Events::contact_begin`](crate::events::Events::contact_begin)
    /// and [`Events::contact_end`](crate::events::Events::contact_end). A pair reports them only if
    /// both shapes say true. Default true.
    pub touches: bool,
    /// Landings: [`Events::hits`](crate::events::Events::hits). A pair reports them only if both
    /// shapes say true. Default true.
    pub hits: bool,
    /// Minimum approach speed of a hit [m/s]; default `None`: `contact.hit_speed` of the world. If
    /// both shapes of a pair set one, the lower is used.
    pub hit_speed: Option<f32>,
    /// Forces: [`Events::contact_forces`](crate::events::Events::contact_forces), for every step in
    /// which the pair touches. A pair reports them if one of its shapes says true. Default false.
    pub forces: bool,
}

impl Default for ContactReports {
    /// Touches and hits, no forces.
    fn default() -> Self {
        Self { touches: true, hits: true, hit_speed: None, forces: false }
    }
}

impl ContactReports {
    /// No reports.
    pub const NONE: Self = Self { touches: false, hits: false, hit_speed: None, forces: false };

    /// Touches, hits and forces.
    #[must_use]
    pub const fn with_forces() -> Self {
        Self { touches: true, hits: true, hit_speed: None, forces: true }
    }

    /// # Errors
    /// The speed is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        self.hit_speed
            .map_or(Ok(()), |speed| within("reports.hit_speed", speed, &limits::THRESHOLD))
    }
}

/// Additional objects that a sensor detects, besides the shapes of bodies that can move: see
/// [`ShapeDef::sensor`](crate::ShapeDef::sensor).
///
/// ```
/// use drystone::ShapeDef;
/// use drystone::events::Senses;
///
/// // A blast that asks which walls it reaches.
/// let blast = ShapeDef::sphere(3.0).as_sensor().with_senses(Senses { statics: true, ..Senses::default() });
/// # let _ = blast;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Senses {
    /// Whether a sensor on a static body detects the shapes of static bodies. Sensors of other
    /// bodies always do. Default false.
    pub statics: bool,
    /// Whether it detects sensors. Default false.
    pub sensors: bool,
}

impl Senses {
    const STATICS: u8 = 1;
    const SENSORS: u8 = 2;
}

/// Bits in addition to those of [`Senses`]: a one-way surface, and a shape whose contacts call
/// hooks.
const ONE_WAY: u8 = 4;
const HOOKS: u8 = 8;

/// Reports and senses, packed into the eight bytes reserved in a shape row.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct PackedReports {
    /// Below 0: the world's hit speed.
    hit_speed: f32,
    pub(crate) touches: bool,
    hits: bool,
    pub(crate) forces: bool,
    /// Bits of [`Senses`].
    senses: u8,
}

impl PackedReports {
    pub(crate) fn new(reports: &ContactReports, senses: Senses) -> Self {
        let ContactReports { touches, hits, hit_speed, forces } = *reports;
        let bit = |is_set: bool, bit: u8| if is_set { bit } else { 0 };
        let senses = bit(senses.statics, Senses::STATICS) | bit(senses.sensors, Senses::SENSORS);
        Self { hit_speed: hit_speed.unwrap_or(-1.0), touches, hits, forces, senses }
    }

    pub(crate) const fn senses(self) -> Senses {
        Senses { statics: self.sees_statics(), sensors: self.sees_sensors() }
    }

    /// Whether a step may drop its contacts.
    pub(crate) const fn is_asked(self) -> bool {
        self.is_one_way() || self.has_hooks()
    }

    pub(crate) const fn has_hooks(self) -> bool {
        self.senses & HOOKS != 0
    }

    pub(crate) const fn with_hooks(self, has_hooks: bool) -> Self {
        let others = self.senses & !HOOKS;
        Self { senses: if has_hooks { others | HOOKS } else { others }, ..self }
    }

    pub(crate) const fn is_one_way(self) -> bool {
        self.senses & ONE_WAY != 0
    }

    pub(crate) const fn with_one_way(self, is_one_way: bool) -> Self {
        let others = self.senses & !ONE_WAY;
        Self { senses: if is_one_way { others | ONE_WAY } else { others }, ..self }
    }

    pub(crate) const fn sees_statics(self) -> bool {
        self.senses & Senses::STATICS != 0
    }

    pub(crate) const fn sees_sensors(self) -> bool {
        self.senses & Senses::SENSORS != 0
    }

    pub(crate) fn unpacked(self) -> ContactReports {
        let Self { touches, hits, forces, .. } = self;
        ContactReports { touches, hits, hit_speed: self.given_hit_speed(), forces }
    }

    pub(crate) fn has_hit_speed(self) -> bool {
        self.hit_speed >= 0.0
    }

    fn given_hit_speed(self) -> Option<f32> {
        self.has_hit_speed().then_some(self.hit_speed)
    }

    /// Whether a pair of shapes reports its begin and end of contact.
    pub(crate) const fn touch(self, other: Self) -> bool {
        self.touches && other.touches
    }

    /// Approach speed above which a pair of shapes reports a hit [m/s], given the world's; `None`:
    /// never.
    pub(crate) fn hit_speed_with(self, other: Self, world: f32) -> Option<f32> {
        let given = [self, other].into_iter().filter_map(Self::given_hit_speed).reduce(f32::min);
        (self.hits && other.hits).then(|| given.unwrap_or(world))
    }
}
