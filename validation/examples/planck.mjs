// Simulate scenes from `ghostball scenes --export` with planck.js, a JavaScript engine; `ghostball
// grade` judges the results:
//
//     ghostball scenes --export scenes
//     npm install planck
//     node planck.mjs scenes/half-ball-cut.json scenes/wall-bounce.json > runs.jsonl
//     ghostball grade runs.jsonl
//
// Balls always roll, in the plane, and cushions reflect them without loss. You can use any language
// that prints the JSON object of each scene; reference_adapters/answer.py describes the object.

import { readFileSync } from "node:fs";
import { Circle, Edge, Settings, World } from "planck";

const DT = 1e-3; // [s]
const UNITS = 100; // per metre: planck's constants suit bodies of about one unit
Settings.velocityThreshold = 0; // otherwise collisions slower than 1 unit/s are inelastic

function play(scene) {
  const { physics, table, balls } = scene;
  const slowing = balls.map((ball) => (ball.rolling_friction ?? physics.rolling_friction) * physics.gravity);
  const world = new World({ gravity: { x: 0, y: 0 }, allowSleep: false });
  const bodies = balls.map((ball, i) => {
    const body = world.createBody({
      type: "dynamic",
      bullet: true,
      fixedRotation: true,
      position: { x: UNITS * ball.position[0], y: UNITS * ball.position[1] },
    });
    const radius = UNITS * ball.radius;
    const density = ball.mass / (Math.PI * radius ** 2);
    body.createFixture(new Circle(radius), { density, restitution: physics.ball_restitution, friction: 0 });
    body.setUserData({ ball: i });
    return body;
  });
  for (const name of table ? table.cushions : []) {
    const far = { left: 0, bottom: 0, right: UNITS * table.length, top: UNITS * table.width }[name];
    const upright = name === "left" || name === "right";
    const end = (along) => (upright ? { x: far, y: along } : { x: along, y: far });
    const cushion = world.createBody({ type: "static" });
    cushion.createFixture(new Edge(end(-1e4), end(1e4)), { restitution: 1, friction: 0 });
    cushion.setUserData({ cushion: name });
  }

  const fastest = Math.max(...balls.map((ball) => Math.hypot(...ball.velocity)));
  let t = 0;
  const events = [];
  const samples = { t: [], positions: [], velocities: [], angular_velocities: [] };
  let velocities = balls.map((ball) => ball.velocity.slice(0, 2));
  world.on("begin-contact", (contact) => {
    const [one, other] = [contact.getFixtureA(), contact.getFixtureB()].map((f) => f.getBody().getUserData());
    const ball = one.ball === undefined ? other : one;
    const against = ball === one ? other : one;
    const kind = against.cushion ? "ball-cushion" : "ball-ball";
    events.push({ t, kind, a: ball.ball, b: against.cushion ?? against.ball });
  });

  function sample() {
    samples.t.push(t);
    samples.positions.push(
      bodies.map((body, i) => {
        const { x, y } = body.getPosition();
        return [x / UNITS, y / UNITS, balls[i].radius];
      }),
    );
    samples.velocities.push(velocities.map(([x, y]) => [x, y, 0]));
    samples.angular_velocities.push(
      velocities.map(([x, y], i) => [-y / balls[i].radius, x / balls[i].radius, 0]),
    );
  }

  // planck has no rolling resistance: half of the deceleration is applied before each time step, half
  // after it.
  const slowed = ([x, y], i) => {
    const speed = Math.hypot(x, y);
    const factor = Math.max(0, 1 - (0.5 * slowing[i] * DT) / Math.max(speed, 1e-300));
    return [x * factor, y * factor];
  };
  const moving = () => velocities.some(([x, y]) => x !== 0 || y !== 0);
  const began = performance.now();
  sample();
  for (let step = 1; moving() && t < (scene.t_max ?? 300); step++) {
    const means = velocities.map(slowed);
    bodies.forEach((body, i) =>
      body.setLinearVelocity({ x: UNITS * means[i][0], y: UNITS * means[i][1] }),
    );
    const before = events.length;
    world.step(DT, 8, 3);
    t = step * DT;
    velocities = bodies.map((body, i) => {
      const { x, y } = body.getLinearVelocity();
      return slowed([x / UNITS, y / UNITS], i);
    });
    if (events.length > before || step % 5 === 0) sample();
  }
  sample();
  return {
    engine: "my-planck",
    settings: { dt: DT, units: UNITS },
    scene: scene.name,
    status: moving() ? "t-max" : "rest",
    rest_time: t,
    rest_positions: samples.positions.at(-1),
    events,
    samples,
    wall_time: (performance.now() - began) / 1000,
    // planck lets bullets overlap by 3 slops when they collide. An event is known to one time step.
    resolution: Math.max(0.015 / UNITS, DT * fastest),
  };
}

for (const path of process.argv.slice(2)) {
  const scene = JSON.parse(readFileSync(path, "utf8"));
  if (scene.physics.motion !== "rolling" || scene.physics.cushion !== "mirror") continue;
  console.log(JSON.stringify(play(scene)));
}
