#!/usr/bin/env python3
"""Writes MuJoCo's masses of our own small files, which tests compare with.

    python3 -m venv /tmp/mujoco && /tmp/mujoco/bin/pip install mujoco
    /tmp/mujoco/bin/python scripts/mujoco_masses.py crates/drystone-scene/tests/data/mjcf-own

Writes the files that vary one thing, then `masses.txt`: for each moving body of each file its mass,
center and inertia about it (xx yy zz xy xz yz) in its own frame.
"""

import os
import sys

import mujoco
import numpy

MESH = '<asset><mesh name="m" {asset}/></asset>'
BODY = '<worldbody><body name="b" pos="0 0 1"><freejoint/>{inside}</body></worldbody>'
U_VERTEX = ("0 0 0 .3 0 0 .3 .1 0 .1 .1 0 .1 .3 0 .3 .3 0 .3 .4 0 0 .4 0 0 0 .1 .3 0 .1 .3 .1 .1 .1 .1 .1 "
            ".1 .3 .1 .3 .3 .1 .3 .4 .1 0 .4 .1 .1 0 0 .1 .4 0 .1 0 .1 .1 .4 .1")
U_FACE = ("0 17 16 0 7 17 16 2 1 16 3 2 4 6 5 4 17 6 8 18 19 8 19 15 18 9 10 18 10 11 12 13 14 12 14 19 0 16 18 "
          "0 18 8 16 1 9 16 9 18 1 2 10 1 10 9 2 3 11 2 11 10 3 4 12 3 12 11 4 5 13 4 13 12 5 6 14 5 14 13 6 17 19 "
          "6 19 14 17 7 15 17 15 19 7 0 8 7 8 15")
U = f'vertex="{U_VERTEX}" face="{U_FACE}" '


def files():
    def mesh(asset, geom='type="mesh" mesh="m"', compiler=""):
        return f"<compiler {compiler}/>" + MESH.format(asset=asset) + BODY.format(inside=f"<geom {geom}/>")

    for kind in ["legacy", "exact", "convex", "shell"]:
        yield f"mesh_{kind}", mesh(U + f'inertia="{kind}"')
    yield "mesh_default", mesh(U)
    yield "mesh_mirrored", mesh(U + 'inertia="exact" scale="1 -1 1"')
    yield "mesh_moved", mesh(U + 'inertia="exact" refpos="1 2 3" refquat="1 0 0 1" scale="2 3 4"',
                             'type="mesh" mesh="m" pos="1 0 0" euler="30 40 50" mass="3"')
    yield "mesh_points", mesh('vertex="0 0 0 1 0 0 0 1 0 0 0 1"')
    for kind in ["box", "sphere", "capsule", "cylinder", "ellipsoid"]:
        l = 'file="concave_l.obj"'
        yield f"fitted_{kind}", mesh(l, f'type="{kind}" mesh="m" pos=".1 0 0" euler="20 0 0"')
        yield f"around_{kind}", mesh(l, f'type="{kind}" mesh="m" fitscale="1.1"', 'fitaabb="true"')
    sizes = {"sphere": ".1", "capsule": ".1 .2", "cylinder": ".1 .2", "box": ".1 .2 .3",
             "ellipsoid": ".1 .2 .3"}
    for kind, size in sizes.items():
        for skin in ["false", "true"]:
            yield f"{kind}_{skin}", BODY.format(
                inside=f'<geom type="{kind}" size="{size}" shellinertia="{skin}" pos="1 2 3" euler="10 20 30"/>')
    inside = '<inertial pos=".1 0 0" mass="2" diaginertia="1 2 2.5"/><geom size=".1" mass="3"/>'
    for kind in ["true", "false", "auto"]:
        yield f"from_geom_{kind}", f'<compiler inertiafromgeom="{kind}"/>' + BODY.format(inside=inside)
    two = ('<worldbody><body name="b"><joint axis="0 1 0"/><geom size=".01"/><body name="c" pos=".1 0 0">'
           '<joint/><geom size=".02" pos=".1 0 0"/></body></body></worldbody>')
    for name, compiler in [("bound_mass", 'boundmass=".01"'), ("bound_inertia", 'boundinertia="1e-6"'),
                           ("bound_both", 'boundmass="1" boundinertia=".01" settotalmass="5"')]:
        yield name, f"<compiler {compiler}/>" + two
    yield "balance", '<compiler balanceinertia="true"/>' + BODY.format(
        inside='<inertial pos="0 0 0" euler="0 0 30" mass="1" diaginertia="1 1 5"/>')
    yield "groups", ('<compiler inertiagrouprange="1 2"/>' + BODY.format(
        inside="".join(f'<geom size=".1" pos="{g} 0 0" group="{g}"/>' for g in range(4))))
    yield "frames", ('<worldbody><body name="b" pos="0 0 1"><frame pos=".1 0 0" euler="0 90 0"><frame pos="0 .2 0">'
                     '<joint name="j" axis="0 0 1" pos="0 0 .1"/><geom size=".1"/></frame></frame></body></worldbody>')


def main(folder):
    for name, inside in files():
        with open(os.path.join(folder, name + ".xml"), "w") as out:
            out.write(f"<mujoco>{inside}</mujoco>\n")
    lines = []
    for name in sorted(os.listdir(folder)):
        if not name.endswith(".xml"):
            continue
        model = mujoco.MjModel.from_xml_path(os.path.join(folder, name))
        for i in range(1, model.nbody):
            turn = numpy.zeros(9)
            mujoco.mju_quat2Mat(turn, model.body_iquat[i])
            turn = turn.reshape(3, 3)
            full = turn @ numpy.diag(model.body_inertia[i]) @ turn.T
            numbers = [model.body_mass[i], *model.body_ipos[i],
                       *(full[j, k] for j, k in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)])]
            label = model.body(i).name or f"#{i}"
            lines.append(f"{name} {label} " + " ".join(f"{x:.9g}" for x in numbers))
    with open(os.path.join(folder, "masses.txt"), "w") as out:
        out.write("\n".join(lines) + "\n")


main(sys.argv[1])
