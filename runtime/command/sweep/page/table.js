// Tables: all runs of a scene, and those that differ in time alone.

function html(name, attributes, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

function headRow(titles) {
  return html('thead', {}, html('tr', {}, ...titles.map((title) => html('th', {scope: 'col'}, title))));
}

function spreadText(samples, textOf) {
  if (!samples) return '';
  return samples.runs < 2 ? '' : textOf(samples.min) + ' to ' + textOf(samples.max);
}

const outcomeWords = {done: '', fell: 'fell', came_apart: 'came apart', non_finite: 'became non-finite', refused: 'refused', too_slow: 'too slow',
  skipped: 'not tried', failed: 'failed'};

function matchText(scene, match) {
  if (!match) return 'none';
  const other = scene.runs[match.run];
  const ratio = match.time_ratio;
  const words = ratio >= 1 ? figure(ratio) + ' times the time' : figure(1 / ratio) + ' times as fast';
  return `${other.engine}, ${other.label}: ${words}`;
}

/** Sorted by error: time compares at no more error only, and that is what the last column does. */
function runsTable(scene, comparison, noError) {
  const error = (run) => Math.abs(run.errors[comparison.measure] ?? Infinity);
  const places = scene.runs.map((_, index) => index).filter((index) => !scene.runs[index].same_bits);
  const rank = (index) => (scene.runs[index].outcome === 'done' ? error(scene.runs[index]) : Infinity);
  places.sort((a, b) => (rank(a) === rank(b) ? a - b : rank(a) - rank(b)));
  const body = html('tbody');
  for (const index of places) {
    const run = scene.runs[index];
    const time = run.cpu_s_per_simulated_s;
    const done = run.outcome === 'done';
    const known = Number.isFinite(error(run));
    const last = done ? matchText(scene, comparison.fastest_other_at_no_more_error[index])
      : run.why || outcomeWords[run.outcome];
    body.append(html('tr', run.default ? {class: 'default'} : {},
      html('td', {}, run.engine),
      html('td', {class: 'words'}, run.label + (run.options.options ? ` (${run.options.options})` : '')),
      html('td', {}, known ? errorText(error(run), comparison.unit, noError) : ''),
      html('td', {}, time ? duration(time.median) : ''),
      html('td', {}, spreadText(time, duration)),
      html('td', {class: 'words'}, last)));
  }
  return html('table', {class: 'runs'},
    headRow(['Engine', 'Setting', comparison.measure, 'CPU time per simulated s', 'least to most',
      'Fastest other engine at no more error']), body);
}

/** Threads and instruction sets: the same bits, so only the time is told. */
function sameBitsTable(scene) {
  const runs = scene.runs.filter((run) => run.ms_per_step && run.engine === 'Atoll' && (run.same_bits || run.default));
  if (runs.length < 2) return '';
  const own = runs[0].ms_per_step.median;
  const text = (ms) => duration(ms / 1000);
  const body = html('tbody');
  for (const run of runs) {
    body.append(html('tr', run.default ? {class: 'default'} : {},
      html('td', {}, run.label),
      html('td', {}, text(run.ms_per_step.median)),
      html('td', {}, spreadText(run.ms_per_step, text)),
      html('td', {}, figure(own / run.ms_per_step.median))));
  }
  return html('details', {}, html('summary', {}, 'Threads and instruction sets: the same bits, another time'),
    html('div', {class: 'scroll'}, html('table', {class: 'runs'},
      headRow(['Setting', 'wall time per step', 'least to most', 'speed against the default']), body)));
}

