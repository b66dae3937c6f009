// How far each engine gets where scenes grow stiffer: a table a ladder, a row an engine, a column for each substep count.

function reachText(reach, frontier) {
  if (reach.reached === null) return 'less than ' + figure(frontier.rungs[0]);
  const all = reach.reached === frontier.rungs[frontier.rungs.length - 1];
  return (all ? 'all: ' : '') + figure(reach.reached) + ` (${duration(reach.ms_per_step / 1000)})`;
}

function frontierTable(frontier) {
  const substeps = [...new Set(frontier.reaches.map((reach) => reach.substeps))];
  const engines = [...new Set(frontier.reaches.map((reach) => reach.engine))];
  const body = html('tbody');
  for (const engine of engines) {
    const cells = substeps.map((count) => {
      const reach = frontier.reaches.find((r) => r.engine === engine && r.substeps === count);
      return html('td', reach.default ? {class: 'default'} : {}, reachText(reach, frontier));
    });
    body.append(html('tr', {}, html('td', {}, engine), ...cells));
  }
  const titles = ['Engine', ...substeps.map((count) => count + (count === 1 ? ' substep' : ' substeps'))];
  return html('div', {class: 'scroll'}, html('table', {class: 'runs'}, headRow(titles), body));
}

function writeFrontiers(frontiers) {
  const section = document.getElementById('frontiers');
  section.hidden = !frontiers.length;
  for (const frontier of frontiers) {
    section.append(html('h3', {}, 'The most ' + frontier.name),
      html('p', {class: 'note'}, 'A run survives if it ' + frontier.survives.replace(/^joints/, 'ends where joints') + '. '
        + 'Rungs: ' + frontier.rungs.map(figure).join(', ') + '.'),
      frontierTable(frontier));
  }
}
