// p2.js: a 2D engine whose contacts are springs with a damper (SPOOK), solved within a step. Tuned, they
// are so stiff and damped that overlap pushes no ball, nothing damps or rubs, and it works in double
// precision, by its own switch P2_ARRAY_TYPE.

import { restitutionsOf } from "./play.mjs";

export function load(require, config) {
  if (config === "tuned") globalThis.P2_ARRAY_TYPE = Float64Array;
  return require("p2");
}

// Of stiffness and relaxation: so much that also in steps of 0.1 ns, where steps end at contacts, neither
// overlap nor softness changes a speed by more than rounding.
const HARD = 1e15;

export class World {
  collidesFirst = true;

  constructor(p2, scene, cushions, settings) {
    const tuned = settings.config === "tuned";
    this.damped = !tuned; // by 10 % of its velocity a second
    this.noise = tuned ? 1e-12 : 2e-6;
    this.iterations = settings.iterations ?? (tuned ? 100 : 10);
    this.world = new p2.World({ gravity: [0, 0] });
    this.world.solver.iterations = this.iterations;
    if (tuned) this.world.solver.tolerance = 1e-14;
    const [ball, cushion] = [new p2.Material(), new p2.Material()];
    const hard = tuned && { friction: 0, stiffness: HARD, relaxation: HARD };
    restitutionsOf(scene).forEach((restitution, k) =>
      this.world.addContactMaterial(new p2.ContactMaterial(ball, [ball, cushion][k], { restitution, ...hard })),
    );
    this.indices = new Map();
    this.balls = scene.balls.map(({ position, radius, mass }, i) => {
      const own = tuned && { damping: 0, angularDamping: 0, fixedRotation: true };
      const body = new p2.Body({ mass, position: position.slice(0, 2), ...own });
      return this.add(body, new p2.Circle({ radius }), ball, i);
    });
    for (const { name, normal: [nx, ny], point } of cushions)
      // A plane's normal is along y.
      this.add(new p2.Body({ position: point, angle: Math.atan2(-nx, ny) }), new p2.Plane(), cushion, name);
  }

  add(body, shape, material, index) {
    shape.material = material;
    body.addShape(shape);
    this.world.addBody(body);
    this.indices.set(body, index);
    return body;
  }

  start(i, x, y) {
    [this.balls[i].velocity[0], this.balls[i].velocity[1]] = [x, y];
  }

  step(dt) {
    this.world.step(dt);
    return this.world.narrowphase.contactEquations.map((one) => {
      const ends = [this.indices.get(one.bodyA), this.indices.get(one.bodyB)];
      return [...(typeof ends[0] === "string" ? ends.reverse() : ends), Math.abs(one.multiplier) * dt];
    });
  }

  read(i) {
    const { position, velocity } = this.balls[i];
    return [position[0], position[1], velocity[0], velocity[1]];
  }
}
