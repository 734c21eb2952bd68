// planck.js: Box2D in JavaScript, in double precision. With config=tuned, its slop is 0.1 um instead of
// 5 mm, so bullets collide when they touch, and no impact is too slow to rebound. Nothing damps the motion.

import { restitutionsOf } from "./play.mjs";

export const load = (require) => require("planck");

const OWN = { linearSlop: 0.005, velocityThreshold: 1 };
const TUNED = { linearSlop: 1e-7, velocityThreshold: 0 };

export class World {
  collidesFirst = true;
  damped = false;
  noise = 1e-12;

  constructor({ World, Circle, Edge, Settings }, scene, cushions, settings) {
    const tuned = settings.config === "tuned";
    Object.assign(Settings, tuned ? TUNED : OWN); // global to the process
    this.iterations = settings.iterations ?? 8;
    const exact = settings.contact_steps === "exact";
    const [ball, cushion] = restitutionsOf(scene);
    const bullet = tuned && !exact && settings.bullet !== false;
    this.world = new World({ gravity: { x: 0, y: 0 }, allowSleep: false, warmStarting: !exact });
    this.balls = scene.balls.map(({ position: [x, y], radius, mass }, i) => {
      const body = this.world.createBody({ type: "dynamic", position: { x, y }, bullet, fixedRotation: tuned });
      const density = mass / (Math.PI * radius ** 2);
      body.createFixture(new Circle(radius), { density, restitution: ball, ...(tuned && { friction: 0 }) });
      body.setUserData(i);
      return body;
    });
    // An edge has a skin, in which it touches balls too early. With exact steps, it is moved back by its skin.
    const skin = exact ? 2 * TUNED.linearSlop : 0;
    for (const { name, normal: [nx, ny], point: [px, py] } of cushions) {
      const far = settings.reach + Math.hypot(scene.table.length, scene.table.width);
      const at = (along) => ({ x: px - skin * nx - along * ny, y: py - skin * ny + along * nx });
      const body = this.world.createBody({ type: "static" });
      body.createFixture(new Edge(at(-far), at(far)), { restitution: cushion, ...(tuned && { friction: 0 }) });
      body.setUserData(name);
    }
    const touching = (contact) => {
      const ends = [contact.getFixtureA(), contact.getFixtureB()].map((one) => one.getBody().getUserData());
      return typeof ends[0] === "string" ? ends.reverse() : ends;
    };
    // planck.js uses the larger of the two restitutions.
    if (tuned)
      this.world.on("pre-solve", (contact) =>
        contact.setRestitution(typeof touching(contact)[1] === "string" ? cushion : ball),
      );
    this.world.on("post-solve", (contact, { normalImpulses }) =>
      this.touched.push([...touching(contact), normalImpulses[0]]),
    );
  }

  start(i, x, y) {
    this.balls[i].setLinearVelocity({ x, y });
  }

  step(dt) {
    this.touched = [];
    this.world.step(dt, this.iterations, 3);
    return this.touched;
  }

  read(i) {
    const [at, velocity] = [this.balls[i].getPosition(), this.balls[i].getLinearVelocity()];
    return [at.x, at.y, velocity.x, velocity.y];
  }
}
