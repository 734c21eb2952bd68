"use strict";
// Reads the bytes from `reports/page/replay_tracks.py`: event logs, and paths as parabolas.
globalThis.Ghostball ??= {};

(() => {
  const { IDENTITY, turned } = Ghostball;
  const SCHEMA = 2;
  const PHASE = {
    RESTING: 0, SLIDING: 1, ROLLING: 2, GONE: 3, FLYING: 4, UNKNOWN: 5, ABSENT: 6,
  };

  async function inflate(base64) {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    if (typeof DecompressionStream === "undefined") {
      throw new Error("this browser can't decompress the data; use one from 2023 or later");
    }
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Reads the packed bytes in order. */
  class Reader {
    constructor(bytes) {
      this.bytes = bytes;
      this.at = 0;
    }

    /** Reads an integer up to 2^53, without bit operations, because they are limited to 2^31. */
    number() {
      let value = 0;
      let weight = 1;
      for (;;) {
        const byte = this.bytes[this.at++];
        if (byte === undefined) throw new Error("the motion data are truncated");
        value += (byte % 128) * weight;
        if (byte < 128) break;
        weight *= 128;
      }
      return value % 2 ? -(value + 1) / 2 : value / 2;
    }

    numbers(count) {
      return Float64Array.from({ length: count }, () => this.number());
    }

    /** Reads integers stored as differences from the integer before. */
    sums(count) {
      let sum = 0;
      return Float64Array.from({ length: count }, () => (sum += this.number()));
    }

    raw(count) {
      const part = this.bytes.subarray(this.at, this.at + count);
      if (part.length < count) throw new Error("the motion data are truncated");
      this.at += count;
      return part;
    }

    /** Reads doubles: first all first bytes, then all second bytes, ... */
    doubles(count) {
      const planes = this.raw(8 * count);
      const view = new DataView(new ArrayBuffer(8));
      return Float64Array.from({ length: count }, (_, i) => {
        for (let k = 0; k < 8; k++) view.setUint8(k, planes[k * count + i]);
        return view.getFloat64(0, true);
      });
    }
  }

  function readEvents(reader) {
    const count = reader.number();
    return {
      count,
      t: reader.doubles(count),
      kind: reader.raw(count),
      a: reader.sums(count),
      b: reader.sums(count),
    };
  }

  /** The path of one ball: pieces between instants, each a parabola in time. */
  class Track {
    constructor(reader, times, { quantum, spin }, radius) {
      const scaled = (numbers, unit) => numbers.map((value) => value * unit);
      const points = reader.number();
      const pieces = Math.max(points - 1, 0);
      this.t = reader.sums(points).map((index) => times[index]);
      this.phase = reader.raw(pieces);
      [this.x, this.y, this.z] = [0, 1, 2].map(() => scaled(reader.sums(points), quantum));
      [this.bowX, this.bowY, this.bowZ] = [0, 1, 2].map(() => scaled(reader.numbers(pieces), quantum));
      this.more = [0, 1, 2, 3, 4, 5].map(() => scaled(reader.numbers(pieces), spin));
      this.radius = radius;
      this.turns = [IDENTITY]; // orientations at the start of each piece, computed when needed
      this.lost = Infinity;
    }

    /** Returns the piece at time t: the last that starts at or before t. */
    piece(t) {
      let low = 0;
      let high = this.phase.length - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (this.t[middle] <= t) low = middle;
        else high = middle - 1;
      }
      return low;
    }

    /** Returns [x, y, z] in metres, null if the ball is lost. After its end the motion stands still. */
    at(t) {
      const points = this.t.length;
      if (points === 0 || t >= this.lost) return null;
      const ends = [this.x, this.y, this.z];
      if (t >= this.t[points - 1]) return ends.map((end) => end[points - 1]);
      const i = this.piece(t);
      const u = Math.max((t - this.t[i]) / (this.t[i + 1] - this.t[i]), 0);
      const bow = 4 * u * (1 - u);
      const bows = [this.bowX, this.bowY, this.bowZ];
      return ends.map((end, k) => end[i] + u * (end[i + 1] - end[i]) + bow * bows[k][i]);
    }

    /** Returns the spins at both ends of a piece [rad/s]: spin of rolling plus stored difference. */
    spins(i) {
      const dt = this.t[i + 1] - this.t[i];
      return [1, -1].map((sign, end) => {
        const along = (ends, bow) => (dt > 0 ? (ends[i + 1] - ends[i] + sign * 4 * bow[i]) / dt : 0);
        const [vx, vy] = [along(this.x, this.bowX), along(this.y, this.bowY)];
        const rolling = [-vy / this.radius, vx / this.radius, 0];
        return rolling.map((w, k) => w + this.more[3 * end + k][i]);
      });
    }

    /** Returns the orientation as a quaternion [w, x, y, z]; at the start it is the identity. */
    orientation(t) {
      const pieces = this.phase.length;
      if (pieces === 0) return IDENTITY;
      const last = t >= this.t[pieces] ? pieces : this.piece(t);
      for (let i = this.turns.length - 1; i < last; i++) {
        this.turns.push(turned(this.turns[i], ...this.spins(i), this.t[i + 1] - this.t[i], 1));
      }
      if (last === pieces) return this.turns[pieces];
      const dt = this.t[last + 1] - this.t[last];
      const part = dt > 0 ? Math.max((t - this.t[last]) / dt, 0) : 0;
      return turned(this.turns[last], ...this.spins(last), dt, part);
    }

    /** Returns the phase of the motion; UNKNOWN if the engine doesn't record phases. */
    phaseAt(t) {
      if (this.t.length === 0 || t >= this.lost) return PHASE.ABSENT;
      if (this.phase.length === 0) return PHASE.UNKNOWN;
      return this.phase[this.piece(t)];
    }
  }

  /** One engine of a scene, with its motion if the engine recorded one. */
  class Engine {
    constructor(said, reader, data) {
      Object.assign(this, said);
      this.tracks = [];
      this.log = { count: 0, t: [], kind: [], a: [], b: [] };
      this.end = said.motion ? said.motion.end : 0;
      this.shown = false;
      if (!said.motion) return;
      this.log = readEvents(reader);
      const times = reader.sums(reader.number()).map((ticks) => ticks * said.motion.tick);
      this.tracks = data.balls.map(({ radius }) => new Track(reader, times, data, radius));
      for (const [ball, t] of said.motion.lost) this.tracks[ball].lost = t;
    }

    positions(t) {
      return this.tracks.map((track) => track.at(t));
    }
  }

  /** Decodes the data of a scene; counts the calls. */
  async function decode(data) {
    if (data.schema !== SCHEMA) {
      throw new Error(`the data have version ${data.schema}, but this page reads version ${SCHEMA}`);
    }
    Ghostball.decoded += 1;
    const reader = new Reader(await inflate(data.packed));
    const engines = data.engines.map((said) => new Engine(said, reader, data));
    const duration = Math.max(0, ...engines.map((engine) => engine.end));
    return { ...data, engines, duration };
  }

  /** "cue hits 3", "cue hits the left cushion", "cue lands", "3 starts to roll" ... */
  function eventWords(scene, kind, a, b) {
    const first = scene.balls[a]?.id ?? `ball ${a}`;
    const cushion = b in scene.cushions ? `the ${scene.cushions[b]} cushion` : "a cushion";
    switch (scene.kinds[kind]) {
      case "ball-ball":
        return `${first} hits ${scene.balls[b]?.id ?? `ball ${b}`}`;
      case "ball-cushion":
        return `${first} hits ${cushion}`;
      case "ball-cloth":
        return `${first} lands`;
      case "leaves-table":
        return `${first} flies off the table${b in scene.cushions ? ` over ${cushion}` : ""}`;
      case "pocketed":
        return `${first} falls into the ${scene.pockets[b]} pocket`;
      case "slide-to-roll":
        return `${first} starts to roll`;
      default:
        return `${first} comes to rest`;
    }
  }

  Ghostball.decoded = 0;
  Object.assign(Ghostball, { PHASE, decode, eventWords });
})();
