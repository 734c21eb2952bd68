"use strict";
// Side view of flying balls: x to the right and z up, around the selected ball.
globalThis.Ghostball ??= {};

(() => {
  const { FROM_THE_SIDE, css, drawMarker, drawStripe, lengthWords } = Ghostball;
  const HIGH = 130; // [px]
  const FLOOR = 22; // [px]: below the cloth, for its scale
  const TAIL = 1; // [s] of path behind a ball
  const CORNERS = 160; // points of the path

  class SideView {
    constructor(host, plate) {
      this.plate = plate;
      this.scene = plate.scene;
      this.host = host;
      this.canvas = document.createElement("canvas");
      this.canvas.className = "gb-side";
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", "Side view at the same time, around the selected ball");
      this.context = this.canvas.getContext("2d");
      host.append(this.canvas);
    }

    /** Fits the canvas to the page and its scale to the highest flight, and clears the canvas. */
    begin(middle) {
      const { scene, plate, canvas, context } = this;
      const largest = Math.max(...scene.balls.map((ball) => ball.radius));
      this.width = this.host.clientWidth;
      this.scale = (HIGH - FLOOR - 8) / (scene.highest + 2 * largest);
      this.middle = middle;
      const [wide, high] = [this.width, HIGH].map((size) => Math.round(size * plate.ratio));
      if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
      canvas.style.height = `${HIGH}px`;
      context.setTransform(plate.ratio, 0, 0, plate.ratio, 0, 0);
      context.fillStyle = css(plate.theme.paper);
      context.fillRect(0, 0, this.width, HIGH);
    }

    toPixels(x, z) {
      return [this.width / 2 + (x - this.middle) * this.scale, HIGH - FLOOR - z * this.scale];
    }

    /** Draws the cloth with a mark every 10 cm, and the noses of the cushions at its ends. */
    drawCloth() {
      const { context, plate, scene, width } = this;
      const { theme } = plate;
      const floor = HIGH - FLOOR;
      context.fillStyle = css(theme.cloth);
      context.fillRect(0, floor, width, FLOOR);
      context.strokeStyle = context.fillStyle = css(theme.muted);
      context.lineWidth = 1;
      context.font = "12px system-ui, sans-serif";
      context.textAlign = "center";
      context.textBaseline = "alphabetic";
      context.beginPath();
      context.moveTo(0, floor);
      context.lineTo(width, floor);
      const reach = width / (2 * this.scale);
      const first = Math.ceil(10 * (this.middle - reach));
      for (let k = first; k <= 10 * (this.middle + reach); k++) {
        const [x] = this.toPixels(k / 10, 0);
        context.moveTo(x, floor);
        context.lineTo(x, floor + 4);
        if (k % 5 === 0) context.fillText(`${k / 10} m`, x, HIGH - 4);
      }
      context.stroke();
      if (scene.table && scene.nose !== null) {
        context.strokeStyle = css(theme.cushion);
        context.lineWidth = 4;
        for (const [name, x] of [["left", 0], ["right", scene.table.length]]) {
          if (!scene.table.cushions.includes(name)) continue;
          context.beginPath();
          context.moveTo(...this.toPixels(x, 0));
          context.lineTo(...this.toPixels(x, scene.nose));
          context.stroke();
        }
      }
      context.textAlign = "left";
      context.fillStyle = css(theme.ink);
      context.fillText(`side view; up to ${lengthWords(scene.highest)} above the cloth`, 8, 14);
    }

    /** Draws the last second of a ball's path. */
    drawTrail(engine, ball, t) {
      const { context, plate } = this;
      const track = engine.tracks[ball];
      context.strokeStyle = css(plate.colourOf(engine), engine.ours ? 0.4 : 0.9);
      context.lineWidth = engine.ours ? 4 : 1.4;
      context.setLineDash(engine.dash.map((part) => 1.4 * part));
      context.beginPath();
      const since = Math.max(t - TAIL, 0);
      for (let k = 0; k <= CORNERS; k++) {
        const place = track.at(since + (k / CORNERS) * (t - since));
        if (place) context.lineTo(...this.toPixels(place[0], place[2]));
      }
      context.stroke();
      context.setLineDash([]);
    }

    /** Draws the balls, the farthest first. */
    drawBalls(engine, t, stripes) {
      const { context, plate, scene } = this;
      const colour = plate.colourOf(engine);
      const there = engine.positions(t).map((place, ball) => ({ place, ball })).filter((one) => one.place);
      for (const { place, ball } of there.sort((p, q) => q.place[1] - p.place[1])) {
        const [x, y] = this.toPixels(place[0], place[2]);
        const radius = scene.balls[ball].radius * this.scale;
        if (x < -radius || x > this.width + radius) continue;
        context.beginPath();
        context.arc(x, y, radius, 0, 2 * Math.PI);
        context.strokeStyle = context.fillStyle = css(colour);
        context.lineWidth = 1.6;
        if (engine.ours) {
          context.fillStyle = css(colour, 0.82);
          context.fill();
        } else {
          context.stroke();
          drawMarker(context, engine.marker, x, y, 4);
        }
        if (stripes) plate.drawStripeOf(context, engine, ball, t, x, y, radius, FROM_THE_SIDE);
      }
    }
  }

  Object.assign(Ghostball, { SideView });
})();
