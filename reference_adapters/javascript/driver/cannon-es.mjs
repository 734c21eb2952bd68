// cannon-es: a 3D engine whose contacts are damped springs (SPOOK), solved within a step. With
// config=tuned, the springs are so stiff and damped that overlap pushes no ball, and there is neither
// friction nor damping of the motion.

import { restitutionsOf } from "./play.mjs";

export const load = (require) => require("cannon-es");

// Stiffness and relaxation of contacts: so large that neither overlap nor softness changes a speed by more
// than rounding, even in steps of 0.1 ns, which occur if steps end at contacts.
const HARD = 1e15;

export class World {
  collidesFirst = true;

  constructor({ Body, ContactMaterial, Material, Plane, Sphere, Vec3, World }, scene, cushions, settings) {
    const tuned = settings.config === "tuned";
    this.damped = !tuned; // a ball loses 1 % of its velocity per second
    this.noise = 1e-12;
    this.iterations = settings.iterations ?? (tuned ? 100 : 10);
    this.world = new World();
    this.world.solver.iterations = this.iterations;
    if (tuned) this.world.solver.tolerance = 1e-14;
    const [ball, cushion] = [new Material(), new Material()];
    const hard = tuned && { friction: 0, contactEquationStiffness: HARD, contactEquationRelaxation: HARD };
    restitutionsOf(scene).forEach((restitution, k) =>
      this.world.addContactMaterial(new ContactMaterial(ball, [ball, cushion][k], { restitution, ...hard })),
    );
    this.indices = new Map();
    this.balls = scene.balls.map(({ position: [x, y], radius, mass }, i) => {
      const own = tuned && { linearDamping: 0, fixedRotation: true };
      const body = new Body({ mass, shape: new Sphere(radius), position: new Vec3(x, y, 0), material: ball, ...own });
      return this.add(body, i);
    });
    for (const { name, normal, point } of cushions) {
      const body = new Body({ mass: 0, shape: new Plane(), position: new Vec3(...point, 0), material: cushion });
      body.quaternion.setFromVectors(new Vec3(0, 0, 1), new Vec3(...normal, 0));
      this.add(body, name);
    }
  }

  add(body, index) {
    this.world.addBody(body);
    this.indices.set(body, index);
    return body;
  }

  start(i, x, y) {
    this.balls[i].velocity.set(x, y, 0);
  }

  step(dt) {
    this.world.step(dt);
    return this.world.contacts.map((one) => {
      const ends = [this.indices.get(one.bi), this.indices.get(one.bj)];
      return [...(typeof ends[0] === "string" ? ends.reverse() : ends), Math.abs(one.multiplier) * dt];
    });
  }

  read(i) {
    const { position, velocity } = this.balls[i];
    return [position.x, position.y, velocity.x, velocity.y];
  }
}
