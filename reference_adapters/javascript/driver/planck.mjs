// planck.js: Box2D in JavaScript, in double precision. Tuned, its slop of 5 mm is 0.1 um, so that
// bullets meet where they touch; slow impacts aren't inelastic; and nothing damps.

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
    Object.assign(Settings, tuned ? TUNED : OWN); // they are of the process
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
    // What exact steps don't find late they find in an edge's skin: that is moved out of the way.
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
    // Of two restitutions planck takes the larger one.
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
