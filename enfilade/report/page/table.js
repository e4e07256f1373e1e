'use strict';

// The table of results, and success as a chart.

const kNames = {
  trajectory_length: 'Trajectory length', nav_error: 'Navigation error', success: 'Success rate',
  oracle_success: 'Oracle success rate: had it stopped at the best point of its way',
  spl: 'Success weighted by path length',
  ndtw: 'Likeness to the reference path, every entry of a trajectory',
  ndtw_collapsed: 'Likeness to the reference path, turns on the spot taken once',
  sdtw: 'The same where it succeeded, else 0, every entry',
  sdtw_collapsed: 'The same where it succeeded, else 0, turns taken once',
  cls: 'Coverage weighted by length', rgs: 'Remote grounding success: the right object was named',
  rgspl: 'The same weighted by path length',
  goal_progress: 'Goal progress: how much nearer the region is at the end',
  detection: 'Share of episodes that end with a point in the object',
  detection_spl: 'The same weighted by path length',
};

const shown = (value, column) =>
  Number.isFinite(value) ? (column.scale * value).toFixed(column.digits) : '–';

function valueCell(value, column) {
  const cell = element('td', {}, shown(value.mean, column));
  if (value.low !== value.high) {
    cell.append(element('span', {class: 'between'},
      `${shown(value.low, column)} to ${shown(value.high, column)}`));
  }
  return cell;
}

function resultRows(row, columns) {
  const runs = row.runs.length > 1 ? ` · ${row.runs.length} seeds` : '';
  const name = row.language ? `– ${row.language}, ${row.episodes.toLocaleString('en')} episodes` :
    agentName(row.agent) + runs;
  const ours = element('tr', {}, element('th', {scope: 'row'}, name));
  for (const column of columns) ours.append(valueCell(row[column.metric], column));
  if (!columns.some((column) => Number.isFinite(row[column.metric].published))) return [ours];
  const paper = element('tr', {class: 'paper'}, element('th', {scope: 'row'}, 'as published'));
  for (const column of columns) {
    paper.append(element('td', {}, shown(row[column.metric].published, column)));
  }
  return [ours, paper];
}

function resultTable(rows, columns) {
  const head = element('tr', {}, element('th', {scope: 'col'}, 'Agent'));
  for (const column of columns) {
    head.append(element('th', {scope: 'col', title: kNames[column.metric] ?? column.metric},
      column.label));
  }
  const table = element('table', {}, element('thead', {}, head));
  for (const split of inOrder(new Set(rows.map((row) => row.split)))) {
    const body = element('tbody', {class: 'split'});
    const here = rows.filter((row) => row.split === split);
    body.append(element('tr', {}, element('th', {scope: 'rowgroup', colspan: columns.length + 1},
      `${longSplitName(split)}, ${here[0].episodes.toLocaleString('en')} episodes`)));
    for (const row of here) body.append(...resultRows(row, columns));
    table.append(body);
  }
  return element('div', {class: 'scroll', tabindex: '0', role: 'region',
    'aria-label': 'Table of results'}, table);
}

// A line an agent: success with its interval, a diamond where the paper has it.
function successChart(rows, split) {
  const line = 24;
  const height = 66 + line * rows.length;
  const chart = makeChart({
    width: 360, height, title: `Success, ${splitName(split)}`,
    description: `Success rate of each agent on ${split} with 95 % intervals`,
    margin: {left: 116, right: 26},
    x: {domain: [0, 1], label: 'success rate', format: d3.format('.0%')},
    y: {domain: [rows.length, 0], label: '', ticks: 1, format: () => ''},
  });
  chart.svg.selectAll('.axis').filter((d, i) => i === 0).remove();
  rows.forEach((row, i) => {
    const y = chart.y(i + 0.5);
    const mark = chart.plot.append('g').attr('class', splitClass(split));
    mark.append('text').attr('text-anchor', 'end').attr('x', 108).attr('y', y + 4)
      .text(agentName(row.agent));
    mark.append('line').attr('class', 'interval').attr('y1', y).attr('y2', y)
      .attr('x1', chart.x(Math.max(0, row.success.low)))
      .attr('x2', chart.x(Math.min(1, row.success.high)));
    mark.append('circle').attr('class', 'dot').attr('r', 4).attr('cy', y)
      .attr('cx', chart.x(row.success.mean));
    if (Number.isFinite(row.success.published)) {
      mark.append('path').attr('class', 'published').attr('d', 'M0,-5L5,0L0,5L-5,0Z')
        .attr('transform', `translate(${chart.x(row.success.published)},${y - 9})`);
    }
    mark.append('title').text(`${agentName(row.agent)}: ${percent(row.success.mean, 1)}`);
  });
  return element('figure', {}, chart.svg.node());
}

function drawResults(section, data) {
  const rows = data.table.rows;
  if (rows.length === 0) {
    leaveOut('Results', 'No results file of this run can be scored.');
    for (const left of data.table.left_out) leaveOut('A file', `${left}.`);
    return;
  }
  for (const left of data.table.left_out) section.append(paragraph(`Left out: ${left}.`, 'note'));
  section.append(resultTable(rows, data.table.columns));
  if (data.table.scorer) {
    section.append(paragraph(
      `Scored by the formulas of "${data.table.scorer}": ${data.table.source}.`, 'note'));
  }
  for (const note of data.table.notes) section.append(paragraph(note, 'note'));
  const several = rows.some((row) => row.runs.length > 1);
  section.append(paragraph('Intervals are of 95 %: bootstrap over paths' +
    (several ? ' for one run, Student’s over seeds for several.' : '.'), 'note'));
  const published = rows.some((row) => Number.isFinite(row.success.published));
  if (published) {
    section.append(paragraph('As published (and ◇): Anderson et al., CVPR 2018, table 1.', 'note'));
  }
  for (const one of data.table.published) {
    const values = data.table.columns.filter((column) => Number.isFinite(one[column.metric]))
      .map((column) => `${column.label} ${shown(one[column.metric], column)}`);
    section.append(paragraph(
      `Published, val unseen: ${one.agent}: ${values.join(', ')} (${one.source}).`, 'note'));
  }
  const panels = element('div', {class: 'panels'});
  for (const split of inOrder(new Set(rows.map((row) => row.split)))) {
    panels.append(
      successChart(rows.filter((row) => row.split === split && !row.language), split));
  }
  section.append(panels);
}
