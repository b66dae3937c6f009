// Reads the Film that runtime/view/film.h wrote: chunks of frames, decoded as they are asked for.

const ROWS = 10, POSE_ROWS = 7, FLAGS = 7, FORCE = 8, ISLAND = 9, ESCAPE = 255;
const KEPT_BYTES = 400e6;  // of chunks that were taken apart

export const Flag = { present: 1, asleep: 2, quarantined: 4, refined: 8, direct: 16 };

export async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Lets the browser draw in between.
const pause = () => new Promise((done) => setTimeout(done, 0));

// Rounded places and turns, flags, codes of forces and islands: by frame, then body.
async function takeApart(bytes, turnUnits) {
  const header = new DataView(bytes.buffer, bytes.byteOffset);
  const frames = header.getUint32(0, true), bodies = header.getUint32(4, true), escapes = header.getUint32(8, true);
  const rowsAt = 12, escapesAt = rowsAt + ROWS * bodies * frames;
  const cells = frames * bodies;
  const chunk = {
    frames, bodies,
    place: new Int32Array(3 * cells), turn: new Int16Array(4 * cells),
    flags: new Uint8Array(cells), force: new Uint8Array(cells), island: new Uint32Array(cells),
  };
  const last = new Int32Array(POSE_ROWS * bodies), before = new Int32Array(POSE_ROWS * bodies);
  const known = new Uint8Array(bodies), flags = new Uint8Array(bodies), force = new Uint8Array(bodies);
  const island = new Int32Array(bodies);
  let escape = 0;
  const difference = (row, body, frame) => {
    const code = bytes[rowsAt + (row * bodies + body) * frames + frame];
    if (code !== ESCAPE) return (code >>> 1) ^ -(code & 1);
    return header.getInt32(escapesAt + 4 * escape++, true);
  };
  for (let frame = 0, cell = 0; frame < frames; ++frame) {
    for (let body = 0; body < bodies; ++body, ++cell) {
      flags[body] ^= bytes[rowsAt + (FLAGS * bodies + body) * frames + frame];
      chunk.flags[cell] = flags[body];
      if ((flags[body] & Flag.present) === 0) continue;
      for (let i = 0; i < POSE_ROWS; ++i) {
        const at = POSE_ROWS * body + i;
        const predicted = known[body] === 0 ? 0 : known[body] === 1 ? last[at] : (2 * last[at] - before[at]) | 0;
        const now = (predicted + difference(i, body, frame)) | 0;
        before[at] = last[at];
        last[at] = now;
        if (i < 3) chunk.place[3 * cell + i] = now;
        else chunk.turn[4 * cell + i - 3] = now;
      }
      if (known[body] < 2) ++known[body];
      force[body] += bytes[rowsAt + (FORCE * bodies + body) * frames + frame];
      chunk.force[cell] = force[body];
      island[body] = (island[body] + difference(ISLAND, body, frame)) | 0;
      chunk.island[cell] = island[body];
    }
    if (frame % 10 === 9) await pause();
  }
  if (escape !== escapes) throw new Error('a chunk of the film is damaged');
  return chunk;
}

function takeContactsApart(bytes, precision) {
  const header = new DataView(bytes.buffer, bytes.byteOffset);
  const frames = header.getUint32(0, true);
  const starts = [0];
  for (let frame = 0; frame < frames; ++frame) starts.push(starts[frame] + header.getUint32(4 + 4 * frame, true));
  const count = starts.at(-1), columnsAt = 4 + 4 * frames;
  const places = new DataView(bytes.buffer, bytes.byteOffset + columnsAt + 8 * count, 12 * count);
  const normals = new Int8Array(bytes.buffer, bytes.byteOffset + columnsAt + 20 * count, 3 * count);
  const forces = new Uint8Array(bytes.buffer, bytes.byteOffset + columnsAt + 23 * count, count);
  return {
    starts,
    place: (i) => [0, 1, 2].map((k) => places.getInt32(4 * (k * count + i), true) * precision),
    normal: (i) => [0, 1, 2].map((k) => normals[k * count + i] / 127),
    force: (i) => Film.force(forces[i]),
  };
}

export class Film {
  constructor(data) {
    this.data = data;
    this.frames = data.frames.step.length;
    this.chunks = new Map();  // promises, in the order in which they were asked for last
    this.ready = new Map();   // those that are done
  }

  get bodies() { return this.data.bodies; }
  get joints() { return this.data.joints; }
  time(frame) { return this.data.frames.time[frame]; }
  // The last frame that is not after a step.
  frameOf(step) {
    const steps = this.data.frames.step;
    let frame = 0;
    while (frame + 1 < steps.length && steps[frame + 1] <= step) ++frame;
    return frame;
  }

  chunkOf(frame) { return Math.floor(frame / this.data.chunk_frames); }

  load(number) {
    let chunk = this.chunks.get(number);
    this.chunks.delete(number);
    chunk ??= unpack(this.data.chunks[number]).then((bytes) => takeApart(bytes)).then((apart) => {
      this.ready.set(number, apart);
      return apart;
    });
    this.chunks.set(number, chunk);
    this.forget();
    return chunk;
  }
  forget() {
    const max = Math.max(3, Math.floor(KEPT_BYTES / (26 * this.data.chunk_frames * Math.max(1, this.bodies.length))));
    for (const number of this.chunks.keys()) {
      if (this.chunks.size <= max) return;
      this.chunks.delete(number);
      this.ready.delete(number);
    }
  }

  // A frame's columns, with `at`, the cell of body 0; or null while they are not there yet.
  frame(number) {
    const chunk = this.ready.get(this.chunkOf(number));
    return chunk ? { chunk, at: (number % this.data.chunk_frames) * chunk.bodies, bodies: chunk.bodies } : null;
  }
  async loadFrame(number) {
    await this.load(this.chunkOf(number));
    return this.frame(number);
  }

  isThere(frame, body) {
    return body < frame.bodies && (frame.chunk.flags[frame.at + body] & Flag.present) !== 0;
  }
  // m, and a unit quaternion x, y, z, w; null where there is no such body.
  pose(frame, body) {
    if (!this.isThere(frame, body)) return null;
    const pose = { position: [0, 0, 0], orientation: [0, 0, 0, 1] };
    this.readPose(frame, body, pose.position, pose.orientation);
    return pose;
  }
  // The same of a body that is there, into arrays: a page asks it of thousands in each frame.
  readPose(frame, body, position, orientation) {
    const cell = frame.at + body, { place, turn } = frame.chunk;
    for (let i = 0; i < 3; ++i) position[i] = place[3 * cell + i] * this.data.precision;
    let square = 0;
    for (let i = 0; i < 4; ++i) square += turn[4 * cell + i] * turn[4 * cell + i];
    const norm = Math.sqrt(square) || 1;
    for (let i = 0; i < 4; ++i) orientation[i] = turn[4 * cell + i] / norm;
  }

  // N, as its code tells it: to 3%.
  static force(code) { return 2 ** (code / 12) - 1; }

  async contacts(frame) {
    const number = this.chunkOf(frame), text = this.data.contact_chunks[number];
    if (!text) return { from: 0, to: 0 };
    if (this.contactChunk?.number !== number) {
      this.contactChunk = { number, apart: takeContactsApart(await unpack(text), this.data.precision) };
    }
    const apart = this.contactChunk.apart, within = frame % this.data.chunk_frames;
    return { ...apart, from: apart.starts[within], to: apart.starts[within + 1] };
  }
}
