"""Physics: not there. The names serve imports and annotations."""

from __future__ import annotations

from habitat_sim._missing import PHYSICS, refused

ArticulatedObjectManager = refused("habitat_sim.physics.ArticulatedObjectManager", PHYSICS)
CollisionGroupHelper = refused("habitat_sim.physics.CollisionGroupHelper", PHYSICS)
CollisionGroups = refused("habitat_sim.physics.CollisionGroups", PHYSICS)
ContactPointData = refused("habitat_sim.physics.ContactPointData", PHYSICS)
JointMotorSettings = refused("habitat_sim.physics.JointMotorSettings", PHYSICS)
JointMotorType = refused("habitat_sim.physics.JointMotorType", PHYSICS)
JointType = refused("habitat_sim.physics.JointType", PHYSICS)
ManagedArticulatedObject = refused("habitat_sim.physics.ManagedArticulatedObject", PHYSICS)
ManagedBulletArticulatedObject = refused("habitat_sim.physics.ManagedBulletArticulatedObject", PHYSICS)
ManagedBulletRigidObject = refused("habitat_sim.physics.ManagedBulletRigidObject", PHYSICS)
ManagedRigidObject = refused("habitat_sim.physics.ManagedRigidObject", PHYSICS)
MotionType = refused("habitat_sim.physics.MotionType", PHYSICS)
PhysicsSimulationLibrary = refused("habitat_sim.physics.PhysicsSimulationLibrary", PHYSICS)
RayHitInfo = refused("habitat_sim.physics.RayHitInfo", PHYSICS)
RaycastResults = refused("habitat_sim.physics.RaycastResults", PHYSICS)
RigidConstraintSettings = refused("habitat_sim.physics.RigidConstraintSettings", PHYSICS)
RigidConstraintType = refused("habitat_sim.physics.RigidConstraintType", PHYSICS)
RigidObjectManager = refused("habitat_sim.physics.RigidObjectManager", PHYSICS)
RigidState = refused("habitat_sim.RigidState", PHYSICS)
VelocityControl = refused("habitat_sim.physics.VelocityControl", PHYSICS)

__all__ = [
    "ArticulatedObjectManager", "CollisionGroupHelper", "CollisionGroups", "ContactPointData",
    "JointMotorSettings", "JointMotorType", "JointType", "ManagedArticulatedObject",
    "ManagedBulletArticulatedObject", "ManagedBulletRigidObject", "ManagedRigidObject", "MotionType",
    "PhysicsSimulationLibrary", "RayHitInfo", "RaycastResults", "RigidConstraintSettings",
    "RigidConstraintType", "RigidObjectManager", "RigidState", "VelocityControl",
]  # fmt: skip
