// Ways to colour bodies. Each gives a body's colour in a frame as [r, g, b] in [0, 1], and the legend's entries.

import { Film, Flag } from './film.js';

// After Viridis (van der Walt and Smith, 2015): dark is little, bright is much, also without colour vision.
const SCALE = [[68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121],
               [110, 206, 88], [181, 222, 43], [253, 231, 37]].map((rgb) => rgb.map((value) => value / 255));

export function scaled(part) {
  const at = Math.min(Math.max(part, 0), 1) * (SCALE.length - 1), low = Math.min(Math.floor(at), SCALE.length - 2);
  return SCALE[low].map((value, i) => value + (at - low) * (SCALE[low + 1][i] - value));
}

function hue(degrees, saturation, lightness) {
  const channel = (n) => {
    const k = (n + degrees / 30) % 12, a = saturation * Math.min(lightness, 1 - lightness);
    return lightness - a * Math.max(-1, Math.min(k - 3, 9 - k, 1));
  };
  return [channel(0), channel(8), channel(4)];
}

// Neighbouring numbers get hues far apart.
const known = [];
const ofNumber = (number) =>
  (known[number] ??= hue((number * 137.508) % 360, 0.45, 0.56 + 0.09 * ((number * 7) % 3 - 1)));

const FIXED = [0.55, 0.57, 0.6], KINEMATIC = [0.45, 0.5, 0.72], AWAKE = [0.95, 0.55, 0.2], ASLEEP = [0.36, 0.45, 0.62];
const LOST = [0.85, 0.1, 0.2], SWEPT = [0.5, 0.62, 0.75], REFINED = [0.93, 0.68, 0.15], DIRECT = [0.8, 0.25, 0.5];

const FASTEST = 20, STRONGEST = 1e6;  // m/s, N: the brightest end of a scale, which is logarithmic

const css = (rgb) => `rgb(${rgb.map((value) => Math.round(255 * value)).join(' ')})`;
// From the low end to the high one; `before` stands ahead of the colours.
const ramp = (low, high) =>
  [{ before: low, text: high, wide: true, from: `linear-gradient(to right, ${SCALE.map(css).join(', ')})` }];

export const colourings = {
  body: { name: 'Body', of: (body) => ofNumber(body.number), legend: [] },
  island: {
    name: 'Island',
    of: (body) => (body.island ? ofNumber(body.island) : [0.75, 0.77, 0.8]),
    legend: [{ text: 'in no island', from: css([0.75, 0.77, 0.8]) }],
  },
  speed: {
    name: 'Speed',
    of: (body) => scaled(Math.log2(1 + 20 * body.speed) / Math.log2(1 + 20 * FASTEST)),
    legend: ramp('0', `${FASTEST} m/s and more`),
  },
  sleep: {
    name: 'Sleep',
    of: (body) => (body.flags & Flag.asleep ? ASLEEP : AWAKE),
    legend: [{ text: 'awake', from: css(AWAKE) }, { text: 'asleep', from: css(ASLEEP) }],
  },
  force: {
    name: 'Contact force',
    of: (body) => scaled(Math.log2(1 + Film.force(body.force)) / Math.log2(1 + STRONGEST)),
    legend: ramp('0', '1 MN and more'),
  },
  solver: {
    name: 'Solver',
    of: (body) => (body.flags & Flag.direct ? DIRECT : body.flags & Flag.refined ? REFINED : SWEPT),
    legend: [{ text: 'swept', from: css(SWEPT) }, { text: 'finer substeps', from: css(REFINED) },
             { text: 'solved at once', from: css(DIRECT) }],
  },
};

export function colourOf(way, body) {
  if (body.flags & Flag.quarantined) return LOST;
  if (body.type === 'static') return FIXED;
  if (body.type === 'kinematic' && way !== 'speed') return KINEMATIC;
  return colourings[way].of(body);
}
