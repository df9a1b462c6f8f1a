#!/usr/bin/env python3
"""Writes the reference numbers of trees that the engine's tests compare with.

    python3 -m venv /tmp/mujoco && /tmp/mujoco/bin/pip install mujoco
    /tmp/mujoco/bin/python scripts/mujoco_reference.py crates/drystone/src/articulation/tests/mujoco.txt

The models are our own: trees that resemble an ant, a cheetah, a hopper, a walker, a humanoid, an
arm, a chain of balls, and one with odd axes. For random states the file has poses, mass matrix,
bias, inverse dynamics, Jacobian, center of mass, momentum, energies and accelerations. For trees
whose root is held it has the coordinates after half a second at steps of 0.1 ms (RK4), passive,
damped and driven. `--errors` prints MuJoCo's own errors at longer steps beside them.
"""

import random
import sys

import mujoco
import numpy

NONE = float("nan")


def joint(kind, axis=(0, 0, 1), anchor=(0, 0, 0), armature=0.0, damping=0.0, stiffness=0.0,
          rest=0.0, reference=0.0):
    return dict(kind=kind, axis=axis, anchor=anchor, armature=armature, damping=damping,
                stiffness=stiffness, rest=rest, reference=reference)


def rod(mass, end, radius=0.03):
    """Mass, center and inertia of a capsule-like rod from the origin to `end`."""
    end = numpy.array(end, dtype=float)
    length = numpy.linalg.norm(end)
    u = end / length
    along = 0.5 * mass * radius ** 2
    across = mass * (length ** 2 / 12 + radius ** 2 / 4)
    full = across * (numpy.eye(3) - numpy.outer(u, u)) + along * numpy.outer(u, u)
    return dict(mass=mass, center=tuple(end / 2),
                inertia=(full[0, 0], full[1, 1], full[2, 2], full[0, 1], full[0, 2], full[1, 2]))


def ball(mass, radius, center=(0, 0, 0)):
    i = 0.4 * mass * radius ** 2
    return dict(mass=mass, center=center, inertia=(i, i, i, 0, 0, 0))


def link(parent, position, body, joints, rotation=(1, 0, 0, 0)):
    return dict(parent=parent, position=position, rotation=rotation, joints=joints, **body)


def ant(held, armature=1.0, damping=1.0):
    root = [] if held else [joint("free")]
    links = [link(-1, (0, 0, 0.75), ball(0.33, 0.25), root)]
    for x, y in [(1, 1), (-1, 1), (-1, -1), (1, -1)]:
        extra = dict(armature=armature, damping=damping)
        links.append(link(0, (0.2 * x, 0.2 * y, 0), rod(0.036, (0.2 * x, 0.2 * y, 0), 0.08),
                          [joint("hinge", (0, 0, 1), **extra)]))
        links.append(link(len(links) - 1, (0.2 * x, 0.2 * y, 0),
                          rod(0.065, (0.4 * x, 0.4 * y, 0), 0.08),
                          [joint("hinge", (-y, x, 0), **extra)]))
    return links


def planar(held):
    if held:
        return []
    return [joint("slide", (1, 0, 0)), joint("slide", (0, 0, 1)), joint("hinge", (0, 1, 0))]


def cheetah(held, scale=1.0):
    body = rod(6.4, (1.0, 0, 0), 0.046)
    body["center"] = (0, 0, 0)
    links = [link(-1, (0, 0, 0.7), body, planar(held))]
    legs = [(-0.5, [(-0.1, -0.13, 1.5, 240, 6), (-0.14, -0.07, 1.6, 180, 4.5),
                    (0.03, -0.1, 1.1, 120, 3)]),
            (0.5, [(-0.07, -0.12, 1.4, 180, 4.5), (0.06, -0.1, 1.2, 120, 3),
                   (0.045, -0.07, 0.9, 60, 1.5)])]
    for x, parts in legs:
        parent, at = 0, (x, 0, 0)
        for dx, dz, mass, k, d in parts:
            links.append(link(parent, at, rod(mass, (2 * dx, 0, 2 * dz), 0.046),
                              [joint("hinge", (0, 1, 0), armature=0.1 * scale,
                                     stiffness=k * scale, damping=d * scale)]))
            parent, at = len(links) - 1, (2 * dx, 0, 2 * dz)
    return links


