//! A film: where the bodies of a scene are over time, by keys on the nodes above them.

use drystone::math::Mat3;
use drystone::{Pose, Quat, Vec3, vec3};

use super::parts::SceneBody;
use crate::transform::{Affine, slerp, split};

/// Where the bodies of a scene are over time.
#[derive(Clone, Debug)]
pub struct Film {
    /// The nodes above each body and its own, ancestors first.
    chains: Vec<Vec<Link>>,
    /// Bodies that have no size at first, and from when on they are there [s], in the order of
    /// their times; their numbers follow those of the scene's bodies.
    late: Vec<(f32, SceneBody)>,
    /// From when on each body is gone [s]; infinity if it stays.
    gone: Vec<f32>,
    seconds: f32,
}

/// A node above a body, or its own.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    /// To the node above it.
    pub(crate) local: Affine,
    /// The rotation in it.
    pub(crate) turn: Quat,
    /// The keys that move it, if any.
    pub(crate) keys: Option<Keys>,
}

/// Keys that move a node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Keys {
    pub(crate) translation: Option<Sampler>,
    pub(crate) rotation: Option<Sampler>,
    pub(crate) scale: Option<Sampler>,
    /// Translation, rotation and scale where no key moves them.
    pub(crate) rest: (Vec3, Quat, Vec3),
}

/// Interpolation between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Between {
    Step,
    Linear,
    Cubic,
}

/// Keys of one property of a node.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    /// Times, rising [s].
    pub(crate) times: Vec<f32>,
    /// Three a key for cubic curves: the slope before it, itself, the slope after it.
    pub(crate) values: Vec<[f32; 4]>,
    pub(crate) between: Between,
}

impl Film {
    /// A film of `seconds` with bodies that are there from the start, by their chains, and others
    /// that come at a time [s]; times are sorted here.
    pub(crate) fn new(
        mut chains: Vec<Vec<Link>>,
        mut late: Vec<(f32, SceneBody, Vec<Link>)>,
        seconds: f32,
    ) -> Self {
        late.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut bodies = Vec::with_capacity(late.len());
        for (from, body, chain) in late {
            bodies.push((from, body));
            chains.push(chain);
        }
        let vanishes = |chain: &Vec<Link>| chain.last().and_then(Link::vanishes);
        let gone = chains.iter().map(|c| vanishes(c).unwrap_or(f32::INFINITY)).collect();
        Self { chains, late: bodies, gone, seconds }
    }

    /// How long it is [s].
    #[must_use]
    pub const fn seconds(&self) -> f32 {
        self.seconds
    }

    /// Where a body is at a time [s], by its number [world].
    #[must_use]
    pub fn pose(&self, body: usize, time: f32) -> Pose {
        let mut world = Affine { linear: Mat3::IDENTITY, translation: Vec3::ZERO };
        let mut turn = Quat::IDENTITY;
        for link in self.chains.get(body).into_iter().flatten() {
            let (local, own) = link.at(time);
            world = world.compose(&local);
            turn = (turn * own).normalized();
        }
        let (rotation, _, _) = split(world.linear, turn);
        Pose::new(world.translation, rotation)
    }

    /// Whether a body that was there is gone at a time [s], by its number.
    pub(crate) fn is_gone(&self, body: usize, time: f32) -> bool {
        self.gone.get(body).is_some_and(|from| *from <= time)
    }

    /// The late body of a number among all that is to be there at a time [s].
    pub(crate) fn late(&self, number: usize, time: f32) -> Option<&SceneBody> {
        let first = self.chains.len() - self.late.len();
        let (from, body) = self.late.get(number.checked_sub(first)?)?;
        (*from <= time).then_some(body)
    }
}

impl Link {
    /// Its map to the node above it at a time [s], and the rotation in that.
    fn at(&self, time: f32) -> (Affine, Quat) {
        let Some(keys) = &self.keys else { return (self.local, self.turn) };
        let (translation, rotation, scale) = keys.rest;
        let vector = |sampler: &Option<Sampler>, rest: Vec3| {
            sampler.as_ref().map_or(rest, |s| {
                let [x, y, z, _] = s.at(time, false);
                vec3(x, y, z)
            })
        };
        let turn = keys.rotation.as_ref().map_or(rotation, |s| Quat::from(s.at(time, true)));
        let turn = turn.normalized();
        let (r, s) = (turn.to_mat3(), vector(&keys.scale, scale));
        let linear = Mat3 { x: r.x * s.x, y: r.y * s.y, z: r.z * s.z };
        (Affine { linear, translation: vector(&keys.translation, translation) }, turn)
    }

    /// When it gets a size, if it has none at first [s]; never is at infinity.
    pub(crate) fn appears(&self) -> Option<f32> {
        let scale = self.keys.as_ref()?.scale.as_ref()?;
        let size =
            |key: usize| scale.values.get(key).is_some_and(|v| v.iter().any(|x| x.abs() > 0.0));
        if scale.between != Between::Step || size(0) {
            return None;
        }
        let first = (1..scale.times.len()).find(|&key| size(key));
        Some(first.map_or(f32::INFINITY, |key| scale.times[key]))
    }

    /// When it loses its size for good, if it has one before [s].
    fn vanishes(&self) -> Option<f32> {
        let scale = self.keys.as_ref()?.scale.as_ref()?;
        let size =
            |key: &usize| scale.values.get(*key).is_some_and(|v| v.iter().any(|x| x.abs() > 0.0));
        if scale.between != Between::Step {
            return None;
        }
        let last = (0..scale.times.len()).rev().find(size)?;
        scale.times.get(last + 1).copied()
    }
}

impl Sampler {
    /// The value at a time [s]; `turns` if it is a rotation.
    fn at(&self, time: f32, turns: bool) -> [f32; 4] {
        let cubic = self.between == Between::Cubic;
        let value = |key: usize, part: usize| {
            let at = if cubic { 3 * key + part } else { key };
            self.values.get(at).copied().unwrap_or_default()
        };
        let next = self.times.partition_point(|t| *t <= time);
        if next == 0 || next == self.times.len() {
            return value(next.saturating_sub(1), 1);
        }
        let (from, to) = (next - 1, next);
        let length = self.times[to] - self.times[from];
        let t = (time - self.times[from]) / length;
        let (a, b) = (value(from, 1), value(to, 1));
        match self.between {
            Between::Step => a,
            Between::Linear if turns => {
                slerp(Quat::from(a).normalized(), Quat::from(b).normalized(), t).to_array()
            }
            Between::Linear => std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t),
            Between::Cubic => {
                let (out, into) = (value(from, 2), value(to, 0));
                let (t2, t3) = (t * t, t * t * t);
                std::array::from_fn(|i| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                        + (t3 - 2.0 * t2 + t) * length * out[i]
                        + (3.0 * t2 - 2.0 * t3) * b[i]
                        + (t3 - t2) * length * into[i]
                })
            }
        }
    }
}
