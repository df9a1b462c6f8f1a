//! Every form of a query gives the same answer as a test of all shapes, one by one.

use core::ops::ControlFlow;
use std::sync::Arc;

use drystone::query::{BodyKinds, Inside, Motion, QueryFilter, RayHit, RayQuery, ShapeQuery};
use drystone::threads::Team;
use drystone::{
    BodyDef, BodyId, BodyKind, Filter, Hull, Mesh, Pose, Quat, Shape, ShapeDef, ShapeId, ShapeRef,
    Vec3, World, vec3,
};

/// Random numbers from -1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        let bits = u16::try_from(self.0 >> 48).unwrap();
        f32::from(bits) / 32768.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        vec3(self.next(), self.next(), self.next())
    }

    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 33).unwrap() % n
    }

    fn pose(&mut self, far: f32) -> Pose {
        let axis = self.vector().normalize_or(Vec3::Y);
        Pose::new(self.vector() * far, Quat::from_axis_angle(axis, 3.0 * self.next()))
    }
}

fn hull() -> Shape {
    let mut numbers = Numbers(77);
    let points: Vec<Vec3> = (0..20).map(|_| numbers.vector() * 0.6).collect();
    Shape::Hull(Arc::new(Hull::from_points(&points).unwrap()))
}

fn mesh() -> Shape {
    let mut numbers = Numbers(5);
    let heights: Vec<f32> = (0..49).map(|_| 0.3 * numbers.next()).collect();
    let at = |i: u8, k: u8| usize::from(i) * 7 + usize::from(k);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..7_u8 {
        for k in 0..7_u8 {
            vertices.push(vec3(
                f32::from(i) * 0.4 - 1.2,
                heights[at(i, k)],
                f32::from(k) * 0.4 - 1.2,
            ));
            if i > 0 && k > 0 {
                let [a, b, c, d] = [at(i - 1, k - 1), at(i - 1, k), at(i, k), at(i, k - 1)]
                    .map(|v| u32::try_from(v).unwrap());
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()))
}

/// One shape of each bounded convex kind.
fn convex() -> Vec<Shape> {
    vec![
        Shape::sphere(0.5),
        Shape::capsule(0.4, 0.25),
        Shape::box_half([0.5, 0.3, 0.7]),
        Shape::cylinder(0.4, 0.35),
        Shape::cone(0.5, 0.5),
        Shape::Cone { half_height: 0.4, radius_bottom: 0.2, radius_top: 0.5 },
        hull(),
    ]
}

fn half_space() -> Shape {
    Shape::half_space([0.1, 1.0, 0.2], -3.5)
}

/// Sixty bodies of all kinds of shapes, in four layers, some of them sensors, and one half-space.
fn crowd(seed: u64) -> World {
    let mut world = World::default();
    let mut numbers = Numbers(seed);
    let kinds = [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic];
    let mut shapes = convex();
    shapes.push(mesh());
    for n in 0..60 {
        let shape = shapes[numbers.below(shapes.len())].clone();
        let pose = numbers.pose(4.0);
        let (layers, sensor) = (1 << numbers.below(4), numbers.below(5) == 0);
        // A body without mass is not dynamic.
        let massless = sensor || matches!(shape, Shape::Mesh(_));
        let kind = if massless { kinds[n % 2] } else { kinds[n % 3] };
        let def = ShapeDef {
            filter: Filter::layers(layers, u64::MAX),
            sensor,
            user_data: numbers.below(3) as u64,
            ..ShapeDef::new(shape)
        };
        let body = BodyDef { kind, ..BodyDef::default() };
        let body = body.with_position(pose.position).with_rotation(pose.rotation);
        world.add_body(body.with_shape(def)).unwrap();
    }
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::new(half_space()))).unwrap();
    world
}

fn shapes(world: &World) -> Vec<ShapeRef<'_>> {
    let ids = world.bodies().flat_map(|b| b.shapes().collect::<Vec<_>>());
    let mut ids: Vec<ShapeId> = ids.collect();
    ids.sort_by_key(|id| id.index());
    ids.into_iter().map(|id| world.shape(id).unwrap()).collect()
}

