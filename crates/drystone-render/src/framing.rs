//! Places a camera so that it shows the relevant part of a scene.

use std::ops::Range;

use drystone::geometry::Aabb;
use drystone::{BodyKind, Pose, Vec3, World};

use crate::camera::{Camera, FIELD_OF_VIEW, horizontal_axes, spherical};

/// Maximum fraction of the picture's width and height that the subject takes.
const FILL: f32 = 0.84;
/// A body has left the scene if it is this many times farther from the middle than four fifths of
/// the other bodies.
const FAR_OFF: f32 = 4.0;

/// The subject of a picture: the boxes around the bodies that matter.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// Direction against gravity, unit [world].
    pub up: Vec3,
    /// The box around the whole subject [m, world].
    pub bounds: Aabb,
    /// The box around everything that can move [m, world].
    pub(crate) core: Aabb,
    boxes: Vec<Aabb>,
}

/// The direction of a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewAngles {
    /// Angle about the vertical, from the front toward the right [rad]. The front is +z if y is up,
    /// and −y if z is up.
    pub yaw: f32,
    /// Angle above the horizon [rad].
    pub pitch: f32,
}

impl Subject {
    /// The subject of a world in its current state: bodies that can move and have not left the
    /// others far behind, and static shapes of their size near them. The ground is not part of it.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let up = (-world.config().gravity).normalize_or(Vec3::Y);
        let (mut moving, mut fixed) = (Vec::new(), Vec::new());
        let mut fastest: Option<(Range<usize>, f32)> = None;
        for body in world.bodies() {
            let shapes = body.shapes().filter_map(|id| world.shape(id));
            let boxes = shapes.filter(|s| !s.is_sensor()).map(|s| s.bounds());
            let boxes = boxes.filter(|b| size(b) < 1.0e5);
            if body.kind() == BodyKind::Static {
                fixed.extend(boxes);
                continue;
            }
            let first = moving.len();
            moving.extend(boxes);
            let speed = body.linear_velocity().length();
            if moving.len() > first && fastest.as_ref().is_none_or(|(_, most)| speed > *most) {
                fastest = Some((first..moving.len(), speed));
            }
        }
        if let Some((shot, speed)) = fastest {
            leave_out_shot(&mut moving, shot, speed);
        }
        // A sample of a cloud's particles is enough to locate it.
        let every = 1 + world.counts().particles / 2000;
        for particle in world.particles().step_by(every) {
            moving
                .push(Aabb::new(particle.position(), particle.position()).grown(particle.radius()));
        }
        let mut boxes = together(moving);
        let core = union(&boxes);
        let anchors = world.joints().flat_map(|j| [j.anchor_a(), j.anchor_b()]);
        let near = core.grown(2.0 * size(&core));
        boxes.extend(anchors.map(|a| Aabb::new(a, a)).filter(|a| near.contains(a)));
        if boxes.is_empty() {
            boxes = together(fixed);
        } else {
            let largest = 1.5 * size(&core);
            let reach = core.grown(0.6 * size(&core));
            boxes.extend(fixed.into_iter().filter(|b| size(b) <= largest && b.overlaps(&reach)));
        }
        if boxes.is_empty() {
            boxes.push(Aabb::new(Vec3::splat(-1.0), Vec3::ONE));
        }
        let core = if core.center().is_finite() { core } else { union(&boxes) };
        Self { up, bounds: union(&boxes), core, boxes }
    }

    /// The union of two subjects.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        self.boxes.extend(&other.boxes);
        self.bounds = self.bounds.union(&other.bounds);
        self.core = self.core.union(&other.core);
        self
    }

    /// Radius of a ball about the middle that contains the subject [m].
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.bounds.half_extents().length().max(1.0e-3)
    }

    /// A view of the subject's broad side, from slightly right and above. A flatter subject is seen
    /// from higher above.
    #[must_use]
    pub fn angles(&self) -> ViewAngles {
        let half = self.bounds.half_extents();
        let (side, ahead) = horizontal_axes(self.up);
        let along = |axis: Vec3| half.dot(axis.abs());
        let (wide, deep, high) = (along(side), along(ahead), along(self.up));
        let quarter = if deep > 1.3 * wide { core::f32::consts::FRAC_PI_2 } else { 0.0 };
        let flat = (high / wide.max(deep).max(1.0e-6)).clamp(0.0, 1.0);
        ViewAngles { yaw: quarter + 0.52, pitch: 0.20 + 0.28 * (1.0 - flat) }
    }

    /// The camera that sees the whole subject from these angles, in a picture `aspect` times as
    /// wide as high.
    #[must_use]
    pub fn camera(&self, angles: ViewAngles, aspect: f32) -> Camera {
        let middle = self.bounds.center();
        let toward = spherical(self.up, angles.yaw, angles.pitch.clamp(-1.55, 1.55));
        let mut camera = Camera {
            eye: middle + toward,
            target: middle,
            up: self.up,
            field_of_view: FIELD_OF_VIEW,
        };
        let [right, above, forward] = camera.axes();
        let (half_height, half_width) = camera.half_size(aspect);
        let (h, w) = (half_height * FILL, half_width * FILL);
        // Each edge of the picture is a plane through the eye; every corner must be inside it.
        let mut most = [f32::NEG_INFINITY; 4];
        let mut nearest = f32::INFINITY;
        for corner in self.boxes.iter().flat_map(corners) {
            let r = corner - middle;
            let (x, y, z) = (r.dot(right), r.dot(above), r.dot(forward));
            let edges = [x - w * z, -x - w * z, y - h * z, -y - h * z];
            for (most, edge) in most.iter_mut().zip(edges) {
                *most = most.max(edge);
            }
            nearest = nearest.min(z);
        }
        let [r, l, a, b] = most;
        let back = ((r + l) / (2.0 * w)).max((a + b) / (2.0 * h));
        let back = back.max(-nearest * 1.02).max(0.02 * self.radius()).max(1.0e-3);
        let aside = right * (0.5 * (r - l)) + above * (0.5 * (a - b));
        camera.target = middle + aside;
        camera.eye = camera.target - forward * back;
        camera
    }
}

