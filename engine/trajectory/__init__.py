"""What is known of a shot's motion: exactly, or in frames; sampled, with energy and orientation."""

from ghostball.engine.trajectory.trajectory import (
    Energy,
    ExactTrajectory,
    Phase,
    SampledTrajectory,
    Samples,
    Trajectory,
    energy_of,
)

__all__ = [
    "Energy",
    "ExactTrajectory",
    "Phase",
    "SampledTrajectory",
    "Samples",
    "Trajectory",
    "energy_of",
]
