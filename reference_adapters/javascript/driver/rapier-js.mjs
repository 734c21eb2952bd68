// Rapier's JavaScript build in 2D, in single precision. Tuned, contacts are seen when balls overlap, not
// up to 2 cm before; see reference_adapters/rapier/engine.py.

import { restitutionsOf } from "./play.mjs";

export async function load(require) {
  const rapier = require("@dimforge/rapier2d-compat");
  await rapier.init();
  return rapier;
}

const PREDICTION = 1e-5; // gap from which on contacts are resolved, tuned [m]
const LEAST_RESTITUTION = 2 ** -52; // stands for 0, which has no inverse

export class World {
  collidesFirst = true;
  damped = false;
  noise = 16 * 2 ** -23;

  constructor(rapier, scene, cushions, settings) {
    const { ColliderDesc, RigidBodyDesc, CoefficientCombineRule } = rapier;
    const tuned = settings.config === "tuned";
    let [ball, cushion] = restitutionsOf(scene);
    if (tuned) {
      ball = Math.sqrt(Math.max(ball, LEAST_RESTITUTION)); // two are multiplied
      cushion /= ball;
    }
    this.world = new rapier.World({ x: 0, y: 0 });
    if (tuned) this.world.integrationParameters.normalizedPredictionDistance = PREDICTION;
    if (settings.iterations) this.world.numSolverIterations = settings.iterations;
    this.iterations = this.world.numSolverIterations;
    this.indices = new Map();
    const add = (shape, restitution, body, index) => {
      shape.setRestitution(restitution);
      if (tuned) shape.setFriction(0).setRestitutionCombineRule(CoefficientCombineRule.Multiply);
      const collider = this.world.createCollider(shape, body);
      this.indices.set(collider.handle, index);
      return collider;
    };
    this.balls = scene.balls.map(({ position: [x, y], radius, mass }, i) => {
      const desc = RigidBodyDesc.dynamic().setTranslation(x, y).setCanSleep(false);
      const body = this.world.createRigidBody(tuned ? desc.lockRotations() : desc);
      return { body, collider: add(ColliderDesc.ball(radius).setMass(mass), ball, body, i) };
    });
    for (const { name, normal: [x, y], point } of cushions) {
      const body = this.world.createRigidBody(RigidBodyDesc.fixed().setTranslation(...point));
      add(ColliderDesc.halfspace({ x, y }), cushion, body, name);
    }
  }

  start(i, x, y) {
    this.balls[i].body.setLinvel({ x, y }, true);
  }

  step(dt) {
    this.world.timestep = dt;
    this.world.step();
    const touching = [];
    this.balls.forEach(({ collider }, a) =>
      this.world.contactPairsWith(collider, (other) => {
        const b = this.indices.get(other.handle);
        if (typeof b === "number" && b < a) return;
        let [contacts, impulse] = [0, 0];
        this.world.contactPair(collider, other, (manifold) => {
          contacts += manifold.numContacts();
          for (let k = 0; k < manifold.numContacts(); k++) impulse += manifold.contactImpulse(k);
        });
        // A pair with a half-space lasts, wherever the ball is.
        if (contacts) touching.push([a, b, impulse]);
      }),
    );
    return touching;
  }

  read(i) {
    const { body } = this.balls[i];
    const [at, velocity] = [body.translation(), body.linvel()];
    return [at.x, at.y, velocity.x, velocity.y];
  }
}
