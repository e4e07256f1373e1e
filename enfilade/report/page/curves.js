'use strict';

// Loss, navigation error and success over training: a row of charts an agent, on common scales.

const kCurves = [
  {key: 'loss', title: 'Loss', label: 'loss', trained: true},
  {key: 'error', title: 'Navigation error', label: 'metres', level: 'nav_error'},
  {key: 'success', title: 'Success', label: 'share of episodes', level: 'success',
    format: d3.format('.0%')},
];

function curvePoints(run, split, key) {
  const points = split === 'train' ? run.train : run.evaluations[split] || [];
  return points.filter((p) => Number.isFinite(p[key])).map((p) => [p.iteration, p[key]]);
}

function curveSplits(agents) {
  const splits = new Set();
  for (const agent of agents) {
    for (const run of agent.runs) {
      if (run.train.length > 0) splits.add('train');
      for (const split of Object.keys(run.evaluations)) splits.add(split);
    }
  }
  return inOrder(splits);
}

// The mean of runs where they have the same iterations; else of none.
function meanOfRuns(lines) {
  if (lines.length === 1) return lines[0];
  const known = lines.map((line) => new Map(line));
  return lines[0].filter(([x]) => known.every((line) => line.has(x)))
    .map(([x]) => [x, d3.mean(known, (line) => line.get(x))]);
}

function curveDomains(agents, splits) {
  const iterations = [];
  const values = {loss: [], error: [], success: []};
  for (const agent of agents) {
    for (const run of agent.runs) {
      for (const split of splits) {
        for (const {key} of kCurves) {
          const points = curvePoints(run, split, key);
          iterations.push(...points.map((p) => p[0]));
          values[key].push(...points.map((p) => p[1]));
        }
      }
    }
  }
  return {
    iterations: [0, d3.max(iterations) || 1],
    loss: niceDomain(values.loss, 0), error: niceDomain(values.error, 0),
    success: niceDomain(values.success, 0, 0.1),
  };
}

function niceDomain(values, least, atLeast = 0) {
  const high = Math.max(d3.max(values) || 1, atLeast);
  return d3.scaleLinear([least, high * 1.05], [0, 1]).nice(5).domain();
}

function drawCurve(agent, splits, curve, domains, random) {
  const chart = makeChart({
    title: curve.title,
    description: `${curve.title} of ${agentName(agent.agent)} over training iterations`,
    x: {domain: domains.iterations, label: 'iterations', ticks: 4, format: d3.format('~s')},
    y: {domain: domains[curve.key], label: curve.label, format: curve.format},
  });
  const level = random && curve.level ? random[curve.level].mean : null;
  if (Number.isFinite(level) && level < domains[curve.key][1]) {
    drawLevel(chart, level, 'Random, unseen');
  }
  for (const split of splits) {
    const lines = agent.runs.map((run) => curvePoints(run, split, curve.key))
      .filter((line) => line.length > 0);
    if (lines.length === 0) continue;
    const kind = splitClass(split);
    if (lines.length > 1) {
      lines.forEach((line) => drawLine(chart, line, `one-seed ${kind}`, `${splitName(split)}, one seed`));
    }
    drawLine(chart, meanOfRuns(lines), kind, splitName(split));
  }
  return element('figure', {}, chart.svg.node());
}

function drawCurves(section, data) {
  const agents = data.curves.agents;
  const splits = curveSplits(agents);
  const domains = curveDomains(agents, splits);
  const random = (data.table.rows || [])
    .find((row) => row.agent === 'random' && row.split === 'val_unseen');
  section.append(paragraph('As in the paper’s figure: loss in training, and the validation ' +
    'splits, in buildings that were trained in (seen) and others (unseen).', 'lead'),
    legend(splits));
  for (const agent of agents) {
    const seeds = agent.runs.length > 1 ? `, mean of ${agent.runs.length} seeds (each one pale)` : '';
    const panels = element('div', {class: 'panels'});
    for (const curve of kCurves) panels.append(drawCurve(agent, splits, curve, domains, random));
    section.append(element('h3', {}, agentName(agent.agent) + seeds), panels);
  }
}
