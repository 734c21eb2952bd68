// The time until balls next touch, if only the cloth acts on them: with contact_steps=exact, a step ends
// there. The method is that of reference_adapters/stepping/contact_time.py, which explains it.

const RESTING_OVERLAP = 1e-7; // overlap at which a step ends for bodies in resting contact [m]
const RESTING_SPEED = 1e-3; // bodies with a slower gap that accelerates shut are in resting contact [m/s]
const LATEST = 1e300;
const MAX_ROUNDS = 100;

// Return the gap at which a step ends, smaller than the present gap [m].
function level(present, rate, acceleration, gap) {
  if (present > 2 * gap) return gap;
  const resting = Math.abs(rate) < RESTING_SPEED && acceleration < 0;
  return Math.min(present, 0) - (resting ? Math.max(RESTING_OVERLAP, gap) : gap);
}

// The smallest t > 0 with c + b t + a t^2 / 2 = 0, for c > 0.
function firstRoot(c, b, a) {
  const discriminant = b * b - 2 * a * c;
  const root = Math.sqrt(Math.max(discriminant, 0));
  if (b < 0) {
    if (discriminant >= 0 && root - b > (2 * c) / LATEST) return (2 * c) / (root - b);
  } else if (-a > (b + root) / LATEST) return (b + root) / -a;
  return Infinity;
}

function toCushion(ball, { normal, point }, gap) {
  const along = ([x, y]) => normal[0] * x + normal[1] * y;
  const present = along(ball.position) - along(point) - ball.radius;
  const [rate, acceleration] = [along(ball.velocity), along(ball.acceleration)];
  return firstRoot(present - level(present, rate, acceleration, gap), rate, acceleration);
}

function toBall(one, other, gap, farthest, horizon) {
  const [x, v, a] = ["position", "velocity", "acceleration"].map((key) => [
    other[key][0] - one[key][0],
    other[key][1] - one[key][1],
  ]);
  if (v[0] === 0 && v[1] === 0 && a[0] === 0 && a[1] === 0) return Infinity; // most pairs of a rack
  const reach = one.radius + other.radius;
  const rounding = 8 * Number.EPSILON * (farthest + reach);
  let distance = Math.hypot(...x);
  let n = [x[0] / distance, x[1] / distance];
  const on = (w) => n[0] * w[0] + n[1] * w[1];
  const target = reach + level(distance - reach, on(v), on(a), gap);
  let t = 0;
  for (let round = 0; round < MAX_ROUNDS; round++) {
    const r = [0, 1].map((k) => x[k] + (v[k] + 0.5 * a[k] * t) * t);
    distance = Math.hypot(...r);
    const remaining = distance - target;
    n = [r[0] / distance, r[1] / distance];
    const step = firstRoot(Math.max(remaining, rounding), on(v) + on(a) * t, on(a));
    if ((t > 0 && remaining <= rounding) || step <= 4e-16 * t) return t;
    t += step;
    if (!(t <= horizon)) return Infinity;
  }
  return t;
}

// Return the time until the first contact [s]; Infinity if there is none within `horizon` [s].
export function timeToContact(balls, cushions, gap, horizon) {
  let first = Infinity;
  for (const ball of balls) for (const one of cushions) first = Math.min(first, toCushion(ball, one, gap));
  const farthest = Math.max(...balls.flatMap(({ position }) => position.map(Math.abs)));
  for (let i = 0; i < balls.length; i++)
    for (let j = i + 1; j < balls.length; j++)
      first = Math.min(first, toBall(balls[i], balls[j], gap, farthest, Math.min(horizon, first)));
  return first;
}