/// Applies the rule of a filter to one shape.
fn is_seen(world: &World, filter: &QueryFilter<'_>, shape: &ShapeRef<'_>) -> bool {
    let kind = world.body(shape.body()).unwrap().kind();
    (filter.sensors || !shape.is_sensor())
        && filter.filter.is_none_or(|f| f.collides_with(shape.filter()))
        && filter.kinds.contains(kind)
        && !filter.exclude.contains(&shape.body())
        && !filter.exclude_shapes.contains(&shape.id())
        && filter.predicate.is_none_or(|sees| sees(*shape))
}

/// Calls `f` with all sorts of filters.
fn with_filters(world: &World, f: impl Fn(&QueryFilter<'_>)) {
    let bodies: Vec<BodyId> = world.bodies().map(|b| b.id()).step_by(4).collect();
    let some: Vec<ShapeId> = shapes(world).iter().map(ShapeRef::id).skip(1).step_by(3).collect();
    let odd = |shape: ShapeRef<'_>| shape.user_data() == 1;
    let all = QueryFilter::default();
    for filter in [
        all,
        all.with_sensors(),
        all.with_filter(Filter::layers(1, 3)),
        all.with_kinds(BodyKinds::STATIC | BodyKinds::DYNAMIC).with_sensors(),
        all.with_kinds(BodyKind::Kinematic),
        all.without(&bodies),
        all.without_shapes(&some).with_sensors(),
        all.with_predicate(&odd).with_inside(Inside::Hollow),
        all.with_inside(Inside::Ignore).with_sensors(),
        QueryFilter::from(Filter { exclude: 2, ..Filter::default() }),
    ] {
        f(&filter);
    }
}

#[test]
fn rays_hit_what_a_look_at_every_shape_finds_in_all_forms_of_the_question() {
    for seed in [1, 2, 3] {
        let world = crowd(seed);
        with_filters(&world, |filter| {
            let mut numbers = Numbers(seed + 100);
            let (query, mut hits, mut met) = (world.query(), Vec::new(), 0);
            let (mut rays, mut closest) = (Vec::new(), Vec::new());
            for _ in 0..60 {
                let (origin, delta) = (numbers.vector() * 5.0, numbers.vector() * 8.0);
                let mut expected: Vec<(f32, u32, ShapeId, bool)> = Vec::new();
                for shape in shapes(&world) {
                    let hit = shape.shape().cast_ray(shape.pose(), origin, delta, filter.inside);
                    if let Some(hit) = hit.unwrap()
                        && is_seen(&world, filter, &shape)
                    {
                        expected.push((hit.fraction, shape.id().index(), shape.id(), hit.inside));
                    }
                }
                expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
                query.cast_ray_all(origin, delta, filter, &mut hits).unwrap();
                let named = |h: &RayHit| (h.fraction, h.shape.index(), h.shape, h.inside);
                assert_eq!(hits.iter().map(named).collect::<Vec<_>>(), expected, "{filter:?}");
                met += hits.len();
                let first = query.cast_ray(origin, delta, filter).unwrap();
                assert_eq!(first, hits.first().copied());
                assert_eq!(query.cast_ray_any(origin, delta, filter).unwrap(), first.is_some());
                let mut visited = Vec::new();
                let keep = |hit: &RayHit| {
                    visited.push(*hit);
                    ControlFlow::Continue(hit.fraction)
                };
                query.visit_ray(origin, delta, filter, keep).unwrap();
                let nearest = visited.iter().min_by(|a, b| a.fraction.total_cmp(&b.fraction));
                assert_eq!(nearest.map(|h| h.fraction), first.map(|h| h.fraction));
                for hit in &hits {
                    assert!((hit.normal.length() - 1.0).abs() < 1e-5, "{hit:?}");
                    assert_eq!(world.shape(hit.shape).unwrap().body(), hit.body);
                }
                rays.push(RayQuery::new(origin, delta));
                closest.push(first);
            }
            let mut batch = Vec::new();
            query.cast_rays(&rays, filter, &mut batch).unwrap();
            assert_eq!(batch, closest);
            assert!(met > 0, "{met} hits: {filter:?}");
        });
    }
}

#[test]
fn batches_give_the_hits_of_one_by_one_for_any_number_of_threads() {
    let world = crowd(9);
    let mut numbers = Numbers(4);
    let rays: Vec<RayQuery> =
        (0..700).map(|_| RayQuery::new(numbers.vector() * 5.0, numbers.vector() * 8.0)).collect();
    let casts: Vec<ShapeQuery> = (0..90)
        .map(|n| {
            let turn = if n % 2 == 0 { Vec3::ZERO } else { numbers.vector() * 2.0 };
            ShapeQuery::new(numbers.pose(5.0), Motion::by(numbers.vector() * 6.0).with_turn(turn))
        })
        .collect();
    let (filter, moving) = (QueryFilter::default(), Shape::box_half([0.2, 0.3, 0.1]));
    let query = world.query();
    let one_ray = |ray: &RayQuery| query.cast_ray(ray.origin, ray.delta, filter).unwrap();
    let one_cast =
        |cast: &ShapeQuery| query.cast_shape(&moving, cast.pose, cast.motion, filter).unwrap();
    let ray_hits: Vec<_> = rays.iter().map(one_ray).collect();
    let cast_hits: Vec<_> = casts.iter().map(one_cast).collect();
    assert!(ray_hits.iter().flatten().count() > 100 && cast_hits.iter().flatten().count() > 20);
    for threads in [1, 2, 3] {
        let world = world.clone().with_executor(Arc::new(Team::with_threads(threads)));
        // The old content of the buffers does not matter.
        let (mut hits, mut met) = (vec![ray_hits[0]; 3], vec![cast_hits[0]; 999]);
        world.query().cast_rays(&rays, filter, &mut hits).unwrap();
        world.query().cast_shapes(&moving, &casts, filter, &mut met).unwrap();
        assert_eq!((hits, met), (ray_hits.clone(), cast_hits.clone()), "{threads} threads");
    }
}

/// Radius of the ball that stands for a point in distance queries [m].
const POINT: f32 = 1.0e-5;

fn distance(shape: &Shape, pose: Pose, p: Vec3) -> f32 {
    Shape::sphere(POINT).distance(Pose::at(p), shape, pose).unwrap() + POINT
}

#[test]
fn a_ray_from_inside_hits_at_once_or_leaves_where_the_shape_ends_or_passes() {
    // Four f32 roundings of positions up to 4 m, and twice the point's radius.
    let off = 4.0 * 4.0 * f32::EPSILON + 2.0 * POINT;
    let mut solids = convex();
    solids.push(Shape::half_space([0.1, 1.0, 0.2], 0.3));
    for shape in solids {
        let (mut numbers, mut inside, mut left) = (Numbers(31), 0, 0);
        for _ in 0..600 {
            let pose = numbers.pose(2.0);
            let (origin, delta) = (pose.position + numbers.vector(), numbers.vector() * 4.0);
            // A start nearer to the surface may count as on it.
            if distance(&shape, pose, origin) > -1.0e-3 {
                continue;
            }
            inside += 1;
            let cast = |inside| shape.cast_ray(pose, origin, delta, inside).unwrap();
            let at_once = cast(Inside::Solid).unwrap();
            assert_eq!((at_once.fraction, at_once.inside, at_once.point), (0.0, true, origin));
            // Its normal is that of the nearest surface: along it, the shape ends after the depth.
            let deep = -distance(&shape, pose, origin);
            let out = distance(&shape, pose, origin + at_once.normal * deep);
            assert!(out.abs() < off, "{shape:?} {out}");
            assert_eq!(cast(Inside::Ignore), None);
            let end = cast(Inside::Hollow);
            for s in 0..=20_u8 {
                let part = end.map_or(1.0, |hit| hit.fraction) * f32::from(s) / 20.0;
                let depth = distance(&shape, pose, origin + delta * part);
                assert!(depth < off, "{shape:?} {origin:?} {delta:?} {part}: {depth}");
            }
            if let Some(hit) = end {
                left += 1;
                let rest = distance(&shape, pose, hit.point);
                assert!(rest.abs() < off && hit.inside, "{shape:?} {hit:?} {rest}");
                assert!(hit.normal.dot(delta) > 0.0, "{shape:?} {hit:?}");
                // The normal is outward: a step along it increases the distance by the same amount.
                let step = distance(&shape, pose, hit.point + hit.normal * 0.01);
                assert!((step - 0.01).abs() < 1.0e-4, "{shape:?} {hit:?} {step}");
            }
        }
        assert!(inside > 15 && left > 5, "{}: {inside} {left}", shape.kind());
    }
}

#[test]
fn a_mesh_has_no_inside_and_is_hit_from_both_sides() {
    let square = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
    let square = square.map(Vec3::from).to_vec();
    let mesh = Shape::Mesh(Arc::new(Mesh::new(square, vec![[0, 1, 2], [0, 2, 3]]).unwrap()));
    for inside in [Inside::Solid, Inside::Hollow, Inside::Ignore] {
        for side in [1.0, -1.0] {
            let (origin, delta) = ([0.3, side, 0.1], [0.0, -2.0 * side, 0.0]);
            let hit = mesh.cast_ray(Pose::IDENTITY, origin, delta, inside).unwrap().unwrap();
            assert_eq!((hit.fraction, hit.normal, hit.inside), (0.5, Vec3::Y * side, false));
        }
    }
}

#[test]
fn a_ray_from_a_point_that_was_hit_goes_on_without_hitting_the_same_surface() {
    let world = crowd(12);
    let (query, mut numbers, mut bounced) = (world.query(), Numbers(8), 0);
    for _ in 0..400 {
        let (origin, delta) = (numbers.vector() * 5.0, numbers.vector() * 8.0);
        let hit = query.cast_ray(origin, delta, QueryFilter::default()).unwrap();
        // A mesh has two sides: a point rounded to the back is in front of it again.
        let is_solid = |hit: &RayHit| {
            !hit.inside && !matches!(world.shape(hit.shape).unwrap().shape(), Shape::Mesh(_))
        };
        let Some(hit) = hit.filter(is_solid) else { continue };
        let back = delta - hit.normal * (2.0 * hit.normal.dot(delta));
        // A cast along the surface hits round shapes again because of rounding.
        if hit.normal.dot(back) < 0.1 {
            continue;
        }
        bounced += 1;
        let only = |shape: ShapeRef<'_>| shape.id() == hit.shape;
        let only = QueryFilter::default().with_predicate(&only);
        let again = query.cast_ray(hit.point, back * 1.0e-3, only).unwrap();
        assert_eq!(again, None, "{hit:?}");
    }
    assert!(bounced > 60);
}

/// Pose of a shape after a fraction of a motion.
fn after(pose: Pose, motion: Motion, part: f32) -> Pose {
    Pose::new(pose.position + motion.delta * part, pose.rotation.turned_by(motion.turn * part))
}

#[test]
fn a_turning_shape_stops_where_the_distance_is_gone_and_nowhere_before() {
    // Sizes and positions sum to 20 m; impacts are accurate to 2e-6 of that, and positions are
    // rounded a few times.
    let met = 2.0 * 2.0e-6 * 20.0;
    let mut others = convex();
    others.extend([mesh(), half_space()]);
    let (mut hits, mut misses) = (0, 0);
    for other in &others {
        for shape in convex() {
            let mut numbers = Numbers(3);
            for _ in 0..12 {
                let (there, start) = (numbers.pose(1.0), numbers.pose(4.0));
                let motion = Motion::by(numbers.vector() * 5.0).with_turn(numbers.vector() * 4.0);
                let apart =
                    |part: f32| shape.distance(after(start, motion, part), other, there).unwrap();
                let hit = shape.cast(start, motion, other, there).unwrap();
                let end = hit.map_or(1.0, |hit| hit.fraction);
                if apart(0.0) < -met {
                    let hit = hit.unwrap();
                    assert!(hit.fraction <= 0.0 && hit.inside, "{hit:?}");
                    continue;
                }
                for s in 0..100_u8 {
                    let gap = apart(end * f32::from(s) / 100.0);
                    assert!(gap > -met, "{shape:?} {other:?} {start:?} {motion:?} {s}: {gap}");
                }
                let gap = apart(end);
                if let Some(hit) = hit {
                    hits += 1;
                    assert!(gap.abs() < met, "{shape:?} {other:?} {start:?} {motion:?}: {gap}");
                    assert!((hit.normal.length() - 1.0).abs() < 1.0e-5);
                } else {
                    misses += 1;
                    assert!(gap > -met, "{gap}");
                }
            }
        }
    }
    assert!(hits > 50 && misses > 50, "{hits} {misses}");
}

#[test]
fn casts_meet_what_a_look_at_every_shape_finds_in_all_forms_of_the_question() {
    let world = crowd(6);
    let query = world.query();
    let moving = convex();
    with_filters(&world, |filter| {
        let (mut numbers, mut hits, mut met) = (Numbers(55), Vec::new(), 0);
        for n in 0..16 {
            let shape = &moving[n % moving.len()];
            let (start, way) = (numbers.pose(6.0), numbers.vector() * 6.0);
            let turn = if n % 2 == 0 { Vec3::ZERO } else { numbers.vector() };
            let motion = Motion::by(way).with_turn(turn);
            let mut expected: Vec<(f32, u32)> = Vec::new();
            for other in shapes(&world) {
                let hit = shape.cast(start, motion, other.shape(), other.pose()).unwrap();
                let hit = hit.filter(|hit| !hit.inside || filter.inside == Inside::Solid);
                if let Some(hit) = hit.filter(|_| is_seen(&world, filter, &other)) {
                    expected.push((hit.fraction, other.id().index()));
                }
            }
            expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
            query.cast_shape_all(shape, start, motion, filter, &mut hits).unwrap();
            let found: Vec<_> = hits.iter().map(|h| (h.fraction, h.shape.index())).collect();
            assert_eq!(found, expected, "{filter:?}");
            met += hits.len();
            let first = query.cast_shape(shape, start, motion, filter).unwrap();
            assert_eq!(first, hits.first().copied());
            let any = query.cast_shape_any(shape, start, motion, filter).unwrap();
            assert_eq!(any, first.is_some());
        }
        assert!(met > 0, "{filter:?}");
    });
}

#[test]
fn overlaps_and_what_is_near_are_what_a_look_at_every_shape_finds() {
    let world = crowd(7);
    let query = world.query();
    let probes = convex();
    with_filters(&world, |filter| {
        let (mut numbers, mut found, mut near, mut met) = (Numbers(21), Vec::new(), Vec::new(), 0);
        for n in 0..90 {
            let (probe, at, reach) = (&probes[n % probes.len()], numbers.pose(4.0), 0.7);
            let seen = shapes(&world).into_iter().filter(|s| is_seen(&world, filter, s));
            let seen: Vec<ShapeRef<'_>> = seen.collect();
            let is_met = |s: &&ShapeRef<'_>| s.shape().overlaps(s.pose(), probe, at).unwrap();
            let expected: Vec<ShapeId> = seen.iter().filter(is_met).map(ShapeRef::id).collect();
            query.overlap_shape_into(probe, at, filter, &mut found).unwrap();
            assert_eq!(found, expected, "{filter:?}");
            met += found.len();
            let any = query.overlap_shape_any(probe, at, filter).unwrap();
            assert_eq!(any, !found.is_empty());
            let distance = |s: &ShapeRef<'_>| s.shape().distance(s.pose(), probe, at).unwrap();
            let mut expected: Vec<(f32, ShapeId)> =
                seen.iter().map(|s| (distance(s), s.id())).filter(|(d, _)| *d <= reach).collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.index().cmp(&b.1.index())));
            query.nearest_all(probe, at, reach, filter, &mut near).unwrap();
            let named: Vec<_> = near.iter().map(|n| (n.distance, n.shape)).collect();
            assert_eq!(named, expected, "{filter:?}");
            let nearest = query.nearest_shape(probe, at, reach, filter).unwrap();
            assert_eq!(nearest.map(|n| n.distance), near.first().map(|n| n.distance));
        }
        assert!(met > 0, "{filter:?}");
    });
}

