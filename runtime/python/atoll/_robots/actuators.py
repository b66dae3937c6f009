"""Actuators of a compiled model."""

from __future__ import annotations

import math

from .. import _core
from .axes import axis_of, with_axis
from .compiled import Compiled
from .robot import Actuator, Robot
from .tendons import Tendons


class Actuators:
    """Gives the joints and tendons of a robot what drives them."""

    def __init__(self, model: Compiled, robot: Robot, tendons: Tendons) -> None:
        self.model, self.robot, self.tendons = model, robot, tendons
        self.places = {c.name: place for place, c in enumerate(robot.coordinates)}

    def add(self) -> None:
        m, mj = self.model.arrays, self.model.mujoco
        joints = list(self.robot.scene.joints)
        for number in range(m.nu):
            name = self.model.name("ACTUATOR", number)
            if self.model.is_off("ACTUATION"):
                self.model.receipt.left_out("actuator", name, "the model switches actuation off")
                continue
            place, why_not = self._place(number)
            if place is None:
                self.model.receipt.left_out("actuator", name, why_not)
                continue
            if int(m.actuator_dyntype[number]) != mj.mjtDyn.mjDYN_NONE:
                self.model.receipt.left_out("actuator", name, "it has dynamics of its own")
                continue
            gain, bias = int(m.actuator_gaintype[number]), int(m.actuator_biastype[number])
            if gain != mj.mjtGain.mjGAIN_FIXED or bias not in (mj.mjtBias.mjBIAS_NONE, mj.mjtBias.mjBIAS_AFFINE):
                self.model.receipt.left_out("actuator", name, "its gain isn't fixed, or its bias not affine")
                continue
            actuator = self._actuator(number, name, place)
            self.robot.actuators.append(actuator)
            of = None if actuator.tendon >= 0 else self.robot.coordinates[place]
            self._drive(joints[of.joint if of else place], of.axis if of else 0, actuator, name)
        self.robot.scene.joints = joints

    def _on_tendon(self, number: int) -> bool:
        return int(self.model.arrays.actuator_trntype[number]) == int(self.model.mujoco.mjtTrn.mjTRN_TENDON)

    def _place(self, number: int) -> tuple[int | None, str]:
        """The place of its coordinate, or of its tendon among the joints of the scene; or why it has none."""
        m, mj, target = self.model.arrays, self.model.mujoco, int(self.model.arrays.actuator_trnid[number][0])
        if self._on_tendon(number):
            return self.tendons.places.get(target), "its tendon is left out"
        if int(m.actuator_trntype[number]) not in (mj.mjtTrn.mjTRN_JOINT, mj.mjtTrn.mjTRN_JOINTINPARENT):
            return None, "it acts on no joint"
        return self.places.get(self.model.name("JOINT", target)), "it acts on a ball or free joint"

    def _actuator(self, number: int, name: str, place: int) -> Actuator:
        m, on_tendon, target = (
            self.model.arrays,
            self._on_tendon(number),
            int(self.model.arrays.actuator_trnid[number][0]),
        )
        kind = "tendon" if on_tendon else "jnt"
        gear = float(m.actuator_gear[number][0])
        gain = gear * float(m.actuator_gainprm[number][0])
        bias, by_position, by_rate = (0.0, 0.0, 0.0)
        if int(m.actuator_biastype[number]) == self.model.mujoco.mjtBias.mjBIAS_AFFINE:
            bias, by_position, by_rate = (float(x) for x in m.actuator_biasprm[number][:3])
        limits = [math.inf]
        for limited, ends, scale in (
            (m.actuator_forcelimited[number], m.actuator_forcerange[number], abs(gear)),
            (getattr(m, f"{kind}_actfrclimited")[target], getattr(m, f"{kind}_actfrcrange")[target], 1.0),
        ):
            if limited:
                limits.append(scale * min(abs(float(ends[0])), abs(float(ends[1]))))
                if ends[0] != -ends[1]:
                    note = f"its force in [{ends[0]}, {ends[1]}] within the smaller of both"
                    self.model.receipt.taken_as("actuator", name, note)
        controls = (-math.inf, math.inf)
        if m.actuator_ctrllimited[number]:
            controls = (float(m.actuator_ctrlrange[number][0]), float(m.actuator_ctrlrange[number][1]))
        return Actuator(
            name=name,
            coordinate=-1 if on_tendon else place,
            tendon=place if on_tendon else -1,
            kind="position" if by_position < 0 else "velocity" if by_rate < 0 else "force",
            gain=gain,
            bias=gear * bias,
            stiffness=-gear * gear * by_position,
            damping=-gear * gear * by_rate,
            limit=min(limits),
            range=controls,
        )

    def _drive(self, joint: _core.SceneJoint, coordinate: int, actuator: Actuator, name: str) -> None:
        if actuator.kind == "force":
            self.model.receipt.taken_as("actuator", name, "a force that Robot.control() gives to each step")
            return
        definition = joint.definition
        axis = axis_of(definition.kind, coordinate)
        if axis.motor is not None:
            self.model.receipt.left_out("actuator", name, "another one has its joint, or tendon")
            return
        self.model.receipt.exact("actuator", name)
        servo = _core.JointServo(
            target=actuator.bias / actuator.stiffness if actuator.kind == "position" else 0.0,
            stiffness=actuator.stiffness,
            damping=actuator.damping,
        )
        axis.motor = _core.JointMotor(max_force=actuator.limit, servo=servo)
        definition.kind = with_axis(definition.kind, coordinate, axis)
        joint.definition = definition
