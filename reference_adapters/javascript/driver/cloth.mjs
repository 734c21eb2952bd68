// Cloth friction on balls between contacts, in closed form: balls slide until they roll, roll until they
// rest, and spin about the vertical. The method is that of reference_adapters/stepping/cloth.py.
//
// The cloth accelerates a sliding ball by mu_s g against the slip of its lowest point. The same force turns
// the ball, so the slip decreases by 7/2 mu_s g per second. A rolling ball decelerates by mu_r g.

export const SHORTEST = 1e-6; // slides, rolls and spins shorter than this after a contact end at once [s]
const SLOWEST = 1e-200; // speed below which a ball isn't slowed, because its direction would overflow [m/s]

const duration = (speed, deceleration) =>
  deceleration > 0 ? speed / deceleration : speed > 0 ? Infinity : 0;

class Ball {
  constructor(ball, physics) {
    const own = (key) => ball[key] ?? physics[key];
    this.radius = ball.radius;
    this.maySlide = physics.motion === "sliding";
    this.rollsBy = own("rolling_friction") * physics.gravity;
    this.slidesBy = own("sliding_friction") * physics.gravity;
    this.spinsBy = own("spinning_friction_rate");
    [this.vx, this.vy] = ball.velocity;
    this.rolls = true;
    [this.wx, this.wy, this.wz] = ball.angular_velocity ?? [-this.vy / ball.radius, this.vx / ball.radius, 0];
    if (this.maySlide && ball.angular_velocity !== null) {
      const most = Math.max(Math.hypot(this.vx, this.vy), this.radius * Math.hypot(this.wx, this.wy));
      this.rolls = Math.hypot(...this.slip()) <= 4 * Number.EPSILON * most;
    }
  }

  slip() {
    return [this.vx - this.radius * this.wy, this.vy + this.radius * this.wx];
  }

  spin() {
    return this.rolls ? [-this.vy / this.radius, this.vx / this.radius, this.wz] : [this.wx, this.wy, this.wz];
  }

  get rests() {
    return this.rolls && this.vx === 0 && this.vy === 0 && !(this.wz !== 0 && this.spinsBy > 0);
  }

  acceleration() {
    const [ux, uy] = this.rolls ? [this.vx, this.vy] : this.slip();
    const speed = Math.hypot(ux, uy);
    const by = this.rolls ? this.rollsBy : this.slidesBy;
    return speed > SLOWEST ? [(-by * ux) / speed, (-by * uy) / speed] : [0, 0];
  }

  // Return how long the ball keeps sliding or rolling, and spinning [s]: 0 means that it doesn't slide, roll
  // or spin now; Infinity means that it never stops.
  durations() {
    const motion = this.rolls
      ? duration(Math.hypot(this.vx, this.vy), this.rollsBy)
      : duration(Math.hypot(...this.slip()), 3.5 * this.slidesBy);
    return [motion, duration(Math.abs(this.wz), this.spinsBy)];
  }

  // Advance by `dt` [s] without contacts, and return the displacement [m]. `changed` is called with the kind
  // and the time of each event.
  advance(dt, changed) {
    let [dx, dy, left] = [0, 0, dt];
    while (left > 0) {
      const lasts = this.durations();
      const step = Math.min(left, ...lasts.filter((one) => one > 0));
      const [ax, ay] = this.acceleration();
      const moved = this.vx !== 0 || this.vy !== 0;
      dx += (this.vx + 0.5 * ax * step) * step;
      dy += (this.vy + 0.5 * ay * step) * step;
      this.vx += ax * step;
      this.vy += ay * step;
      if (!this.rolls) {
        this.wx += (2.5 * step * ay) / this.radius;
        this.wy -= (2.5 * step * ax) / this.radius;
      }
      if (this.wz !== 0) this.wz = lasts[1] <= step ? 0 : Math.sign(this.wz) * (Math.abs(this.wz) - this.spinsBy * step);
      left -= step;
      if (lasts[0] <= step || this.durations()[0] === 0) {
        if (!this.rolls) {
          this.rolls = true;
          changed("slide-to-roll", dt - left);
        } else if (moved) {
          this.vx = this.vy = 0;
          changed("roll-to-rest", dt - left);
        }
      }
    }
    return [dx, dy];
  }

  // Add the velocity change caused by the contacts of a step of `dt` [s].
  kick(dvx, dvy, dt) {
    const shortest = Math.max(dt, SHORTEST);
    const [wx, wy] = this.spin();
    // A ball that transfers all its speed stops; the remainder of the cancellation is rounding.
    const added = (v, dv) => (Math.abs(v + dv) <= 4 * Number.EPSILON * Math.abs(v) ? 0 : v + dv);
    this.vx = added(this.vx, dvx);
    this.vy = added(this.vy, dvy);
    if (this.maySlide) {
      [this.wx, this.wy] = [wx, wy];
      const [ux, uy] = this.slip();
      this.rolls = Math.hypot(ux, uy) <= 3.5 * shortest * this.slidesBy;
      if (this.rolls) {
        this.vx -= (2 / 7) * ux;
        this.vy -= (2 / 7) * uy;
      }
      if (Math.abs(this.wz) <= shortest * this.spinsBy) this.wz = 0;
    }
    if (this.rolls && Math.hypot(this.vx, this.vy) <= shortest * this.rollsBy) this.vx = this.vy = 0;
  }
}

export const clothOf = (scene) => scene.balls.map((ball) => new Ball(ball, scene.physics));
