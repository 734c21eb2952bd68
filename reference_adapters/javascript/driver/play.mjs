// Simulates a scene in the world of an engine: the engine moves the balls and resolves their contacts, and
// cloth.mjs applies the cloth friction between its steps, in closed form. Each ball gets its mean velocity
// over the coming step, so that the engine moves it as the cloth would. The change of this velocity by the
// engine is the effect of contacts.
//
// A world is created from a loaded engine, a scene, its cushions and settings, and has
//
//     collidesFirst       whether a step first finds contacts and then moves the balls, or the reverse
//     damped              whether the engine slows balls by itself
//     noise               impulses below this fraction of the largest possible momentum are ignored
//     iterations          number of iterations of its solver
//     start(i, vx, vy)    set the velocity of a ball [m/s]
//     step(dt)            advance by dt [s]; return the contacts, [a, b, impulse]: b is a ball, or the name
//                         of a cushion; the impulse [kg m/s] is 0 if the contact did not push
//     read(i)             return x, y [m], vx, vy [m/s] of a ball

import { clothOf } from "./cloth.mjs";
import { timeToContact } from "./contact_time.mjs";

const NORMALS = { left: [1, 0], right: [-1, 0], bottom: [0, 1], top: [0, -1] };

export const cushionsOf = ({ table }) =>
  (table ? table.cushions : []).map((name) => {
    const point = [name === "right" ? table.length : 0, name === "top" ? table.width : 0];
    return { name, normal: NORMALS[name], point };
  });

// Return the restitution of balls, and the normal restitution of cushions.
export function restitutionsOf({ physics }) {
  return [physics.ball_restitution, physics.cushion === "mirror" ? 1 : physics.cushion_restitution];
}

// Return the momentum of the heaviest ball if it had all the energy [kg m/s].
function largestMomentum({ balls }) {
  const energy = balls.map(({ mass, radius, velocity, angular_velocity }) => {
    const spin = angular_velocity ? radius * Math.hypot(...angular_velocity) : Math.hypot(...velocity);
    return 0.5 * mass * (Math.hypot(...velocity) ** 2 + 0.4 * spin ** 2);
  });
  return Math.sqrt(2 * energy.reduce((sum, one) => sum + one, 0) * Math.max(...balls.map(({ mass }) => mass)));
}

class Recorder {
  // frameInterval: shortest time between two samples, except at events [s]
  constructor(scene, record, frameInterval) {
    this.scene = scene;
    this.record = record;
    this.frameInterval = frameInterval;
    this.events = [];
    this.samples = { t: [], positions: [], velocities: [], angular_velocities: [] };
    this.last = -Infinity;
    this.due = false;
  }

  event(t, kind, a, b = null) {
    this.due = true;
    if (typeof b === "number" && b < a) [a, b] = [b, a];
    this.events.push({ t, kind, a, b });
  }

  wants(t) {
    return this.record === "trajectory" && (this.due || t - this.last >= this.frameInterval * (1 - 1e-9));
  }

  frame(t, positions, motion) {
    this.samples.t.push(t);
    this.samples.positions.push(positions.map(([x, y], i) => [x, y, this.scene.balls[i].radius]));
    this.samples.velocities.push(motion.map(({ velocity: [x, y] }) => [x, y, 0]));
    this.samples.angular_velocities.push(motion.map(({ spin }) => spin));
    [this.last, this.due] = [t, false];
  }
}

