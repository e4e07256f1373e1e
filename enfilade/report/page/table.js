'use strict';

// The table of results, and success as a chart.

const kColumns = [
  {key: 'trajectory_length', label: 'TL', unit: 'm', scale: 1, digits: 2,
    name: 'Trajectory length'},
  {key: 'nav_error', label: 'NE', unit: 'm', scale: 1, digits: 2, name: 'Navigation error'},
  {key: 'success', label: 'SR', unit: '%', scale: 100, digits: 1, name: 'Success rate'},
  {key: 'oracle_success', label: 'OSR', unit: '%', scale: 100, digits: 1,
    name: 'Oracle success rate: had it stopped at the best point of its way'},
  {key: 'spl', label: 'SPL', unit: '%', scale: 100, digits: 1,
    name: 'Success weighted by path length'},
];

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

function resultRows(row) {
  const runs = row.runs.length > 1 ? ` · ${row.runs.length} seeds` : '';
  const ours = element('tr', {}, element('th', {scope: 'row'}, agentName(row.agent) + runs));
  for (const column of kColumns) ours.append(valueCell(row[column.key], column));
  if (!kColumns.some((column) => Number.isFinite(row[column.key].published))) return [ours];
  const paper = element('tr', {class: 'paper'}, element('th', {scope: 'row'}, 'as published'));
  for (const column of kColumns) {
    paper.append(element('td', {}, shown(row[column.key].published, column)));
  }
  return [ours, paper];
}

function resultTable(rows) {
  const head = element('tr', {}, element('th', {scope: 'col'}, 'Agent'));
  for (const column of kColumns) {
    head.append(element('th', {scope: 'col', title: column.name}, `${column.label} (${column.unit})`));
  }
  const table = element('table', {}, element('thead', {}, head));
  for (const split of inOrder(new Set(rows.map((row) => row.split)))) {
    const body = element('tbody', {class: 'split'});
    const here = rows.filter((row) => row.split === split);
    body.append(element('tr', {}, element('th', {scope: 'rowgroup', colspan: kColumns.length + 1},
      `${longSplitName(split)}, ${here[0].episodes.toLocaleString('en')} episodes`)));
    for (const row of here) body.append(...resultRows(row));
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
  for (const left of data.table.left_out) section.append(paragraph(`Left out: ${left}.`, 'note'));
  if (rows.length === 0) {
    section.append(missing('No results file of this run can be scored.'));
    return;
  }
  section.append(resultTable(rows));
  const several = rows.some((row) => row.runs.length > 1);
  section.append(paragraph('Intervals are of 95 %: bootstrap over paths' +
    (several ? ' for one run, Student’s over seeds for several.' : '.'), 'note'));
  const published = rows.some((row) => Number.isFinite(row.success.published));
  if (published) {
    section.append(paragraph('As published (and ◇): Anderson et al., CVPR 2018, table 1.', 'note'));
  }
  const panels = element('div', {class: 'panels'});
  for (const split of inOrder(new Set(rows.map((row) => row.split)))) {
    panels.append(successChart(rows.filter((row) => row.split === split), split));
  }
  section.append(panels);
}
