// The diagram of one scene by one measure, as SVG.

const svgSpace = 'http://www.w3.org/2000/svg';

function svg(name, attributes, ...children) {
  const element = document.createElementNS(svgSpace, name);
  for (const [key, value] of Object.entries(attributes || {})) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** One shape an engine, so that none needs its colour to be known. */
function markerPath(engine, r) {
  const polygon = (points) => 'M' + points.map(([x, y]) => (x * r).toFixed(2) + ' ' + (y * r).toFixed(2)).join('L') + 'Z';
  const shapes = [
    () => `M${-r} 0A${r} ${r} 0 1 1 ${r} 0A${r} ${r} 0 1 1 ${-r} 0Z`,
    () => polygon([[-.9, -.9], [.9, -.9], [.9, .9], [-.9, .9]]),
    () => polygon([[0, -1.15], [1.1, .85], [-1.1, .85]]),
    () => polygon([[0, -1.3], [1.1, 0], [0, 1.3], [-1.1, 0]]),
    () => polygon([[0, 1.15], [1.1, -.85], [-1.1, -.85]]),
    () => polygon([[-.35, -1.1], [.35, -1.1], [.35, -.35], [1.1, -.35], [1.1, .35], [.35, .35], [.35, 1.1],
      [-.35, 1.1], [-.35, .35], [-1.1, .35], [-1.1, -.35], [-.35, -.35]]),
  ];
  return shapes[engine % shapes.length]();
}

const engineColour = (engine) => `var(--engine-${engine % 6})`;

function marker(engine, radius) {
  return svg('path', {d: markerPath(engine, radius), fill: engineColour(engine)});
}

/** What a hollow mark of a run that became non-finite has in it. */
function crossOut(engine, radius) {
  const a = 0.5 * radius;
  return svg('path', {d: `M${-a} ${-a}L${a} ${a}M${-a} ${a}L${a} ${-a}`, class: 'cross',
    style: 'stroke: ' + engineColour(engine)});
}

/** Whether islands of a run of Atoll got the substeps that an error target asks for, in place of a fixed number. */
const hasTarget = (run) => (run.options.target ?? 'off') !== 'off';

const targetHole = (radius) => svg('circle', {r: 0.42 * radius, class: 'hole'});

const brokenOutcomes = ['fell', 'came_apart', 'non_finite'];

/**
 * The runs to draw, with what decides their place: "field" for error and time, "zero" for no error, "broken" for the
 * strip at the top. What was refused or has no such error has no place.
 */
function placedRuns(scene, measure, engines, noError) {
  const runs = [];
  scene.runs.forEach((run, index) => {
    if (run.same_bits) return;
    const broken = brokenOutcomes.includes(run.outcome);
    const found = run.errors[measure];
    if (!broken && (run.outcome !== 'done' || found === undefined || !run.cpu_s_per_simulated_s)) return;
    const error = Math.abs(found);
    const zone = broken ? 'broken' : error < noError ? 'zero' : 'field';
    runs.push({index, run, error, zone, time: run.cpu_s_per_simulated_s, engine: engines.indexOf(run.engine)});
  });
  return runs;
}

function layoutOf(width, runs) {
  const narrow = width < 560;
  const height = Math.round(Math.min(460, Math.max(340, width * 0.56)));
  const strip = 30;
  const hasBroken = runs.some((r) => r.zone === 'broken');
  const brokenName = runs.some((r) => r.run.outcome === 'came_apart') ? 'apart' : 'fell';
  const hasZero = runs.some((r) => r.zone === 'zero');
  const left = narrow ? 58 : 80, right = width - 14, top = narrow ? 26 : 12, bottom = height - 50;
  return {width, narrow, height, left, right, strip, hasBroken, brokenName, hasZero, top, bottom,
    fieldTop: top + (hasBroken ? strip : 0), fieldBottom: bottom - (hasZero ? strip : 0)};
}

/** Marks in the same strip that would cover each other take turns over its height. */
function placeRuns(runs, layout, x, y) {
  const untimed = runs.filter((r) => !r.time);
  for (const r of runs) {
    r.x = r.time ? x(r.time.median) : layout.right - 12 - 13 * untimed.indexOf(r);
    if (r.zone === 'field') r.y = y(r.error);
    if (r.zone === 'broken') r.y = layout.top + layout.strip / 2;
    if (r.zone === 'zero') r.y = layout.bottom - layout.strip / 2;
  }
}

function drawGrid(layout, x, y, unit) {
  const group = svg('g', {'aria-hidden': 'true'});
  const line = (x1, x2, y1, y2, major) =>
    group.append(svg('line', {x1, x2, y1, y2, class: major ? 'grid' : 'fine-grid'}));
  const text = (content, attributes) => group.append(svg('text', attributes, content));
  const verticals = ticksOf(x, 62, timeTick), horizontals = y ? ticksOf(y, 20, errorTick) : [];
  for (const major of [false, true]) {
    for (const t of verticals) {
      if (t.major === major) line(x(t.value), x(t.value), layout.top, layout.bottom, major);
    }
    for (const t of horizontals) {
      if (t.major === major) line(layout.left, layout.right, y(t.value), y(t.value), major);
    }
  }
  const bounds = {x: layout.left, width: layout.right - layout.left};
  if (layout.hasBroken) group.append(svg('rect', {...bounds, y: layout.top, height: layout.strip, class: 'strip'}));
  if (layout.hasZero) {
    group.append(svg('rect', {...bounds, y: layout.bottom - layout.strip, height: layout.strip, class: 'strip'}));
  }
  group.append(svg('rect', {...bounds, y: layout.top, height: layout.bottom - layout.top, class: 'frame'}));

  for (const t of verticals) {
    if (t.text && x(t.value) > layout.left + 8 && x(t.value) < layout.right - 8) {
      text(t.text, {x: x(t.value), y: layout.bottom + 17, 'text-anchor': 'middle', class: 'tick'});
    }
  }
  for (const t of horizontals) {
    const clear = y(t.value) > layout.fieldTop + 4 && y(t.value) < layout.fieldBottom - 4;
    if (t.text && clear) text(t.text, {x: layout.left - 7, y: y(t.value) + 4, 'text-anchor': 'end', class: 'tick'});
  }
  if (layout.hasBroken) {
    text(layout.brokenName, {x: layout.left - 7, y: layout.top + 19, 'text-anchor': 'end', class: 'strip-name'});
  }
  if (layout.hasZero) {
    text('none', {x: layout.left - 7, y: layout.bottom - 11, 'text-anchor': 'end', class: 'strip-name'});
  }
  text('CPU time per simulated second, one thread',
    {x: (layout.left + layout.right) / 2, y: layout.height - 10, 'text-anchor': 'middle', class: 'axis-title'});
  const middle = (layout.fieldTop + layout.fieldBottom) / 2;
  text('error' + (unit ? ', ' + unit : ''), layout.narrow ? {x: 4, y: 15, class: 'axis-title'} :
    {transform: `translate(13 ${middle}) rotate(-90)`, 'text-anchor': 'middle', class: 'axis-title'});
  return group;
}

/** The level and upright pieces of a front, as boxes. */
function frontPieces(places, byIndex, layout) {
  const points = places.map((index) => byIndex.get(index)).filter((point) => point);
  return points.flatMap((point, i) => {
    const above = i ? points[i - 1].y : layout.fieldTop, right = i + 1 < points.length ? points[i + 1].x : layout.right;
    return [{x: point.x - 1, y: above, w: 2, h: point.y - above}, {x: point.x, y: point.y - 1, w: right - point.x, h: 2}];
  });
}

/** The staircase over which a front has something at no more time and no more error. */
function drawFront(places, byIndex, layout, side) {
  const points = places.map((index) => byIndex.get(index)).filter((point) => point);
  if (!points.length) return '';
  let d = `M${points[0].x} ${layout.fieldTop}V${points[0].y}`;
  for (const point of points.slice(1)) d += `H${point.x}V${point.y}`;
  return svg('path', {d: d + `H${layout.right}`, class: 'front ' + side});
}

function drawSpread(r, x) {
  if (!r.time || r.time.runs < 2) return '';
  return svg('line', {x1: x(r.time.min), x2: x(r.time.max), y1: r.y, y2: r.y, class: 'spread',
    stroke: engineColour(r.engine)});
}

/** What a mark stands for, in lines: its setting first. */
function runWords(r, comparison, noError) {
  const lines = [`${r.run.engine}: ${r.run.label}`];
  if (r.zone === 'broken') lines.push(r.run.why);
  if (Number.isFinite(r.error)) lines.push(`${comparison.measure}: ${errorText(r.error, comparison.unit, noError)}`);
  if (r.time) {
    const spread = spreadText(r.time, duration);
    lines.push(`${duration(r.time.median)} per simulated s${spread ? ` (${spread})` : ''}`);
  }
  if (r.run.ms_per_step) lines.push(`${duration(r.run.ms_per_step.median / 1000)} per step of ${duration(r.run.dt)}`);
  return lines;
}

function drawPoint(r, comparison, noError) {
  const radius = r.run.default ? 6.5 : 4.2;
  const path = marker(r.engine, radius);
  const group = svg('g', {class: 'point', 'data-run': r.index,
    transform: `translate(${r.x.toFixed(1)} ${r.y.toFixed(1)})`, role: 'img',
    'aria-label': runWords(r, comparison, noError).join('; ')}, path);
  if (hasTarget(r.run)) group.append(targetHole(radius));
  if (r.zone === 'broken') {
    group.classList.add('hollow');
    path.style.stroke = engineColour(r.engine);
    if (r.run.outcome === 'non_finite') group.append(crossOut(r.engine, radius));
  }
  if (r.run.default) group.append(svg('circle', {r: radius + 4.5, class: 'ring', stroke: engineColour(r.engine)}));
  return group;
}

/**
 * Texts at the defaults, each where it covers least, of the lines of fronts above all; and at the other marks on a
 * front where one covers neither texts nor lines.
 */
function drawLabels(runs, layout, lines, onFront) {
  const group = svg('g', {'aria-hidden': 'true'});
  const placed = [];
  const named = runs.filter((r) => r.run.default).concat(runs.filter((r) => !r.run.default && onFront.has(r.index)));
  for (const r of named) {
    const text = r.run.default ? r.run.engine + ' default' : r.run.label;
    const w = (r.run.default ? 6.9 : 5.9) * text.length, h = 15;
    const boxes = [[15, -h / 2], [-15 - w, -h / 2], [-w / 2, -14 - h], [-w / 2, 14], [10, -12 - h], [10, 12],
      [-10 - w, -12 - h], [-10 - w, 12], [26, -28 - h], [-26 - w, 28], [26, 28], [-26 - w, -28 - h],
      [-w / 2, 30], [-w / 2, -30 - h], [-w / 2, 46], [-w / 2, -46 - h]]
      .map(([dx, dy]) => ({x: r.x + dx, y: r.y + dy, w, h}));
    const overlaps = (a, b) => a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;
    const cost = (box) => {
      const outside = box.x < layout.left + 2 || box.x + w > layout.right - 2 || box.y < layout.top || box.y + h > layout.bottom;
      const marks = runs.filter((o) => o !== r && overlaps(box, {x: o.x - 5, y: o.y - 5, w: 10, h: 10}));
      return (outside ? 1000 : 0) + 100 * placed.filter((other) => overlaps(box, other)).length +
        10 * lines.filter((line) => overlaps(box, line)).length +
        marks.reduce((sum, o) => sum + (o.run.default ? 20 : 1), 0);
    };
    const best = boxes.reduce((a, b) => (cost(b) < cost(a) ? b : a));
    if (!r.run.default && cost(best) >= 10) continue;
    placed.push(best);
    group.append(svg('text', {x: best.x + w / 2, y: best.y + 11.5, 'text-anchor': 'middle',
      class: r.run.default ? 'label' : 'label small', fill: engineColour(r.engine)}, text));
  }
  return group;
}

/** Draws into `holder`, which keeps its tip; returns the placed runs by rising time, for the pointer and the keys. */
function drawPlot(holder, scene, comparison, engines, noError) {
  const runs = placedRuns(scene, comparison.measure, engines, noError);
  const layout = layoutOf(Math.max(300, holder.clientWidth), runs);
  const times = runs.flatMap((r) => (r.time ? [r.time.min, r.time.max] : []));
  const errors = runs.filter((r) => r.zone === 'field').map((r) => r.error);
  const x = logScale(times, layout.left, layout.right);
  const y = errors.length ? logScale(errors, layout.fieldBottom, layout.fieldTop) : null;
  placeRuns(runs, layout, x, y);
  const byIndex = new Map(runs.map((r) => [r.index, r]));
  const byRank = [...runs].sort((a, b) => (a.run.default - b.run.default) || (b.engine - a.engine));

  const drawing = svg('svg', {viewBox: `0 0 ${layout.width} ${layout.height}`, role: 'group', tabindex: 0,
    'aria-roledescription': 'diagram',
    'aria-label': `Error against CPU time of ${runs.length} runs of ${scene.name}, by ${comparison.measure}. ` +
      `${comparison.verdict.text} The table below holds the numbers; arrow keys go through the runs.`});
  drawing.append(drawGrid(layout, x, y, comparison.unit));
  drawing.append(...byRank.map((r) => drawSpread(r, x)));
  const fronts = [comparison.peer_front, comparison.atoll_front];
  drawing.append(drawFront(comparison.peer_front, byIndex, layout, 'peers'),
    drawFront(comparison.atoll_front, byIndex, layout, 'atoll'));
  drawing.append(...byRank.map((r) => drawPoint(r, comparison, noError)));
  const pieces = fronts.flatMap((places) => frontPieces(places, byIndex, layout));
  drawing.append(drawLabels(runs, layout, pieces, new Set(fronts.flat())),
    svg('circle', {r: 11, class: 'cursor', visibility: 'hidden'}));
  holder.querySelector('svg')?.remove();
  holder.prepend(drawing);
  return runs.sort((a, b) => a.x - b.x);
}