#[test]
fn no_query_sees_a_sensor_unless_it_asks_for_sensors() {
    let mut world = World::default();
    let zone = ShapeDef { sensor: true, ..ShapeDef::box_half([1.0; 3]) };
    world.add_body(BodyDef::fixed().with_shape(zone)).unwrap();
    let (q, ball) = (world.query(), Shape::sphere(0.2));
    let (from, way, at) = (vec3(-3.0, 0.0, 0.0), vec3(6.0, 0.0, 0.0), Pose::at([0.5, 0.0, 0.0]));
    for sensors in [false, true] {
        let filter = QueryFilter { sensors, ..QueryFilter::default() };
        let (mut rays, mut near) = (Vec::new(), Vec::new());
        q.cast_ray_all(from, way, filter, &mut rays).unwrap();
        q.nearest_all(&ball, at, 1.0, filter, &mut near).unwrap();
        let bounds = drystone::geometry::Aabb::new(vec3(-0.1, -0.1, -0.1), vec3(0.1, 0.1, 0.1));
        assert_eq!(
            [
                q.cast_ray(from, way, filter).unwrap().is_some(),
                q.cast_ray_any(from, way, filter).unwrap(),
                !rays.is_empty(),
                q.cast_shape(&ball, Pose::at(from), way, filter).unwrap().is_some(),
                q.nearest_shape(&ball, at, 1.0, filter).unwrap().is_some(),
                !near.is_empty(),
                !q.overlap_bounds(bounds, filter).unwrap().is_empty(),
                !q.overlap_shape(&ball, at, filter).unwrap().is_empty(),
                !q.overlap_point([0.1; 3], filter).unwrap().is_empty(),
            ],
            [sensors; 9]
        );
    }
}

