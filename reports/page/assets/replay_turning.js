"use strict";
// Rotation of balls: orientations as quaternions [w, x, y, z], from spins that change linearly
// within a piece, and the stripe and spot that make the rotation visible.
globalThis.Ghostball ??= {};

(() => {
  const LONGEST_TURN = 0.5; // [rad]: largest rotation in a step if the axis changes
  const CORNERS = 48; // points of the stripe
  const IDENTITY = [1, 0, 0, 0];

  const cross = ([ax, ay, az], [bx, by, bz]) =>
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];

  function product([a, b, c, d], [e, f, g, h]) {
    return [
      a * e - b * f - c * g - d * h,
      a * f + b * e + c * h - d * g,
      a * g - b * h + c * e + d * f,
      a * h + b * g - c * f + d * e,
    ];
  }

  /** Rotates by a spin that changes linearly from `from` to `to` in a time h [s]. */
  function step(orientation, from, to, h) {
    // Magnus expansion to fourth order: the mean spin, and a correction for the changing axis.
    const twist = cross(to, from);
    const [x, y, z] = from.map((w, k) => (h * (w + to[k])) / 2 + (h * h * twist[k]) / 12);
    const angle = Math.hypot(x, y, z);
    if (angle === 0) return orientation;
    const sine = Math.sin(angle / 2) / angle;
    return product([Math.cos(angle / 2), sine * x, sine * y, sine * z], orientation);
  }

  /** Rotates through the fraction `part` of a piece of duration dt [s]. */
  function turned(orientation, from, to, dt, part) {
    const at = (u) => from.map((w, k) => w + u * (to[k] - w));
    const end = at(part);
    if (Math.hypot(...cross(from, to)) < 1e-9 * Math.hypot(...from) * Math.hypot(...to)) {
      return step(orientation, from, end, part * dt);
    }
    const most = Math.max(Math.hypot(...from), Math.hypot(...end));
    const steps = Math.max(Math.ceil((most * part * dt) / LONGEST_TURN), 1);
    let now = orientation;
    for (let k = 0; k < steps; k++) {
      now = step(now, at((k / steps) * part), at(((k + 1) / steps) * part), (part * dt) / steps);
    }
    return now;
  }

  /** Returns a direction fixed in the ball, rotated to its orientation. */
  function direction([w, x, y, z], own) {
    const axis = [x, y, z];
    const twice = cross(axis, own).map((part) => 2 * part);
    const more = cross(axis, twice);
    return own.map((part, k) => part + w * twice[k] + more[k]);
  }

  // The stripe is tilted, so it is visible from above and from the side at the start of a shot.
  const [ALONG, ACROSS, POLE] = [[0.8, -0.6, 0], [0.48, 0.64, -0.6], [0.36, 0.48, 0.8]];
  const STRIPE = Array.from({ length: CORNERS + 1 }, (_, k) => {
    const [cosine, sine] = [Math.cos, Math.sin].map((of) => of((2 * Math.PI * k) / CORNERS));
    return ALONG.map((part, axis) => cosine * part + sine * ACROSS[axis]);
  });

  /**
   * Draws the stripe around a ball, and a spot at one of its poles. `seen(direction)` returns the
   * components to the right, upwards, and towards the viewer.
   */
  function drawStripe(context, orientation, x, y, radius, seen) {
    context.beginPath();
    let pen = false;
    for (const own of STRIPE) {
      const [right, up, near] = seen(direction(orientation, own));
      if (near >= 0 && pen) context.lineTo(x + radius * right, y - radius * up);
      else if (near >= 0) context.moveTo(x + radius * right, y - radius * up);
      pen = near >= 0;
    }
    context.stroke();
    const [right, up, near] = seen(direction(orientation, POLE));
    if (near < 0) return;
    context.beginPath();
    context.arc(x + 0.9 * radius * right, y - 0.9 * radius * up, 0.13 * radius, 0, 2 * Math.PI);
    context.fill();
  }

  const FROM_ABOVE = ([x, y, z]) => [x, y, z];
  const FROM_THE_SIDE = ([x, y, z]) => [x, z, -y];

  Object.assign(Ghostball, { FROM_ABOVE, FROM_THE_SIDE, IDENTITY, drawStripe, turned });
})();
