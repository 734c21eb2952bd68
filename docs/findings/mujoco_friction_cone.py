"""MuJoCo: both impulses of a slipping contact are too large. Needs only `pip install mujoco`.

A ball without gravity hits a plane. The contact is a pure damper, which gives it a restitution of
0.85 in one step, and has Coulomb friction. Restitution must not depend on friction: the ball must
leave at 0.85 of its approach speed.
"""

import mujoco

R, MASS = 0.028575, 0.17  # [m], [kg]
RESTITUTION, DT = 0.85, 1e-7  # [s]
APPROACH = 1.0  # [m/s]

MODEL = """
<mujoco>
  <option timestep="{dt}" gravity="0 0 0" cone="elliptic" solver="Newton" iterations="200"
          tolerance="1e-14" integrator="Euler"/>
  <worldbody>
    <geom name="plane" type="plane" size="1 1 1"/>
    <body pos="0 0 {height}">
      <freejoint/>
      <geom name="ball" type="sphere" size="{radius}" mass="{mass}"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="plane" geom2="ball" condim="3" friction="{mu} {mu} 0 0 0" margin="1e-9"
          solref="0 {damper}" solreffriction="0 {stop}" solimp="0.9999 0.9999 0.001 0.5 2"/>
  </contact>
</mujoco>
"""


def leaves(mu: float, slip: float) -> tuple[float, float]:
    """Return the ratio of the speeds after and before the impact, and the lost slip [m/s]."""
    damper, stop = -(1.0 + RESTITUTION) / DT, -1.0 / DT
    text = MODEL.format(dt=DT, height=R, radius=R, mass=MASS, mu=mu, damper=damper, stop=stop)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[:3] = slip, 0.0, -APPROACH
    mujoco.mj_step(model, data)
    return data.qvel[2] / APPROACH, slip - data.qvel[0]


def main() -> None:
    """Print both values for several frictions and slips."""
    print(f"MuJoCo {mujoco.__version__}; expected: leaves at {RESTITUTION}, for any mu and slip")
    print("  mu   slip [m/s]   leaves at   impulse too large by")
    for mu in (0.0, 0.06, 0.2):
        for slip in (0.2, 0.5, 1.0, 2.0):
            found, lost = leaves(mu, slip)
            ends = "sticks" if lost * 3.5 > slip * (1 - 1e-3) else "slips"
            excess = 100.0 * (found - RESTITUTION) / (1.0 + RESTITUTION)
            print(f"{mu:4}   {slip:10}   {found:9.4f}   {excess:5.2f} %   {ends}")


if __name__ == "__main__":
    main()