#[test]
fn the_contacts_of_a_body_and_of_a_pair_are_those_of_the_world_that_name_them() {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::new(mesh_floor()))).unwrap();
    for n in 0..12_u8 {
        let at = vec3(f32::from(n % 3) * 0.9, 0.5 + f32::from(n / 3), 0.0);
        let body = BodyDef::dynamic().with_position(at);
        let body = body.with_shape(ShapeDef::box_half([0.46, 0.5, 0.5]));
        world.add_body(body.with_shape(ShapeDef::sphere(0.2))).unwrap();
    }
    for _ in 0..30 {
        world.step(1.0 / 60.0);
    }
    let key =
        |c: &drystone::contact::ContactRef<'_>| (c.shape_a(), c.shape_b(), c.normal().to_array());
    let sorted = |mut keys: Vec<(ShapeId, ShapeId, [f32; 3])>| {
        keys.sort_by(|a, b| a.partial_cmp(b).unwrap());
        keys
    };
    let all: Vec<_> = world.contacts().collect();
    assert!(all.len() > 12);
    let ids: Vec<BodyId> = world.bodies().map(|b| b.id()).collect();
    for &a in &ids {
        let own = world.body(a).unwrap().contacts().map(|c| key(&c)).collect();
        let of_a = all.iter().filter(|c| c.other_body(a).is_some());
        assert_eq!(sorted(own), sorted(of_a.clone().map(key).collect()));
        for &b in ids.iter().filter(|b| **b != a) {
            let between = world.contacts_between(a, b).map(|c| key(&c)).collect();
            let expected = of_a.clone().filter(|c| c.other_body(a) == Some(b)).map(key).collect();
            assert_eq!(sorted(between), sorted(expected));
        }
        for shape in world.body(a).unwrap().shapes() {
            let own = world.shape(shape).unwrap().contacts().map(|c| key(&c)).collect();
            let of_shape = all.iter().filter(|c| c.shape_a() == shape || c.shape_b() == shape);
            assert_eq!(sorted(own), sorted(of_shape.map(key).collect()));
        }
    }
    let gone = ids[3];
    world.remove_body(gone);
    assert_eq!(world.contacts_between(gone, ids[0]).count(), 0);
}

