//! Sensors.

/// A thing that a sensor is about.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    /// A joint, by its number.
    Joint(usize),
    /// A tendon, by its number.
    Tendon(usize),
    /// An actuator, by its number.
    Actuator(usize),
    /// A site, by its number.
    Site(usize),
    /// A link by its name, and whether its frame is the inertial one, at its center of mass.
    Link {
        /// Its name.
        name: String,
        /// Whether the frame of its inertia is meant.
        inertial: bool,
    },
    /// A shape, by its name.
    Geom(String),
    /// Another thing of the file, by its kind and its name.
    Other(String, String),
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Its name, empty if it has none.
    pub name: String,
    /// Its kind, as MJCF calls it: `gyro`, `jointpos`, `framequat` and so on.
    pub kind: String,
    /// The thing that it is about; `None` for those of the whole world, such as `clock`.
    pub object: Option<Object>,
    /// The thing that it is measured in or against.
    pub reference: Option<Object>,
    /// How many numbers it gives; `None`: it depends on more than the file says.
    pub size: Option<usize>,
    /// Bound of its readings, 0 for none.
    pub cutoff: f32,
    /// Standard deviation of its noise, which is not applied.
    pub noise: f32,
}
