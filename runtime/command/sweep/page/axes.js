// Logarithmic axes.

/** Maps values to pixels between `from` and `to`, with some air around the least and the largest. */
function logScale(values, from, to) {
  let low = Math.log10(Math.min(...values));
  let high = Math.log10(Math.max(...values));
  if (!values.length) [low, high] = [-1, 0];
  const air = Math.max(0.06 * (high - low), (0.8 - (high - low)) / 2, 0.08);
  low -= air;
  high += air;
  const scale = (value) => from + (Math.log10(value) - low) / (high - low) * (to - from);
  return Object.assign(scale, {low, high, from, to});
}

/** Lines of a scale: {value, major, text}; text where there is room for it, so that labels never touch. */
function ticksOf(scale, room, textOf) {
  const pixelsPerDecade = Math.abs(scale.to - scale.from) / (scale.high - scale.low);
  const stride = Math.max(1, Math.ceil(room / pixelsPerDecade));
  const labelled = new Set([1]);
  if (pixelsPerDecade * Math.log10(2) >= room) [2, 5].forEach((digit) => labelled.add(digit));
  if (pixelsPerDecade * Math.log10(7 / 5) >= room) [3, 7].forEach((digit) => labelled.add(digit));
  const ticks = [];
  for (let exponent = Math.floor(scale.low); exponent <= scale.high; ++exponent) {
    for (let digit = 1; digit < 10; ++digit) {
      const value = digit * 10 ** exponent;
      const place = Math.log10(value);
      if (place < scale.low || place > scale.high) continue;
      if (digit > 1 && pixelsPerDecade < 25) continue;
      const hasText = labelled.has(digit) && (digit > 1 || exponent % stride === 0);
      ticks.push({value, major: digit === 1, text: hasText ? textOf(value, digit, exponent) : ''});
    }
  }
  return ticks;
}

function timeTick(value) {
  return duration(value);
}

function errorTick(value, digit, exponent) {
  if (exponent >= -2 && exponent <= 3) return figure(value);
  return (digit === 1 ? '' : digit + '×') + powerOfTen(exponent);
}