fn mesh_floor() -> Shape {
    let square = [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]];
    let square = square.map(Vec3::from).to_vec();
    Shape::Mesh(Arc::new(Mesh::new(square, vec![[0, 1, 2], [0, 2, 3]]).unwrap()))
}

#[test]
fn a_sensor_lists_who_entered_and_has_not_left() {
    let mut world = World::default();
    let zone = ShapeDef { sensor: true, ..ShapeDef::box_half([1.0; 3]) };
    let zone = world.add_body(BodyDef::fixed().with_shape(zone)).unwrap();
    let zone = world.body(zone).unwrap().shapes().next().unwrap();
    for n in 0..5_u8 {
        let at = vec3(-3.0 - f32::from(n), 0.0, f32::from(n) * 0.3 - 0.6);
        let ball = BodyDef::dynamic().with_position(at).with_linear_velocity([4.0, 0.0, 0.0]);
        let ball = BodyDef { gravity_scale: 0.0, ..ball };
        world.add_body(ball.with_shape(ShapeDef::sphere(0.1))).unwrap();
    }
    let (mut inside, mut most) = (Vec::new(), 0);
    for _ in 0..180 {
        world.step(1.0 / 60.0);
        for event in &world.events().sensor_enter {
            inside.push(event.visitor);
        }
        for event in &world.events().sensor_exit {
            inside.retain(|id| *id != event.visitor);
        }
        let mut listed: Vec<ShapeId> = world.shape(zone).unwrap().sensor_overlaps().collect();
        listed.sort();
        inside.sort();
        assert_eq!(listed, inside);
        for visitor in &listed {
            let seen_by: Vec<_> = world.shape(*visitor).unwrap().sensor_overlaps().collect();
            assert_eq!(seen_by, [zone]);
        }
        most = most.max(listed.len());
    }
    assert!(most > 1 && inside.is_empty(), "{most}");
}