def hopper(held, damping=1.0, armature=1.0):
    extra = dict(damping=damping, armature=armature)
    torso = rod(3.5, (0, 0, 0.4), 0.05)
    return [link(-1, (0, 0, 1.05), torso, planar(held)),
            link(0, (0, 0, 0), rod(3.9, (0, 0, -0.45), 0.05), [joint("hinge", (0, -1, 0), **extra)]),
            link(1, (0, 0, -0.45), rod(2.7, (0, 0, -0.5), 0.04), [joint("hinge", (0, -1, 0), **extra)]),
            link(2, (0, 0, -0.5), rod(5.1, (0.39, 0, 0.02), 0.06), [joint("hinge", (0, -1, 0), **extra)])]


def walker(held, damping=0.1, armature=0.01):
    extra = dict(damping=damping, armature=armature)
    links = [link(-1, (0, 0, 1.05), rod(3.5, (0, 0, 0.4), 0.05), planar(held))]
    for y in (0.1, -0.1):
        links.append(link(0, (0, y, 0), rod(3.9, (0, 0, -0.45), 0.05), [joint("hinge", (0, -1, 0), **extra)]))
        links.append(link(len(links) - 1, (0, 0, -0.45), rod(2.7, (0, 0, -0.5), 0.04), [joint("hinge", (0, -1, 0), **extra)]))
        links.append(link(len(links) - 1, (0, 0, -0.5), rod(3.0, (0.2, 0, 0), 0.06), [joint("hinge", (0, -1, 0), **extra)]))
    return links


def humanoid(held, scale=1.0):
    def h(axis, armature=0.01, damping=5.0, stiffness=10.0):
        return joint("hinge", axis, armature=armature * scale, damping=damping * scale, stiffness=stiffness * scale)
    x, y, z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    links = [link(-1, (0, 0, 1.4), rod(8.3, (0, 0.14, 0.02), 0.07), [] if held else [joint("free")])]
    links[0]["center"] = (0, 0, 0.05)
    links.append(link(0, (-0.01, 0, -0.26), rod(2.0, (0, 0.12, 0.01), 0.06), [h(z, 0.02, stiffness=20), h(y, 0.02, stiffness=20)]))
    links.append(link(1, (0, 0, -0.165), rod(5.8, (-0.02, 0.14, 0), 0.09), [h(x)]))
    for s in (-1, 1):
        links.append(link(2, (0, 0.1 * s, -0.04), rod(4.5, (0, 0.01 * s, -0.34), 0.06), [h(x), h(z), h(y, 0.01, 5.0, 20)]))
        links.append(link(len(links) - 1, (0, 0.01 * s, -0.403), rod(2.6, (0, 0, -0.3), 0.049), [h((0, -1, 0), 0.006, 1.0, 1.0)]))
        links.append(link(len(links) - 1, (0, 0, -0.35), ball(1.7, 0.075, (0, 0, -0.1)), []))
    for s in (-1, 1):
        links.append(link(0, (0, 0.17 * s, 0.06), rod(1.6, (0.16, 0.16 * s, -0.16), 0.04), [h((2, s, s), 0.0068, 1.0, 1.0), h((0, -1, s), 0.0051, 1.0, 1.0)]))
        links.append(link(len(links) - 1, (0.18, 0.18 * s, -0.18), rod(1.2, (0.17, -0.17 * s, 0.17), 0.031), [h((0, -1, -s), 0.0028, 1.0, 0.0)]))
    return links


def arm(held=True):
    links = [link(-1, (0.1, -0.2, 0.3), ball(3.0, 0.1), [], (0.9, 0.1, 0.2, -0.3))]
    axes = [(0, 0, 1), (0, 1, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1)]
    for i, axis in enumerate(axes):
        mass = [4.0, 3.5, 3.0, 2.5, 1.5, 1.0, 0.3][i]
        links.append(link(i, (0, 0, 0) if i == 0 else (0.05, 0.02, 0.2), rod(mass, (0.05, 0.02, 0.2)),
                          [joint("hinge", axis, armature=0.1 if i < 3 else 0.0, damping=0.2)]))
    return links


