"""Rigid-body physics: island-parallel, and the same bits every time.

`Batch` steps many worlds of one scene, and `atoll.gym`, which takes gymnasium, makes environments of such.

Units are SI, angles radians. Vectors are passed as sequences or arrays of three numbers, orientations as x, y, z, w, and
many of either as arrays of a row each. Everything that is unusable raises `Error`, which names the field, the value that
was found and what was expected.

    import atoll

    world = atoll.World()
    world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
    crate = world.add_body(shape=atoll.Box([0.5, 0.5, 0.5]), position=[0, 0, 3])
    for _ in range(120):
        world.step(1 / 60)
    print(world.positions[crate])
"""

import numpy as _numpy  # without it the module below can't say what is missing

from ._core import (
    Axis as Axis,
    BallJoint as BallJoint,
    BallServo as BallServo,
    Batch as Batch,
    BodyDef as BodyDef,
    BodyForce as BodyForce,
    BodyHash as BodyHash,
    BodyId as BodyId,
    BodyNumber as BodyNumber,
    BodyTorque as BodyTorque,
    BodyType as BodyType,
    Box as Box,
    BuiltinScene as BuiltinScene,
    Capsule as Capsule,
    ClosestPoint as ClosestPoint,
    CollisionFilter as CollisionFilter,
    CombineRule as CombineRule,
    Compound as Compound,
    CompoundChild as CompoundChild,
    Cone as Cone,
    ConeTwistJoint as ConeTwistJoint,
    ContactCandidate as ContactCandidate,
    ContactSolver as ContactSolver,
    ConvexHull as ConvexHull,
    Cylinder as Cylinder,
    DistanceJoint as DistanceJoint,
    Ellipsoid as Ellipsoid,
    Error as Error,
    ErrorMeter as ErrorMeter,
    ErrorTarget as ErrorTarget,
    FeatureReport as FeatureReport,
    Film as Film,
    FixedJoint as FixedJoint,
    Forces as Forces,
    FrictionModel as FrictionModel,
    GearJoint as GearJoint,
    HalfSpace as HalfSpace,
    HeightField as HeightField,
    HingeJoint as HingeJoint,
    InverseKinematics as InverseKinematics,
    JointAxis as JointAxis,
    JointDef as JointDef,
    JointEvent as JointEvent,
    JointEventKind as JointEventKind,
    JointId as JointId,
    JointMotor as JointMotor,
    JointNumber as JointNumber,
    JointRange as JointRange,
    JointServo as JointServo,
    JointSolver as JointSolver,
    JointSpring as JointSpring,
    JointState as JointState,
    MassProperties as MassProperties,
    Material as Material,
    MaterialPair as MaterialPair,
    Mechanism as Mechanism,
    MechanismJoint as MechanismJoint,
    MechanismMomentum as MechanismMomentum,
    ModifiableContact as ModifiableContact,
    ModifiablePoint as ModifiablePoint,
    MotionLocks as MotionLocks,
    MotorSpeed as MotorSpeed,
    FirstDifference as FirstDifference,
    FirstDifferenceResult as FirstDifferenceResult,
    Playback as Playback,
    Pose as Pose,
    Quarantine as Quarantine,
    Quarantined as Quarantined,
    QueryFilter as QueryFilter,
    RayHit as RayHit,
    Recording as Recording,
    ReplayDivergence as ReplayDivergence,
    ReplayedBody as ReplayedBody,
    ReplayResult as ReplayResult,
    Scene as Scene,
    SceneBody as SceneBody,
    SceneError as SceneError,
    SceneJoint as SceneJoint,
    SceneParameter as SceneParameter,
    ServoTarget as ServoTarget,
    Settings as Settings,
    ShapeHit as ShapeHit,
    Simd as Simd,
    SixDofJoint as SixDofJoint,
    SixDofTurns as SixDofTurns,
    SliderJoint as SliderJoint,
    Snapshot as Snapshot,
    Sphere as Sphere,
    Stabilisation as Stabilisation,
    StepCounts as StepCounts,
    StepReport as StepReport,
    TaperedCapsule as TaperedCapsule,
    TargetError as TargetError,
    TendonJoint as TendonJoint,
    TendonTerm as TendonTerm,
    TriangleMesh as TriangleMesh,
    MissedTarget as MissedTarget,
    UniversalJoint as UniversalJoint,
    WheelJoint as WheelJoint,
    World as World,
    body_mass as body_mass,
    builtin_scenes as builtin_scenes,
    find_first_difference as find_first_difference,
    has_page as has_page,
    is_recording as is_recording,
    joint_at as joint_at,
    load_scene as load_scene,
    mass_properties as mass_properties,
    parse_scene as parse_scene,
    replay as replay,
    scene_of as scene_of,
    unlimited as unlimited,
    version as __version__,
    view as view,
)
from ._robots import Receipt as Receipt, Robot as Robot, load_mjcf as load_mjcf, load_urdf as load_urdf
from ._ensemble import EnsembleError as EnsembleError, ensemble as ensemble
from ._sweep import SweepTable as SweepTable, sweep as sweep

#: What numbers of Batch.rollout() act on.
Control = MotorSpeed | ServoTarget | BodyForce | BodyTorque