#[test]
fn shapes_without_a_world_say_who_cannot_be_asked_and_which_number_is_wrong() {
    let (ball, here) = (Shape::sphere(0.5), Pose::IDENTITY);
    let (plane, mesh) = (half_space(), mesh_floor());
    let lost = Pose::at([f32::NAN, 0.0, 0.0]);
    let bad = Shape::sphere(f32::NAN);
    for (refused, field) in [
        (plane.closest_points(here, &mesh, here, 1.0).unwrap_err(), "(got mesh)"),
        (mesh.distance(here, &mesh, here).unwrap_err(), "(got mesh)"),
        (mesh.overlaps(here, &plane, here).unwrap_err(), "(got half-space)"),
        (plane.contacts(here, &plane, here, 0.0).unwrap_err(), "(got half-space)"),
        (mesh.cast(here, Vec3::Y, &ball, here).unwrap_err(), "(got mesh)"),
        (ball.distance(lost, &ball, here).unwrap_err(), "pose.position"),
        (ball.distance(here, &ball, lost).unwrap_err(), "other_pose.position"),
        (ball.distance(here, &bad, here).unwrap_err(), "other.radius"),
        (ball.closest_points(here, &ball, here, -1.0).unwrap_err(), "reach"),
        (ball.contacts(here, &ball, here, f32::NAN).unwrap_err(), "margin"),
        (ball.cast(here, [f32::INFINITY; 3], &ball, here).unwrap_err(), "delta"),
        (
            ball.cast(here, Motion::default().with_turn([0.0, 1.0e3, 0.0]), &ball, here)
                .unwrap_err(),
            "turn",
        ),
        (ball.cast_ray(here, [f32::NAN; 3], Vec3::Y, Inside::Solid).unwrap_err(), "origin"),
    ] {
        assert!(refused.to_string().contains(field), "{refused}");
    }
    // Both orders of the pair give the same answer, seen from the other side.
    let above = Pose::at([0.3, 2.0, 0.1]);
    for other in [&plane, &mesh] {
        let one = ball.closest_points(above, other, here, 9.0).unwrap().unwrap();
        let two = other.closest_points(here, &ball, above, 9.0).unwrap().unwrap();
        assert_eq!(
            (one.distance, one.point_a, one.normal),
            (two.distance, two.point_b, -two.normal)
        );
        let touching = Pose::at([0.3, 0.49, 0.1]);
        let contacts = ball.contacts(touching, &mesh, here, 0.0).unwrap();
        let point = contacts[0].points().next().unwrap();
        assert!((contacts[0].normal() + Vec3::Y).length() < 1.0e-6);
        assert!((point.separation + 0.01).abs() < 1.0e-6, "{point:?}");
    }
}

