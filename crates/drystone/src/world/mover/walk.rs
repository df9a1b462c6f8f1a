//! One move of a [`Mover`]: out of overlaps, along the ground or over a step, up or down, and back
//! onto the ground.

use super::{Moved, Mover, MoverHit};
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::query::cast::ShapeHit;
use crate::query::filter::{Inside, QueryFilter};
use crate::state::def::DefError;
use crate::world::World;

/// Maximum number of surfaces that bend one displacement.
const MAX_BENDS: usize = 6;
/// Maximum number of pushes out of overlaps.
const MAX_PUSHES: usize = 8;
/// Length of the first cast, in skins. A cast resolves hits only to a fraction of its length, so
/// near obstacles need a short one. After a cast without a hit the next one is ten times as long.
const LONGEST: f32 = 1.0e4;
/// Maximum number of casts along one displacement; more than the longest one needs.
const MAX_LOOKS: usize = 32;
/// Relative accuracy of the hit fraction of a cast.
const ROUNDING: f32 = 1.0e-6;
/// A displacement within this cosine of a surface's tangent does not run into the surface.
const ALONG: f32 = 1.0e-5;

/// Treatment of steep surfaces.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// Steep surfaces are walls and lift nothing.
    Level,
    /// The shape slides along steep surfaces, and stops on ground.
    Down,
    /// The shape slides along steep surfaces.
    Up,
}

/// Walkable ground.
#[derive(Clone, Copy)]
struct Ground {
    /// Position of the shape on the ground.
    at: Vec3,
    hit: ShapeHit,
    normal: Vec3,
}

/// The settings of one move.
pub(super) struct Walk<'a, 'f> {
    pub(super) world: &'a World,
    pub(super) mover: &'a Mover,
    pub(super) filter: QueryFilter<'f>,
    pub(super) rotation: Quat,
    /// Upward direction, unit.
    pub(super) up: Vec3,
    /// Minimum upward component of the normal of walkable ground.
    pub(super) flattest: f32,
}

impl Walk<'_, '_> {
    /// Runs the whole move.
    pub(super) fn all(&self, from: Vec3, delta: Vec3, moved: &mut Moved) -> Result<(), DefError> {
        let mover = self.mover;
        moved.hits.clear();
        let rise = delta.dot(self.up);
        let level = delta - self.up * rise;
        let start = self.push_out(from)?;
        let stood = if rise > 0.0 { None } else { self.ground(start, 0.0, moved)? };
        let level = stood.map_or(level, |ground| on_ground(level, ground.normal));
        let mut at = self.slide(start, level, Mode::Level, moved)?;
        if let Some(stood) = &stood
            && mover.step > 0.0
            && moved.hits.iter().any(|hit| hit.normal.dot(self.up) < self.flattest)
        {
            at = self.climb(start, level, at, stood, moved)?;
        }
        let mode = if rise > 0.0 { Mode::Up } else { Mode::Down };
        at = self.slide(at, self.up * rise, mode, moved)?;
        let snap = if stood.is_some() { mover.snap } else { 0.0 };
        let ground = if rise > 0.0 { None } else { self.ground(at, snap, moved)? };
        moved.pose =
            Pose { position: ground.map_or(at, |ground| ground.at), rotation: self.rotation };
        moved.grounded = ground.is_some();
        moved.ground = ground.map(|ground| ground.hit.body);
        moved.ground_point = ground.map_or(Vec3::ZERO, |ground| ground.hit.point);
        moved.ground_normal = ground.map_or(Vec3::ZERO, |ground| ground.normal);
        Ok(())
    }

    fn pose(&self, at: Vec3) -> Pose {
        Pose { position: at, rotation: self.rotation }
    }

