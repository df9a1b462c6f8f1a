"""Writes what MuJoCo's compiler makes of FILE.xml to FILE.json, for the tests of the description of robots.

pip install mujoco; python compile.py *.xml
"""

import json
import sys

import mujoco


def powers(first, rest):
    return [float(first), *plain(rest)]


def name(model, kind, i):
    return mujoco.mj_id2name(model, kind, i) if i >= 0 else None


def limited(flag, values):
    return plain(values) if flag else None


def plain(values):
    """Numbers without needless zeros."""
    return [int(x) if x == int(x) else float(x) for x in values]


def numbers(model):
    obj = mujoco.mjtObj
    joints = []
    for i in range(model.njnt):
        q, v = int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i])
        kind = mujoco.mjtJoint(int(model.jnt_type[i]))
        joints.append({
            "name": name(model, obj.mjOBJ_JOINT, i),
            "link": name(model, obj.mjOBJ_BODY, model.jnt_bodyid[i]),
            "kind": kind.name[len("mjJNT_"):].lower(),
            "axis": plain(model.jnt_axis[i]),
            "anchor": plain(model.jnt_pos[i]),
            "q": q,
            "v": v,
            "range": limited(model.jnt_limited[i], model.jnt_range[i]),
            "force_range": limited(model.jnt_actfrclimited[i], model.jnt_actfrcrange[i]),
            "gravity_by_actuators": bool(model.jnt_actgravcomp[i]),
            "stiffness": powers(model.jnt_stiffness[i], model.jnt_stiffnesspoly[i]),
            "damping": powers(model.dof_damping[v], model.dof_dampingpoly[v]),
            "armature": float(model.dof_armature[v]),
            "friction": float(model.dof_frictionloss[v]),
            "margin": float(model.jnt_margin[i]),
            "reference": float(model.qpos0[q]),
            "spring_reference": float(model.qpos_spring[q]),
        })
    tendons = []
    for i in range(model.ntendon):
        path = []
        for w in range(model.tendon_adr[i], model.tendon_adr[i] + model.tendon_num[i]):
            kind = mujoco.mjtWrap(int(model.wrap_type[w])).name[len("mjWRAP_"):].lower()
            of = {"joint": obj.mjOBJ_JOINT, "site": obj.mjOBJ_SITE}.get(kind, obj.mjOBJ_GEOM)
            number = float(model.wrap_prm[w])
            side = name(model, obj.mjOBJ_SITE, int(number)) if kind in ("sphere", "cylinder") else None
            of_name = name(model, of, int(model.wrap_objid[w])) if kind != "pulley" else None
            path.append([kind, of_name, side, number if kind in ("joint", "pulley") else 0.0])
        tendons.append({
            "name": name(model, obj.mjOBJ_TENDON, i),
            "path": path,
            "range": limited(model.tendon_limited[i], model.tendon_range[i]),
            "stiffness": powers(model.tendon_stiffness[i], model.tendon_stiffnesspoly[i]),
            "damping": powers(model.tendon_damping[i], model.tendon_dampingpoly[i]),
            "friction": float(model.tendon_frictionloss[i]),
            "armature": float(model.tendon_armature[i]),
            "spring_length": plain(model.tendon_lengthspring[i]),
        })
    actuators = []
    for i in range(model.nu):
        kind = mujoco.mjtTrn(int(model.actuator_trntype[i]))
        trn = kind.name[len("mjTRN_"):].lower()
        a, b = (int(x) for x in model.actuator_trnid[i])
        of = {
            "joint": obj.mjOBJ_JOINT, "jointinparent": obj.mjOBJ_JOINT, "tendon": obj.mjOBJ_TENDON, "body": obj.mjOBJ_BODY,
        }.get(trn, obj.mjOBJ_SITE)
        second = name(model, obj.mjOBJ_SITE, b) if trn in ("site", "slidercrank") else None
        actuators.append({
            "name": name(model, obj.mjOBJ_ACTUATOR, i),
            "transmission": [trn, name(model, of, a), second],
            "crank_length": float(model.actuator_cranklength[i]),
            "gear": plain(model.actuator_gear[i]),
            "control_range": limited(model.actuator_ctrllimited[i], model.actuator_ctrlrange[i]),
            "force_range": limited(model.actuator_forcelimited[i], model.actuator_forcerange[i]),
            "activation_range": limited(model.actuator_actlimited[i], model.actuator_actrange[i]),
            "length_range": plain(model.actuator_lengthrange[i]),
            "dynamics": mujoco.mjtDyn(int(model.actuator_dyntype[i])).name[len("mjDYN_"):].lower(),
            "gain": mujoco.mjtGain(int(model.actuator_gaintype[i])).name[len("mjGAIN_"):].lower(),
            "bias": mujoco.mjtBias(int(model.actuator_biastype[i])).name[len("mjBIAS_"):].lower(),
            "dynamics_numbers": plain(model.actuator_dynprm[i]),
            "gain_numbers": plain(model.actuator_gainprm[i]),
            "bias_numbers": plain(model.actuator_biasprm[i]),
            "acts_early": bool(model.actuator_actearly[i]),
            "armature": float(model.actuator_armature[i]),
            "damping": powers(model.actuator_damping[i], model.actuator_dampingpoly[i]),
        })
    sensors = []
    for i in range(model.nsensor):
        kind = mujoco.mjtSensor(int(model.sensor_type[i])).name[len("mjSENS_"):].lower()
        of, ref = mujoco.mjtObj(int(model.sensor_objtype[i])), mujoco.mjtObj(int(model.sensor_reftype[i]))
        thing = lambda o, n: [o.name[len("mjOBJ_"):].lower(), name(model, o, n)] if n >= 0 else None
        sensors.append({
            "name": name(model, obj.mjOBJ_SENSOR, i),
            "kind": kind,
            "object": thing(of, int(model.sensor_objid[i])),
            "reference": thing(ref, int(model.sensor_refid[i])),
            "size": int(model.sensor_dim[i]),
            "cutoff": float(model.sensor_cutoff[i]),
            "noise": float(model.sensor_noise[i]),
        })
    keyframes = [
        {
            "name": name(model, obj.mjOBJ_KEY, i),
            "time": float(model.key_time[i]),
            "q": plain(model.key_qpos[i]),
            "v": plain(model.key_qvel[i]),
            "act": plain(model.key_act[i]),
            "ctrl": plain(model.key_ctrl[i]),
            "mocap_positions": plain(model.key_mpos[i]),
            "mocap_rotations": plain(model.key_mquat[i]),
        }
        for i in range(model.nkey)
    ]
    start = plain(model.qpos0)
    return {
        "start": start, "joints": joints, "tendons": tendons, "actuators": actuators, "sensors": sensors,
        "keyframes": keyframes,
    }


def lines(things):
    """One thing a line."""
    return ",\n".join(json.dumps(thing) for thing in things)


for file in sys.argv[1:]:
    model = mujoco.MjModel.from_xml_path(file)
    text = "{\n" + ",\n".join(f'"{k}": [\n{lines(v)}\n]' for k, v in numbers(model).items()) + "\n}"
    with open(file.removesuffix(".xml") + ".json", "w", encoding="utf-8") as out:
        out.write(text + "\n")