#[test]
fn a_bad_ray_or_cast_of_a_batch_is_named_and_the_buffer_stays() {
    let world = crowd(2);
    let (query, ball, filter) = (world.query(), Shape::sphere(0.1), QueryFilter::default());
    let good = RayQuery::new([0.0, 9.0, 0.0], [0.0, -20.0, 0.0]);
    let mut hits = Vec::new();
    query.cast_rays(&[good], filter, &mut hits).unwrap();
    let before = hits.clone();
    let bad = RayQuery::new([0.0, f32::NAN, 0.0], [0.0; 3]);
    let refused = query.cast_rays(&[good, bad], filter, &mut hits).unwrap_err();
    assert_eq!(refused.field(), "rays[1].origin");
    assert_eq!(hits, before);
    let casts = [ShapeQuery::default(), ShapeQuery::new(Pose::IDENTITY, [f32::NAN; 3])];
    let mut met = Vec::new();
    let refused = query.cast_shapes(&ball, &casts, filter, &mut met).unwrap_err();
    assert_eq!(refused.field(), "casts[1].delta");
    let endless = Vec3::splat(f32::INFINITY);
    let everything =
        query.overlap_bounds(drystone::geometry::Aabb::new(-endless, endless), filter).unwrap();
    assert_eq!(everything.len(), shapes(&world).iter().filter(|s| !s.is_sensor()).count());
    let broken = drystone::geometry::Aabb::new(vec3(f32::NAN, 0.0, 0.0), Vec3::ONE);
    assert!(query.overlap_bounds(broken, filter).is_err());
}

