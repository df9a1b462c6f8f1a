//! The list of built-in scenes.

use super::entry::Entry;
use super::parameters::Parameter;
use super::{
    box3d, breaking, first, heaps, jolt, linked, machines, masonry, rain, steady, survey, threads,
};

/// Sizes are limited so that no scene has more than about 1.1 million bodies.
pub(super) static CATALOG: [Entry; 65] = [
    Entry::new("hello", "A box and a ball fall on the ground", first::hello),
    Entry::new("stack", "A column of cubes, the top one as heavy as you like", first::stack).with(
        &[
            Parameter::whole("n", 10, (1, 10_000), "cubes"),
            Parameter::number(
                "top_mass_ratio",
                1.0,
                (1.0e-3, 1.0e6),
                "mass of the top cube over that of another",
            ),
            Parameter::number("edge", 1.0, (0.001, 100.0), "of a cube [m]"),
        ],
    ),
    Entry::new(
        "pyramid",
        "A flat pyramid of cubes that only friction holds together",
        box3d::pyramid,
    )
    .with(&[Parameter::whole("base", 20, (1, 1400), "cubes in the lowest row")]),
    Entry::new(
        "large_pyramid",
        "5,050 cubes in one flat pyramid: one large island",
        box3d::large_pyramid,
    ),
    Entry::new(
        "many_pyramids",
        "Rows of flat pyramids of 55 cubes: many islands of middling size",
        box3d::many_pyramids,
    )
    .with(&[Parameter::whole("side", 14, (1, 100), "rows, and pyramids in a row")]),
    Entry::new("wall", "A brick wall without mortar; ball=1: a heavy ball hits it", masonry::wall)
        .with(&[
            Parameter::whole("width", 16, (1, 1000), "bricks in a row"),
            Parameter::whole("height", 15, (1, 1000), "rows"),
            Parameter::whole("ball", 0, (0, 1), "1: a heavy ball hits it after a second"),
        ]),
    Entry::new("tower", "A round tower of bricks without mortar", masonry::tower).with(&[
        Parameter::whole("layers", 20, (1, 1000), "rings of bricks"),
        Parameter::whole("bricks", 16, (6, 1000), "bricks in a ring"),
    ]),
    Entry::new("jenga", "A tower of crossed layers of three blocks", masonry::jenga).with(&[
        Parameter::whole("layers", 18, (1, 10_000), "layers"),
        Parameter::whole("pulled", 0, (0, 1), "1: every second layer lacks its middle block"),
    ]),
    Entry::new("plank_tower", "A tower of crossed layers of two planks each", masonry::plank_tower)
        .with(&[Parameter::whole("layers", 12, (1, 10_000), "layers")]),
    Entry::new("domino", "A spiral of dominoes; the first one is tipped", masonry::domino)
        .with(&[Parameter::whole("n", 80, (1, 10_000), "dominoes")]),
    Entry::new("arch", "A half circle of wedge stones that hold each other up", masonry::arch)
        .with(&[Parameter::whole("stones", 25, (3, 199), "stones")]),
    Entry::new(
        "card_house",
        "A house of cards, 25 degrees from upright, held by friction alone",
        masonry::card_house,
    )
    .with(&[
        Parameter::whole("levels", 5, (1, 100), "stories"),
        Parameter::number("thickness", 0.02, (0.002, 0.03), "thickness of a card [m]"),
    ]),
    Entry::new(
        "falling_tower",
        "A column of cubes, each further out than the one below: it topples",
        masonry::falling_tower,
    )
    .with(&[
        Parameter::whole("n", 10, (1, 1000), "cubes"),
        Parameter::number("overhang", 0.12, (0.0, 0.9), "of a cube over the one below [m]"),
    ]),
    Entry::new(
        "tower_minus_base",
        "A tower of crossed bricks, one of its two lowest bricks taken away: it tips over",
        masonry::tower_minus_base,
    )
    .with(&[Parameter::whole("layers", 12, (1, 1000), "layers")]),
    Entry::new(
        "stack_drop",
        "A heavy cube falls on a column of light ones: it must not crush it",
        steady::stack_drop,
    )
    .with(&[
        Parameter::whole("n", 10, (1, 1000), "cubes in the column"),
        Parameter::number(
            "mass_ratio",
            100.0,
            (0.001, 1.0e5),
            "mass of the falling cube over that of another",
        ),
        Parameter::number("height", 3.0, (0.0, 100.0), "of its fall [m]"),
    ]),
    Entry::new(
        "leaning_stack",
        "A column of cubes, each a little off the one below: ten stand exactly if that is below 0.1 m",
        steady::leaning_stack,
    )
    .with(&[
        Parameter::whole("n", 10, (1, 1000), "cubes"),
        Parameter::number("lean", 0.09, (0.0, 0.9), "of a cube over the one below [m]"),
    ]),
    Entry::new(
        "pushed_stack",
        "The upper half of a column of cubes is given a speed: a slow one it survives",
        steady::pushed_stack,
    )
    .with(&[
        Parameter::whole("n", 10, (1, 1000), "cubes"),
        Parameter::number("speed", 1.0, (0.0, 100.0), "of the upper half at the start [m/s]"),
    ]),
    Entry::new(
        "tiny_pyramid",
        "A flat pyramid of very small cubes: lengths of the engine must not show",
        steady::tiny_pyramid,
    )
    .with(&[
        Parameter::whole("base", 30, (1, 1400), "cubes in the lowest row"),
        Parameter::number("edge", 0.05, (0.005, 100.0), "of a cube [m]"),
    ]),
    Entry::new(
        "kapla",
        "A building of 102 flat blocks, six stories of bases and walls: it stands on friction alone",
        steady::kapla,
    )
    .with(&[
        Parameter::whole("floors", 6, (1, 1000), "stories of 17 blocks"),
        Parameter::number("friction", 0.6, (0.0, 10.0), "friction coefficient"),
    ]),
    Entry::new(
        "catenary_arch",
        "Stones along a catenary, 60 m high, let go a little apart: they meet and hold each other up",
        steady::catenary_arch,
    )
    .with(&[
        Parameter::whole("stones", 25, (3, 951), "stones, an odd number"),
        Parameter::number("gap", 0.1, (0.0, 0.5), "air below and between stones at the start [m]"),
    ]),
    Entry::new(
        "seesaw",
        "A plank with a cube at either end: level if they weigh the same, else the heavier one goes down",
        steady::seesaw,
    )
    .with(&[Parameter::number(
        "mass_ratio",
        1.0,
        (0.001, 1000.0),
        "mass of the right cube over that of the left one",
    )]),
    Entry::new(
        "catapult",
        "A weight falls on one end of a plank and throws the stone on the other",
        steady::catapult,
    )
    .with(&[
        Parameter::number("mass_ratio", 1.0, (0.001, 1000.0), "density of the weight over the stone's"),
        Parameter::number("height", 5.0, (0.0, 100.0), "of its fall [m]"),
    ]),
    Entry::new(
        "truck",
        "A column of cubes under a heavy one rides on a truck: it stands as if it stood still",
        steady::truck,
    )
    .with(&[
        Parameter::whole("n", 10, (1, 1000), "cubes"),
        Parameter::number("top_mass_ratio", 1.0, (0.001, 1.0e6), "mass of the top cube over that of another"),
        Parameter::number("speed", 20.0, (0.0, 100.0), "of the truck [m/s]"),
    ]),
    Entry::new(
        "pull",
        "Of two slabs, 100 kg below and 1000 kg above, one is pulled: it moves exactly if friction lets it",
        steady::pull,
    )
    .with(&[
        Parameter::number("factor", 0.9, (0.0, 100.0), "force over what friction holds, 6000 N above and 6600 N below"),
        Parameter::whole("lower", 0, (0, 1), "1: the lower slab is pulled"),
    ]),
    Entry::new(
        "conveyor",
        "Parcels put on a moving belt slide until they go along",
        steady::conveyor,
    )
    .with(&[
        Parameter::whole("n", 12, (1, 30), "parcels"),
        Parameter::number("speed", 1.5, (0.0, 10.0), "of the belt [m/s]"),
    ]),
    Entry::new("billiards", "A cue ball breaks a rack of fifteen balls", steady::billiards).with(&[
        Parameter::number("speed", 8.0, (0.0, 30.0), "of the cue ball [m/s]"),
        Parameter::number("gap", 0.0, (0.0, 0.01), "air between two balls of the rack [m]"),
    ]),
    Entry::new(
        "tops",
        "Spinning tops lean and go round, and do not fall while they spin",
        steady::tops,
    )
    .with(&[
        Parameter::whole("n", 5, (1, 1000), "tops"),
        Parameter::number("spin", 100.0, (0.0, 500.0), "about their own axis [rad/s]"),
        Parameter::number("lean", 10.0, (0.0, 80.0), "from upright at the start [degrees]"),
        Parameter::number("friction", 0.6, (0.0, 10.0), "friction coefficient"),
    ]),
    Entry::new(
        "incline",
        "A cube on a slope: it slides exactly if the slope exceeds the friction",
        first::incline,
    )
    .with(&[
        Parameter::number("tan", 0.5, (0.0, 10.0), "tangent of the slope's angle"),
        Parameter::number("mu", 0.5, (0.0, 10.0), "friction coefficient of cube and slope"),
        Parameter::number("restitution", 0.0, (0.0, 1.0), "of cube and slope"),
        Parameter::number("drop", 0.0, (0.0, 20.0), "height above the slope at the start [m]"),
    ]),
    Entry::new(
        "bouncy_cube_incline",
        "A perfectly bouncy cube put on a slope that holds it must not start to bounce",
        first::bouncy_cube_incline,
    ),
    Entry::new(
        "book",
        "A book lies on a table, partly over its edge: it falls exactly if that is more than half",
        survey::book,
    )
    .with(&[Parameter::number("overhang", 0.4, (0.0, 1.0), "over its length")]),
    Entry::new(
        "tilted_table",
        "A box on a tilted table: it slides exactly if the slope exceeds the friction, and tips exactly if \
         it exceeds width over height",
        survey::tilted_table,
    )
    .with(&[
        Parameter::number("tan", 0.5, (0.0, 2.0), "tangent of the slope's angle"),
        Parameter::number("mu", 0.4, (0.0, 10.0), "friction coefficient"),
        Parameter::number("height", 1.0, (0.1, 10.0), "of the box, 1 m wide [m]"),
    ]),
    Entry::new(
        "ball_roll",
        "A ball slides at first: 2/7 of its speed are lost when it rolls",
        survey::ball_roll,
    )
    .with(&[
        Parameter::number("speed", 7.0, (0.0, 100.0), "at the start, without spin [m/s]"),
        Parameter::number("mu", 0.3, (0.0, 10.0), "friction coefficient"),
    ]),
    Entry::new(
        "super_ball",
        "A rubber ball with backspin hops to and fro between bounces",
        survey::super_ball,
    )
    .with(&[
        Parameter::number("restitution", 0.9, (0.0, 1.0), "of ball and ground"),
        Parameter::number("speed", 1.5, (-50.0, 50.0), "at the start [m/s]"),
        Parameter::number("spin", 60.0, (-1000.0, 1000.0), "at the start [rad/s]"),
    ]),
    Entry::new("tumble", "Boxes tumble down a hill", survey::tumble)
        .with(&[Parameter::whole("boxes", 8, (1, 1000), "boxes")]),
    Entry::new(
        "hourglass",
        "1,000 cubes run through an hourglass and come to rest",
        survey::hourglass,
    )
    .with(&[Parameter::whole("cubes", 1000, (1, 10_000), "cubes")]),
    Entry::new("rings", "Rings fall over pegs", survey::rings)
        .with(&[Parameter::whole("rings", 125, (1, 10_000), "rings of eight capsules")]),
    Entry::new("cradle", "Newton's cradle: as many balls fly off as came in", first::cradle).with(
        &[
            Parameter::whole("balls", 5, (1, 200), "balls"),
            Parameter::whole("pulled", 1, (0, 200), "balls pulled back by 30 degrees"),
            Parameter::number("gap", 0.02, (0.0, 1.0), "air between two balls [m]"),
        ],
    ),
    Entry::new(
        "chain",
        "A chain of ball joints with a heavy ball at its end, let go at 60 degrees",
        linked::chain,
    )
    .with(&[
        Parameter::whole("links", 20, (1, 1000), "links of 0.5 m"),
        Parameter::number(
            "mass_ratio",
            50.0,
            (0.01, 1.0e5),
            "mass of the ball over that of a link",
        ),
    ]),
    Entry::new("bridge", "A hanging bridge of planks; boxes and balls fall on it", linked::bridge)
        .with(&[Parameter::whole("planks", 24, (4, 1000), "planks")]),
    Entry::new(
        "wrecking_ball",
        "A heavy ball on a chain swings into a brick wall",
        linked::wrecking_ball,
    )
    .with(&[Parameter::whole(
        "bond",
        0,
        (0, 2),
        "0: a wall without mortar; 100 bricks held by 1: glue, 2: fixed joints that break",
    )]),
    Entry::new(
        "fracture",
        "A block, a rock and a pane break into pieces where they are hit",
        breaking::fracture,
    )
    .with(&[
        Parameter::whole("pieces", 24, (2, 1024), "of a body at most; three times as many of the pane"),
        Parameter::whole("generations", 2, (1, 8), "how often pieces break again; 1: never"),
        Parameter::whole("seed", 1, (0, 1_000_000), "chooses where"),
    ]),
    Entry::new(
        "mattress",
        "A mattress of blocks on damped springs lies on two beams; balls fall on it",
        machines::mattress,
    )
    .with(&[
        Parameter::whole("long", 10, (2, 200), "blocks along it"),
        Parameter::whole("wide", 6, (2, 200), "blocks across it"),
        Parameter::number("bend", 40.0, (0.1, 200.0), "frequency of its springs that bend [Hz]"),
    ]),
    Entry::new(
        "vehicle",
        "A vehicle on sprung and driven wheels drives over bumps and into boxes",
        machines::vehicle,
    )
    .with(&[Parameter::number("speed", 8.0, (0.0, 30.0), "speed its motors hold [m/s]")]),
    Entry::new(
        "gears",
        "A motor drives a row of gear wheels, the last of which lifts a rack",
        machines::gears,
    )
    .with(&[
        Parameter::whole("n", 5, (1, 500), "wheels"),
        Parameter::number("speed", 2.0, (-20.0, 20.0), "speed of the first wheel [rad/s]"),
        Parameter::number("load", 20.0, (0.1, 200.0), "mass of the rack [kg]"),
    ]),
    Entry::new(
        "pulley",
        "A weight lifts a load on a rope over two wheels, as on a block and tackle",
        machines::pulley,
    )
    .with(&[
        Parameter::number("mass", 30.0, (0.1, 10_000.0), "mass of the weight [kg]"),
        Parameter::number("load", 50.0, (0.1, 10_000.0), "mass of the load [kg]"),
        Parameter::number("strands", 2.0, (0.5, 20.0), "strands that the load hangs on"),
    ]),
    Entry::new(
        "ragdolls",
        "People of 23 parts fall on a heap, limp or held in their pose",
        machines::ragdolls,
    )
    .with(&[
        Parameter::whole("n", 16, (1, 10_000), "people"),
        Parameter::number(
            "muscles",
            0.0,
            (0.0, 100_000.0),
            "greatest torque that pulls a joint to the pose [N m]; 0: limp, 300: strong, 100000: of stone",
        ),
    ]),
    Entry::new(
        "rain",
        "People of 14 bones fall on meshes, column after column; the oldest ones leave",
        rain::rain,
    )
    .with(&[
        Parameter::whole("springs", 1, (0, 1), "0: joints without springs"),
        Parameter::whole("rows", 10, (1, 10), "cells along a side, of 3 people each"),
    ]),
    Entry::new(
        "joint_grid",
        "A net of 10,000 balls and 19,701 ball joints that hangs from its upper edge",
        box3d::joint_grid,
    ),
    Entry::new(
        "pile",
        "Balls, boxes, capsules, cylinders, cones and hulls fall in a tray",
        heaps::pile,
    )
    .with(&[Parameter::whole("n", 500, (1, 1_000_000), "bodies")]),
    Entry::new(
        "convex_pile",
        "A tall column of 5,120 hulls of 32 points that collapses into a pile",
        box3d::convex_pile,
    ),
    Entry::new(
        "voxels",
        "Boxes fall on a stepped landscape and slide over its seams",
        heaps::voxels,
    )
    .with(&[
        Parameter::whole("cells", 32, (8, 1000), "columns along a side"),
        Parameter::whole("boxes", 300, (0, 100_000), "boxes"),
    ]),
    Entry::new(
        "junkyard",
        "10,584 rocks in a yard, stirred by a pillar that goes round",
        box3d::junkyard,
    ),
    Entry::new(
        "washer",
        "8,000 cubes tumble in a turning drum with paddles: nothing ever rests",
        box3d::washer,
    ),
    Entry::new(
        "trees100",
        "50 trees of 22 hulls topple over waves of 60,000 triangles",
        box3d::trees100,
    ),
    Entry::new(
        "trees50",
        "50 trees of 22 hulls topple over waves of 240,000 triangles",
        box3d::trees50,
    ),
    Entry::new(
        "trees25",
        "50 trees of 22 hulls topple over waves of 960,000 triangles",
        box3d::trees25,
    ),
    Entry::new(
        "large_world",
        "Balls dropped on a floor of a million bodies: what stands still must cost nothing",
        box3d::large_world,
    )
    .with(&[Parameter::whole("tiles", 1000, (1, 1000), "bodies along a side of the floor")]),
    Entry::new(
        "jolt_pyramid",
        "1,240 cubes in a solid pyramid, its levels dropped onto each other",
        jolt::pyramid,
    ),
    Entry::new(
        "convex_vs_mesh",
        "1,764 boxes, balls, capsules and hulls bounce into the dents of a mesh",
        jolt::convex_vs_mesh,
    ),
    Entry::new(
        "large_mesh",
        "4,410 boxes fall on hills of half a million triangles",
        jolt::large_mesh,
    )
    .with(&[Parameter::whole("n", 500, (150, 2000), "cells of 1 m along a side")]),
    Entry::new(
        "high_speed",
        "Small bodies at 250 m/s inside a closed room with thin walls: nothing may get out",
        jolt::high_speed,
    )
    .with(&[Parameter::whole("n", 5000, (1, 100_000), "bodies")]),
    Entry::new(
        "rope",
        "A rope with a ball at its end falls from level, and wraps round a bar",
        threads::rope,
    )
    .with(&[
        Parameter::whole("links", 40, (1, 10_000), "links"),
        Parameter::number("length", 4.0, (0.1, 1000.0), "of the rope [m]"),
        Parameter::number("ball", 0.5, (0.001, 1.0e4), "mass of the ball [kg]"),
    ]),
    Entry::new("cloth", "A cloth falls over a ball; hang=1: it hangs, and a ball flies into it", threads::cloth)
        .with(&[
            Parameter::whole("n", 40, (1, 1000), "squares along a side"),
            Parameter::whole("hang", 0, (0, 1), "1: it hangs by two corners"),
            Parameter::number("tear", 0.0, (0.0, 1.0e6), "force that tears a thread [N]; 0: none does"),
        ]),
    Entry::new("dust", "Points fall on stones of five shapes and on the ground", threads::dust)
        .with(&[Parameter::whole("n", 100_000, (1, 10_000_000), "points")]),
    Entry::new("hail", "Points fall on a field of loose cubes, four high", threads::hail).with(&[
        Parameter::whole("n", 10_000, (1, 1_000_000), "points"),
        Parameter::whole("bodies", 2000, (1, 100_000), "cubes"),
    ]),
];
