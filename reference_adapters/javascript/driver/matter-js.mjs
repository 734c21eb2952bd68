// matter.js: a 2D engine of polygons, in pixels and milliseconds. Its circles are polygons of at most 25
// sides, so a contact normal is wrong by up to half the angle of a side. Impacts slower than 2 pixels in
// 1/60 s are inelastic (Resolver._restingThresh). With config=tuned, balls have `sides` sides, no impact is
// too slow to rebound, and there is neither friction nor damping.

import { restitutionsOf } from "./play.mjs";

export const load = (require) => require("matter-js");

const [TUNED_UNITS, OWN_UNITS] = [1000, 300]; // pixels per metre; with 300, a table has 762 pixels
const THICKNESS = 1; // thickness of a cushion [m]

// Return the largest distance of a ball's polygon from the surface of the ball [m].
export const inside = ({ balls }, { sides }) =>
  Math.max(...balls.map(({ radius }) => radius * (1 - Math.cos(Math.PI / sides))));

export class World {
  collidesFirst = false;
  noise = 1e-9;

  constructor(Matter, scene, cushions, settings) {
    const { Bodies, Body, Composite, Engine, Events, Resolver } = Matter;
    const tuned = settings.config === "tuned";
    const [ball, cushion] = restitutionsOf(scene);
    this.damped = !tuned; // a ball loses 1 % of its velocity in 1/60 s
    this.units = tuned ? TUNED_UNITS : OWN_UNITS;
    Resolver._restingThresh = tuned ? 0 : 2; // global to the process
    this.matter = Matter;
    this.iterations = settings.iterations ?? 4; // of the velocity solver
    this.engine = Engine.create({ velocityIterations: this.iterations, gravity: { x: 0, y: 0, scale: 0 } });
    const own = tuned && { friction: 0, frictionStatic: 0, frictionAir: 0, inertia: Infinity };
    const units = this.units;
    this.balls = scene.balls.map(({ position: [x, y], radius, mass }, i) => {
      const more = { restitution: ball, label: i, ...own };
      const body = tuned
        ? Bodies.polygon(units * x, units * y, settings.sides, units * radius, more)
        : Bodies.circle(units * x, units * y, units * radius, more);
      Body.setMass(body, mass);
      if (tuned) Body.setInertia(body, Infinity);
      return body;
    });
    const walls = cushions.map(({ name, normal: [nx, ny], point: [px, py] }) => {
      const { length, width } = scene.table;
      const [midX, midY] = nx ? [px, width / 2] : [length / 2, py];
      const long = (nx ? width : length) + 2 * (settings.reach + THICKNESS);
      const [wide, high] = nx ? [THICKNESS, long] : [long, THICKNESS];
      const more = { isStatic: true, restitution: cushion, label: name, ...(tuned && { friction: 0 }) };
      const [x, y] = [midX - (nx * THICKNESS) / 2, midY - (ny * THICKNESS) / 2];
      return Bodies.rectangle(units * x, units * y, units * wide, units * high, more);
    });
    this.walls = new Map(cushions.map(({ name, normal }) => [name, normal]));
    Composite.add(this.engine.world, [...this.balls, ...walls]);
    const touch = ({ pairs }) => {
      for (const pair of pairs) {
        const ends = [pair.bodyA.label, pair.bodyB.label];
        this.touched.push(typeof ends[0] === "string" ? ends.reverse() : ends);
        // matter.js uses the larger of the two restitutions.
        if (tuned) pair.restitution = typeof this.touched.at(-1)[1] === "string" ? cushion : ball;
      }
    };
    Events.on(this.engine, "collisionStart", touch);
    Events.on(this.engine, "collisionActive", touch);
  }

  start(i, x, y) {
    // matter.js measures velocities in pixels per 1/60 s.
    const scale = this.units / 60;
    this.matter.Body.setVelocity(this.balls[i], { x: scale * x, y: scale * y });
  }

  step(dt) {
    this.touched = [];
    const before = this.balls.map((_, i) => this.read(i));
    this.matter.Engine.update(this.engine, 1000 * dt);
    const after = this.balls.map((_, i) => this.read(i));
    const pushed = (i, [nx, ny]) =>
      this.balls[i].mass * Math.abs((after[i][2] - before[i][2]) * nx + (after[i][3] - before[i][3]) * ny);
    return this.touched.map(([a, b]) => {
      if (typeof b === "string") return [a, b, pushed(a, this.walls.get(b))];
      const [dx, dy] = [after[b][0] - after[a][0], after[b][1] - after[a][1]];
      const normal = [dx / Math.hypot(dx, dy), dy / Math.hypot(dx, dy)];
      return [a, b, Math.min(pushed(a, normal), pushed(b, normal))];
    });
  }

  read(i) {
    const { position } = this.balls[i];
    const velocity = this.matter.Body.getVelocity(this.balls[i]);
    const scale = 60 / this.units;
    return [position.x / this.units, position.y / this.units, scale * velocity.x, scale * velocity.y];
  }
}