def balls(held):
    links = [link(-1, (0, 0, 1), rod(1.0, (0.3, 0, 0)), [joint("ball")] if held else [joint("free")])]
    for i in range(4):
        links.append(link(i, (0.3, 0, 0), rod(1.0 / (i + 1), (0.3, 0.05 * i, 0.02)),
                          [joint("ball", anchor=(0.01, 0.02, -0.01), damping=0.02 * i)], (1, 0.1 * i, 0.2, -0.1)))
    return links


def odd(held=True):
    return [link(-1, (0.3, 0.1, -0.2), rod(2.0, (0.1, 0.2, 0.3)),
                 [joint("slide", (1, 2, -1)), joint("hinge", (1, 0, 1), (0.1, 0.05, -0.2), reference=0.3)], (0.5, 0.5, -0.2, 0.1)),
            link(0, (0.1, -0.1, 0.2), rod(0.05, (0.2, 0.2, 0)),
                 [joint("hinge", (0, 1, 1), (0.05, 0, 0.1), 0.01, stiffness=3.0, rest=0.2), joint("slide", (0, 0, 1), damping=0.3),
                  joint("ball", (0, 0, 1), (0.02, 0.03, 0.04))], (0.2, 0.9, 0.1, 0.3)),
            link(1, (0, 0.2, 0), rod(20.0, (0.1, 0, 0.3)), [joint("hinge", (1, 1, 1), (0.1, 0.1, 0.1))]),
            link(1, (0, -0.2, 0), rod(0.01, (0.1, 0, -0.1), 0.01), []),
            link(3, (0.05, 0, 0), rod(0.5, (0, 0.1, 0)), [joint("hinge", (1, 0, 0)), joint("hinge", (0, 1, 0)), joint("hinge", (0, 0, 1))])]


def text(values):
    return " ".join(repr(float(v)) for v in numpy.asarray(values).ravel())


def xml(links, passive=True, step=1e-4, integrator="RK4"):
    children = {}
    for i, l in enumerate(links):
        children.setdefault(l["parent"], []).append(i)

    def numbers(values):
        return text(values)

    def body(i):
        l = links[i]
        out = f'<body name="b{i}" pos="{numbers(l["position"])}" quat="{numbers(l["rotation"])}">'
        xx, yy, zz, xy, xz, yz = l["inertia"]
        out += f'<inertial pos="{numbers(l["center"])}" mass="{float(l["mass"])!r}" fullinertia="{numbers((xx, yy, zz, xy, xz, yz))}"/>'
        for j in l["joints"]:
            if j["kind"] == "free":
                out += '<joint type="free" armature="0" damping="0"/>'
                continue
            scale = 1.0 if passive else 0.0
            out += (f'<joint type="{j["kind"]}" pos="{numbers(j["anchor"])}" armature="{j["armature"] * scale!r}" '
                    f'damping="{j["damping"] * scale!r}" stiffness="{j["stiffness"] * scale!r}" ')
            if j["kind"] != "ball":
                out += f'axis="{numbers(j["axis"])}" ref="{j["reference"]!r}" springref="{j["rest"]!r}" '
            out += "/>"
        return out + "".join(body(c) for c in children.get(i, [])) + "</body>"

    return (f'<mujoco><compiler angle="radian" inertiafromgeom="false" balanceinertia="false" boundmass="0" boundinertia="0"/>'
            f'<option timestep="{step!r}" integrator="{integrator}" gravity="0 0 -9.81"><flag energy="enable" constraint="disable" contact="disable"/></option>'
            f"<worldbody>{body(0)}</worldbody></mujoco>")


def write_model(out, name, links):
    print("model", name, file=out)
    for l in links:
        print("link", l["parent"], text(l["position"]), text(l["rotation"]), float(l["mass"]), text(l["center"]), text(l["inertia"]), file=out)
        for j in l["joints"]:
            print("joint", j["kind"], text(j["axis"]), text(j["anchor"]), j["reference"], j["armature"], j["damping"], j["stiffness"], j["rest"], file=out)