/// A camera for a film. It begins where the whole subject is visible, and moves back smoothly as
/// the subject spreads.
#[derive(Clone, Debug)]
pub struct Follow {
    start: Subject,
    angles: ViewAngles,
    aspect: f32,
    camera: Option<Camera>,
}

impl Follow {
    /// Makes a camera for a film that begins with this subject, in pictures `aspect` times as wide
    /// as high.
    #[must_use]
    pub fn new(start: Subject, angles: ViewAngles, aspect: f32) -> Self {
        Self { start, angles, aspect, camera: None }
    }

    /// The camera for the world `dt` [s] after the previous call, turned by `turn` [rad] since the
    /// start.
    pub fn next(&mut self, world: &World, dt: f32, turn: f32) -> Camera {
        let subject = Subject::of(world).with(&self.start);
        let wanted = subject.camera(self.angles, self.aspect);
        // Covers two thirds of the distance in about 0.7 s (an exponential approach).
        let part = (dt / (0.7 + dt)).clamp(0.0, 1.0);
        let camera = match self.camera {
            None => wanted,
            Some(c) => Camera {
                eye: c.eye.lerp(wanted.eye, part),
                target: c.target.lerp(wanted.target, part),
                ..wanted
            },
        };
        self.camera = Some(camera);
        if turn == 0.0 {
            return camera;
        }
        // Turns about the middle of the initial subject, far enough away to see it from all sides.
        let around = Subject { boxes: vec![ball_box(&self.start)], ..self.start.clone() };
        let angles = ViewAngles { yaw: self.angles.yaw + turn, ..self.angles };
        let round = around.camera(angles, self.aspect);
        Camera { eye: camera.target + (round.eye - round.target), ..camera }
    }
}

/// The box of the upright cylinder that a subject sweeps as it turns about the vertical.
fn ball_box(subject: &Subject) -> Aabb {
    let (half, up) = (subject.bounds.half_extents(), subject.up);
    let high = half.dot(up.abs());
    let flat = (half.length_squared() - high * high).max(0.0).sqrt();
    let reach = up.abs() * high + (Vec3::ONE - up.abs()) * (0.8 * flat);
    let center = subject.bounds.center();
    Aabb::new(center - reach, center + reach)
}

/// Removes the boxes of the fastest body if it is a projectile in flight: small, outside all other
/// boxes, and fast enough to cross them within a second. Its target matters, and its path is long.
fn leave_out_shot(boxes: &mut Vec<Aabb>, shot: Range<usize>, speed: f32) {
    let own = union(&boxes[shot.clone()]);
    let rest = union(&boxes[..shot.start]).union(&union(&boxes[shot.end..]));
    let radius = rest.half_extents().length();
    let away = (own.center() - rest.center()).length();
    let several = boxes.len() - shot.len() >= 2;
    if several && speed > radius && away > 1.2 * radius && size(&own) < 0.2 * radius {
        boxes.drain(shot);
    }
}