export function play(World, engine, scene, record, settings) {
  const cushions = cushionsOf(scene);
  const along = scene.physics.cushion === "restitution" ? scene.physics.cushion_tangential_restitution : 1;
  const world = new World(engine, scene, cushions, settings);
  const cloth = clothOf(scene);
  const noise = world.noise * largestMomentum(scene);
  const end = Math.min(scene.t_max ?? Infinity, settings.max_time);
  const count = Math.max(1, Math.ceil((end / settings.dt) * (1 - 1e-12)));
  const exact = settings.contact_steps === "exact";
  const recorder = new Recorder(scene, record, settings.frame_interval);
  const motion = () => cloth.map((ball) => ({ velocity: [ball.vx, ball.vy], spin: ball.spin() }));
  let positions = scene.balls.map((_, i) => world.read(i).slice(0, 2));
  let lasting = new Set();
  let [t, steps, contactsSolved, status, reason] = [0, 0, 0, "", ""];

  // Return the length and the end of the next step [s], and whether bodies touch at its end.
  function nextStep() {
    if (!exact) return [end / count, steps + 1 === count ? end : (steps + 1) * (end / count), false];
    const left = end - t;
    const changes = cloth.flatMap((ball) => ball.durations()).filter((one) => one > 0);
    const horizon = Math.min(settings.dt, left, ...changes);
    const balls = cloth.map((ball, i) => ({
      position: positions[i],
      velocity: [ball.vx, ball.vy],
      acceleration: ball.acceleration(),
      radius: ball.radius,
    }));
    const contact = timeToContact(balls, cushions, settings.gap, horizon);
    let dt = Math.max(Math.min(horizon, contact), settings.shortest);
    if (left - dt < settings.shortest) dt = left;
    return [dt, dt === left ? end : t + dt, contact <= horizon];
  }

  function step() {
    const [dt, until, keep] = nextStep();
    const whole = record === "trajectory";
    const began = whole && motion();
    const starts = world.collidesFirst && cloth.map((ball) => ({ ...ball }));
    const parted = whole && [...began]; // the motion just after the contacts
    let changes = [];
    const given = cloth.map((ball, i) => {
      const [dx, dy] = ball.advance(dt, (kind, at) => changes.push({ kind, at, ball: i }));
      world.start(i, dx / dt, dy / dt);
      return world.read(i).slice(2);
    });
    const touching = world.step(dt);
    const state = scene.balls.map((_, i) => world.read(i));
    if (!state.flat().every(Number.isFinite)) {
      const i = state.findIndex((one) => !one.every(Number.isFinite));
      status = "failed";
      reason = `the engine put ball "${scene.balls[i].id}" at (${state[i][0]}, ${state[i][1]}) m at t = ${until} s`;
      return;
    }
    const pushing = new Map();
    const near = new Set();
    for (const [a, b, impulse] of touching) {
      const key = typeof b === "number" ? `${Math.min(a, b)} ${Math.max(a, b)}` : `${a} ${b}`;
      if (impulse > noise) pushing.set(key, [a, b]);
      else near.add(key);
    }
    contactsSolved += pushing.size;
    const collisions = [...pushing].filter(([key]) => !lasting.has(key)).map(([, pair]) => pair);
    lasting = new Set([...pushing.keys(), ...[...lasting].filter((key) => near.has(key))]);
    if (along !== 1)
      for (const [a, b] of collisions)
        if (typeof b === "string") state[a][NORMALS[b][0] === 0 ? 2 : 3] *= along;
    const centres = state.map(([x, y]) => [x, y]);
    const pushed = new Set([...pushing.values()].flat());
    cloth.forEach((ball, i) => {
      const [dvx, dvy] = [state[i][2] - given[i][0], state[i][3] - given[i][1]];
      if (!(world.damped || pushed.has(i)) || (dvx === 0 && dvy === 0)) return;
      if (!starts) return ball.kick(dvx, dvy, dt);
      // The cloth friction of half a step acts on the motion after the contacts.
      Object.assign(ball, starts[i]);
      changes = changes.filter((change) => change.ball !== i);
      ball.advance(dt / 2, (kind, at) => changes.push({ kind, at, ball: i }));
      ball.kick(dvx, dvy, dt);
      if (whole) parted[i] = { velocity: [ball.vx, ball.vy], spin: ball.spin() };
      ball.advance(dt / 2, (kind, at) => changes.push({ kind, at: dt / 2 + at, ball: i }));
    });
    const seen = world.collidesFirst ? t : until;
    const met = world.collidesFirst ? positions : centres;
    [positions, t] = [centres, until];
    // Otherwise a ball would change its direction one step late in the recorded motion.
    if (whole && collisions.length) {
      recorder.frame(seen, met, began);
      recorder.frame(seen, met, starts ? parted : motion());
    }
    collisions
      .sort(([a], [b]) => a - b)
      .forEach(([a, b]) => recorder.event(seen, typeof b === "string" ? "ball-cushion" : "ball-ball", a, b));
    changes.sort((one, other) => one.at - other.at).forEach(({ kind, ball }) => recorder.event(t, kind, ball));
    if (whole && (keep || recorder.wants(t))) recorder.frame(t, positions, motion());
  }

  const moving = () => cloth.some((ball) => !ball.rests);
  const began = performance.now();
  if (record === "trajectory") recorder.frame(0, positions, motion());
  for (; !status && moving() && t < end && steps < settings.max_steps; steps++) step();
  recorder.frame(t, positions, motion());
  const seconds = (performance.now() - began) / 1000;
  if (!status) status = !moving() ? "rest" : t === scene.t_max ? "t-max" : "step-limit";
  recorder.events.sort((one, other) => one.t - other.t);
  return {
    scene: scene.name,
    status,
    reason,
    rest_time: t,
    rest_positions: recorder.samples.positions.at(-1),
    events: recorder.events,
    samples: recorder.samples,
    settings: { ...settings, iterations: world.iterations },
    work: { steps, contacts_solved: contactsSolved },
    wall_time: seconds,
  };
}
