'use strict';

// Histograms, and success by path length.

// Corners of a histogram's outline: [x, share].
function outline(histogram, last) {
  const corners = [[0, 0]];
  for (let bin = 0; bin < last; ++bin) {
    const share = (histogram.counts[bin] || 0) / histogram.total;
    corners.push([bin * histogram.width, share], [(bin + 1) * histogram.width, share]);
  }
  corners.push([last * histogram.width, 0]);
  return corners;
}

function drawHistogram(chart, histogram, last, split, filled) {
  const corners = outline(histogram, last);
  if (split === filled) {
    const area = d3.area().x((p) => chart.x(p[0])).y0(chart.y(0)).y1((p) => chart.y(p[1]));
    chart.plot.append('path').attr('class', `area ${splitClass(split)}`).attr('d', area(corners));
  }
  drawLine(chart, corners, splitClass(split), `${splitName(split)}, ${histogram.total} in all`);
}

// Bins after which less than a two-hundredth of any histogram lies.
function lastBin(histograms) {
  let last = 1;
  for (const histogram of histograms) {
    let beyond = histogram.total;
    for (let bin = 0; bin < histogram.counts.length && beyond > histogram.total / 200; ++bin) {
      beyond -= histogram.counts[bin];
      last = Math.max(last, bin + 1);
    }
  }
  return last;
}

const largestShare = (histograms) =>
  d3.max(histograms, (h) => d3.max(h.counts) / h.total) || 1;

const validation = (splits) => inOrder(Object.keys(splits)).filter((split) => split !== 'train');

function drawErrors(section, data) {
  const agents = data.errors.agents;
  const all = agents.flatMap((a) => validation(a.splits).map((split) => a.splits[split]));
  const last = lastBin(all);
  const splits = new Set(agents.flatMap((a) => validation(a.splits)));
  section.append(paragraph(`The distance ${data.errors.measured} from where the agent ` +
    `stopped to the goal. ${data.errors.rule}`, 'lead'), legend(splits, 'val_seen'));
  const panels = element('div', {class: 'panels'});
  for (const agent of agents) {
    const chart = makeChart({
      title: agentName(agent.agent),
      description: `Histogram of the navigation error of ${agentName(agent.agent)}`,
      x: {domain: [0, last], label: 'navigation error (m)'},
      y: {domain: [0, largestShare(all) * 1.08], label: 'share of episodes',
        format: d3.format('.0%')},
    });
    if (data.errors.radius !== null) drawMark(chart, data.errors.radius, 'success');
    for (const split of validation(agent.splits)) {
      drawHistogram(chart, agent.splits[split], last, split, 'val_seen');
    }
    panels.append(element('figure', {}, chart.svg.node()));
  }
  section.append(panels);
}

function drawShare(chart, bins, split, shift) {
  const kind = splitClass(split);
  const middle = (bin) => (bin.from + bin.to) / 2 + shift;
  drawLine(chart, bins.map((bin) => [middle(bin), bin.success]), kind, splitName(split));
  for (const bin of bins) {
    const x = chart.x(middle(bin));
    const mark = chart.plot.append('g').attr('class', kind);
    mark.append('line').attr('class', 'interval')
      .attr('x1', x).attr('x2', x).attr('y1', chart.y(bin.low)).attr('y2', chart.y(bin.high));
    mark.append('circle').attr('class', 'dot').attr('r', 3.2).attr('cx', x)
      .attr('cy', chart.y(bin.success));
    mark.append('title').text(`${splitName(split)}, ${bin.from} to ${bin.to} m: ` +
      `${percent(bin.success)} of ${bin.paths} paths`);
  }
}

function drawByLength(section, data) {
  const agents = data.byLength.agents;
  const bins = agents.flatMap((a) => validation(a.splits).flatMap((split) => a.splits[split]));
  if (bins.length === 0) {
    leaveOut('Success by path length', 'There are too few paths: fewer than 5 of each length.');
    return;
  }
  const splits = new Set(agents.flatMap((a) => validation(a.splits)));
  const domain = [d3.min(bins, (b) => b.from), d3.max(bins, (b) => b.to)];
  const high = Math.min(1, d3.max(bins, (b) => b.high) * 1.05);
  section.append(paragraph('By the length of the shortest path to the goal. Bars are Wilson’s ' +
    '95 % intervals by the number of paths; lengths with fewer than 5 paths are left out.', 'lead'),
    legend(splits));
  const panels = element('div', {class: 'panels'});
  for (const agent of agents) {
    const chart = makeChart({
      title: agentName(agent.agent),
      description: `Success of ${agentName(agent.agent)} by the length of the shortest path`,
      x: {domain, label: 'shortest path (m)'},
      y: {domain: [0, high], label: 'success', format: d3.format('.0%')},
    });
    validation(agent.splits).forEach((split, i, shown) => {
      drawShare(chart, agent.splits[split], split, 0.24 * (i - (shown.length - 1) / 2));
    });
    panels.append(element('figure', {}, chart.svg.node()));
  }
  section.append(panels);
}

function lengthChart(splits, key, title, label, unit) {
  const histograms = splits.map((split) => split[key]);
  const last = lastBin(histograms);
  const chart = makeChart({
    title,
    description: `Histogram of ${title.toLowerCase()} by split`,
    x: {domain: [0, last * histograms[0].width], label},
    y: {domain: [0, largestShare(histograms) * 1.08], label: 'share', format: d3.format('.0%')},
  });
  for (const split of splits) drawHistogram(chart, split[key], last, split.split, 'train');
  const means = splits.map((split) => `${splitName(split.split)} ` +
    `${split[`${key}Summary`].mean.toFixed(1)} ${unit}`);
  return element('figure', {}, chart.svg.node(),
    element('figcaption', {}, `Means: ${means.join(', ')}.`));
}

function drawLengths(section, data) {
  const splits = data.lengths.splits;
  const withPaths = splits.filter((split) => split.paths);
  const withWords = splits.filter((split) => split.wordsSummary);
  section.append(legend(splits.map((split) => split.split), 'train'));
  const panels = element('div', {class: 'panels'});
  if (withPaths.length > 0) {
    panels.append(lengthChart(withPaths, 'paths', 'Path lengths', 'reference path (m)', 'm'));
  }
  if (withWords.length > 0) {
    panels.append(lengthChart(withWords, 'words', 'Instruction lengths', 'words', 'words'));
  }
  section.append(panels);
}