/// The boxes that are not far from the others.
fn together(boxes: Vec<Aabb>) -> Vec<Aabb> {
    if boxes.len() < 3 {
        return boxes;
    }
    let middle_of = |axis: usize| {
        let mut at: Vec<f32> = boxes.iter().map(|b| b.center()[axis]).collect();
        let half = at.len() / 2;
        *at.select_nth_unstable_by(half, f32::total_cmp).1
    };
    let middle = Vec3::from([middle_of(0), middle_of(1), middle_of(2)]);
    let distance = |b: &Aabb| (b.center() - middle).length();
    let mut distances: Vec<f32> = boxes.iter().map(distance).collect();
    let rank = distances.len() * 4 / 5;
    let usual = *distances.select_nth_unstable_by(rank, f32::total_cmp).1;
    boxes.into_iter().filter(|b| distance(b) <= FAR_OFF * usual + 2.0 * size(b)).collect()
}

/// Half the longest edge [m]; infinite if the box is not finite.
fn size(b: &Aabb) -> f32 {
    let half = b.half_extents();
    if b.center().is_finite() && half.is_finite() { half.max_element() } else { f32::INFINITY }
}

fn union(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b))
}

fn corners(b: &Aabb) -> impl Iterator<Item = Vec3> + use<> {
    let pose = Pose::at(b.center());
    let half = b.half_extents();
    (0..8_u8).map(move |i| {
        let sign = |bit: u8| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        pose.point(half.mul_each(Vec3::from([sign(0), sign(1), sign(2)])))
    })
}

#[cfg(test)]
mod tests {
    use drystone::{BodyDef, ShapeDef, World, vec3};

    use super::{Follow, Subject, Vec3, corners};

    fn stack(n: u8) -> World {
        let mut world = World::default();
        let ground = BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0));
        world.add_body(ground).unwrap();
        for i in 0..n {
            let at = vec3(0.0, 0.5 + f32::from(i), 0.0);
            let body = BodyDef::dynamic().with_position(at);
            world.add_body(body.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
        }
        world
    }

    #[test]
    fn all_corners_are_in_the_picture_and_it_is_filled() {
        for (n, aspect) in [(1, 1.0), (20, 1.78), (3, 0.5)] {
            let subject = Subject::of(&stack(n));
            let camera = subject.camera(subject.angles(), aspect);
            let (half_height, half_width) = camera.half_size(aspect);
            let [right, above, forward] = camera.axes();
            let mut most: f32 = 0.0;
            for corner in corners(&subject.bounds) {
                let r = corner - camera.eye;
                let z = r.dot(forward);
                assert!(z > 0.0);
                let (x, y) = (r.dot(right) / z / half_width, r.dot(above) / z / half_height);
                most = most.max(x.abs()).max(y.abs());
            }
            assert!((most - super::FILL).abs() < 1.0e-3, "{n} boxes: filled to {most}");
        }
    }

    #[test]
    fn a_body_that_left_the_scene_does_not_empty_the_picture() {
        let mut world = stack(10);
        let bounds = Subject::of(&world).bounds;
        let far = BodyDef::dynamic().with_position([0.0, -500.0, 300.0]);
        world.add_body(far.with_shape(ShapeDef::sphere(0.5))).unwrap();
        assert_eq!(Subject::of(&world).bounds, bounds);
        assert_eq!(Subject::of(&World::default()).bounds.center(), Vec3::ZERO);
    }

    #[test]
    fn a_shot_is_in_the_picture_when_it_arrives() {
        let mut world = stack(4);
        let bounds = Subject::of(&world).bounds;
        let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.1));
        let ball = ball.with_position([0.0, 1.0, 12.0]).with_linear_velocity([0.0, 0.0, -15.0]);
        let ball = world.add_body(ball).unwrap();
        assert_eq!(Subject::of(&world).bounds, bounds);
        world.body_mut(ball).unwrap().set_linear_velocity(Vec3::ZERO);
        assert!(Subject::of(&world).bounds.max.z > 12.0, "what rests there is part of the scene");
        let near = drystone::Pose::at(vec3(0.0, 1.0, 1.5));
        world.body_mut(ball).unwrap().set_pose(near);
        world.body_mut(ball).unwrap().set_linear_velocity(vec3(0.0, 0.0, -15.0));
        assert!(Subject::of(&world).bounds.max.z > 1.5);
    }

    #[test]
    fn a_film_of_something_at_rest_stands_still() {
        let world = stack(4);
        let subject = Subject::of(&world);
        let mut follow = Follow::new(subject.clone(), subject.angles(), 1.5);
        let first = follow.next(&world, 0.0, 0.0);
        let later = follow.next(&world, 0.1, 0.0);
        assert!((first.eye - later.eye).length() < 1.0e-5);
    }
}