    fn filter(&self) -> QueryFilter<'_> {
        self.filter.with_inside(Inside::Solid)
    }

    /// Pushes the shape out of overlaps, the deepest first.
    fn push_out(&self, mut at: Vec3) -> Result<Vec3, DefError> {
        let (query, shape) = (self.world.query(), &self.mover.shape);
        let holds = |shape: crate::ShapeRef<'_>| {
            shape.one_way().is_none() && self.filter.predicate.is_none_or(|sees| sees(shape))
        };
        let filter = self.filter().with_predicate(&holds);
        for _ in 0..MAX_PUSHES {
            let Some(near) = query.nearest_shape(shape, self.pose(at), 0.0, filter)? else { break };
            if near.distance >= 0.0 {
                break;
            }
            at -= near.normal * near.distance;
        }
        Ok(at)
    }

    /// Stores the surfaces in the path in `moved.found`, nearest first. Surfaces parallel to the
    /// path or facing away are left out. A slight overlap with a wall then does not block the
    /// shape.
    fn look(
        &self,
        from: Vec3,
        direction: Vec3,
        length: f32,
        moved: &mut Moved,
    ) -> Result<(), DefError> {
        let (query, displacement) = (self.world.query(), direction * length);
        let (shape, found) = (&self.mover.shape, &mut moved.found);
        query.cast_shape_all(shape, self.pose(from), displacement, self.filter(), found)?;
        found.retain(|hit| hit.normal.dot(direction) < -ALONG && self.is_held_by(hit, direction));
        Ok(())
    }

    /// True if the surface blocks a shape that comes from this side.
    fn is_held_by(&self, hit: &ShapeHit, direction: Vec3) -> bool {
        let Some(shape) = self.world.shape(hit.shape) else { return false };
        let Some(front) = shape.one_way() else { return true };
        let front = shape.pose().direction(front);
        !hit.inside && hit.normal.dot(front) > 0.0 && direction.dot(front) < 0.0
    }

    /// The distance that the shape can move [m], up to a skin before the first obstacle, and that
    /// obstacle.
    fn free_way(
        &self,
        from: Vec3,
        direction: Vec3,
        length: f32,
        moved: &mut Moved,
    ) -> Result<(f32, Option<ShapeHit>), DefError> {
        let skin = self.mover.skin;
        let (mut gone, mut longest) = (0.0, LONGEST * skin);
        for _ in 0..MAX_LOOKS {
            let left = lesser(length - gone, longest);
            let reach = left + skin;
            self.look(from + direction * gone, direction, reach, moved)?;
            let Some(hit) = moved.found.first().copied() else {
                if left < longest {
                    return Ok((length, None));
                }
                gone += left;
                longest *= 10.0;
                continue;
            };
            // One skin along the normal is a longer distance along an oblique path.
            let back = skin / greater(-hit.normal.dot(direction), 0.1);
            let (free, error) = (hit.fraction * reach - back, ROUNDING * reach);
            if reach <= 2.0 * LONGEST * skin {
                return Ok((gone + lesser(greater(free, 0.0), left), Some(hit)));
            }
            // The far cast is too inaccurate: move closer and cast again from there.
            gone += lesser(greater(free - error, 0.0), left);
            longest = LONGEST * skin;
        }
        Ok((gone, None))
    }

    /// Moves along a displacement and bends it at each obstacle.
    fn slide(
        &self,
        from: Vec3,
        delta: Vec3,
        mode: Mode,
        moved: &mut Moved,
    ) -> Result<Vec3, DefError> {
        let (mut at, mut left) = (from, delta);
        let mut planes = [Vec3::ZERO; MAX_BENDS];
        for bend in 0..MAX_BENDS {
            let length = left.length();
            let Some(direction) = left.try_normalize() else { break };
            let (free, hit) = self.free_way(at, direction, length, moved)?;
            at += direction * free;
            let Some(hit) = hit else { break };
            left = direction * (length - free);
            let ShapeHit { shape, body, point, normal, .. } = hit;
            let blocked = greater(-left.dot(normal), 0.0);
            moved.hits.push(MoverHit { shape, body, point, normal, blocked });
            if mode == Mode::Down && self.face(&hit)?.is_some() {
                break;
            }
            let is_wall = mode == Mode::Level && normal.dot(self.up) < self.flattest;
            let wall = (normal - self.up * normal.dot(self.up)).try_normalize();
            let wall = wall.filter(|wall| is_wall && wall.dot(left) < 0.0);
            planes[bend] = wall.unwrap_or(normal);
            let bent = along(left, &planes[..=bend]);
            // On ground the speed stays the same.
            let slows = bend > 0 || mode != Mode::Level || normal.dot(self.up) < self.flattest;
            left = if slows { bent } else { on_ground(left, normal) };
            // A displacement backwards would cause jitter in a corner.
            if left.dot(delta) <= 0.0 {
                break;
            }
        }
        Ok(at)
    }

    /// Moves up, along and down again. The result is used if it leads farther than the flat move,
    /// onto ground not higher than a step.
    fn climb(
        &self,
        from: Vec3,
        level: Vec3,
        flat: Vec3,
        stood: &Ground,
        moved: &mut Moved,
    ) -> Result<Vec3, DefError> {
        let (step, kept) = (self.mover.step, moved.hits.len());
        let (lift, _) = self.free_way(from, self.up, step, moved)?;
        let over = self.slide(from + self.up * lift, level, Mode::Level, moved)?;
        let farther = (over - flat).dot(level) > 1.0e-3 * level.length_squared();
        let ground = if farther { self.ground(over, lift, moved)? } else { None };
        let height = |ground: &Ground| (ground.hit.point - stood.hit.point).dot(self.up);
        // The height of a step of exactly this size may be rounded up.
        let maximum = step + 0.1 * self.mover.skin;
        let Some(ground) = ground.filter(|ground| height(ground) <= maximum) else {
            moved.hits.truncate(kept);
            return Ok(flat);
        };
        moved.hits.drain(..kept);
        Ok(ground.at)
    }

    /// The ground under a position, at most `reach` [m] plus the skin below it.
    fn ground(&self, at: Vec3, reach: f32, moved: &mut Moved) -> Result<Option<Ground>, DefError> {
        let skin = self.mover.skin;
        let reach = reach + skin / greater(self.flattest, 0.1) + skin;
        self.look(at, -self.up, reach, moved)?;
        let mut minimum = None;
        for hit in &moved.found {
            // A negative drop lifts the shape, to one skin above the ground.
            let drop = hit.fraction * reach - skin / greater(hit.normal.dot(self.up), 0.5);
            let minimum = *minimum.get_or_insert(drop);
            if drop > minimum + skin {
                break;
            }
            if let Some(normal) = self.face(hit)? {
                return Ok(Some(Ground { at: at - self.up * minimum, hit: *hit, normal }));
            }
        }
        Ok(None)
    }

    /// The normal of walkable ground: that of the hit or, at an edge, that of the face behind it.
    fn face(&self, hit: &ShapeHit) -> Result<Option<Vec3>, DefError> {
        let rise = hit.normal.dot(self.up);
        if rise >= self.flattest {
            return Ok(Some(hit.normal));
        }
        if rise <= 0.0 {
            return Ok(None);
        }
        let Some(back) = (self.up * rise - hit.normal).try_normalize() else { return Ok(None) };
        let skin = self.mover.skin;
        let above = hit.point + back * skin + self.up * (5.0 * skin);
        let seen = self.world.query().cast_ray(above, self.up * (-10.0 * skin), self.filter())?;
        let seen = seen.filter(|seen| !seen.inside && seen.normal.dot(self.up) >= self.flattest);
        Ok(seen.map(|seen| seen.normal))
    }
}

/// The displacement along ground with this normal, with the same length, so that uphill is not
/// slower.
fn on_ground(displacement: Vec3, normal: Vec3) -> Vec3 {
    (displacement - normal * displacement.dot(normal)).normalize_or(Vec3::ZERO)
        * displacement.length()
}

/// The part of a displacement that leads into none of the planes.
fn along(displacement: Vec3, planes: &[Vec3]) -> Vec3 {
    let free = |displacement: Vec3| {
        planes.iter().all(|n| displacement.dot(*n) >= -1.0e-6 * displacement.length())
    };
    if free(displacement) {
        return displacement;
    }
    let on_one = planes.iter().map(|n| displacement - *n * lesser(displacement.dot(*n), 0.0));
    let creases = planes.iter().enumerate().flat_map(|(i, n)| {
        planes[..i].iter().filter_map(move |other| n.cross(*other).try_normalize())
    });
    let on_two = creases.map(|crease| crease * displacement.dot(crease));
    on_one.chain(on_two).find(|bent| free(*bent)).unwrap_or(Vec3::ZERO)
}
