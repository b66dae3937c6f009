"""Sensors of a compiled model."""

from __future__ import annotations

from typing import Any, get_args

from .bodies import Bodies
from .compiled import Compiled, xyzw
from .quaternions import product, turned
from .sensors import Kind, Sensor

_KINDS = {f"mjSENS_{kind.upper()}": kind for kind in get_args(Kind)}
_ZONES = {"SPHERE": "sphere", "CAPSULE": "capsule", "ELLIPSOID": "ellipsoid", "CYLINDER": "cylinder", "BOX": "box"}


class SensorElements:
    """Makes the sensors that a world can answer, and tells which it can't."""

    def __init__(self, model: Compiled, bodies: Bodies) -> None:
        self.model, self.bodies = model, bodies
        self.sensors: list[Sensor] = []
        self._kinds = {int(getattr(model.mujoco.mjtSensor, name)): kind for name, kind in _KINDS.items()}
        self._coordinates = {c.name: place for place, c in enumerate(bodies.joints.coordinates)}
        for number in range(model.arrays.nsensor):
            self._add(number)

    def _add(self, number: int) -> None:
        m, name = self.model.arrays, self.model.name("SENSOR", number)
        kind = self._kinds.get(int(m.sensor_type[number]))
        place: dict[str, Any] = {}
        why = ""
        if kind is None:
            why = f"worlds don't tell {self._word(number)}"
        elif int(m.sensor_refid[number]) >= 0:
            why = "it is relative to another frame"
        elif m.sensor_history[number].any() or m.sensor_interval[number].any() or m.sensor_delay[number]:
            why = "it is delayed"
        elif kind in ("jointpos", "jointvel"):
            joint = self.model.name("JOINT", int(m.sensor_objid[number]))
            place = {"coordinate": self._coordinates[joint]}
        else:
            place, why = self._place(number, kind)
        if why or kind is None:
            self.model.receipt.left_out("sensor", name, why)
            return
        self.sensors.append(Sensor(name, kind, **place, **self._ends(number)))
        if kind == "accelerometer":
            self.model.receipt.taken_as("sensor", name, "the mean between two readings")
        elif kind == "touch":
            self.model.receipt.taken_as("sensor", name, "the forces of points within its site")
        elif kind in ("force", "torque"):
            self.model.receipt.taken_as(
                "sensor", name, "that of the joint, in the last substep, without forces of actuators"
            )
        else:
            self.model.receipt.exact("sensor", name)

    def _word(self, number: int) -> str:
        return str(self.model.mujoco.mjtSensor(int(self.model.arrays.sensor_type[number])).name)[7:].lower()

    def _ends(self, number: int) -> dict[str, Any]:
        m, kinds = self.model.arrays, self.model.mujoco.mjtDataType
        cutoff, kind = float(m.sensor_cutoff[number]), int(m.sensor_datatype[number])
        if cutoff <= 0 or kind not in (kinds.mjDATATYPE_REAL, kinds.mjDATATYPE_POSITIVE):
            return {}
        return {"max_value": cutoff, "min_value": -cutoff if kind == kinds.mjDATATYPE_REAL else 0.0}

    def _place(self, number: int, kind: Kind) -> tuple[dict[str, Any], str]:
        """Fields of the sensor that say where it is, or why there is none."""
        m, objects = self.model.arrays, self.model.mujoco.mjtObj
        of, one = int(m.sensor_objtype[number]), int(m.sensor_objid[number])
        if of == objects.mjOBJ_SITE:
            body, position, turn = int(m.site_bodyid[one]), m.site_pos[one], m.site_quat[one]
        elif of == objects.mjOBJ_GEOM:
            body, position, turn = int(m.geom_bodyid[one]), m.geom_pos[one], m.geom_quat[one]
        elif of == objects.mjOBJ_BODY:
            body, position, turn = one, m.body_ipos[one], m.body_iquat[one]
        elif of == objects.mjOBJ_XBODY:
            body, position, turn = one, [0, 0, 0], [1, 0, 0, 0]
        else:
            return {}, "it is in no body"
        offset, frame = self.model.in_root(body)
        fields: dict[str, Any] = {
            "body": self.bodies.place_of(body),
            "position": tuple((offset + turned(frame, position)).tolist()),
            "orientation": tuple(product(frame, xyzw(turn)).tolist()),
        }
        if kind == "touch":
            types = {int(getattr(self.model.mujoco.mjtGeom, f"mjGEOM_{k}")): zone for k, zone in _ZONES.items()}
            fields |= {"zone": types[int(m.site_type[one])], "size": tuple(m.site_size[one].tolist())}
        elif kind in ("force", "torque"):
            last = int(m.body_jntadr[body] + m.body_jntnum[body]) - 1
            free = self.model.mujoco.mjtJoint.mjJNT_FREE
            if m.body_jntnum[body] == 0 or int(m.jnt_type[last]) == free:
                return {}, "no joint carries its body"
            own = [p for p, joint in enumerate(self.bodies.joints.scene) if joint.second == fields["body"]]
            fields["joint"] = own[0]
        return fields, ""
