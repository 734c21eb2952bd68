"""What is known of a shot's motion: exactly, or in frames; sampled, with energy and orientation."""

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