#[test]
fn a_bar_that_turns_over_the_ground_comes_down_where_its_end_does() {
    let mut world = World::default();
    world
        .add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))
        .unwrap();
    // Half a meter below the middle of a bar of 2 m that is only as thick as its radius.
    let (bar, quarter) = (Shape::capsule(1.0, 0.05), core::f32::consts::FRAC_PI_2);
    let level = Pose::new([0.0, 0.55, 0.0], Quat::from_axis_angle(Vec3::Z, quarter));
    let turn = Motion::default().with_turn([0.0, 0.0, quarter]);
    let hit = world.query().cast_shape(&bar, level, turn, QueryFilter::default()).unwrap().unwrap();
    // The end drops by 1 m · sin(angle): half a meter at 30 of 90 degrees.
    assert!((hit.fraction - 1.0 / 3.0).abs() < 1.0e-5, "{hit:?}");
    // About the vertical it turns without an impact, even flush with the ground.
    for height in [0.05, 0.3] {
        let level = Pose { position: vec3(0.0, height, 0.0), ..level };
        let round = Motion::default().with_turn([0.0, 50.0, 0.0]);
        let hit = world.query().cast_shape(&bar, level, round, QueryFilter::default()).unwrap();
        assert_eq!(hit, None, "{height}");
    }
}
