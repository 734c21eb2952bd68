"""Recorded motion, exact or in frames; gives states, energy and orientation at any time."""

from ghostball.model.trajectory.segment import Phase
from ghostball.model.trajectory.tangent_map import TangentMap
from ghostball.model.trajectory.trajectory import (
    Energy,
    ExactTrajectory,
    SampledTrajectory,
    Samples,
    Tangents,
    Trajectory,
    energy_of,
)

__all__ = [
    "Energy",
    "ExactTrajectory",
    "Phase",
    "SampledTrajectory",
    "Samples",
    "TangentMap",
    "Tangents",
    "Trajectory",
    "energy_of",
]