def write_states(out, links, rng):
    model = mujoco.MjModel.from_xml_string(xml(links))
    data = mujoco.MjData(model)
    for _ in range(2):
        for i in range(model.nq):
            data.qpos[i] = rng.uniform(-1, 1)
        mujoco.mj_normalizeQuat(model, data.qpos)
        for i in range(model.nv):
            data.qvel[i] = rng.uniform(-2, 2)
            data.qfrc_applied[i] = rng.uniform(-3, 3)
        a = numpy.array([rng.uniform(-5, 5) for _ in range(model.nv)])
        mujoco.mj_forward(model, data)
        full = numpy.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        inverse = numpy.zeros(model.nv)
        mujoco.mj_mulM(model, data, inverse, a)
        inverse += data.qfrc_bias
        last = model.nbody - 1
        point = data.xpos[last] + data.xmat[last].reshape(3, 3) @ numpy.array([0.1, 0.2, 0.3])
        linear, angular = numpy.zeros((3, model.nv)), numpy.zeros((3, model.nv))
        mujoco.mj_jac(model, data, linear, angular, point, last)
        mujoco.mj_subtreeVel(model, data)
        mass = model.body_subtreemass[1]
        for key, value in [("q", data.qpos), ("v", data.qvel), ("tau", data.qfrc_applied), ("a", a),
                           ("position", data.xpos[1:]), ("rotation", data.xquat[1:]), ("mass", full), ("bias", data.qfrc_bias),
                           ("inverse", inverse), ("linear", linear), ("angular", angular), ("center", data.subtree_com[1]),
                           ("momentum", numpy.concatenate([data.subtree_angmom[1], mass * data.subtree_linvel[1]])),
                           ("energy", data.energy), ("acceleration", data.qacc)]:
            print(key, text(value), file=out)


def swing(links, passive, drive, step, integrator, seconds=0.5):
    model = mujoco.MjModel.from_xml_string(xml(links, passive, step, integrator))
    data = mujoco.MjData(model)
    for i in range(model.nv):
        data.qfrc_applied[i] = drive * (1 if i % 2 == 0 else -1)
    first = data.qpos.copy()
    mujoco.mj_forward(model, data)
    start = data.xquat[1:].copy()
    energy = data.energy.sum()
    scale = 0.0
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
        scale = max(scale, data.energy[1])
    mujoco.mj_forward(model, data)
    return first, data.qpos.copy(), data.xquat[1:].copy(), start, (data.energy.sum() - energy) / max(scale, 1e-12)


def angle(a, b):
    return numpy.degrees(2 * numpy.arccos(numpy.clip(numpy.abs((a * b).sum(axis=1)), 0, 1))).max()


def main():
    errors = "--errors" in sys.argv
    out = sys.stdout if errors else open(sys.argv[1], "w")
    rng = random.Random(7)
    makers = [("ant", ant), ("cheetah", cheetah), ("hopper", hopper), ("walker", walker), ("humanoid", humanoid),
              ("arm", arm), ("balls", balls), ("odd", odd)]
    for name, maker in makers:
        links = maker(name in ("arm", "odd"))
        if not errors:
            write_model(out, name, links)
            write_states(out, links, rng)
    for name, maker in makers:
        links = maker(True)
        for kind, passive, drive in [("free", False, 0.0), ("damped", True, 0.0), ("driven", True, 0.5)]:
            # A constant force makes light links of these fly round too fast to compare.
            if kind == "driven" and name in ("balls", "odd"):
                continue
            first, last, turned, start, energy = swing(links, passive, drive, 1e-4, "RK4")
            if errors:
                row = [f"{name} {kind}: turns {angle(start, turned):.1f}"]
                for step, integrator in [(0.002, "Euler"), (0.002, "implicitfast"), (0.01, "Euler"), (0.01, "RK4")]:
                    got = swing(links, passive, drive, step, integrator)
                    row.append(f"{integrator} {1000 * step:g} ms {angle(got[2], turned):.4f} deg, energy {got[4]:.1e}")
                print("; ".join(row))
                continue
            write_model(out, f"{name}-{kind}", links)
            print("swing", int(passive), drive, text(last), file=out)
            print("rotation", text(turned), file=out)


if __name__ == "__main__":
    main()
